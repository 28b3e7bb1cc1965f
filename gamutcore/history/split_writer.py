"""From splits to the streams of a history file; see `gamutcore.history.split_codes`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.arrays import IndexArray
from gamutcore.history.bit_codes import (
    LONGEST_CODE,
    BitWriter,
    Contexts,
    write_adaptive,
    write_below,
    write_bits,
    write_differences,
)
from gamutcore.history.replay import Frame, frame_of, third
from gamutcore.history.rings import (
    VISITED,
    WALKED,
    Replay,
    copy_ring,
    has_room,
    ring_of,
    split_slot,
    with_room,
)
from gamutcore.history.split_codes import (
    ADDED_ALONG,
    ADDED_OFF,
    KEPT,
    PARENT_ALONG,
    PARENT_OFF,
    SHIFTED_ALONG,
    SHIFTED_OFF,
)
from gamutcore.kernels import kernel, leaf_kernel

if TYPE_CHECKING:
    from gamutcore.history.prefix_order import Splits

__all__ = ["write_group"]


@kernel
def write_group(
    contexts: Contexts, replay: Replay, splits: Splits, start: int, end: int
) -> tuple[BitWriter, int, Replay]:
    """Write the splits from one level to a finer one as a stream.

    Parameters
    ----------
    contexts : Contexts
        As the group before left them.
    replay : Replay
        The level with `start` vertices; becomes that with `end`.
    splits : Splits
        With all positions as int32 in steps.
    start, end : int

    Returns
    -------
    writer : BitWriter
        With the stream in it.
    faulty : int
        The first slot whose split does not fit the level before it or is not in canonical order;
        0 if there is none.
    replay : Replay
        The same or longer arrays.
    """
    writer = BitWriter(np.zeros(16 * (end - start) + 64, np.uint8), np.zeros(1, np.int64))
    ring = np.empty((64, 2), np.int32)
    first_shift = splits.shifted_end[start - 5] if start > 4 else 0
    shifts = splits.shifted_end[end - 5] > first_shift
    write_bits(writer, 1 if shifts else 0, 1)
    for slot in range(start, end):
        split = slot - 4
        parent = splits.parent[split]
        degree, lowest = ring_of(replay, parent)
        if degree > len(ring):
            ring = np.empty((2 * degree, 2), np.int32)
        copy_ring(replay, parent, lowest, ring)
        writer = _with_room(writer, 8 * LONGEST_CODE + degree * (1 + 3 * LONGEST_CODE))
        cut = _steps_to_left(ring, degree, splits.faces[split, 0, 2])
        copy_ring(replay, parent, (lowest + cut) % degree, ring)
        begin = splits.moved_end[split - 1] if split > 0 else 0
        kept = degree - (splits.moved_end[split] - begin)
        if not _fits(replay, splits, slot, ring, degree, kept):
            return writer, slot, replay
        if not has_room(replay, ring, degree, kept):
            replay = with_room(replay, ring, degree, kept)
        write_below(writer, parent, slot)
        write_below(writer, cut, degree)
        half = (degree + 1) // 2
        fewer = degree - 1 - kept
        write_adaptive(writer, contexts, KEPT, kept - half if kept >= half else fewer)
        frame = frame_of(replay, parent, ring, degree, kept)
        _write_places(writer, contexts, frame, replay, splits, split)
        begin = splits.shifted_end[split - 1] if split > 0 else 0
        count = splits.shifted_end[split] - begin
        if shifts:
            found = _write_shifts(
                writer, contexts, frame, replay, splits, begin, count, ring, degree
            )
            if found != count:
                return writer, slot, replay
        split_slot(replay, parent, slot, ring, degree, kept)
        # readers look at all faces around what moves
        for index in range(begin, begin + count):
            replay.used[VISITED] += WALKED * replay.span[splits.shifted[index], 1]
        for axis in range(3):
            replay.position[parent, axis] = splits.fine[split, axis]
            replay.position[slot, axis] = splits.added[split, axis]
    return writer, 0, replay


@kernel
def _with_room(writer: BitWriter, bits: int) -> BitWriter:
    """Return the writer, or a longer one with the same content, that so many bits more fit into."""
    needed = (writer.place[0] + bits) // 8 + 1
    if needed <= writer.data.size:
        return writer
    longer = np.zeros(2 * needed, np.uint8)
    for index in range(writer.data.size):
        longer[index] = writer.data[index]
    return BitWriter(longer, writer.place)


@leaf_kernel
def _steps_to_left(ring: IndexArray, degree: int, left: int) -> int:
    """Where a ring names a neighbour; 0 if it does not."""
    for index in range(degree):
        if ring[index, 1] == left:
            return index
    return 0


@leaf_kernel
def _fits(
    replay: Replay, splits: Splits, slot: int, ring: IndexArray, degree: int, kept: int
) -> bool:
    """Whether a split is one of the level that is replayed, and in canonical order."""
    split = slot - 4
    parent = splits.parent[split]
    for axis in range(3):
        if replay.position[parent, axis] != splits.coarse[split, axis]:
            return False
    if kept < 1 or kept >= degree:
        return False
    faces = splits.faces
    for side in range(2):
        if faces[split, side, side] != parent or faces[split, side, 1 - side] != slot:
            return False
        if faces[split, side, 2] != ring[side * kept, 1]:
            return False
    end = splits.moved_end[split]
    for index in range(kept, degree):
        if ring[index, 0] != splits.moved[end - degree + index]:
            return False
    return True


@leaf_kernel
def _write_places(
    writer: BitWriter, contexts: Contexts, frame: Frame, replay: Replay, splits: Splits, split: int
) -> None:
    """Write where the parent and the new slot are after a split."""
    u, v, w = frame.u, frame.v, frame.w
    parent = splits.parent[split]
    position, fine, added = replay.position, splits.fine, splits.added
    du, dv = fine[split, u] - position[parent, u], fine[split, v] - position[parent, v]
    dw = fine[split, w] - position[parent, w]
    write_differences(
        writer,
        contexts,
        PARENT_ALONG + frame.size,
        PARENT_OFF + frame.height,
        du - frame.ahead_u,
        dv - frame.ahead_v,
        dw - third(frame, du, dv),
    )
    eu, ev = added[split, u] - position[parent, u], added[split, v] - position[parent, v]
    ew = added[split, w] - position[parent, w]
    write_differences(
        writer,
        contexts,
        ADDED_ALONG + frame.height,
        ADDED_OFF + frame.height,
        eu + du,
        ev + dv,
        ew - third(frame, eu, ev),
    )


@leaf_kernel
def _write_shifts(
    writer: BitWriter,
    contexts: Contexts,
    frame: Frame,
    replay: Replay,
    splits: Splits,
    begin: int,
    count: int,
    ring: IndexArray,
    degree: int,
) -> int:
    """Write which neighbours move and by how much, and move them; return how many there are."""
    u, v, w = frame.u, frame.v, frame.w
    position = replay.position
    write_bits(writer, 1 if count > 0 else 0, 1)
    found = 0
    for index in range(degree if count > 0 else 0):
        neighbour = ring[index, 1]
        at = -1
        for candidate in range(begin, begin + count):
            if splits.shifted[candidate] == neighbour:
                at = candidate
        write_bits(writer, 1 if at >= 0 else 0, 1)
        if at < 0:
            continue
        found += 1
        fine, coarse = splits.shifted_fine, splits.shifted_coarse
        for axis in range(3):
            if position[neighbour, axis] != coarse[at, axis]:
                return -1
        du, dv = fine[at, u] - coarse[at, u], fine[at, v] - coarse[at, v]
        dw = fine[at, w] - coarse[at, w]
        write_differences(
            writer,
            contexts,
            SHIFTED_ALONG + frame.size,
            SHIFTED_OFF + frame.height,
            du,
            dv,
            dw - third(frame, du, dv),
        )
        for axis in range(3):
            position[neighbour, axis] = fine[at, axis]
    return found
