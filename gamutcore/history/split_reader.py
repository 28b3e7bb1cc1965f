"""From the streams of a history file to splits; see `gamutcore.history.split_codes`.

Whatever the bits are, a stream that is read to its end is a history of closed, oriented meshes of
genus 0, because a split can only be told in ways that keep that. That no face turns away from the
centre is tested for each face that a split adds or changes: a history that was read is valid at
every level. Work and memory are bounded by the length of the stream.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray, LongArray
from gamutcore.history.bit_codes import (
    BitReader,
    Contexts,
    read_adaptive,
    read_below,
    read_bits,
    read_differences,
)
from gamutcore.history.replay import (
    Frame,
    frame_of,
    sees_centre_after_split,
    star_sees_centre,
    third,
)
from gamutcore.history.rings import (
    MOST_VISITED,
    VISITED,
    VISITED_PER_VERTEX,
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
    LARGEST_COORDINATE,
    PARENT_ALONG,
    PARENT_OFF,
    SHIFTED_ALONG,
    SHIFTED_OFF,
)
from gamutcore.kernels import inlined_kernel, kernel

__all__ = [
    "FAULTS",
    "MOVED",
    "MOVED_PER_VERTEX",
    "SHIFTED",
    "FixedColumns",
    "GrowingColumns",
    "empty_columns",
    "read_group",
]

MOVED_PER_VERTEX = 24
"""Corners that move, divided by the vertices of the full boundary. Real histories move three. Where
the smaller part of a ring always goes to the new slot, as writers let it, each corner that moves
does so into a ring of about half the length, so that there are not many more than log₂ V. Whoever
writes refuses what has more."""

OK, CUT_SHORT, BAD_CUT, LONG_RINGS, MANY_MOVED, FAR_OFF, NOT_STAR_SHAPED = range(7)

FAULTS = {
    CUT_SHORT: "the stream ends within it",
    BAD_CUT: "the parent keeps more faces than it has",
    LONG_RINGS: "there are too many neighbours to walk through",
    MANY_MOVED: "too many corners move",
    FAR_OFF: "a coordinate is beyond 2^24 steps",
    NOT_STAR_SHAPED: "a face does not see the centre from inside",
}
"""What `read_group` finds wrong with a split, by the numbers that it returns."""

MOVED, SHIFTED = range(2)
"""Places in `GrowingColumns.used`."""


class FixedColumns(NamedTuple):
    """Columns of `Splits` with a row per split; `faces` has its last two axes in one."""

    parent: IndexArray
    coarse: Float32Array
    fine: Float32Array
    added: Float32Array
    faces: IndexArray
    moved_end: IndexArray
    shifted_end: IndexArray


class GrowingColumns(NamedTuple):
    """Columns of `Splits` whose length is not known before all splits are read.

    Attributes
    ----------
    moved : (≥ used[MOVED],) int32
    shifted : (≥ used[SHIFTED],) int32
    shifted_coarse, shifted_fine : (≥ used[SHIFTED], 3) float32
    used : (2,) int64
        How much of the first and of the others is in use.
    """

    moved: IndexArray
    shifted: IndexArray
    shifted_coarse: Float32Array
    shifted_fine: Float32Array
    used: LongArray


def empty_columns(splits: int) -> tuple[FixedColumns, GrowingColumns]:
    """Return columns for so many splits, with nothing in them."""
    fixed = FixedColumns(
        np.empty(splits, np.int32),
        np.empty((splits, 3), np.float32),
        np.empty((splits, 3), np.float32),
        np.empty((splits, 3), np.float32),
        np.empty((splits, 6), np.int32),
        np.empty(splits, np.int32),
        np.empty(splits, np.int32),
    )
    growing = GrowingColumns(
        np.empty(4 * splits + 64, np.int32),
        np.empty(64, np.int32),
        np.empty((64, 3), np.float32),
        np.empty((64, 3), np.float32),
        np.zeros(2, np.int64),
    )
    return fixed, growing


@kernel
def read_group(
    reader: BitReader,
    contexts: Contexts,
    replay: Replay,
    fixed: FixedColumns,
    growing: GrowingColumns,
    start: int,
    end: int,
    vertices: int,
    centre: FloatArray,
    step: float,
) -> tuple[int, int, Replay, GrowingColumns]:
    """Read the splits from one level to a finer one from a stream, and test all of their faces.

    Parameters
    ----------
    reader : BitReader
    contexts : Contexts
        As the group before left them.
    replay : Replay
        The level with `start` vertices, with room for `end`; becomes that with `end`.
    fixed : FixedColumns
        With rows up to the end of this group, which are filled.
    growing : GrowingColumns
        With what the groups before hold.
    start, end : int
    vertices : int
        Of the full boundary.
    centre : (3,) float64
    step : float

    Returns
    -------
    fault : int
        0 if there is none, else a key of `FAULTS`.
    slot : int
        That the faulty split adds; `end` if there is none.
    replay : Replay
    growing : GrowingColumns
        The same or longer arrays.
    """
    ring = np.empty((64, 2), np.int32)
    shifts = read_bits(reader, 1) == 1
    for slot in range(start, end):
        parent = read_below(reader, slot)
        degree, lowest = ring_of(replay, parent)
        cut, kept = _read_cuts(reader, contexts, degree)
        if kept < 1:
            fault = CUT_SHORT if reader.place[0] > reader.length else BAD_CUT
            return fault, slot, replay, growing
        if degree > len(ring):
            ring = np.empty((2 * degree, 2), np.int32)
        copy_ring(replay, parent, (lowest + cut) % degree, ring)
        if not has_room(replay, ring, degree, kept):
            replay = with_room(replay, ring, degree, kept)
        used = growing.used
        if used[MOVED] + degree > growing.moved.size or (
            shifts and used[SHIFTED] + degree > growing.shifted.size
        ):
            growing = _grown(growing, degree)
        fault = _read_split(
            reader,
            contexts,
            replay,
            fixed,
            growing,
            parent,
            slot,
            ring,
            degree,
            kept,
            shifts,
            end,
            vertices,
            centre,
            step,
        )
        if reader.place[0] > reader.length:
            fault = CUT_SHORT
        if fault != OK:
            return fault, slot, replay, growing
    return OK, end, replay, growing


@inlined_kernel
def _read_split(
    reader: BitReader,
    contexts: Contexts,
    replay: Replay,
    fixed: FixedColumns,
    growing: GrowingColumns,
    parent: int,
    slot: int,
    ring: IndexArray,
    degree: int,
    kept: int,
    shifts: bool,
    end: int,
    vertices: int,
    centre: FloatArray,
    step: float,
) -> int:
    """Read the places of one split, and apply it; returns a fault."""
    split, used, position = slot - 4, growing.used, replay.position
    frame = frame_of(replay, parent, ring, degree, kept)

    shifted_before = used[SHIFTED]
    for axis in range(3):
        fixed.coarse[split, axis] = position[parent, axis] * step
    if not _read_places(reader, contexts, frame, replay, parent, slot):
        return FAR_OFF
    if shifts and not _read_shifts(reader, contexts, frame, replay, growing, ring, degree, step):
        return FAR_OFF
    fixed.parent[split] = parent
    for axis in range(3):
        fixed.fine[split, axis] = position[parent, axis] * step
        fixed.added[split, axis] = position[slot, axis] * step
    for index in range(kept, degree):
        growing.moved[used[MOVED]] = ring[index, 0]
        used[MOVED] += 1
    fixed.moved_end[split], fixed.shifted_end[split] = used[MOVED], used[SHIFTED]
    faces = fixed.faces
    faces[split, 0], faces[split, 1], faces[split, 2] = parent, slot, ring[0, 1]
    faces[split, 3], faces[split, 4], faces[split, 5] = slot, parent, ring[kept, 1]

    split_slot(replay, parent, slot, ring, degree, kept)
    for index in range(shifted_before, used[SHIFTED]):
        replay.used[VISITED] += WALKED * replay.span[growing.shifted[index], 1]
    if replay.used[VISITED] > MOST_VISITED + VISITED_PER_VERTEX * end:
        return LONG_RINGS
    if used[MOVED] > MOVED_PER_VERTEX * vertices:
        return MANY_MOVED
    valid = sees_centre_after_split(replay, parent, slot, ring, degree, kept, centre, step)
    for index in range(shifted_before, used[SHIFTED]):
        valid &= star_sees_centre(replay, growing.shifted[index], centre, step)
    return OK if valid else NOT_STAR_SHAPED


@inlined_kernel
def _read_cuts(reader: BitReader, contexts: Contexts, degree: int) -> tuple[int, int]:
    """Read where the ring of the parent is cut, and how many faces it keeps: 0 if that is wrong."""
    cut = read_below(reader, degree)
    code = read_adaptive(reader, contexts, KEPT)
    half = (degree + 1) // 2
    if code > degree - 2:
        return cut, 0
    return cut, half + code if half + code < degree else degree - 1 - code


@inlined_kernel
def _read_places(
    reader: BitReader, contexts: Contexts, frame: Frame, replay: Replay, parent: int, slot: int
) -> bool:
    """Read and set where the parent and the new slot are; False if that is out of range."""
    u, v, w = frame.u, frame.v, frame.w
    position = replay.position
    cu, cv, cw = position[parent, u], position[parent, v], position[parent, w]
    du, dv, dw = read_differences(
        reader, contexts, PARENT_ALONG + frame.size, PARENT_OFF + frame.height
    )
    du, dv = du + frame.ahead_u, dv + frame.ahead_v
    dw += third(frame, du, dv)
    eu, ev, ew = read_differences(
        reader, contexts, ADDED_ALONG + frame.height, ADDED_OFF + frame.height
    )
    eu, ev = eu - du, ev - dv
    ew += third(frame, eu, ev)
    if not (_is_near(cu + du, cv + dv, cw + dw) and _is_near(cu + eu, cv + ev, cw + ew)):
        return False
    position[parent, u], position[parent, v], position[parent, w] = cu + du, cv + dv, cw + dw
    position[slot, u], position[slot, v], position[slot, w] = cu + eu, cv + ev, cw + ew
    return True


@inlined_kernel
def _read_shifts(
    reader: BitReader,
    contexts: Contexts,
    frame: Frame,
    replay: Replay,
    growing: GrowingColumns,
    ring: IndexArray,
    degree: int,
    step: float,
) -> bool:
    """Read which neighbours move, and move them; False if one goes out of range."""
    u, v, w = frame.u, frame.v, frame.w
    position = replay.position
    if not read_bits(reader, 1):
        return True
    for index in range(degree):
        if not read_bits(reader, 1):
            continue
        neighbour = ring[index, 1]
        du, dv, dw = read_differences(
            reader, contexts, SHIFTED_ALONG + frame.size, SHIFTED_OFF + frame.height
        )
        dw += third(frame, du, dv)
        cu, cv, cw = position[neighbour, u], position[neighbour, v], position[neighbour, w]
        if not _is_near(cu + du, cv + dv, cw + dw):
            return False
        at = growing.used[SHIFTED]
        growing.used[SHIFTED] += 1
        growing.shifted[at] = neighbour
        for axis in range(3):
            growing.shifted_coarse[at, axis] = position[neighbour, axis] * step
        position[neighbour, u], position[neighbour, v], position[neighbour, w] = (
            cu + du,
            cv + dv,
            cw + dw,
        )
        for axis in range(3):
            growing.shifted_fine[at, axis] = position[neighbour, axis] * step
    return True


@inlined_kernel
def _is_near(x: int, y: int, z: int) -> bool:
    return max(abs(x), abs(y), abs(z)) <= LARGEST_COORDINATE


@kernel
def _grown(growing: GrowingColumns, degree: int) -> GrowingColumns:
    """Return longer columns with the same content, that a ring more fits into."""
    moved, shifted = growing.moved, growing.shifted
    coarse, fine = growing.shifted_coarse, growing.shifted_fine
    # element by element: numba takes seconds to compile the assignment of slices
    if growing.used[MOVED] + degree > moved.size:
        moved = np.empty(2 * (growing.used[MOVED] + degree), np.int32)
        for index in range(growing.used[MOVED]):
            moved[index] = growing.moved[index]
    if growing.used[SHIFTED] + degree > shifted.size:
        room = 2 * (growing.used[SHIFTED] + degree)
        shifted = np.empty(room, np.int32)
        coarse, fine = np.empty((room, 3), np.float32), np.empty((room, 3), np.float32)
        for index in range(growing.used[SHIFTED]):
            shifted[index] = growing.shifted[index]
            for axis in range(3):
                coarse[index, axis] = growing.shifted_coarse[index, axis]
                fine[index, axis] = growing.shifted_fine[index, axis]
    return GrowingColumns(moved, shifted, coarse, fine, growing.used)
