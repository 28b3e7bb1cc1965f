"""The decimation kernel: its record is replayed by renaming vertices in plain Python lists."""

import numpy as np
import pytest

from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS, decimated
from gamutcore.decimation.collapse import _moved_corners


@pytest.fixture(scope="module", params=COSTS)
def run(request, random_cloud):
    """Return a boundary and its decimation."""
    boundary = modified_convex_hull(random_cloud(20, 150))
    return boundary.mesh, decimated(boundary.mesh, boundary.centre, request.param)


def degree(faces, vertex):
    return sum(vertex in face for face in faces.values())


class TestSurface:
    def test_every_corner_faces_the_edge_of_the_other_two(self, surface_from, bumpy_mesh, edges_of):
        positions, faces = bumpy_mesh(3)
        surface = surface_from(positions, faces)
        edges = edges_of(faces)
        assert len(surface.corner_facing) == len(edges) == 3 * len(faces) // 2
        named = {}
        for corner, edge in enumerate(surface.edge_of.tolist()):
            face = faces[corner // 3].tolist()
            del face[corner % 3]
            assert named.setdefault(edge, tuple(sorted(face))) == tuple(sorted(face))
        assert sorted(named.values()) == edges
        for edge, corner in enumerate(surface.corner_facing.tolist()):
            assert surface.edge_of[corner] == edge
        for vertex, corner in enumerate(surface.corner_at.tolist()):
            assert surface.vertex[corner] == vertex

    def test_its_arrays_are_its_own(self, surface_from, bumpy_mesh):
        positions, faces = bumpy_mesh(3)
        surface = surface_from(positions, faces)
        assert not np.shares_memory(surface.position, positions)
        assert not np.shares_memory(surface.vertex, faces)


class TestRecord:
    def test_is_a_sequence_of_edge_collapses(self, run):
        mesh, decimation = run
        record = decimation.record
        faces = dict(enumerate(mesh.faces.tolist()))
        positions = mesh.vertices.copy()
        start = 0
        for step, (kept, dead) in enumerate(
            zip(record.kept.tolist(), record.dead.tolist(), strict=True)
        ):
            np.testing.assert_array_equal(record.position[step, 0], positions[kept])
            np.testing.assert_array_equal(record.position[step, 1], positions[dead])
            vanishing = {n for n, face in faces.items() if kept in face and dead in face}
            assert vanishing == set(record.face[step].tolist())
            for side in range(2):
                assert record.face_corners[step, side].tolist() == faces[record.face[step, side]]
            moved = {
                3 * number + face.index(dead)
                for number, face in faces.items()
                if dead in face and number not in vanishing
            }
            end = int(record.moved_end[step])
            assert set(record.moved[start:end].tolist()) == moved
            assert end - start == len(moved)
            assert degree(faces, dead) <= degree(faces, kept)
            for number in vanishing:
                del faces[number]
            for corner in moved:
                faces[corner // 3][corner % 3] = kept
            positions[kept] = record.position[step, 2]
            start = end
        assert start == len(record.moved)
        assert len(faces) == 4
        for number, face in faces.items():
            assert decimation.vertex[3 * number : 3 * number + 3].tolist() == face
            np.testing.assert_array_equal(decimation.positions[face], positions[face])

    def test_every_vertex_dies_at_most_once_and_four_never(self, run):
        mesh, decimation = run
        dead = decimation.record.dead
        assert len(set(dead.tolist())) == len(dead) == len(mesh.vertices) - 4
        assert len(set(decimation.record.face.ravel().tolist())) == mesh.triangles - 4


def test_moved_corners_may_outgrow_their_room(surface_from, bumpy_mesh):
    positions, faces = bumpy_mesh(3)
    surface = surface_from(positions, faces)
    kept, dead = (int(vertex) for vertex in faces[0][:2])
    expected = {
        3 * number + face.index(dead)
        for number, face in enumerate(faces.tolist())
        if dead in face and kept not in face
    }
    moved, filled = _moved_corners(surface, kept, dead, np.array([77], np.int32), 1)
    assert moved[0] == 77
    assert set(moved[1:filled].tolist()) == expected
    assert filled == 1 + len(expected) <= len(moved)
