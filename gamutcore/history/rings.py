"""The one-rings of a level while a history is written or read.

A ring is the list of faces around a slot, counter-clockwise. A ring entry holds the corner of a
face at the slot, and the next slot around the ring. Most rings are short lists, which are twice as
fast as linked rings. Rings of more than `LONGEST_LIST` entries are linked by their corners: a
search through thousands of entries for every split beside the slot would take quadratic time. No
search is needed in a linked ring, because the faces around the parent name the corners.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import IndexArray, LongArray
from gamutcore.history.streams import extended_copy
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

__all__ = [
    "BEGIN",
    "CORNER",
    "DEGREE",
    "LINKED",
    "LONGEST_LIST",
    "MOST_WORK",
    "NEIGHBOUR",
    "ROOM",
    "VISITED",
    "WALK_COST",
    "WORK_PER_VERTEX",
    "Replay",
    "copy_ring",
    "first_replay",
    "grow_replay",
    "has_room",
    "larger_replay",
    "ring_start",
    "split_slot",
]

SMALLEST_ROOM = 8
"""Entries that a list has room for at first; most rings never have more."""

LONGEST_LIST = 256
"""Longer rings are linked. Real gamuts have none."""

BEGIN, DEGREE, ROOM = range(3)
"""Columns of `Replay.span`."""

LINKED = 0
"""`ROOM` of a linked ring."""

CORNER, NEIGHBOUR = range(2)
"""Columns of `Replay.entries`, and of `Replay.links`, whose `CORNER` is the next corner."""

TAKEN, VISITED = range(2)
"""Elements of `Replay.used`."""

WALK_COST = 32
"""Work of an entry whose neighbour's position is read, if the search through an entry is 1. About
the ratio of the times (27 ns in rings of 20,000 entries)."""

MOST_WORK, WORK_PER_VERTEX = 2**32, 2048
"""Limit of `VISITED` in a history: four seconds, plus two microseconds per vertex. Real histories
need about 250 per vertex. Only rings of parents and of moved neighbours are walked in full, so a
large degree alone never reaches the limit; thousands of splits at such slots do."""


class Replay(NamedTuple):
    """A level of a history: positions and rings, with room for finer levels.

    A split changes a few independent entries of the rings. That takes half the time of a walk
    through a corner table (docs/decisions/compact-histories.md).

    Attributes
    ----------
    position : (V, 3) int32
        In steps of the grid.
    span : (V, 3) int32
        For a list: its begin in `entries`, its degree, and its room. For a linked ring: one of its
        corners, its degree, and `LINKED`.
    entries : (n, 2) int32
        Corner and neighbour of each entry.
    links : (0 or ≥ 6 V − 12, 2) int32
        Next corner and neighbour of each corner in a linked ring. Empty until a ring is linked.
    used : (2,) int64
        `TAKEN`: entries in use or abandoned. `VISITED`: work done, see `WALK_COST`.
    """

    position: IndexArray
    span: IndexArray
    entries: IndexArray
    links: IndexArray
    used: LongArray


def first_replay(positions: IndexArray, faces: IndexArray, vertices: int = 4) -> Replay:
    """Return the coarsest level.

    Parameters
    ----------
    positions : (4, 3) int32
        In steps.
    faces : (4, 3) int32
        A closed, oriented tetrahedron.
    vertices : int, optional
        Vertices to make room for.

    Returns
    -------
    Replay
    """
    replay = Replay(
        np.empty((vertices, 3), np.int32),
        np.empty((vertices, 3), np.int32),
        np.empty((_usual_entries(vertices), 2), np.int32),
        np.empty((0, 2), np.int32),
        np.zeros(2, np.int64),
    )
    replay.position[:4] = positions
    for slot in range(4):
        # neighbours of the slot's corners: (corner, next slot in the face, last slot in the face)
        around = [
            (3 * face + place, int(row[(place + 1) % 3]), int(row[(place + 2) % 3]))
            for face, row in enumerate(faces)
            for place in range(3)
            if row[place] == slot
        ]
        entry = around[0]
        for index in range(3):
            replay.entries[SMALLEST_ROOM * slot + index] = entry[:2]
            entry = next(other for other in around if other[1] == entry[2])
        replay.span[slot] = SMALLEST_ROOM * slot, 3, SMALLEST_ROOM
    replay.used[TAKEN] = 4 * SMALLEST_ROOM
    return replay


def larger_replay(replay: Replay, vertices: int) -> Replay:
    """Return a copy with room for so many vertices and for rings of the usual length."""
    return Replay(
        extended_copy(replay.position, vertices),
        extended_copy(replay.span, vertices),
        extended_copy(replay.entries, max(_usual_entries(vertices), len(replay.entries))),
        extended_copy(replay.links, 6 * vertices) if len(replay.links) else replay.links,
        replay.used,
    )


def _usual_entries(vertices: int) -> int:
    return SMALLEST_ROOM * vertices + 64


@inlined_kernel
def ring_start(replay: Replay, slot: int) -> tuple[int, int]:
    """Return the degree of a slot, and the position of its lowest face in its ring."""
    begin, degree = int(replay.span[slot, BEGIN]), int(replay.span[slot, DEGREE])
    lowest = 0
    if replay.span[slot, ROOM] == LINKED:
        corner = smallest = begin
        for index in range(1, degree):
            corner = int(replay.links[corner, CORNER])
            if corner < smallest:
                lowest, smallest = index, corner
        return degree, lowest
    smallest = int(replay.entries[begin, CORNER])
    for index in range(1, degree):
        corner = int(replay.entries[begin + index, CORNER])
        if corner < smallest:
            lowest, smallest = index, corner
    return degree, lowest


@inlined_kernel
def copy_ring(replay: Replay, slot: int, start: int, ring: IndexArray) -> None:
    """Copy the ring of a slot, beginning with entry `start`, to `ring`, (≥ degree, 2) int32."""
    begin, degree = int(replay.span[slot, BEGIN]), int(replay.span[slot, DEGREE])
    if replay.span[slot, ROOM] == LINKED:
        corner = begin
        target = degree - start if start > 0 else 0
        for _ in range(degree):
            ring[target, CORNER], ring[target, NEIGHBOUR] = corner, replay.links[corner, NEIGHBOUR]
            corner = int(replay.links[corner, CORNER])
            target = target + 1 if target + 1 < degree else 0
        return
    index = start
    for target in range(degree):
        ring[target, CORNER] = replay.entries[begin + index, CORNER]
        ring[target, NEIGHBOUR] = replay.entries[begin + index, NEIGHBOUR]
        index = index + 1 if index + 1 < degree else 0


@inlined_kernel
def has_room(replay: Replay, ring: IndexArray, degree: int, kept: int) -> bool:
    """Whether `split_slot` has room for all rings that it may have to store anew."""
    longest, needed = _needed_room(replay, ring, degree, kept)
    return bool(
        replay.used[TAKEN] + needed <= len(replay.entries)
        and (longest < LONGEST_LIST or len(replay.links) > 0)
    )


@kernel
def grow_replay(replay: Replay, ring: IndexArray, degree: int, kept: int) -> Replay:
    """Return the same level with room for a split."""
    longest, needed = _needed_room(replay, ring, degree, kept)
    entries, links = replay.entries, replay.links
    taken = int(replay.used[TAKEN])
    if taken + needed > len(entries):
        # element by element: numba takes seconds to compile an assignment of slices
        entries = np.empty((2 * (taken + needed), 2), np.int32)
        for index in range(taken):
            entries[index, 0] = replay.entries[index, 0]
            entries[index, 1] = replay.entries[index, 1]
    if longest >= LONGEST_LIST and len(links) == 0:
        links = np.empty((6 * len(replay.position), 2), np.int32)
    return Replay(replay.position, replay.span, entries, links, replay.used)


@inlined_kernel
def _needed_room(replay: Replay, ring: IndexArray, degree: int, kept: int) -> tuple[int, int]:
    """Longest ring that a split changes, and how many entries its rings may take."""
    left = int(replay.span[ring[0, NEIGHBOUR], DEGREE])
    right = int(replay.span[ring[kept, NEIGHBOUR], DEGREE])
    parts = 4 * (min(degree, LONGEST_LIST) + 2)
    sides = 2 * (min(left, LONGEST_LIST) + min(right, LONGEST_LIST) + 2)
    return max(degree, left, right), parts + sides + 4 * SMALLEST_ROOM


@inlined_kernel
def split_slot(
    replay: Replay, parent: int, slot: int, ring: IndexArray, degree: int, kept: int
) -> None:
    """Split a slot: give some of its faces to a new slot, and insert two faces between them.

    The new faces are (parent, slot, left) and (slot, parent, right). Positions do not change.

    Parameters
    ----------
    replay : Replay
        A level with `slot` vertices and room for one more.
    parent, slot : int
    ring : (≥ degree, 2) int32
        The parent's ring, beginning with the face (parent, left, …).
    degree : int
    kept : int
        How many of the faces the parent keeps, from the first one; 1 ≤ kept < degree.
    """
    left, right = int(ring[0, NEIGHBOUR]), int(ring[kept, NEIGHBOUR])
    one, two = 6 * slot - 12, 6 * slot - 9
    visited = WALK_COST * degree
    for index in range(kept + 1, degree):
        neighbour = int(ring[index, NEIGHBOUR])
        visited += _rename(replay, neighbour, _corner_before(int(ring[index - 1, CORNER])), slot)
    # left sees the parent in the ring's first and last face; right in the two faces beside it
    last = _corner_before(int(ring[degree - 1, CORNER]))
    visited += _insert(replay, left, _corner_after(int(ring[0, CORNER])), last, one + 2, parent)
    visited += _rename(replay, left, last, slot)
    last = _corner_before(int(ring[kept - 1, CORNER]))
    visited += _insert(replay, right, _corner_after(int(ring[kept, CORNER])), last, two + 2, slot)
    replay.used[VISITED] += visited

    _store(replay, parent, ring, 0, kept, two + 1, right, one, slot)
    replay.span[slot, DEGREE], replay.span[slot, ROOM] = 0, 0
    _store(replay, slot, ring, kept, degree, one + 1, left, two, parent)


@inlined_kernel
def _corner_before(corner: int) -> int:
    """Previous corner of the same face."""
    return corner - 1 if corner % 3 > 0 else corner + 2


@inlined_kernel
def _corner_after(corner: int) -> int:
    """Next corner of the same face."""
    return corner + 1 if corner % 3 < 2 else corner - 2


@leaf_kernel
def _rename(replay: Replay, slot: int, corner: int, neighbour: int) -> int:
    """Set the neighbour in the entry of a corner; return the number of entries searched."""
    entry, degree = int(replay.span[slot, BEGIN]), int(replay.span[slot, DEGREE])
    if replay.span[slot, ROOM] == LINKED:
        replay.links[corner, NEIGHBOUR] = neighbour
        return 1
    while replay.entries[entry, CORNER] != corner:
        entry += 1
    replay.entries[entry, NEIGHBOUR] = neighbour
    return degree


@leaf_kernel
def _insert(
    replay: Replay, slot: int, previous: int, following: int, corner: int, neighbour: int
) -> int:
    """Insert an entry between those of two corners; return the number of entries searched."""
    span, entries, links = replay.span, replay.entries, replay.links
    begin, degree = int(span[slot, BEGIN]), int(span[slot, DEGREE])
    if degree == LONGEST_LIST and span[slot, ROOM] != LINKED:
        for index in range(degree):
            entry = begin + index
            behind = entry + 1 if index + 1 < degree else begin
            links[entries[entry, CORNER], CORNER] = entries[behind, CORNER]
            links[entries[entry, CORNER], NEIGHBOUR] = entries[entry, NEIGHBOUR]
        span[slot, BEGIN], span[slot, ROOM] = entries[begin, CORNER], LINKED
    if span[slot, ROOM] == LINKED:
        links[previous, CORNER] = corner
        links[corner, CORNER], links[corner, NEIGHBOUR] = following, neighbour
        span[slot, DEGREE] = degree + 1
        return 1
    gap = 0
    while entries[begin + gap, CORNER] != following:
        gap += 1
    to = _set_degree(replay, slot, degree + 1)
    if to != begin:
        for index in range(gap):
            entries[to + index, 0] = entries[begin + index, 0]
            entries[to + index, 1] = entries[begin + index, 1]
    for index in range(degree - 1, gap - 1, -1):
        entries[to + index + 1, 0] = entries[begin + index, 0]
        entries[to + index + 1, 1] = entries[begin + index, 1]
    entries[to + gap, CORNER], entries[to + gap, NEIGHBOUR] = corner, neighbour
    return degree


@leaf_kernel
def _store(
    replay: Replay,
    slot: int,
    ring: IndexArray,
    start: int,
    end: int,
    one: int,
    neighbour_one: int,
    two: int,
    neighbour_two: int,
) -> None:
    """Set the ring of a slot to entries [start, end) of another ring and two more entries."""
    span, entries, links = replay.span, replay.entries, replay.links
    degree = end - start + 2
    if degree > LONGEST_LIST:
        for index in range(start, end):
            corner = ring[index, CORNER]
            links[corner, CORNER] = ring[index + 1, CORNER] if index + 1 < end else one
            links[corner, NEIGHBOUR] = ring[index, NEIGHBOUR]
        links[one, CORNER], links[one, NEIGHBOUR] = two, neighbour_one
        links[two, CORNER], links[two, NEIGHBOUR] = ring[start, CORNER], neighbour_two
        span[slot, BEGIN], span[slot, DEGREE] = ring[start, CORNER], degree
        span[slot, ROOM] = LINKED
        return
    at = _set_degree(replay, slot, degree)
    for index in range(start, end):
        entries[at, 0], entries[at, 1] = ring[index, 0], ring[index, 1]
        at += 1
    entries[at, CORNER], entries[at, NEIGHBOUR] = one, neighbour_one
    entries[at + 1, CORNER], entries[at + 1, NEIGHBOUR] = two, neighbour_two


@inlined_kernel
def _set_degree(replay: Replay, slot: int, degree: int) -> int:
    """Set the length of a list; move a list that is too short. Return its begin."""
    span = replay.span
    span[slot, DEGREE] = degree
    if degree > span[slot, ROOM]:
        room = SMALLEST_ROOM
        while room < degree:
            room *= 2
        span[slot, BEGIN], span[slot, ROOM] = replay.used[TAKEN], room
        replay.used[TAKEN] += room
    return int(span[slot, BEGIN])
