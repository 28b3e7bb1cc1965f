"""The codec of splits: each split is predicted from the level before it, and coded as bits.

The ring of the parent gives the plane that both vertices nearly lie in. It also gives the likely
size of the differences, and a first guess of the positions. Writer and reader both replay the
history, and compute predictions alike: in integers and in float64 operations of a fixed order,
which ``docs/history-format.md`` specifies.

The format can only describe splits of closed, oriented meshes of genus 0, whatever the bits are.
The reader tests that each face a split adds or changes has the centre on its inner side. Every
level that was read is therefore valid. Work and memory are bounded by the length of the stream.
Each group is unpacked and checked when a level first needs it. Groups that nobody asks for cost
nothing but the bytes of their streams.

Kernels that allocate or return arrays count references, which takes longer than the work. Both
loops over splits are therefore leaf kernels. They stop where an array has no room for the next
split, and are called again with longer arrays.

The prediction comes first, then the kernels that read and write a group, then `PackedSplits` and
`split_streams`, which call them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.errors import HistoryFileError, NeighbourLimitError
from gamutcore.history.bit_codes import (
    DAMAGE_REMEDY,
    LENGTH_CLASSES,
    LONGEST_CODE,
    SPLITS,
    BitReader,
    BitWriter,
    Contexts,
    Streams,
    doublings_beyond,
    read_adaptive,
    read_below,
    read_bits,
    read_differences,
    stream_bytes,
    write_adaptive,
    write_below,
    write_bits,
    write_differences,
)
from gamutcore.history.replay import (
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
    first_replay,
    has_room,
    larger_replay,
    ring_start,
    split_slot,
    star_sees_centre,
)
from gamutcore.history.splits import (
    Splits,
    ascending_order,
    copy_row,
    empty_splits,
    extended_copy,
    group_ranges,
    part_begin,
)
from gamutcore.kernels import inlined_kernel, leaf_kernel

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from gamutcore.arrays import ByteArray

__all__ = [
    "FAULTS",
    "KEPT",
    "LARGEST_COORDINATE",
    "MINIMUM_SPLIT_BITS",
    "MISFIT",
    "OK",
    "Group",
    "PackedSplits",
    "first_contexts",
    "read_group",
    "split_streams",
    "splits_in_steps",
    "write_group",
]


KEPT = 0
"""Context of the number of faces that the parent keeps."""

PARENT, ADDED, SHIFTED = 1, 3, 5
"""Differences of the parent, the new slot and a neighbour that moves: the kind of the differences
along the plane of the ring. The next kind has those off the plane."""

KINDS = 7
"""Kinds of numbers. Each has a context for every length class."""


class _Frame(NamedTuple):
    """Prediction of a split. Lengths are in steps, relative to the parent before the split."""

    u: int
    v: int
    w: int  # the axis closest to the normal of the ring; u and v are the other axes
    # rise in w per step in u and v of the plane through the parent, across that normal
    slope_u: float
    slope_v: float
    # expected position of the parent after the split
    ahead_u: int
    ahead_v: int
    # length classes of the neighbours' distances, and of their distances from the plane
    size: int
    height: int


@inlined_kernel
def _find_frame(replay: Replay, cut: Cut) -> _Frame:
    """Return the prediction of a split from the level before it."""
    position, ring = replay.position, replay.ring
    slot, degree, kept = cut.parent, cut.degree, cut.kept
    cx, cy, cz = int(position[slot, 0]), int(position[slot, 1]), int(position[slot, 2])
    near_x, near_y, near_z, far_x, far_y, far_z = 0, 0, 0, 0, 0, 0
    normal_x, normal_y, normal_z = 0.0, 0.0, 0.0
    distance = 0
    left = ring[0, NEIGHBOUR]
    x = int(position[left, 0]) - cx
    y = int(position[left, 1]) - cy
    z = int(position[left, 2]) - cz
    for index in range(degree):
        neighbour = ring[index + 1, NEIGHBOUR] if index + 1 < degree else left
        px, py, pz = x, y, z
        x = int(position[neighbour, 0]) - cx
        y = int(position[neighbour, 1]) - cy
        z = int(position[neighbour, 2]) - cz
        distance += abs(px) + abs(py) + abs(pz)
        if index <= kept:
            near_x, near_y, near_z = near_x + px, near_y + py, near_z + pz
        if index >= kept or index == 0:
            far_x, far_y, far_z = far_x + px, far_y + py, far_z + pz
        ax, ay, az = float(px), float(py), float(pz)
        bx, by, bz = float(x), float(y), float(z)
        normal_x += ay * bz - az * by
        normal_y += az * bx - ax * bz
        normal_z += ax * by - ay * bx

    normal = (normal_x, normal_y, normal_z)
    w = 0
    if abs(normal[1]) > abs(normal[0]):
        w = 1
    if abs(normal[2]) > abs(normal[w]):
        w = 2
    u, v = (w + 1) % 3, (w + 2) % 3
    slope_u, slope_v = 0.0, 0.0
    if normal[w] != 0.0:
        slope_u, slope_v = -normal[u] / normal[w], -normal[v] / normal[w]

    centre = (cx, cy, cz)
    off = 0.0
    for index in range(degree):
        neighbour = ring[index, NEIGHBOUR]
        du = float(position[neighbour, u] - centre[u])
        dv = float(position[neighbour, v] - centre[v])
        dw = float(position[neighbour, w] - centre[w])
        off += abs(dw - (slope_u * du + slope_v * dv))

    near, far = (near_x, near_y, near_z), (far_x, far_y, far_z)
    near_count, far_count = kept + 1, degree - kept + 1
    return _Frame(
        u,
        v,
        w,
        slope_u,
        slope_v,
        _expected_offset(near[u], near_count, far[u], far_count),
        _expected_offset(near[v], near_count, far[v], far_count),
        min(doublings_beyond(distance, degree), LENGTH_CLASSES - 1),
        min(doublings_beyond(math.floor(off), degree), LENGTH_CLASSES - 1),
    )


@inlined_kernel
def _expected_offset(near: int, near_count: int, far: int, far_count: int) -> int:
    """Expected offset of the parent along an axis, from sums over both parts of its ring.

    The parent goes towards the middle of the neighbours that it keeps, and away from the others.
    The factors 0.4 and 0.2 are the best round numbers on real gamuts.
    """
    return math.floor((2.0 * (near / near_count) - far / far_count) / 5.0 + 0.5)


def first_contexts() -> Contexts:
    """Return the contexts at the beginning of a file: a guess for each length class."""
    total = np.tile(2 ** np.arange(LENGTH_CLASSES, dtype=np.int64) // 2, KINDS)
    return Contexts(total, np.ones(KINDS * LENGTH_CLASSES, np.int64))


@inlined_kernel
def _difference_contexts(frame: _Frame, kind: int) -> tuple[int, int]:
    """Contexts of the differences of a position along the plane and off it."""
    along = frame.height if kind == ADDED else frame.size
    return LENGTH_CLASSES * kind + along, LENGTH_CLASSES * (kind + 1) + frame.height


@inlined_kernel
def _plane_height(frame: _Frame, along_u: int, along_v: int) -> int:
    """Height of the plane in w, rounded to whole steps, halves upwards."""
    return math.floor(frame.slope_u * along_u + frame.slope_v * along_v + 0.5)


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
    """A group of splits: those that add slots [start, end)."""

    start: int
    end: int
    shifts: int  # 1 if any of its splits moves neighbours, else 0


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
    frame = _find_frame(replay, cut)
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
    reader: BitReader, contexts: Contexts, frame: _Frame, replay: Replay, cut: Cut
) -> bool:
    """Read and set the positions of the parent and the new slot; False if one is out of range."""
    parent = cut.parent
    along, off = _difference_contexts(frame, PARENT)
    du, dv, dw = read_differences(reader, contexts, along, off)
    du, dv = du + frame.ahead_u, dv + frame.ahead_v
    along, off = _difference_contexts(frame, ADDED)
    eu, ev, ew = read_differences(reader, contexts, along, off)
    # both are relative to the parent before the split
    return _move(replay, frame, parent, cut.slot, eu - du, ev - dv, ew) and _move(
        replay, frame, parent, parent, du, dv, dw
    )


@inlined_kernel
def _move(
    replay: Replay, frame: _Frame, origin: int, slot: int, du: int, dv: int, rise: int
) -> bool:
    """Set a position relative to that of a slot and to the plane; False if it is out of range."""
    position, u, v, w = replay.position, frame.u, frame.v, frame.w
    x, y = int(position[origin, u]) + du, int(position[origin, v]) + dv
    z = int(position[origin, w]) + rise + _plane_height(frame, du, dv)
    if max(abs(x), abs(y), abs(z)) > LARGEST_COORDINATE:
        return False
    position[slot, u], position[slot, v], position[slot, w] = x, y, z
    return True


@inlined_kernel
def _read_shifts(
    reader: BitReader,
    contexts: Contexts,
    frame: _Frame,
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
        along, off = _difference_contexts(frame, SHIFTED)
        du, dv, dw = read_differences(reader, contexts, along, off)
        if not _move(replay, frame, slot, slot, du, dv, dw):
            return False
        copy_row(splits.shifted_fine, shifted, replay.position, slot)
        splits.shifted_end[row] = shifted + 1
    return True


@leaf_kernel
def write_group(
    writer: BitWriter, contexts: Contexts, replay: Replay, splits: Splits, group: Group, first: int
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
    frame = _find_frame(replay, cut)
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
    writer: BitWriter, contexts: Contexts, frame: _Frame, replay: Replay, splits: Splits, cut: Cut
) -> None:
    """Write the positions of the parent and the new slot after a split."""
    du, dv, rise = _offset(replay, frame, cut.parent, splits.fine, cut.slot - 4)
    along, off = _difference_contexts(frame, PARENT)
    write_differences(writer, contexts, along, off, du - frame.ahead_u, dv - frame.ahead_v, rise)
    eu, ev, rise = _offset(replay, frame, cut.parent, splits.added, cut.slot - 4)
    along, off = _difference_contexts(frame, ADDED)
    write_differences(writer, contexts, along, off, eu + du, ev + dv, rise)


@inlined_kernel
def _offset(
    replay: Replay, frame: _Frame, slot: int, target: NDArray[Any], row: int
) -> tuple[int, int, int]:
    """Return a position relative to that of a slot and to the plane, for `_move`."""
    position, u, v, w = replay.position, frame.u, frame.v, frame.w
    du = int(target[row, u]) - int(position[slot, u])
    dv = int(target[row, v]) - int(position[slot, v])
    dw = int(target[row, w]) - int(position[slot, w])
    return du, dv, dw - _plane_height(frame, du, dv)


@inlined_kernel
def _write_shifts(
    writer: BitWriter, contexts: Contexts, frame: _Frame, replay: Replay, splits: Splits, cut: Cut
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
        along, off = _difference_contexts(frame, SHIFTED)
        write_differences(writer, contexts, along, off, du, dv, rise)
        copy_row(replay.position, neighbour, splits.shifted_fine, at)
    return bool(left == 0)


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
