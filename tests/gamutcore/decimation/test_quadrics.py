"""Errors and optima of both quadrics, by explicit sums over planes, LAPACK and determinants.

``quadric`` is the published cost of Garland and Heckbert; ``volume`` begins with the memoryless
quadrics of Lindstrom and Turk.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import lapack

from gamutcore.decimation import decimate
from gamutcore.decimation.costs import (
    cost_named,
    error_at,
    find_optimum,
    update_before_collapse,
)
from gamutcore.decimation.quadrics import (
    Quadrics,
    area_vectors,
    constrained_error,
    constrained_optimum,
)
from gamutcore.decimation.surface_mesh import DEFICIT_NOW
from gamutcore.geometry import TriangleMesh

pytestmark = pytest.mark.slow  # it compiles kernels that only tests use

QUADRIC, VOLUME = (cost_named(name).parameters for name in ("quadric", "volume"))
SEEDS = st.integers(0, 10**6)


def planes_at(positions, faces):
    """For each vertex, (normal, offset) of the planes of its faces."""
    planes = [[] for _ in positions]
    for face in faces:
        one, two, three = positions[face]
        normal = np.cross(two - one, three - one)
        normal /= np.linalg.norm(normal)
        for vertex in face:
            planes[vertex].append((normal, -normal @ one))
    return planes


def squared_distances(planes, place):
    return sum((normal @ place + offset) ** 2 for normal, offset in planes)


def length_penalty(positions, planes, one, two):
    """Penalty of an edge's length: 10⁻¹⁰ of the trace times the squared length."""
    return 1e-10 * len(planes) * np.sum((positions[one] - positions[two]) ** 2)


class TestPublishedCost:
    @settings(max_examples=10)
    @given(seed=SEEDS)
    def test_the_error_is_the_sum_over_all_planes_that_the_ends_have_accumulated(
        self, bumpy_mesh, edges_of, corner_of, seed, state_of
    ):
        positions, faces = bumpy_mesh(seed, 40)
        state = state_of(QUADRIC, positions, faces)
        surface = state.surface
        planes, edges = planes_at(positions, faces), edges_of(faces)
        random = np.random.default_rng(seed)

        def assert_errors(edges):
            for one, two in edges:
                place = surface.position[one] + 20 * random.normal(size=3)
                both = planes[one] + planes[two]
                expected = squared_distances(both, place)
                expected += length_penalty(surface.position, both, one, two)
                found = error_at(state, corner_of(surface, one, two), place)
                assert found == pytest.approx(expected, rel=1e-9)

        assert_errors(edges[::4])
        for one, two in [edges[index] for index in random.permutation(len(edges))[:10]]:
            place = (positions[one] + positions[two]) / 2 + random.normal(size=3)
            update_before_collapse(state, corner_of(surface, one, two), one, two, place)
            surface.position[one] = place
            planes[one] += planes[two]
        assert_errors(edges[::7])

    @settings(max_examples=10)
    @given(seed=SEEDS)
    @pytest.mark.slow
    def test_the_optimum_is_where_the_gradient_vanishes(
        self, bumpy_mesh, edges_of, corner_of, seed, state_of
    ):
        positions, faces = bumpy_mesh(seed, 40)
        state = state_of(QUADRIC, positions, faces)
        planes = planes_at(positions, faces)
        compared = 0
        for one, two in edges_of(faces):
            both = planes[one] + planes[two]
            A = sum(np.outer(normal, normal) for normal, _ in both)
            best = -np.linalg.solve(A, sum(offset * normal for normal, offset in both))
            place = np.empty(3)
            value = find_optimum(state, corner_of(state.surface, one, two), place)
            least = squared_distances(both, best)
            assert value >= least
            eigenvalues = np.linalg.eigvalsh(A)
            if eigenvalues[0] > 0.01 * eigenvalues.sum():
                # the pull to the midpoint is 1e-5 of the trace: a thousandth of the way at most
                middle = (positions[one] + positions[two]) / 2
                assert np.linalg.norm(place - best) <= 1e-3 * np.linalg.norm(middle - best)
                penalty = length_penalty(positions, both, one, two)
                assert value <= least * (1 + 1e-5) + penalty + 1e-4
                compared += 1
        assert compared > 10

    @pytest.mark.parametrize("seed", range(5))
    def test_the_cheapest_edge_is_collapsed_first(self, bumpy_mesh, edges_of, seed):
        """By the formula of Garland and Heckbert, with explicit sums over planes."""
        positions, faces = bumpy_mesh(seed, 80)
        record = decimate(TriangleMesh(positions, faces), np.zeros(3), "quadric").record
        planes = planes_at(positions, faces)
        errors = {}
        for one, two in edges_of(faces):
            both = planes[one] + planes[two]
            normals = np.array([normal for normal, _ in both])
            offsets = np.array([offset for _, offset in both])
            best, *_ = np.linalg.lstsq(normals, -offsets)
            merged = np.where(faces == two, one, faces)
            merged = merged[[len(set(face)) == 3 for face in merged.tolist()]]
            moved = positions.copy()
            moved[one] = best
            around = [set(faces[(faces == end).any(axis=1)].ravel().tolist()) for end in (one, two)]
            if len(around[0] & around[1]) == 4 and np.linalg.det(moved[merged]).min() > 0:
                errors[one, two] = squared_distances(both, best)
        first = tuple(sorted((int(record.kept[0]), int(record.dead[0]))))
        # up to the pull towards the midpoint: 1e-5 of the trace times the squared distance
        length = max(np.linalg.norm(positions[one] - positions[two]) for one, two in errors)
        assert errors[first] <= min(errors.values()) + 1e-5 * 20 * length**2
        assert errors[first] <= np.quantile(list(errors.values()), 0.05)


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


@pytest.fixture(scope="module")
def edges(surface_from, bumpy_mesh, ends_of):
    """Return a function from a seed to a mesh, its state and surface, and its edges."""

    def make(seed, count=40):
        positions, faces = bumpy_mesh(seed, count)
        surface = surface_from(positions, faces)
        named = [(int(corner), *ends_of(surface, int(corner))) for corner in surface.corner_facing]
        return positions, faces, memoryless_quadrics(positions, faces), surface, named

    return make


class TestMemorylessQuadrics:
    @settings(max_examples=10)
    @given(seed=SEEDS)
    def test_the_error_is_area_by_squared_distance(self, edges, seed):
        positions, faces, planes, surface, named = edges(seed)
        random = np.random.default_rng(seed)
        for corner, one, two in named[::4]:
            place = positions[one] + 20 * random.normal(size=3)
            expected = error_by_hand(positions, faces, one, two, place)
            for at in (corner, int(surface.opposite[corner])):
                found = constrained_error(planes, surface, at, place)
                assert found == pytest.approx(expected, rel=1e-9)

    @settings(max_examples=10)
    @given(seed=SEEDS)
    @pytest.mark.slow
    def test_the_optimum_is_the_constrained_least_squares_solution(self, edges, seed):
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
                # the error with the pull is minimal, so the error exceeds its least value by at
                # most the pull at the best position
                pull = 1e-5 * ((rows**2).sum() * np.linalg.norm(best - middle)) ** 2
                assert value**2 <= least**2 * (1 + 1e-9) + pull
                compared += 1
        assert compared > 10

    @pytest.mark.parametrize("deficit", [0.0, 0.01])
    @settings(max_examples=5)
    @given(seed=SEEDS)
    def test_the_optimum_preserves_the_volume_and_makes_up_for_a_deficit(
        self, edges, deficit, seed
    ):
        positions, faces, planes, surface, named = edges(seed)
        before = np.linalg.det(positions[faces]).sum() / 6
        surface.deficit[DEFICIT_NOW] = 6 * deficit * before
        for corner, one, two in named:
            place = np.empty(3)
            constrained_optimum(planes, surface, corner, place)
            after = enclosed(positions, faces, one, two, place)
            assert after == pytest.approx((1 + deficit) * before, rel=1e-9)

    def test_they_have_no_memory(
        self, surface_from, bumpy_mesh, faces_left, random_collapses, state_of
    ):
        """After collapses the result is that of a surface built from the present faces."""
        positions, faces = bumpy_mesh(6, 80)
        state = state_of(VOLUME, positions, faces)
        surface = state.surface
        before = np.linalg.det(positions[faces]).sum()
        for _ in random_collapses(state, 0, 40):
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
            value = constrained_optimum(state.quadrics, surface, old, here)
            expected = constrained_optimum(fresh, again, corner, there)
            assert value == pytest.approx(expected, rel=1e-9)
            np.testing.assert_allclose(here, there, rtol=1e-9, atol=1e-9)
