"""Meshes and their validity: known bodies, known faults, and a comparison with trimesh."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.errors import MeshError
from gamutcore.mesh import TriangleMesh

CORNERS = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], float)
FACES = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)])


@pytest.fixture
def tetrahedron():
    return TriangleMesh(CORNERS.copy(), FACES.copy())


def torus():
    body = trimesh.creation.torus(2.0, 0.5, major_sections=12, minor_sections=8)
    return TriangleMesh(np.asarray(body.vertices), np.asarray(body.faces))


class TestMeasures:
    def test_of_a_tetrahedron_of_edge_2_sqrt_2(self, tetrahedron):
        edge = 2 * np.sqrt(2)
        assert tetrahedron.volume == pytest.approx(edge**3 / (6 * np.sqrt(2)))
        assert tetrahedron.area == pytest.approx(np.sqrt(3) * edge**2)
        np.testing.assert_array_equal(tetrahedron.bounds, [(-1, -1, -1), (1, 1, 1)])
        assert tetrahedron.triangles == 4

    def test_of_a_box_and_a_torus_as_trimesh_has_them(self):
        for body in (trimesh.creation.box((1, 2, 3)), trimesh.creation.torus(2.0, 0.5)):
            mesh = TriangleMesh(np.asarray(body.vertices), np.asarray(body.faces))
            assert mesh.volume == pytest.approx(body.volume)
            assert mesh.area == pytest.approx(body.area)
            np.testing.assert_allclose(mesh.bounds, body.bounds)

    @given(st.tuples(*[st.floats(-100, 100)] * 3))
    def test_volume_is_the_sum_of_determinants_about_any_point(self, point):
        mesh = TriangleMesh(CORNERS, FACES)
        assert mesh.determinants(point).sum() / 6 == pytest.approx(mesh.volume, rel=1e-9)

    def test_volume_does_not_suffer_from_distance(self, tetrahedron):
        away = TriangleMesh(CORNERS + 1e6, FACES)
        assert away.volume == pytest.approx(tetrahedron.volume, rel=1e-12)

    def test_volume_of_a_mesh_turned_inside_out_is_negative(self, tetrahedron):
        turned = TriangleMesh(CORNERS, FACES[:, ::-1])
        assert turned.volume == pytest.approx(-tetrahedron.volume)

    def test_float32_is_measured_in_double_precision(self, icosphere):
        mesh = icosphere(4, 50.0, (50.0, 0.0, 0.0))
        double = TriangleMesh(mesh.vertices.astype(float), mesh.faces)
        assert mesh.volume == double.volume
        assert mesh.area == double.area
        np.testing.assert_array_equal(
            mesh.determinants((50, 0, 0)), double.determinants((50, 0, 0))
        )

    def test_nothing_has_no_volume(self):
        nothing = TriangleMesh(np.empty((0, 3)), np.empty((0, 3), int))
        assert (nothing.volume, nothing.area, nothing.triangles) == (0.0, 0.0, 0)
        assert not nothing.validity((0, 0, 0)).is_gamut


class TestConstruction:
    @pytest.mark.parametrize(
        ("vertices", "faces", "field"),
        [
            (np.zeros((4, 2)), FACES, "vertices"),
            (np.zeros(12), FACES, "vertices"),
            (np.zeros((4, 3), complex), FACES, "vertices"),
            (np.full((4, 3), "a"), FACES, "vertices"),
            (CORNERS, FACES.astype(float), "faces"),
            (CORNERS, FACES[:, :2], "faces"),
            (CORNERS, FACES.ravel(), "faces"),
            (CORNERS, FACES + 1, "faces"),
            (CORNERS, FACES - 1, "faces"),
            (CORNERS[:0], FACES, "faces"),
        ],
    )
    def test_refuses(self, vertices, faces, field):
        with pytest.raises(MeshError) as caught:
            TriangleMesh(vertices, faces)
        assert caught.value.where == {"field": field}
        assert caught.value.remedy

    def test_integers_become_coordinates(self):
        assert TriangleMesh(CORNERS.astype(int), FACES).vertices.dtype == np.float64

    def test_equality_is_that_of_the_arrays(self, tetrahedron):
        assert tetrahedron == TriangleMesh(CORNERS, FACES)
        assert tetrahedron != TriangleMesh(CORNERS + 1, FACES)
        assert tetrahedron != TriangleMesh(CORNERS, FACES[::-1])
        assert tetrahedron != "mesh"
        with pytest.raises(TypeError):
            hash(tetrahedron)


class TestValidity:
    def test_of_valid_bodies(self, tetrahedron, icosphere):
        for mesh in (tetrahedron, icosphere(3)):
            validity = mesh.validity((0, 0, 0))
            assert validity.is_gamut
            assert validity.euler_characteristic == 2
            assert validity.minimum_determinant == mesh.determinants((0, 0, 0)).min()

    def test_without_a_centre_nothing_is_said_about_the_star_shape(self, tetrahedron):
        validity = tetrahedron.validity()
        assert validity.is_sphere
        assert validity.minimum_determinant is None
        assert not validity.star_shaped
        assert not validity.is_gamut

    def test_of_a_centre_outside(self, tetrahedron):
        validity = tetrahedron.validity((2, 2, 2))
        assert validity.is_sphere
        assert not validity.star_shaped

    def test_of_a_centre_on_a_face(self, tetrahedron):
        assert not tetrahedron.validity(CORNERS[:3].mean(axis=0) * (1 + 1e-9)).star_shaped

    def test_of_a_hole(self, icosphere):
        mesh = icosphere(1)
        validity = TriangleMesh(mesh.vertices, mesh.faces[1:]).validity((0, 0, 0))
        assert not validity.closed
        assert not validity.is_sphere

    def test_of_a_flipped_face(self, icosphere):
        mesh = icosphere(1)
        mesh.faces[5] = mesh.faces[5, ::-1]
        assert not mesh.validity().closed

    def test_of_a_torus(self):
        validity = torus().validity()
        assert validity.closed
        assert validity.manifold
        assert validity.connected
        assert validity.euler_characteristic == 0
        assert not validity.is_sphere

    def test_of_two_pieces(self):
        both = TriangleMesh(np.vstack([CORNERS, CORNERS + 9]), np.vstack([FACES, FACES + 4]))
        validity = both.validity()
        assert validity.closed
        assert validity.manifold
        assert not validity.connected
        assert not validity.is_sphere

    def test_of_two_bodies_that_share_a_vertex(self):
        """Two tetrahedra that share a vertex: all edges are manifold, the vertex is not."""
        faces = np.vstack([FACES, np.where(FACES == 0, 0, FACES + 3)])
        mesh = TriangleMesh(np.vstack([CORNERS, 2 - CORNERS[1:]]), faces)
        validity = mesh.validity()
        assert validity.closed
        assert not validity.manifold
        assert not validity.is_sphere

    def test_of_an_unused_vertex(self):
        validity = TriangleMesh(np.vstack([CORNERS, [(9, 9, 9)]]), FACES).validity()
        assert validity.closed
        assert not validity.manifold
        assert not validity.is_sphere

    def test_of_a_face_there_twice(self):
        validity = TriangleMesh(CORNERS, np.vstack([FACES, FACES[:1]])).validity()
        assert validity.duplicate_faces == 1
        assert not validity.closed

    def test_of_a_face_and_its_back(self):
        """Two faces back to back are closed, but enclose no volume."""
        validity = TriangleMesh(CORNERS[:3], np.array([(0, 1, 2), (0, 2, 1)])).validity()
        assert validity.closed
        assert validity.duplicate_faces == 1
        assert not validity.is_sphere

    def test_of_a_face_that_names_a_vertex_twice(self):
        faces = FACES.copy()
        faces[0] = (0, 0, 2)
        validity = TriangleMesh(CORNERS, faces).validity()
        assert validity.degenerate_faces == 1
        assert not validity.is_sphere

    def test_of_a_face_without_area(self):
        corners = CORNERS.copy()
        corners[0] = (corners[1] + corners[2]) / 2
        validity = TriangleMesh(corners, FACES).validity()
        assert validity.closed
        assert validity.degenerate_faces == 1
        assert not validity.is_sphere

    @pytest.mark.parametrize("value", [np.nan, np.inf])
    def test_of_numbers_that_are_not_finite(self, tetrahedron, value):
        tetrahedron.vertices[2, 1] = value
        with np.errstate(invalid="ignore"):
            validity = tetrahedron.validity((0, 0, 0))
        assert not validity.finite
        assert not validity.is_gamut

    @settings(max_examples=60)
    @given(
        changes=st.lists(
            st.tuples(st.integers(0, 79), st.integers(0, 2), st.integers(0, 41)), max_size=2
        ),
        without=st.lists(st.integers(0, 79), max_size=1),
    )
    def test_agrees_with_trimesh_on_damaged_spheres(self, icosphere, changes, without):
        mesh = icosphere(1)
        faces = mesh.faces.copy()
        for face, place, vertex in changes:
            faces[face, place] = vertex
        faces = np.delete(faces, without, axis=0)
        judged = TriangleMesh(mesh.vertices, faces).validity()
        other = trimesh.Trimesh(mesh.vertices, faces, process=False, validate=False)
        named_twice = (faces == np.roll(faces, -1, axis=1)).any()
        if not named_twice:
            assert judged.closed == (other.is_watertight and other.is_winding_consistent)
        if judged.is_sphere:
            assert other.is_volume
            assert other.euler_number == 2
        assert judged.is_sphere == np.array_equal(faces, mesh.faces)


def test_trimesh_gets_the_same_arrays(icosphere):
    mesh = icosphere(2)
    converted = mesh.to_trimesh()
    np.testing.assert_array_equal(converted.vertices, mesh.vertices)
    np.testing.assert_array_equal(converted.faces, mesh.faces)


def test_corners_are_relative_to_an_origin(tetrahedron):
    one, two, three = tetrahedron.corners((1, 2, 3))
    for corner, column in zip((one, two, three), FACES.T, strict=True):
        np.testing.assert_array_equal(corner, CORNERS[column] - (1, 2, 3))
