"""The appearance of colours on an sRGB display, against colour-science and known values."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.colours.spaces.cielab import ICC_D50, colour_science
from gamutcore.colours.spaces.srgb import D50_TO_LINEAR_SRGB, linear_srgb, srgb

LAB = st.tuples(st.floats(0, 100), st.floats(-128, 128), st.floats(-128, 128))


def test_the_matrix_is_bradford_and_the_primaries_of_srgb():
    colour = colour_science()
    space = colour.RGB_COLOURSPACES["sRGB"]
    white = colour.xy_to_XYZ(space.whitepoint)
    matrix = colour.models.normalised_primary_matrix(space.primaries, space.whitepoint)
    adaptation = colour.adaptation.matrix_chromatic_adaptation_VonKries(
        ICC_D50, white, transform="Bradford"
    )
    np.testing.assert_allclose(
        D50_TO_LINEAR_SRGB, np.linalg.inv(matrix) @ adaptation, rtol=1e-6, atol=1e-8
    )


@pytest.mark.parametrize("convert", [linear_srgb, srgb])
class TestEnds:
    def test_white_is_one(self, convert):
        np.testing.assert_allclose(convert(np.array([(100.0, 0, 0)])), 1.0, atol=1e-6)

    def test_black_is_nought(self, convert):
        np.testing.assert_array_equal(convert(np.array([(0.0, 0, 0)])), 0.0)

    def test_what_cannot_be_shown_is_clipped(self, convert):
        beyond = np.array([(150.0, 0, 0), (-10, 0, 0), (50, 200, 0), (50, -200, 0), (90, 0, -128)])
        shown = convert(beyond)
        assert (shown >= 0).all()
        assert (shown <= 1).all()
        np.testing.assert_allclose(shown[0], 1.0, rtol=1e-15)
        np.testing.assert_array_equal(shown[1], 0.0)
        assert shown[2, 1] == 0.0
        assert shown[3, 0] == 0.0

    def test_nothing_gives_nothing(self, convert):
        assert convert(np.empty((0, 3))).shape == (0, 3)

    def test_float32_is_taken_as_it_is(self, convert):
        lab = np.array([(61.25, -12.5, 33.75)])
        np.testing.assert_array_equal(convert(lab.astype(np.float32)), convert(lab))


class TestKnownColours:
    def test_a_grey_of_half_the_lightness(self):
        """L* 50 is Y = (66/116)³ = 0.184187; encoded, 1.055 Y^(1/2.4) − 0.055 = 0.46633."""
        luminance = (66 / 116) ** 3
        grey = np.array([(50.0, 0, 0)])
        np.testing.assert_allclose(linear_srgb(grey), luminance, rtol=1e-5)
        np.testing.assert_allclose(srgb(grey), 0.46633, atol=1e-4)
        np.testing.assert_array_equal(np.rint(255 * srgb(grey)), 119)

    @pytest.mark.parametrize(
        ("lab", "rgb"),
        [
            # the primaries of sRGB in CIELAB D50 (Lindbloom's calculator, Bradford)
            ((54.2917, 80.8125, 69.8851), (1, 0, 0)),
            ((87.8181, -79.2873, 80.9902), (0, 1, 0)),
            ((29.5676, 68.2986, -112.0294), (0, 0, 1)),
        ],
    )
    def test_the_primaries(self, lab, rgb):
        np.testing.assert_allclose(linear_srgb(np.array([lab])), [rgb], atol=1e-3)


@given(st.lists(LAB, min_size=1, max_size=20))
@pytest.mark.slow
def test_all_colours_are_those_of_colour_science(displayed, lab):
    points = np.array(lab)
    np.testing.assert_allclose(linear_srgb(points), displayed(points, encoded=False), atol=2e-6)
    np.testing.assert_allclose(srgb(points), displayed(points, encoded=True), atol=5e-5)


@given(st.lists(LAB, min_size=1, max_size=10))
@pytest.mark.slow
def test_encoding_changes_no_order(lab):
    """Both transfer functions ascend from 0 to 1."""
    linear, encoded = linear_srgb(np.array(lab)), srgb(np.array(lab))
    assert (encoded >= linear - 1e-12).all()
    order = np.argsort(linear.ravel(), kind="stable")
    assert (np.diff(encoded.ravel()[order]) >= -1e-12).all()
