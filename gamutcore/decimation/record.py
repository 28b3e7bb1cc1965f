"""The record of a decimation: every collapse, in the order in which it happened.

A collapse removes the `dead` vertex of an edge and the two faces at the edge, and moves the `kept`
one. Seen from the finer level, the face on the left of the directed edge kept → dead is (kept,
dead, left), the one on its right (dead, kept, right), both counter-clockwise from outside. The
faces of the dead vertex between `right` and `left` pass to the kept one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, IndexArray, LongArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.star import Surface
from gamutcore.kernels import kernel, leaf_kernel

__all__ = [
    "Record",
    "empty_record",
    "has_room",
    "in_use",
    "record_moved_corners",
    "record_shift",
    "with_room",
    "write_collapse",
]


class Record(NamedTuple):
    """Every collapse of a boundary with V vertices.

    Attributes
    ----------
    kept, dead : (V − 4,) int32
        The vertex that stays and the one that goes.
    position : (V − 4, 3, 3) float32
        Where the kept vertex was, where the dead one was, where the kept one is after it.
    sides : (V − 4, 2) int32
        The vertices left and right of the edge kept → dead.
    corner : (V − 4, 2) int32
        Corner of the kept vertex in the left face that goes, of the dead one in the right face.
    moved_end : (V − 4,) int64
        Where this collapse's part of `moved` ends.
    moved : (≥ moved_end[-1],) int32
        Corners that pass from the dead vertex to the kept one, counter-clockwise around the dead
        one from the right side to the left.
    shifted_end : (V − 4,) int64
        Where this collapse's part of the next two ends.
    shifted : (≥ shifted_end[-1],) int32
        Neighbours of the kept vertex that were moved after the collapse, each at most once.
    shift : (≥ shifted_end[-1], 2, 3) float32
        Where they were and where they are after it.
    """

    kept: IndexArray
    dead: IndexArray
    position: Float32Array
    sides: IndexArray
    corner: IndexArray
    moved_end: LongArray
    moved: IndexArray
    shifted_end: LongArray
    shifted: IndexArray
    shift: Float32Array


def empty_record(vertices: int) -> Record:
    """Return a record with room for all collapses of so many vertices."""
    steps = vertices - 4
    return Record(
        kept=np.empty(steps, np.int32),
        dead=np.empty(steps, np.int32),
        position=np.empty((steps, 3, 3), np.float32),
        sides=np.empty((steps, 2), np.int32),
        corner=np.empty((steps, 2), np.int32),
        moved_end=np.empty(steps, np.int64),
        moved=np.empty(4 * vertices, np.int32),
        shifted_end=np.empty(steps, np.int64),
        shifted=np.empty(16, np.int32),
        shift=np.empty((16, 2, 3), np.float32),
    )


@leaf_kernel
def write_collapse(
    record: Record,
    index: int,
    surface: Surface,
    delivered: Float32Array,
    rounded: Float32Array,
    corner: int,
    kept: int,
    dead: int,
) -> None:
    """Write down a collapse, all but its moved corners and shifts, before it happens.

    Parameters
    ----------
    record : Record
    index : int
        How many collapses there were before.
    surface : Surface
    delivered : (V, 3) float32
        Positions before the collapse.
    rounded : (3,) float32
        Position of the kept vertex after it.
    corner : int
        One of the two corners that face the edge.
    kept, dead : int
    """
    record.kept[index], record.dead[index] = kept, dead
    for axis in range(3):
        record.position[index, 0, axis] = delivered[kept, axis]
        record.position[index, 1, axis] = delivered[dead, axis]
        record.position[index, 2, axis] = rounded[axis]
    left, right = corner, surface.opposite[corner]
    if surface.vertex[following(left)] != kept:
        left, right = right, left
    record.sides[index, 0], record.sides[index, 1] = surface.vertex[left], surface.vertex[right]
    record.corner[index, 0], record.corner[index, 1] = following(left), following(right)


@leaf_kernel
def record_moved_corners(surface: Surface, right_corner: int, record: Record, filled: int) -> int:
    """Append the corners that pass from the dead vertex to the kept one; there must be room.

    Parameters
    ----------
    surface : Surface
        Before the collapse.
    right_corner : int
        Corner of the dead vertex in the face (dead, kept, right).
    record : Record
    filled : int
        How much of `record.moved` is in use.

    Returns
    -------
    int
        How much of it is then.
    """
    kept = surface.vertex[following(right_corner)]
    corner = surface.swung[right_corner]
    while surface.vertex[preceding(corner)] != kept:
        record.moved[filled] = corner
        filled += 1
        corner = surface.swung[corner]
    return filled


@leaf_kernel
def record_shift(
    record: Record,
    filled: int,
    vertex: int,
    before: Float32Array,
    row: int,
    delivered: Float32Array,
) -> None:
    """Write down the move of a vertex that took no part in the collapse; there must be room.

    Parameters
    ----------
    record : Record
    filled : int
        How much of `record.shifted` is in use.
    vertex : int
    before : (n, 3) float32
        Where it was, in one of the rows.
    row : int
    delivered : (V, 3) float32
        Where it is.
    """
    record.shifted[filled] = vertex
    for axis in range(3):
        record.shift[filled, 0, axis] = before[row, axis]
        record.shift[filled, 1, axis] = delivered[vertex, axis]


@leaf_kernel
def has_room(record: Record, collapses: int, changes: int) -> bool:
    """Whether so many moved corners, and so many shifts, can be written after so many collapses."""
    if collapses == 0:
        return min(record.moved.size, record.shifted.size) >= changes
    return (
        record.moved_end[collapses - 1] + changes <= record.moved.size
        and record.shifted_end[collapses - 1] + changes <= record.shifted.size
    )


@kernel
def with_room(record: Record, collapses: int, changes: int) -> Record:
    """Return a record for which `has_room` holds: with longer arrays where they are too short."""
    moved, shifted, shift = record.moved, record.shifted, record.shift
    in_use = record.moved_end[collapses - 1] if collapses > 0 else 0
    if in_use + changes > moved.size:
        moved = np.empty(2 * moved.size + changes, np.int32)
        moved[:in_use] = record.moved[:in_use]
    in_use = record.shifted_end[collapses - 1] if collapses > 0 else 0
    if in_use + changes > shifted.size:
        shifted = np.empty(2 * shifted.size + changes, np.int32)
        shift = np.empty((shifted.size, 2, 3), np.float32)
        shifted[:in_use] = record.shifted[:in_use]
        shift[:in_use] = record.shift[:in_use]
    return Record(
        record.kept,
        record.dead,
        record.position,
        record.sides,
        record.corner,
        record.moved_end,
        moved,
        record.shifted_end,
        shifted,
        shift,
    )


@kernel
def in_use(record: Record, collapses: int) -> Record:
    """Return a record of so many collapses without the room that is left."""
    moved = record.moved_end[collapses - 1] if collapses > 0 else 0
    shifts = record.shifted_end[collapses - 1] if collapses > 0 else 0
    return Record(
        record.kept[:collapses],
        record.dead[:collapses],
        record.position[:collapses],
        record.sides[:collapses],
        record.corner[:collapses],
        record.moved_end[:collapses],
        record.moved[:moved],
        record.shifted_end[:collapses],
        record.shifted[:shifts],
        record.shift[:shifts],
    )
