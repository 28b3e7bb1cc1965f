"""Conversion of colours between the space of a gamut and others, against colour-science."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.colours.spaces import CIELAB, SPACES, ColourSpace
from gamutcore.colours.spaces.cielab import colour_science
from gamutcore.colours.spaces.conversion import GIVEN_SPACE, ColourConversion
from gamutcore.errors import InvalidPointsError, OptionError

LAB = np.array([(50, 20, -30), (80, -10, 60), (30, 5, 5), (100, 0, 0)], float)


@pytest.mark.parametrize("gamut", list(SPACES))
@pytest.mark.parametrize("given", GIVEN_SPACE.values)
def test_there_and_back(gamut, given):
    conversion = ColourConversion(given, ColourSpace(gamut))
    points, _ = ColourSpace(gamut).coordinates(LAB)
    back = conversion.to_gamut(conversion.from_gamut(points))
    np.testing.assert_allclose(back, points, rtol=1e-6, atol=2e-6 * abs(points).max())


@pytest.mark.parametrize("gamut", ["Oklab", "CAM16-UCS", "CIEXYZ", "CIELUV"])
def test_cielab_is_that_of_the_file_whatever_the_space(gamut):
    """A build converts the L*, a*, b* of a file in the same way."""
    space = ColourSpace(gamut)
    points, _ = space.coordinates(LAB)
    np.testing.assert_allclose(ColourConversion("lab", space).to_gamut(LAB), points, atol=1e-9)


def test_srgb_is_that_of_colour_science():
    """With Bradford from D65 to ICC's D50; the matrix of the standard is rounded to 4 digits."""
    rgb = np.array([(0.2, 0.5, 0.9), (1, 1, 1), (0.01, 0.0, 0.03)])
    colour = colour_science()
    d50 = colour.XYZ_to_xy(np.array([0.9642, 1.0, 0.8249]))
    xyz = colour.RGB_to_XYZ(
        rgb,
        "sRGB",
        illuminant=d50,
        chromatic_adaptation_transform="Bradford",
        apply_cctf_decoding=True,
    )
    expected = colour.XYZ_to_Lab(xyz, d50)
    found = ColourConversion("sRGB", CIELAB).to_gamut(rgb)
    np.testing.assert_allclose(found, expected, atol=0.05)


def test_lch_is_polar():
    lch = ColourConversion("CIE LCHab", CIELAB).from_gamut(LAB)
    hue = 360 - np.degrees(np.arctan(30 / 20))
    np.testing.assert_allclose(lch[0], (50, np.sqrt(1300), hue))


def test_a_white_that_the_gamut_states_is_that_of_the_other_space_too():
    space = ColourSpace("CIELAB", reference_white="A")
    point = ColourConversion("CIELUV", space).to_gamut(np.array([[100.0, 0.0, 0.0]]))
    np.testing.assert_allclose(point, [[100.0, 0.0, 0.0]], atol=1e-9)


def test_values_of_a_display_are_not_adapted():
    """The white of sRGB is then X, Y, Z of D65 (IEC 61966-2-1)."""
    conversion = ColourConversion("sRGB", ColourSpace("CIEXYZ"), as_measured=True)
    white = conversion.to_gamut(np.ones((1, 3)))
    np.testing.assert_allclose(white, [[0.9505, 1.0, 1.089]], atol=2e-3)


@given(st.lists(st.tuples(*[st.floats(-0.5, 1.5)] * 3), min_size=1, max_size=5))
def test_srgb_continues_beyond_its_gamut(rows):
    """The branches of IEC 61966-2-1 differ by 3e-8 where they meet: its constants are rounded."""
    conversion = ColourConversion("sRGB", CIELAB)
    rgb = np.array(rows)
    np.testing.assert_allclose(conversion.from_gamut(conversion.to_gamut(rgb)), rgb, atol=5e-8)


def test_errors_name_the_space_or_the_row():
    with pytest.raises(OptionError):
        ColourConversion("HSV", CIELAB)
    with pytest.raises(InvalidPointsError) as caught:
        ColourConversion("Oklab", CIELAB).to_gamut(np.array([(1, 0, 0), (1e150, 0, 0)]))
    assert caught.value.where["row"] == 1
