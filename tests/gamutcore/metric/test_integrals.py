"""Integrals over triangles, against sums over many small ones, and the order of a queue's sums."""

import numpy as np
import pytest

from gamutcore.metric.integrals import CAPACITY, empty_queue, flush, integrate, push, push_three


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
        push(waiting, number, corners, (1.0, 1.0, 1.0), 1.0)
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


class TestDrained:
    def test_adds_weighted_integrals(self):
        """The first weight times the gap, the second ÷ slope, the third × slope."""
        corners = [(0.1, 0.2, 0.3), (-0.1, 0.2, 0.3)]
        (gap1, mean1, back1), (gap2, mean2, back2) = integrals_of(corners)
        waiting = empty_queue()
        count = push(waiting, 0, corners[0], (2.0, 3.0, 5.0), 4.0)
        count = push(waiting, count, corners[1], (7.0, 11.0, 13.0), 0.5)
        assert count == 2
        found = flush(waiting, count, 1.0, 10.0, 100.0)
        expected = (
            1 + 2 * gap1 + 7 * gap2,
            10 + 3 * mean1 / 4 + 11 * mean2 / 0.5,
            100 + 5 * back1 * 4 + 13 * back2 * 0.5,
        )
        assert found == pytest.approx(expected, rel=1e-12)

    def test_of_three_is_that_of_the_parts_one_by_one(self):
        one, two, three, four, five = 0.2, -0.1, 0.3, 0.05, 0.1
        shares, weights, slopes = (0.2, 0.3, 0.5), (2.0, 3.0, 5.0), (4.0, 0.5)
        waiting = empty_queue()
        count = push_three(waiting, 0, (one, two, three, four, five), shares, weights, slopes)
        assert count == 3
        found = flush(waiting, count, 0.0, 0.0, 0.0)
        parts = empty_queue()
        for number, corners in enumerate(
            ((one, two, four), (one, four, five), (four, three, five))
        ):
            share, slope = shares[number], slopes[number // 2]
            push(parts, number, corners, tuple(share * weight for weight in weights), slope)
        assert found == pytest.approx(flush(parts, 3, 0.0, 0.0, 0.0), rel=1e-12)

    def test_of_an_empty_queue_adds_nothing(self):
        assert flush(empty_queue(), 0, 1.0, 2.0, 3.0) == (1.0, 2.0, 3.0)
