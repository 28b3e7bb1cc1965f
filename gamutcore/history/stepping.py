"""Levels of a history: read from a finer one, or stepped through in place.

A split writes the new position of the parent, the position of the new slot, the positions of
neighbours that move, the new slot into the corners that pass to it, and two faces. A collapse
writes the old positions and the parent back into the same corners. Slots and faces behind the end
of a level are not part of it. `level_from_snapshot` reads a level without changing the snapshot.
"""

from __future__ import annotations

from operator import attrgetter
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.arrays import Float32Array, IndexArray
from gamutcore.errors import TriangleCountError
from gamutcore.kernels import inlined_kernel, kernel
from gamutcore.mesh import TriangleMesh

if TYPE_CHECKING:
    from gamutcore.history.prefix_order import Splits

__all__ = ["LevelCursor", "level_from_snapshot", "refine"]

# arrays one by one: numba takes three microseconds more for a tuple of them
_fine_columns = attrgetter(
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
_coarse_columns = attrgetter(
    "parent", "coarse", "moved_end", "moved", "shifted_end", "shifted", "shifted_coarse"
)


def refine(
    splits: Splits, positions: Float32Array, corners: IndexArray, start: int, end: int
) -> None:
    """Split a level with `start` vertices until it has `end`, in place.

    Parameters
    ----------
    splits : Splits
    positions : (≥ end, 3) float32
    corners : (≥ 6 end − 12,) int32
        Slots at the corners of all faces, face by face.
    start, end : int
    """
    _refine(positions, corners, start, end, *_fine_columns(splits))


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
        self._columns = _fine_columns(splits), _coarse_columns(splits)
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
                remedy=f"levels of 4 to {2 * self._most - 4} triangles",
            )
        fine, coarse = self._columns
        if vertices > self._vertices:
            _refine(self._positions, self._corners, self._vertices, vertices, *fine)
        else:
            _coarsen(self._positions, self._corners, self._vertices, vertices, *coarse)
        self._vertices = vertices


@inlined_kernel
def _set_positions(
    positions: Float32Array, ends: IndexArray, split: int, slots: IndexArray, values: Float32Array
) -> None:
    """Write the positions of the neighbours that a split moves."""
    for index in range(ends[split - 1] if split > 0 else 0, ends[split]):
        for axis in range(3):
            positions[slots[index], axis] = values[index, axis]


@kernel
def _refine(
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
    shifted_positions: Float32Array,
) -> None:
    for slot in range(start, end):
        split = slot - 4
        above = parent[split]
        for axis in range(3):
            positions[above, axis] = fine[split, axis]
            positions[slot, axis] = added[split, axis]
        _set_positions(positions, shifted_end, split, shifted, shifted_positions)
        for index in range(moved_end[split - 1] if split > 0 else 0, moved_end[split]):
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
    shifted_positions: Float32Array,
) -> None:
    for slot in range(start - 1, end - 1, -1):
        split = slot - 4
        above = parent[split]
        for axis in range(3):
            positions[above, axis] = coarse[split, axis]
        _set_positions(positions, shifted_end, split, shifted, shifted_positions)
        for index in range(moved_end[split - 1] if split > 0 else 0, moved_end[split]):
            corners[moved[index]] = above


@kernel
def level_from_snapshot(
    vertices: int,
    snapshot_vertices: int,
    snapshot_positions: Float32Array,
    snapshot_faces: IndexArray,
    parent: IndexArray,
    coarse: Float32Array,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_coarse: Float32Array,
) -> tuple[Float32Array, IndexArray]:
    """Read a level from a snapshot of a level that is not coarser.

    Parameters
    ----------
    vertices : int
        Vertices of the level.
    snapshot_vertices : int
    snapshot_positions : (snapshot_vertices, 3) float32
    snapshot_faces : (2 snapshot_vertices − 4, 3) int32
    parent, coarse, shifted_end, shifted, shifted_coarse
        Fields of `Splits`, with rows up to the snapshot.

    Returns
    -------
    positions : (vertices, 3) float32
    faces : (2 vertices − 4, 3) int32
    """
    positions = snapshot_positions[:vertices].copy()
    for slot in range(snapshot_vertices - 1, vertices - 1, -1):
        above = parent[slot - 4]
        if above < vertices:
            for axis in range(3):
                positions[above, axis] = coarse[slot - 4, axis]
        for index in range(shifted_end[slot - 5] if slot > 4 else 0, shifted_end[slot - 4]):
            if shifted[index] < vertices:
                for axis in range(3):
                    positions[shifted[index], axis] = shifted_coarse[index, axis]
    faces = np.empty((2 * vertices - 4, 3), np.int32)
    for face in range(len(faces)):
        for place in range(3):
            slot = snapshot_faces[face, place]
            while slot >= vertices:
                slot = parent[slot - 4]
            faces[face, place] = slot
    return positions, faces
