"""The constrained optimum against LAPACK's least squares with equality constraints."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import lapack

from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.costs.memoryless_quadrics import (
    Quadrics,
    account_for_volume,
    area_vectors,
    constrained_error,
    constrained_optimum,
    shift_to_preserve_volume,
)
from gamutcore.decimation.star import DEFICIT_NOW

VOLUME = cost_named("volume").parameters


def memoryless_quadrics(positions, faces):
    vectors = area_vectors(positions, np.ascontiguousarray(faces, np.int32))
    return Quadrics(np.empty((len(positions), 9)), np.zeros(len(positions), np.uint8), vectors)


def stars(faces, one, two):
    """The faces at both ends of an edge. The two faces at the edge itself occur twice."""
    return [face for end in (one, two) for face in faces if end in face]


def vectors_by_hand(positions, faces):
    corners = positions[np.asarray(faces)]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2


def error_by_hand(positions, faces, one, two, place):
    """Square root of (sum of area × squared distance from the plane) × (sum of areas)."""
    around = stars(faces, one, two)
    vectors = vectors_by_hand(positions, around)
    areas = np.linalg.norm(vectors, axis=1)
    distances = np.sum(vectors * (place - positions[np.asarray(around)[:, 0]]), axis=1) / areas
    length = np.linalg.norm(positions[one] - positions[two])
    return np.sqrt(((areas * distances**2).sum() + 1e-10 * areas.sum() * length**2) * areas.sum())


def enclosed(positions, faces, one, two, place):
    """Volume after the collapse."""
    moved = positions.copy()
    moved[one] = moved[two] = place
    return np.linalg.det(moved[faces]).sum() / 6


def by_lapack(positions, faces, one, two):
    """Least squares over the planes of both stars under exact volume, by LAPACK's GGLSE."""
    middle = (positions[one] + positions[two]) / 2
    around = stars(faces, one, two)
    vectors = vectors_by_hand(positions, around)
    rows = vectors / np.sqrt(np.linalg.norm(vectors, axis=1))[:, np.newaxis]
    right = np.sum(rows * (positions[np.asarray(around)[:, 0]] - middle), axis=1)
    # the volume is affine in the position, so differences give its gradient exactly
    at_middle = enclosed(positions, faces, one, two, middle)
    slope = [enclosed(positions, faces, one, two, middle + step) - at_middle for step in np.eye(3)]
    wanted = np.linalg.det(positions[faces]).sum() / 6 - at_middle
    *_, solution, info = lapack.dgglse(rows, np.array([slope]), right, np.array([wanted]))
    assert info == 0
    return middle + solution, rows


@pytest.fixture(scope="session")
def edges(surface_from, bumpy_mesh, ends_of):
    """Return a function from a seed to a mesh, its state and surface, and its edges."""

    def make(seed, count=40):
        positions, faces = bumpy_mesh(seed, count)
        surface = surface_from(positions, faces)
        named = [(int(corner), *ends_of(surface, int(corner))) for corner in surface.corner_facing]
        return positions, faces, memoryless_quadrics(positions, faces), surface, named

    return make


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
def test_the_error_is_area_by_squared_distance(edges, seed):
    positions, faces, planes, surface, named = edges(seed)
    random = np.random.default_rng(seed)
    for corner, one, two in named[::4]:
        place = positions[one] + 20 * random.normal(size=3)
        expected = error_by_hand(positions, faces, one, two, place)
        assert constrained_error(planes, surface, corner, place) == pytest.approx(
            expected, rel=1e-9
        )


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
@pytest.mark.slow
def test_the_optimum_is_the_constrained_least_squares_solution(edges, seed):
    positions, faces, planes, surface, named = edges(seed)
    compared = 0
    for corner, one, two in named:
        place = np.empty(3)
        value = constrained_optimum(planes, surface, corner, place)
        best, rows = by_lapack(positions, faces, one, two)
        least = error_by_hand(positions, faces, one, two, best)
        singular = np.linalg.svd(rows, compute_uv=False)
        if singular[-1] ** 2 > 0.01 * (singular**2).sum():
            # the pull to the midpoint is 1e-5 of the trace
            middle = (positions[one] + positions[two]) / 2
            assert np.linalg.norm(place - best) <= 2e-3 * np.linalg.norm(middle - best) + 1e-9
            assert least * (1 - 1e-9) <= value
            # the error with the pull is minimal, so the error exceeds its least value by at most
            # the pull at the best position
            pull = 1e-5 * ((rows**2).sum() * np.linalg.norm(best - middle)) ** 2
            assert value**2 <= least**2 * (1 + 1e-9) + pull
            compared += 1
    assert compared > 10


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
def test_the_optimum_preserves_the_volume(edges, seed):
    positions, faces, planes, surface, named = edges(seed)
    before = np.linalg.det(positions[faces]).sum() / 6
    for corner, one, two in named:
        place = np.empty(3)
        constrained_optimum(planes, surface, corner, place)
        assert enclosed(positions, faces, one, two, place) == pytest.approx(before, rel=1e-9)


def test_the_optimum_compensates_the_deficit(edges):
    positions, faces, planes, surface, named = edges(2)
    before = np.linalg.det(positions[faces]).sum() / 6
    surface.deficit[DEFICIT_NOW] = 6 * 0.01 * before
    for corner, one, two in named:
        place = np.empty(3)
        constrained_optimum(planes, surface, corner, place)
        after = enclosed(positions, faces, one, two, place)
        assert after == pytest.approx(1.01 * before, rel=1e-9)


def test_the_shift_to_the_volume_is_the_shortest(edges):
    positions, faces, planes, surface, named = edges(3)
    before = np.linalg.det(positions[faces]).sum() / 6
    random = np.random.default_rng(0)
    for corner, one, two in named:
        place, optimum = positions[one] + random.normal(size=3), np.empty(3)
        start = place.copy()
        constrained_optimum(planes, surface, corner, optimum)
        shift_to_preserve_volume(planes, surface, corner, place)
        assert enclosed(positions, faces, one, two, place) == pytest.approx(before, rel=1e-9)
        # perpendicular to the plane of positions with that volume
        assert (place - start) @ (optimum - place) == pytest.approx(0.0, abs=1e-6)


def test_the_deficit_is_what_rounding_loses(edges):
    positions, faces, planes, surface, named = edges(4)
    before = np.linalg.det(positions[faces]).sum() / 6
    surface.deficit[DEFICIT_NOW] = 0.5
    for corner, one, two in named[:1]:
        place = positions[one] * 1.01
        account_for_volume(planes, surface, corner, place)
        lost = before - enclosed(positions, faces, one, two, place)
        assert surface.deficit[DEFICIT_NOW] == pytest.approx(0.5 + 6 * lost, rel=1e-9)


def test_both_corners_of_an_edge_give_the_same_result(edges):
    _, _, planes, surface, named = edges(5)
    for corner, *_ in named:
        here, there = np.empty(3), np.empty(3)
        value = constrained_optimum(planes, surface, corner, here)
        twin = int(surface.opposite[corner])
        assert constrained_optimum(planes, surface, twin, there) == pytest.approx(value, rel=1e-9)
        np.testing.assert_allclose(there, here, rtol=1e-7, atol=1e-7)


def test_quadrics_have_no_memory(surface_from, bumpy_mesh, faces_left, random_collapses, stage_of):
    """After collapses the result is that of a surface built from the present faces."""
    positions, faces = bumpy_mesh(6, 80)
    stage = stage_of(VOLUME, positions, faces)
    surface = stage.surface
    before = np.linalg.det(positions[faces]).sum()
    for _ in random_collapses(stage, 0, 40):
        pass
    numbers, left = faces_left(surface)
    assert len(left) < len(faces) - 40
    missing = before - np.linalg.det(surface.position[left]).sum()
    assert surface.deficit[DEFICIT_NOW] == pytest.approx(missing, rel=1e-9)
    # the same surface with renumbered faces and vertices
    kept, renamed = np.unique(left, return_inverse=True)
    again = surface_from(surface.position[kept], renamed.reshape(-1, 3))
    again.deficit[DEFICIT_NOW] = surface.deficit[DEFICIT_NOW]
    fresh = memoryless_quadrics(again.position, renamed.reshape(-1, 3))
    for corner in again.corner_facing.tolist():
        here, there = np.empty(3), np.empty(3)
        old = int(3 * numbers[corner // 3] + corner % 3)
        value = constrained_optimum(stage.quadrics, surface, old, here)
        expected = constrained_optimum(fresh, again, corner, there)
        assert value == pytest.approx(expected, rel=1e-9)
        np.testing.assert_allclose(here, there, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scale_costs_no_digits(surface_from, bumpy_mesh, scale):
    positions, faces = bumpy_mesh(5, 40)
    here, there = np.empty(3), np.empty(3)
    surface, other = surface_from(positions, faces), surface_from(positions * scale, faces)
    expected = constrained_optimum(memoryless_quadrics(positions, faces), surface, 2, here)
    value = constrained_optimum(memoryless_quadrics(positions * scale, faces), other, 2, there)
    # of the order of a volume
    assert value == pytest.approx(expected * scale**3, rel=1e-9)
    np.testing.assert_allclose(there / scale, here, rtol=1e-9)


def test_on_a_flat_side_the_shorter_edge_comes_first(surface_from):
    """The solution is the midpoint, and the error is the length penalty."""
    axis = np.linspace(-1.0, 1.0, 5)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    top = np.stack([x.ravel(), y.ravel() * (1 + 0.5 * y.ravel() ** 2), np.ones(25)], axis=1)
    index = np.arange(25).reshape(5, 5)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], -1)
    quads = quads.reshape(-1, 4)
    rim = [*index[:, 0], *index[-1, 1:], *index[-2::-1, -1], *index[0, -2:0:-1]]
    below = [(25, rim[(i + 1) % 16], rim[i]) for i in range(16)]
    faces = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]], below])
    positions = np.vstack([top, [[0, 0, -1]]])
    surface, planes = surface_from(positions, faces), memoryless_quadrics(positions, faces)
    for corner in surface.corner_facing.tolist():
        face = surface.vertex[3 * (corner // 3) : 3 * (corner // 3) + 3].tolist()
        one, two = (face[(corner + step) % 3] for step in (1, 2))
        interior = {6, 7, 8, 11, 12, 13, 16, 17, 18}
        if {one, two} <= interior:
            place = np.empty(3)
            value = constrained_optimum(planes, surface, corner, place)
            middle = (positions[one] + positions[two]) / 2
            np.testing.assert_allclose(place, middle, atol=1e-12)
            area = np.linalg.norm(vectors_by_hand(positions, stars(faces, one, two)), axis=1).sum()
            length = np.linalg.norm(positions[one] - positions[two])
            assert value == pytest.approx(1e-5 * area * length, rel=1e-6)
