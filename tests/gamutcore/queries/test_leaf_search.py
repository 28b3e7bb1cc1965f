"""The nearest point in a plane of constant hue, compared with all faces and with a sphere."""

import numpy as np
import pytest

from gamutcore.queries import build_index
from gamutcore.queries.face_tree import STACK, WIDTH
from gamutcore.queries.leaf_search import nearest_of_hue


def search(index, lightness, chroma, hue):
    """Return face, lightness and chroma of the nearest point, and the weights in its face."""
    weights = np.empty(3)
    work = np.empty(STACK, np.int64), np.empty(STACK), np.empty(WIDTH), weights
    direction = float(np.cos(hue)), float(np.sin(hue))
    return *nearest_of_hue(lightness, chroma, *direction, index, *work), weights


def smallest_distance(index, lightness, chroma, hue):
    """Return the distance to the nearest of all segments in which faces meet the half-plane."""
    across, along = np.array([-np.sin(hue), np.cos(hue)]), np.array([np.cos(hue), np.sin(hue)])
    best = np.inf
    for corners in index.vertices[index.faces]:
        heights = corners[:, 1:] @ across
        ends = []
        for one, two in ((0, 1), (1, 2), (2, 0)):
            if heights[one] * heights[two] < 0:
                share = heights[one] / (heights[one] - heights[two])
                point = corners[one] + share * (corners[two] - corners[one])
                ends.append((point[0], point[1:] @ along))
        if len(ends) < 2:
            continue
        (l1, c1), (l2, c2) = ends
        if c1 < 0 or c2 < 0:  # leave the half-plane at the axis
            if c1 < 0 and c2 < 0:
                continue
            axis = (l1 + (l2 - l1) * c1 / (c1 - c2), 0.0)
            (l1, c1), (l2, c2) = (axis, (l2, c2)) if c1 < 0 else ((l1, c1), axis)
        segment = np.array([l2 - l1, c2 - c1])
        start = np.array([lightness - l1, chroma - c1])
        share = np.clip(start @ segment / max(segment @ segment, 1e-300), 0, 1)
        best = min(best, float(np.linalg.norm(start - share * segment)))
    return best


class TestNearestOfHue:
    @pytest.mark.parametrize("count", [8, 60, 400])
    def test_is_the_nearest_of_all_segments(self, rough, count):
        index = build_index(*rough(count, count, 0.5))
        random = np.random.default_rng(count)
        for _ in range(60):
            lightness, chroma = random.uniform(-20, 120), random.uniform(0, 90)
            hue = random.uniform(-np.pi, np.pi)
            face, found, found_chroma, weights = search(index, lightness, chroma, hue)
            distance = np.hypot(found - lightness, found_chroma - chroma)
            expected = smallest_distance(index, lightness, chroma, hue)
            np.testing.assert_allclose(distance, expected, rtol=1e-9, atol=1e-9)
            point = weights @ index.vertices[index.faces[face]]
            made = found, found_chroma * np.cos(hue), found_chroma * np.sin(hue)
            np.testing.assert_allclose(point, made, atol=1e-9)

    def test_no_face_is_found_where_the_half_plane_misses_the_level(self, cube):
        vertices, faces, _ = cube
        shifted = vertices + np.array([0, 5, 0], np.float32)
        index = build_index(shifted, faces, np.array([0.0, 5.0, 0.0]))
        assert search(index, 0.0, 5.0, np.pi)[0] == -1
        face, lightness, chroma, _ = search(index, 0.5, 20.0, 0.0)
        assert face >= 0
        assert (lightness, chroma) == pytest.approx((0.5, 6.0))
