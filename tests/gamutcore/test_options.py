"""Options: explicit defaults, one canonical form, and refusals that name the field."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.boundary import BOUNDARIES
from gamutcore.colours import SPACE_PARAMETERS
from gamutcore.colours.spaces import SPACES
from gamutcore.decimation import COSTS
from gamutcore.errors import OptionError
from gamutcore.options import OPTIONS, Options, option_name, option_value

GAMMA = st.floats(0, 1, exclude_min=True)
METHODS = {
    "auto": {"gamma": GAMMA},
    "modified-convex-hull": {"gamma": GAMMA},
    "device-surface": {},
    "segment-maxima": {"segments": st.tuples(st.integers(2, 180), st.integers(3, 360)).map(list)},
    "usv": {
        "gamma": GAMMA,
        "basis": st.sampled_from(["tetrahedron", "octahedron", "icosahedron"]),
        "subdivisions": st.integers(0, 7),
    },
}
MEASUREMENT = {
    "observer": st.sampled_from([2, 10]),
    "illuminant": st.sampled_from(["A", "C", "D50", "D65", "E", "FL2", "FL11", "f7", "d75"]),
    "popularity": st.floats(0.001, 0.999),
    "condition": st.sampled_from(["M0", "M1", "m2", "M1, black backing"]),
}
COMMON = st.fixed_dictionaries(
    {},
    optional={
        "centre": st.one_of(
            st.just("auto"), st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=3)
        ),
        "cost": st.sampled_from(COSTS),
        "surface_samples": st.integers(8, 1_000_000),
        "intent": st.sampled_from(["relative", "absolute", "perceptual", "saturation"]),
        "space": st.just("CIELAB"),
        "source": st.sampled_from(["transforms", "measurements", "boundary"]),
        "device_model": st.sampled_from(["interpolation", "fit"]),
        "ink_limit": st.floats(0, 1500, exclude_min=True),
        "black_limit": st.floats(0, 100),
        **MEASUREMENT,
    },
)


@st.composite
def valid(draw):
    """Options of one method with those that all methods have."""
    name = draw(st.sampled_from(sorted(METHODS)))
    own = draw(st.fixed_dictionaries({}, optional=METHODS[name]))
    named = {} if name == "auto" and draw(st.booleans()) else {"boundary": name}
    return {**draw(COMMON), **own, **named}


VALID = valid()
JSON_VALUE = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=6,
)


@given(VALID)
def test_a_mapping_survives_json(mapping):
    options = Options.from_mapping(mapping)
    again = Options.from_mapping(json.loads(json.dumps(options.to_mapping())))
    assert again == options
    assert again.canonical == options.canonical
    assert hash(again) == hash(options)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *[
            ("gamma", value)
            for value in (0, -0.2, 1.01, math.nan, math.inf, "0.2", None, True, [], 10**400)
        ],
        *[("space", value) for value in ("CIEXYY", "CIE", "", None, 1, [], {})],
        *[("boundary", value) for value in ("hull", "convex-hull", None, 1, ["usv"])],
        *[("cost", value) for value in ("area", "interface", None, 2)],
        *[("intent", value) for value in ("media", None, 0)],
        *[("observer", value) for value in (1, 5, "2", None, True, [2])],
        *[("illuminant", value) for value in ("D5", "F13", "", None, 50, ["D50"])],
        *[("popularity", value) for value in (0, 1, -0.1, 1.5, float("nan"), "0.1", True, [0.1])],
        *[("condition", value) for value in ("", "  ", "x" * 81, "M\n1", None, 1, ["M1"])],
        *[
            ("segments", value) for value in ([16, 16], None, 16, "16")
        ],
        *[("source", value) for value in ("measured", 1, ["measurements"])],
        *[("ink_limit", value) for value in (0, -1, 1501, "300", True, math.nan)],
        *[("black_limit", value) for value in (-0.1, 100.5, [50])],
        *[("device_model", value) for value in ("rbf", True)],
        *[("basis", value) for value in ("icosahedron", None, 3)],
        *[("subdivisions", value) for value in (3, None, "3")],
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
    assert caught.value.message.startswith(f"{field} ")
    assert caught.value.message.endswith((", which is not accepted.", f" has no {field}."))
    assert caught.value.remedy
    assert len(caught.value.message) < 120


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({}, {"gamma": "auto", "centre": "auto"}),
        ({}, {"boundary": "auto", "gamma": "auto", "source": "transforms"}),
        ({}, {"space": "lab"}),
        ({}, {"space": "L*a*b*"}),
        ({}, {"Space": "CIE Lab", "reference_white": "D50", "adaptation": "Bradford"}),
        ({"gamma": 1}, {"gamma": 1.0}),
        ({"centre": [50, 0, 0]}, {"centre": (50.0, 0.0, -0.0)}),
        ({"boundary": "usv"}, {"boundary": "usv", "gamma": 0.05, "basis": "icosahedron"}),
        ({"boundary": "usv", "subdivisions": 4}, {"boundary": "usv"}),
        ({"boundary": "segment-maxima"}, {"boundary": "segment-maxima", "segments": (16, 16)}),
        ({"illuminant": "f11"}, {"illuminant": "FL11"}),
        ({"condition": " m1 "}, {"condition": "M1"}),
        ({"INK-LIMIT": 300}, {"ink_limit": 300.0}),
        ({"cost": "Finest"}, {"cost": "finest"}),
        ({"space": "XYZ"}, {"space": "CIEXYZ"}),
        ({"space": "cam16"}, {"space": "CAM16-UCS", "background": 20, "surround": "average"}),
        ({"space": "icTcP"}, {"space": "ICtCp", "luminance": 203}),
        (
            {"space": "OKLab", "adaptation": "bradford"},
            {"space": "Oklab", "reference_white": "D65"},
        ),
        (
            {"space": "Oklab", "reference_white": [95.5, 100, 110]},
            {"space": "Oklab", "reference_white": (0.955, 1.0, 1.1)},
        ),
    ],
)
def test_the_same_question_has_one_canonical_form(one, other):
    assert Options.from_mapping(one) == Options.from_mapping(other)
    assert Options.from_mapping(one).canonical == Options.from_mapping(other).canonical


@pytest.mark.parametrize(
    ("mapping", "field"),
    [
        # an option of other boundaries or spaces: not ignored, because the caller expects an effect
        ({"segments": [16, 16]}, "segments"),
        ({"basis": "octahedron"}, "basis"),
        ({"boundary": "segment-maxima", "gamma": 0.2}, "gamma"),
        ({"boundary": "segment-maxima", "subdivisions": 3}, "subdivisions"),
        ({"boundary": "usv", "segments": [16, 16]}, "segments"),
        ({"luminance": 100}, "luminance"),
        ({"space": "Oklab", "surround": "dim"}, "surround"),
        # values out of bounds
        ({"boundary": "segment-maxima", "segments": [1, 16]}, "segments"),
        ({"boundary": "segment-maxima", "segments": [16, 100_000]}, "segments"),
        ({"boundary": "segment-maxima", "segments": [16]}, "segments"),
        ({"boundary": "segment-maxima", "segments": None}, "segments"),
        ({"boundary": "usv", "basis": "cube"}, "basis"),
        ({"boundary": "usv", "subdivisions": 20}, "subdivisions"),
        ({"boundary": "usv", "subdivisions": 2.0}, "subdivisions"),
        ({"boundary": "usv", "gamma": 0}, "gamma"),
        ({"space": "Oklab", "reference_white": None}, "reference_white"),
        ({"space": "CAM16-UCS", "surround": "light"}, "surround"),
        ({"adaptation": "cat2000"}, "adaptation"),
        ({"cost": "finest", "Cost": "volume"}, "cost"),
    ],
)
def test_what_does_not_apply_and_what_is_out_of_bounds_is_refused(mapping, field):
    with pytest.raises(OptionError) as caught:
        Options.from_mapping(mapping)
    assert caught.value.where == {"field": field}
    assert caught.value.remedy


@pytest.mark.parametrize(
    ("mapping", "remedy"),
    [
        ({"boundary": "Convex Hull"}, '"gamma": 1'),
        ({"boundary": "convex-hull", "gamma": 1}, '"gamma": 1'),
        ({"scale": 100}, "multiply the coordinates"),
        ({"space": "Oklab", "Scale": 1}, "multiply the coordinates"),
    ],
)
def test_what_has_left_is_refused_with_what_takes_its_place(mapping, remedy):
    with pytest.raises(OptionError) as caught:
        Options.from_mapping(mapping)
    assert remedy in caught.value.remedy
    assert "Did you mean" not in caught.value.remedy


def test_near_matches_are_named():
    with pytest.raises(OptionError) as caught:
        Options.from_mapping({"ink_limits": 300})
    assert "ink_limit" in caught.value.remedy.partition("Options are")[0]
    with pytest.raises(OptionError) as caught:
        Options.from_mapping({"space": "CIELABB"})
    assert caught.value.remedy.endswith("Did you mean 'CIELAB'?")


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ({"ink_limit": "300"}, {"ink_limit": 300}),
        ({"boundary": "usv", "subdivisions": "3"}, {"boundary": "usv", "subdivisions": 3}),
        ({"centre": "[50, 1, 2]"}, {"centre": [50, 1, 2]}),
        ({"centre": "50,1,2"}, {"centre": [50, 1, 2]}),
        ({"centre": " 50, 1, -2e0"}, {"centre": [50, 1, -2]}),
        ({"centre": "50 1 2"}, {"centre": [50, 1, 2]}),
        (
            {"boundary": "segment-maxima", "segments": "30,60"},
            {"boundary": "segment-maxima", "segments": [30, 60]},
        ),
        ({"centre": "auto"}, {}),
        ({"observer": "10"}, {"observer": 10}),
        ({"condition": "M1"}, {"condition": "M1"}),
        ({"Cost": "finest"}, {"cost": "finest"}),
    ],
)
def test_options_from_text(text, same):
    values = {name: option_value(option_name(name), given) for name, given in text.items()}
    assert Options.from_mapping(values) == Options.from_mapping(same)


@pytest.mark.parametrize(
    "text", [{"ink_limit": "much"}, {"centre": "[1"}, {"centre": "50,0"}, {"gamma": "null"}]
)
def test_text_without_a_valid_value_is_refused(text):
    with pytest.raises(OptionError) as caught:
        Options.from_mapping({name: option_value(name, given) for name, given in text.items()})
    assert caught.value.where == {"field": next(iter(text))}


class TestDeclarations:
    def test_declared_defaults_are_those_of_the_options(self):
        for boundary in BOUNDARIES:
            for space in SPACES:
                given = Options(boundary=boundary, space=space).to_mapping()
                for name, declared in OPTIONS.items():
                    selected = {"boundary": boundary, "space": space}.get(declared.selector)
                    default = declared.defaults.get(selected, declared.default)
                    default = list(default) if isinstance(default, tuple) else default
                    if name in {"space", "boundary"}:
                        continue
                    if name in given:
                        assert given[name] == default
                    else:
                        assert default is None or space == "CIELAB"


@pytest.mark.parametrize("name", ["", "triangles", "__class__", "x" * 500, "self"])
def test_an_unknown_name(name):
    with pytest.raises(OptionError) as caught:
        Options.from_mapping({name: 1})
    assert caught.value.where == {"field": name[:40]}
    assert "gamma" in caught.value.remedy
    assert len(caught.value.message) < 120


@given(
    st.dictionaries(
        st.sampled_from(list(OPTIONS)) | st.text(max_size=8),
        JSON_VALUE,
        max_size=3,
    )
)
@pytest.mark.slow
def test_any_json_is_options_or_a_named_error(mapping):
    try:
        options = Options.from_mapping(mapping)
    except OptionError as error:
        field = error.where["field"]
    else:
        field = None
        json.dumps(options.to_mapping(), allow_nan=False)
    assert field is None or field in {
        name.strip().lower().replace("-", "_") for name in mapping
    } | set(mapping)


@given(st.sampled_from(sorted(SPACES)), VALID)
@pytest.mark.slow
def test_a_space_and_its_parameters_survive_json(name, mapping):
    options = Options.from_mapping({**mapping, "space": name})
    again = Options.from_mapping(json.loads(json.dumps(options.to_mapping())))
    assert again == options
    assert again.canonical == options.canonical
    assert again.colour_space() == options.colour_space()
    own = set(SPACE_PARAMETERS) & set(options.to_mapping())
    common = set() if name == "CIELAB" else {"reference_white", "adaptation"}
    assert own == common | set(SPACES[name].parameters)


def test_a_measured_luminance_is_the_datas_or_refused():
    options = Options(space="ITP", luminance="measured")
    assert options.to_mapping()["luminance"] == "measured"
    assert options.colour_space(484.8).luminance == 484.8
    for stated in (None, 0.0, 20_000.0, float("nan"), "100"):
        with pytest.raises(OptionError) as caught:
            options.colour_space(stated)
        assert caught.value.where == {"field": "luminance"}
        assert caught.value.remedy
