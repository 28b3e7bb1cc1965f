"""The star test against determinants in exact rational arithmetic."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.geometry import MINIMUM_DETERMINANT, faces_not_seeing_centre, sees_centre

NUMBER = st.floats(-1e6, 1e6, width=32).filter(lambda value: value == 0 or abs(value) > 1e-6)
POINT = st.tuples(NUMBER, NUMBER, NUMBER)


def exact(one, two, three):
    """Determinant and squared product of lengths, without rounding."""
    (a, b, c), (d, e, f), (g, h, i) = (map(Fraction, point) for point in (one, two, three))
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    squares = (a**2 + b**2 + c**2) * (d**2 + e**2 + f**2) * (g**2 + h**2 + i**2)
    return determinant, squares


@given(POINT, POINT, POINT)
def test_agrees_with_the_exact_determinant(one, two, three):
    determinant, squares = exact(one, two, three)
    seen = sees_centre(one, two, three)
    if seen:
        assert determinant > 0
    if determinant > 0 and determinant**2 > 4 * Fraction(MINIMUM_DETERMINANT) ** 2 * squares:
        assert seen
    if determinant <= 0:
        assert not seen


@given(POINT, POINT, st.floats(-3, 3), st.floats(-3, 3), st.integers(-3, 3))
def test_is_not_fooled_by_rounding_of_flat_faces(one, two, s, t, nudge):
    """The third corner is in the plane of the others and the centre, or an ulp off it."""
    third = s * np.array(one) + t * np.array(two)
    third[2] += nudge * np.spacing(np.abs(third[2]))
    determinant, _ = exact(one, two, third.tolist())
    if determinant <= 0:
        assert not sees_centre(one, two, third)


@given(POINT, POINT, POINT)
def test_turning_the_corners_changes_nothing_and_swapping_two_denies(one, two, three):
    seen = sees_centre(one, two, three)
    determinant, squares = exact(one, two, three)
    if abs(determinant) ** 2 > 4 * Fraction(MINIMUM_DETERMINANT) ** 2 * squares:
        assert sees_centre(two, three, one) == seen
        assert sees_centre(two, one, three) != seen
    else:
        assert not (seen and sees_centre(two, one, three))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("place", range(9))
def test_what_is_not_finite_does_not_see_it(value, place):
    corners = [1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0]
    assert sees_centre(*np.reshape(corners, (3, 3)))
    corners[place] = value
    assert not sees_centre(*np.reshape(corners, (3, 3)))


def test_faces_that_do_not_see_the_centre_are_named(icosphere):
    mesh = icosphere(2)
    positions = mesh.vertices.astype(np.float64)
    assert faces_not_seeing_centre(positions, mesh.faces).size == 0
    flipped = mesh.faces.copy()
    flipped[[3, 77]] = flipped[[3, 77], ::-1]
    assert faces_not_seeing_centre(positions, flipped).tolist() == [3, 77]
    # seen from beyond the surface, the faces in front of the eye turn their outside to it
    outside = np.array([0.0, 0.0, 3.0])
    expected = np.flatnonzero(mesh.determinants(outside) <= 0)
    assert faces_not_seeing_centre(positions - outside, mesh.faces).tolist() == expected.tolist()
    assert 0 < len(expected) < mesh.triangles
