"""Candidate positions of a collapse and their rounding to the grid, by brute force."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.decimation.candidates import (
    CANDIDATES,
    round_to_grid,
    write_candidate,
)
from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.stage import Grid
from gamutcore.decimation.star import (
    DEFICIT_NOW,
    keeps_star_shape,
    link_condition_holds,
    write_edge_link,
)

QUADRIC = cost_named("quadric").parameters
VOLUME = cost_named("volume").parameters

COORDINATES = st.floats(-100, 100)
PLACES = st.tuples(COORDINATES, COORDINATES, COORDINATES)
STEPS = st.sampled_from([2.0**-12, 2.0**-4, 0.5])


def grid_of(centre, step):
    return Grid(np.empty((0, 3), np.float32), np.array(centre, np.float64), step)


class TestRoundingToTheGrid:
    @given(place=PLACES, centre=PLACES, step=STEPS)
    def test_is_to_the_nearest_multiple_of_the_step(self, place, centre, step):
        rounded, delivered = np.array(place), np.empty(3, np.float32)
        assert round_to_grid(grid_of(centre, step), rounded, delivered) is True
        exact = delivered.astype(np.float64)
        np.testing.assert_array_equal(exact % step, 0.0)
        assert (np.abs(exact - (np.array(place) + centre)) <= step / 2).all()
        np.testing.assert_array_equal(rounded, exact - np.array(centre))
        assert not np.signbit(delivered[delivered == 0]).any()

    def test_fails_beyond_the_grid(self):
        # 2²⁴ + 1 is the first integer that float32 cannot represent
        for value, expected in ((2.0**24, True), (2.0**24 + 1, False), (2.0**24 + 2, False)):
            place, delivered = np.array([0.0, value, 0.0]), np.empty(3, np.float32)
            assert round_to_grid(grid_of((0, 0, 0), 1.0), place, delivered) is expected


@pytest.fixture(scope="module")
def edges(surface_from, bumpy_mesh, ends_of):
    """Return a function from a seed to a surface and its edges that may be collapsed."""

    def make(seed):
        surface = surface_from(*bumpy_mesh(seed, 40))
        found = []
        for corner in surface.corner_facing.tolist():
            one, two = ends_of(surface, corner)
            if link_condition_holds(surface, one, two):
                ring = np.empty((100, 2), np.int32)
                found.append((corner, one, two, ring, write_edge_link(surface, one, two, ring)))
        return surface, found

    return make


class TestCandidates:
    @pytest.mark.parametrize("missing", [0.0, 100.0])
    def test_keep_the_volume(self, edges, bumpy_mesh, missing, stage_of):
        """The optimum of the default cost and the other candidates; also with a volume deficit."""
        positions, faces = bumpy_mesh(2, 40)
        _, found = edges(2)
        stage = stage_of(VOLUME, positions, faces)
        stage.surface.deficit[DEFICIT_NOW] = 6 * missing
        wanted = np.linalg.det(positions[faces]).sum() / 6 + missing
        written = np.zeros(CANDIDATES, int)
        for corner, one, two, ring, count in found:
            for choice in range(CANDIDATES):
                place = np.empty(3)
                if write_candidate(stage, corner, choice, ring, count, place):
                    moved = positions.copy()
                    moved[one] = moved[two] = place
                    after = np.linalg.det(moved[faces]).sum() / 6
                    assert after == pytest.approx(wanted, rel=1e-9)
                    written[choice] += 1
        assert written.min() > len(found) // 2

    def test_are_the_midpoint_the_ends_and_a_valid_direction(self, edges, bumpy_mesh, stage_of):
        positions, faces = bumpy_mesh(3, 40)
        _, found = edges(3)
        stage, valid = stage_of(QUADRIC, positions, faces), 0

        def direction(vector):
            return vector / np.linalg.norm(vector)

        for corner, one, two, ring, count in found:
            middle = positions[[one, two]].mean(axis=0)
            places = np.empty((CANDIDATES, 3))
            there = [
                write_candidate(stage, corner, choice, ring, count, places[choice])
                for choice in range(CANDIDATES)
            ]
            assert there[0]
            for choice, expected in ((1, middle), (2, positions[one]), (3, positions[two])):
                if there[choice]:
                    np.testing.assert_allclose(direction(places[choice]), direction(expected))
            if there[4]:
                assert keeps_star_shape(positions, ring, count, *places[4])
                valid += 1
        assert valid > len(found) // 2
