"""Meshes and their validity: known bodies, known faults, and a comparison with trimesh."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.errors import MeshError
from gamutcore.geometry import DeviceValues, TriangleMesh

CORNERS = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], float)
FACES = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)])


FLAT = np.vstack([[(CORNERS[1] + CORNERS[2]) / 2], CORNERS[1:]])
TORUS = trimesh.creation.torus(2.0, 0.5, major_sections=12, minor_sections=8)
FAULTS = {
    "a hole": (CORNERS, FACES[1:], {"closed": False}),
    "a turned face": (CORNERS, np.vstack([FACES[:1, ::-1], FACES[1:]]), {"closed": False}),
    "a torus": (
        np.asarray(TORUS.vertices),
        np.asarray(TORUS.faces),
        {"closed": True, "manifold": True, "connected": True, "euler_characteristic": 0},
    ),
    "two pieces": (
        np.vstack([CORNERS, CORNERS + 9]),
        np.vstack([FACES, FACES + 4]),
        {"closed": True, "manifold": True, "connected": False},
    ),
    "a shared vertex": (  # all edges are manifold, the vertex is not
        np.vstack([CORNERS, 2 - CORNERS[1:]]),
        np.vstack([FACES, np.where(FACES == 0, 0, FACES + 3)]),
        {"closed": True, "manifold": False},
    ),
    "an unused vertex": (
        np.vstack([CORNERS, [(9, 9, 9)]]),
        FACES,
        {"closed": True, "manifold": False},
    ),
    "a face twice": (CORNERS, np.vstack([FACES, FACES[:1]]), {"duplicate_faces": 1}),
    "a face and its back": (
        CORNERS[:3],
        np.array([(0, 1, 2), (0, 2, 1)]),
        {"closed": True, "duplicate_faces": 1},
    ),
    "a corner twice": (
        CORNERS,
        np.vstack([[(0, 0, 2)], FACES[1:]]),
        {"degenerate_faces": 1},
    ),
    "no area": (FLAT, FACES, {"closed": True, "degenerate_faces": 1}),
    "not a number": (np.where(CORNERS > 0, CORNERS, np.nan), FACES, {"finite": False}),
    "infinite": (np.where(CORNERS > 0, CORNERS, np.inf), FACES, {"finite": False}),
}


@pytest.fixture
def tetrahedron():
    return TriangleMesh(CORNERS.copy(), FACES.copy())


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

    def test_nothing_has_no_volume(self):
        nothing = TriangleMesh(np.empty((0, 3)), np.empty((0, 3), int))
        assert (nothing.volume, nothing.area, nothing.triangles) == (0.0, 0.0, 0)
        assert not nothing.validity((0, 0, 0)).is_gamut


class TestDeviceValues:
    """One row for each vertex, with values from 0 to 1."""

    def test_have_a_row_for_each_vertex(self):
        device = DeviceValues(("C", "M"), np.zeros((4, 2)))
        assert TriangleMesh(CORNERS, FACES, device).device is device
        with pytest.raises(MeshError, match="3 rows for 4 vertices"):
            TriangleMesh(CORNERS, FACES, DeviceValues(("C", "M"), np.zeros((3, 2))))

    @pytest.mark.parametrize(
        ("channels", "values"),
        [
            (("C",), np.zeros((4, 2))),
            ((), np.zeros((4, 0))),
            (("C",), np.zeros(4)),
            (("C",), np.zeros((4, 1), int)),
            *((("C",), np.full((4, 1), value)) for value in (1.001, -0.001, np.nan)),
        ],
    )
    def test_of_other_shapes_and_ranges_are_refused(self, channels, values):
        with pytest.raises(MeshError):
            DeviceValues(channels, values)

    def test_make_meshes_differ(self):
        one, other = (DeviceValues(("C",), np.full((4, 1), value)) for value in (0.25, 0.5))
        assert TriangleMesh(CORNERS, FACES, one) == TriangleMesh(CORNERS, FACES, one)
        for device in (other, DeviceValues(("M",), one.values), None):
            assert TriangleMesh(CORNERS, FACES, one) != TriangleMesh(CORNERS, FACES, device)


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

    @pytest.mark.parametrize("centre", [(2, 2, 2), CORNERS[:3].mean(axis=0) * (1 + 1e-9)])
    def test_a_centre_outside_or_on_a_face_does_not_see_all(self, tetrahedron, centre):
        validity = tetrahedron.validity(centre)
        assert validity.is_sphere
        assert not validity.star_shaped

    @pytest.mark.parametrize("fault", FAULTS)
    def test_faults_are_named(self, fault):
        vertices, faces, expected = FAULTS[fault]
        with np.errstate(invalid="ignore"):
            validity = TriangleMesh(vertices, faces).validity((0, 0, 0))
        assert not validity.is_sphere
        assert not validity.is_gamut
        assert {name: getattr(validity, name) for name in expected} == expected

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


def test_corners_are_relative_to_an_origin(tetrahedron):
    one, two, three = tetrahedron.corners((1, 2, 3))
    for corner, column in zip((one, two, three), FACES.T, strict=True):
        np.testing.assert_array_equal(corner, CORNERS[column] - (1, 2, 3))
