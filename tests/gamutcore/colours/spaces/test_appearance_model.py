"""CIECAM02 and CAM16 against the worked examples of their publications."""

import numpy as np
import pytest

from gamutcore.colours.spaces.appearance_model import SURROUNDS, AppearanceModel
from gamutcore.colours.spaces.cielab import colour_science

SRGB_TO_XYZ = np.array(
    [
        (0.41233895, 0.35762064, 0.18051042),
        (0.2126, 0.7152, 0.0722),
        (0.01932141, 0.11916382, 0.95034478),
    ]
)
D65 = np.array([95.047, 100.0, 108.883])


def correlates(model, xyz):
    lightness, colourfulness, hue, outside = model.correlates(np.array([xyz]))
    assert not outside.any()
    return lightness[0], colourfulness[0], np.rad2deg(hue[0]) % 360


@pytest.mark.parametrize(
    ("luminance", "expected"),
    [(200.0, (48.0314, 38.7789, 191.0452)), (20.0, (47.6856, 29.7580, 185.3445))],
)
def test_the_worked_examples_of_cie_159(luminance, expected):
    """CIE 159:2004, clause 9, whose white has Y 90 and whose background Y 18."""
    model = AppearanceModel("CIECAM02", np.array([98.88, 90.0, 32.03]), luminance, 18.0, "average")
    assert correlates(model, (19.31, 23.93, 10.14)) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(
    ("xyz", "white", "luminance", "expected"),
    [
        ((19.01, 20.00, 21.78), (95.05, 100.0, 108.88), 318.31, (41.73, 0.11, 219.0)),
        ((57.06, 43.06, 31.96), (95.05, 100.0, 108.88), 31.83, (65.96, 41.67, 19.6)),
        ((3.53, 6.56, 2.14), (109.85, 100.0, 35.58), 318.31, (21.79, 48.80, 177.1)),
        ((19.01, 20.00, 21.78), (109.85, 100.0, 35.58), 31.83, (42.53, 44.54, 248.9)),
    ],
)
def test_the_worked_examples_of_fairchild(xyz, white, luminance, expected):
    """Fairchild, Color Appearance Models, 3rd edition (2013), table 16.4."""
    model = AppearanceModel("CIECAM02", np.array(white), luminance, 20.0, "average")
    lightness, colourfulness, hue = correlates(model, xyz)
    assert (lightness, colourfulness) == pytest.approx(expected[:2], abs=0.0051)
    assert hue == pytest.approx(expected[2], abs=0.051)


def test_the_worked_example_of_cam16():
    """Li et al. 2017 with the conditions of CIECAM02's first example: J, M and h."""
    model = AppearanceModel("CAM16", np.array([95.05, 100.0, 108.88]), 318.31, 20.0, "average")
    expected = (41.7312, 0.1074, 217.068)
    assert correlates(model, (19.01, 20.0, 21.78)) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(
    ("rgb", "expected"),
    [
        ((1, 0, 0), (46.445, 89.494, 27.408)),
        ((0, 1, 0), (79.331, 85.587, 142.139)),
        ((0, 0, 1), (25.465, 68.867, 282.788)),
        ((1, 1, 1), (100.0, 2.265, 209.492)),
    ],
)
def test_the_primaries_of_srgb_are_those_of_material_design(rgb, expected):
    """material-color-utilities' own tests: L_A of a white of 200/π seen at L* 50, Y_b of L* 50."""
    gray = ((50 + 16) / 116) ** 3 * 100
    model = AppearanceModel("CAM16", D65, 200 / np.pi * gray / 100, gray, "average")
    assert correlates(model, 100 * SRGB_TO_XYZ @ rgb) == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("name", ["CAM16", "CIECAM02"])
@pytest.mark.parametrize("surround", SURROUNDS)
@pytest.mark.parametrize(("luminance", "background"), [(4.0, 20.0), (318.31, 10.0), (0.1, 60.0)])
class TestUniformSpace:
    def test_agrees_with_colour_science(self, name, surround, luminance, background):
        colour = colour_science()
        rgb = np.random.default_rng(1).random((500, 3))
        xyz = 100 * rgb @ SRGB_TO_XYZ.T
        theirs = {"CAM16": colour.XYZ_to_CAM16, "CIECAM02": colour.XYZ_to_CIECAM02}[name](
            xyz, D65, luminance, background, colour.VIEWING_CONDITIONS_CAM16[surround.title()]
        )
        jmh = np.stack([theirs.J, theirs.M, theirs.h], axis=1)
        uniform = {"CAM16": colour.models.JMh_CAM16_to_CAM16UCS}.get(
            name, colour.models.JMh_CIECAM02_to_CAM02UCS
        )
        ours, outside = AppearanceModel(name, D65, luminance, background, surround).uniform(xyz)
        assert not outside.any()
        np.testing.assert_allclose(ours, uniform(jmh), atol=1e-6)

    def test_round_trip(self, name, surround, luminance, background):
        xyz = 100 * np.random.default_rng(2).random((2000, 3)) @ SRGB_TO_XYZ.T
        model = AppearanceModel(name, D65, luminance, background, surround)
        coordinates, _ = model.uniform(xyz)
        np.testing.assert_allclose(model.tristimulus(coordinates), xyz, atol=1e-7)

    def test_black_is_the_origin(self, name, surround, luminance, background):
        model = AppearanceModel(name, D65, luminance, background, surround)
        coordinates, outside = model.uniform(np.zeros((1, 3)))
        assert not outside.any()
        np.testing.assert_allclose(coordinates, 0.0, atol=1e-9)
        np.testing.assert_allclose(model.tristimulus(coordinates), 0.0, atol=1e-9)


@pytest.mark.parametrize("name", ["CAM16", "CIECAM02"])
def test_where_the_model_has_no_answer_its_nearest_is_finite_and_told(name):
    wild = np.random.default_rng(3).normal(0, 200, (5000, 3))
    model = AppearanceModel(name, D65, 4.0, 20.0, "average")
    coordinates, outside = model.uniform(wild)
    assert np.isfinite(coordinates).all()
    assert outside.any()
    assert np.isfinite(model.tristimulus(wild)).all()
