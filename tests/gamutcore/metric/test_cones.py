"""Cones of faces, and the cone of a point, compared with solving for all faces."""

import numpy as np
import pytest

from gamutcore.metric.cones import MOVES, compute_cones, find_crossing, locate
from gamutcore.metric.distance_bound import make_surface

CENTRE = (50.0, 0.0, 0.0)


def surface_of(mesh):
    return make_surface(
        mesh.vertices.astype(np.float64) - CENTRE, mesh.faces.astype(np.int32).ravel()
    )


@pytest.fixture(scope="module")
def mesh(star_shaped):
    return star_shaped(11, 300)


class TestConesOf:
    def test_normals_are_one_at_every_corner(self, mesh):
        cones = compute_cones(surface_of(mesh))
        corners = np.stack(mesh.corners(CENTRE), axis=1)
        np.testing.assert_allclose(np.einsum("fx,fcx->fc", cones.normal, corners), 1, rtol=1e-12)
        np.testing.assert_allclose(cones.slope, np.linalg.norm(cones.normal, axis=1), rtol=1e-12)

    def test_planes_hold_the_edges_and_see_the_corner_across(self, mesh):
        cones = compute_cones(surface_of(mesh))
        corners = np.stack(mesh.corners(CENTRE), axis=1)
        products = np.einsum("fpx,fcx->fpc", cones.planes.reshape(-1, 3, 3), corners)
        determinants = mesh.determinants(CENTRE)[:, None, None]
        expected = np.tile(np.eye(3), (mesh.triangles, 1, 1))
        np.testing.assert_allclose(products / determinants, expected, atol=1e-9)

    def test_neighbours_share_the_edge(self, mesh):
        neighbour = compute_cones(surface_of(mesh)).neighbour
        for face in range(mesh.triangles):
            for place in range(3):
                edge = set(mesh.faces[face].tolist()) - {int(mesh.faces[face, place])}
                assert edge < set(mesh.faces[neighbour[face, place]].tolist())
                assert face in neighbour[neighbour[face, place]]


class TestLocated:
    def points(self, count=500):
        random = np.random.default_rng(3)
        return random.normal(size=(count, 3)) * random.uniform(1, 100, (count, 1))

    def by_solving(self, mesh, points):
        """Solve p = Σ s c for all faces; return the face with the largest smallest s, and Σ s."""
        inverse = np.linalg.inv(np.stack(mesh.corners(CENTRE), axis=2))
        shares = np.einsum("fij,pj->pfi", inverse, points)
        face = shares.min(axis=2).argmax(axis=1)
        return face, shares[np.arange(len(points)), face].sum(axis=1)

    @pytest.mark.parametrize("moves", [MOVES, 2, 0])
    def test_is_what_solving_for_all_faces_finds(self, mesh, moves):
        points = self.points()
        order = np.random.default_rng(1).permutation(len(points)).astype(np.int32)
        near = np.full(len(points), order[0], np.int32)
        locations = locate(points, order, near, compute_cones(surface_of(mesh)), moves)
        face, ratio = self.by_solving(mesh, points)
        np.testing.assert_array_equal(locations.face, face)
        np.testing.assert_allclose(locations.beyond, ratio - 1, rtol=1e-9, atol=1e-12)
        radius = np.linalg.norm(points, axis=1)
        np.testing.assert_allclose(locations.along, abs(radius - radius / ratio), rtol=1e-8)

    def test_of_the_surface_s_own_vertices_is_on_it(self, mesh):
        surface = surface_of(mesh)
        count = len(surface.position)
        order = np.arange(count, dtype=np.int32)
        locations = locate(
            surface.position, order, np.zeros(count, np.int32), compute_cones(surface)
        )
        assert abs(locations.beyond).max() < 1e-12
        for vertex, face in enumerate(locations.face):
            assert vertex in mesh.faces[face]


class TestCrossing:
    def test_is_where_the_plane_of_the_shared_edge_is_met(self, mesh):
        """Triangles have two corners above a face and one above its neighbour."""
        cones = compute_cones(surface_of(mesh))
        corners = np.stack(mesh.corners(CENTRE), axis=1)
        for face in range(0, mesh.triangles, 13):
            beyond = int(cones.neighbour[face, 1])
            middle, other = corners[face].mean(axis=0), corners[beyond].mean(axis=0)
            edge = np.delete(corners[face], 1, axis=0).mean(axis=0)
            one, two = 0.6 * edge + 0.4 * middle, 0.5 * edge + 0.5 * middle
            position = np.stack([one, two, 0.9 * edge + 0.1 * other])
            single, from_two, from_one = find_crossing(position, 0, 1, 2, face, beyond, cones)
            assert single
            for start, share in ((position[1], from_two), (position[0], from_one)):
                point = start + share * (position[2] - start)
                plane = cones.planes[face, 3:6]
                assert abs(plane @ point) < 1e-9 * np.linalg.norm(plane) * np.linalg.norm(point)
            # the reverse direction and distant faces give no result
            assert not find_crossing(position, 0, 1, 2, beyond, face, cones)[0]
            assert not find_crossing(position, 0, 1, 2, face, face, cones)[0]
