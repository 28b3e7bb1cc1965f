"""Whites and adaptations against Lindbloom's published figures, and against colour-science."""

import numpy as np
import pytest

from gamutcore.colours.spaces.cielab import ICC_D50, colour_science
from gamutcore.colours.spaces.white_points import (
    ADAPTATIONS,
    WHITES,
    adaptation_matrix,
    white_point,
)

D50, D65 = np.array([0.96422, 1.0, 0.82521]), np.array([0.95047, 1.0, 1.08883])

# Bruce Lindbloom, Chromatic Adaptation: D65 to D50 of ASTM E308
LINDBLOOM = {
    "Bradford": [
        (1.0478112, 0.0228866, -0.0501270),
        (0.0295424, 0.9904844, -0.0170491),
        (-0.0092345, 0.0150436, 0.7521316),
    ],
    "von-Kries": [
        (1.0160803, 0.0552297, -0.0521326),
        (0.0060666, 0.9955661, -0.0012235),
        (0.0, 0.0, 0.7578869),
    ],
    "XYZ-scaling": [(1.0144665, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.7578869)],
}


@pytest.mark.parametrize("name", LINDBLOOM)
def test_matrices_are_those_of_lindblooms_table(name):
    np.testing.assert_allclose(adaptation_matrix(D65, D50, name), LINDBLOOM[name], atol=2e-6)


@pytest.mark.parametrize("name", sorted(set(ADAPTATIONS) - {"none"}))
def test_matrices_are_those_of_colour_science(name):
    theirs = name.replace("-s", " S").replace("-K", " K").replace("von", "Von")
    expected = colour_science().adaptation.matrix_chromatic_adaptation_VonKries(
        D65, D50, transform=theirs
    )
    np.testing.assert_allclose(adaptation_matrix(D65, D50, name), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "expected"),
    [  # ASTM E308, as in Lindbloom's table; the last two: SMPTE RP 431-2 and ST 2065-1
        ("A", (1.09850, 0.35585)),
        ("C", (0.98074, 1.18232)),
        ("D55", (0.95682, 0.92149)),
        ("D65", (0.95047, 1.08883)),
        ("D75", (0.94972, 1.22638)),
        ("E", (1.0, 1.0)),
        ("DCI", (0.89459, 0.95442)),
        ("D60", (0.95265, 1.00883)),
    ],
)
def test_whites_are_the_published_ones(name, expected):
    x, y, z = white_point(name)
    assert y == 1.0
    np.testing.assert_allclose((x, z), expected, atol=3e-4)


def test_d50_is_that_of_icc_profiles():
    np.testing.assert_array_equal(white_point("D50"), ICC_D50)


@pytest.mark.parametrize("name", sorted(set(ADAPTATIONS) - {"none"}))
@pytest.mark.parametrize("white", WHITES)
def test_a_white_becomes_the_other_and_two_steps_are_one(name, white):
    source, middle, target = white_point(white), white_point("D50"), white_point("D65")
    there = adaptation_matrix(source, target, name)
    np.testing.assert_allclose(there @ source, target, atol=1e-12)
    composed = adaptation_matrix(middle, target, name) @ adaptation_matrix(source, middle, name)
    np.testing.assert_allclose(composed, there, atol=1e-12)


def test_no_adaptation_leaves_all_as_it_is():
    np.testing.assert_array_equal(adaptation_matrix(D65, D50, "none"), np.eye(3))
