"""Parameters of spaces: explicit defaults, one canonical form, refusals."""

import contextlib
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.colours.spaces import SPACES, ColourSpace
from gamutcore.colours.spaces.parameters import SPACE_PARAMETERS, space_parameters
from gamutcore.colours.spaces.white_points import ADAPTATIONS
from gamutcore.errors import OptionError

ABSOLUTE = {"ICtCp", "ITP", "Jzazbz"}
APPEARANCE = {"CAM16-UCS", "CAM02-UCS"}


def test_cielab_has_none_by_default():
    assert space_parameters("CIELAB", {}) == dict.fromkeys(SPACE_PARAMETERS)
    same = {"reference_white": "D50", "adaptation": "Bradford", "scale": 1}
    assert space_parameters("CIELAB", same) == dict.fromkeys(SPACE_PARAMETERS)


@pytest.mark.parametrize("name", sorted(set(SPACES) - {"CIELAB"}))
def test_defaults_are_made_explicit(name):
    checked = {k: v for k, v in space_parameters(name, {}).items() if v is not None}
    own = {"luminance"} if name in ABSOLUTE else set()
    own |= {"adapting_luminance", "background", "surround"} if name in APPEARANCE else set()
    assert set(checked) == {"reference_white", "adaptation", "scale"} | own
    assert checked["adaptation"] == "Bradford"
    assert checked["scale"] == 1.0
    assert ColourSpace(name, **checked).description() == ColourSpace(name).description()


def test_a_white_is_kept_with_y_of_one():
    given = space_parameters("Oklab", {"reference_white": [95, 100, 110]})
    assert given["reference_white"] == pytest.approx((0.95, 1.0, 1.10))
    again = space_parameters("Oklab", {"reference_white": list(given["reference_white"])})
    assert again == given


@pytest.mark.parametrize(
    ("space", "name", "value"),
    [
        *[("CIELAB", name, 10.0) for name in ("luminance", "adapting_luminance", "background")],
        ("Oklab", "luminance", 100),
        ("CAM16-UCS", "luminance", 100),
        ("ICtCp", "surround", "average"),
        ("ICtCp", "luminance", 0),
        ("ICtCp", "luminance", 10_001),
        ("ICtCp", "luminance", "100"),
        ("ICtCp", "luminance", True),
        ("ICtCp", "luminance", float("nan")),
        ("ICtCp", "luminance", 10**400),
        ("CAM16-UCS", "adapting_luminance", 0),
        ("CAM16-UCS", "background", 0),
        ("CAM16-UCS", "background", 101),
        ("CAM16-UCS", "surround", "bright"),
        ("CAM16-UCS", "surround", ["dim"]),
        *[
            ("CIELAB", "reference_white", value)
            for value in (
                "D51", "D5 0 0", "", 50, [1, 1], [1, 0, 1], [0, 1, 1], [1, 1, -1], [1, 1, "1"],
                [1, 1, float("inf")], [1e300, 1e-300, 1], {"X": 1}, True, [9, 1, 1],
                    [3, 1, 0.2], [0.2, 1, 3],
            )
        ],
        *[("CIELAB", "adaptation", value) for value in ("brad", "", 1, ["CAT02"])],
        *[("CIELAB", "scale", value) for value in (0, -1, 1e7, "1", float("inf"), True)],
    ],
)  # fmt: skip
def test_what_is_not_accepted_is_named(space, name, value):
    with pytest.raises(OptionError) as caught:
        space_parameters(space, {name: value})
    assert caught.value.where == {"field": name}
    assert caught.value.remedy


@given(
    st.sampled_from(sorted(SPACES)),
    st.tuples(st.floats(0.05, 6), st.just(1.0), st.floats(0.05, 6)),
    st.sampled_from(sorted(ADAPTATIONS)),
    st.sampled_from([1e-4, 1.0, 1e6]),
    st.sampled_from([0.0, 1.0]),
)
def test_every_space_works_with_all_that_is_accepted(name, white, adaptation, scale, end):
    own = {"luminance": (0.1, 1e4), "adapting_luminance": (0.01, 1e4), "background": (1.0, 100.0)}
    extremes = {key: own[key][int(end)] for key in own if key in SPACES[name].parameters}
    asked = {"reference_white": white, "adaptation": adaptation, "scale": scale, **extremes}
    with contextlib.suppress(OptionError):
        space = ColourSpace(name, **space_parameters(name, asked))
        json.dumps(space.description(), allow_nan=False)
        lab = np.array([(0, 0, 0), (50, 60, -20), (100, 0, 0), (80, -80, 80.0)])
        coordinates, _ = space.coordinates(lab)
        assert np.isfinite(coordinates).all()
        assert np.isfinite(space.appearance_lab(coordinates)).all()
