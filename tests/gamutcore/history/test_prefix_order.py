"""Prefix order: slots and faces of every split agree with the collapses of the decimation."""

import numpy as np
import pytest

from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS, decimate
from gamutcore.history.prefix_order import (
    ascending_order,
    extended_copy,
    group_count,
    group_ranges,
    prefix_order_splits,
    vertex_slots,
)


@pytest.mark.parametrize("vertices", [4, 5, 7, 8, 9, 16, 17, 1000, 2**25])
def test_groups_double_the_vertices_and_leave_none_out(vertices):
    groups = group_ranges(vertices)
    assert [start for start, _ in groups] == [4 * 2**number for number in range(len(groups))]
    assert [end for _, end in groups[:-1]] == [start for start, _ in groups[1:]]
    assert (groups[-1][1] if groups else 4) == vertices


def test_a_level_needs_the_fewest_groups_that_reach_it():
    ends = [4, *(end for _, end in group_ranges(2**25))]
    near = (end + step for end in ends for step in (-1, 0, 1))
    for vertices in (*range(4, 300), *(count for count in near if 4 <= count <= 2**25)):
        groups = group_count(vertices)
        assert ends[groups] >= vertices
        assert groups == 0 or ends[groups - 1] < vertices
        assert groups == len(group_ranges(vertices))


@pytest.fixture(scope="module", params=COSTS)
def both(request, random_cloud):
    """Return a decimation and its splits."""
    boundary = modified_convex_hull(random_cloud(50, 120))
    decimation = decimate(boundary.mesh, boundary.centre, request.param)
    return decimation, prefix_order_splits(decimation, vertex_slots(decimation))


def test_types_and_shapes(both):
    decimation, splits = both
    steps = len(decimation.record.kept)
    assert splits.vertices == steps + 4
    expected = {
        "base_positions": ((4, 3), np.float32),
        "base_faces": ((4, 3), np.int32),
        "parent": ((steps,), np.int32),
        "coarse": ((steps, 3), np.float32),
        "fine": ((steps, 3), np.float32),
        "added": ((steps, 3), np.float32),
        "faces": ((steps, 2, 3), np.int32),
        "moved_end": ((steps,), np.int32),
        "shifted_end": ((steps,), np.int32),
    }
    for name, (shape, kind) in expected.items():
        array = getattr(splits, name)
        assert (array.shape, array.dtype) == (shape, kind), name
        assert array.flags.c_contiguous, name
    assert splits.moved.dtype == np.int32


def test_slots_are_numbered_by_the_reverse_order_of_death(both):
    """The last collapse is the first split: the vertex that was removed last is added first."""
    decimation, splits = both
    record = decimation.record
    np.testing.assert_array_equal(splits.added, record.position[::-1, 1])
    np.testing.assert_array_equal(splits.fine, record.position[::-1, 0])
    np.testing.assert_array_equal(splits.coarse, record.position[::-1, 2])


def test_a_split_refers_to_what_is_there_before_it(both):
    _, splits = both
    slots = np.arange(4, splits.vertices)
    assert (splits.parent >= 0).all()
    assert (splits.parent < slots).all()
    assert (splits.faces >= 0).all()
    assert (splits.faces <= slots[:, np.newaxis, np.newaxis]).all()
    start = 0
    for slot, end in zip(slots, splits.moved_end, strict=True):
        moved = splits.moved[start:end]
        assert (moved >= 0).all()
        assert (moved < 3 * (2 * slot - 4)).all()
        assert len(np.unique(moved // 3)) == len(moved)
        start = end
    assert start == len(splits.moved)


def test_both_new_faces_lie_at_the_edge_of_parent_and_new_slot(both):
    _, splits = both
    for slot, (parent, faces) in enumerate(
        zip(splits.parent.tolist(), splits.faces.tolist(), strict=True), start=4
    ):
        assert faces[0][:2] == [parent, slot]
        assert faces[1][:2] == [slot, parent]
        assert faces[0][2] != faces[1][2]


def test_corners_move_from_the_right_side_to_the_left(both):
    _, splits = both
    corners = splits.base_faces.tolist()
    start = 0
    for slot, (parent, faces) in enumerate(
        zip(splits.parent.tolist(), splits.faces.tolist(), strict=True), start=4
    ):
        (left, right), end = (faces[0][2], faces[1][2]), int(splits.moved_end[slot - 4])
        neighbour = right
        for corner in splits.moved[start:end].tolist():
            face, place = corners[corner // 3], corner % 3
            assert face[place] == parent
            assert face[(place + 1) % 3] == neighbour
            neighbour = face[(place + 2) % 3]
            face[place] = slot
        assert neighbour == left
        corners += faces
        start = end


def test_base_faces_begin_with_their_smallest_slot(both):
    _, splits = both
    assert (splits.base_faces.argmin(axis=1) == 0).all()


def test_the_base_is_a_tetrahedron(both):
    _, splits = both
    assert sorted(map(sorted, splits.base_faces.tolist())) == [
        [0, 1, 2],
        [0, 1, 3],
        [0, 2, 3],
        [1, 2, 3],
    ]


def test_the_base_positions_are_those_after_the_last_collapse(both):
    decimation, splits = both
    survivors = sorted(set(range(splits.vertices)) - set(decimation.record.dead.tolist()))
    np.testing.assert_array_equal(splits.base_positions, decimation.positions[survivors])


def test_moved_neighbours_ascend_within_their_splits():
    ends = np.array([0, 3, 3, 5], np.int32)
    slots = np.array([7, 2, 5, 9, 1], np.int32)
    order = ascending_order(ends, slots)
    assert slots[order].tolist() == [2, 5, 7, 1, 9]


def test_a_boundary_of_four_faces_has_no_splits():
    boundary = modified_convex_hull(np.vstack([np.zeros(3), np.eye(3)]))
    decimation = decimate(boundary.mesh, boundary.centre)
    splits = prefix_order_splits(decimation, vertex_slots(decimation))
    assert splits.vertices == 4
    assert [len(array) for array in splits] == [4, 4] + [0] * 11


@pytest.mark.parametrize("shape", [(0, 3), (5, 3), (5,)])
def test_an_extended_copy_keeps_the_rows_and_leaves_the_old_array_alone(shape):
    array = np.arange(np.prod(shape), dtype=np.int16).reshape(shape)
    longer = extended_copy(array, 9)
    assert (longer.shape, longer.dtype) == ((9, *shape[1:]), array.dtype)
    np.testing.assert_array_equal(longer[: len(array)], array)
    longer[:] = -1
    assert (array >= 0).all()
