import dataclasses

import pytest

from gamutcore.errors import OptionError
from gamutcore.gamut import Options
from service.models import GamutDescription, GamutOptions, JobDescription, Level


def test_the_documented_options_are_those_of_gamutcore():
    fields = {field.name: field.default for field in dataclasses.fields(Options)}
    documented = {name: field.default for name, field in GamutOptions.model_fields.items()}
    assert documented == fields


@pytest.mark.parametrize("name", ["boundary", "cost", "intent"])
def test_every_documented_choice_is_accepted(name):
    schema = GamutOptions.model_json_schema()["properties"][name]
    for choice in schema.get("enum", [schema.get("const")]):
        assert getattr(Options.from_mapping({name: choice}), name) == choice
    with pytest.raises(OptionError):
        Options.from_mapping({name: "something else"})


def test_a_built_gamut_is_as_documented(server, gamut):
    answer = server.client.get(gamut["links"]["self"]).json()
    GamutDescription.model_validate(answer, strict=True)
    assert set(GamutDescription.model_fields) <= set(answer)
    for level in answer["levels"]:
        assert set(Level.model_fields) <= set(level)


def test_a_job_is_as_documented(server, gamut):
    answer = server.client.get(f"/v1/jobs/{gamut['id']}").json()
    JobDescription.model_validate(answer, strict=True)
    assert set(answer) == set(JobDescription.model_fields)
