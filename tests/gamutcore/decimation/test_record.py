"""The record of a decimation, replayed by renaming vertices in plain Python lists."""

import numpy as np
import pytest

from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS, decimate
from gamutcore.decimation.record import (
    empty_record,
    extend_record,
    has_room,
    record_collapse,
    record_shift,
    trim_record,
)


@pytest.fixture(scope="module", params=COSTS)
def run(request, random_cloud):
    """Return a boundary and its decimation."""
    boundary = modified_convex_hull(random_cloud(20, 150))
    return boundary.mesh, decimate(boundary.mesh, boundary.centre, request.param)


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
    """Return the corners at a vertex between two neighbours, counter-clockwise.

    Seen from outside, without the two faces that contain both vertices of the edge.
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


def test_moved_corners_are_those_of_the_dead_vertex(surface_from, bumpy_mesh):
    positions, faces = bumpy_mesh(3)
    surface, record = surface_from(positions, faces), empty_record(len(positions))
    kept, dead = (int(vertex) for vertex in faces[0][[1, 0]])
    expected = {
        3 * number + face.index(dead)
        for number, face in enumerate(faces.tolist())
        if dead in face and kept not in face
    }
    # an earlier collapse has one moved corner; corner 2 faces the edge
    record.moved[0], record.moved_end[0], record.shifted_end[0] = 77, 1, 0
    delivered = positions.astype(np.float32)
    record_collapse(record, 1, surface, delivered, delivered[kept], 2, kept, dead)
    filled = int(record.moved_end[1])
    assert record.moved[0] == 77
    assert set(record.moved[1:filled].tolist()) == expected
    assert filled == 1 + len(expected)
    assert record.shifted_end[1] == 0


@pytest.fixture
def partly_filled():
    """Return a record of three collapses of ten vertices: 7 moved corners, 5 shifts."""
    record = empty_record(10)
    record.moved_end[:3], record.shifted_end[:3] = (2, 4, 7), (0, 2, 5)
    record.moved[:7] = np.arange(7)
    delivered = np.arange(30, dtype=np.float32).reshape(10, 3)
    record.shifted_end[2] = 0
    for number, vertex in enumerate((3, 1, 4, 0, 5)):
        record_shift(record, 2, vertex, -delivered, 9 - number, delivered)
    assert record.shifted_end[2] == 5
    return record


def test_has_room_compares_with_the_length(partly_filled):
    assert len(partly_filled.moved) == 40
    few = partly_filled._replace(shifted=partly_filled.shifted[:16])
    assert [has_room(few, 3, changes) for changes in (1, 11, 12)] == [True, True, False]
    assert [has_room(few, 0, changes) for changes in (16, 17)] == [True, False]
    scarce = partly_filled._replace(moved=partly_filled.moved[:9])
    assert [has_room(scarce, 3, changes) for changes in (2, 3)] == [True, False]


@pytest.mark.parametrize("changes", [1, 12, 34, 1000])
def test_an_extended_record_has_room(partly_filled, changes):
    longer = extend_record(partly_filled, 3, changes)
    assert has_room(longer, 3, changes)
    assert_same_in_use(trim_record(longer, 3))


def assert_same_in_use(record):
    assert record.moved.tolist() == list(range(7))
    assert record.shifted.tolist() == [3, 1, 4, 0, 5]
    delivered = np.arange(30, dtype=np.float32).reshape(10, 3)
    np.testing.assert_array_equal(record.shift[:, 0], -delivered[[9, 8, 7, 6, 5]])
    np.testing.assert_array_equal(record.shift[:, 1], delivered[record.shifted])


def test_a_trimmed_record_has_no_unused_entries(partly_filled):
    assert_same_in_use(trim_record(partly_filled, 3))
    nothing = trim_record(partly_filled, 0)
    assert len(nothing.moved) == len(nothing.shifted) == len(nothing.shift) == 0
