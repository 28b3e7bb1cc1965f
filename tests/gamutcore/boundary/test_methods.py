"""The table of boundary methods: every entry wraps, by its defaults and about one centre."""

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


class TestTable:
    @pytest.mark.parametrize("name", BOUNDARIES)
    def test_defaults_are_accepted_and_canonical(self, name):
        for parameter in BOUNDARIES[name].parameters.values():
            assert parameter.checked(parameter.default) == parameter.default

    @pytest.mark.parametrize("name", BOUNDARIES)
    def test_parameters_are_those_of_the_function(self, name):
        method = BOUNDARIES[name]
        signature = inspect.signature(method.wrap).parameters
        assert {*method.parameters, "points", "centre"} == set(signature)
        if name != "convex-hull":  # whose function is the modified one's
            for option, parameter in method.parameters.items():
                assert parameter.default == signature[option].default

    @pytest.mark.parametrize("value", [0, 1.5, "1", None, True, float("nan"), 10**400, []])
    @pytest.mark.parametrize("name", ["modified-convex-hull", "convex-hull", "usv"])
    def test_a_power_that_is_none(self, name, value):
        with pytest.raises(OptionError) as caught:
            BOUNDARIES[name].parameters["gamma"].checked(value)
        assert caught.value.where == {"field": "gamma"}

    def test_the_convex_hull_has_no_power_but_one(self):
        gamma = BOUNDARIES["convex-hull"].parameters["gamma"]
        assert gamma.checked(1) == 1.0
        with pytest.raises(OptionError) as caught:
            gamma.checked(0.5)
        assert "convex hull" in caught.value.message


class TestWrapped:
    @pytest.mark.parametrize("name", BOUNDARIES)
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

    @pytest.mark.parametrize("name", BOUNDARIES)
    def test_takes_a_centre(self, random_cloud, name):
        boundary = compute_boundary(random_cloud(52), name, (52.0, 1.0, -1.0))
        np.testing.assert_array_equal(boundary.centre, (52.0, 1.0, -1.0))
