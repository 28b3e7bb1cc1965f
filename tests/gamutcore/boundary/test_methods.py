"""The table of boundary methods: every entry gives a valid boundary about the same centre."""

import inspect

import numpy as np
import pytest

from gamutcore.boundary import (
    BOUNDARIES,
    compute_boundary,
    modified_convex_hull,
    segment_maxima,
    usv,
)
from gamutcore.errors import OptionError

OF_POINTS = [name for name, method in BOUNDARIES.items() if not method.needs_faces]
"""Methods that need nothing but points; the tests of the others make faces."""


class TestTable:
    @pytest.mark.parametrize("name", BOUNDARIES)
    def test_options_are_the_parameters_of_the_function(self, name):
        method = BOUNDARIES[name]
        signature = inspect.signature(method.wrap).parameters
        faces = {"faces"} if method.needs_faces else set()
        assert {*method.defaults, *faces, "points", "centre"} == set(signature)
        if name != "convex-hull":  # whose function is the modified one's
            for option, default in method.defaults.items():
                assert default == signature[option].default

    @pytest.mark.parametrize("value", [0, 1.5, "1", None, True, float("nan"), 10**400, []])
    @pytest.mark.parametrize("name", ["modified-convex-hull", "usv"])
    def test_an_invalid_power(self, name, value, random_cloud):
        with pytest.raises(OptionError) as caught:
            compute_boundary(random_cloud(49), name, gamma=value)
        assert caught.value.where == {"field": "gamma"}


class TestComputeBoundary:
    @pytest.mark.parametrize("name", OF_POINTS)
    @pytest.mark.slow
    def test_is_valid_and_about_the_same_centre(self, random_cloud, assert_decimates, name):
        points = random_cloud(50, 400)
        boundary = compute_boundary(points, name)
        np.testing.assert_array_equal(boundary.centre, modified_convex_hull(points).centre)
        assert_decimates(boundary)

    def test_is_what_the_functions_give(self, random_cloud):
        points = random_cloud(51)
        for name, parameters, expected in (
            ("modified-convex-hull", {}, modified_convex_hull(points)),
            ("modified-convex-hull", {"gamma": 0.4}, modified_convex_hull(points, 0.4)),
            ("convex-hull", {}, modified_convex_hull(points, 1.0)),
            ("segment-maxima", {"segments": (5, 7)}, segment_maxima(points, (5, 7))),
            ("usv", {"basis": "octahedron"}, usv(points, "octahedron")),
        ):
            assert compute_boundary(points, name, **parameters).mesh == expected.mesh

    @pytest.mark.parametrize("name", OF_POINTS)
    def test_takes_a_centre(self, random_cloud, name):
        boundary = compute_boundary(random_cloud(52), name, (52.0, 1.0, -1.0))
        np.testing.assert_array_equal(boundary.centre, (52.0, 1.0, -1.0))
