"""A mesh as the boundary itself: its centre, its rounding, its provenance, and its refusals."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.boundary import mesh_boundary
from gamutcore.characterisation import GamutMesh
from gamutcore.colours import lab_to_xyz
from gamutcore.decimation import decimate
from gamutcore.errors import CentreError, MeshError
from gamutcore.geometry import mesh_grid_step

MIDDLE = np.array([50.0, 2.0, -3.0])


def made(body, **changes):
    mesh = GamutMesh("ply", np.asarray(body.vertices, float), np.asarray(body.faces, np.int64))
    return replace(mesh, **changes)


@pytest.fixture(scope="module")
def ball():
    body = trimesh.creation.icosphere(3, 40.0)
    body.apply_translation(MIDDLE)
    return made(body)


def test_a_ball_is_a_boundary_that_is_decimated(ball):
    boundary, provenance = mesh_boundary(ball)
    assert boundary.mesh.validity(boundary.centre).is_gamut
    assert boundary.mesh.triangles == 1280
    np.testing.assert_allclose(boundary.mesh.vertices, ball.vertices[boundary.sources], atol=1e-3)
    np.testing.assert_allclose(boundary.centre, MIDDLE, atol=0.5)
    assert provenance["mesh"]["centre"]["from"].startswith("found")
    assert 38 < provenance["mesh"]["centre"]["margin"] < 40
    assert provenance["warnings"] == []
    result = decimate(boundary.mesh, boundary.centre)
    # nothing was rounded again
    assert result.step == mesh_grid_step(boundary.mesh.vertices)


@settings(max_examples=20, deadline=None)
@given(st.tuples(*[st.floats(-10, 10)] * 3))
def test_the_centre_that_is_asked_for_is_taken(ball, offset):
    boundary, provenance = mesh_boundary(ball, MIDDLE + offset)
    np.testing.assert_allclose(boundary.centre, MIDDLE + offset, atol=1e-3)
    assert provenance["mesh"]["centre"]["from"] == "the option centre"


def test_the_files_own_centre_goes_before_one_that_is_found(ball):
    boundary, provenance = mesh_boundary(replace(ball, centre=MIDDLE + 5))
    np.testing.assert_allclose(boundary.centre, MIDDLE + 5, atol=1e-3)
    assert provenance["mesh"]["centre"]["from"] == "the file"


def test_a_centre_of_the_file_that_some_faces_do_not_see_is_replaced(ball):
    boundary, provenance = mesh_boundary(replace(ball, centre=MIDDLE + 100))
    np.testing.assert_allclose(boundary.centre, MIDDLE, atol=0.5)
    assert "own centre" in provenance["warnings"][0]


def test_a_centre_outside_is_refused_with_one_that_is_right(ball):
    with pytest.raises(CentreError, match="faces do not see it") as caught:
        mesh_boundary(ball, MIDDLE + 100)
    assert caught.value.where == {"field": "centre"}
    assert "50." in caught.value.remedy


def test_what_is_inside_out_is_turned(ball):
    boundary, provenance = mesh_boundary(replace(ball, faces=ball.faces[:, ::-1]))
    assert boundary.mesh.volume > 0
    assert provenance["mesh"]["turned"] == 1280
    assert "inside out" in provenance["warnings"][0]


def test_vertices_that_rounding_makes_one_are_merged(ball):
    """An edge of 10⁻⁶ units, which no grid of a gamut resolves."""
    face = ball.faces[0]
    neighbour = next(
        number for number, other in enumerate(ball.faces[1:], 1) if len({*other, *face}) == 4
    )
    # the face and its neighbour are split at a vertex beside one that they share
    one, two = sorted({*ball.faces[0]} & {*ball.faces[neighbour]})
    faces, number = [], len(ball.vertices)
    for corners in ball.faces.tolist():
        if one in corners and two in corners:
            faces += [
                [number if corner == two else corner for corner in corners],
                [number if corner == one else corner for corner in corners],
            ]
        else:
            faces.append(corners)
    near = ball.vertices[one] + 1e-6 * (ball.vertices[two] - ball.vertices[one])
    split = replace(
        ball, vertices=np.vstack([ball.vertices, near]), faces=np.array(faces, np.int64)
    )
    boundary, provenance = mesh_boundary(split)
    assert boundary.mesh.triangles == 1280
    assert provenance["mesh"]["merged_on_grid"] == 1
    assert provenance["mesh"]["dropped"] == 2


def test_slivers_on_the_grid_are_refused():
    """An octahedron with an edge split in its middle, so that two faces have no area."""
    body = trimesh.creation.box((60.0, 60.0, 60.0))
    body.apply_translation(MIDDLE)
    vertices = np.vstack([body.vertices, body.vertices[[0, 1]].mean(axis=0)])
    faces = np.vstack([body.faces, [0, 1, 8]])
    shared = next(face for face in body.faces.tolist() if 0 in face and 1 in face)
    start = shared.index(0)
    forward = shared[(start + 1) % 3] == 1
    faces = np.array([face for face in body.faces.tolist() if face != shared])
    third = next(corner for corner in shared if corner not in {0, 1})
    ring = [0, 8, 1] if forward else [1, 8, 0]
    added = [[ring[0], ring[1], third], [ring[1], ring[2], third], [ring[2], ring[1], ring[0]]]
    mesh = GamutMesh("ply", vertices, np.vstack([faces, added]))
    with pytest.raises(MeshError, match="1 faces have no area") as caught:
        mesh_boundary(mesh)
    assert "slivers" in caught.value.remedy


def test_what_is_not_star_shaped_is_refused_with_the_places():
    """A ball with a long, bent spike."""
    body = trimesh.creation.icosphere(3, 40.0)
    top = int(np.argmax(body.vertices[:, 2]))
    ring = {int(v) for face in body.faces if top in face for v in face} - {top}
    body.vertices[top] = (0.0, 60.0, 80.0)
    for vertex in ring:
        body.vertices[vertex] = (*(body.vertices[vertex][:2] * 0.2), 70.0)
    with pytest.raises(MeshError, match="not star-shaped: no point sees all faces") as caught:
        mesh_boundary(made(body))
    assert "CSV" in caught.value.remedy


def test_a_boundary_in_xyz_is_brought_to_cielab(ball):
    xyz = replace(ball, vertices=lab_to_xyz(ball.vertices), space="CIEXYZ")
    boundary, provenance = mesh_boundary(xyz)
    np.testing.assert_allclose(boundary.mesh.vertices, ball.vertices, atol=1e-3)
    assert "XYZ" in provenance["warnings"][0]


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.6))
@pytest.mark.slow
def test_any_rough_ball_is_a_valid_boundary_or_refused(ball, seed, roughness):
    radii = 1 - roughness * np.random.default_rng(seed).random((len(ball.vertices), 1))
    rough = replace(ball, vertices=MIDDLE + (ball.vertices - MIDDLE) * radii)
    # every ray from the middle meets it once, whatever its radii
    boundary, _ = mesh_boundary(rough, MIDDLE)
    assert boundary.mesh.validity(boundary.centre).is_gamut
    try:
        boundary, _ = mesh_boundary(rough)
    except MeshError as error:
        pytest.fail(f"the middle sees all faces: {error}")
    assert boundary.mesh.validity(boundary.centre).is_gamut


CUBE = trimesh.creation.box((2.0, 4.0, 6.0))
VERTICES, FACES = np.asarray(CUBE.vertices, float), np.asarray(CUBE.faces, np.int64)


def bounded(vertices, faces):
    """Return the boundary of a mesh about the origin, and what was changed in it."""
    mesh = GamutMesh("ply", np.asarray(vertices, float), np.asarray(faces, np.int64))
    boundary, provenance = mesh_boundary(mesh, (0, 0, 0))
    assert boundary.mesh.validity(boundary.centre).is_gamut
    return boundary, provenance["mesh"]


def cycles(mesh):
    """Faces by their positions, each from its smallest corner on."""
    corners = mesh.vertices[mesh.faces].tolist()
    return sorted(min(face[i:] + face[:i] for i in range(3)) for face in corners)


class TestRepairs:
    """Of a box with defects: all give the box again."""

    def assert_box(self, boundary):
        expected, _ = bounded(VERTICES, FACES)
        assert expected.mesh.volume == pytest.approx(48)
        assert cycles(boundary.mesh) == cycles(expected.mesh)

    @given(st.permutations(range(12)), st.lists(st.booleans(), min_size=12, max_size=12))
    @settings(max_examples=30)
    def test_loose_triangles_in_any_order_and_orientation(self, order, turned):
        """Three vertices for each triangle, as in STL."""
        mixed = np.where(np.array(turned)[:, np.newaxis], FACES[:, ::-1], FACES)
        loose = VERTICES[mixed[list(order)]].reshape(-1, 3)
        boundary, changes = bounded(loose, np.arange(36).reshape(-1, 3))
        assert changes["welded"] == 36 - 8
        assert changes["turned"] == sum(turned)
        np.testing.assert_array_equal(loose[boundary.sources], boundary.mesh.vertices)
        self.assert_box(boundary)

    def test_faces_without_area_and_unused_vertices_are_dropped(self):
        """An edge split at a vertex beside its end, with the sliver's corners welded."""
        vertices = np.vstack([VERTICES, VERTICES[0], [9.0, 9.0, 9.0]])
        boundary, changes = bounded(vertices, np.vstack([FACES, [0, 8, 3], [5, 5, 2]]))
        assert (changes["welded"], changes["unused"], changes["dropped"]) == (1, 1, 2)
        self.assert_box(boundary)

    def test_a_fin_of_two_faces_that_cover_each_other_is_dropped(self):
        boundary, changes = bounded(VERTICES, np.vstack([FACES, [0, 3, 6], [6, 3, 0]]))
        assert changes["dropped"] == 2
        self.assert_box(boundary)


def klein_bottle(size=6):
    """A grid on a square with opposite sides glued, one pair of them reversed."""

    def at(row, column):
        if row == size:
            row, column = 0, -column
        return row * size + column % size

    faces = [
        face
        for row in range(size)
        for column in range(size)
        for face in (
            (at(row, column), at(row + 1, column), at(row + 1, column + 1)),
            (at(row, column), at(row + 1, column + 1), at(row, column + 1)),
        )
    ]
    return np.random.default_rng(1).random((size * size, 3)), faces


TORUS = trimesh.creation.torus(3, 1)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (VERTICES, FACES[1:], "3 edges"),
        (VERTICES, np.vstack([FACES, [0, 3, 6]]), "more than two"),
        (
            np.vstack([VERTICES, VERTICES + 10]),
            np.vstack([FACES, FACES + 8]),
            "2 pieces; the largest has 12 of 24",
        ),
        (
            np.vstack([VERTICES, VERTICES + np.ptp(VERTICES, axis=0)]),
            np.vstack([FACES, FACES + 8]),
            "pieces|touches",
        ),
        (TORUS.vertices, TORUS.faces, "handle"),
        (*klein_bottle(), "side"),
        (np.zeros((4, 3)), [(0, 1, 2), (1, 2, 3)], "area"),
    ],
    ids=["hole", "inner wall", "two pieces", "shared vertex", "torus", "one side", "points"],
)
def test_what_is_no_closed_surface_of_genus_0_is_refused_with_the_reason(vertices, faces, message):
    with pytest.raises(MeshError, match=message) as caught:
        bounded(vertices, faces)
    assert caught.value.remedy
    if message == "3 edges":
        # the vertex is one of the missing face's
        assert caught.value.where["vertex"] in FACES[0]
    if message == "handle":
        assert caught.value.where["handles"] == 1
