from __future__ import annotations

import numpy as np
import pytest

from gamutcore.colours.spaces.cielab import white_of, xyz_to_lab
from gamutcore.colours.spectral import (
    ILLUMINANTS,
    OBSERVERS,
    emission_xyz,
    reflectance_xyz,
    tristimulus_weights,
)

PRESS_BANDS = tuple(float(nm) for nm in range(380, 740, 10))


@pytest.mark.parametrize(
    ("illuminant", "observer", "steps", "white"),
    [  # ASTM E308-18, table 5: white points of the weights
        ("A", 2, (5, 10, 20), (109.850, 35.585)),
        ("D50", 2, (5, 10, 20), (96.422, 82.521)),
        ("D65", 2, (5, 10, 20), (95.047, 108.883)),
        ("D50", 10, (5, 10, 20), (96.720, 81.427)),
        ("D65", 10, (10, 20), (94.811, 107.304)),
        # CIE 15 tabulates these illuminants in steps of 5 nm; between, interpolations differ.
        ("C", 2, (5,), (98.074, 118.232)),
        ("FL11", 2, (5,), (100.962, 64.350)),
    ],
)
@pytest.mark.slow
def test_the_weights_add_up_to_the_published_white(illuminant, observer, steps, white):
    for step in steps:
        bands = tuple(float(nm) for nm in range(380, 740, step))
        x, y, z = 100 * tristimulus_weights(bands, illuminant, observer).sum(axis=0)
        assert y == pytest.approx(100)
        assert (x, z) == pytest.approx(white, abs=0.02)


@pytest.mark.parametrize("illuminant", ILLUMINANTS)
@pytest.mark.parametrize("observer", OBSERVERS)
def test_the_perfect_diffuser_is_the_white(illuminant, observer):
    xyz, scale = reflectance_xyz(
        np.array(PRESS_BANDS), np.full((1, 36), 100.0), illuminant, observer
    )
    white = white_of(illuminant, str(observer))
    assert scale == 100
    np.testing.assert_allclose(xyz[0], white, rtol=1e-12)
    np.testing.assert_allclose(xyz_to_lab(xyz, white)[0], [100, 0, 0], atol=1e-9)


def test_weights_are_linear_and_kept():
    assert tristimulus_weights(PRESS_BANDS, "D50", 2) is tristimulus_weights(PRESS_BANDS, "D50", 2)
    random = np.random.default_rng(0).random((5, 36))
    one, _ = reflectance_xyz(np.array(PRESS_BANDS), random, "D50", 2)
    half, _ = reflectance_xyz(np.array(PRESS_BANDS), random / 2, "D50", 2)
    np.testing.assert_allclose(half, one / 2)


@pytest.mark.parametrize("bands", [
    np.arange(380, 731, 1.0), np.arange(380, 732, 4.0), np.arange(383, 733, 10.0),
    np.arange(380, 731, 5.0), np.linspace(380, 730, 106), np.arange(300, 1000, 10.0),
    np.array([380, 395, 420, *range(430, 735, 10)], float),
])  # fmt: skip
def test_a_smooth_spectrum_has_one_colour_however_it_is_sampled(bands):
    """ASTM E308 itself is accurate to a few hundredths of ΔE for smooth spectra."""

    def smooth(wavelengths):
        return 0.1 + 0.8 / (1 + np.exp(-(np.asarray(wavelengths) - 580) / 30))

    expected, _ = reflectance_xyz(np.array(PRESS_BANDS), smooth(PRESS_BANDS)[None], "D50", 2)
    found, _ = reflectance_xyz(bands, smooth(bands)[None], "D50", 2)
    assert np.linalg.norm(xyz_to_lab(found) - xyz_to_lab(expected)) < 0.1


def test_what_lies_beyond_the_visible_has_no_weight():
    weights = tristimulus_weights(tuple(np.arange(300, 1010, 10.0)), "D65", 2)
    beyond = np.r_[0:6, 49:71]
    assert not weights[beyond].any()
    assert weights[6:49, 1].sum() == pytest.approx(1)


def test_lights_in_candela_per_square_metre():
    """Of 1 W/(m² sr nm) at all wavelengths: 683 lm/W times the functions' sums (CIE 15)."""
    for bands in (np.arange(360, 785, 5.0), np.arange(360, 781, 1.0)):
        xyz = emission_xyz(bands, np.ones((1, len(bands))), 2)
        assert xyz[0, 1] == pytest.approx(683 * 106.857, rel=1e-4)
    assert xyz[0] / 683 == pytest.approx([106.865, 106.857, 106.892], rel=1e-4)


def test_a_narrow_light_has_the_chromaticity_of_its_wavelength():
    """CIE 15:2018, table 1, at 550 nm."""
    bands = np.arange(360, 781, 1.0)
    x, y, z = emission_xyz(bands, (bands == 550)[None].astype(float), 2)[0]
    assert (x / (x + y + z), y / (x + y + z)) == pytest.approx((0.3016, 0.6923), abs=2e-4)
