"""The measured bounds, on random colours other than those of the measurement."""

import numpy as np
import pytest

from gamutcore.queries import build_index
from gamutcore.queries.ciede2000_metric import (
    curvature,
    least_chroma,
    metric_bound,
    metric_slack,
    set_metric,
    set_metric_bounds,
    tangent_curvature,
)
from gamutcore.queries.ciede2000_slope import SLOPE, set_slope
from gamutcore.queries.colour_difference import delta_e_2000
from gamutcore.queries.face_tree import WIDTH


def quadratic(metric, offset):
    """Return the quadratic form of offsets."""
    x, y, z = offset.T
    return metric[0] * x * x + metric[1] * y * y + 2 * metric[2] * y * z + metric[3] * z * z


class TestCurvature:
    @pytest.mark.parametrize("radius", [0.5, 3.0, 12.0])
    def test_bounds_are_never_above_a_colour_of_the_ball(self, radius):
        random = np.random.default_rng(5)
        count = 3000
        middles = random.uniform((0, -100, -100), (100, 100, 100), (count, 3))
        spread = random.choice([3, 10, 25, 60], (count, 1))
        colours = middles + spread * random.normal(size=(count, 3))
        slope, metric = np.empty(SLOPE), np.empty(7)
        valid = 0
        for colour, middle in zip(colours, middles, strict=True):
            state = np.append(colour, np.hypot(*colour[1:]))
            chroma = least_chroma(state, *middle[1:], radius)
            value = set_slope(state, *middle, slope)
            if not chroma or value > 64:
                continue
            valid += 1
            offset = random.normal(size=(30, 3))
            offset *= radius / np.linalg.norm(offset, axis=1, keepdims=True)
            actual = delta_e_2000(np.repeat([colour], 30, axis=0), middle + offset)
            least = set_metric(slope, *middle, metric)
            square = least + quadratic(metric, middle + offset - metric[4:])
            error = curvature(state, value, chroma, *middle[1:]) * radius**2
            assert (np.sqrt(np.maximum(square, 0)) - error <= actual + 1e-9).all()
            linear = value + offset @ slope[:3] / value
            error = tangent_curvature(state, value, chroma, *middle[1:]) * radius**2
            assert (linear - error <= actual + 1e-9).all()
        assert valid > 1500


class TestMetric:
    def test_bound_by_the_distance_in_the_metric(self):
        random = np.random.default_rng(6)
        colours = random.uniform((-10, -120, -120), (110, 120, 120), (1000, 3))
        colours[::5, 1:] *= 0.1
        slope, metric = np.empty(SLOPE), np.empty(7)
        checked = 0
        for colour in colours:
            state = np.append(colour, np.hypot(*colour[1:]))
            set_slope(state, colour[0], colour[1] + 1e-3, colour[2], slope)
            set_metric(slope, *colour, metric)
            slack, growth, near = metric_slack(state)
            offset = random.normal(size=(200, 3))
            offset *= random.uniform(0.1, 60, (200, 1))
            offset /= np.linalg.norm(offset, axis=1, keepdims=True) / random.choice(
                [1, 4, 12, 30], (200, 1)
            )
            actual = delta_e_2000(np.repeat([colour], 200, axis=0), colour + offset)
            away = np.sqrt(quadratic(metric, offset))
            bounds = np.array([metric_bound(each, slack, growth) for each in away])
            # near the neutral axis the metric is that of a step of 0.001
            assert (np.minimum(bounds, near) <= actual * (1 + 1e-4)).all()
            checked += (actual < near).sum()
        assert checked > 50_000

    def test_distances_to_cylinders_are_not_above_those_to_their_faces(self, rough):
        vertices, faces, centre = rough(7, 300, 0.3)
        index = build_index(vertices, faces, centre)
        tree = index.tree
        random = np.random.default_rng(7)
        squares = np.empty(WIDTH)
        for _ in range(4):
            factor = random.normal(size=(2, 2))
            block = factor @ factor.T + 0.05 * np.eye(2)
            at = random.uniform(-100, 100, 3)
            metric = np.array([random.uniform(0.1, 2), block[0, 0], block[0, 1], block[1, 1], *at])
            for node in range(len(tree.first)):
                set_metric_bounds(metric, index.centre, tree, node, squares)
                for child in np.flatnonzero(np.isfinite(squares)):
                    held = faces_below(tree, node, child)
                    corners = index.vertices[index.faces[held]].reshape(-1, 3)
                    middles = index.vertices[index.faces[held]].mean(axis=1)
                    least = quadratic(metric, np.vstack([corners, middles]) - at).min()
                    assert squares[child] / tree.scale**2 <= least * (1 + 1e-9)


def faces_below(tree, node, child):
    """Return the faces of a child of a node."""
    first = tree.first[node]
    if first < 0:
        return [tree.faces[~first + child]]
    row = first + child
    children = np.flatnonzero(tree.cylinders[row, 6 * WIDTH : 7 * WIDTH] >= 0)
    return [face for each in children for face in faces_below(tree, row, each)]
