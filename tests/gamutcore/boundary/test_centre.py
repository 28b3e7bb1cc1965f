"""Centres: of points by Qhull, of a device's surface whose star-kernel is known."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, Delaunay

from gamutcore.boundary import modified_convex_hull
from gamutcore.boundary.centre import Centre, centre_of_points
from gamutcore.boundary.device_surface import device_centre, enclosed_centre
from gamutcore.errors import FlatPointsError
from gamutcore.geometry import grid_step


def shell(steps):
    axis = np.linspace(-1, 1, steps)
    points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    return points[(np.abs(points) == 1).any(axis=1)]


class TestOfPoints:
    @given(seed=st.integers(0, 10**6))
    def test_is_the_middle_or_the_centroid_and_inside(self, seed):
        points = np.random.default_rng(seed).normal(size=(12, 3)) * (1, 3, 2)
        step = grid_step(points)
        found = modified_convex_hull(points).centre
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
        np.testing.assert_allclose(found, expected, rtol=0, atol=2 * step)
        assert depth(found) > 0

    def test_many_points_in_one_place_hide_no_volume(self):
        # none of the first points spans anything
        points = np.vstack([np.zeros((5000, 3)), shell(2)])
        np.testing.assert_array_equal(modified_convex_hull(points).centre, (0, 0, 0))

    @pytest.mark.parametrize("thickness", [0.0, 1e-12, 1e-8])
    def test_flat_points_have_none(self, thickness):
        plate = shell(5) * (1, 1, thickness)
        rotation = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
        for points in (plate, plate @ rotation):
            with pytest.raises(FlatPointsError):
                centre_of_points(points)


def surface(body):
    return np.array(body.vertices, float), np.array(body.faces, np.int32)


def outside_share(points, faces, centre):
    """Share of the area of faces that turn their back to a point."""
    first, second, third = (points[faces[:, corner]] - centre for corner in range(3))
    normal = np.cross(second - first, third - first)
    areas = np.linalg.norm(normal, axis=1)
    return areas[np.einsum("ij,ij->i", normal, first) <= 0].sum() / areas.sum()


def test_all_faces_of_a_star_shaped_surface_see_the_centre():
    """A box with a notch: the middle of the bounds is in the notch, the star-kernel below it."""
    outline = np.array([(0, 0), (10, 0), (10, 9), (5, 3), (0, 9)], float)
    prism = trimesh.creation.extrude_triangulation(
        outline, np.array([(0, 1, 3), (1, 2, 3), (0, 3, 4)]), 5.0
    )
    points, faces = surface(prism)
    assert outside_share(points, faces, (5, 4.5, 2.5)) > 0
    found = device_centre(points, faces)
    assert found.origin == "star-kernel"
    assert found.hidden == 0
    assert outside_share(points, faces, found.point) == 0
    # the deepest point has the same distance from the floor and from the planes of the notch
    normal = np.array([6, 5]) / np.hypot(6, 5)
    assert found.depth == pytest.approx(found.point[1])
    assert found.depth == pytest.approx(normal @ (np.array([5, 3]) - found.point[:2]))


@given(seed=st.integers(0, 2**32 - 1), scale=st.sampled_from([1e-3, 1.0, 1e3]))
def test_a_bent_sphere_has_a_centre_that_hides_nothing_and_is_as_deep_as_it_says(seed, scale):
    rng = np.random.default_rng(seed)
    ball = trimesh.creation.icosphere(3, 1.0)
    radii = 1 + 0.1 * np.sin(ball.vertices @ rng.normal(size=3) * 2)
    points = (ball.vertices * radii[:, np.newaxis] + rng.normal(size=3)) * scale
    found = device_centre(points, np.array(ball.faces, np.int32))
    assert found.origin == "star-kernel"
    first, second, third = (points[ball.faces[:, corner]] - found.point for corner in range(3))
    normal = np.cross(second - first, third - first)
    normal /= np.linalg.norm(normal, axis=1)[:, np.newaxis]
    assert np.einsum("ij,ij->i", normal, first).min() == pytest.approx(found.depth, rel=1e-6)


def test_a_fold_hides_as_little_as_possible():
    """A vertex pushed through the opposite side folds the faces around it; all others stay seen."""
    ball = trimesh.creation.icosphere(4, 10.0)
    points, faces = surface(ball)
    points[0] *= -1.5
    found = device_centre(points, faces)
    assert found.origin == "least hidden area"
    assert found.hidden == pytest.approx(outside_share(points, faces, found.point))
    assert 0 < found.hidden <= outside_share(points, faces, np.zeros(3))
    assert found.depth > 1


def test_flat_surfaces_have_no_centre():
    plane = np.random.default_rng(1).normal(size=(30, 3)) * (1, 1, 0)
    faces = np.arange(30, dtype=np.int32).reshape(-1, 3)
    assert device_centre(plane, faces) is None
    assert device_centre(np.zeros((3, 3)), faces[:1]) is None


def test_a_given_centre_is_examined():
    ball = trimesh.creation.icosphere(4, 10.0)
    points, faces = surface(ball)
    found = device_centre(points, faces, np.array([7.0, 0.0, 0.0]))
    assert found.origin == "the option centre"
    assert found.hidden == 0
    assert found.depth == pytest.approx(3, rel=0.01)
    outside = device_centre(points, faces, np.array([20.0, 0.0, 0.0]))
    # a sphere's cap beyond the tangent cone has the share (1 − r/d) / 2 of the area
    assert outside.hidden == pytest.approx(0.25, abs=0.01)


def test_a_centre_inside_of_crossing_faces_is_kept():
    bars = [trimesh.creation.box(extents) for extents in ((4, 1, 1), (1, 4, 1))]
    points, faces = surface(trimesh.util.concatenate(bars))
    start = centre_of_points(points)
    assert enclosed_centre(points, faces, start) is start


def test_outside_of_the_faces_a_deep_point_replaces_the_centre():
    """The middle of a thick bowl's bounds is in its hollow."""
    outer = trimesh.creation.icosphere(4, 10.0)
    points, faces = surface(outer)
    top = points[:, 2] > 0
    points[top, 2] *= -0.5  # the upper half is pushed in, half as deep as the lower one
    start = Centre(np.array([0.0, 0.0, -0.5]), "middle of the bounding box", 0.5)
    found = enclosed_centre(points, faces, start)
    assert found.origin == "deep point within the faces"
    # no ball of more than half the thickness, which is 5 at the axis, fits in between
    assert 1.25 < found.depth < 2.6
    nearest = np.linalg.norm(points - found.point, axis=1).min()
    assert found.depth == pytest.approx(nearest, rel=0.1)


def test_a_ring_has_no_point_that_all_faces_see():
    points, faces = surface(trimesh.creation.torus(3, 1))
    found = device_centre(points, faces)
    assert found.origin == "least hidden area"
    assert found.hidden == pytest.approx(outside_share(points, faces, found.point))
    assert found.hidden > 0


def test_of_a_tetrahedron_it_is_the_incentre():
    """x, y, z ≥ 0 and x + y + z ≤ 1: r = (1 − 3 r) / √3 on the diagonal, 1 / (3 + √3)."""
    points = np.vstack([np.zeros(3), np.eye(3)])
    faces = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], np.int32)
    found = device_centre(points, faces)
    np.testing.assert_allclose(found.point, 1 / (3 + np.sqrt(3)), atol=1e-6)
    assert found.depth == pytest.approx(1 / (3 + np.sqrt(3)))
