"""The columns of a group of splits: their bytes in a file, and the test of their validity.

A group holds one column for each quantity of its splits. A column is an array of unsigned integers
whose bytes are transposed, so that the high bytes of all rows follow one another; then deflate
finds the repetitions. All columns of a group are deflated together. ``docs/history-format.md``
specifies the columns.

Positions and device values are differences from the parent before the split. The sums along all
chains of differences are computed together by pointer doubling, so no split is replayed.

Reading tests a group against the level before it, in two steps. A *state* of a face is its three
slots between two splits that change them; all states of a group are rows, sorted by face and time.

1. `_read_connectivity`: the moved corners of each split are a contiguous fan of faces around the
   parent. Each is then a vertex split, which leads from a closed, oriented mesh of genus 0 to
   another one. The neighbours beside the fan are its sides, left and right.
2. `_test_stars`: the determinant of every face in every state is positive.

A group that passes has valid levels only.
"""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.errors import HistoryFileError
from gamutcore.history.splits import Splits

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.geometry import TriangleMesh

Numbers: TypeAlias = NDArray[np.integer[Any]]
"""Whole numbers of any type."""

__all__ = [
    "CORNERS_PER_VERTEX",
    "DAMAGE_REMEDY",
    "LARGEST_COORDINATE",
    "LARGEST_WORK",
    "Column",
    "Group",
    "GroupRows",
    "StoredGroups",
    "columns_of",
    "group_name",
    "pack_group",
    "star_test_work",
]

LARGEST_COORDINATE = 2**24
"""In steps: integers up to this are exact in float32."""

CORNERS_PER_VERTEX = 24
"""Most moved corners, and most moved neighbours, for each vertex at the end of a group. Gamuts have
3. With this limit the memory of a group is proportional to the level before it."""

LARGEST_WORK = 2**26
"""Most states of faces in a group that come from moved vertices: 15 s of the star test. Gamuts have
3 for each split. One vertex of many neighbours that is split many times would exceed it."""

STEP_WORK = 256
"""Time of one vectorised step over all faces, in units of the time of one state."""

DAMAGE_REMEDY = "Give the file as it was delivered, unchanged."


class Column(NamedTuple):
    """A column of a group: one row for each split, moved corner or moved neighbour."""

    name: str
    dtype: str
    width: int
    rows: str


class Group(NamedTuple):
    """The line of the header about a group; it adds slots [start, end)."""

    number: int
    start: int
    end: int
    moved: int
    shifted: int
    nbytes: int
    crc32: int


class GroupRows(NamedTuple):
    """The splits of a group. Its arrays `moved_end` and `shifted_end` count from the group's begin.

    `device` has the columns of `SplitValues` as int64; it is empty without device values.
    """

    splits: Splits
    device: list[Numbers]


class StoredGroups:
    """The groups of a history file, each read and tested on request."""

    def __init__(self, groups: Sequence[Group], contents: Sequence[bytes], scale: int) -> None:
        self._groups = groups
        self._contents = [*contents]
        self._scale = scale

    @property
    def nbytes(self) -> int:
        """Bytes of the groups that are not released."""
        return sum(map(len, self._contents))

    def read(
        self,
        number: int,
        level: TriangleMesh,
        values: Numbers,
        centre: FloatArray,
        step: float,
    ) -> GroupRows:
        """Return the splits of a group after the level before it.

        `values` are the device values of the level, (v, k) with no columns if there are none.
        Damage raises a `HistoryFileError`.
        """
        group = self._groups[number]
        columns = _inflate_columns(group, self._contents[number], values.shape[1])
        start = (level.vertices.astype(np.float64) / step).astype(np.int64)
        splits, device = _read_group(group, columns, start, level.faces, values, centre / step)
        for array in device:
            if array.size and not 0 <= array.min() <= array.max() <= self._scale:
                raise _group_error(group, f"device values are not from 0 to {self._scale}")
        names = ("base_positions", "coarse", "fine", "added", "shifted_coarse", "shifted_fine")
        scaled = {name: (getattr(splits, name) * step).astype(np.float32) for name in names}
        return GroupRows(splits._replace(**scaled), device)

    def release(self, number: int) -> None:
        """Release the bytes of a group."""
        self._contents[number] = b""


def columns_of(channels: int) -> list[Column]:
    """Return the columns of every group, in the order of the file."""
    columns = [
        Column("parent", "i4", 1, "splits"),
        Column("moved_count", "i4", 1, "splits"),
        Column("shifted_count", "i4", 1, "splits"),
        Column("middle", "u4", 3, "splits"),
        Column("edge", "u4", 3, "splits"),
        Column("moved", "i4", 1, "moved"),
        Column("shifted", "i4", 1, "shifted"),
        Column("shift", "u4", 3, "shifted"),
    ]
    if channels:
        columns += [
            Column("device_middle", "u2", channels, "splits"),
            Column("device_edge", "u2", channels, "splits"),
            Column("device_shift", "u2", channels, "shifted"),
        ]
    return columns


def group_name(number: int) -> str:
    """Name of a group in errors."""
    return f"groups.{number:02d}"


def _group_error(group: Group, message: str, slot: int | None = None) -> HistoryFileError:
    """Return the error of a damaged group, which names the group and perhaps the split."""
    place = f"group {group.number} of the history, which adds slots {group.start} to"
    where: dict[str, Any] = {"field": group_name(group.number)}
    if slot is not None:
        where["slot"] = int(slot)
        message = f"in the split that adds slot {slot}, {message}"
    text = f"{place} {group.end - 1}, is damaged: {message}"
    return HistoryFileError(text, where=where, remedy=DAMAGE_REMEDY)


def pack_group(
    splits: Splits, device: Sequence[Numbers], number: int, start: int, end: int
) -> tuple[Group, bytes]:
    """Return the line of the header and the bytes of the splits that add slots [start, end).

    Positions are in steps. `device` has the columns of `SplitValues`, or nothing.
    """
    rows = slice(start - 4, end - 4)
    moved, moved_count = _part(splits.moved_end, rows)
    shifted, shifted_count = _part(splits.shifted_end, rows)
    edge, middle = _edge_and_middle(splits.coarse[rows], splits.fine[rows], splits.added[rows])
    arrays: list[NDArray[Any]] = [
        splits.parent[rows],
        moved_count,
        shifted_count,
        middle,
        edge,
        splits.moved[moved],
        splits.shifted[shifted],
        _fold_signs(splits.shifted_fine[shifted] - splits.shifted_coarse[shifted]),
    ]
    channels = 0
    if device:
        coarse, fine, added, before, after = (array.astype(np.int64) for array in device)
        channels = coarse.shape[1]
        edge, middle = _edge_and_middle(coarse[rows], fine[rows], added[rows])
        arrays += [middle, edge, _fold_signs(after[shifted] - before[shifted])]
    content = zlib.compress(
        b"".join(
            _shuffle_bytes(array.astype("<" + column.dtype))
            for array, column in zip(arrays, columns_of(channels), strict=True)
        )
    )
    counts = moved.stop - moved.start, shifted.stop - shifted.start
    return Group(number, start, end, *counts, len(content), zlib.crc32(content)), content


def _inflate_columns(group: Group, content: bytes, channels: int) -> dict[str, Numbers]:
    """Return the columns of a group, whose checksum and length are tested."""
    if len(content) != group.nbytes or zlib.crc32(content) != group.crc32:
        raise _group_error(group, "its bytes do not have the CRC-32 that the header states")
    rows = {"splits": group.end - group.start, "moved": group.moved, "shifted": group.shifted}
    columns = columns_of(channels)
    sizes = [
        rows[column.rows] * column.width * np.dtype(column.dtype).itemsize for column in columns
    ]
    try:
        inflater = zlib.decompressobj()
        data = inflater.decompress(content, sum(sizes) + 1)
    except zlib.error as cause:
        raise _group_error(group, "its bytes are no deflated columns") from cause
    if len(data) != sum(sizes) or not inflater.eof or inflater.unused_data:
        raise _group_error(group, f"its columns do not have {sum(sizes)} bytes")
    arrays, begin = {}, 0
    for column, size in zip(columns, sizes, strict=True):
        count, numbers = rows[column.rows], column.width
        planes = np.frombuffer(data, np.uint8, size, begin)
        planes = planes.reshape(numbers * np.dtype(column.dtype).itemsize, count)
        array = np.ascontiguousarray(planes.T).view("<" + column.dtype)
        # slots, corners and counts are one number for each row; the others are folded differences
        is_flat = column.dtype == "i4"
        arrays[column.name] = (
            array.reshape(count) if is_flat else _unfold_signs(array.reshape(count, numbers))
        )
        begin += size
    return arrays


def _read_group(
    group: Group,
    columns: Mapping[str, Numbers],
    level: Numbers,
    faces: IndexArray,
    values: Numbers,
    centre: FloatArray,
) -> GroupRows:
    """Return the splits of a group after a level, or refuse them.

    Positions of the level (v, 3), and the centre, are in steps. `values` are the device values of
    the level, (v, 0) without any.
    """
    connectivity = _read_connectivity(group, columns, faces)
    writes = _slot_writes(group, connectivity)
    nodes = _sum_chains(group, writes, level, [columns[n] for n in ("middle", "edge", "shift")])
    x, y, z = np.abs(nodes[group.start :].T) > LARGEST_COORDINATE
    message = "a coordinate is beyond 2^24 steps"
    _refuse_first(group, x | y | z, writes.time[group.start :], message)
    _test_stars(group, faces, connectivity, writes, nodes - centre)
    splits, start, end = len(connectivity.parent), group.start, group.end
    coarse = nodes[writes.before]
    # nodes are the start level, then fine and added positions of all splits, then shifted ones
    fine, added, shifted = np.split(nodes[start:], [splits, 2 * splits])
    added_slots = np.arange(start, end)
    parent, sides = connectivity.parent, connectivity.sides
    new_faces = (parent, added_slots, sides[:, 0], added_slots, parent, sides[:, 1])
    rows = Splits(
        base_positions=cast("Any", level),
        base_faces=faces,
        parent=parent.astype(np.int32),
        coarse=cast("Any", coarse[:splits]),
        fine=cast("Any", fine),
        added=cast("Any", added),
        faces=np.stack(new_faces, axis=1).reshape(-1, 2, 3).astype(np.int32),
        moved_end=columns["moved_count"].cumsum().astype(np.int32),
        moved=connectivity.moved.astype(np.int32),
        shifted_end=columns["shifted_count"].cumsum().astype(np.int32),
        shifted=connectivity.shifted.astype(np.int32),
        shifted_coarse=cast("Any", coarse[2 * splits :]),
        shifted_fine=cast("Any", shifted),
    )
    if "device_edge" not in columns:
        return GroupRows(rows, [])
    names = ("device_middle", "device_edge", "device_shift")
    nodes = _sum_chains(group, writes, values, [columns[name] for name in names])
    fine, added, shifted = np.split(nodes[start:], [splits, 2 * splits])
    coarse = nodes[writes.before]
    return GroupRows(rows, [coarse[:splits], fine, added, coarse[2 * splits :], shifted])


def _part(ends: IndexArray, rows: slice) -> tuple[slice, IndexArray]:
    """Return the part of the elements of some splits, and their number for each split."""
    begin = int(ends[rows.start - 1]) if rows.start else 0
    return slice(begin, int(ends[rows.stop - 1])), np.diff(ends[rows], prepend=begin)


def _shuffle_bytes(array: NDArray[Any]) -> bytes:
    """Return the first bytes of all rows, then the second bytes, and so on."""
    return array.view(np.uint8).reshape(len(array), -1).T.tobytes() if array.size else b""


def _fold_signs(numbers: NDArray[Any]) -> NDArray[Any]:
    """Return numbers without a sign: 0, 1, 2, 3, 4 for 0, −1, 1, −2, 2, and so on."""
    return np.where(numbers < 0, -2 * numbers - 1, 2 * numbers)


def _unfold_signs(numbers: NDArray[Any]) -> IndexArray:
    """Invert `_fold_signs`."""
    half = (numbers >> 1).astype(np.int32)
    return half ^ -(numbers & 1).astype(np.int32)


def _edge_and_middle(
    coarse: NDArray[Any], fine: NDArray[Any], added: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the columns `edge` and `middle` of a value before and after splits."""
    edge = added - fine
    return _fold_signs(edge), _fold_signs(fine + (edge >> 1) - coarse)


def _refuse_first(group: Group, faulty: NDArray[Any], time: Numbers, message: str) -> None:
    """Refuse the group if any row is faulty; name the first split. Its slot is start + time − 1."""
    if faulty.any():
        raise _group_error(group, message, group.start + int(time[faulty].min()) - 1)


class _Connectivity(NamedTuple):
    """Splits of a group without positions.

    Time i + 1 is split i of the group, and 0 is the level before it. The states of faces with
    moved corners are rows of a table, sorted by face and time.
    """

    parent: Numbers
    moved: Numbers
    moved_split: Numbers
    shifted: Numbers
    shifted_split: Numbers
    sides: Numbers  # (n, 2) slots left and right
    move: Numbers  # row of each moved corner
    first_move: Numbers  # row of the first move of each face; `rows` without one
    rows: int


def _read_connectivity(
    group: Group, columns: Mapping[str, Numbers], faces: IndexArray
) -> _Connectivity:
    """Return the connectivity of a group after a level; refuse all but vertex splits."""
    start, splits = group.start, group.end - group.start
    index = np.arange(splits, dtype=np.int32)
    slots = index + np.int32(start)
    parent, moved, shifted = columns["parent"], columns["moved"], columns["shifted"]
    counts = columns["moved_count"]
    for name, most in (("moved", group.moved), ("shifted", group.shifted)):
        number = columns[f"{name}_count"]
        if number.min() < 0 or number.sum(dtype=np.int64) != most:
            raise _group_error(group, f"the counts of {name!r} are not those of its rows")
    _refuse_first(group, counts < 1, index + 1, "no corner moves")
    _refuse_first(group, (parent < 0) | (parent >= slots), index + 1, "the parent does not exist")
    split = np.repeat(index, counts)
    moved_face = moved // 3
    beyond = (moved < 0) | (moved_face >= 2 * slots[split] - 4)
    _refuse_first(group, beyond, split + 1, "a corner that moves does not exist")
    shifted_split = np.repeat(index, columns["shifted_count"])
    disorder = (shifted < 0) | (shifted >= slots[shifted_split])
    disorder |= shifted == parent[shifted_split]
    disorder[1:] |= (np.diff(shifted) <= 0) & (np.diff(shifted_split) == 0)
    message = "the neighbours that move do not exist, or are not ascending"
    _refuse_first(group, disorder, shifted_split + 1, message)

    # One row for each face with moved corners, and one for each of these, by face and time. Slots
    # that are not known yet are negative: −1 − 2i is left of split i, and −2 − 2i is right.
    old, new = len(faces), 2 * splits
    moves = np.bincount(moved_face, minlength=old + new)
    changed = np.flatnonzero(moves)
    birth = np.arange(len(changed)) + moves[changed].cumsum() - moves[changed]
    order = np.argsort(moved_face.astype(np.int64) * (splits + 1) + split)
    move = np.empty_like(order)
    move[order] = np.arange(len(order)) + np.repeat(np.arange(1, len(changed) + 1), moves[changed])
    twice = np.append(False, (np.diff(moved_face[order]) == 0) & (np.diff(split[order]) == 0))
    _refuse_first(group, twice, split[order] + 1, "a face moves two corners")
    born = (
        np.stack([parent, slots], axis=1).reshape(-1),
        np.stack([slots, parent], axis=1).reshape(-1),
        -1 - np.arange(new, dtype=np.int32),
    )
    # Each place of a face has the slot of the last row that sets it.
    moved_place = moved - 3 * moved_face
    corners = np.empty((3, len(changed) + len(moved)), np.int32)
    first_new = int(np.searchsorted(changed, old))
    for place in range(3):
        last = np.zeros(corners.shape[1], np.int32)
        last[birth] = birth
        corners[place, birth[:first_new]] = faces[changed[:first_new], place]
        corners[place, birth[first_new:]] = born[place][changed[first_new:] - old]
        here = moved_place == place
        last[move[here]] = move[here]
        corners[place, move[here]] = slots[split[here]]
        corners[place] = corners[place].take(np.maximum.accumulate(last))
    first_move = np.full(old + new, corners.shape[1])
    first_move[changed] = birth + 1

    next_place, previous_place = (moved_place + 1) % 3, (moved_place + 2) % 3
    ends = counts.cumsum()
    sides = np.stack(
        [
            corners[previous_place[ends - 1], move[ends - 1]],
            corners[next_place[ends - counts], move[ends - counts]],
        ],
        axis=1,
    ).reshape(-1)
    # unknown slots refer to earlier splits
    while (unknown := np.flatnonzero(sides < 0)).size:
        sides[unknown] = sides[-1 - sides[unknown]]
    later = corners < 0
    corners[later] = sides[-1 - corners[later]]
    wrong = corners[moved_place, move - 1] != parent[split]
    follows = np.diff(split) == 0
    left, right = corners[previous_place, move], corners[next_place, move]
    wrong[1:] |= follows & (left[:-1] != right[1:])
    wrong[ends - 1] |= sides[::2] == sides[1::2]
    message = "the corners that move are no fan around the parent"
    _refuse_first(group, wrong, split + 1, message)
    return _Connectivity(
        parent,
        moved,
        split,
        shifted,
        shifted_split,
        sides.reshape(-1, 2),
        move,
        first_move,
        corners.shape[1],
    )


class _Writes(NamedTuple):
    """Changes of the values of slots: the level, then fine, added and shifted ones of all splits.

    Their keys are sorted by slot and time; `order` are the changes in this order, and `rank` is
    the inverse. `before` is the change before each fine, added or shifted one: of the same slot,
    or, for an added one, that of its parent.
    """

    slot: Numbers
    time: Numbers
    keys: Numbers
    order: Numbers
    rank: Numbers
    before: Numbers


def _slot_writes(group: Group, splits: _Connectivity) -> _Writes:
    start, count = group.start, group.end - group.start
    times = np.arange(1, count + 1)
    slot = np.concatenate(
        [np.arange(start), splits.parent, np.arange(start, group.end), splits.shifted]
    )
    time = np.concatenate([np.zeros(start, np.int64), times, times, splits.shifted_split + 1])
    keys = slot.astype(np.int64) * (count + 1) + time
    order = np.argsort(keys)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    before = order[rank[start:] - 1]
    before[count : 2 * count] = np.arange(start, start + count)
    return _Writes(slot, time, keys[order], order, rank, before)


def _sum_chains(
    group: Group, writes: _Writes, level: NDArray[Any], columns: list[Numbers]
) -> Numbers:
    """Return the values of all writes from those of the level and the columns of differences.

    The columns are the middle of both ends of the new edge, the edge, and the shifts.
    """
    middle, edge, shift = columns
    total = np.concatenate([level.astype(np.int64), middle - (edge >> 1), edge, shift])
    to = np.concatenate([np.full(group.start, -1), writes.before])
    # pointer doubling: each round adds twice as long a part of every chain
    left = np.flatnonzero(to >= 0)
    while left.size:
        target = to[left]
        total[left] += total.take(target, axis=0)
        to[left] = further = to[target]
        left = left[further >= 0]
    return total


def _test_stars(
    group: Group,
    faces: IndexArray,
    splits: _Connectivity,
    writes: _Writes,
    positions: FloatArray,
) -> None:
    """Refuse the group unless every face has the centre on its inner side in every state.

    Positions are relative to the centre, by the number of the write. All faces step together, each
    from one of its states to the next: a slot of the face is written, or a corner moves.
    """
    start, count, width = group.start, group.end - group.start, group.end - group.start + 1
    never = np.int32(width)
    position, rank = positions[writes.order], writes.rank.astype(np.int32)
    fine, added = rank[start : start + count], rank[start + count : start + 2 * count]
    # when the slot of each write is written again, by the rank of the write
    times, slots = writes.time[writes.order].astype(np.int32), writes.slot[writes.order]
    rewritten = np.where(np.append(slots[1:] == slots[:-1], False), np.append(times[1:], 0), never)
    rewritten = rewritten.astype(np.int32)
    # rows of the table; the last one stands for no move
    moving = np.full(splits.rows + 1, never)
    moving[splits.move] = splits.moved_split + 1
    moved_place = np.zeros(len(moving), np.int8)
    moved_place[splits.move] = splits.moved % 3
    moved_rank = np.zeros(len(moving), np.int32)
    moved_rank[splits.move] = added[splits.moved_split]

    def test(ranks: IndexArray, time: NDArray[Any]) -> None:
        one, two, three = (position.take(ranks[:, place], axis=0).T for place in range(3))
        volume = (
            one[0] * (two[1] * three[2] - two[2] * three[1])
            + one[1] * (two[2] * three[0] - two[0] * three[2])
            + one[2] * (two[0] * three[1] - two[1] * three[0])
        )
        # writers keep determinants so far above zero that no order of operations matters
        message = "a face does not see the centre from inside"
        _refuse_first(group, ~(volume > 0), time, message)

    # Faces of the level take part if one of their slots is written, or a corner moves.
    old, born = len(faces), np.repeat(np.arange(1, width, dtype=np.int32), 2)
    is_written = rewritten[rank[:start]] < never
    moves_corner = splits.first_move[:old] < splits.rows
    a, b, c = faces.T
    changed = np.flatnonzero(is_written[a] | is_written[b] | is_written[c] | moves_corner)
    current = np.empty((2 * count, 3), np.int32)
    current[::2, 0] = current[1::2, 1] = fine
    current[::2, 1] = current[1::2, 0] = added
    keys = splits.sides.reshape(-1).astype(np.int64) * width + born
    current[:, 2] = np.searchsorted(writes.keys, keys, "right") - 1
    test(current, born)
    current = np.concatenate([rank[faces[changed]], current])
    next_move = np.concatenate([splits.first_move[changed], splits.first_move[old:]])
    work = 0
    while True:
        written, move = rewritten.take(current), moving.take(next_move)
        time = np.minimum(np.minimum(written[:, 0], written[:, 1]), np.minimum(written[:, 2], move))
        left = np.flatnonzero(time < never)
        if not left.size:
            return
        work += len(left) + STEP_WORK
        if work > LARGEST_WORK:
            raise _group_error(group, "too many triangles meet at vertices that move")
        time, written, move, next_move = time[left], written[left], move[left], next_move[left]
        current = current[left]
        current += written == time[:, np.newaxis]
        moves = np.flatnonzero(move == time)
        rows = next_move[moves]
        current[moves, moved_place[rows]] = moved_rank[rows]
        next_move[moves] += 1
        test(current, time)


def star_test_work(splits: Splits) -> tuple[int, int]:
    """Return an upper bound of the work of the star test, and the largest degree of a slot."""
    count = len(splits.parent)
    index, added = np.arange(count), np.arange(4, count + 4)
    moved = np.diff(splits.moved_end, prepend=0)
    shifting = np.repeat(index, np.diff(splits.shifted_end, prepend=0))
    sides = splits.faces[:, :, 2]
    written = np.concatenate([splits.parent, splits.shifted])
    slot = np.concatenate([np.arange(4), written, added, sides[:, 0], sides[:, 1]])
    time = np.concatenate([np.full(4, -1), index, shifting, index, index, index])
    one = np.ones(count, np.int64)
    change = np.concatenate(
        [np.full(4, 3), 2 - moved, np.zeros(len(shifting), np.int64), moved + 2, one, one]
    )
    order = np.lexsort((time, slot))
    total, change = change[order].cumsum(), change[order]
    starts = np.flatnonzero(np.diff(slot[order], prepend=-1))
    degree = np.empty(len(order), np.int64)
    degree[order] = total - np.repeat(
        total[starts] - change[starts], np.diff(starts, append=len(order))
    )
    states = int(degree[4 : 4 + len(written)].sum()) + len(splits.moved) + 2 * count
    steps = 3 * np.bincount(written).max(initial=0) + np.bincount(splits.moved // 3).max(initial=0)
    return states + STEP_WORK * int(steps), int(degree.max())
