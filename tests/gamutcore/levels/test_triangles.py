"""Distances from, and integrals over, single triangles: trimesh, samples, and small triangles."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gamutcore.levels.overlay import (
    SLACK,
    STACK,
    make_surface,
    raise_bound,
    squared_distance,
)

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
        found = np.sqrt(squared_distance(tuple(point), surface, 0))
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
        assert np.sqrt(squared_distance(tuple(point), surface, 0)) == pytest.approx(
            expected, abs=1e-5
        )


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
