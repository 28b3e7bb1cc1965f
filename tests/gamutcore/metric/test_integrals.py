"""Integrals over triangles, against sums over many small ones, and the order of a queue's sums."""

import numpy as np
import pytest

from gamutcore.metric.integrals import CAPACITY, empty_queue, flush, integrate, push, push_part


def by_subdivision(corners, parts=400):
    """The three integrals from the middles of small triangles, N · p being linear on the whole.

    At N · p = 1 ÷ t the other surface is t times as far away: volumes and areas are t³ times those
    at the triangle, the heights of all cones over one plane being the same.
    """
    steps = np.arange(parts)
    u, v = (grid.ravel() for grid in np.meshgrid(steps, steps))
    inside = u + v < parts
    first = np.stack([u, v], axis=1)[inside] + 1 / 3
    second = np.stack([u, v], axis=1)[u + v < parts - 1] + 2 / 3
    middles = np.vstack([first, second]) / parts
    one, two, three = corners
    d = one + middles @ (two - one, three - one)
    t = 1 / (1 + d)
    return abs(1 - t**3).mean(), abs(d).mean(), (t**3 * abs(t - 1)).mean()


def integrals_of(triangles):
    waiting = empty_queue()
    for number, corners in enumerate(triangles):
        push(waiting, number, 0, corners, (1.0, 1.0, 1.0), 1.0)
    integrate(waiting, len(triangles))
    return waiting.integral.reshape(3, CAPACITY)[:, : len(triangles)].T


class TestDifferences:
    @pytest.mark.parametrize("size", [1e-3, 0.05, 0.5])
    @pytest.mark.parametrize("signs", [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)])
    def test_are_those_of_many_small_triangles(self, size, signs):
        corners = size * np.array(signs) * (0.4, 1.0, 0.7)
        for turned in (corners, -corners):
            (found,) = integrals_of([tuple(turned)])
            # 160,000 small triangles, of 1 ÷ 400 of the length: errors of the order of the square
            np.testing.assert_allclose(found, by_subdivision(turned), rtol=1e-4)

    def test_do_not_depend_on_which_corner_is_the_first(self):
        random = np.random.default_rng(2)
        corners = random.uniform(-0.3, 0.5, (60, 3))
        expected = integrals_of([tuple(row) for row in corners])
        for turn in (1, 2):
            found = integrals_of([tuple(row) for row in np.roll(corners, turn, axis=1)])
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-14)

    def test_of_a_triangle_on_the_face_are_nothing(self):
        np.testing.assert_array_equal(integrals_of([(0.0, 0.0, 0.0)]), [[0.0, 0.0, 0.0]])

    def test_have_closed_forms_between_similar_triangles(self):
        """Parallel to the face at N · p = 1 + d: t = 1 ÷ (1 + d) everywhere."""
        for d in (-0.5, 0.25, 3.0):
            t = 1 / (1 + d)
            ((gap, mean, back),) = integrals_of([(d, d, d)])
            assert gap == pytest.approx(abs(1 - t**3))
            assert mean == pytest.approx(abs(d))
            assert back == pytest.approx(t**3 * abs(t - 1))


class TestFlush:
    def test_adds_weighted_integrals(self):
        """The first weight times the gap, the second ÷ slope, the third × slope."""
        corners = [(0.1, 0.2, 0.3), (-0.1, 0.2, 0.3), (0.2, 0.2, -0.3)]
        (gap1, mean1, back1), (gap2, mean2, back2), (gap3, mean3, back3) = integrals_of(corners)
        waiting, sums = empty_queue(), np.array([[1.0, 10.0, 100.0], [0.0, 0.0, 0.0]])
        count = push(waiting, 0, 0, corners[0], (2.0, 3.0, 5.0), 4.0)
        count = push(waiting, count, 1, corners[1], (7.0, 11.0, 13.0), 0.5)
        count = push_part(waiting, count, 0, corners[2], 0.25, (4.0, 8.0, 12.0), 2.0)
        assert count == 3
        flush(waiting, count, sums)
        first = (
            1 + 2 * gap1 + gap3,
            10 + 3 * mean1 / 4 + 2 * mean3 / 2,
            100 + 5 * back1 * 4 + 3 * back3 * 2,
        )
        second = (7 * gap2, 11 * mean2 / 0.5, 13 * back2 * 0.5)
        np.testing.assert_allclose(sums, [first, second], rtol=1e-12)

    def test_of_an_empty_queue_adds_nothing(self):
        sums = np.ones((2, 3))
        flush(empty_queue(), 0, sums)
        np.testing.assert_array_equal(sums, 1.0)
