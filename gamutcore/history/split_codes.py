"""The splits of a group as a stream of bits: writer and reader.

The format can only describe splits of closed, oriented meshes of genus 0, whatever the bits are.
The reader tests that each face a split adds or changes has the centre on its inner side. Every
level that was read is therefore valid. Work and memory are bounded by the length of the stream.

Kernels that allocate or return arrays count references, which takes longer than the work. Both
loops over splits are therefore leaf kernels. They stop where an array has no room for the next
split, and are called again with longer arrays.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

from gamutcore.arrays import FloatArray
from gamutcore.history.bit_codes import (
    LONGEST_CODE,
    BitReader,
    BitWriter,
    Contexts,
    read_adaptive,
    read_below,
    read_bits,
    read_differences,
    write_adaptive,
    write_below,
    write_bits,
    write_differences,
)
from gamutcore.history.prediction import (
    ADDED,
    KEPT,
    PARENT,
    SHIFTED,
    Frame,
    difference_contexts,
    find_frame,
    plane_height,
    star_sees_centre,
)
from gamutcore.history.prefix_order import Splits, copy_row, part_begin
from gamutcore.history.rings import (
    CORNER,
    DEGREE,
    LONGEST,
    MOST_WORK,
    MOVED,
    MOVED_PER_VERTEX,
    NEIGHBOUR,
    VISITED,
    WALK_COST,
    WORK_PER_VERTEX,
    Cut,
    Replay,
    copy_ring,
    has_room,
    ring_start,
    split_slot,
)
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "FAULTS",
    "LARGEST_COORDINATE",
    "MINIMUM_SPLIT_BITS",
    "NO_ROOM",
    "RING_BYTES",
    "SPLIT_BYTES",
    "Group",
    "read_group",
    "write_group",
]

LARGEST_COORDINATE = 2**24
"""In steps: integers up to this are exact in float32."""

MINIMUM_SPLIT_BITS = 10
"""Two bits for the parent, one of at least four slots; one for each of the two cuts of its ring;
one for each of six differences."""

SPLIT_BYTES = LONGEST_CODE + 1
"""Upper bound of the bytes that a split takes without neighbours that move, in eight numbers."""

RING_BYTES = (1 + 3 * LONGEST_CODE) // 8 + 1
"""Upper bound of the bytes for each neighbour of the parent."""

OK, NO_ROOM, MISFIT = range(3)
"""Results of writer and reader. `MISFIT`: a split does not fit the level before it, or is not in
canonical order."""

CUT_SHORT, BAD_CUT, TOO_MUCH_WORK, MANY_MOVED, FAR_OFF, NOT_STAR_SHAPED = range(3, 9)

FAULTS = {
    CUT_SHORT: "the stream ends within it",
    BAD_CUT: "the parent keeps more faces than it has",
    TOO_MUCH_WORK: "there are too many neighbours to walk through",
    MANY_MOVED: "too many corners move",
    FAR_OFF: "a coordinate is beyond 2^24 steps",
    NOT_STAR_SHAPED: "a face does not see the centre from inside",
}
"""Further results of the reader: defects of a split in a stream."""


class Group(NamedTuple):
    """A group of splits.

    Attributes
    ----------
    start, end : int
        The first slot that the group adds, and the end of its slots.
    shifts : int
        1 if any of its splits moves neighbours, else 0.
    """

    start: int
    end: int
    shifts: int


@leaf_kernel
def read_group(
    reader: BitReader,
    contexts: Contexts,
    replay: Replay,
    splits: Splits,
    group: Group,
    first: int,
    centre: FloatArray,
) -> tuple[int, int]:
    """Read the splits of a group from slot `first` on, and test all of their faces.

    Only rows of this group are in `splits`; positions and the centre are in steps. The result is 0,
    `NO_ROOM` or a key of `FAULTS`, and the slot at which the reader stopped.
    """
    for slot in range(first, group.end):
        row, longest = slot - group.start, replay.used[LONGEST]
        if (
            not has_room(replay)
            or part_begin(splits.moved_end, row) + longest > splits.moved.size
            or group.shifts * (part_begin(splits.shifted_end, row) + longest) > splits.shifted.size
        ):
            return NO_ROOM, slot
        cut = _read_cut(reader, contexts, replay, slot)
        fault = CUT_SHORT if reader.position[0] > reader.length else BAD_CUT
        if cut.kept > 0:
            fault = _read_split(reader, contexts, replay, splits, group, cut, centre)
        if fault != OK:
            return fault, slot
    return OK, group.end


@leaf_kernel
def _read_cut(reader: BitReader, contexts: Contexts, replay: Replay, slot: int) -> Cut:
    """Read where a split cuts the ring of its parent; `kept` is 0 if it is more than there are."""
    parent = read_below(reader, slot)
    degree, lowest = ring_start(replay, parent)
    first = read_below(reader, degree)
    code = read_adaptive(reader, contexts, KEPT)
    if code > degree - 2:
        return Cut(parent, slot, degree, 0)
    copy_ring(replay, parent, (lowest + first) % degree)
    half = (degree + 1) // 2
    return Cut(parent, slot, degree, half + code if half + code < degree else degree - 1 - code)


@leaf_kernel
def _read_split(
    reader: BitReader,
    contexts: Contexts,
    replay: Replay,
    splits: Splits,
    group: Group,
    cut: Cut,
    centre: FloatArray,
) -> int:
    """Read the positions of a split, apply it, and test the new level; return a fault."""
    ring, parent, slot, row = replay.ring, cut.parent, cut.slot, cut.slot - group.start
    shifted_begin = part_begin(splits.shifted_end, row)
    splits.shifted_end[row] = shifted_begin
    frame = find_frame(replay, cut)
    copy_row(splits.coarse, row, replay.position, parent)
    is_near = _read_positions(reader, contexts, frame, replay, cut)
    if is_near and group.shifts:
        is_near = _read_shifts(reader, contexts, frame, replay, splits, cut, row)
    if reader.position[0] > reader.length:
        return CUT_SHORT
    if not is_near:
        return FAR_OFF
    splits.parent[row] = parent
    copy_row(splits.fine, row, replay.position, parent)
    copy_row(splits.added, row, replay.position, slot)
    moved = part_begin(splits.moved_end, row)
    for index in range(cut.kept, cut.degree):
        splits.moved[moved] = ring[index, CORNER]
        moved += 1
    splits.moved_end[row] = moved
    left, right, faces = ring[0, NEIGHBOUR], ring[cut.kept, NEIGHBOUR], splits.faces
    faces[row, 0, 0], faces[row, 0, 1], faces[row, 0, 2] = parent, slot, left
    faces[row, 1, 0], faces[row, 1, 1], faces[row, 1, 2] = slot, parent, right
    split_slot(replay, cut)
    _count_shifts(replay, splits, row)
    if replay.used[VISITED] > MOST_WORK + WORK_PER_VERTEX * group.end:
        return TOO_MUCH_WORK
    if replay.used[MOVED] > MOVED_PER_VERTEX * group.end:
        return MANY_MOVED
    valid = star_sees_centre(replay, parent, centre) and star_sees_centre(replay, slot, centre)
    for index in range(shifted_begin, splits.shifted_end[row]):
        valid &= star_sees_centre(replay, int(splits.shifted[index]), centre)
    return OK if valid else NOT_STAR_SHAPED


@inlined_kernel
def _count_shifts(replay: Replay, splits: Splits, row: int) -> None:
    """Add the work of tests around moved neighbours."""
    for index in range(part_begin(splits.shifted_end, row), splits.shifted_end[row]):
        replay.used[VISITED] += WALK_COST * replay.span[splits.shifted[index], DEGREE]


@inlined_kernel
def _read_positions(
    reader: BitReader, contexts: Contexts, frame: Frame, replay: Replay, cut: Cut
) -> bool:
    """Read and set the positions of the parent and the new slot; False if one is out of range."""
    parent = cut.parent
    along, off = difference_contexts(frame, PARENT)
    du, dv, dw = read_differences(reader, contexts, along, off)
    du, dv = du + frame.ahead_u, dv + frame.ahead_v
    along, off = difference_contexts(frame, ADDED)
    eu, ev, ew = read_differences(reader, contexts, along, off)
    # both are relative to the parent before the split
    return _move(replay, frame, parent, cut.slot, eu - du, ev - dv, ew) and _move(
        replay, frame, parent, parent, du, dv, dw
    )


@inlined_kernel
def _move(
    replay: Replay, frame: Frame, origin: int, slot: int, du: int, dv: int, rise: int
) -> bool:
    """Set a position relative to that of a slot and to the plane; False if it is out of range."""
    position, u, v, w = replay.position, frame.u, frame.v, frame.w
    x, y = int(position[origin, u]) + du, int(position[origin, v]) + dv
    z = int(position[origin, w]) + rise + plane_height(frame, du, dv)
    if max(abs(x), abs(y), abs(z)) > LARGEST_COORDINATE:
        return False
    position[slot, u], position[slot, v], position[slot, w] = x, y, z
    return True


@inlined_kernel
def _read_shifts(
    reader: BitReader,
    contexts: Contexts,
    frame: Frame,
    replay: Replay,
    splits: Splits,
    cut: Cut,
    row: int,
) -> bool:
    """Read which neighbours move, and move them; False if one goes out of range."""
    if not read_bits(reader, 1):
        return True
    for index in range(cut.degree):
        if not read_bits(reader, 1):
            continue
        slot, shifted = int(replay.ring[index, NEIGHBOUR]), int(splits.shifted_end[row])
        splits.shifted[shifted] = slot
        copy_row(splits.shifted_coarse, shifted, replay.position, slot)
        along, off = difference_contexts(frame, SHIFTED)
        du, dv, dw = read_differences(reader, contexts, along, off)
        if not _move(replay, frame, slot, slot, du, dv, dw):
            return False
        copy_row(splits.shifted_fine, shifted, replay.position, slot)
        splits.shifted_end[row] = shifted + 1
    return True


@leaf_kernel
def write_group(
    writer: BitWriter,
    contexts: Contexts,
    replay: Replay,
    splits: Splits,
    group: Group,
    first: int,
) -> tuple[int, int]:
    """Write the splits of a group from slot `first` on; all positions are in steps.

    The result is 0, `NO_ROOM` or `MISFIT`, and the slot at which the writer stopped.
    """
    for slot in range(first, group.end):
        most = int(writer.position[0]) // 8 + SPLIT_BYTES + RING_BYTES * int(replay.used[LONGEST])
        if most > writer.data.size or not has_room(replay):
            return NO_ROOM, slot
        cut, begin = _find_cut(replay, splits, slot)
        if cut.kept < 1 or not _write_split(writer, contexts, replay, splits, group, cut, begin):
            return MISFIT, slot
    return OK, group.end


@leaf_kernel
def _find_cut(replay: Replay, splits: Splits, slot: int) -> tuple[Cut, int]:
    """Find where a split cuts the ring of its parent, and the left neighbour's place in the ring.

    `kept` is 0 if the split does not fit the level or is not in canonical order.
    """
    row, ring = slot - 4, replay.ring
    parent = int(splits.parent[row])
    degree, lowest = ring_start(replay, parent)
    begin = 0
    while begin < degree - 1 and ring[begin, NEIGHBOUR] != splits.faces[row, 0, 2]:
        begin += 1
    copy_ring(replay, parent, begin)
    end = int(splits.moved_end[row])
    kept = degree - (end - part_begin(splits.moved_end, row))
    fits = 1 <= kept < degree
    for axis in range(3):
        fits &= replay.position[parent, axis] == splits.coarse[row, axis]
    for side in range(2 if fits else 0):
        fits &= splits.faces[row, side, side] == parent
        fits &= splits.faces[row, side, 1 - side] == slot
        fits &= splits.faces[row, side, 2] == ring[side * kept, NEIGHBOUR]
    for index in range(kept if fits else degree, degree):
        fits &= ring[index, CORNER] == splits.moved[end - degree + index]
    return Cut(parent, slot, degree, kept if fits else 0), (begin - lowest) % degree


@leaf_kernel
def _write_split(
    writer: BitWriter,
    contexts: Contexts,
    replay: Replay,
    splits: Splits,
    group: Group,
    cut: Cut,
    begin: int,
) -> bool:
    """Write a split, and apply it to the level; False if a shift does not fit the level."""
    parent, slot, degree, row = cut.parent, cut.slot, cut.degree, cut.slot - 4
    write_below(writer, parent, slot)
    write_below(writer, begin, degree)
    half = (degree + 1) // 2
    code = cut.kept - half if cut.kept >= half else degree - 1 - cut.kept
    write_adaptive(writer, contexts, KEPT, code)
    frame = find_frame(replay, cut)
    _write_positions(writer, contexts, frame, replay, splits, cut)
    if group.shifts and not _write_shifts(writer, contexts, frame, replay, splits, cut):
        return False
    split_slot(replay, cut)
    _count_shifts(replay, splits, row)
    copy_row(replay.position, parent, splits.fine, row)
    copy_row(replay.position, slot, splits.added, row)
    return True


@inlined_kernel
def _write_positions(
    writer: BitWriter, contexts: Contexts, frame: Frame, replay: Replay, splits: Splits, cut: Cut
) -> None:
    """Write the positions of the parent and the new slot after a split."""
    du, dv, rise = _offset(replay, frame, cut.parent, splits.fine, cut.slot - 4)
    along, off = difference_contexts(frame, PARENT)
    write_differences(writer, contexts, along, off, du - frame.ahead_u, dv - frame.ahead_v, rise)
    eu, ev, rise = _offset(replay, frame, cut.parent, splits.added, cut.slot - 4)
    along, off = difference_contexts(frame, ADDED)
    write_differences(writer, contexts, along, off, eu + du, ev + dv, rise)


@inlined_kernel
def _offset(
    replay: Replay, frame: Frame, slot: int, target: NDArray[Any], row: int
) -> tuple[int, int, int]:
    """Return a position relative to that of a slot and to the plane, for `_move`."""
    position, u, v, w = replay.position, frame.u, frame.v, frame.w
    du = int(target[row, u]) - int(position[slot, u])
    dv = int(target[row, v]) - int(position[slot, v])
    dw = int(target[row, w]) - int(position[slot, w])
    return du, dv, dw - plane_height(frame, du, dv)


@inlined_kernel
def _write_shifts(
    writer: BitWriter, contexts: Contexts, frame: Frame, replay: Replay, splits: Splits, cut: Cut
) -> bool:
    """Write which neighbours move, and move them; False if the splits do not fit the level."""
    begin, end = part_begin(splits.shifted_end, cut.slot - 4), splits.shifted_end[cut.slot - 4]
    left = end - begin
    write_bits(writer, int(left > 0), 1)
    for index in range(cut.degree if left > 0 else 0):
        neighbour = int(replay.ring[index, NEIGHBOUR])
        at = -1
        for candidate in range(begin, end):
            if splits.shifted[candidate] == neighbour:
                at = candidate
        write_bits(writer, int(at >= 0), 1)
        if at < 0:
            continue
        left -= 1
        for axis in range(3):
            if replay.position[neighbour, axis] != splits.shifted_coarse[at, axis]:
                return False
        du, dv, rise = _offset(replay, frame, neighbour, splits.shifted_fine, at)
        along, off = difference_contexts(frame, SHIFTED)
        write_differences(writer, contexts, along, off, du, dv, rise)
        copy_row(replay.position, neighbour, splits.shifted_fine, at)
    return bool(left == 0)
