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
from gamutcore.history.prediction import Frame, find_frame, plane_height
from gamutcore.history.rings import (
    CORNER,
    DEGREE,
    NEIGHBOUR,
    VISITED,
    WALK_COST,
    Replay,
    copy_ring,
    grow_replay,
    has_room,
    ring_start,
    split_slot,
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
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

if TYPE_CHECKING:
    from gamutcore.history.prefix_order import Splits

__all__ = ["write_group"]


@kernel
def write_group(
    contexts: Contexts, replay: Replay, splits: Splits, start: int, end: int
) -> tuple[BitWriter, int, Replay]:
    """Write the splits from one level to a finer level as a stream.

    Parameters
    ----------
    contexts : Contexts
        State after the group before; updated.
    replay : Replay
        The level with `start` vertices; becomes the level with `end` vertices.
    splits : Splits
        All positions are int32 in steps.
    start, end : int

    Returns
    -------
    writer : BitWriter
        Holds the stream.
    faulty : int
        First slot whose split does not fit the level before it or is not in canonical order; 0 if
        there is none.
    replay : Replay
        The same arrays, or longer ones.
    """
    writer = BitWriter(np.zeros(16 * (end - start) + 64, np.uint8), np.zeros(1, np.int64))
    ring = np.empty((64, 2), np.int32)
    shifted_before = int(splits.shifted_end[start - 5]) if start > 4 else 0
    shifts = bool(splits.shifted_end[end - 5] > shifted_before)
    write_bits(writer, int(shifts), 1)
    for slot in range(start, end):
        split = slot - 4
        parent = int(splits.parent[split])
        degree, lowest = ring_start(replay, parent)
        if degree > len(ring):
            ring = np.empty((2 * degree, 2), np.int32)
        copy_ring(replay, parent, lowest, ring)
        writer = _grow_writer(writer, 8 * LONGEST_CODE + degree * (1 + 3 * LONGEST_CODE))
        cut = _find_neighbour(ring, degree, int(splits.faces[split, 0, 2]))
        copy_ring(replay, parent, (lowest + cut) % degree, ring)
        moved_before = int(splits.moved_end[split - 1]) if split > 0 else 0
        kept = degree - (int(splits.moved_end[split]) - moved_before)
        if not _is_canonical(replay, splits, slot, ring, degree, kept):
            return writer, slot, replay
        if not has_room(replay, ring, degree, kept):
            replay = grow_replay(replay, ring, degree, kept)
        write_below(writer, parent, slot)
        write_below(writer, cut, degree)
        half = (degree + 1) // 2
        write_adaptive(writer, contexts, KEPT, kept - half if kept >= half else degree - 1 - kept)
        frame = find_frame(replay, parent, ring, degree, kept)
        _write_positions(writer, contexts, frame, replay, splits, split)
        if shifts and not _write_shifts(
            writer, contexts, frame, replay, splits, split, ring, degree
        ):
            return writer, slot, replay
        split_slot(replay, parent, slot, ring, degree, kept)
        # readers test all faces around moved neighbours
        for index in range(shifted_before, splits.shifted_end[split]):
            replay.used[VISITED] += WALK_COST * replay.span[splits.shifted[index], DEGREE]
        shifted_before = int(splits.shifted_end[split])
        for axis in range(3):
            replay.position[parent, axis] = splits.fine[split, axis]
            replay.position[slot, axis] = splits.added[split, axis]
    return writer, 0, replay


@kernel
def _grow_writer(writer: BitWriter, bits: int) -> BitWriter:
    """Return the writer, or a copy with room for so many more bits."""
    needed = (int(writer.position[0]) + bits) // 8 + 1
    if needed <= writer.data.size:
        return writer
    longer = np.zeros(2 * needed, np.uint8)
    for index in range(writer.data.size):
        longer[index] = writer.data[index]
    return BitWriter(longer, writer.position)


@leaf_kernel
def _find_neighbour(ring: IndexArray, degree: int, neighbour: int) -> int:
    """Position of a neighbour in a ring; 0 if the ring does not have it."""
    for index in range(degree):
        if ring[index, NEIGHBOUR] == neighbour:
            return index
    return 0


@leaf_kernel
def _is_canonical(
    replay: Replay, splits: Splits, slot: int, ring: IndexArray, degree: int, kept: int
) -> bool:
    """Whether a split fits the replayed level and is in canonical order."""
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
        if faces[split, side, 2] != ring[side * kept, NEIGHBOUR]:
            return False
    end = splits.moved_end[split]
    for index in range(kept, degree):
        if ring[index, CORNER] != splits.moved[end - degree + index]:
            return False
    return True


@inlined_kernel
def _write_positions(
    writer: BitWriter, contexts: Contexts, frame: Frame, replay: Replay, splits: Splits, split: int
) -> None:
    """Write the positions of the parent and the new slot after a split."""
    u, v, w = frame.u, frame.v, frame.w
    parent, position = splits.parent[split], replay.position
    cu, cv, cw = int(position[parent, u]), int(position[parent, v]), int(position[parent, w])
    fine, added = splits.fine, splits.added
    du, dv, dw = fine[split, u] - cu, fine[split, v] - cv, fine[split, w] - cw
    along, off = PARENT_ALONG + frame.size, PARENT_OFF + frame.height
    rise = dw - plane_height(frame, du, dv)
    write_differences(writer, contexts, along, off, du - frame.ahead_u, dv - frame.ahead_v, rise)
    eu, ev, ew = added[split, u] - cu, added[split, v] - cv, added[split, w] - cw
    along, off = ADDED_ALONG + frame.height, ADDED_OFF + frame.height
    rise = ew - plane_height(frame, eu, ev)
    write_differences(writer, contexts, along, off, eu + du, ev + dv, rise)


@inlined_kernel
def _write_shifts(
    writer: BitWriter,
    contexts: Contexts,
    frame: Frame,
    replay: Replay,
    splits: Splits,
    split: int,
    ring: IndexArray,
    degree: int,
) -> bool:
    """Write which neighbours move, and move them; False if the splits do not fit the level."""
    u, v, w = frame.u, frame.v, frame.w
    position, fine = replay.position, splits.shifted_fine
    begin = int(splits.shifted_end[split - 1]) if split > 0 else 0
    left = int(splits.shifted_end[split]) - begin
    write_bits(writer, int(left > 0), 1)
    for index in range(degree if left > 0 else 0):
        neighbour = ring[index, NEIGHBOUR]
        at = -1
        for candidate in range(begin, splits.shifted_end[split]):
            if splits.shifted[candidate] == neighbour:
                at = candidate
        write_bits(writer, int(at >= 0), 1)
        if at < 0:
            continue
        left -= 1
        for axis in range(3):
            if position[neighbour, axis] != splits.shifted_coarse[at, axis]:
                return False
        du = int(fine[at, u]) - int(position[neighbour, u])
        dv = int(fine[at, v]) - int(position[neighbour, v])
        dw = int(fine[at, w]) - int(position[neighbour, w])
        along, off = SHIFTED_ALONG + frame.size, SHIFTED_OFF + frame.height
        rise = dw - plane_height(frame, du, dv)
        write_differences(writer, contexts, along, off, du, dv, rise)
        for axis in range(3):
            position[neighbour, axis] = fine[at, axis]
    return left == 0
