"""The record of a decimation: every collapse, in order.

A collapse removes the `dead` vertex of an edge and the two faces at the edge, and moves the `kept`
vertex. In the finer level, the face left of the directed edge kept → dead is (kept, dead, left).
The face right of it is (dead, kept, right). Both are counter-clockwise from outside. The faces of
the dead vertex between `right` and `left` pass to the kept vertex.

Two words are kept apart here and in histories. A corner that *moves* gets another vertex. A vertex
that *shifts* gets another position; only the cost ``finest`` shifts vertices.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, IndexArray, LongArray
from gamutcore.decimation.surface_mesh import LARGEST_LINK, SurfaceMesh
from gamutcore.geometry import next_corner
from gamutcore.kernels import leaf_kernel


class Record(NamedTuple):
    """Every collapse of a boundary with V vertices.

    Attributes
    ----------
    kept, dead : (V − 4,) int32
        The vertex that stays and the vertex that is removed.
    position : (V − 4, 3, 3) float32
        The kept vertex before the collapse, the dead vertex, and the kept vertex after it.
    sides : (V − 4, 2) int32
        The vertices left and right of the edge kept → dead.
    corner : (V − 4, 2) int32
        Corner of the kept vertex in the left face, and of the dead vertex in the right face.
    moved_end : (V − 4,) int64
        End of the collapse's part of `moved`.
    moved : (≥ moved_end[-1],) int32
        Corners that pass from the dead vertex to the kept one. They are in counter-clockwise order
        around the dead vertex, from the right side to the left side.
    shifted_end : (V − 4,) int64
        End of the collapse's part of `shifted` and `shift`.
    shifted : (≥ shifted_end[-1],) int32
        Neighbours of the kept vertex that moved after the collapse, each at most once.
    shift : (≥ shifted_end[-1], 2, 3) float32
        Their positions before and after the move.
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


SHIFTS = 12
"""Room for so many shifts per vertex. About six neighbours move in a collapse."""


def empty_record(vertices: int, moved_vertices: int = 0) -> Record:
    """Return a record with room for all collapses of a boundary with `vertices` vertices.

    There is room for the shifts of usual boundaries, whose vertices move in levels of at most
    `moved_vertices` vertices.
    """
    steps, shifts = vertices - 4, SHIFTS * min(vertices, moved_vertices) + 2 * LARGEST_LINK
    return Record(
        kept=np.empty(steps, np.int32),
        dead=np.empty(steps, np.int32),
        position=np.empty((steps, 3, 3), np.float32),
        sides=np.empty((steps, 2), np.int32),
        corner=np.empty((steps, 2), np.int32),
        moved_end=np.empty(steps, np.int64),
        moved=np.empty(4 * vertices, np.int32),
        shifted_end=np.empty(steps, np.int64),
        shifted=np.empty(shifts, np.int32),
        shift=np.empty((shifts, 2, 3), np.float32),
    )


@leaf_kernel
def _end(ends: LongArray, collapses: int) -> int:
    """End of the parts of the first `collapses` collapses."""
    return int(ends[collapses - 1]) if collapses > 0 else 0


@leaf_kernel
def record_collapse(
    record: Record,
    index: int,
    surface: SurfaceMesh,
    grid_position: Float32Array,
    rounded: Float32Array,
    corner: int,
    kept: int,
    dead: int,
) -> None:
    """Record collapse number `index` of the edge that `corner` faces, before it happens.

    `grid_position` has the positions before the collapse, `rounded` that of the kept vertex after
    it. Shifts are recorded later. The record has room for the degree of the dead vertex.
    """
    record.kept[index], record.dead[index] = kept, dead
    for axis in range(3):
        record.position[index, 0, axis] = grid_position[kept, axis]
        record.position[index, 1, axis] = grid_position[dead, axis]
        record.position[index, 2, axis] = rounded[axis]
    left, right = corner, int(surface.opposite[corner])
    if surface.vertex[next_corner(left)] != kept:
        left, right = right, left
    record.sides[index, 0], record.sides[index, 1] = surface.vertex[left], surface.vertex[right]
    record.corner[index, 0], record.corner[index, 1] = next_corner(left), next_corner(right)
    filled = _end(record.moved_end, index)
    moved = int(surface.swing[next_corner(right)])
    for _ in range(surface.degree[dead] - 2):
        record.moved[filled] = moved
        filled += 1
        moved = int(surface.swing[moved])
    record.moved_end[index] = filled
    record.shifted_end[index] = _end(record.shifted_end, index)


@leaf_kernel
def record_shift(
    record: Record,
    index: int,
    vertex: int,
    before: Float32Array,
    row: int,
    grid_position: Float32Array,
) -> None:
    """Record that a vertex beside the collapsed edge moved; the record has room for it.

    `index` is the number of earlier collapses. Row `row` of `before` is the position before the
    move, and `grid_position` has the positions after it.
    """
    filled = record.shifted_end[index]
    record.shifted[filled] = vertex
    for axis in range(3):
        record.shift[filled, 0, axis] = before[row, axis]
        record.shift[filled, 1, axis] = grid_position[vertex, axis]
    record.shifted_end[index] += 1


@leaf_kernel
def has_room(record: Record, collapses: int, changes: int) -> bool:
    """Whether `changes` moved corners and as many shifts fit after `collapses` collapses."""
    return (
        _end(record.moved_end, collapses) + changes <= record.moved.size
        and _end(record.shifted_end, collapses) + changes <= record.shifted.size
    )


def extend_record(record: Record, collapses: int, changes: int) -> Record:
    """Return a record with more room, for which `has_room` holds."""
    used = trim_record(record, collapses)
    moved = np.empty(2 * record.moved.size + changes, np.int32)
    shifted = np.empty(2 * record.shifted.size + changes, np.int32)
    shift = np.empty((shifted.size, 2, 3), np.float32)
    moved[: used.moved.size], shifted[: used.shifted.size] = used.moved, used.shifted
    shift[: used.shifted.size] = used.shift
    return record._replace(moved=moved, shifted=shifted, shift=shift)


def trim_record(record: Record, collapses: int) -> Record:
    """Return the first `collapses` collapses of a record, without unused entries."""
    moved, shifts = _end(record.moved_end, collapses), _end(record.shifted_end, collapses)
    parts = {name: values[:collapses] for name, values in record._asdict().items()}
    parts.update(
        moved=record.moved[:moved], shifted=record.shifted[:shifts], shift=record.shift[:shifts]
    )
    return Record(**parts)
