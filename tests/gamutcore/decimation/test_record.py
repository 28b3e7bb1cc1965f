"""The record of a decimation, replayed by renaming vertices in plain Python lists."""

import numpy as np
import pytest

from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS, decimated
from gamutcore.decimation.record import record_moved_corners, record_shift


@pytest.fixture(scope="module", params=COSTS)
def run(request, random_cloud):
    """Return a boundary and its decimation."""
    boundary = modified_convex_hull(random_cloud(20, 150))
    return boundary.mesh, decimated(boundary.mesh, boundary.centre, request.param)


def degree(faces, vertex):
    return sum(vertex in face for face in faces.values())


class TestRecord:
    def test_is_a_sequence_of_edge_collapses_and_shifts(self, run):
        mesh, decimation = run
        record = decimation.record
        faces = dict(enumerate(mesh.faces.tolist()))
        positions = mesh.vertices.copy()
        start = shift_start = 0
        for step, (kept, dead) in enumerate(
            zip(record.kept.tolist(), record.dead.tolist(), strict=True)
        ):
            np.testing.assert_array_equal(record.position[step, 0], positions[kept])
            np.testing.assert_array_equal(record.position[step, 1], positions[dead])
            vanishing = {n for n, face in faces.items() if kept in face and dead in face}
            left, right = record.sides[step].tolist()
            for corner, expected in zip(
                record.corner[step].tolist(), [(kept, dead, left), (dead, kept, right)], strict=True
            ):
                face = faces[corner // 3]
                assert tuple(face[(corner + place) % 3] for place in range(3)) == expected
                vanishing.remove(corner // 3)
            assert not vanishing
            moved = counter_clockwise(faces, dead, right, left)
            end = int(record.moved_end[step])
            assert record.moved[start:end].tolist() == moved
            assert degree(faces, dead) <= degree(faces, kept)
            for corner in record.corner[step].tolist():
                del faces[corner // 3]
            for corner in moved:
                faces[corner // 3][corner % 3] = kept
            positions[kept] = record.position[step, 2]
            shift_end = int(record.shifted_end[step])
            shifted = record.shifted[shift_start:shift_end].tolist()
            assert len(set(shifted)) == len(shifted)
            around = {vertex for face in faces.values() if kept in face for vertex in face} - {kept}
            assert set(shifted) <= around
            for index, vertex in enumerate(shifted, shift_start):
                np.testing.assert_array_equal(record.shift[index, 0], positions[vertex])
                positions[vertex] = record.shift[index, 1]
            start, shift_start = end, shift_end
        assert start == len(record.moved)
        assert shift_start == len(record.shifted)
        assert len(faces) == 4
        for number, face in faces.items():
            assert decimation.vertex[3 * number : 3 * number + 3].tolist() == face
            np.testing.assert_array_equal(decimation.positions[face], positions[face])

    def test_every_vertex_dies_at_most_once_and_four_never(self, run):
        mesh, decimation = run
        dead = decimation.record.dead
        assert len(set(dead.tolist())) == len(dead) == len(mesh.vertices) - 4
        gone = decimation.record.corner // 3
        assert len(set(gone.ravel().tolist())) == mesh.triangles - 4


def counter_clockwise(faces, vertex, start, end):
    """Return the corners at a vertex from the face after a neighbour on to the one before another.

    Seen from outside, and without the two faces that name both.
    """
    follower = {}
    for number, face in faces.items():
        if vertex in face:
            place = face.index(vertex)
            follower[face[(place + 1) % 3]] = (3 * number + place, face[(place + 2) % 3])
    corners, neighbour = [], start
    while neighbour != end:
        corner, neighbour = follower[neighbour]
        corners.append(corner)
    return corners


def test_moved_corners_may_outgrow_their_room(surface_from, bumpy_mesh):
    positions, faces = bumpy_mesh(3)
    surface = surface_from(positions, faces)
    kept, dead = (int(vertex) for vertex in faces[0][[1, 0]])
    expected = {
        3 * number + face.index(dead)
        for number, face in enumerate(faces.tolist())
        if dead in face and kept not in face
    }
    # corner 0 is that of the dead vertex in the face (dead, kept, right)
    moved, filled = record_moved_corners(surface, 0, np.array([77], np.int32), 1)
    assert moved[0] == 77
    assert set(moved[1:filled].tolist()) == expected
    assert filled == 1 + len(expected) <= len(moved)


def test_shifts_may_outgrow_their_room():
    delivered = np.arange(30, dtype=np.float32).reshape(10, 3)
    shifted, shift, filled = np.empty(1, np.int32), np.empty((1, 2, 3), np.float32), 0
    for vertex in range(10):
        place = np.full(3, -vertex, np.float32)
        shifted, shift, filled = record_shift(
            shifted, shift, filled, vertex, delivered[vertex], place
        )
    assert filled == 10 <= len(shifted) == len(shift)
    assert shifted[:10].tolist() == list(range(10))
    np.testing.assert_array_equal(shift[:10, 0], delivered)
    np.testing.assert_array_equal(shift[:10, 1, 2], -np.arange(10))
