"""From the streams of a history file to splits; see `gamutcore.history.split_codes`.

The format can only describe splits of closed, oriented meshes of genus 0, whatever the bits are.
The reader tests that each face that a split adds or changes has the centre on its inner side, so
every level that was read is valid. Work and memory are bounded by the length of the stream.
"""

from __future__ import annotations

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
from gamutcore.history.prediction import (
    Frame,
    find_frame,
    plane_height,
    sees_centre_after_split,
    star_sees_centre,
)
from gamutcore.history.prefix_order import Splits
from gamutcore.history.rings import (
    CORNER,
    DEGREE,
    MOST_WORK,
    NEIGHBOUR,
    VISITED,
    WALK_COST,
    WORK_PER_VERTEX,
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
    LARGEST_COORDINATE,
    MOVED_PER_VERTEX,
    PARENT_ALONG,
    PARENT_OFF,
    SHIFTED_ALONG,
    SHIFTED_OFF,
)
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

__all__ = ["FAULTS", "MOVED", "SHIFTED", "read_group"]

OK, CUT_SHORT, BAD_CUT, TOO_MUCH_WORK, MANY_MOVED, FAR_OFF, NOT_STAR_SHAPED = range(7)

FAULTS = {
    CUT_SHORT: "the stream ends within it",
    BAD_CUT: "the parent keeps more faces than it has",
    TOO_MUCH_WORK: "there are too many neighbours to walk through",
    MANY_MOVED: "too many corners move",
    FAR_OFF: "a coordinate is beyond 2^24 steps",
    NOT_STAR_SHAPED: "a face does not see the centre from inside",
}
"""Defects of a split by their number."""

MOVED, SHIFTED = range(2)
"""Elements of `used`: rows in use of `Splits.moved`, and of `Splits.shifted` and its positions."""


@kernel
def read_group(
    reader: BitReader,
    contexts: Contexts,
    replay: Replay,
    splits: Splits,
    used: LongArray,
    start: int,
    end: int,
    vertices: int,
    centre: FloatArray,
    step: float,
) -> tuple[int, int, Replay, Splits]:
    """Read the splits from one level to a finer level, and test all of their faces.

    Parameters
    ----------
    reader : BitReader
    contexts : Contexts
        State after the group before; updated.
    replay : Replay
        The level with `start` vertices, with room for `end`; becomes the level with `end` vertices.
    splits : Splits
        With one row per split up to `end`; this group's rows are filled. `moved` and `shifted` may
        be longer than the rows in use.
    used : (2,) int64
        Rows in use, by `MOVED` and `SHIFTED`; updated.
    start, end : int
    vertices : int
        Vertices of the full boundary.
    centre : (3,) float64
    step : float

    Returns
    -------
    fault : int
        0, or a key of `FAULTS`.
    slot : int
        Slot that the faulty split adds; `end` if there is no fault.
    replay : Replay
        The same arrays, or longer ones.
    splits : Splits
        The same arrays, or longer ones.
    """
    ring = np.empty((64, 2), np.int32)
    shifts = read_bits(reader, 1) == 1
    for slot in range(start, end):
        parent = read_below(reader, slot)
        degree, lowest = ring_start(replay, parent)
        cut, kept = _read_cuts(reader, contexts, degree)
        if kept < 1:
            fault = CUT_SHORT if reader.position[0] > reader.length else BAD_CUT
            return fault, slot, replay, splits
        if degree > len(ring):
            ring = np.empty((2 * degree, 2), np.int32)
        copy_ring(replay, parent, (lowest + cut) % degree, ring)
        if not has_room(replay, ring, degree, kept):
            replay = grow_replay(replay, ring, degree, kept)
        if used[MOVED] + degree > splits.moved.size or (
            shifts and used[SHIFTED] + degree > splits.shifted.size
        ):
            splits = _grow_splits(splits, used, degree)
        fault = _read_split(
            reader, contexts, replay, splits, used, parent, slot, ring, degree, kept, shifts, step
        )
        if fault == OK:
            if replay.used[VISITED] > MOST_WORK + WORK_PER_VERTEX * end:
                fault = TOO_MUCH_WORK
            elif used[MOVED] > MOVED_PER_VERTEX * vertices:
                fault = MANY_MOVED
            elif not _is_star_shaped(
                replay, splits, used, parent, slot, ring, degree, kept, centre, step
            ):
                fault = NOT_STAR_SHAPED
        if reader.position[0] > reader.length:
            fault = CUT_SHORT
        if fault != OK:
            return fault, slot, replay, splits
    return OK, end, replay, splits


@inlined_kernel
def _read_cuts(reader: BitReader, contexts: Contexts, degree: int) -> tuple[int, int]:
    """Read where the parent's ring is cut, and how many faces the parent keeps; 0 if wrong."""
    cut = read_below(reader, degree)
    code = read_adaptive(reader, contexts, KEPT)
    half = (degree + 1) // 2
    if code > degree - 2:
        return cut, 0
    return cut, half + code if half + code < degree else degree - 1 - code


@inlined_kernel
def _read_split(
    reader: BitReader,
    contexts: Contexts,
    replay: Replay,
    splits: Splits,
    used: LongArray,
    parent: int,
    slot: int,
    ring: IndexArray,
    degree: int,
    kept: int,
    shifts: bool,
    step: float,
) -> int:
    """Read the positions of one split, and apply it; return a fault."""
    split, position = slot - 4, replay.position
    frame = find_frame(replay, parent, ring, degree, kept)
    _deliver(splits.coarse, split, position, parent, step)
    shifted_before = int(used[SHIFTED])
    if not _read_positions(reader, contexts, frame, replay, parent, slot):
        return FAR_OFF
    if shifts and not _read_shifts(
        reader, contexts, frame, replay, splits, used, ring, degree, step
    ):
        return FAR_OFF
    splits.parent[split] = parent
    _deliver(splits.fine, split, position, parent, step)
    _deliver(splits.added, split, position, slot, step)
    moved = int(used[MOVED])
    for index in range(kept, degree):
        splits.moved[moved] = ring[index, CORNER]
        moved += 1
    used[MOVED] = moved
    splits.moved_end[split], splits.shifted_end[split] = moved, used[SHIFTED]
    faces = splits.faces
    faces[split, 0, 0], faces[split, 0, 1], faces[split, 0, 2] = parent, slot, ring[0, NEIGHBOUR]
    faces[split, 1, 0], faces[split, 1, 1], faces[split, 1, 2] = slot, parent, ring[kept, NEIGHBOUR]
    split_slot(replay, parent, slot, ring, degree, kept)
    for index in range(shifted_before, used[SHIFTED]):
        replay.used[VISITED] += WALK_COST * replay.span[splits.shifted[index], DEGREE]
    return OK


@inlined_kernel
def _deliver(target: Float32Array, row: int, position: IndexArray, slot: int, step: float) -> None:
    """Write a position in units of the colour space."""
    for axis in range(3):
        target[row, axis] = position[slot, axis] * step


@inlined_kernel
def _is_star_shaped(
    replay: Replay,
    splits: Splits,
    used: LongArray,
    parent: int,
    slot: int,
    ring: IndexArray,
    degree: int,
    kept: int,
    centre: FloatArray,
    step: float,
) -> bool:
    """Whether the centre is on the inner side of all faces that a split added or changed."""
    valid = sees_centre_after_split(replay, parent, slot, ring, degree, kept, centre, step)
    begin = splits.shifted_end[slot - 5] if slot > 4 else 0
    for index in range(begin, used[SHIFTED]):
        valid &= star_sees_centre(replay, int(splits.shifted[index]), centre, step)
    return valid


@inlined_kernel
def _read_positions(
    reader: BitReader, contexts: Contexts, frame: Frame, replay: Replay, parent: int, slot: int
) -> bool:
    """Read and set the positions of the parent and the new slot; False if one is out of range."""
    u, v, w = frame.u, frame.v, frame.w
    position = replay.position
    cu, cv, cw = int(position[parent, u]), int(position[parent, v]), int(position[parent, w])
    along, off = PARENT_ALONG + frame.size, PARENT_OFF + frame.height
    du, dv, dw = read_differences(reader, contexts, along, off)
    du, dv = du + frame.ahead_u, dv + frame.ahead_v
    dw += plane_height(frame, du, dv)
    along, off = ADDED_ALONG + frame.height, ADDED_OFF + frame.height
    eu, ev, ew = read_differences(reader, contexts, along, off)
    eu, ev = eu - du, ev - dv
    ew += plane_height(frame, eu, ev)
    if not (_is_in_range(cu + du, cv + dv, cw + dw) and _is_in_range(cu + eu, cv + ev, cw + ew)):
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
    splits: Splits,
    used: LongArray,
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
        slot = int(ring[index, NEIGHBOUR])
        along, off = SHIFTED_ALONG + frame.size, SHIFTED_OFF + frame.height
        du, dv, dw = read_differences(reader, contexts, along, off)
        dw += plane_height(frame, du, dv)
        cu, cv, cw = int(position[slot, u]), int(position[slot, v]), int(position[slot, w])
        if not _is_in_range(cu + du, cv + dv, cw + dw):
            return False
        row = int(used[SHIFTED])
        used[SHIFTED] = row + 1
        splits.shifted[row] = slot
        _deliver(splits.shifted_coarse, row, position, slot, step)
        position[slot, u], position[slot, v], position[slot, w] = cu + du, cv + dv, cw + dw
        _deliver(splits.shifted_fine, row, position, slot, step)
    return True


@inlined_kernel
def _is_in_range(x: int, y: int, z: int) -> bool:
    return max(abs(x), abs(y), abs(z)) <= LARGEST_COORDINATE


@leaf_kernel
def _copy_rows(source: Float32Array, target: Float32Array, rows: int) -> None:
    # element by element: numba takes seconds to compile an assignment of slices
    for row in range(rows):
        for axis in range(3):
            target[row, axis] = source[row, axis]


@kernel
def _grow_splits(splits: Splits, used: LongArray, degree: int) -> Splits:
    """Return splits with room for one more ring in `moved` and `shifted`."""
    moved_room, shifted_room = 2 * (used[MOVED] + degree), 2 * (used[SHIFTED] + degree)
    moved, shifted = np.empty(moved_room, np.int32), np.empty(shifted_room, np.int32)
    coarse, fine = np.empty((shifted_room, 3), np.float32), np.empty((shifted_room, 3), np.float32)
    for index in range(used[MOVED]):
        moved[index] = splits.moved[index]
    for index in range(used[SHIFTED]):
        shifted[index] = splits.shifted[index]
    _copy_rows(splits.shifted_coarse, coarse, used[SHIFTED])
    _copy_rows(splits.shifted_fine, fine, used[SHIFTED])
    return Splits(
        splits.base_positions,
        splits.base_faces,
        splits.parent,
        splits.coarse,
        splits.fine,
        splits.added,
        splits.faces,
        splits.moved_end,
        moved,
        splits.shifted_end,
        shifted,
        coarse,
        fine,
    )
