from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from gamutcore.characterisation import characterisation
from gamutcore.colours import plausibility, surface_colours
from gamutcore.colours.optimal_colours import optimal_colours
from gamutcore.colours.plausibility import (
    extrapolation_warnings,
    impossible_colour_warnings,
)
from gamutcore.colours.spaces.cielab import xyz_to_lab
from gamutcore.colours.spectral import tristimulus_weights

CORNERS = np.stack(np.meshgrid(*[[0.0, 1.0]] * 3), axis=-1).reshape(-1, 3)


def lab(device):
    """Return the colours of a device whose gamut is a box of 100 × 120 × 120."""
    return np.column_stack([100 * device[:, 0], 120 * (device[:, 1:] - 0.5)])


def test_a_cube_measured_at_its_corners_is_not_extrapolated():
    assert extrapolation_warnings(CORNERS, CORNERS, lab(CORNERS), lab(CORNERS)) == []


def test_the_excess_over_the_hull_of_the_samples_is_told():
    """Samples fill the half of the range: the hull is an eighth of the gamut."""
    samples = 0.25 + CORNERS / 2
    far, size = extrapolation_warnings(CORNERS, 0.1 * samples, lab(CORNERS), lab(samples))
    assert far.startswith("7 of the 8 corners")
    assert "8.00 times" in size
    near = extrapolation_warnings(CORNERS, samples, lab(CORNERS), lab(samples))
    assert near == [size]


def test_samples_in_a_plane_have_no_hull_to_exceed():
    flat = CORNERS * [1, 1, 0]
    assert extrapolation_warnings(CORNERS * 0.4, flat * 0.4, lab(CORNERS), lab(flat)) == []


def test_lightness_outside_0_to_100_is_told():
    colours = np.array([[-3.0, 0, 0], [0, 0, 0], [100.0, 0, 0], [104.0, 0, 0]])
    (said,) = impossible_colour_warnings(colours, lights=True)
    assert "2 of 4" in said
    assert "from -3.0 to 104.0" in said
    assert impossible_colour_warnings(colours[1:3], lights=False) == []


def test_the_bands_are_those_of_astm_e308():
    weights = tristimulus_weights(tuple(np.arange(400.0, 701.0, 10.0)), "D50", 2)
    np.testing.assert_allclose(plausibility._BANDS.T, weights / weights[:, 1].sum(), atol=1e-3)


@pytest.mark.slow
def test_colour_science_is_not_imported():
    """Its import takes a second, which builds from CIELAB do not need otherwise."""
    code = (
        "import sys, numpy; from gamutcore.colours.plausibility import *; "
        "impossible_colour_warnings(numpy.eye(3), lights=False); assert 'colour' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_optimal_colours_are_inside_their_solid_and_lighter_ones_are_not():
    """Reflectances of 0 and 1 with two steps (Schrödinger 1920), by their cumulative sums."""
    optimal = optimal_colours("D50", 2, 4000)[1:]
    assert impossible_colour_warnings(xyz_to_lab(optimal), lights=False) == []
    # Away from the middle of the solid by 5 %: all of them are outside.
    middle = optimal[-1] / 2
    beyond = middle + 1.05 * (optimal - middle)
    assert impossible_colour_warnings(xyz_to_lab(beyond), lights=False)[-1].startswith("100 %")


@pytest.mark.parametrize("stated", [False, True])
def test_a_scanner_target_is_told_to_be_extrapolated(stated):
    """Patches with little saturation, as on targets for scanners; the scanner is linear."""
    values = np.random.default_rng(0).random((300, 1)) ** [[1, 1, 1]]
    device = np.clip(values + np.random.default_rng(1).normal(0, 0.08, (300, 3)), 0, 1)
    matrix = np.array([[0.61, 0.21, 0.14], [0.31, 0.63, 0.06], [0.02, 0.07, 0.74]])
    colours = xyz_to_lab(device**2.2 @ (matrix * 0.85).T + 0.004)
    document = {
        "columns": ["RGB_R", "RGB_G", "RGB_B", "LAB_L", "LAB_A", "LAB_B"],
        "samples": np.column_stack([device, colours]).tolist(),
        "conditions": {"DEVICE_CLASS": "OUTPUT"} if stated else {},
    }
    surface = surface_colours(characterisation(json.dumps(document).encode()))
    warnings = " ".join(str(said) for said in surface.provenance["warnings"])
    assert "corners of the device cube are farther from all samples" in warnings
    assert "times the volume of the convex hull of the measured colours" in warnings
    assert ("assumed to be a display's" in warnings) != stated


def test_profiles_of_lights_are_not_compared_with_surfaces(small_profile):
    surface = surface_colours(characterisation(small_profile("DisplayP3-v4.icc")))
    assert impossible_colour_warnings(surface.points, lights=False)
    assert surface.provenance["warnings"] == []


def test_bare_colours_that_no_surface_has_are_told():
    rows = [[50, 120, -120], [50, -120, 80], [101, 0, 0], [0, 0, 0], [50, 0, 0]]
    surface = surface_colours(characterisation(json.dumps(rows).encode()))
    warnings = surface.provenance["warnings"]
    assert any("60 % of the colours are outside the optimal colour solid" in w for w in warnings)
    assert any("1 of 5 colours have an L* outside 0 to 100" in w for w in warnings)
