"""Prefix order: vertices and faces numbered so that every level is a prefix.

Slots and faces are numbered by the reverse order of their death. The last four of each survive to
the end; slot k ≥ 4 and faces 2k − 4 and 2k − 3 are what the split to k + 1 vertices adds. The
level with v vertices is then slots [0, v) and faces [0, 2v − 4), with nothing to compact.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, IndexArray, LongArray
from gamutcore.kernels import kernel

if TYPE_CHECKING:
    from gamutcore.decimation import Decimation

__all__ = ["Splits", "ascending_in_parts", "slots_of_vertices", "splits_in_prefix_order"]


class Splits(NamedTuple):
    """A history as the splits that lead from four triangles to the full boundary.

    Row i of every array but the first two and those that are divided by an `..._end` belongs to the
    split that adds slot k = i + 4.

    Attributes
    ----------
    base_positions : (4, 3) float32
        Slots 0 to 3 at the coarsest level.
    base_faces : (4, 3) int32
        Faces 0 to 3 at the coarsest level, each from its smallest slot on.
    parent : (V − 4,) int32
        The slot < k that is split.
    coarse : (V − 4, 3) float32
        Where the parent is before the split.
    fine : (V − 4, 3) float32
        Where the parent is after it.
    added : (V − 4, 3) float32
        Where the new slot is.
    faces : (V − 4, 2, 3) int32
        The two new faces, 2k − 4 and 2k − 3: (parent, k, left) and (k, parent, right), where `left`
        and `right` are neighbours of the parent before the split.
    moved_end : (V − 4,) int32
        Where the split's part of `moved` ends; it begins where the part before it ends.
    moved : (m,) int32
        Corners (3 · face + place in the face) that pass from the parent to the new slot, in the
        order in which their faces stand around it, counter-clockwise from `right` to `left`.
    shifted_end : (V − 4,) int32
        Where the split's part of the next three ends.
    shifted : (s,) int32
        Neighbours of the parent before the split that move with it, in ascending order.
    shifted_coarse, shifted_fine : (s, 3) float32
        Where they are before and after the split.
    """

    base_positions: Float32Array
    base_faces: IndexArray
    parent: IndexArray
    coarse: Float32Array
    fine: Float32Array
    added: Float32Array
    faces: IndexArray
    moved_end: IndexArray
    moved: IndexArray
    shifted_end: IndexArray
    shifted: IndexArray
    shifted_coarse: Float32Array
    shifted_fine: Float32Array

    @property
    def vertices(self) -> int:
        """Number of vertices of the full boundary."""
        return len(self.parent) + 4

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return sum(array.nbytes for array in self)


def splits_in_prefix_order(decimation: Decimation) -> Splits:
    """Turn collapses as they happened into splits in prefix order.

    Parameters
    ----------
    decimation : Decimation

    Returns
    -------
    Splits
    """
    record = decimation.record
    steps = len(record.dead)
    slot_of = slots_of_vertices(decimation)
    survivors = np.flatnonzero(slot_of < 4)
    # where each corner goes: to its face's number, and in the face to its place after the first one
    first_corner = np.empty(2 * steps + 4, np.int32)
    face_of = np.full(2 * steps + 4, -1, np.int32)
    numbers = np.arange(2 * steps + 4, dtype=np.int32)
    face_of[(record.corner // 3).ravel()] = numbers[4:].reshape(-1, 2)[::-1].ravel()
    first_corner[(record.corner // 3).ravel()] = (record.corner % 3).ravel()
    left = np.flatnonzero(face_of < 0)
    base = slot_of[decimation.vertex.reshape(-1, 3)[left]]
    face_of[left], first_corner[left] = numbers[:4], base.argmin(axis=1)
    turned = (first_corner[left][:, np.newaxis] + np.arange(3)) % 3
    moved_end, moved = _moved_in_reverse(record.moved_end, record.moved, face_of, first_corner)
    added = np.arange(4, steps + 4, dtype=np.int32)
    parent = slot_of[record.kept[::-1]]
    sides = slot_of[record.sides[::-1]]
    new_faces = (parent, added, sides[:, 0], added, parent, sides[:, 1])
    shifted_end, order = _reversed_parts(record.shifted_end, len(record.shifted))
    order = order[ascending_in_parts(shifted_end, slot_of[record.shifted[order]])]
    return Splits(
        base_positions=decimation.positions[survivors],
        base_faces=np.take_along_axis(base, turned, axis=1),
        parent=parent,
        coarse=np.ascontiguousarray(record.position[::-1, 2]),
        fine=np.ascontiguousarray(record.position[::-1, 0]),
        added=np.ascontiguousarray(record.position[::-1, 1]),
        faces=np.stack(new_faces, axis=1).reshape(-1, 2, 3),
        moved_end=moved_end,
        moved=moved,
        shifted_end=shifted_end,
        shifted=slot_of[record.shifted[order]],
        shifted_coarse=record.shift[order, 1],
        shifted_fine=record.shift[order, 0],
    )


def slots_of_vertices(decimation: Decimation) -> IndexArray:
    """Return the slot that each vertex of the full boundary is, by the reverse order of death.

    Parameters
    ----------
    decimation : Decimation

    Returns
    -------
    (V,) int32
    """
    dead = decimation.record.dead
    slot_of = np.full(len(dead) + 4, -1, np.int32)
    slot_of[dead] = np.arange(len(dead) + 3, 3, -1, dtype=np.int32)
    slot_of[slot_of < 0] = np.arange(4, dtype=np.int32)
    return slot_of


def ascending_in_parts(ends: IndexArray, slots: IndexArray) -> LongArray:
    """Return the order in which slots ascend within each split's part.

    Parameters
    ----------
    ends : (V − 4,) int32
        Where the parts end.
    slots : (s,) int32

    Returns
    -------
    (s,) int64
    """
    part = np.repeat(np.arange(len(ends)), np.diff(ends, prepend=0))
    return np.lexsort((slots, part))


@kernel
def _reversed_parts(ends: LongArray, count: int) -> tuple[IndexArray, IndexArray]:
    """Ends of parts in the reverse order of the parts, and the order of what they hold."""
    steps = len(ends)
    reversed_ends, order = np.empty(steps, np.int32), np.empty(count, np.int32)
    filled = 0
    for split in range(steps):
        step = steps - 1 - split
        for index in range(ends[step - 1] if step > 0 else 0, ends[step]):
            order[filled] = index
            filled += 1
        reversed_ends[split] = filled
    return reversed_ends, order


@kernel
def _moved_in_reverse(
    moved_end: LongArray, moved: IndexArray, face_of: IndexArray, first_corner: IndexArray
) -> tuple[IndexArray, IndexArray]:
    ends, order = _reversed_parts(moved_end, moved.size)
    reordered = np.empty(moved.size, np.int32)
    for index in range(moved.size):
        face, place = divmod(moved[order[index]], 3)
        reordered[index] = 3 * face_of[face] + (place - first_corner[face]) % 3
    return ends, reordered
