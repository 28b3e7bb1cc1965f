"""The order in which points enter a hull: a curve without jumps, rounds that grow."""

import numpy as np
import pytest

from gamutcore.boundary.insertion_order import (
    CURVE_BITS,
    LAST_ROUND,
    _hilbert_position,
    _rounds,
    curve_positions,
    insertion_order,
)


def directions(count, seed=0):
    random = np.random.default_rng(seed)
    found = random.normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1)[:, np.newaxis]


def test_the_curve_visits_every_cell_and_steps_to_a_neighbour():
    # an aligned block of cells is a run of the curve at any level
    cells = np.array([(column, row) for column in range(32) for row in range(32)])
    places = np.array([_hilbert_position(int(column), int(row)) for column, row in cells])
    np.testing.assert_array_equal(np.sort(places), np.arange(1024))
    steps = np.diff(cells[np.argsort(places)], axis=0)
    np.testing.assert_array_equal(np.abs(steps).sum(axis=1), 1)


def test_near_in_place_is_near_in_direction():
    # 20,000 directions are about 0.025 apart; the sphere is cut open along edges of an octahedron,
    # yet the curve itself has no jump
    found = directions(20_000)
    ordered = found[np.argsort(curve_positions(found))]
    steps = np.linalg.norm(np.diff(ordered, axis=0), axis=1)
    assert np.median(steps) < 0.04
    assert steps.max() < 0.3


def test_only_the_direction_counts():
    found = directions(100)
    np.testing.assert_array_equal(curve_positions(found), curve_positions(found * 2.0**-40))


@pytest.mark.parametrize("axis", range(3))
def test_places_are_within_range_at_the_poles_and_the_centre(axis):
    points = np.array([np.eye(3)[axis], -np.eye(3)[axis], np.zeros(3), -np.zeros(3)])
    places = curve_positions(points)
    assert places.min() >= 0
    assert places.max() < 4**CURVE_BITS
    assert places[0] != places[1]


def test_rounds_grow_fourfold():
    counts = np.bincount(_rounds(1_000_000), minlength=LAST_ROUND + 1)
    assert counts[-1] == pytest.approx(750_000, rel=0.01)
    assert counts[-2] == pytest.approx(187_500, rel=0.01)
    assert counts[-3] == pytest.approx(46_875, rel=0.03)
    assert counts[: LAST_ROUND - 9].sum() < 50


def test_the_order_is_by_round_and_within_rounds_along_the_curve():
    places = curve_positions(directions(5000))
    order = insertion_order(places)
    np.testing.assert_array_equal(np.sort(order), np.arange(5000))
    rounds = _rounds(5000)[order]
    assert (np.diff(rounds) >= 0).all()
    same = np.diff(rounds) == 0
    assert (np.diff(places[order])[same] >= 0).all()


def test_further_points_do_not_change_the_order_of_the_first():
    places = curve_positions(directions(3000))
    order = insertion_order(places)
    np.testing.assert_array_equal(order[order < 1000], insertion_order(places[:1000]))
