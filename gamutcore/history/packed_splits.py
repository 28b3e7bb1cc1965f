"""The splits of a history file, unpacked group by group when a level needs them.

Each group is checked while it is unpacked: every level that it leads to is closed and star-shaped
about the centre. Groups that nobody asks for cost nothing but the bytes of their streams.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.errors import HistoryFileError
from gamutcore.history.prefix_order import Splits, ascending_order
from gamutcore.history.rings import first_replay, larger_replay
from gamutcore.history.split_codes import first_contexts
from gamutcore.history.split_reader import FAULTS, MOVED, SHIFTED, read_group
from gamutcore.history.streams import DAMAGE_REMEDY, SPLITS, Streams, extended_copy

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gamutcore.arrays import ByteArray, FloatArray, IndexArray

__all__ = ["PackedSplits"]

ROWS = ("parent", "coarse", "fine", "added", "faces", "moved_end", "shifted_end")
"""Fields of `Splits` with one row per split."""


class PackedSplits:
    """The splits of a history file.

    Parameters
    ----------
    streams : sequence of (n,) uint8
        One per group; each is long enough for its splits.
    positions : (4, 3) int32
        Coarsest level, in steps.
    faces : (4, 3) int32
        Coarsest level: a tetrahedron around the centre.
    vertices : int
        Vertices of the full boundary.
    centre : (3,) float64
    step : float

    Attributes
    ----------
    streams : Streams
    splits : Splits
        The unpacked splits. `moved` and the `shifted` arrays have spare room until all groups are
        unpacked. Unpacking never changes rows in use.
    """

    def __init__(
        self,
        streams: Sequence[ByteArray],
        positions: IndexArray,
        faces: IndexArray,
        vertices: int,
        centre: FloatArray,
        step: float,
    ) -> None:
        self.streams = Streams(SPLITS, streams, vertices)
        self.splits = Splits(
            base_positions=(positions * step).astype(np.float32),
            base_faces=faces,
            parent=np.empty(0, np.int32),
            coarse=np.empty((0, 3), np.float32),
            fine=np.empty((0, 3), np.float32),
            added=np.empty((0, 3), np.float32),
            faces=np.empty((0, 2, 3), np.int32),
            moved_end=np.empty(0, np.int32),
            moved=np.empty(0, np.int32),
            shifted_end=np.empty(0, np.int32),
            shifted=np.empty(0, np.int32),
            shifted_coarse=np.empty((0, 3), np.float32),
            shifted_fine=np.empty((0, 3), np.float32),
        )
        self._used = np.zeros(2, np.int64)
        self._centre, self._step = centre, step
        self._replay = first_replay(positions, faces)
        self._contexts = first_contexts()

    @property
    def nbytes(self) -> int:
        """Memory of the splits, of the state of the reader and of the remaining streams."""
        state = (*self._replay, *self._contexts)
        return self.splits.nbytes + self.streams.nbytes + sum(array.nbytes for array in state)

    def unpack(self) -> None:
        """Unpack and check the next group.

        Raises
        ------
        HistoryFileError
            If the group is damaged; every later call raises the same error.
        """
        with self.streams.next_group() as (name, start, end, reader):
            before = int(self._used[SHIFTED])
            rows = {row: extended_copy(getattr(self.splits, row), end - 4) for row in ROWS}
            fault, slot, self._replay, splits = read_group(
                reader,
                self._contexts,
                larger_replay(self._replay, end),
                self.splits._replace(**rows),
                self._used,
                start,
                end,
                self.streams.vertices,
                self._centre,
                self._step,
            )
            if fault:
                raise HistoryFileError(
                    f"in the split that adds slot {slot}, {FAULTS[fault]}",
                    where={"field": name, "slot": int(slot)},
                    remedy=DAMAGE_REMEDY,
                )
            moved, shifted = int(self._used[MOVED]), int(self._used[SHIFTED])
            part = slice(before, shifted)
            ends = splits.shifted_end[start - 4 :] - before
            order = ascending_order(ends, splits.shifted[part])
            for array in (splits.shifted, splits.shifted_coarse, splits.shifted_fine):
                array[part] = array[part][order]
            self.splits = splits
        if self.streams.is_complete:
            self.splits = splits._replace(
                moved=splits.moved[:moved].copy(),
                shifted=splits.shifted[:shifted].copy(),
                shifted_coarse=splits.shifted_coarse[:shifted].copy(),
                shifted_fine=splits.shifted_fine[:shifted].copy(),
            )
