"""Device values of a boundary's vertices."""

import numpy as np
import pytest

from gamutcore.boundary import BOUNDARIES, compute_boundary, vertex_device_values


@pytest.mark.parametrize(
    "method", [name for name, entry in BOUNDARIES.items() if not entry.needs_faces]
)
def test_are_those_of_the_point_that_a_vertex_is_or_of_the_nearest(random_cloud, method):
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


def test_what_is_off_the_cube_by_a_rounding_is_put_on_it(random_cloud):
    points = random_cloud(3)
    boundary = compute_boundary(points, "convex-hull")
    device = np.full((len(points), 2), [np.nextafter(1.0, 2.0), -1e-17])
    values = vertex_device_values(boundary, points, device, ("C", "M")).values
    assert (values == [1.0, 0.0]).all()
