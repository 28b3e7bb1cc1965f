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
from gamutcore.corner_table import following, preceding, swung
from gamutcore.decimation.star import Surface
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["Record", "empty_record", "record_moved_corners", "record_shift", "write_collapse"]


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


@kernel
def record_moved_corners(
    surface: Surface, right_corner: int, moved: IndexArray, filled: int
) -> tuple[IndexArray, int]:
    """Append the corners that pass from the dead vertex to the kept one; the array may grow.

    Parameters
    ----------
    surface : Surface
        Before the collapse.
    right_corner : int
        Corner of the dead vertex in the face (dead, kept, right).
    moved : (m,) int32
    filled : int
        How much of `moved` is in use.

    Returns
    -------
    moved : (≥ m,) int32
    filled : int
    """
    kept = surface.vertex[following(right_corner)]
    corner = swung(surface.opposite, right_corner)
    while surface.vertex[preceding(corner)] != kept:
        if filled == moved.size:
            longer = np.empty(2 * moved.size, np.int32)
            longer[:filled] = moved
            moved = longer
        moved[filled] = corner
        filled += 1
        corner = swung(surface.opposite, corner)
    return moved, filled


@kernel
def record_shift(
    shifted: IndexArray,
    shift: Float32Array,
    filled: int,
    vertex: int,
    before: Float32Array,
    after: Float32Array,
) -> tuple[IndexArray, Float32Array, int]:
    """Append the move of a vertex that took no part in the collapse; the arrays may grow.

    Parameters
    ----------
    shifted : (m,) int32
    shift : (m, 2, 3) float32
    filled : int
        How much of both is in use.
    vertex : int
    before, after : (3,) float32
        Where it was and where it is.

    Returns
    -------
    shifted : (≥ m,) int32
    shift : (≥ m, 2, 3) float32
    filled : int
    """
    if filled == shifted.size:
        longer = np.empty(2 * shifted.size, np.int32)
        longer[:filled] = shifted
        shifted = longer
        longer_shift = np.empty((2 * shift.shape[0], 2, 3), np.float32)
        longer_shift[:filled] = shift
        shift = longer_shift
    shifted[filled] = vertex
    for axis in range(3):
        shift[filled, 0, axis] = before[axis]
        shift[filled, 1, axis] = after[axis]
    return shifted, shift, filled + 1
