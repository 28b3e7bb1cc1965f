from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from gamutcore.colours.spaces.cielab import (
    ICC_D50,
    colour_science,
    lab_to_xyz,
    white_of,
    xyz_to_lab,
)


def test_the_white_is_iccs_d50():
    # ICC.1:2022, 7.2.16, and not CIE 15's .96422, 1, .82521.
    np.testing.assert_allclose(
        xyz_to_lab(np.array([[0.9642, 1.0, 0.8249]])), [[100, 0, 0]], atol=1e-9
    )
    assert tuple(ICC_D50) == (0.9642, 1.0, 0.8249)


@pytest.mark.parametrize(
    ("y", "lightness"),
    [
        # By hand from CIE 15: L* 50 is Y = (66/116)³, L* 8 is 216/24389, and a straight line below.
        ((66 / 116) ** 3, 50),
        (216 / 24389, 8),
        (108 / 24389, 4),
        (0, 0),
    ],
)
def test_lightness_of_grays(y, lightness):
    np.testing.assert_allclose(xyz_to_lab(y * ICC_D50), [lightness, 0, 0], atol=1e-9)


def test_a_worked_example():
    # colour-science's documentation of XYZ_to_Lab, D65.
    white = np.array([0.3127 / 0.3290, 1, (1 - 0.3127 - 0.3290) / 0.3290])
    lab = xyz_to_lab(np.array([0.20654008, 0.12197225, 0.05136952]), white)
    np.testing.assert_allclose(lab, [41.52787529, 52.63858304, 26.92317922], atol=1e-6)


def test_colour_science_agrees():
    xyz = np.random.default_rng(1).uniform(-0.01, 1.2, (1000, 3))
    for white in (ICC_D50, white_of("A", "10")):
        chromaticity = white[:2] / white.sum()
        expected = colour_science().XYZ_to_Lab(xyz, chromaticity)
        np.testing.assert_allclose(xyz_to_lab(xyz, white), expected, atol=1e-10)
        back = colour_science().Lab_to_XYZ(expected, chromaticity)
        np.testing.assert_allclose(lab_to_xyz(expected, white), back, atol=1e-12)


def test_there_and_back():
    lab = np.random.default_rng(0).uniform([0, -120, -120], [100, 120, 120], (1000, 3))
    np.testing.assert_allclose(xyz_to_lab(lab_to_xyz(lab)), lab, atol=1e-9)


def test_slightly_negative_values_go_on_in_a_straight_line():
    lab = xyz_to_lab(np.array([[-0.001, -0.001, -0.001], [0, 0, 0], [0.001, 0.001, 0.001]]))
    np.testing.assert_allclose(lab[1] - lab[0], lab[2] - lab[1], atol=1e-9)


def test_whites_of_illuminants():
    # ASTM E308, table 5: D65, 2° and 10°, and A, 2°.
    np.testing.assert_allclose(white_of("D65", "2"), [0.95047, 1, 1.08883], atol=3e-4)
    np.testing.assert_allclose(white_of("D65", "10"), [0.94811, 1, 1.07304], atol=3e-4)
    np.testing.assert_allclose(white_of("a", "2"), [1.09850, 1, 0.35585], atol=3e-4)
    np.testing.assert_allclose(white_of("F11", "2"), [1.00962, 1, 0.64350], atol=3e-4)
    assert white_of("D50", "2") is ICC_D50
    assert white_of("candle", "2") is None


@pytest.mark.slow
def test_importing_colour_science_leaves_no_mocks_behind():
    program = (
        "import sys, gamutcore.colours\n"
        "assert 'colour' not in sys.modules\n"
        "from gamutcore.colours.spaces.cielab import colour_science\n"
        "colour_science()\n"
        "print([n for n, m in sys.modules.items() if 'Mock' in type(m).__name__])\n"
    )
    ended = subprocess.run(
        [sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, check=False
    )
    assert ended.stderr == ""
    assert ended.stdout.strip() == "[]"


def test_colour_science_is_imported_once():
    assert colour_science() is colour_science()
