"""The prediction of a split, worked out by hand, and the star test of its faces."""

import numpy as np
import pytest

from gamutcore.history.prediction import (
    ADDED,
    CLASSES,
    KEPT,
    KINDS,
    PARENT,
    SHIFTED,
    Frame,
    difference_contexts,
    find_frame,
    first_contexts,
    plane_height,
    star_sees_centre,
)
from gamutcore.history.rings import Cut, copy_ring, first_replay, ring_start, split_slot

TETRAHEDRON = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], np.int32)


class TestFrame:
    """A slot inside a hexagonal ring, in a plane with the slope 1 in 4 along x."""

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
        replay = first_replay(np.zeros((4, 3), np.int32), TETRAHEDRON, count + 1)
        replay.position[0] = here
        replay.position[1:] = np.array(neighbours) + here
        replay.ring[:count] = [(0, slot) for slot in range(1, count + 1)]
        return find_frame(replay, Cut(0, count + 1, count, kept))

    def test_axes_and_slopes(self):
        frame = self.frame(self.NEIGHBOURS, 3)
        assert (frame.u, frame.v, frame.w) == (0, 1, 2)
        assert (frame.slope_u, frame.slope_v) == (0.25, 0.0)
        assert plane_height(frame, 8, 100) == 2
        assert plane_height(frame, 10, 0) == 3  # 2.5, halves upwards
        assert plane_height(frame, -10, 0) == -2

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
        assert plane_height(frame, 5, 5) == 0


class TestContexts:
    def test_each_kind_and_length_class_has_its_own(self):
        used = {KEPT}
        for size in range(CLASSES):
            frame = Frame(0, 1, 2, 0.0, 0.0, 0, 0, size, size)
            for kind in (PARENT, ADDED, SHIFTED):
                contexts = set(difference_contexts(frame, kind))
                assert len(contexts) == 2
                assert not contexts & used
                used |= contexts
        assert used == {KEPT, *range(CLASSES, KINDS * CLASSES)}
        assert len(first_contexts().totals) == KINDS * CLASSES

    def test_the_first_guess_is_half_the_limit_of_the_class(self):
        contexts = first_contexts()
        assert (contexts.counts == 1).all()
        assert contexts.totals[CLASSES * ADDED + 10] == 512
        assert contexts.totals[KEPT] == 0


class TestSeeingTheCentre:
    @pytest.fixture
    def split(self):
        """Return slot 0 on the axis x, split towards slot 4."""
        replay = first_replay(
            np.array([(8, 0, 0), (-8, 8, 0), (-8, -8, 8), (-8, -8, -8)], np.int32),
            TETRAHEDRON,
            5,
        )
        copy_ring(replay, 0, ring_start(replay, 0)[1])
        ring = replay.ring[:3].copy()
        replay.position[4] = (7, 0, 0) + replay.position[ring[1:, 1]].sum(axis=0) // 8
        split_slot(replay, Cut(0, 4, 3, 1))
        return replay, ring

    @pytest.mark.slow
    def test_around_both_slots(self, split):
        replay, ring = split

        def seen(centre):
            return all(star_sees_centre(replay, slot, centre) for slot in (0, 4))

        left, right = ring[0, 1], ring[1, 1]
        own = [(0, 4, left), (4, 0, right)]
        kept, moved = ring[:1], ring[1:]
        after = {int(n): int(m) for n, m in zip(ring[:, 1], np.roll(ring[:, 1], -1), strict=True)}
        own += [(0, int(n), after[int(n)]) for n in kept[:, 1]]
        own += [(4, int(n), after[int(n)]) for n in moved[:, 1]]
        random = np.random.default_rng(1)
        answers = set()
        for centre in random.uniform(-8, 8, (200, 3)):
            corners = replay.position[np.array(own)] - centre
            expected = bool((np.linalg.det(corners) > 0).all())
            assert seen(centre) == expected
            answers.add(expected)
        assert answers == {True, False}
