"""The volume cost against LAPACK's equality-constrained least squares over explicit faces."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import lapack

from gamutcore.decimation.costs import volume


def star(faces, one, two):
    return [face for face in faces if one in face or two in face]


def area_weighted_error(positions, faces, one, two, place):
    """Sum over the faces around an edge of their area by the squared distance to their plane."""
    total = 0.0
    for a, b, c in positions[star(faces, one, two)]:
        normal = np.cross(b - a, c - a)
        area = np.linalg.norm(normal) / 2
        total += area * (normal @ (place - a) / np.linalg.norm(normal)) ** 2
    return total


def enclosed(positions, faces, one, two, place):
    """Volume after the collapse."""
    moved = positions.copy()
    moved[one] = moved[two] = place
    return np.linalg.det(moved[faces]).sum() / 6


def shortness(positions, faces, one, two):
    corners = positions[star(faces, one, two)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    trace = np.linalg.norm(normals, axis=1).sum() / 2
    return 1e-10 * trace * np.sum((positions[one] - positions[two]) ** 2)


def constrained_optimum(positions, faces, one, two):
    """Least squares over the planes of the star under exact volume, by LAPACK's GGLSE."""
    middle = (positions[one] + positions[two]) / 2
    rows, right = [], []
    for a, b, c in positions[star(faces, one, two)]:
        normal = np.cross(b - a, c - a)
        weight = 1 / np.sqrt(2 * np.linalg.norm(normal))
        rows.append(weight * normal)
        right.append(weight * normal @ (a - middle))
    # the volume is affine in the place: its value and slope there, by differences that are exact
    at_middle = enclosed(positions, faces, one, two, middle)
    slope = [enclosed(positions, faces, one, two, middle + step) - at_middle for step in np.eye(3)]
    wanted = np.linalg.det(positions[faces]).sum() / 6 - at_middle
    *_, solution, info = lapack.dgglse(
        np.array(rows), np.array([slope]), np.array(right), np.array([wanted])
    )
    assert info == 0
    return middle + solution, np.array(rows)


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
def test_the_error_is_area_by_squared_distance(surface_from, bumpy_mesh, edges_of, compiled, seed):
    positions, faces = bumpy_mesh(seed, 40)
    state, surface = volume.state(positions, faces), surface_from(positions, faces)
    random = np.random.default_rng(seed)
    for one, two in edges_of(faces)[::4]:
        place = positions[one] + 20 * random.normal(size=3)
        assert compiled.error(state, surface, one, two, place) == pytest.approx(
            area_weighted_error(positions, faces, one, two, place)
            + shortness(positions, faces, one, two),
            rel=1e-9,
        )


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
def test_the_optimum_is_the_constrained_least_squares_solution(
    surface_from, bumpy_mesh, edges_of, compiled, seed
):
    positions, faces = bumpy_mesh(seed, 40)
    state, surface = volume.state(positions, faces), surface_from(positions, faces)
    compared = 0
    for one, two in edges_of(faces):
        place = np.empty(3)
        value = compiled.optimum(state, surface, one, two, place)
        best, rows = constrained_optimum(positions, faces, one, two)
        least = area_weighted_error(positions, faces, one, two, best)
        singular = np.linalg.svd(rows, compute_uv=False)
        if singular[-1] ** 2 > 0.01 * (singular**2).sum():
            # the pull to the midpoint is 1e-5 of the trace
            middle = (positions[one] + positions[two]) / 2
            assert np.linalg.norm(place - best) <= 2e-3 * np.linalg.norm(middle - best) + 1e-9
            assert value <= least * (1 + 1e-4) + shortness(positions, faces, one, two) + 1e-6
            compared += 1
    assert compared > 10


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
def test_the_optimum_preserves_the_volume(surface_from, bumpy_mesh, edges_of, compiled, seed):
    positions, faces = bumpy_mesh(seed, 40)
    state, surface = volume.state(positions, faces), surface_from(positions, faces)
    before = np.linalg.det(positions[faces]).sum() / 6
    for one, two in edges_of(faces):
        place = np.empty(3)
        compiled.optimum(state, surface, one, two, place)
        assert enclosed(positions, faces, one, two, place) == pytest.approx(before, rel=1e-9)


def test_nothing_is_remembered(surface_from, bumpy_mesh, edges_of, compiled):
    positions, faces = bumpy_mesh(4, 40)
    state, surface = volume.state(positions, faces), surface_from(positions, faces)
    (one, two), (three, four) = edges_of(faces)[0], edges_of(faces)[-1]
    before, after = np.empty(3), np.empty(3)
    expected = compiled.optimum(state, surface, one, two, before)
    compiled.optimum(state, surface, three, four, after)
    compiled.merge(state, surface, three, four, after)
    assert compiled.optimum(state, surface, one, two, after) == expected
    np.testing.assert_array_equal(after, before)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scale_costs_no_digits(surface_from, bumpy_mesh, compiled, scale):
    positions, faces = bumpy_mesh(5, 40)
    one, two = (int(v) for v in faces[0][:2])
    here, there = np.empty(3), np.empty(3)
    state = volume.state(positions, faces)
    expected = compiled.optimum(state, surface_from(positions, faces), one, two, here)
    other = positions * scale
    value = compiled.optimum(state, surface_from(other, faces), one, two, there)
    # area by squared distance
    assert value == pytest.approx(expected * scale**4, rel=1e-9)
    np.testing.assert_allclose(there / scale, here, rtol=1e-9)
