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

__all__ = ["Splits", "splits_in_prefix_order"]


class Splits(NamedTuple):
    """A history as the splits that lead from four triangles to the full boundary.

    Row i of every array but the first two belongs to the split that adds slot k = i + 4.

    Attributes
    ----------
    base_positions : (4, 3) float32
        Slots 0 to 3 at the coarsest level.
    base_faces : (4, 3) int32
        Faces 0 to 3 at the coarsest level.
    parent : (V − 4,) int32
        The slot < k that is split.
    coarse : (V − 4, 3) float32
        Where the parent is before the split.
    fine : (V − 4, 3) float32
        Where the parent is after it.
    added : (V − 4, 3) float32
        Where the new slot is.
    faces : (V − 4, 2, 3) int32
        The two new faces, 2k − 4 and 2k − 3.
    moved_end : (V − 4,) int32
        Where the split's part of `moved` ends; it begins where the part before it ends.
    moved : (m,) int32
        Corners (3 · face + place in the face) that pass from the parent to the new slot.
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

    @property
    def vertices(self) -> int:
        """Number of vertices of the full boundary."""
        return len(self.parent) + 4


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
    slot_of = np.full(steps + 4, -1, np.int32)
    slot_of[record.dead] = np.arange(steps + 3, 3, -1, dtype=np.int32)
    survivors = np.flatnonzero(slot_of < 0)
    slot_of[survivors] = np.arange(4, dtype=np.int32)
    face_of = np.full(2 * steps + 4, -1, np.int32)
    face_of[record.face.ravel()] = (
        np.arange(2 * steps + 4, dtype=np.int32)[4:].reshape(-1, 2)[::-1].ravel()
    )
    left = np.flatnonzero(face_of < 0)
    face_of[left] = np.arange(4, dtype=np.int32)
    moved_end, moved = _moved_in_reverse(record.moved_end, record.moved, face_of)
    return Splits(
        base_positions=decimation.positions[survivors],
        base_faces=slot_of[decimation.vertex.reshape(-1, 3)[left]],
        parent=slot_of[record.kept[::-1]],
        coarse=np.ascontiguousarray(record.position[::-1, 2]),
        fine=np.ascontiguousarray(record.position[::-1, 0]),
        added=np.ascontiguousarray(record.position[::-1, 1]),
        faces=slot_of[record.face_corners[::-1]],
        moved_end=moved_end,
        moved=moved,
    )


@kernel
def _moved_in_reverse(
    moved_end: LongArray, moved: IndexArray, face_of: IndexArray
) -> tuple[IndexArray, IndexArray]:
    steps = len(moved_end)
    ends, reordered = np.empty(steps, np.int32), np.empty(moved.size, np.int32)
    filled = 0
    for split in range(steps):
        step = steps - 1 - split
        for index in range(moved_end[step - 1] if step > 0 else 0, moved_end[step]):
            corner = moved[index]
            reordered[filled] = 3 * face_of[corner // 3] + corner % 3
            filled += 1
        ends[split] = filled
    return ends, reordered
