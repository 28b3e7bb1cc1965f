import dataclasses
import json

import pytest

from gamutcore import Options
from gamutcore.boundary import BOUNDARIES
from gamutcore.errors import OptionError
from gamutcore.options import OPTIONS
from service.openapi.request_models import GamutOptions


def test_the_documented_options_are_those_of_gamutcore():
    fields = {field.name: field.default for field in dataclasses.fields(Options)}
    documented = {name: field.default for name, field in GamutOptions.model_fields.items()}
    assert documented == fields


def edges(schema):
    """Return values at the limits that a schema states, and values just beyond them."""
    if "anyOf" in schema:
        parts = [edges(part) for part in schema["anyOf"]]
        return [value for within, _ in parts for value in within], parts[-1][1]
    if "enum" in schema:
        return schema["enum"], ["something else"]
    if "prefixItems" in schema:
        (one, no_one), (two, no_two) = (edges(item) for item in schema["prefixItems"])
        wrong = [*([value, two[0]] for value in no_one), *([one[0], value] for value in no_two)]
        return [list(pair) for pair in zip(one, two, strict=True)], wrong
    if schema["type"] == "integer":
        least, most = schema["minimum"], schema["maximum"]
        return [least, most], [least - 1, most + 1]
    return [schema["exclusiveMinimum"] + 1e-9, schema["maximum"]], [
        schema["exclusiveMinimum"],
        schema["maximum"] + 1e-9,
    ]


@pytest.mark.parametrize("boundary", sorted(set(BOUNDARIES) - {"convex-hull"}))
def test_the_documented_limits_are_those_of_gamutcore(boundary):
    for name in BOUNDARIES[boundary].defaults:
        within, beyond = edges(GamutOptions.model_json_schema()["properties"][name])
        for value in within:
            given = Options.from_mapping({"boundary": boundary, name: value}).to_mapping()
            assert given[name] == value
            GamutOptions.model_validate_json(json.dumps(given), strict=True)
        for value in beyond:
            with pytest.raises(OptionError):
                Options.from_mapping({"boundary": boundary, name: value})


@pytest.mark.parametrize("name", ["surface_samples", "scale", "adapting_luminance", "background"])
def test_documented_numbers_are_bounded(name):
    """Values at the bounds are accepted, values beyond them are refused."""
    schema = GamutOptions.model_json_schema()["properties"][name]
    space = {"space": "CAM16-UCS"}
    for value in (schema["minimum"], schema["maximum"]):
        given = Options.from_mapping({**space, name: value}).to_mapping()
        assert given[name] == value
        GamutOptions.model_validate_json(json.dumps(given), strict=True)
    for value in (schema["minimum"] * 0.5, schema["maximum"] * 2):
        with pytest.raises(OptionError):
            Options.from_mapping({**space, name: value})


def test_a_default_that_depends_on_another_option_is_described():
    properties = GamutOptions.model_json_schema()["properties"]
    for name, option in OPTIONS.items():
        assert ("default" in properties[name]) == (option.default is not None)
        assert all(f"{user}" in properties[name]["description"] for user in option.defaults) or (
            option.is_universal
        )


@pytest.mark.parametrize("name", ["adaptation", "surround", "reference_white"])
def test_every_documented_choice_of_spaces_is_accepted(name):
    schema = GamutOptions.model_json_schema()["properties"][name]
    choices = schema.get("enum") or schema["anyOf"][0]["enum"]
    for choice in choices:
        assert getattr(Options.from_mapping({"space": "CAM16-UCS", name: choice}), name) == choice


@pytest.mark.parametrize("name", ["space", "boundary", "cost", "intent"])
def test_every_documented_choice_is_accepted(name):
    schema = GamutOptions.model_json_schema()["properties"][name]
    for choice in schema.get("enum", [schema.get("const")]):
        assert getattr(Options.from_mapping({name: choice}), name) == choice
    with pytest.raises(OptionError):
        Options.from_mapping({name: "something else"})
