"""Nearest points, compared with all faces one by one, a cube, a sphere and trimesh."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.search import build_index, contains, nearest, signed_distance

COORDINATE = st.one_of(st.sampled_from([-1.0, 1.0, 0.0, 3.0, 1e6]), st.floats(-3, 3))


def segment_distances(point, start, end):
    along = end - start
    share = ((point - start) * along).sum(axis=1) / (along * along).sum(axis=1)
    return np.linalg.norm(point - start - np.clip(share, 0, 1)[:, None] * along, axis=1)


def smallest_distance(point, corners):
    """Return the distance to the nearest of all faces: to their edges, and to planes above them."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    height = ((point - a) * normal).sum(axis=1)
    foot = point - height[:, None] * normal
    above = np.ones(len(a), bool)
    distances = []
    for start, end in ((a, b), (b, c), (c, a)):
        above &= (np.cross(end - start, foot - start) * normal).sum(axis=1) >= 0
        distances.append(segment_distances(point, start, end).min())
    if above.any():
        distances.append(abs(height[above]).min())
    return min(distances)


def assert_nearest(points, level):
    """Compare with all faces, and check that the fields describe the same point."""
    index = build_index(*level)
    found = nearest(points, index)
    corners = index.vertices[index.faces]
    expected = np.array([smallest_distance(point, corners) for point in points])
    scale = np.maximum(abs(points).max(axis=1), abs(corners).max())
    assert (abs(found.distance - expected) <= 1e-12 * scale).all()
    length = np.linalg.norm(found.points - points, axis=1)
    assert (abs(found.distance - length) <= 1e-12 * scale).all()
    assert (found.weights >= 0).all()
    np.testing.assert_allclose(found.weights.sum(axis=1), 1, rtol=1e-14)
    at = np.einsum("nc,ncx->nx", found.weights, corners[found.faces])
    np.testing.assert_allclose(found.points, at, atol=1e-13 * abs(corners).max())
    return found


def barycentric(random, count):
    """Return weights inside faces, on edges and at corners."""
    weights = random.dirichlet(np.ones(3), count)
    weights[: count // 3, 0] = 0
    weights[: count // 6, 1] = 0
    return weights / weights.sum(axis=1, keepdims=True)


class TestNearest:
    @pytest.mark.parametrize(("count", "roughness"), [(8, 0.1), (30, 0.4), (500, 0.6), (500, 0.0)])
    def test_is_the_smallest_over_all_faces(self, rough, count, roughness):
        vertices, faces, centre = level = rough(21, count, roughness)
        random = np.random.default_rng(0)
        corners = vertices.astype(np.float64)[faces[random.integers(0, len(faces), 60)]]
        on_faces = np.einsum("nc,ncx->nx", barycentric(random, 60), corners)
        outwards = centre + (on_faces - centre) * random.uniform(0, 3, (60, 1))
        points = np.concatenate(
            [
                centre + random.uniform(-120, 120, (100, 3)),
                on_faces,
                outwards,
                centre + random.normal(0, 1e-9, (5, 3)),
                centre[np.newaxis],
                centre + 1e9 * random.normal(size=(5, 3)),
            ]
        )
        found = assert_nearest(points, level)
        assert found.distance[100:160].max() < 1e-12 * 100

    @settings(max_examples=200, deadline=None)
    @given(point=st.tuples(COORDINATE, COORDINATE, COORDINATE))
    @pytest.mark.slow
    def test_of_a_cube_is_a_comparison_of_coordinates(self, cube, point):
        found = nearest([point], cube)
        clipped = np.clip(point, -1, 1)
        if (clipped != point).any():
            np.testing.assert_allclose(found.points[0], clipped, atol=1e-9)
            expected = np.linalg.norm(clipped - point)
        else:
            expected = 1 - abs(clipped).max()
        assert abs(found.distance[0] - expected) <= 1e-12 * max(1, *np.abs(point))

    def test_of_a_fine_sphere_is_the_difference_of_radii(self, rough):
        vertices, faces, centre = rough(22, 3000, 0.0)
        points = centre + np.random.default_rng(1).uniform(-120, 120, (5000, 3))
        radius = np.linalg.norm(points - centre, axis=1)
        # faces of the inscribed polyhedron are below the sphere by so much
        depth = 40 - np.linalg.norm(vertices[faces].mean(axis=1) - centre, axis=1).min() + 0.1
        found = signed_distance(points, (vertices, faces, centre))
        assert (found >= radius - 40 - 1e-5).all()
        assert (found <= radius - 40 + depth).all()

    def test_needles_are_no_difficulty(self):
        """A bipyramid whose faces are a millionth as wide as long, and thinner ones."""
        for width in (1e-3, 1e-6, 1e-9, 1e-11):
            ring = [(1, 0, 0), (1 - width, width, 0), (-1, 1, 0), (-1, -1, 0)]
            vertices = np.array([*ring, (0, 0, 1), (0, 0, -1)])
            upper = [(at, (at + 1) % 4, 4) for at in range(4)]
            faces = np.array(upper + [(two, one, 5) for one, two, _ in upper])
            random = np.random.default_rng(2)
            weights = barycentric(random, 40)
            on_faces = np.einsum("nc,ncx->nx", weights, vertices[faces[random.integers(0, 8, 40)]])
            points = np.concatenate([on_faces, random.uniform(-2, 2, (40, 3))])
            found = assert_nearest(points, (vertices, faces, (0.0, 0.0, 0.0)))
            assert found.distance[:40].max() < 1e-15

    def test_vertices_are_given_the_first_of_their_faces(self, cube):
        """All distances are exactly 0 there."""
        vertices, faces, _ = cube
        found = nearest(vertices, cube)
        assert found.faces.tolist() == [
            int(np.flatnonzero((faces == vertex).any(axis=1))[0]) for vertex in range(8)
        ]

    def test_takes_levels_and_points_of_any_size(self, cube):
        vertices, faces, centre = cube[0].astype(np.float64), *cube[1:]
        for size in (1e-30, 1e30, 1e50):
            found = nearest(size * np.array([(3.0, 0.5, 0.25)]), (size * vertices, faces, centre))
            np.testing.assert_allclose(found.points / size, [(1, 0.5, 0.25)], rtol=1e-12)
        np.testing.assert_allclose(
            nearest(np.diag([1e60, 1e30, -1e60]), cube).distance, [1e60, 1e30, 1e60]
        )


class TestSignedDistance:
    def test_is_the_distance_with_the_sign_of_contains(self, rough):
        level = build_index(*rough(24, 300))
        points = np.random.default_rng(5).uniform(*level.box, (2000, 3))
        found = signed_distance(points, level)
        np.testing.assert_array_equal(abs(found), nearest(points, level).distance)
        np.testing.assert_array_equal(found < 0, contains(points, level))

    def test_at_vertices_is_zero_without_a_sign(self, rough):
        vertices, faces, centre = rough(25, 300)
        found = signed_distance(vertices, (vertices, faces, centre))
        assert (found == 0).all()
        assert not np.signbit(found).any()
