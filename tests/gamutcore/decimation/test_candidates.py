"""Candidate places of a collapse, their reach, and their rounding to the grid, by brute force."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.decimation.candidates import (
    CANDIDATES,
    REACH,
    candidate,
    rounded_as_delivered,
    rounded_to_volume,
    within_reach,
)
from gamutcore.decimation.costs import quadric, volume
from gamutcore.decimation.star import keeps_star_shape, link_condition_holds, write_edge_link

COORDINATES = st.floats(-100, 100)
PLACES = st.tuples(COORDINATES, COORDINATES, COORDINATES)
STEPS = st.sampled_from([2.0**-12, 2.0**-4, 0.5])


class TestRoundingAsDelivered:
    @given(place=PLACES, centre=PLACES, step=STEPS)
    def test_is_to_the_nearest_multiple_of_the_step(self, place, centre, step):
        rounded, delivered = np.array(place), np.empty(3, np.float32)
        assert rounded_as_delivered(rounded, np.array(centre), step, delivered) is True
        exact = delivered.astype(np.float64)
        np.testing.assert_array_equal(exact % step, 0.0)
        assert (np.abs(exact - (np.array(place) + centre)) <= step / 2).all()
        np.testing.assert_array_equal(rounded, exact - np.array(centre))
        assert not np.signbit(delivered[delivered == 0]).any()

    def test_says_where_the_grid_does_not_reach(self):
        # 2²⁴ + 1 is the first whole number that float32 does not have; from there on none counts
        for value, expected in ((2.0**24, True), (2.0**24 + 1, False), (2.0**24 + 2, False)):
            place, delivered = np.array([0.0, value, 0.0]), np.empty(3, np.float32)
            assert rounded_as_delivered(place, np.zeros(3), 1.0, delivered) is expected
            slope = np.array([0.0, 1.0, 0.0])
            place[:] = (0.0, value, 0.0)
            assert rounded_to_volume(place, np.zeros(3), 1.0, slope, value, delivered) is expected


class TestRoundingToVolume:
    @given(place=PLACES, centre=PLACES, step=STEPS, slope=PLACES, miss=st.floats(-1, 1))
    def test_is_to_the_best_corner_of_the_cell(self, place, centre, step, slope, miss):
        middle, ways = np.array(centre), np.array(slope)
        wanted = np.dot(place, ways) + miss * step
        rounded, delivered = np.array(place), np.empty(3, np.float32)
        assert rounded_to_volume(rounded, middle, step, ways, wanted, delivered) is True
        exact = delivered.astype(np.float64)
        np.testing.assert_array_equal(rounded, exact - middle)
        low = np.floor((np.array(place) + middle) / step)
        corners = [(low + corner) * step for corner in itertools.product((0, 1), repeat=3)]
        assert exact.tolist() in [corner.tolist() for corner in corners]
        best = min(abs(ways @ (corner - middle) - wanted) for corner in corners)
        assert abs(ways @ rounded - wanted) == pytest.approx(best, rel=1e-6, abs=1e-9)
        assert not np.signbit(delivered[delivered == 0]).any()


@pytest.fixture(scope="module")
def edges(surface_from, bumpy_mesh, ends_of):
    """Return a function from a seed to a surface and its edges that may be collapsed."""

    def make(seed):
        surface = surface_from(*bumpy_mesh(seed, 40))
        found = []
        for query, corner in enumerate(surface.corner_facing.tolist()):
            one, two = ends_of(surface, corner)
            if link_condition_holds(surface, one, two, query):
                ring = np.empty((100, 2), np.int32)
                found.append((corner, one, two, ring, write_edge_link(surface, one, two, ring)))
        return surface, found

    return make


class TestReach:
    def test_is_a_ball_about_the_midpoint(self, edges):
        surface, found = edges(1)
        random, seen = np.random.default_rng(0), set()
        for _, one, two, ring, count in found:
            middle = surface.position[[one, two]].mean(axis=0)
            radius = np.linalg.norm(surface.position[ring[:count, 0]] - middle, axis=1).max()
            way = random.normal(size=3)
            way /= np.linalg.norm(way)
            for factor in (0.0, 0.999, 1.001, 3.0):
                place = middle + factor * REACH * radius * way
                reached = within_reach(surface.position, ring, count, one, two, place)
                assert reached == (factor < 1)
                seen.add(reached)
        assert seen == {True, False}

    def test_excludes_what_is_not_a_number(self, edges):
        surface, found = edges(1)
        _, one, two, ring, count = found[0]
        place = np.array([np.nan, 0.0, 0.0])
        assert not within_reach(surface.position, ring, count, one, two, place)


class TestCandidates:
    @pytest.mark.parametrize("missing", [0.0, 100.0])
    def test_keep_the_volume(self, edges, bumpy_mesh, missing):
        """The optimum of the default cost and the other four; a volume that is missing as well."""
        positions, faces = bumpy_mesh(2, 40)
        surface, found = edges(2)
        state = volume.state(positions, faces)
        surface.deficit[0] = 6 * missing
        wanted = np.linalg.det(positions[faces]).sum() / 6 + missing
        written = np.zeros(CANDIDATES, int)
        for corner, one, two, ring, count in found:
            for choice in range(CANDIDATES):
                place, slope = np.empty(3), np.empty(3)
                if candidate(state, surface, corner, choice, ring, count, slope, place):
                    moved = positions.copy()
                    moved[one] = moved[two] = place
                    after = np.linalg.det(moved[faces]).sum() / 6
                    assert after == pytest.approx(wanted, rel=1e-9)
                    written[choice] += 1
        assert written.min() > len(found) // 2

    def test_are_the_midpoint_the_ends_and_a_valid_direction(self, edges, bumpy_mesh):
        positions, faces = bumpy_mesh(3, 40)
        surface, found = edges(3)
        state, valid = quadric.state(positions, faces), 0

        def direction(vector):
            return vector / np.linalg.norm(vector)

        for corner, one, two, ring, count in found:
            middle = positions[[one, two]].mean(axis=0)
            places, slope = np.empty((CANDIDATES, 3)), np.empty(3)
            there = [
                candidate(state, surface, corner, choice, ring, count, slope, places[choice])
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
