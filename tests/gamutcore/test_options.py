"""Options: defaults made explicit, one canonical form, and every refusal names its field."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.decimation import COSTS
from gamutcore.errors import OptionError
from gamutcore.options import Options

VALID = st.fixed_dictionaries(
    {},
    optional={
        "boundary": st.sampled_from(["modified-convex-hull", "convex-hull"]),
        "gamma": st.floats(0, 1, exclude_min=True),
        "centre": st.one_of(
            st.just("auto"), st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=3)
        ),
        "cost": st.sampled_from(COSTS),
        "surface_samples": st.integers(8, 1_000_000),
        "intent": st.sampled_from(["relative", "absolute", "perceptual", "saturation"]),
        "space": st.just("CIELAB"),
    },
)
JSON_VALUE = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=6,
)


def test_the_defaults_are_those_of_the_design():
    assert Options().to_mapping() == {
        "space": "CIELAB",
        "boundary": "modified-convex-hull",
        "gamma": 0.2,
        "centre": "auto",
        "cost": "volume",
        "surface_samples": 100_000,
        "intent": "relative",
    }


@given(VALID)
def test_a_mapping_survives_json(mapping):
    options = Options.from_mapping(mapping)
    again = Options.from_mapping(json.loads(json.dumps(options.to_mapping())))
    assert again == options
    assert again.canonical == options.canonical
    assert hash(again) == hash(options)


@given(VALID)
def test_the_canonical_form_has_every_option_sorted_and_no_space(mapping):
    canonical = Options.from_mapping(mapping).canonical
    parsed = json.loads(canonical)
    assert list(parsed) == sorted(Options().to_mapping())
    assert canonical == json.dumps(parsed, sort_keys=True, separators=(",", ":"))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({}, {"gamma": 0.2, "centre": "auto"}),
        ({"gamma": 1}, {"gamma": 1.0}),
        ({"centre": [50, 0, 0]}, {"centre": (50.0, 0.0, -0.0)}),
        ({"boundary": "convex-hull", "gamma": 0.3}, {"boundary": "convex-hull"}),
    ],
)
def test_equal_options_have_one_canonical_form(one, other):
    assert Options.from_mapping(one) == Options.from_mapping(other)
    assert Options.from_mapping(one).canonical == Options.from_mapping(other).canonical


def test_the_convex_hull_says_that_its_gamma_is_one():
    assert Options(boundary="convex-hull", gamma=0.2).gamma == 1.0


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *[
            ("gamma", value)
            for value in (0, -0.2, 1.01, math.nan, math.inf, "0.2", None, True, [], 10**400)
        ],
        *[("space", value) for value in ("CIEXYZ", "cielab", "", None, 1, [], {})],
        *[("boundary", value) for value in ("hull", None, 1, ["convex-hull"])],
        *[("cost", value) for value in ("area", "interface", None, 2)],
        *[("intent", value) for value in ("media", None, 0)],
        *[
            ("surface_samples", value)
            for value in (7, 0, -1, 1e5, "100", None, True, 10**9, math.nan)
        ],
        *[
            ("centre", value)
            for value in (
                "middle", None, 50, [50, 0], [50, 0, 0, 0], [50, 0, "0"], [50, 0, math.nan],
                [math.inf, 0, 0], [True, 0, 0], {"L": 50}, [10**400, 0, 0], "123",
            )
        ],
    ],
)  # fmt: skip
def test_a_value_that_is_not_accepted(field, value):
    with pytest.raises(OptionError) as caught:
        Options.from_mapping({field: value})
    assert caught.value.where == {"field": field}
    assert caught.value.message.startswith(f"{field} is ")
    assert caught.value.remedy
    assert len(caught.value.message) < 120


@pytest.mark.parametrize("name", ["Gamma", "", "triangles", "__class__", "x" * 500, "self"])
def test_an_unknown_name(name):
    with pytest.raises(OptionError) as caught:
        Options.from_mapping({name: 1})
    assert caught.value.where == {"field": name[:40]}
    assert "gamma" in caught.value.remedy
    assert len(caught.value.message) < 120


@given(
    st.dictionaries(
        st.sampled_from(sorted(Options().to_mapping())) | st.text(max_size=8),
        JSON_VALUE,
        max_size=3,
    )
)
def test_any_json_is_options_or_a_named_error(mapping):
    try:
        options = Options.from_mapping(mapping)
    except OptionError as error:
        field = error.where["field"]
    else:
        field = None
        json.dumps(options.to_mapping(), allow_nan=False)
    assert field is None or field in mapping


def test_options_cannot_be_changed():
    with pytest.raises(AttributeError):
        Options().gamma = 0.5
