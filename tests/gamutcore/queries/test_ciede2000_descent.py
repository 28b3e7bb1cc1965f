"""Descent in a triangle finds what dense samples of the triangle find."""

import numpy as np
import pytest

from gamutcore.queries.ciede2000_descent import Work, descend, has_one_minimum
from gamutcore.queries.ciede2000_slope import SLOPE, set_slope
from gamutcore.queries.colour_difference import delta_e_2000

STEPS = np.array([(i, j) for i in range(13) for j in range(13 - i)]) / 12


def work_arrays():
    sizes = (4, 9, SLOPE, 3, 72, 24, 64, 88, 1, (1, 3), (1, 6), (8, 3))
    arrays = [np.empty(size) for size in sizes]
    arrays[8] = np.empty(1, np.int64)
    return Work(*arrays)


class TestDescend:
    @pytest.mark.parametrize("radius", [1.0, 4.0, 12.0])
    def test_finds_the_smallest_difference_of_a_triangle(self, radius):
        random = np.random.default_rng(8)
        work = work_arrays()
        single = 0
        for _ in range(1500):
            middle = random.uniform((0, -100, -100), (100, 100, 100))
            colour = middle + random.choice([3, 6, 10, 20]) * random.normal(size=3)
            triangle = random.normal(size=(3, 3))
            triangle -= triangle.mean(axis=0)
            triangle *= radius / np.linalg.norm(triangle, axis=1).max()
            triangle += middle
            sides = np.concatenate([triangle[0], triangle[1:].ravel() - np.tile(triangle[0], 2)])
            work.colour[:] = np.append(colour, np.hypot(*colour[1:]))
            work.corners[:] = sides
            work.best[:] = set_slope(work.colour, *middle, work.slope), 1 / 3, 1 / 3
            descend(work, 0.0, 0.0, 1.0)
            value, u, v = work.best
            if not has_one_minimum(work.colour, *middle[1:], radius, value):
                continue
            single += 1
            assert u >= 0
            assert v >= 0
            assert u + v <= 1 + 1e-12
            samples = sides[:3] + STEPS[:, :1] * sides[3:6] + STEPS[:, 1:] * sides[6:]
            everywhere = delta_e_2000(np.repeat([colour], len(samples), axis=0), samples)
            assert value <= everywhere.min() + 1e-6
        assert single > 1000
