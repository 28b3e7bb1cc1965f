"""Distances from, and integrals over, single triangles: trimesh, samples, and small triangles."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gamutcore.metric.distance_bound import (
    SLACK,
    STACK,
    make_surface,
    raise_bound,
    squared_distance,
)
from gamutcore.metric.integrals import CAPACITY, empty_queue, integrate, push

coordinates = st.floats(-100, 100, allow_subnormal=False).map(lambda value: round(value, 3))


def surface_of(mesh):
    return make_surface(mesh.vertices.astype(np.float64), mesh.faces.astype(np.int32).ravel())


def distance_to_triangle(point, triangle):
    closest = trimesh.triangles.closest_point(triangle[None], point[None])[0]
    return np.linalg.norm(closest - point)


class TestSquaredDistance:
    @given(arrays(np.float64, (4, 3), elements=coordinates))
    def test_is_that_of_the_closest_point(self, points):
        triangle, point = points[:3], points[3]
        edges = triangle[1:] - triangle[0]
        if np.linalg.norm(np.cross(*edges)) < 1e-3 * np.prod(np.linalg.norm(edges, axis=1)) or (
            (np.ptp(triangle, axis=0) == 0).all()
        ):
            return  # slivers have a test of their own
        surface = make_surface(triangle, np.arange(3, dtype=np.int32))
        found = np.sqrt(squared_distance(*point, surface, 0))
        assert found == pytest.approx(distance_to_triangle(point, triangle), rel=1e-6, abs=1e-6)

    @given(
        arrays(np.float64, (3, 3), elements=coordinates),
        st.floats(0, 1),
        st.floats(-1e-7, 1e-7),
        st.integers(0, 2),
    )
    def test_of_a_sliver_is_that_of_its_longest_edge(self, points, share, off, turn):
        start, end, point = points
        if np.linalg.norm(end - start) < 0.1:
            return
        corners = np.roll([start, end, start + share * (end - start) + off], turn, axis=0)
        surface = make_surface(corners, np.arange(3, dtype=np.int32))
        along = np.clip((point - start) @ (end - start) / np.sum((end - start) ** 2), 0, 1)
        expected = np.linalg.norm(start + along * (end - start) - point)
        assert np.sqrt(squared_distance(*point, surface, 0)) == pytest.approx(expected, abs=1e-5)


class TestRaiseBound:
    def raised(self, surface, triangle, lower=0.0, upper=0.0, face=0, halvings=1e6, deviation=0.0):
        stack = np.empty(STACK)
        stack[0, :9] = np.ravel(triangle)
        lower, upper, left = raise_bound(
            stack, surface, face, deviation, lower, upper, halvings, SLACK
        )
        assert 0 <= left <= halvings
        return lower, upper

    @pytest.mark.parametrize("halvings", [1e6, 3.0, 0.0])
    @pytest.mark.parametrize("seed", range(8))
    @pytest.mark.slow
    def test_holds_for_every_point_of_the_triangle(self, star_shaped, distances_to, seed, halvings):
        mesh = star_shaped(3)
        surface = surface_of(mesh)
        random = np.random.default_rng(seed)
        size = 10.0 ** random.uniform(-2, 1.5)
        triangle = random.normal(size=(3, 3)) * size + (50, 30, 20)
        lower, upper = self.raised(surface, triangle, halvings=halvings)
        shares = random.dirichlet(np.full(3, 0.5), 300)
        found = distances_to(np.vstack([triangle, shares @ triangle]), mesh).max()
        assert found <= upper * (1 + 1e-9)
        assert lower <= upper


def by_subdivision(corners, parts=400):
    """The three integrals from the middles of small triangles, N · p being linear on the whole.

    At N · p = 1 ÷ t the other surface is t times as far away: volumes and areas are t³ times those
    at the triangle, the heights of all cones over one plane being the same.
    """
    steps = np.arange(parts)
    u, v = (grid.ravel() for grid in np.meshgrid(steps, steps))
    inside = u + v < parts
    first = np.stack([u, v], axis=1)[inside] + 1 / 3
    second = np.stack([u, v], axis=1)[u + v < parts - 1] + 2 / 3
    middles = np.vstack([first, second]) / parts
    one, two, three = corners
    d = one + middles @ (two - one, three - one)
    t = 1 / (1 + d)
    return abs(1 - t**3).mean(), abs(d).mean(), (t**3 * abs(t - 1)).mean()


def integrals_of(triangles):
    waiting = empty_queue()
    for number, corners in enumerate(triangles):
        push(waiting, number, 0, corners, (1.0, 1.0, 1.0), 1.0)
    integrate(waiting, len(triangles))
    return waiting.integral.reshape(3, CAPACITY)[:, : len(triangles)].T


class TestDifferences:
    @pytest.mark.parametrize("size", [1e-3, 0.05, 0.5])
    @pytest.mark.parametrize("signs", [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)])
    def test_are_those_of_many_small_triangles(self, size, signs):
        corners = size * np.array(signs) * (0.4, 1.0, 0.7)
        for turned in (corners, -corners):
            (found,) = integrals_of([tuple(turned)])
            # 160,000 small triangles, of 1 ÷ 400 of the length: errors of the order of the square
            np.testing.assert_allclose(found, by_subdivision(turned), rtol=1e-4)

    def test_do_not_depend_on_which_corner_is_the_first(self):
        random = np.random.default_rng(2)
        corners = random.uniform(-0.3, 0.5, (60, 3))
        expected = integrals_of([tuple(row) for row in corners])
        for turn in (1, 2):
            found = integrals_of([tuple(row) for row in np.roll(corners, turn, axis=1)])
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-14)

    def test_have_closed_forms_between_similar_triangles(self):
        """Parallel to the face at N · p = 1 + d: t = 1 ÷ (1 + d) everywhere."""
        for d in (-0.5, 0.25, 3.0):
            t = 1 / (1 + d)
            ((gap, mean, back),) = integrals_of([(d, d, d)])
            assert gap == pytest.approx(abs(1 - t**3))
            assert mean == pytest.approx(abs(d))
            assert back == pytest.approx(t**3 * abs(t - 1))
