"""The replay of a history: rings that agree with the faces, and frames worked out by hand."""

import numpy as np
import pytest

from gamutcore.history.replay import (
    copy_ring,
    frame_of,
    has_room,
    replay_for,
    replay_of,
    ring_of,
    sees_centre_after_split,
    split_slot,
    star_sees_centre,
    third,
    with_room,
)

TETRAHEDRON = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], np.int32)


def ring_in(replay, slot):
    begin, degree, room = replay.span[slot]
    assert degree <= room
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
        degree, lowest = ring_of(replay, slot)
        copied = np.empty((degree, 2), np.int32)
        copy_ring(replay, slot, lowest, copied)
        assert [tuple(entry) for entry in copied.tolist()] == ring


def replayed(replay, splits, until, since=4):
    """Apply the splits up to a number of vertices, and yield what leads to each."""
    for split in range(since - 4, until - 4):
        slot, parent = split + 4, int(splits.parent[split])
        degree, _ = ring_of(replay, parent)
        neighbours = [neighbour for _, neighbour in ring_in(replay, parent)]
        ring = np.empty((degree, 2), np.int32)
        copy_ring(replay, parent, neighbours.index(splits.faces[split, 0, 2]), ring)
        start = int(splits.moved_end[split - 1]) if split else 0
        kept = degree - (int(splits.moved_end[split]) - start)
        if not has_room(replay, ring, degree, kept):
            replay = with_room(replay, ring, degree, kept)
        split_slot(replay, parent, slot, ring, degree, kept)
        yield replay, ring, degree, kept


def test_the_coarsest_level():
    replay = replay_of(np.zeros((4, 3), np.int32), TETRAHEDRON, 9)
    assert_rings(replay, TETRAHEDRON)
    assert len(replay.position) == 9


def test_room_for_more_is_made_between_splits(small_history):
    splits = small_history.splits
    replay = replay_of(np.zeros((4, 3), np.int32), splits.base_faces)
    for slot in range(4, splits.vertices):
        if slot == len(replay.position):
            replay = replay_for(replay, min(2 * slot, splits.vertices))
        for replay, *_ in replayed(replay, splits, slot + 1, slot):  # noqa: B020
            assert_rings(replay, small_history.level(2 * slot - 2).faces)


def test_rings_agree_with_the_faces_of_every_level(small_history):
    splits = small_history.splits
    replay = replay_of(np.zeros((4, 3), np.int32), splits.base_faces, splits.vertices)
    for replay, *_ in replayed(replay, splits, splits.vertices):  # noqa: B020
        slot = ring_in(replay, 0)
        assert slot
    assert_rings(replay, small_history.full().faces)


@pytest.mark.parametrize("vertices", [5, 6, 10, 50])
def test_rings_agree_with_the_faces_of_a_level(small_history, vertices):
    splits = small_history.splits
    replay = replay_of(np.zeros((4, 3), np.int32), splits.base_faces, splits.vertices)
    for replay, *_ in replayed(replay, splits, vertices):  # noqa: B007, B020
        pass
    assert_rings(replay, small_history.level(2 * vertices - 4).faces)


def test_rings_that_outgrow_their_room():
    """Slot 0 keeps all but one of its faces, again and again."""
    replay = replay_of(np.zeros((4, 3), np.int32), TETRAHEDRON, 400)
    replay = replay._replace(entries=replay.entries[:80].copy())
    faces = [list(face) for face in TETRAHEDRON.tolist()]
    for slot in range(4, 400):
        degree, lowest = ring_of(replay, 0)
        ring = np.empty((degree, 2), np.int32)
        copy_ring(replay, 0, lowest, ring)
        if not has_room(replay, ring, degree, degree - 1):
            replay = with_room(replay, ring, degree, degree - 1)
        split_slot(replay, 0, slot, ring, degree, degree - 1)
        corner = ring[degree - 1, 0]
        faces[corner // 3][corner % 3] = slot
        faces += [[0, slot, ring[0, 1]], [slot, 0, ring[degree - 1, 1]]]
    assert ring_of(replay, 0)[0] == 399
    assert replay.filled[0] <= len(replay.entries)
    assert_rings(replay, np.array(faces))


class TestFrame:
    """A slot in the middle of a hexagon-like ring, in a plane that rises 1 in 4 along x."""

    NEIGHBOURS = (
        (40, 0, 10),
        (20, 40, 5),
        (-20, 40, -5),
        (-40, 0, -10),
        (-20, -40, -5),
        (20, -40, 5),
    )

    def frame(self, neighbours, kept, here=(1000, -2000, 3000)):
        count = len(neighbours)
        replay = replay_of(np.zeros((4, 3), np.int32), TETRAHEDRON, count + 1)
        replay.position[0] = here
        replay.position[1:] = np.array(neighbours) + here
        ring = np.array([(0, slot) for slot in range(1, count + 1)], np.int32)
        return frame_of(replay, 0, ring, count, kept)

    def test_axes_and_slopes(self):
        frame = self.frame(self.NEIGHBOURS, 3)
        assert (frame.u, frame.v, frame.w) == (0, 1, 2)
        assert (frame.slope_u, frame.slope_v) == (0.25, 0.0)
        assert third(frame, 8, 100) == 2
        assert third(frame, 10, 0) == 3  # 2.5, halves upwards
        assert third(frame, -10, 0) == -2

    def test_the_axes_turn_with_the_plane(self):
        rolled = [neighbour[-1:] + neighbour[:-1] for neighbour in self.NEIGHBOURS]
        frame = self.frame(rolled, 3)
        assert (frame.u, frame.v, frame.w) == (1, 2, 0)
        assert (frame.slope_u, frame.slope_v) == (0.25, 0.0)

    def test_the_parent_is_expected_between_what_it_keeps_and_away_from_the_rest(self):
        frame = self.frame(self.NEIGHBOURS, 3)
        # kept: the first four neighbours; lost: the last three and the first
        assert frame.ahead_u == np.floor((2 * 0 / 4 - 0 / 4) / 5 + 0.5)
        assert frame.ahead_v == np.floor((2 * 80 / 4 - -80 / 4) / 5 + 0.5)
        frame = self.frame(self.NEIGHBOURS, 1)
        assert frame.ahead_u == np.floor(
            (2 * 60 / 2 - (-20 - 40 - 20 + 20 + 40 + 20) / 6) / 5 + 0.5
        )

    def test_length_classes(self):
        frame = self.frame(self.NEIGHBOURS, 3)
        assert frame.size == 6  # mean 60, below 2⁶
        assert frame.height == 0
        bent = [(x, y, z + 4 * (-1) ** index) for index, (x, y, z) in enumerate(self.NEIGHBOURS)]
        assert self.frame(bent, 3).height == 3  # mean 4, not below 2²

    def test_a_ring_without_a_plane(self):
        frame = self.frame([(0, 0, 0)] * 3, 1)
        assert (frame.slope_u, frame.slope_v, frame.size, frame.height) == (0, 0, 0, 0)
        assert third(frame, 5, 5) == 0


class TestSeeingTheCentre:
    @pytest.fixture
    def split(self):
        """Return slot 0 on the axis x, split towards slot 4."""
        replay = replay_of(
            np.array([(8, 0, 0), (-8, 8, 0), (-8, -8, 8), (-8, -8, -8)], np.int32),
            TETRAHEDRON,
            5,
        )
        ring = np.array(ring_in(replay, 0), np.int32)
        replay.position[4] = (7, 0, 0) + replay.position[ring[1:, 1]].sum(axis=0) // 8
        split_slot(replay, 0, 4, ring, 3, 1)
        return replay, ring

    def test_around_both_slots(self, split):
        replay, ring = split

        def seen(centre):
            around = sees_centre_after_split(
                replay, 0, 4, ring, 3, 1, np.array(centre, np.float64), 0.5
            )
            each = [
                star_sees_centre(replay, slot, np.array(centre, np.float64), 0.5) for slot in (0, 4)
            ]
            assert around == all(each)
            return around

        left, right = ring[0, 1], ring[1, 1]
        own = [(0, 4, left), (4, 0, right)]
        kept, moved = ring[:1], ring[1:]
        after = {int(n): int(m) for n, m in zip(ring[:, 1], np.roll(ring[:, 1], -1), strict=True)}
        own += [(0, int(n), after[int(n)]) for n in kept[:, 1]]
        own += [(4, int(n), after[int(n)]) for n in moved[:, 1]]
        random = np.random.default_rng(1)
        answers = set()
        for centre in random.uniform(-4, 4, (200, 3)):
            corners = (replay.position[np.array(own)] * 0.5) - centre
            expected = bool((np.linalg.det(corners) > 0).all())
            assert seen(centre) == expected
            answers.add(expected)
        assert answers == {True, False}
