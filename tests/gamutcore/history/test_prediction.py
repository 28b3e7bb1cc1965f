"""What a ring says about a split, worked out by hand, and faces that see the centre."""

import numpy as np
import pytest

from gamutcore.history.prediction import (
    find_frame,
    plane_height,
    sees_centre_after_split,
    star_sees_centre,
)
from gamutcore.history.rings import copy_ring, first_replay, ring_start, split_slot

TETRAHEDRON = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], np.int32)


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
        replay = first_replay(np.zeros((4, 3), np.int32), TETRAHEDRON, count + 1)
        replay.position[0] = here
        replay.position[1:] = np.array(neighbours) + here
        ring = np.array([(0, slot) for slot in range(1, count + 1)], np.int32)
        return find_frame(replay, 0, ring, count, kept)

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


class TestSeeingTheCentre:
    @pytest.fixture
    def split(self):
        """Return slot 0 on the axis x, split towards slot 4."""
        replay = first_replay(
            np.array([(8, 0, 0), (-8, 8, 0), (-8, -8, 8), (-8, -8, -8)], np.int32),
            TETRAHEDRON,
            5,
        )
        ring = np.empty((3, 2), np.int32)
        copy_ring(replay, 0, ring_start(replay, 0)[1], ring)
        replay.position[4] = (7, 0, 0) + replay.position[ring[1:, 1]].sum(axis=0) // 8
        split_slot(replay, 0, 4, ring, 3, 1)
        return replay, ring

    @pytest.mark.slow
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
