"""Rings agree with the faces of their level after any splits, and see the centre as these do."""

import numpy as np
import pytest

from gamutcore.history.replay import (
    LINKED,
    LONGEST,
    LONGEST_LIST,
    Cut,
    copy_ring,
    first_replay,
    has_room,
    larger_replay,
    ring_start,
    split_slot,
    star_sees_centre,
)

TETRAHEDRON = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], np.int32)


def ring_in(replay, slot):
    begin, degree, room = replay.span[slot].tolist()
    if room == LINKED:
        assert degree > LONGEST_LIST
        corners = [begin]
        while len(corners) < degree:
            corners.append(int(replay.links[corners[-1], 0]))
        assert replay.links[corners[-1], 0] == begin
        return [(corner, int(replay.links[corner, 1])) for corner in corners]
    assert degree <= min(room, LONGEST_LIST)
    return [tuple(entry) for entry in replay.entries[begin : begin + degree].tolist()]


def rings_of(faces):
    """Rings by definition: the faces around each slot, each beginning where the last one ends."""
    around = {}
    for face, slots in enumerate(faces.tolist()):
        for place, slot in enumerate(slots):
            entry = (3 * face + place, slots[(place + 1) % 3], slots[(place + 2) % 3])
            around.setdefault(slot, []).append(entry)
    for slot, entries in around.items():
        ordered = [min(entries)]
        while len(ordered) < len(entries):
            (found,) = (entry for entry in entries if entry[1] == ordered[-1][2])
            ordered.append(found)
        around[slot] = [entry[:2] for entry in ordered]
    return around


def turned(ring):
    lowest = ring.index(min(ring))
    return ring[lowest:] + ring[:lowest]


def assert_rings(replay, faces):
    for slot, ring in rings_of(faces).items():
        assert turned(ring_in(replay, slot)) == ring
        degree, lowest = ring_start(replay, slot)
        copy_ring(replay, slot, lowest)
        assert [tuple(entry) for entry in replay.ring[:degree].tolist()] == ring


def split_in(replay, parent, slot, start, kept):
    """Split a slot; return the level and the ring of the parent before the split."""
    if not has_room(replay):
        replay = larger_replay(replay, len(replay.position))
    degree, _ = ring_start(replay, parent)
    copy_ring(replay, parent, start)
    ring = replay.ring[:degree].copy()
    split_slot(replay, Cut(parent, slot, int(degree), kept))
    return replay, ring


def with_slot_0_split(replay, slot):
    """Split slot 0, which keeps all but one of its faces; also return its ring before the split."""
    degree, lowest = ring_start(replay, 0)
    return split_in(replay, 0, slot, lowest, int(degree) - 1)


def random_splits(random, until):
    """Split slots at random, half of the time slot 0, and yield the level and its faces.

    The parent keeps all but one of its faces, so that its ring grows; slot 0 now and then keeps a
    third of them.
    """
    replay = first_replay(np.zeros((4, 3), np.int32), TETRAHEDRON)
    faces = [list(face) for face in TETRAHEDRON.tolist()]
    for slot in range(4, until):
        if slot == len(replay.position):
            replay = larger_replay(replay, min(2 * slot, until))
        cut = slot % 1000 == 999
        parent = 0 if cut or random.random() < 0.5 else int(random.integers(slot))
        degree, lowest = ring_start(replay, parent)
        kept = int(degree // 3 if cut else degree - 1)
        start = int(lowest + random.integers(degree)) % degree
        replay, ring = split_in(replay, parent, slot, start, kept)
        for corner in ring[kept:, 0].tolist():
            faces[corner // 3][corner % 3] = slot
        faces += [[parent, slot, int(ring[0, 1])], [slot, parent, int(ring[kept, 1])]]
        yield replay, faces


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.slow
def test_rings_agree_with_the_faces_as_they_become_long_and_short_again(seed):
    linked, unlinked = set(), set()
    for replay, faces in random_splits(np.random.default_rng(seed), 3000):
        slots = len(faces) // 2 + 2
        now = set(np.flatnonzero(replay.span[:slots, 2] == LINKED).tolist())
        unlinked |= linked - now
        linked = now
        if slots % 500 == 0:
            assert_rings(replay, np.array(faces))
            assert replay.used[0] <= len(replay.entries)
            assert replay.used[0] < 12 * slots + 64 + 8 * LONGEST_LIST
            assert replay.used[LONGEST] >= replay.span[:slots, 1].max()
    assert linked
    assert unlinked


@pytest.mark.slow
def test_a_long_ring_sees_the_centre_as_a_list_of_it_would():
    """The other slots all surround the apex of a pyramid. The base lies below the centre."""
    count = 2 * LONGEST_LIST
    replay = first_replay(np.zeros((4, 3), np.int32), TETRAHEDRON, count)
    for slot in range(4, count):
        replay, _ = with_slot_0_split(replay, slot)
    ring = [slot for _, slot in ring_in(replay, 0)]
    assert replay.span[0, 2] == LINKED
    turn = 2 * np.pi * np.arange(len(ring)) / len(ring)
    replay.position[0] = 0, 0, 10_000
    replay.position[ring] = np.stack(
        [1e6 * np.cos(turn), 1e6 * np.sin(turn), np.full(len(ring), -10_000)], axis=1
    )
    assert star_sees_centre(replay, 0, np.zeros(3))
    for slot in (ring[0], ring[1], ring[-1], ring[100]):
        where = replay.position[slot].copy()
        replay.position[slot, 2] = 20_000
        replay.position[slot, :2] //= -1000
        assert not star_sees_centre(replay, 0, np.zeros(3))
        replay.position[slot] = where
