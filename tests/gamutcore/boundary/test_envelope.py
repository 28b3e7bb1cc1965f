"""The envelope against exact unions of solids, and against radii by brute force."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.boundary.envelope import radial_envelope
from gamutcore.grid import grid_step, nearest_grid_points
from gamutcore.mesh import TriangleMesh


def divided_box(size, times, angles=(0.0, 0.0, 0.0)):
    mesh = trimesh.creation.box(size)
    for _ in range(times):
        mesh = mesh.subdivide()
    mesh.apply_transform(trimesh.transformations.euler_matrix(*angles))
    return mesh


def envelope_of(*meshes):
    """The envelope around the origin, and its step."""
    points = np.vstack([mesh.vertices for mesh in meshes])
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    corners = np.vstack([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)])
    step = grid_step(points)
    position = nearest_grid_points(points, step)
    envelope = radial_envelope(position, corners.astype(np.int32), step)
    return envelope, position, step


def used(envelope):
    """The envelope as a mesh of its vertices only."""
    rows, faces = np.unique(envelope.faces, return_inverse=True)
    return TriangleMesh(envelope.position[rows], faces.reshape(-1, 3).astype(np.int32))


@given(st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(0.6, 1.6)] * 3), st.integers(2, 4))
@pytest.mark.slow
def test_two_boxes_that_cross_make_their_union(angles, size, times):
    one, two = divided_box((2, 2, 2), times), divided_box(2 * np.array(size), times, angles)
    envelope, _, _ = envelope_of(one, two)
    mesh = used(envelope)
    assert mesh.validity(np.zeros(3)).is_gamut
    union = trimesh.boolean.union([one, two], engine="manifold")
    # edges shorter than the cells of the boxes are not followed: their volume falls with the cell
    assert mesh.volume == pytest.approx(union.volume, rel=0.03 / 4 ** (times - 2))


def test_crossing_vertices_are_on_the_lines_between_points():
    envelope, position, step = envelope_of(
        divided_box((2, 2, 2), 3), divided_box((3, 1.5, 1.6), 3, (0.3, 0.5, 0.7))
    )
    assert (envelope.share > 0).any()
    start, end = position[envelope.ends[:, 0]], position[envelope.ends[:, 1]]
    between = start + envelope.share[:, np.newaxis] * (end - start)
    assert np.abs(between - envelope.position).max() <= step / 2


def test_what_is_inside_does_not_matter():
    outer = trimesh.creation.icosphere(4, 10.0)
    alone, _, _ = envelope_of(outer)
    inner = trimesh.creation.icosphere(3, 5.0)
    both, _, _ = envelope_of(outer, inner)
    np.testing.assert_array_equal(used(alone).faces, used(both).faces)
    assert used(both).volume == pytest.approx(outer.volume, rel=1e-6)


def test_equal_surfaces_count_once():
    outer = trimesh.creation.icosphere(4, 10.0)
    twice, _, _ = envelope_of(outer, outer)
    assert used(twice).triangles == len(outer.faces)


def test_a_centre_outside_gives_no_faces():
    sphere = trimesh.creation.icosphere(3, 1.0)
    sphere.apply_translation((5, 0, 0))
    envelope, _, _ = envelope_of(sphere)
    assert len(envelope.faces) == 0


def test_reruns_are_identical():
    meshes = divided_box((2, 2, 2), 3), divided_box((3, 1.5, 1.6), 3, (0.3, 0.5, 0.7))
    (one, _, _), (two, _, _) = envelope_of(*meshes), envelope_of(*meshes)
    for first, second in zip(one, two, strict=True):
        np.testing.assert_array_equal(first, second)
