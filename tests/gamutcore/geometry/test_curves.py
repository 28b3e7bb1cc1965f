"""Orders of points: neighbours stay near, and every point is there once."""

import numpy as np

from gamutcore.geometry import curve_order, curve_positions, grouped


def unit_vectors(count, seed):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1)[:, np.newaxis]


def test_of_a_cube_of_cells_takes_one_step_at_a_time():
    cells = np.array(list(np.ndindex(16, 16, 16)), np.float64)
    shuffled = np.random.default_rng(0).permutation(cells)
    steps = np.diff(shuffled[curve_order(shuffled)], axis=0)
    assert (abs(steps).sum(axis=1) == 1).all()


def test_neighbours_along_the_curve_are_near_on_the_sphere():
    points = unit_vectors(10_000, 0)
    steps = np.linalg.norm(np.diff(points[np.argsort(curve_positions(points))], axis=0), axis=1)
    # a point has 4 π ÷ 10,000 of the sphere to itself
    assert steps.mean() < 2 * np.sqrt(4 * np.pi / len(points))


def test_the_order_along_the_curve_has_all_points_and_keeps_equal_ones():
    points = np.random.default_rng(1).normal(size=(5000, 3))
    assert sorted(curve_order(points)) == list(range(5000))
    assert curve_order(np.ones((7, 3))).tolist() == list(range(7))
    assert curve_order(np.zeros((0, 3))).tolist() == []
    assert sorted(curve_order(np.array([[-1e60] * 3, [1e60] * 3, [0.0] * 3]))) == [0, 1, 2]


def test_groups_hold_their_items_in_ascending_order():
    group = np.random.default_rng(3).integers(0, 9, 200).astype(np.int32)
    start, items = grouped(group, 11)  # two groups are empty
    assert len(start) == 12
    for number, part in enumerate(np.split(items, start[1:-1])):
        assert part.tolist() == np.flatnonzero(group == number).tolist()
    assert grouped(group[:0], 2)[0].tolist() == [0, 0, 0]
