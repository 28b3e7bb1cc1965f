"""An order of points along a Hilbert curve, so that neighbours in the order are near in space.

Source: J. Skilling, "Programming the Hilbert curve", AIP Conference Proceedings 707 (2004).
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["curve_order"]

BITS = 10
"""Steps of the curve along an axis are 2 to this power."""

DIGIT = 11
"""Bits per pass of the sort."""


@leaf_kernel
def curve_position(x: int, y: int, z: int) -> int:
    """Return the position, 0 to 2³⁰ − 1, of a cell (0 to 2¹⁰ − 1 each) along the curve."""
    bit = 1 << (BITS - 1)
    while bit > 1:
        low = bit - 1
        if x & bit:
            x ^= low
        if y & bit:
            x ^= low
        else:
            swapped = (x ^ y) & low
            x ^= swapped
            y ^= swapped
        if z & bit:
            x ^= low
        else:
            swapped = (x ^ z) & low
            x ^= swapped
            z ^= swapped
        bit >>= 1
    y ^= x
    z ^= y
    turned = 0
    bit = 1 << (BITS - 1)
    while bit > 1:
        if z & bit:
            turned ^= bit - 1
        bit >>= 1
    return (_spread(x ^ turned) << 2) | (_spread(y ^ turned) << 1) | _spread(z ^ turned)


@leaf_kernel
def _spread(value: int) -> int:
    """Return a number of 10 bits with two zeros between neighbouring bits."""
    value = (value | (value << 16)) & 0x030000FF
    value = (value | (value << 8)) & 0x0300F00F
    value = (value | (value << 4)) & 0x030C30C3
    return (value | (value << 2)) & 0x09249249


@kernel
def curve_order(points: FloatArray) -> IndexArray:
    """Return the order of points along a Hilbert curve through their bounding box.

    Points in one cell of the curve keep their order.
    """
    count = len(points)
    order = np.empty(count, np.int32)
    low, scale = np.empty(3), np.empty(3)
    for axis in range(3):
        least, most = np.inf, -np.inf
        for row in range(count):
            least, most = min(least, points[row, axis]), max(most, points[row, axis])
        low[axis] = least
        scale[axis] = 2.0**BITS / (most - least) if most > least else 0.0
    position = np.empty(count, np.uint32)
    last = (1 << BITS) - 1
    for row in range(count):
        position[row] = curve_position(
            min(int((points[row, 0] - low[0]) * scale[0]), last),
            min(int((points[row, 1] - low[1]) * scale[1]), last),
            min(int((points[row, 2] - low[2]) * scale[2]), last),
        )
        order[row] = row
    # sort by digits, stable
    other = np.empty(count, np.int32)
    size = 1 << DIGIT
    shift = 0
    while shift < 3 * BITS:
        place = np.zeros(size + 1, np.int32)
        for row in range(count):
            place[((position[row] >> shift) & (size - 1)) + 1] += 1
        for digit in range(size):
            place[digit + 1] += place[digit]
        for index in range(count):
            row = order[index]
            digit = (position[row] >> shift) & (size - 1)
            other[place[digit]] = row
            place[digit] += 1
        order, other = other, order
        shift += DIGIT
    return order
