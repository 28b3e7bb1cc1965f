"""Points and centre of boundaries; refusals are tested with the hull."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, Delaunay

from gamutcore.boundary.centre import (
    _depth,
    _moments,
    _point_inside,
    automatic_centre,
    bounds,
    centre_on_grid,
    points_on_grid,
)
from gamutcore.boundary.radial_hull import radial_hull
from gamutcore.errors import CentreError, FlatPointsError, OptionError
from gamutcore.grid import grid_step

STEP = 2.0**-18


def cloud(seed, count=300):
    return points_on_grid(np.random.default_rng(seed).normal(size=(count, 3)))


def shell(steps):
    axis = np.linspace(-1, 1, steps)
    points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    return points[(np.abs(points) == 1).any(axis=1)]


class TestAutomaticCentre:
    @given(seed=st.integers(0, 10**6))
    def test_is_the_middle_or_the_centroid_and_inside(self, seed):
        points, step = points_on_grid(cloud(seed, 12)[0] * (1, 3, 2))
        found = automatic_centre(points, step).point
        np.testing.assert_array_equal(found, np.rint(found / step) * step)
        hull = ConvexHull(points)
        # the centroid by another way: simplices of Delaunay's tetrahedralisation
        tetrahedra = points[Delaunay(points).simplices]
        volumes = np.abs(np.linalg.det(tetrahedra[:, 1:] - tetrahedra[:, :1]))
        centroid = (tetrahedra.mean(axis=1) * volumes[:, np.newaxis]).sum(axis=0) / volumes.sum()
        middle = (points.min(axis=0) + points.max(axis=0)) / 2

        def depth(place):
            return -(hull.equations[:, :3] @ place + hull.equations[:, 3]).max()

        expected = middle if depth(middle) >= 0.5 * depth(centroid) else centroid
        np.testing.assert_allclose(found, expected, rtol=0, atol=step)
        assert depth(found) > 0

    @pytest.mark.parametrize("scale", [2.0**-60, 1.0, 2.0**30])
    def test_goes_with_the_scale(self, scale):
        points, step = cloud(1)
        np.testing.assert_array_equal(
            automatic_centre(points * scale, step * scale).point,
            automatic_centre(points, step).point * scale,
        )

    def test_many_points_in_one_place_hide_no_volume(self):
        # none of the first points spans anything
        points = np.vstack([np.zeros((5000, 3)), shell(2)])
        np.testing.assert_array_equal(automatic_centre(points, STEP).point, (0, 0, 0))

    @pytest.mark.parametrize("thickness", [0.0, 1e-12, 1e-8])
    def test_refuses_flat_points(self, thickness):
        plate = shell(5) * (1, 1, thickness)
        rotation = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
        for points in (plate, plate @ rotation):
            with pytest.raises(FlatPointsError):
                automatic_centre(points, 2.0**-60)

    def test_takes_points_that_are_just_not_flat(self):
        plate = shell(5) * (1, 1, 2.0**-15)
        found = automatic_centre(plate, 2.0**-40).point
        np.testing.assert_array_equal(found, (0, 0, 0))


class TestGivenCentre:
    def test_is_put_on_the_grid(self):
        points, step = cloud(2)
        found = centre_on_grid((0.1, 0.2, 0.3), points, step)
        np.testing.assert_array_equal(found, np.rint(np.divide((0.1, 0.2, 0.3), step)) * step)

    def test_auto_is_none(self):
        assert centre_on_grid("auto", *cloud(2)) is None

    def test_outside_the_bounds(self):
        with pytest.raises(CentreError):
            centre_on_grid((9, 0, 0), *cloud(2))

    @pytest.mark.parametrize("value", ["middle", None, (1, 2), (1, np.nan, 0), 1e300])
    def test_of_another_kind(self, value):
        with pytest.raises(OptionError):
            centre_on_grid(value, *cloud(2))


def test_points_are_put_on_their_grid():
    points = np.random.default_rng(3).normal(size=(50, 3))
    rounded, step = points_on_grid(points)
    assert step == grid_step(points)
    np.testing.assert_array_equal(rounded, np.rint(points / step) * step)


def test_points_have_one_layout_whatever_they_come_in():
    points = np.random.default_rng(3).normal(size=(50, 3))
    for layout in (np.asfortranarray(points), np.repeat(points, 2, axis=0)[::2]):
        rounded, _ = points_on_grid(layout)
        assert rounded.flags.c_contiguous
        np.testing.assert_array_equal(rounded, points_on_grid(points)[0])


@given(seed=st.integers(0, 100), count=st.integers(1, 30))
def test_bounds(seed, count):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    lowest, highest = bounds(points)
    np.testing.assert_array_equal(lowest, points.min(axis=0))
    np.testing.assert_array_equal(highest, points.max(axis=0))


def test_the_first_point_is_inside():
    points, _ = cloud(4)
    found = _point_inside(points, 10.0)
    assert len(radial_hull(points - found)) > 0


def test_moments_and_depth_of_a_box():
    corners = shell(2) * (1, 2, 3) + (0.5, 0.25, -0.125)
    faces = radial_hull(corners)
    np.testing.assert_allclose(_moments(corners, faces), np.multiply(48, (1, 0.5, 0.25, -0.125)))
    assert _depth(corners, faces, np.array([0.5, 0.25, -0.125])) == pytest.approx(1.0)
    assert _depth(corners, faces, np.array([2.0, 0.25, -0.125])) == pytest.approx(-0.5)
