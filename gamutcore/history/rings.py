"""The rings of a level while a history is written or read: the faces around each slot, in order.

Most rings are short lists. The few that a vertex with hundreds of neighbours has would make the
time quadratic as lists, as each split beside it searches through all of its ring and shifts a good
part of it; they are linked by their corners instead. In a linked ring nothing is searched for: the
faces around the slot that is split say which corners its neighbours have in them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import IndexArray, LongArray
from gamutcore.history.groups import lengthened
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

__all__ = [
    "LINKED",
    "LONGEST_LIST",
    "MOST_VISITED",
    "VISITED",
    "VISITED_PER_VERTEX",
    "WALKED",
    "Replay",
    "copy_ring",
    "has_room",
    "replay_for",
    "replay_of",
    "ring_of",
    "split_slot",
    "with_room",
]

SMALLEST_ROOM = 8
"""Entries that a ring has room for at the beginning; most rings never have more."""

LONGEST_LIST = 256
"""Rings with more entries are linked. Real gamuts have none; lists are twice as fast while they are
short."""

LINKED = 0
"""The room of a linked ring."""

TAKEN, VISITED = range(2)
"""Places in `Replay.used`."""

WALKED = 32
"""What an entry counts in `VISITED` if its neighbour's place is looked at as well, and one that is
only searched through being 1: about so much longer it takes, 27 ns in rings of 20,000."""

MOST_VISITED, VISITED_PER_VERTEX = 2**32, 2048
"""Up to which `VISITED` a history of V vertices is written and read: the former, and the latter for
each vertex; four seconds, and two microseconds for each vertex. Real histories need about 250 V.
Only the rings of parents and of neighbours that move are walked along whatever their length, so no
number of neighbours is too large in itself: it is where thousands of splits are those of slots that
have tens of thousands each."""


class Replay(NamedTuple):
    """A level in arrays that have room for finer ones.

    Its connectivity is the ring of each slot: the faces around it, counter-clockwise, each as its
    corner at the slot and the slot that follows in it. Everything that a split changes is then in a
    few places that do not depend on each other, which takes half the time of walking through a
    corner table (docs/decisions/compact-histories.md).

    Attributes
    ----------
    position : (V, 3) int32
        In steps of the grid.
    span : (V, 3) int32
        Of a list: where it begins in `entries`, how long it is, and how much room there is. Of a
        linked ring: one of its corners, how long it is, and `LINKED`.
    entries : (n, 2) int32
        Corner and following slot.
    links : (0 or ≥ 6 V - 12, 2) int32
        Of each corner in a linked ring: the next corner, and the following slot. Empty until there
        is such a ring.
    used : (2,) int64
        How many entries are taken, by lists or by what they have outgrown; and how many entries
        have been looked at, those of the rings that were walked along times `WALKED`.
    """

    position: IndexArray
    span: IndexArray
    entries: IndexArray
    links: IndexArray
    used: LongArray


def replay_of(positions: IndexArray, faces: IndexArray, vertices: int = 4) -> Replay:
    """Return the coarsest level, ready to be refined.

    Parameters
    ----------
    positions : (4, 3) int32
        In steps.
    faces : (4, 3) int32
        A closed, oriented tetrahedron.
    vertices : int, optional
        That there is to be room for.

    Returns
    -------
    Replay
    """
    replay = Replay(
        np.empty((vertices, 3), np.int32),
        np.empty((vertices, 3), np.int32),
        np.empty((_entries_for(vertices), 2), np.int32),
        np.empty((0, 2), np.int32),
        np.zeros(2, np.int64),
    )
    replay.position[:4] = positions
    for slot in range(4):
        corners = np.flatnonzero(faces.ravel() == slot)
        following = {int(faces[c // 3, (c + 1) % 3]): int(c) for c in corners}
        preceding = {int(c): int(faces[c // 3, (c + 2) % 3]) for c in corners}
        corner = int(corners[0])
        for index in range(3):
            neighbour = int(faces[corner // 3, (corner + 1) % 3])
            replay.entries[SMALLEST_ROOM * slot + index] = corner, neighbour
            corner = following[preceding[corner]]
        replay.span[slot] = SMALLEST_ROOM * slot, 3, SMALLEST_ROOM
    replay.used[TAKEN] = 4 * SMALLEST_ROOM
    return replay


def replay_for(replay: Replay, vertices: int) -> Replay:
    """Return the same level with room for so many vertices and for rings of the usual length."""
    return Replay(
        lengthened(replay.position, vertices),
        lengthened(replay.span, vertices),
        lengthened(replay.entries, max(_entries_for(vertices), len(replay.entries))),
        lengthened(replay.links, 6 * vertices) if len(replay.links) else replay.links,
        replay.used,
    )


def _entries_for(vertices: int) -> int:
    return SMALLEST_ROOM * vertices + 64


@inlined_kernel
def ring_of(replay: Replay, slot: int) -> tuple[int, int]:
    """Return the length of a slot's ring, and where the face with the smallest number is in it."""
    begin, degree = replay.span[slot, 0], replay.span[slot, 1]
    lowest = 0
    if replay.span[slot, 2] == LINKED:
        corner = smallest = begin
        for index in range(1, degree):
            corner = replay.links[corner, 0]
            if corner < smallest:
                lowest, smallest = index, corner
        return degree, lowest
    smallest = replay.entries[begin, 0]
    for index in range(1, degree):
        corner = replay.entries[begin + index, 0]
        if corner < smallest:
            lowest, smallest = index, corner
    return degree, lowest


@inlined_kernel
def copy_ring(replay: Replay, slot: int, start: int, ring: IndexArray) -> None:
    """Copy a slot's ring, beginning with its entry number `start`.

    Parameters
    ----------
    replay : Replay
    slot, start : int
    ring : (≥ degree, 2) int32
        Receives the entries.
    """
    begin, degree = replay.span[slot, 0], replay.span[slot, 1]
    if replay.span[slot, 2] == LINKED:
        corner = begin
        copied = degree - start if start > 0 else 0
        for _ in range(degree):
            ring[copied, 0], ring[copied, 1] = corner, replay.links[corner, 1]
            corner = replay.links[corner, 0]
            copied = copied + 1 if copied + 1 < degree else 0
        return
    index = start
    for copied in range(degree):
        ring[copied, 0] = replay.entries[begin + index, 0]
        ring[copied, 1] = replay.entries[begin + index, 1]
        index = index + 1 if index + 1 < degree else 0


@inlined_kernel
def has_room(replay: Replay, ring: IndexArray, degree: int, kept: int) -> bool:
    """Whether `split_slot` finds room for all rings that may have to go elsewhere."""
    left, right = replay.span[ring[0, 1], 1], replay.span[ring[kept, 1], 1]
    if max(degree, left, right) >= LONGEST_LIST and len(replay.links) == 0:
        return False
    needed = _room_needed(degree, left, right)
    return bool(replay.used[TAKEN] + needed <= len(replay.entries))


@kernel
def with_room(replay: Replay, ring: IndexArray, degree: int, kept: int) -> Replay:
    """Return the same level with room for a split."""
    left, right = replay.span[ring[0, 1], 1], replay.span[ring[kept, 1], 1]
    entries, links = replay.entries, replay.links
    needed = _room_needed(degree, left, right)
    if replay.used[TAKEN] + needed > len(entries):
        entries = np.empty((2 * (replay.used[TAKEN] + needed), 2), np.int32)
        for index in range(replay.used[TAKEN]):
            entries[index, 0] = replay.entries[index, 0]
            entries[index, 1] = replay.entries[index, 1]
    if max(degree, left, right) >= LONGEST_LIST and len(links) == 0:
        links = np.empty((6 * len(replay.position), 2), np.int32)
    return Replay(replay.position, replay.span, entries, links, replay.used)


@inlined_kernel
def _room_needed(degree: int, left: int, right: int) -> int:
    """How many entries the rings that a split changes may take, from their lengths before it."""
    parts = 4 * (min(degree, LONGEST_LIST) + 2)
    sides: int = 2 * (min(left, LONGEST_LIST) + min(right, LONGEST_LIST) + 2)
    return parts + sides + 4 * SMALLEST_ROOM


@inlined_kernel
def split_slot(
    replay: Replay, parent: int, slot: int, ring: IndexArray, degree: int, kept: int
) -> None:
    """Split a slot: give part of its faces to a new one, and put two new faces between them.

    The new faces are (parent, slot, left) and (slot, parent, right).

    Parameters
    ----------
    replay : Replay
        A level with `slot` vertices and room for one more, whose position is not touched.
    parent, slot : int
    ring : (≥ degree, 2) int32
        The parent's ring, beginning with the face (parent, left, ...).
    degree : int
    kept : int
        How many of the faces the parent keeps, from the first one on; 1 ≤ kept < degree.
    """
    left, right = ring[0, 1], ring[kept, 1]
    one, two = 6 * slot - 12, 6 * slot - 9
    visited = WALKED * degree
    for index in range(kept + 1, degree):
        visited += _renamed(replay, ring[index, 1], _before(ring[index - 1, 0]), slot)
    # left has the parent in the ring's first face and in its last one; right in those beside it
    last = _before(ring[degree - 1, 0])
    visited += _inserted(replay, left, _after(ring[0, 0]), last, one + 2, parent)
    visited += _renamed(replay, left, last, slot)
    last = _before(ring[kept - 1, 0])
    visited += _inserted(replay, right, _after(ring[kept, 0]), last, two + 2, slot)
    replay.used[VISITED] += visited

    _store(replay, parent, ring, 0, kept, two + 1, right, one, slot)
    replay.span[slot, 1], replay.span[slot, 2] = 0, 0
    _store(replay, slot, ring, kept, degree, one + 1, left, two, parent)


@inlined_kernel
def _before(corner: int) -> int:
    """Return the corner before one in its face."""
    return corner - 1 if corner % 3 > 0 else corner + 2


@inlined_kernel
def _after(corner: int) -> int:
    """Return the corner behind one in its face."""
    return corner + 1 if corner % 3 < 2 else corner - 2


@inlined_kernel
def _renamed(replay: Replay, slot: int, corner: int, names: int) -> int:
    """Let the entry of a corner name another slot; returns how many entries were looked at."""
    entry, degree = replay.span[slot, 0], replay.span[slot, 1]
    if replay.span[slot, 2] == LINKED:
        replay.links[corner, 1] = names
        return 1
    while replay.entries[entry, 0] != corner:
        entry += 1
    replay.entries[entry, 1] = names
    return int(degree)


@leaf_kernel
def _inserted(
    replay: Replay, slot: int, previous: int, following: int, corner: int, names: int
) -> int:
    """Put an entry between two, told by their corners; returns how many were looked at."""
    span, entries, links = replay.span, replay.entries, replay.links
    begin: int = span[slot, 0]
    degree: int = span[slot, 1]
    if degree == LONGEST_LIST and span[slot, 2] != LINKED:
        for index in range(degree):
            place = begin + index
            behind = place + 1 if index + 1 < degree else begin
            links[entries[place, 0], 0] = entries[behind, 0]
            links[entries[place, 0], 1] = entries[place, 1]
        span[slot, 0], span[slot, 2] = entries[begin, 0], LINKED
    if span[slot, 2] == LINKED:
        links[previous, 0] = corner
        links[corner, 0], links[corner, 1] = following, names
        span[slot, 1] = degree + 1
        return 1
    gap = 0
    while entries[begin + gap, 0] != following:
        gap += 1
    to = _room_for(replay, slot, degree + 1)
    if to != begin:
        for index in range(gap):
            entries[to + index, 0] = entries[begin + index, 0]
            entries[to + index, 1] = entries[begin + index, 1]
    for index in range(degree - 1, gap - 1, -1):
        entries[to + index + 1, 0] = entries[begin + index, 0]
        entries[to + index + 1, 1] = entries[begin + index, 1]
    entries[to + gap, 0], entries[to + gap, 1] = corner, names
    return degree


@inlined_kernel
def _store(
    replay: Replay,
    slot: int,
    ring: IndexArray,
    start: int,
    end: int,
    one: int,
    one_names: int,
    two: int,
    two_names: int,
) -> None:
    """Make part of a ring and two more entries the ring of a slot."""
    span, entries, links = replay.span, replay.entries, replay.links
    degree = end - start + 2
    if degree > LONGEST_LIST:
        for index in range(start, end):
            corner = ring[index, 0]
            links[corner, 0] = ring[index + 1, 0] if index + 1 < end else one
            links[corner, 1] = ring[index, 1]
        links[one, 0], links[one, 1] = two, one_names
        links[two, 0], links[two, 1] = ring[start, 0], two_names
        span[slot, 0], span[slot, 1], span[slot, 2] = ring[start, 0], degree, LINKED
        return
    at = _room_for(replay, slot, degree)
    for index in range(start, end):
        entries[at, 0], entries[at, 1] = ring[index, 0], ring[index, 1]
        at += 1
    entries[at, 0], entries[at, 1] = one, one_names
    entries[at + 1, 0], entries[at + 1, 1] = two, two_names


@inlined_kernel
def _room_for(replay: Replay, slot: int, degree: int) -> int:
    """Give a list its new length, and where it does not fit a new place; returns the place."""
    span = replay.span
    span[slot, 1] = degree
    if degree > span[slot, 2]:
        room = SMALLEST_ROOM
        while room < degree:
            room *= 2
        span[slot, 0], span[slot, 2] = replay.used[TAKEN], room
        replay.used[TAKEN] += room
    begin: int = span[slot, 0]
    return begin
