"""Helpers of the segment methods: points, centres, the farthest point of each segment."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.boundary import modified_convex_hull
from gamutcore.boundary.points import centred_points, farthest_points
from gamutcore.errors import CentreError, FlatPointsError, OptionError
from gamutcore.grid import grid_step


class TestCentredPoints:
    @pytest.mark.parametrize("centre", ["auto", (50.1, 0.2, 0.3)])
    def test_the_centre_is_that_of_the_modified_hull(self, random_cloud, centre):
        points = random_cloud(30, 1000)
        _, middle = centred_points(points, centre)
        np.testing.assert_array_equal(middle, modified_convex_hull(points, 0.2, centre).centre)

    def test_points_are_on_the_grid_and_near_where_they_were(self, random_cloud):
        points = random_cloud(31)
        rounded, _ = centred_points(points, "auto")
        step = grid_step(points)
        np.testing.assert_array_equal(rounded / step, np.rint(rounded / step))
        assert 0 < np.abs(rounded - points).max() <= step / 2

    @pytest.mark.parametrize(
        ("centre", "kind"), [((50, 200, 0), CentreError), ((1, 2), OptionError)]
    )
    def test_a_centre_that_is_refused(self, random_cloud, centre, kind):
        with pytest.raises(kind):
            centred_points(random_cloud(32), centre)

    def test_flat_points_with_a_centre(self):
        with pytest.raises(FlatPointsError):
            centred_points(np.random.default_rng(0).random((50, 3)) * (1, 1, 0), (0.5, 0.5, 0))


class TestFarthestPoints:
    @given(st.lists(st.tuples(st.integers(0, 5), st.sampled_from([0.5, 1.0, 2.0, 3.0]))))
    def test_is_the_first_of_the_farthest(self, pairs):
        segment = np.array([number for number, _ in pairs], np.int64)
        radii = np.array([radius for _, radius in pairs])
        for number, found in enumerate(farthest_points(segment, radii, 6)):
            inside = [(-radius, index) for index, (s, radius) in enumerate(pairs) if s == number]
            assert found == (min(inside)[1] if inside else -1)
