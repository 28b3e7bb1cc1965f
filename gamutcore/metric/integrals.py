"""Integrals over triangles that are each seen through one face of another surface, many at a time.

They are closed forms with ten divisions and a case of their own for triangles that the face cuts,
which is half of them. Triangles are therefore put into a queue; when it is full the forms of both
cases are taken for all of its triangles, in a loop without branches that the compiler makes vector
instructions of, in a third of the time. Sums are taken in the order of the queue, so they are the
same to the bit as if each triangle were added when it is found.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.kernels import inlined_kernel, leaf_kernel
from gamutcore.metric.cones import INDEX

__all__ = ["CAPACITY", "Queue", "differences", "drained", "put", "put_three", "queue"]

CAPACITY = 256
"""Triangles in a queue: with their integrals 20 kB, which stay in the first cache."""

ONE, TWO, THREE, FOUR, FIVE, SIX = (INDEX(row * CAPACITY) for row in range(1, 7))
"""Where the rows of a queue begin, after the first."""


class Queue(NamedTuple):
    """Triangles, and room for their integrals.

    Attributes
    ----------
    triangle : (7 `CAPACITY`,) float64
        Seven rows: N · p − 1 at the three corners, the weights of the three integrals, and the
        length of N. Of three triangles that were put in together the weights are as `put_three`
        says, and the first one's length is negative.
    integral : (3 `CAPACITY`,) float64
        Three rows: what `differences` writes.
    """

    triangle: FloatArray
    integral: FloatArray


def queue() -> Queue:
    """Return an empty queue."""
    return Queue(np.zeros(7 * CAPACITY), np.zeros(3 * CAPACITY))


@inlined_kernel
def put(
    waiting: Queue,
    count: int,
    corners: tuple[float, float, float],
    weights: tuple[float, float, float],
    slope: float,
) -> int:
    """Put a triangle at the end of a queue of `count`; returns the new count.

    Parameters
    ----------
    waiting : Queue
    count : int
        Less than `CAPACITY`.
    corners : tuple of float
        N · p − 1 at the corners.
    weights : tuple of float
        What the three integrals are multiplied by, but for the slope.
    slope : float
        The length of N: the second integral is divided by it, the third one multiplied.
    """
    triangle, at = waiting.triangle, INDEX(count)
    triangle[at], triangle[at + ONE], triangle[at + TWO] = corners
    triangle[at + THREE], triangle[at + FOUR], triangle[at + FIVE] = weights
    triangle[at + SIX] = slope
    return count + 1


@inlined_kernel
def put_three(
    waiting: Queue,
    count: int,
    corners: tuple[float, float, float, float, float],
    shares: tuple[float, float, float],
    weights: tuple[float, float, float],
    slopes: tuple[float, float],
) -> int:
    """Put the three parts of a triangle that a single edge crosses at the end of a queue.

    Parameters
    ----------
    waiting : Queue
    count : int
        Less than `CAPACITY` − 2.
    corners : tuple of float
        N · p − 1 at the three corners, and where the edges from the second and from the first to
        the third corner are crossed.
    shares : tuple of float
        The parts' areas as shares of the triangle's: two parts before the edge, one beyond it.
    weights : tuple of float
        As for `put`, of the whole triangle.
    slopes : tuple of float
        Lengths of N before the edge and beyond it.
    """
    one, two, three, four, five = corners
    count = put(waiting, count, (one, two, four), (shares[0], weights[0], 0.0), -slopes[0])
    count = put(waiting, count, (one, four, five), (shares[1], weights[1], 0.0), slopes[0])
    return put(waiting, count, (four, three, five), (shares[2], weights[2], 0.0), slopes[1])


@leaf_kernel
def differences(waiting: Queue, count: int) -> None:
    """Write the integrals over the first triangles of a queue, each per volume below the triangle.

    With d = N · p − 1 at its corners and t = 1 ÷ (N · p), the other surface's part of the same
    cone has t₁ t₂ t₃ times the volume. The integrals are

    - the volume between the triangle and the face;
    - the mean of |d| over the triangle;
    - the mean of |t − 1| over the part of the face through which it is seen, times t₁ t₂ t₃.
    """
    triangle, integral = waiting.triangle, waiting.integral
    for index in range(count):
        at = INDEX(index)
        one, two, three = triangle[at], triangle[at + ONE], triangle[at + TWO]
        t1, t2, t3 = 1.0 + one, 1.0 + two, 1.0 + three
        product = 1.0 / (t1 * t2 * t3)
        t_sum = product * (t2 * t3 + t1 * t3 + t1 * t2)
        # turned so that the first corner is alone on its side of the face; the cut is where d = 0
        up1, up2, up3 = one >= 0.0, two >= 0.0, three >= 0.0
        third = up1 == up2
        second = (up1 == up3) & (not third)
        whole = third & (up2 == up3)
        a = three if third else (two if second else one)
        b = one if third else (three if second else two)
        c = two if third else (one if second else three)
        mean = (a + b + c) / 3.0
        part = a * a / ((a - b) * (a - c))
        t = 1.0 / (1.0 + a)
        volume_cut = part * (1.0 - t)
        mean_cut = part * a / 3.0
        a, b, c = a * t, b / (1.0 + b), c / (1.0 + c)
        back_cut = a * a * a / ((a - b) * (a - c) * 3.0)
        gap = abs(1.0 - product - volume_cut) + abs(volume_cut)
        here = abs(mean - mean_cut) + abs(mean_cut)
        back = product * (abs((a + b + c) / 3.0 - back_cut) + abs(back_cut))
        integral[at] = abs(1.0 - product) if whole else gap
        integral[at + ONE] = abs(one + two + three) / 3.0 if whole else here
        integral[at + TWO] = product * abs(t_sum - 3.0) / 3.0 if whole else back


@leaf_kernel
def drained(
    waiting: Queue, count: int, difference: float, first: float, second: float
) -> tuple[float, float, float]:
    """Return three sums with the weighted integrals over a queue's triangles added, in its order.

    Parameters
    ----------
    waiting : Queue
    count : int
        Triangles in it.
    difference, first, second : float
        The sums so far.
    """
    differences(waiting, count)
    triangle, integral = waiting.triangle, waiting.integral
    index = 0
    while index < count:
        at = INDEX(index)
        gap, mean, back = integral[at], integral[at + ONE], integral[at + TWO]
        one, two, three = triangle[at + THREE], triangle[at + FOUR], triangle[at + FIVE]
        slope = triangle[at + SIX]
        if slope >= 0.0:
            difference += one * gap
            first += two * mean / slope
            second += three * back * slope
            index += 1
            continue
        slope = -slope
        beside, last = INDEX(index + 1), INDEX(index + 2)
        share1, share2, share3 = one, triangle[beside + THREE], triangle[last + THREE]
        beyond = triangle[last + SIX]
        difference += two * (share1 * gap + share2 * integral[beside] + share3 * integral[last])
        first += triangle[beside + FOUR] * (
            (share1 * mean + share2 * integral[beside + ONE]) / slope
            + share3 * integral[last + ONE] / beyond
        )
        second += triangle[last + FOUR] * (
            (share1 * back + share2 * integral[beside + TWO]) * slope
            + share3 * integral[last + TWO] * beyond
        )
        index += 3
    return difference, first, second
