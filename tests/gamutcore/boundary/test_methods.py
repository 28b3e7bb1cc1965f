"""The table of boundary methods: every entry gives a valid boundary about the same centre."""

import numpy as np
import pytest

from gamutcore.boundary import (
    BOUNDARIES,
    compute_boundary,
    modified_convex_hull,
    vertex_device_values,
)

OF_POINTS = [name for name, method in BOUNDARIES.items() if not method.needs_faces]
"""Methods that need nothing but points; the tests of the others make faces."""


class TestComputeBoundary:
    @pytest.mark.parametrize("name", OF_POINTS)
    @pytest.mark.slow
    def test_is_valid_and_about_the_same_centre(self, random_cloud, assert_decimates, name):
        points = random_cloud(50, 400)
        boundary = compute_boundary(points, name)
        np.testing.assert_array_equal(boundary.centre, modified_convex_hull(points).centre)
        assert_decimates(boundary)

    @pytest.mark.parametrize("name", OF_POINTS)
    def test_takes_a_centre(self, random_cloud, name):
        boundary = compute_boundary(random_cloud(52), name, (52.0, 1.0, -1.0))
        np.testing.assert_array_equal(boundary.centre, (52.0, 1.0, -1.0))


@pytest.mark.parametrize("method", OF_POINTS)
def test_device_values_are_those_of_the_point_that_a_vertex_is_or_of_the_nearest(
    random_cloud, method
):
    points = random_cloud(3, 400)
    # values that tell where their point is
    device = (points - points.min(axis=0)) / np.ptp(points, axis=0)
    boundary = compute_boundary(points, method)
    values = vertex_device_values(boundary, points, device, ("R", "G", "B"))
    assert values.channels == ("R", "G", "B")
    constructed = boundary.sources < 0
    assert constructed.any() == (method == "segment-maxima")
    known = boundary.sources[~constructed]
    np.testing.assert_array_equal(values.values[~constructed], device[known])
    for vertex, row in zip(
        boundary.mesh.vertices[constructed], values.values[constructed], strict=True
    ):
        nearest = np.linalg.norm(points - vertex, axis=1).argmin()
        np.testing.assert_array_equal(row, device[nearest])


def test_device_values_off_the_cube_by_a_rounding_are_put_on_it(random_cloud):
    points = random_cloud(3)
    boundary = compute_boundary(points, "modified-convex-hull", gamma=1)
    device = np.full((len(points), 2), [np.nextafter(1.0, 2.0), -1e-17])
    values = vertex_device_values(boundary, points, device, ("C", "M")).values
    assert (values == [1.0, 0.0]).all()
