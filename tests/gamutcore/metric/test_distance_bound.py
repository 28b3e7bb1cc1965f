"""Distances from faces, compared with trimesh, and bounds for all points of a triangle."""

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
    nearest_face,
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

    def test_of_a_point_thrice_is_that_of_the_point(self):
        surface = make_surface(np.ones((3, 3)), np.arange(3, dtype=np.int32))
        assert squared_distance(1.0, 1.0, 3.0, surface, 0) == 4.0
        assert squared_distance(2.0, 2.0, 2.0, surface, 0) == pytest.approx(3.0)


class TestNearestFace:
    @pytest.mark.parametrize("seed", range(3))
    def test_of_a_convex_body_is_the_nearest_from_wherever_it_starts(
        self, icosphere, distances_to, seed
    ):
        """Outside a convex body the distance has no other local minimum."""
        mesh = icosphere(2)
        surface = surface_of(mesh)
        random = np.random.default_rng(seed)
        points = random.normal(size=(20, 3))
        points *= random.uniform(1.0, 3.0, (20, 1)) / np.linalg.norm(points, axis=1)[:, None]
        for point, expected in zip(points, distances_to(points, mesh), strict=True):
            for start in random.integers(0, mesh.triangles, 5):
                face, squared = nearest_face(*point, surface, int(start))
                assert np.sqrt(squared) == pytest.approx(expected, rel=1e-6)
                assert squared == squared_distance(*point, surface, face)

    def test_is_never_nearer_than_the_surface(self, star_shaped, distances_to, random_cloud):
        mesh = star_shaped(1)
        surface = surface_of(mesh)
        points = random_cloud(2, 50)
        for point, least in zip(points, distances_to(points, mesh), strict=True):
            face, squared = nearest_face(*point, surface, 0)
            assert squared <= squared_distance(*point, surface, 0)
            assert squared == squared_distance(*point, surface, face)
            assert np.sqrt(squared) >= least * (1 - 1e-9)


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
    @pytest.mark.parametrize("seed", range(20))
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

    @pytest.mark.parametrize("seed", range(10))
    def test_is_tight_for_what_lies_outside_of_a_convex_body(self, icosphere, distances_to, seed):
        """The distance from a convex body is convex, so a corner is the furthest point."""
        mesh = icosphere(3)
        random = np.random.default_rng(seed)
        triangle = random.normal(size=(3, 3)) * 0.05 + (1.3, 0, 0)
        lower, upper = self.raised(surface_of(mesh), triangle)
        furthest = distances_to(triangle, mesh).max()
        assert lower == pytest.approx(furthest, rel=1e-6)
        assert furthest * (1 - 1e-9) <= upper <= SLACK * furthest * (1 + 1e-9)

    def test_of_a_part_of_the_surface_is_nothing(self, star_shaped):
        mesh = star_shaped(4)
        surface = surface_of(mesh)
        for face in range(0, mesh.triangles, 7):
            triangle = mesh.vertices[mesh.faces[face]].astype(np.float64)
            assert self.raised(surface, triangle, face=face)[1] < 1e-6

    def test_is_never_lowered(self, icosphere):
        surface = surface_of(icosphere(1))
        triangle = np.array([(2.0, 0, 0), (2.0, 0.1, 0), (2.0, 0, 0.1)])
        assert self.raised(surface, triangle, 5.0, 6.0) == (5.0, 6.0)
        lower, upper = self.raised(surface, triangle, 0.5, 0.6)
        assert lower > 0.9
        assert upper >= lower

    def test_adds_what_both_surfaces_are_off(self, star_shaped):
        mesh = star_shaped(3)
        surface = surface_of(mesh)
        triangle = np.array([(80.0, 30, 20), (81, 30, 20), (80, 31, 20)])
        _, alone = self.raised(surface, triangle)
        same = surface._replace(deviation=np.full(mesh.triangles, 2.0))
        _, upper = self.raised(same, triangle, deviation=3.0)
        assert alone / SLACK + 5 <= upper <= SLACK * (alone + 5)

    def test_ends_where_it_cannot_be_tight(self):
        """A triangle spans the gap between two parallel walls."""
        wall = np.array([(0.0, 0, 0), (10, 0, 0), (0, 10, 0)])
        corners = np.vstack([wall, wall + np.array([0, 0, 8])])
        surface = make_surface(corners, np.arange(6, dtype=np.int32))
        _, upper = self.raised(surface, [(1, 1, 0), (2, 1, 8), (1, 2, 4)])
        # the farthest point is half way; descent cannot leave a wall, as they share no vertex
        assert upper >= 4
        assert upper < np.inf
