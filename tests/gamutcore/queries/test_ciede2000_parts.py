"""The bounds of parts: on random triangles other than those of the measurement, and on levels."""

import numpy as np
import pytest

from gamutcore.queries import build_index
from gamutcore.queries.ciede2000_parts import (
    BOUND,
    ESTIMATE,
    MIDDLE,
    set_node_bounds,
    set_triangle_bounds,
)
from gamutcore.queries.colour_difference import delta_e_2000
from gamutcore.queries.face_tree import WIDTH

WORK = np.empty(8 * WIDTH), np.empty(11 * WIDTH)

STEPS = np.array([(i, j, 6 - i - j) for i in range(7) for j in range(7 - i)]) / 6


def smallest(colours, triangles):
    """Return the smallest ΔE00 to samples of each triangle, and that to its centroid."""
    samples = np.einsum("sc,ncx->snx", STEPS, triangles)
    found = np.array([delta_e_2000(colours, each) for each in samples])
    return found.min(axis=0), delta_e_2000(colours, triangles.mean(axis=1))


def triangle_bounds(colours, triangles):
    """Return what is known of triangles, in ΔE00."""
    known = np.empty((3, len(triangles)))
    found = np.empty(3 * WIDTH)
    for row, (colour, triangle) in enumerate(zip(colours, triangles, strict=True)):
        corners = np.repeat(triangle.reshape(9, 1), WIDTH, axis=1).ravel()
        set_triangle_bounds(np.append(colour, np.hypot(*colour[1:])), corners, found, *WORK)
        known[:, row] = found[::WIDTH]
    return np.sqrt(2 * np.maximum(known, 0))


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


class TestTriangles:
    @pytest.mark.parametrize("radius", [0.3, 1.0, 4.0, 12.0, 30.0])
    def test_bounds_are_not_above_any_point(self, radius):
        colours, triangles = random_triangles(int(10 * radius), 12_000, radius)
        bounds = triangle_bounds(colours, triangles)[BOUND]
        least, _ = smallest(colours, triangles)
        assert (bounds <= least + 1e-9).all()

    def test_bounds_are_near_the_minimum_of_small_triangles(self):
        colours, triangles = random_triangles(9, 4000, 1.0)
        known = triangle_bounds(colours, triangles)
        least, middle = smallest(colours, triangles)
        same_side = (colours[:, None, 1:] * triangles[:, :, 1:]).sum(axis=2).min(axis=1) > 0
        colourful = np.hypot(*triangles.mean(axis=1)[:, 1:].T) > 10
        np.testing.assert_allclose(known[MIDDLE][same_side], middle[same_side], rtol=2e-5)
        kept = same_side & colourful & (least > 1)
        assert kept.sum() > 800
        assert np.median((least - known[BOUND])[kept]) < 0.01
        assert np.quantile((least - known[BOUND])[kept], 0.9) < 0.1
        assert np.median(np.abs(least - known[ESTIMATE])[kept]) < 0.01

    def test_neutral_colours(self):
        _, triangles = random_triangles(10, 3000, 3.0)
        colours = np.column_stack(
            [np.random.default_rng(1).uniform(-20, 120, 3000)] + [np.zeros(3000)] * 2
        )
        bounds = triangle_bounds(colours, triangles)[BOUND]
        least, _ = smallest(colours, triangles)
        assert (bounds <= least + 1e-9).all()
        colourful = np.hypot(*triangles.mean(axis=1)[:, 1:].T) > 10
        assert np.median((least - bounds)[colourful]) < 0.1


class TestNodes:
    def test_bounds_are_not_above_any_face_below(self, rough):
        index = build_index(*rough(7, 300, 0.3))
        tree = index.tree
        triangles = index.vertices[index.faces]
        random = np.random.default_rng(7)
        found = np.empty(3 * WIDTH)
        tight = 0
        for colour in random.uniform((-40, -150, -150), (140, 150, 150), (12, 3)):
            least, _ = smallest(np.repeat([colour], len(triangles), axis=0), triangles)
            for node in range(len(tree.first)):
                set_node_bounds(
                    np.append(colour, np.hypot(*colour[1:])), index.centre, tree, node, found, *WORK
                )
                for child in range(WIDTH):
                    held = faces_below(tree, node, child)
                    assert np.isfinite(found[MIDDLE * WIDTH + child]) == (len(held) > 0)
                    if held:
                        bound = np.sqrt(2 * max(found[BOUND * WIDTH + child], 0))
                        assert bound <= least[held].min() + 1e-9
                        tight += bound > 0.8 * least[held].min()
        assert tight > 1000


def faces_below(tree, node, child):
    """Return the faces of a child of a node."""
    if tree.cylinders[node, 6 * WIDTH + child] < 0:
        return []
    first = tree.first[node]
    if first < 0:
        return [tree.faces[~first + child]]
    row = first + child
    return [face for each in range(WIDTH) for face in faces_below(tree, row, each)]
