"""The level that writers and readers of a history replay: positions, one-rings, and the star test.

A ring is the list of faces around a slot, counter-clockwise. A ring entry holds the corner of a
face at the slot, and the next slot around the ring. Most rings are short lists, which are twice as
fast as linked rings. Rings of more than `LONGEST_LIST` entries are linked by their corners: a
search through thousands of entries for every split beside the slot would take quadratic time. No
search is needed in a linked ring, because the faces around the parent name the corners.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.geometry import following, minus, preceding, row, triple
from gamutcore.history.splits import copy_row, extended_copy
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "CORNER",
    "DEGREE",
    "LINKED",
    "LONGEST",
    "LONGEST_LIST",
    "MOST_WORK",
    "MOVED",
    "MOVED_PER_VERTEX",
    "NEIGHBOUR",
    "VISITED",
    "WALK_COST",
    "WORK_PER_VERTEX",
    "Cut",
    "Replay",
    "copy_ring",
    "first_replay",
    "has_room",
    "larger_replay",
    "ring_start",
    "split_slot",
    "star_sees_centre",
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

TAKEN, VISITED, LONGEST, MOVED = range(4)
"""Elements of `Replay.used`."""

SPLIT_ROOM = 4 * LONGEST_LIST
"""A split stores at most four lists anew: of the parent, the new slot and the slots beside."""

WALK_COST = 32
"""Work of an entry whose neighbour's position is read, if the search through an entry is 1. About
the ratio of the times (27 ns in rings of 20,000 entries)."""

MOST_WORK, WORK_PER_VERTEX = 2**32, 2048
"""Limit of `VISITED` in a history: four seconds, plus two microseconds per vertex. Real histories
need about 250 per vertex. Only rings of parents and of moved neighbours are walked in full, so a
large degree alone never reaches the limit; thousands of splits at such slots do."""

MOVED_PER_VERTEX = 24
"""Limit of the moved corners ÷ vertices of the full boundary. Real histories move three. Writers
give the smaller part of a ring to the new slot, so each corner moves about log₂ V times at most.
Writers refuse histories beyond the limit."""


class Replay(NamedTuple):
    """A level of a history: positions and rings, with room for finer levels.

    A split changes a few independent entries of the rings. That takes half the time of a walk
    through a corner table (docs/decisions/compact-histories.md).
    """

    position: IndexArray  # (V, 3), in steps of the grid
    # (V, 3). Of a list: its begin in entries, degree and room. Of a linked ring: one of its
    # corners, degree and LINKED
    span: IndexArray
    entries: IndexArray  # (n, 2), corner and neighbour of each entry of a list
    # (0 or ≥ 6 V - 12, 2), next corner and neighbour of each corner in a linked ring; empty until a
    # ring is linked
    links: IndexArray
    ring: IndexArray  # (V, 2), the entries around the parent of a Cut
    # (4,). TAKEN: entries in use or abandoned. VISITED: work done, see WALK_COST. LONGEST: largest
    # degree so far. MOVED: corners that passed to new slots
    used: LongArray


class Cut(NamedTuple):
    """A split of a slot. `Replay.ring` has the faces around the parent before the split."""

    parent: int
    slot: int  # the new slot
    degree: int  # faces around the parent; the first one is (parent, left, …)
    kept: int  # how many of these the parent keeps, from the first one; 1 ≤ kept < degree


def first_replay(positions: IndexArray, faces: IndexArray, vertices: int = 4) -> Replay:
    """Return a coarsest level, a closed tetrahedron, with room for so many vertices."""
    replay = Replay(
        np.empty((vertices, 3), np.int32),
        np.empty((vertices, 3), np.int32),
        np.empty((_usual_entries(vertices), 2), np.int32),
        np.empty((0, 2), np.int32),
        np.empty((vertices, 2), np.int32),
        np.array([4 * SMALLEST_ROOM, 0, 3, 0]),
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
    return replay


def larger_replay(replay: Replay, vertices: int) -> Replay:
    """Return a copy with room for so many vertices, and for the rings of at least one split."""
    taken, needs_links = int(replay.used[TAKEN]), replay.used[LONGEST] >= LONGEST_LIST
    entries = max(_usual_entries(vertices), 2 * (taken + SPLIT_ROOM))
    return Replay(
        extended_copy(replay.position, vertices),
        extended_copy(replay.span, vertices),
        extended_copy(replay.entries[:taken], entries),
        extended_copy(replay.links, 6 * vertices) if needs_links else replay.links,
        np.empty((vertices, 2), np.int32),
        replay.used,
    )


def _usual_entries(vertices: int) -> int:
    return SMALLEST_ROOM * vertices + SPLIT_ROOM


@inlined_kernel
def has_room(replay: Replay) -> bool:
    """Whether there is room for the rings of any split."""
    return bool(
        replay.used[TAKEN] + SPLIT_ROOM <= len(replay.entries)
        and (replay.used[LONGEST] < LONGEST_LIST or len(replay.links) > 0)
    )


@inlined_kernel
def copy_ring(replay: Replay, slot: int, start: int) -> None:
    """Copy the ring of a slot, beginning with entry `start`, to `replay.ring`."""
    begin, degree = int(replay.span[slot, BEGIN]), int(replay.span[slot, DEGREE])
    ring = replay.ring
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
def ring_start(replay: Replay, slot: int) -> tuple[int, int]:
    """Return the degree of a slot, and the position of its lowest face in its ring.

    Leaves the ring in `replay.ring`.
    """
    copy_ring(replay, slot, 0)
    degree, lowest = int(replay.span[slot, DEGREE]), 0
    for index in range(1, degree):
        if replay.ring[index, CORNER] < replay.ring[lowest, CORNER]:
            lowest = index
    return degree, lowest


@inlined_kernel
def split_slot(replay: Replay, cut: Cut) -> None:
    """Split a slot: give some of its faces to a new slot, and insert two faces between them.

    The new faces are (parent, slot, left) and (slot, parent, right). Positions do not change. The
    level has `cut.slot` vertices before, and room for one more.
    """
    ring, parent, slot, degree, kept = replay.ring, cut.parent, cut.slot, cut.degree, cut.kept
    left, right = int(ring[0, NEIGHBOUR]), int(ring[kept, NEIGHBOUR])
    one, two = 6 * slot - 12, 6 * slot - 9
    visited = WALK_COST * degree
    for index in range(kept + 1, degree):
        neighbour = int(ring[index, NEIGHBOUR])
        visited += _rename(replay, neighbour, preceding(int(ring[index - 1, CORNER])), slot)
    # left sees the parent in the ring's first and last face; right in the two faces beside it
    last = preceding(int(ring[degree - 1, CORNER]))
    visited += _insert(replay, left, following(int(ring[0, CORNER])), last, one + 2, parent)
    visited += _rename(replay, left, last, slot)
    last = preceding(int(ring[kept - 1, CORNER]))
    visited += _insert(replay, right, following(int(ring[kept, CORNER])), last, two + 2, slot)
    replay.used[VISITED] += visited
    replay.used[MOVED] += degree - kept

    _store(replay, parent, 0, kept, (two + 1, right), (one, slot))
    replay.span[slot, DEGREE], replay.span[slot, ROOM] = 0, 0
    _store(replay, slot, kept, degree, (one + 1, left), (two, parent))
    sides = max(replay.span[left, DEGREE], replay.span[right, DEGREE])
    replay.used[LONGEST] = max(replay.used[LONGEST], sides, kept + 2, degree - kept + 2)


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
            copy_row(entries, to + index, entries, begin + index)
    for index in range(degree - 1, gap - 1, -1):
        copy_row(entries, to + index + 1, entries, begin + index)
    entries[to + gap, CORNER], entries[to + gap, NEIGHBOUR] = corner, neighbour
    return degree


@leaf_kernel
def _store(
    replay: Replay, slot: int, start: int, end: int, one: tuple[int, int], two: tuple[int, int]
) -> None:
    """Set the ring of a slot to entries [start, end) of `replay.ring` and two more entries."""
    span, entries, links = replay.span, replay.entries, replay.links
    ring, degree = replay.ring, end - start + 2
    if degree > LONGEST_LIST:
        for index in range(start, end):
            corner = ring[index, CORNER]
            links[corner, CORNER] = ring[index + 1, CORNER] if index + 1 < end else one[CORNER]
            links[corner, NEIGHBOUR] = ring[index, NEIGHBOUR]
        links[one[CORNER], CORNER], links[one[CORNER], NEIGHBOUR] = two[CORNER], one[NEIGHBOUR]
        links[two[CORNER], CORNER] = ring[start, CORNER]
        links[two[CORNER], NEIGHBOUR] = two[NEIGHBOUR]
        span[slot, BEGIN], span[slot, DEGREE] = ring[start, CORNER], degree
        span[slot, ROOM] = LINKED
        return
    at = _set_degree(replay, slot, degree)
    for index in range(start, end):
        copy_row(entries, at + index - start, ring, index)
    at += degree - 2
    entries[at, CORNER], entries[at, NEIGHBOUR] = one
    entries[at + 1, CORNER], entries[at + 1, NEIGHBOUR] = two


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


@leaf_kernel
def star_sees_centre(replay: Replay, slot: int, centre: FloatArray) -> bool:
    """Whether the centre, in steps, is on the inner side of all faces around a slot.

    Leaves the ring of the slot in `replay.ring`.
    """
    copy_ring(replay, slot, 0)
    ring, degree = replay.ring, replay.span[slot, DEGREE]
    middle = centre[0], centre[1], centre[2]
    a = minus(row(replay.position, slot, 0), middle)
    c = minus(row(replay.position, ring[degree - 1, NEIGHBOUR], 0), middle)
    valid = True
    for index in range(degree):
        b, c = c, minus(row(replay.position, ring[index, NEIGHBOUR], 0), middle)
        # writers keep the determinant so far above zero that its sign is the same in any order
        # of the operations
        valid &= triple(a, b, c) > 0.0
    return valid
