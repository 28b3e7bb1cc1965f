"""The hull against Qhull, against its definition, and for input that is difficult to round."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial import ConvexHull

from gamutcore.boundary.radial_hull import CLEARANCE, radial_hull
from gamutcore.geometry import (
    TriangleMesh,
    curve_positions,
    faces_not_seeing_centre,
    insertion_order,
)

ROTATION = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]


def directions(count, seed=0):
    found = np.random.default_rng(seed).normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1)[:, np.newaxis]


def grid(steps):
    axis = np.linspace(-1, 1, steps)
    return np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)


def shell(steps):
    points = grid(steps)
    return points[(np.abs(points) == 1).any(axis=1)]


def raised(points, gamma=0.2):
    return points * np.linalg.norm(points, axis=1)[:, np.newaxis] ** (gamma - 1)


def rim(count, height=0.0):
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.stack([np.cos(angle), np.sin(angle), np.full(count, height)], axis=1)


def hull(points):
    """Return the ordered points and their hull's faces."""
    ordered = np.ascontiguousarray(points[insertion_order(curve_positions(points))])
    return ordered, radial_hull(ordered)


def volume(points, faces):
    return np.linalg.det(points[faces]).sum() / 6


def greatest_height(points, faces):
    """Return the largest height of a point above the plane of a face."""
    one, two, three = (points[faces[:, corner]] for corner in range(3))
    normals = np.cross(two - one, three - one)
    normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
    offsets = np.einsum("ij,ij->i", normals, one)
    return max(
        (points @ normal - offset).max() for normal, offset in zip(normals, offsets, strict=True)
    )


def assert_valid(points, faces):
    used, packed = np.unique(faces, return_inverse=True)
    mesh = TriangleMesh(points[used], packed.reshape(-1, 3).astype(np.int32))
    assert mesh.validity((0.0, 0.0, 0.0)).is_gamut, mesh.validity((0.0, 0.0, 0.0))
    assert mesh.triangles == 2 * len(used) - 4
    assert faces_not_seeing_centre(points, faces).size == 0


def assert_hull(points, tolerance=1e-12):
    """Check the definition (no point above a face), validity, and the volume that Qhull finds."""
    ordered, faces = hull(points)
    assert_valid(ordered, faces)
    assert greatest_height(ordered, faces) < tolerance * np.abs(points).max()
    assert volume(ordered, faces) == pytest.approx(ConvexHull(points).volume, rel=1e-9)


BODIES = {
    "sphere": directions(3000),
    "sphere but for rounding": directions(3000) * (1 + 1e-15 * np.arange(3000)[:, np.newaxis] % 3),
    "cloud": np.random.default_rng(1).normal(size=(3000, 3)),
    "box": np.random.default_rng(2).uniform(-1, 1, (3000, 3)),
    "spikes": directions(1000) * 10 ** np.random.default_rng(3).uniform(-6, 0, (1000, 1)),
    "few rays": np.vstack([directions(30) * radius for radius in np.linspace(0.1, 1, 40)]),
    "grid": grid(7),
    "cube": grid(2),
    "cube's surface": shell(9),
    "cube's surface, raised": raised(shell(9)),
    "turned grid": grid(6) @ ROTATION,
    "turned cube's surface": shell(9) @ ROTATION,
    "flat": np.random.default_rng(4).normal(size=(2000, 3)) * (1, 1, 1e-6),
    "flat box": shell(9) * (1, 1, 1e-7),
    "needle": np.random.default_rng(4).normal(size=(2000, 3)) * (1, 1e-4, 1e-4),
    "flat sphere": directions(2000) * (1, 1, 1e-7),
    "double cone": np.vstack([rim(500), [(0, 0, 1), (0, 0, -1)]]),
    "cylinder": np.vstack([rim(200, -1.0), rim(200, 1.0)]),
    "parallels": np.vstack([rim(99, z) * (s, s, 1) for z, s in ((-0.9, 0.5), (0, 1), (0.9, 0.5))]),
    "tiny": directions(500) * 1e-30,
    "huge": directions(500) * 1e12,
    "off centre": np.add(directions(3000), (0.9, 0.3, 0.1)),
    "centre near a face": np.add(shell(5), (1 - 1e-8, 0.1, 0.2)),
    "centre near a corner": np.add(shell(5), 1 - 1e-8),
}


class TestAgainstQhull:
    @pytest.mark.parametrize("name", BODIES)
    def test_bodies(self, name):
        assert_hull(BODIES[name])

    @settings(max_examples=60)
    @given(
        points=arrays(np.float64, (25, 3), elements=st.integers(-3, 3).map(float)),
        shift=arrays(np.float64, 3, elements=st.integers(-2, 2).map(lambda k: k / 7)),
        stretch=arrays(np.float64, 3, elements=st.sampled_from([1.0, 1e-3, 0.1, 1 / 3])),
    )
    @pytest.mark.slow
    def test_lattices_full_of_ties(self, points, shift, stretch):
        corners = shell(2) * 3.25  # the centre is inside
        assert_hull((np.vstack([points, corners]) + shift) * stretch)

    @settings(max_examples=60)
    @given(seed=st.integers(0, 10**9), spread=st.sampled_from([0.0, 1e-15, 1e-9, 0.01, 1.0]))
    @pytest.mark.slow
    def test_clouds(self, seed, spread):
        random = np.random.default_rng(seed)
        points = directions(150, seed) * (1 + spread * random.uniform(-1, 0, (150, 1)))
        assert_hull(points @ np.diag(10 ** random.uniform(-3, 0, 3)))

    def test_points_of_a_line_but_for_rounding(self):
        # eighths of a cube's edges, turned: thousands of triples on one line but for their last bit
        ordered, faces = hull(shell(33) @ ROTATION)
        assert_valid(ordered, faces)
        assert greatest_height(ordered, faces) < 1e-12
        assert volume(ordered, faces) == pytest.approx(8.0, rel=1e-12)

    def test_points_that_differ_in_their_last_bits(self):
        # too near for a triangle between them that sees the centre: any of them will do
        random = np.random.default_rng(0)
        corners = directions(300)
        points = np.vstack([corners + 1e-15 * random.normal(size=(300, 3)) for _ in range(8)])
        ordered, faces = hull(points)
        assert_valid(ordered, faces)
        assert greatest_height(ordered, faces) < 1e-12
        assert volume(ordered, faces) == pytest.approx(ConvexHull(corners).volume, rel=1e-12)


class TestTheOrderOfPoints:
    @settings(max_examples=30)
    @given(seed=st.integers(0, 10**6))
    def test_does_not_matter(self, seed):
        points = raised(directions(200, seed) * (1, 0.7, 0.4))
        shuffled = np.random.default_rng(seed).permutation(points)
        expected = {frozenset(map(tuple, points[face])) for face in radial_hull(points)}
        assert {frozenset(map(tuple, shuffled[face])) for face in radial_hull(shuffled)} == expected

    def test_nor_do_duplicates_and_points_at_the_centre(self):
        points = directions(200)
        more = np.vstack([np.zeros((3, 3)), points, points[::-1], np.zeros((2, 3)), points / 2])
        assert volume(more, radial_hull(more)) == pytest.approx(
            volume(points, radial_hull(points)), rel=1e-12
        )
        assert radial_hull(more).shape == radial_hull(points).shape

    def test_a_power_of_two_changes_nothing(self):
        points = raised(shell(6) * (1, 2, 3))
        np.testing.assert_array_equal(radial_hull(points * 2.0**-70), radial_hull(points))


class TestTheCentre:
    @pytest.mark.parametrize(
        "points", [np.empty((0, 3)), np.zeros((9, 3)), np.eye(3), np.eye(4, 3)]
    )
    def test_without_points_around_it_there_is_no_hull(self, points):
        assert radial_hull(points).shape == (0, 3)

    @pytest.mark.parametrize("outside", [1e-12, 1e-3, 0.5, 10.0])
    def test_outside_there_is_none(self, outside):
        assert len(radial_hull(np.add(directions(500), (1 + outside, 0, 0)))) == 0
        assert len(radial_hull(np.add(shell(5), (1 + outside, 0.1, 0.2)))) == 0

    @pytest.mark.parametrize("point", [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0.3, 0.2)])
    def test_on_the_surface_there_is_none(self, point):
        assert len(radial_hull(shell(5) + point)) == 0

    @pytest.mark.parametrize("point", [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0.3, 0.2)])
    def test_inside_by_more_than_the_clearance_there_is_one(self, point):
        # the clearance is relative to the largest radius, at most 2 √3 here
        points = shell(5) + np.multiply(point, 1 - 4 * CLEARANCE)
        assert_valid(points, radial_hull(points))
        assert len(radial_hull(shell(5) + np.multiply(point, 1 - CLEARANCE / 8))) == 0


@pytest.mark.parametrize("name", ["circle", "two circles", "moment curve"])
@pytest.mark.slow
def test_large_bodies_that_qhull_takes_minutes_for(name):
    # circles in planes that are none in floating point; the hull with the highest degrees
    along = np.linspace(-1, 1, 100_000)
    curve = {
        "circle": rim(100_000),
        "two circles": np.vstack([rim(50_000, 0.5), rim(50_000, -0.5)]),
        "moment curve": np.stack([along, along**2 - 0.5, along**3], axis=1),
    }[name]
    ordered, faces = hull(np.vstack([curve, shell(2) * 0.3]) @ ROTATION)
    assert_valid(ordered, faces)
    some = np.random.default_rng(0).choice(len(faces), 500, replace=False)
    assert greatest_height(ordered, faces[some]) < 1e-9
