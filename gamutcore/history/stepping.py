"""Levels of a history: read from a finer one, or stepped through in place.

A split writes the new positions of the parent and of neighbours that move, and the position of the
new slot. It writes the new slot into the corners that pass to it, and adds two faces. A collapse
writes the old positions and the parent back into the same corners. Slots and faces behind the end
of a level are not part of it. `level_from_snapshot` reads a level without changing the snapshot.
"""

from __future__ import annotations

from operator import attrgetter
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.arrays import Float32Array, IndexArray, ShortArray
from gamutcore.errors import TriangleCountError
from gamutcore.history.prefix_order import copy_row, part_begin
from gamutcore.kernels import inlined_kernel, kernel
from gamutcore.mesh import TriangleMesh

if TYPE_CHECKING:
    from gamutcore.history.prefix_order import Splits

__all__ = [
    "LevelCursor",
    "apply_splits",
    "fine_columns",
    "level_from_snapshot",
    "refine",
    "undo_splits",
]

# arrays one by one: numba takes three microseconds more for a tuple of them
fine_columns = attrgetter(
    "parent",
    "fine",
    "added",
    "faces",
    "moved_end",
    "moved",
    "shifted_end",
    "shifted",
    "shifted_fine",
)
"""The last arguments of `apply_splits`, from `Splits`."""

_coarse_columns = attrgetter(
    "parent", "coarse", "moved_end", "moved", "shifted_end", "shifted", "shifted_coarse"
)


def refine(
    splits: Splits, positions: Float32Array, corners: IndexArray, start: int, end: int
) -> None:
    """Split a level with `start` vertices until it has `end`, in place.

    The arrays have room for the finer level; `corners` are the slots at the corners, face by face.
    """
    apply_splits(positions, corners, start, end, *fine_columns(splits))


class LevelCursor:
    """A level that moves through its history in place.

    Parameters
    ----------
    splits : Splits
    level : TriangleMesh
        Any level of the same history.
    """

    def __init__(self, splits: Splits, level: TriangleMesh) -> None:
        self._most = splits.vertices
        self._columns = fine_columns(splits), _coarse_columns(splits)
        self._vertices = len(level.vertices)
        self._positions = np.empty((splits.vertices, 3), np.float32)
        self._faces = np.empty((2 * splits.vertices - 4, 3), np.int32)
        self._positions[: self._vertices] = level.vertices
        self._faces[: level.triangles] = level.faces
        self._corners = self._faces.reshape(-1)

    @property
    def triangles(self) -> int:
        """Triangle count of the present level."""
        return 2 * self._vertices - 4

    @property
    def mesh(self) -> TriangleMesh:
        """The present level. Its arrays are views; the next step changes them."""
        return TriangleMesh(self._positions[: self._vertices], self._faces[: self.triangles])

    def finer(self, steps: int = 1) -> None:
        """Apply the next splits.

        Raises
        ------
        TriangleCountError
            If the history has fewer splits left. The level does not change then.
        """
        self._move(self._vertices + steps)

    def coarser(self, steps: int = 1) -> None:
        """Undo the last splits.

        Raises
        ------
        TriangleCountError
            If four triangles are reached before. The level does not change then.
        """
        self._move(self._vertices - steps)

    def _move(self, vertices: int) -> None:
        if not 4 <= vertices <= self._most:
            raise TriangleCountError(
                f"a level of {2 * vertices - 4} triangles was asked for",
                where={"field": "steps"},
                remedy=f"Give a level of 4 to {2 * self._most - 4} triangles.",
            )
        fine, coarse = self._columns
        if vertices > self._vertices:
            apply_splits(self._positions, self._corners, self._vertices, vertices, *fine)
        else:
            _coarsen(self._positions, self._corners, self._vertices, vertices, *coarse)
        self._vertices = vertices


@kernel
def apply_splits(
    positions: Float32Array,
    corners: IndexArray,
    start: int,
    end: int,
    parent: IndexArray,
    fine: Float32Array,
    added: Float32Array,
    faces: IndexArray,
    moved_end: IndexArray,
    moved: IndexArray,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_fine: Float32Array,
) -> None:
    """Split a level as `refine` does, from a kernel. The last arrays are fields of `Splits`."""
    for slot in range(start, end):
        split = slot - 4
        copy_row(positions, parent[split], fine, split)
        copy_row(positions, slot, added, split)
        for index in range(part_begin(shifted_end, split), shifted_end[split]):
            copy_row(positions, shifted[index], shifted_fine, index)
        for index in range(part_begin(moved_end, split), moved_end[split]):
            corners[moved[index]] = slot
        first = 3 * (2 * slot - 4)
        for side in range(2):
            for place in range(3):
                corners[first + 3 * side + place] = faces[split, side, place]


@kernel
def _coarsen(
    positions: Float32Array,
    corners: IndexArray,
    start: int,
    end: int,
    parent: IndexArray,
    coarse: Float32Array,
    moved_end: IndexArray,
    moved: IndexArray,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_coarse: Float32Array,
) -> None:
    undo_splits(positions, 3, start, end, parent, coarse, shifted_end, shifted, shifted_coarse)
    for split in range(start - 5, end - 5, -1):
        for index in range(part_begin(moved_end, split), moved_end[split]):
            corners[moved[index]] = parent[split]


@inlined_kernel
def undo_splits(
    rows: Float32Array | ShortArray,
    columns: int,
    start: int,
    end: int,
    parent: IndexArray,
    coarse: Float32Array | ShortArray,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_coarse: Float32Array | ShortArray,
) -> None:
    """Turn the first rows of a level with `start` slots into those of the level with `end` slots.

    Rows are positions or device values. Only `end` rows are needed. With a constant number of
    columns the loops over columns are unrolled.
    """
    for split in range(start - 5, end - 5, -1):
        if parent[split] < end:
            for column in range(columns):
                rows[parent[split], column] = coarse[split, column]
        for index in range(part_begin(shifted_end, split), shifted_end[split]):
            if shifted[index] < end:
                for column in range(columns):
                    rows[shifted[index], column] = shifted_coarse[index, column]


@kernel
def level_from_snapshot(
    vertices: int,
    snapshot_positions: Float32Array,
    snapshot_faces: IndexArray,
    parent: IndexArray,
    coarse: Float32Array,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_coarse: Float32Array,
) -> tuple[Float32Array, IndexArray]:
    """Return positions and faces of a level from a snapshot of a level that is not coarser."""
    positions, start = snapshot_positions[:vertices].copy(), len(snapshot_positions)
    undo_splits(positions, 3, start, vertices, parent, coarse, shifted_end, shifted, shifted_coarse)
    faces = snapshot_faces[: 2 * vertices - 4].copy()
    corners = faces.reshape(-1)
    for corner in range(len(corners)):
        slot = corners[corner]
        if slot >= vertices:
            while slot >= vertices:
                slot = parent[slot - 4]
            corners[corner] = slot
    return positions, faces
