"""Orders: by group, along Hilbert curves in space and on the sphere of directions, and at random.

The curve is that of Hilbert, "Ueber die stetige Abbildung einer Linie auf ein Flächenstück" (1891).
For directions, the sphere is unfolded into a square by way of an octahedron. Points that follow
each other along a curve are near, so a search may start where the last one ended.

Random numbers are hashes of whole numbers, so they are the same in every run.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.geometry.vectors import row
from gamutcore.kernels import kernel, leaf_kernel

__all__ = [
    "GOLDEN",
    "curve_order",
    "curve_positions",
    "grouped",
    "insertion_order",
    "mixed_bits",
]

SPHERE_BITS = 15
"""Steps along an axis of the square are 2 to this power. The curve has 4¹⁵ = 10⁹ cells, a thousand
for each of a million points."""

SPACE_BITS = 10
"""Steps along an axis of the bounding box are 2 to this power."""

DIGIT = 11
"""Bits per pass of the sort."""

ROUND_BITS = 2
"""Each round has 2² times the points of the round before. The hull of 10⁶ points took 0.63, 0.51
and 0.57 s with 1, 2 and 3 bits."""

LAST_ROUND = 15
"""Rounds before the last one; with 4¹⁵ points, the first round has one point."""

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
"""2⁶⁴ ÷ the golden ratio, the increment of SplitMix64."""


@kernel
def grouped(group: IndexArray, groups: int) -> tuple[IndexArray, IndexArray]:
    """Return the items of each group, as start (groups + 1,) and items (n,), ascending in a group.

    `group` (n,) has the group of each item. The items of group g are
    ``items[start[g]:start[g + 1]]``.
    """
    start, items = np.zeros(groups + 2, np.int32), np.empty(len(group), np.int32)
    for item in range(len(group)):  # one place further for the next loop
        start[group[item] + 2] += 1
    for each in range(2, groups + 2):
        start[each] += start[each - 1]
    for item in range(len(group)):
        free = group[item] + 1
        items[start[free]] = item
        start[free] += 1
    return start[:-1].copy(), items


@kernel
def curve_positions(relative: FloatArray) -> LongArray:
    """Return the positions of directions (n, 3), 0 to 4¹⁵ − 1, along the curve on the sphere."""
    position, cell = np.empty(len(relative), np.int64), np.empty(2, np.int64)
    half = 0.5 * (2**SPHERE_BITS - 1)
    for index in range(len(relative)):
        x, y, z = row(relative, index, 0)
        total = abs(x) + abs(y) + abs(z)
        u, v = (x / total, y / total) if total > 0.0 else (0.0, 0.0)
        if z < 0.0:  # fold the corners of the lower half outwards
            u, v = (
                (1.0 - abs(v)) * (1.0 if u >= 0.0 else -1.0),
                (1.0 - abs(u)) * (1.0 if v >= 0.0 else -1.0),
            )
        cell[0], cell[1] = int((u + 1.0) * half), int((v + 1.0) * half)
        position[index] = _hilbert_position(cell, SPHERE_BITS)
    return position


@kernel
def curve_order(points: FloatArray) -> IndexArray:
    """Return the order of points (n, 3) along a curve through their bounding box.

    Points in one cell of the curve keep their order.
    """
    count = len(points)
    low, scale = np.empty(3), np.empty(3)
    for axis in range(3):
        least, most = np.inf, -np.inf
        for index in range(count):
            least, most = min(least, points[index, axis]), max(most, points[index, axis])
        low[axis] = least
        scale[axis] = 2.0**SPACE_BITS / (most - least) if most > least else 0.0
    position, cell = np.empty(count, np.int64), np.empty(3, np.int64)
    for index in range(count):
        for axis in range(3):
            step = int((points[index, axis] - low[axis]) * scale[axis])
            cell[axis] = min(step, (1 << SPACE_BITS) - 1)
        position[index] = _hilbert_position(cell, SPACE_BITS)
    order, digit = np.arange(count).astype(np.int32), np.empty(count, np.int32)
    for shift in range(0, 3 * SPACE_BITS, DIGIT):
        for place in range(count):
            digit[place] = (position[order[place]] >> shift) & ((1 << DIGIT) - 1)
        order = order[grouped(digit, 1 << DIGIT)[1]]
    return order


@leaf_kernel
def _hilbert_position(cell: LongArray, bits: int) -> int:
    """Return the position along the curve of a cell (d,), and overwrite the cell.

    The curve has d · `bits` bits. Source: Skilling, "Programming the Hilbert curve" (2004).
    """
    bit = 1 << (bits - 1)
    while bit > 1:
        for axis in range(len(cell)):
            if cell[axis] & bit:
                cell[0] ^= bit - 1
            else:
                swapped = (cell[0] ^ cell[axis]) & (bit - 1)
                cell[0] ^= swapped
                cell[axis] ^= swapped
        bit >>= 1
    for axis in range(1, len(cell)):
        cell[axis] ^= cell[axis - 1]
    turned, position = 0, 0
    for level in range(bits - 1, 0, -1):
        if cell[-1] >> level & 1:
            turned ^= (1 << level) - 1
    for level in range(bits - 1, -1, -1):
        for axis in range(len(cell)):
            position = 2 * position + ((cell[axis] ^ turned) >> level & 1)
    return position


def insertion_order(positions: LongArray) -> LongArray:
    """Return the order of points by rounds of growing size, and along the curve within a round.

    `positions` (n,) are those of `curve_positions`. Points are chosen for the rounds at random, as
    a hash of their number. The order of two points does not depend on the other points.
    """
    bits = mixed_bits(np.arange(1, len(positions) + 1, dtype=np.uint64) * GOLDEN)
    lowest_bit = bits & (~bits + np.uint64(1))
    trailing_zeros = np.frexp(lowest_bit.astype(np.float64))[1] - 1  # exact for a power of two
    # three quarters of the points are in the last round, a fifth in the round before it
    rounds = np.maximum(LAST_ROUND - trailing_zeros.astype(np.int64) // ROUND_BITS, 0)
    keys = rounds << 2 * SPHERE_BITS | positions
    return np.argsort(keys, kind="stable").astype(np.int64, copy=False)


def mixed_bits(numbers: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return the hashes of numbers: the output function of SplitMix64.

    Source: Steele, Lea & Flood, "Fast Splittable Pseudorandom Number Generators" (2014).
    """
    bits = (numbers ^ (numbers >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return bits ^ (bits >> np.uint64(31))
