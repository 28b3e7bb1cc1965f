"""The splits of a history file, unpacked group by group when a level that needs them is asked for.

Whatever was unpacked has been checked: each level that it leads to is closed and star-shaped about
the centre. What is not asked for costs nothing but the bytes of its streams.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.errors import HistoryFileError
from gamutcore.history.bit_codes import reader_of
from gamutcore.history.groups import (
    DAMAGED,
    Unbroken,
    group_name,
    groups_of,
    lengthened,
    refuse_bits_left,
)
from gamutcore.history.prefix_order import Splits, ascending_in_parts
from gamutcore.history.rings import replay_for, replay_of
from gamutcore.history.split_codes import first_contexts
from gamutcore.history.split_reader import (
    FAULTS,
    MOVED,
    SHIFTED,
    FixedColumns,
    empty_columns,
    read_group,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gamutcore.arrays import ByteArray, FloatArray, IndexArray

__all__ = ["PackedSplits"]


class PackedSplits:
    """The splits of a history file.

    Parameters
    ----------
    streams : sequence of (n,) uint8
        One for each group; long enough for as many splits.
    positions : (4, 3) int32
        Of the coarsest level, in steps.
    faces : (4, 3) int32
        Of the coarsest level: a tetrahedron around the centre.
    vertices : int
        Of the full boundary.
    centre : (3,) float64
    step : float

    Attributes
    ----------
    vertices : int
        Of the full boundary.
    unpacked : int
        How many groups are.
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
        self.unpacked = 0
        self.vertices = vertices
        self._streams = streams
        self._groups = groups_of(vertices)
        self._base = (positions * step).astype(np.float32), faces
        self._centre, self._step = centre, step
        self._replay = replay_of(positions, faces)
        self._contexts = first_contexts()
        self._fixed, self._growing = empty_columns(0)
        self._unbroken = Unbroken()

    @property
    def complete(self) -> bool:
        """Whether all groups are unpacked."""
        return self.unpacked == len(self._groups)

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes, by what is unpacked and by what is not."""
        unpacked = (self._replay, self._contexts, self._fixed, self._growing)
        left = sum(stream.nbytes for stream in self._streams[self.unpacked :])
        return left + sum(array.nbytes for arrays in unpacked for array in arrays)

    def unpack(self) -> None:
        """Unpack and check the next group.

        Raises
        ------
        HistoryFileError
            If it is damaged; from then on, whenever it is asked for.
        """
        with self._unbroken:
            self._unpack()
        self.unpacked += 1

    @property
    def splits(self) -> Splits:
        """The splits of the groups that are unpacked, with some room behind them unless all are.

        Nobody writes to what they hold any more.
        """
        fixed, growing = self._fixed, self._growing
        shifts, moves = growing.used[SHIFTED], growing.used[MOVED]
        splits = Splits(
            *self._base,
            fixed.parent,
            fixed.coarse,
            fixed.fine,
            fixed.added,
            fixed.faces.reshape(-1, 2, 3),
            fixed.moved_end,
            growing.moved,
            fixed.shifted_end,
            growing.shifted,
            growing.shifted_coarse,
            growing.shifted_fine,
        )
        if not self.complete:
            return splits
        return splits._replace(
            moved=splits.moved[:moves].copy(),
            shifted=splits.shifted[:shifts].copy(),
            shifted_coarse=splits.shifted_coarse[:shifts].copy(),
            shifted_fine=splits.shifted_fine[:shifts].copy(),
        )

    def _unpack(self) -> None:
        start, end = self._groups[self.unpacked]
        name = group_name(self.unpacked)
        reader = reader_of(self._streams[self.unpacked])
        first = int(self._growing.used[SHIFTED])
        self._fixed = FixedColumns._make(lengthened(each, end - 4) for each in self._fixed)
        fault, slot, self._replay, self._growing = read_group(
            reader,
            self._contexts,
            replay_for(self._replay, end),
            self._fixed,
            self._growing,
            start,
            end,
            self.vertices,
            self._centre,
            self._step,
        )
        if fault:
            raise HistoryFileError(
                f"in the split that adds slot {slot}, {FAULTS[fault]}",
                where={"field": name, "slot": int(slot)},
                remedy=DAMAGED,
            )
        refuse_bits_left(reader, name)
        growing = self._growing
        part = slice(first, int(growing.used[SHIFTED]))
        ends = self._fixed.shifted_end[start - 4 : end - 4] - first
        order = ascending_in_parts(ends, growing.shifted[part])
        for array in (growing.shifted, growing.shifted_coarse, growing.shifted_fine):
            array[part] = array[part][order]
