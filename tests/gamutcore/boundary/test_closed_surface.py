"""A closed surface from loose triangles: repairs, and refusals with their reasons."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.boundary.closed_surface import closed_surface
from gamutcore.errors import MeshError

CUBE = trimesh.creation.box((2.0, 4.0, 6.0))
VERTICES, FACES = np.asarray(CUBE.vertices, float), np.asarray(CUBE.faces, np.int64)


def test_a_sound_mesh_is_unchanged():
    surface = closed_surface(VERTICES, FACES)
    np.testing.assert_array_equal(surface.mesh.vertices, VERTICES)
    np.testing.assert_array_equal(surface.mesh.faces, FACES)
    np.testing.assert_array_equal(surface.sources, np.arange(8))
    assert surface[2:] == (0, 0, 0, 0)
    assert surface.mesh.volume == pytest.approx(48)


@given(st.randoms(use_true_random=False))
def test_loose_triangles_in_any_order_are_welded(random):
    """Three vertices for each triangle, as in STL."""
    order = list(range(12))
    random.shuffle(order)
    loose = VERTICES[FACES[order]].reshape(-1, 3)
    surface = closed_surface(loose, np.arange(36).reshape(-1, 3))
    assert surface.mesh.validity((0, 0, 0)).is_gamut
    assert surface.welded == 36 - 8
    np.testing.assert_array_equal(loose[surface.sources], surface.mesh.vertices)
    assert surface.mesh.volume == pytest.approx(48)


@given(st.lists(st.booleans(), min_size=12, max_size=12))
def test_faces_in_either_orientation_are_turned_outwards(turned):
    mixed = np.where(np.array(turned)[:, np.newaxis], FACES[:, ::-1], FACES)
    surface = closed_surface(VERTICES, mixed)
    assert surface.turned == sum(turned)
    assert surface.mesh.validity((0, 0, 0)).is_gamut
    np.testing.assert_array_equal(surface.mesh.faces, FACES)


def test_faces_without_area_and_unused_vertices_are_dropped():
    """An edge split at a vertex beside its end, with the sliver's corners welded."""
    vertices = np.vstack([VERTICES, VERTICES[0], [9.0, 9.0, 9.0]])
    faces = np.vstack([FACES, [0, 8, 3], [5, 5, 2]])
    surface = closed_surface(vertices, faces)
    assert (surface.welded, surface.unused, surface.dropped) == (1, 1, 2)
    np.testing.assert_array_equal(surface.mesh.faces, FACES)


def test_a_fin_of_two_faces_that_cover_each_other_is_dropped():
    surface = closed_surface(VERTICES, np.vstack([FACES, [0, 3, 6], [6, 3, 0]]))
    assert surface.dropped == 2
    np.testing.assert_array_equal(surface.mesh.faces, FACES)


def refusal(vertices, faces):
    with pytest.raises(MeshError) as caught:
        closed_surface(np.asarray(vertices, float), np.asarray(faces, np.int64))
    assert caught.value.remedy
    return caught.value


def test_a_hole_is_named_by_its_edges():
    error = refusal(VERTICES, FACES[1:])
    assert "3 edges" in error.message
    # the vertex is one of the missing face's
    assert error.where["vertex"] in FACES[0]


def test_an_inner_wall_is_named():
    error = refusal(VERTICES, np.vstack([FACES, [0, 3, 6]]))
    assert "more than two" in error.message


def test_two_pieces_are_counted():
    error = refusal(np.vstack([VERTICES, VERTICES + 10]), np.vstack([FACES, FACES + 8]))
    assert "2 pieces; the largest has 12 of 24" in error.message


def test_two_cubes_that_share_a_vertex_touch():
    corner = VERTICES.max(axis=0)
    other = VERTICES + (corner - VERTICES.min(axis=0))
    error = refusal(np.vstack([VERTICES, other]), np.vstack([FACES, FACES + 8]))
    assert "pieces" in error.message or "touches" in error.message


def test_a_torus_has_a_handle():
    torus = trimesh.creation.torus(3, 1)
    error = refusal(torus.vertices, torus.faces)
    assert error.where["handles"] == 1


def test_a_klein_bottle_has_one_side():
    """A grid on a square with opposite sides glued, one pair of them reversed (a Klein bottle)."""
    size = 6

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
    assert "side" in refusal(np.random.default_rng(1).random((size * size, 3)), faces).message


def test_nothing_but_points_is_refused():
    assert "area" in refusal(np.zeros((4, 3)), [(0, 1, 2), (1, 2, 3)]).message
