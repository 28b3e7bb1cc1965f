"""The order along a Hilbert curve: its definition, and sorting."""

import numpy as np

from gamutcore.queries.curve import curve_order


class TestCurveOrder:
    def test_of_a_cube_of_cells_takes_one_step_at_a_time(self):
        cells = np.array(list(np.ndindex(16, 16, 16)), np.float64)
        shuffled = np.random.default_rng(0).permutation(cells)
        steps = np.diff(shuffled[curve_order(shuffled)], axis=0)
        assert (abs(steps).sum(axis=1) == 1).all()

    def test_is_a_permutation_that_keeps_equal_points_in_order(self):
        points = np.random.default_rng(1).normal(size=(5000, 3))
        assert sorted(curve_order(points)) == list(range(5000))
        assert curve_order(np.ones((7, 3))).tolist() == list(range(7))
        assert curve_order(np.zeros((0, 3))).tolist() == []

    def test_takes_points_that_are_very_far_apart(self):
        points = np.diag([1e60, -1e60, 1e-300])
        assert sorted(curve_order(points)) == [0, 1, 2]
