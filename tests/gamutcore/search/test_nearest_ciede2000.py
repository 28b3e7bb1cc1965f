"""CIEDE2000 and the nearest point by it: published pairs, and dense samples of the surface."""

import numpy as np
import pytest

from gamutcore.colours.colorimetry import colour_science
from gamutcore.search import build_index, delta_e_2000, nearest, nearest_ciede2000
from gamutcore.search.ciede2000_bounds import (
    BOUND,
    set_triangle_bounds,
)
from gamutcore.search.face_tree import WIDTH

# Sharma, Wu & Dalal (2005), table I
PAIRS = """
50.0000 2.6772 -79.7751 50.0000 0.0000 -82.7485 2.0425
50.0000 3.1571 -77.2803 50.0000 0.0000 -82.7485 2.8615
50.0000 2.8361 -74.0200 50.0000 0.0000 -82.7485 3.4412
50.0000 -1.3802 -84.2814 50.0000 0.0000 -82.7485 1.0000
50.0000 -1.1848 -84.8006 50.0000 0.0000 -82.7485 1.0000
50.0000 -0.9009 -85.5211 50.0000 0.0000 -82.7485 1.0000
50.0000 0.0000 0.0000 50.0000 -1.0000 2.0000 2.3669
50.0000 -1.0000 2.0000 50.0000 0.0000 0.0000 2.3669
50.0000 2.4900 -0.0010 50.0000 -2.4900 0.0009 7.1792
50.0000 2.4900 -0.0010 50.0000 -2.4900 0.0010 7.1792
50.0000 2.4900 -0.0010 50.0000 -2.4900 0.0011 7.2195
50.0000 2.4900 -0.0010 50.0000 -2.4900 0.0012 7.2195
50.0000 -0.0010 2.4900 50.0000 0.0009 -2.4900 4.8045
50.0000 -0.0010 2.4900 50.0000 0.0010 -2.4900 4.8045
50.0000 -0.0010 2.4900 50.0000 0.0011 -2.4900 4.7461
50.0000 2.5000 0.0000 50.0000 0.0000 -2.5000 4.3065
50.0000 2.5000 0.0000 73.0000 25.0000 -18.0000 27.1492
50.0000 2.5000 0.0000 61.0000 -5.0000 29.0000 22.8977
50.0000 2.5000 0.0000 56.0000 -27.0000 -3.0000 31.9030
50.0000 2.5000 0.0000 58.0000 24.0000 15.0000 19.4535
50.0000 2.5000 0.0000 50.0000 3.1736 0.5854 1.0000
50.0000 2.5000 0.0000 50.0000 3.2972 0.0000 1.0000
50.0000 2.5000 0.0000 50.0000 1.8634 0.5757 1.0000
50.0000 2.5000 0.0000 50.0000 3.2592 0.3350 1.0000
60.2574 -34.0099 36.2677 60.4626 -34.1751 39.4387 1.2644
63.0109 -31.0961 -5.8663 62.8187 -29.7946 -4.0864 1.2630
61.2901 3.7196 -5.3901 61.4292 2.2480 -4.9620 1.8731
35.0831 -44.1164 3.7933 35.0232 -40.0716 1.5901 1.8645
22.7233 20.0904 -46.6940 23.0331 14.9730 -42.5619 2.0373
36.4612 47.8580 18.3852 36.2715 50.5065 21.2231 1.4146
90.8027 -2.0831 1.4410 91.1528 -1.6435 0.0447 1.4441
90.9257 -0.5406 -0.9208 88.6381 -0.8985 -0.7239 1.5381
6.7747 -0.2908 -2.4247 5.8714 -0.0985 -2.2286 0.6377
2.0776 0.0795 -1.1350 0.9033 -0.0636 -0.5514 0.9082
"""


class TestDeltaE2000:
    def test_of_the_published_pairs(self):
        pairs = np.array([line.split() for line in PAIRS.split("\n") if line], float)
        assert len(pairs) == 34
        for one, two in ((pairs[:, :3], pairs[:, 3:6]), (pairs[:, 3:6], pairs[:, :3])):
            np.testing.assert_array_equal(delta_e_2000(one, two).round(4), pairs[:, 6])

    def test_is_that_of_colour_science(self):
        random = np.random.default_rng(0)
        one = random.uniform((0, -120, -120), (100, 120, 120), (20_000, 3))
        two = one + random.normal(0, 1, one.shape) * random.choice([0.1, 5, 60], (20_000, 1))
        expected = colour_science().delta_E(one, two, method="CIE 2000")
        np.testing.assert_allclose(delta_e_2000(one, two), expected, atol=1e-10)

    def test_of_neutral_colours_and_far_ones(self):
        one = np.array([(50, 0, 0), (0, 0, 0), (50, 30, 0), (0, 1e60, -1e60)], float)
        two = np.array([(50, 0, 0), (100, 0, 0), (50, 0, 0), (1e60, 0, 0)], float)
        found = delta_e_2000(one, two)
        assert found[0] == 0
        assert abs(found[1] - 100) < 1e-12
        assert np.isfinite(found).all()


WORK = np.empty(8 * WIDTH), np.empty(11 * WIDTH)

STEPS = np.array([(i, j, 6 - i - j) for i in range(7) for j in range(7 - i)]) / 6


def smallest_of_triangles(colours, triangles):
    """Return the smallest ΔE00 to samples of each triangle."""
    samples = np.einsum("sc,ncx->snx", STEPS, triangles)
    return np.min([delta_e_2000(colours, each) for each in samples], axis=0)


def triangle_bound(colour, triangle, found):
    """Return the lower bound of ΔE00 to a triangle."""
    corners = np.repeat(triangle.reshape(9, 1), WIDTH, axis=1).ravel()
    set_triangle_bounds(np.append(colour, np.hypot(*colour[1:])), corners, found, *WORK)
    return np.sqrt(2 * max(found[BOUND * WIDTH], 0))


def random_triangles(seed, count, radius):
    """Return colours and triangles: near each other, far, of equal hue, opposite, neutral."""
    random = np.random.default_rng(seed)
    middles = random.uniform((0, -100, -100), (100, 100, 100), (count, 3))
    middles[::3, 1:] *= random.uniform(0.02, 0.5, (len(middles[::3]), 1))
    spread = random.choice([3, 10, 25, 60], (count, 1))
    colours = middles + spread * random.normal(size=(count, 3))
    kind = random.integers(0, 4, count)
    colours[kind == 1] = random.uniform((-60, -200, -200), (160, 200, 200), (count, 3))[kind == 1]
    for which, least, most in ((2, 0.01, 8.0), (3, -8.0, -0.01)):
        chosen = kind == which
        colours[chosen, 1:] = middles[chosen, 1:] * random.uniform(least, most, (chosen.sum(), 1))
        colours[chosen, 1:] += random.normal(0, 3, (chosen.sum(), 2))
    triangles = random.normal(size=(count, 3, 3))
    triangles -= triangles.mean(axis=1, keepdims=True)
    triangles *= radius / np.linalg.norm(triangles, axis=2).max(axis=1)[:, None, None]
    return colours, triangles + middles[:, None]


@pytest.mark.slow
class TestBounds:
    """A bound that is too high seldom changes an answer, so it has tests of its own."""

    @pytest.mark.parametrize("radius", [0.3, 1.0, 4.0, 12.0, 30.0])
    def test_of_triangles_are_not_above_any_point(self, radius):
        colours, triangles = random_triangles(int(10 * radius), 6000, radius)
        colours[::10, 1:] = 0
        found = np.empty(3 * WIDTH)
        pairs = zip(colours, triangles, strict=True)
        bounds = np.array([triangle_bound(*pair, found) for pair in pairs])
        assert (bounds <= smallest_of_triangles(colours, triangles) + 1e-9).all()


def surface(level, count):
    """Return points of all faces, so dense that `count` are on an edge."""
    vertices, faces, _ = level
    steps = [(i, j, count - i - j) for i in range(count + 1) for j in range(count + 1 - i)]
    weights = np.array(steps) / count
    return np.einsum("sc,fcx->fsx", weights, np.asarray(vertices, float)[faces]).reshape(-1, 3)


def smallest(point, samples):
    """Return the smallest ΔE00 between a colour and samples."""
    return delta_e_2000(np.repeat([point], len(samples), axis=0), samples).min()


@pytest.mark.slow
class TestNearestCiede2000:
    @pytest.mark.parametrize(("count", "samples"), [(8, 40), (40, 20), (200, 9)])
    def test_is_not_above_any_point_of_the_surface(self, rough, count, samples):
        level = rough(31, count, 0.2)
        points = surface(level, samples)
        random = np.random.default_rng(0)
        colours = random.uniform((-40, -150, -150), (140, 150, 150), (60, 3))
        colours[:20, 1:] *= 0.05
        colours[:10, 1:] = 0
        colours[30:] = random.uniform((0, -110, -110), (110, 110, 110), (30, 3))
        found = nearest_ciede2000(colours, level)
        # where hues are opposite, the formula is not continuous
        along = (found.points[:, 1:] * colours[:, 1:]).sum(axis=1)
        tolerance = np.where(along >= 0, 1e-6, 0.1)
        assert (along >= 0).sum() > 35
        for row, colour in enumerate(colours):
            assert found.distance[row] <= smallest(colour, points) + tolerance[row]

    def test_of_large_faces_beside_the_neutral_axis(self):
        """Faces of coarse RGB gamuts reach from black to saturated colours."""
        hues = np.radians([25, 85, 140, 200, 290, 330])
        ring = np.stack([np.full(6, 55), 90 * np.cos(hues), 90 * np.sin(hues)], axis=1)
        vertices = np.concatenate([[(0, 0, 0), (100, 0, 0)], ring])
        sides = [(2 + at, 2 + (at + 1) % 6) for at in range(6)]
        faces = [(0, two, one) for one, two in sides] + [(1, one, two) for one, two in sides]
        level = vertices, faces, (50, 0, 0)
        random = np.random.default_rng(9)
        neutral = np.where(random.random(60) < 0.5, 0, 100) + random.normal(0, 4, 60)
        colours = np.stack([neutral, *random.normal(0, 4, (2, 60))], axis=1)
        found = nearest_ciede2000(colours, level)
        samples = surface(level, 60)
        along = (found.points[:, 1:] * colours[:, 1:]).sum(axis=1)
        tolerance = np.where(along >= 0, 1e-6, 0.1)
        smallest_of = np.array([smallest(colour, samples) for colour in colours])
        assert (found.distance <= smallest_of + tolerance).all()

    def test_fields_describe_one_point_of_the_surface(self, rough):
        vertices, faces, _ = level = rough(32, 200, 0.2)
        colours = np.random.default_rng(1).uniform((0, -110, -110), (110, 110, 110), (60, 3))
        found = nearest_ciede2000(colours, level)
        np.testing.assert_allclose(delta_e_2000(colours, found.points), found.distance, atol=1e-9)
        assert (found.weights >= 0).all()
        corners = vertices.astype(float)[faces[found.faces]]
        at = np.einsum("nc,ncx->nx", found.weights, corners)
        np.testing.assert_allclose(found.points, at, atol=1e-10)
        euclidean = nearest(colours, level)
        assert (found.distance <= delta_e_2000(colours, euclidean.points) + 1e-9).all()

    def test_no_point_nearby_is_better(self, rough):
        """The minimum in its face is exact to 1e-6."""
        vertices, faces, _ = level = rough(33, 60, 0.2)
        random = np.random.default_rng(2)
        colours = random.uniform((0, -110, -110), (110, 110, 110), (30, 3))
        found = nearest_ciede2000(colours, level)
        corners = vertices.astype(float)[faces[found.faces]]
        for size in (1e-1, 1e-2, 1e-3):
            for _ in range(50):
                other = found.weights + size * random.normal(size=found.weights.shape)
                other = np.maximum(other, 0)
                other /= other.sum(axis=1, keepdims=True)
                near = np.einsum("nc,ncx->nx", other, corners)
                assert (delta_e_2000(colours, near) >= found.distance - 1e-6).all()

    def test_order_of_the_rows_does_not_matter(self, rough):
        index = build_index(*rough(37, 200, 0.2))
        colours = np.random.default_rng(6).uniform((-40, -150, -150), (140, 150, 150), (200, 3))
        turned = nearest_ciede2000(colours[::-1], index).distance[::-1]
        distance = nearest_ciede2000(colours, index).distance
        assert (np.abs(distance - turned) < 1e-6).mean() > 0.95  # others have the opposite hue
        assert np.abs(distance - turned).max() < 0.1

    def test_of_colours_far_away_is_found_soon(self, rough):
        """The formula is nearly constant there."""
        level = rough(38, 100, 0.2)
        colours = np.random.default_rng(7).uniform((0, -80, -80), (100, 80, 80), (30, 3))
        for size in (1e3, 1e6, 1e40):
            found = nearest_ciede2000(size * colours, level)
            smallest_of = [smallest(size * colour, surface(level, 6)) for colour in colours]
            assert (found.distance <= 1.001 * np.array(smallest_of)).all()

    def test_gamuts_far_larger_than_those_of_colours(self, rough):
        """No face is left out when the number of divisions is used up."""
        vertices, faces, centre = rough(39, 100, 0.2)
        level = 1e6 * vertices.astype(float), faces, 1e6 * centre
        samples = surface(level, 12)
        colours = np.random.default_rng(8).uniform((-40, -90, -90), (140, 90, 90), (12, 3))
        colours = np.concatenate([1e6 * colours, colours])
        found = nearest_ciede2000(colours, level)
        smallest_of = np.array([smallest(colour, samples) for colour in colours])
        assert (found.distance <= 1.01 * smallest_of).all()
