"""Integrals over triangles that are each seen through one face of another surface, in batches.

The integrals are closed forms with ten divisions, and with a special case for triangles that the
face cuts, which is half of them. Triangles are pushed to a queue. A full queue is integrated in one
loop without branches, which the compiler vectorises; that takes a third of the time. Sums are
formed in the order of the queue, so they do not depend on the batches.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.kernels import inlined_kernel, leaf_kernel
from gamutcore.metric.cones import INDEX

__all__ = ["CAPACITY", "Queue", "empty_queue", "flush", "integrate", "push", "push_three"]

CAPACITY = 256
"""Triangles in a queue. With their integrals they take 20 kB, which fit into the L1 cache."""

ONE, TWO, THREE, FOUR, FIVE, SIX = (INDEX(row * CAPACITY) for row in range(1, 7))
"""Begins of the rows of a queue, after the first."""


class Queue(NamedTuple):
    """A queue of triangles, and room for their integrals.

    Attributes
    ----------
    triangle : (7 `CAPACITY`,) float64
        Seven rows: N · p − 1 at the three corners, the weights of the three integrals, and the
        length of N. `push_three` uses the weights differently, and marks its first triangle by a
        negative length.
    integral : (3 `CAPACITY`,) float64
        Three rows of results of `integrate`.
    """

    triangle: FloatArray
    integral: FloatArray


def empty_queue() -> Queue:
    """Return an empty queue."""
    return Queue(np.zeros(7 * CAPACITY), np.zeros(3 * CAPACITY))


@inlined_kernel
def push(
    waiting: Queue,
    count: int,
    corners: tuple[float, float, float],
    weights: tuple[float, float, float],
    slope: float,
) -> int:
    """Push a triangle to a queue with `count` triangles; return the new count.

    Parameters
    ----------
    waiting : Queue
    count : int
        Less than `CAPACITY`.
    corners : tuple of float
        N · p − 1 at the corners.
    weights : tuple of float
        Factors of the three integrals.
    slope : float
        Length of N. The second integral is also divided by it, the third multiplied.
    """
    triangle, at = waiting.triangle, INDEX(count)
    triangle[at], triangle[at + ONE], triangle[at + TWO] = corners
    triangle[at + THREE], triangle[at + FOUR], triangle[at + FIVE] = weights
    triangle[at + SIX] = slope
    return count + 1


@inlined_kernel
def push_three(
    waiting: Queue,
    count: int,
    corners: tuple[float, float, float, float, float],
    shares: tuple[float, float, float],
    weights: tuple[float, float, float],
    slopes: tuple[float, float],
) -> int:
    """Push the three parts of a triangle that a single edge crosses; return the new count.

    Parameters
    ----------
    waiting : Queue
    count : int
        Less than `CAPACITY` − 2.
    corners : tuple of float
        N · p − 1 at the three corners, and at the crossings of the edges from the second and from
        the first corner to the third.
    shares : tuple of float
        Areas of the parts ÷ area of the triangle: two parts before the edge, one beyond it.
    weights : tuple of float
        As for `push`, for the whole triangle.
    slopes : tuple of float
        Lengths of N before the edge and beyond it.
    """
    one, two, three, four, five = corners
    count = push(waiting, count, (one, two, four), (shares[0], weights[0], 0.0), -slopes[0])
    count = push(waiting, count, (one, four, five), (shares[1], weights[1], 0.0), slopes[0])
    return push(waiting, count, (four, three, five), (shares[2], weights[2], 0.0), slopes[1])


@leaf_kernel
def integrate(waiting: Queue, count: int) -> None:
    """Compute the integrals of triangles of a queue, each ÷ volume between triangle and centre.

    With d = N · p − 1 at its corners and t = 1 ÷ (N · p), the other surface's part of the same
    cone has t₁ t₂ t₃ times the volume. The integrals are

    - the volume between the triangle and the face;
    - the mean of |d| over the triangle;
    - the mean of |t − 1| over the part of the face that the triangle is seen through, times
      t₁ t₂ t₃.
    """
    triangle, integral = waiting.triangle, waiting.integral
    for index in range(count):
        at = INDEX(index)
        one, two, three = triangle[at], triangle[at + ONE], triangle[at + TWO]
        t1, t2, t3 = 1.0 + one, 1.0 + two, 1.0 + three
        product = 1.0 / (t1 * t2 * t3)
        t_sum = product * (t2 * t3 + t1 * t3 + t1 * t2)
        # rotate the corners so that the first is alone on its side of the face; d = 0 on the cut
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
def flush(
    waiting: Queue, count: int, difference: float, first: float, second: float
) -> tuple[float, float, float]:
    """Integrate the triangles of a queue, and return three sums with the results added.

    Parameters
    ----------
    waiting : Queue
    count : int
        Number of triangles.
    difference, first, second : float
        The sums so far.
    """
    integrate(waiting, count)
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
