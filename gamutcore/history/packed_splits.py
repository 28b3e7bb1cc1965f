"""The splits of a history file, packed into streams and unpacked when a level needs them.

Each group is checked while it is unpacked: every level that it leads to is closed and star-shaped
about the centre. Groups that nobody asks for cost nothing but the bytes of their streams.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from gamutcore.errors import HistoryFileError, NeighbourLimitError
from gamutcore.history.bit_codes import BitWriter, read_bits, stream_bytes
from gamutcore.history.prediction import first_contexts
from gamutcore.history.prefix_order import (
    Splits,
    ascending_order,
    empty_splits,
    extended_copy,
    group_ranges,
)
from gamutcore.history.rings import (
    DEGREE,
    LONGEST,
    MOST_WORK,
    MOVED,
    MOVED_PER_VERTEX,
    VISITED,
    WORK_PER_VERTEX,
    Replay,
    first_replay,
    larger_replay,
)
from gamutcore.history.split_codes import (
    FAULTS,
    LARGEST_COORDINATE,
    NO_ROOM,
    RING_BYTES,
    SPLIT_BYTES,
    Group,
    read_group,
    write_group,
)
from gamutcore.history.streams import DAMAGE_REMEDY, SPLITS, Streams

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from gamutcore.arrays import ByteArray, FloatArray, IndexArray

__all__ = ["PackedSplits", "split_streams", "splits_in_steps"]


class PackedSplits:
    """The splits of a history file.

    `streams` has one long enough stream per group. `positions` (4, 3), in steps, and `faces` (4, 3)
    are the coarsest level, a tetrahedron around the centre. `splits` holds the unpacked splits.
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
        self.splits = empty_splits((positions * step).astype(np.float32), faces, 0)
        self._centre, self._step = centre / step, np.float32(step)
        self._replay = first_replay(positions, faces)
        self._contexts = first_contexts()

    @property
    def nbytes(self) -> int:
        """Memory of the splits, of the state of the reader and of the remaining streams."""
        state = (*self._replay, *self._contexts)
        return self.splits.nbytes + self.streams.nbytes + sum(array.nbytes for array in state)

    def unpack(self) -> None:
        """Unpack and check the next group.

        Damage raises a `HistoryFileError`; every later call raises the same error.
        """
        with self.streams.next_group() as (name, start, end, reader):
            group = Group(start, end, read_bits(reader, 1))
            rows = empty_splits(self._replay.position[:4], self.splits.base_faces, end - start)
            fault, slot = NO_ROOM, start
            while fault == NO_ROOM:
                rows = self._with_room(rows, group)
                self._replay = larger_replay(self._replay, end)
                fault, slot = read_group(
                    reader, self._contexts, self._replay, rows, group, slot, self._centre
                )
            if fault:
                raise HistoryFileError(
                    f"in the split that adds slot {slot}, {FAULTS[fault]}",
                    where={"field": name, "slot": int(slot)},
                    remedy=DAMAGE_REMEDY,
                )
            self._append(rows)

    def _with_room(self, rows: Splits, group: Group) -> Splits:
        """Return the splits of a group with room for more moved corners and neighbours."""
        more = 4 * (group.end - group.start) + int(self._replay.used[LONGEST])
        moved = 2 * rows.moved.size + more
        shifted = group.shifts * (2 * rows.shifted.size + more)
        return rows._replace(
            moved=extended_copy(rows.moved, moved),
            shifted=extended_copy(rows.shifted, shifted),
            shifted_coarse=extended_copy(rows.shifted_coarse, shifted),
            shifted_fine=extended_copy(rows.shifted_fine, shifted),
        )

    def _append(self, rows: Splits) -> None:
        """Append the splits of a group, whose positions are in steps."""
        order = ascending_order(rows.shifted_end, rows.shifted[: rows.shifted_end[-1]])
        rows = rows._replace(
            moved_end=rows.moved_end + len(self.splits.moved),
            moved=rows.moved[: rows.moved_end[-1]],
            shifted_end=rows.shifted_end + len(self.splits.shifted),
            shifted=rows.shifted[order],
            shifted_coarse=rows.shifted_coarse[order],
            shifted_fine=rows.shifted_fine[order],
        )
        columns: list[Any] = [*self.splits[:2]]
        for old, new in zip(self.splits[2:], rows[2:], strict=True):
            column: NDArray[Any] = np.concatenate([old, new], dtype=old.dtype, casting="unsafe")
            if column.dtype == np.float32:
                column[len(old) :] *= self._step
            columns.append(column)
        self.splits = Splits(*columns)


def splits_in_steps(splits: Splits, step: float) -> Splits:
    """Return the splits with positions as int32 in steps, or raise a `HistoryFileError`."""
    whole: dict[str, Any] = {}
    for name, array in splits._asdict().items():
        if array.dtype != np.float32:
            continue
        steps = np.rint(array.astype(np.float64) / step)
        if not (np.abs(steps) <= LARGEST_COORDINATE).all() or (steps * step != array).any():
            message = f"positions in {name!r} are not on the grid of the step {step!r}"
            remedy = f"Give multiples of the step, at most {LARGEST_COORDINATE} times it."
            raise HistoryFileError(message, where={"field": name}, remedy=remedy)
        whole[name] = steps.astype(np.int32)
    return splits._replace(**whole)


def split_streams(splits: Splits) -> Iterator[ByteArray]:
    """Yield the stream of each group; positions are in steps.

    Splits that do not fit the level before them raise a `HistoryFileError`, and those that readers
    would refuse as too much work a `NeighbourLimitError`.
    """
    replay = first_replay(cast("IndexArray", splits.base_positions), splits.base_faces)
    contexts = first_contexts()
    shifted = 0
    for start, end in group_ranges(splits.vertices):
        group = Group(start, end, int(splits.shifted_end[end - 5] > shifted))
        shifted = splits.shifted_end[end - 5]
        writer = BitWriter(np.array([group.shifts << 7], np.uint8), np.ones(1, np.int64))
        fault, slot = NO_ROOM, start
        while fault == NO_ROOM:
            more = SPLIT_BYTES * (end - start) + RING_BYTES * int(replay.used[LONGEST])
            longer = np.pad(writer.data, (0, writer.data.size + more))
            writer, replay = writer._replace(data=longer), larger_replay(replay, end)
            fault, slot = write_group(writer, contexts, replay, splits, group, slot)
        if fault:
            raise HistoryFileError(
                f"the split that adds slot {slot} does not fit the level before it",
                where={"slot": int(slot)},
                remedy="Give splits in the order that build_history gives them.",
            )
        _refuse_much_work(replay, end)
        yield stream_bytes(writer)


def _refuse_much_work(replay: Replay, end: int) -> None:
    """Check the work of readers up to the end of a group, so that no reader refuses the file."""
    visited, moved = replay.used[VISITED], replay.used[MOVED]
    if visited > MOST_WORK + WORK_PER_VERTEX * end or moved > MOVED_PER_VERTEX * end:
        most = int(replay.span[:end, DEGREE].max())
        raise NeighbourLimitError(
            f"Up to {most} triangles meet at a vertex, and levels would take too long to read.",
            where={"neighbours": most},
            remedy="Divide the surface so that fewer triangles meet at a vertex.",
        )
