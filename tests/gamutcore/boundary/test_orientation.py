"""The side of a plane that a point is on, against exact rational arithmetic."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gamutcore.boundary import radial_hull
from gamutcore.geometry import TERMS


def exact(position, one, two, three, point):
    """Return the determinant, negative above the plane."""
    rows = [
        [Fraction(float(position[corner, axis])) - Fraction(float(position[point, axis]))
         for axis in range(3)]
        for corner in (one, two, three)
    ]  # fmt: skip
    determinant = Fraction(0)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        determinant += rows[0][i] * (rows[1][j] * rows[2][k] - rows[1][k] * rows[2][j])
    return determinant


def is_above(position, *corners_and_point):
    return radial_hull.is_above(position, *corners_and_point, np.empty(TERMS))


def assert_as_exact(position):
    """Check all cyclic orders of the corners: "above" is always right."""
    expected = exact(position, 0, 1, 2, 3) < 0
    for corners in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        assert is_above(position, *corners, 3) == expected


COORDINATE = st.floats(-1, 1).map(lambda x: 0.0 if abs(x) < 1e-12 else x)
WEIGHT = st.floats(0, 1).map(lambda x: 0.0 if abs(x) < 1e-12 else x)


@given(arrays(np.float64, (4, 3), elements=COORDINATE))
def test_of_any_four_points(position):
    assert_as_exact(position)


@given(arrays(np.float64, (3, 3), elements=COORDINATE), WEIGHT, WEIGHT)
def test_of_points_on_the_plane_but_for_rounding(corners, u, v):
    point = corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0])
    point[np.abs(point) < 1e-12] = 0.0
    assert_as_exact(np.vstack([corners, point]))


@given(arrays(np.int64, (4, 2), elements=st.integers(-(2**19), 2**19)), st.integers(-7, 7))
def test_on_a_plane_nobody_is_above(flat, slope):
    # whole numbers on the plane z = slope x + 3 y
    position = np.column_stack([flat, slope * flat[:, 0] + 3 * flat[:, 1]]) * 2.0**-30
    assert not is_above(position, 0, 1, 2, 3)
    assert not is_above(position, 0, 2, 1, 3)


@pytest.mark.parametrize("height", [2.0**-52, -(2.0**-52), 2.0**-80, -(2.0**-80), 1.0, -1.0])
def test_the_least_height_counts(height):
    position = np.array([(0, 0, 0), (1, 0, 0), (0.3, 0.7, 0), (0.4, 0.1, height)])
    assert is_above(position, 0, 1, 2, 3) == (height > 0)
    assert is_above(position, 0, 2, 1, 3) == (height < 0)


def test_far_beyond_the_digits_of_one_number():
    # three points of a line in exact arithmetic but for the last bit of one coordinate
    position = np.array([(0.1, 0.1, 0.1), (0.3, 0.3, 0.3), (0.7, 0.7, 0.7), (0.9, 0.2, 0.5)])
    for bit in (0.7, np.nextafter(0.7, 1), np.nextafter(0.7, 0)):
        position[2, 2] = bit
        assert_as_exact(position)
        assert_as_exact(position[[1, 0, 2, 3]])
