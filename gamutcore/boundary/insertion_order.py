"""The order in which points are inserted into a hull: near in direction, near in time.

Directions are sorted along a Hilbert curve on the sphere. The face of each point is then a few
steps from the face of the point before. The points are inserted in rounds of growing size, chosen
at random, so a coarse hull exists before the fine one is begun. No order of the input makes the
work quadratic (Amenta, Choi & Rote, "Incremental Constructions con BRIO", 2003). The random choice
is a hash of the point's number, so the order is the same in every run.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, LongArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["curve_positions", "insertion_order"]

CURVE_BITS = 15
"""Levels of the curve. It has 4¹⁵ = 10⁹ cells, a thousand for each of a million points."""

ROUND_BITS = 2
"""Each round has 2² times the points of the round before. The hull of 10⁶ points took 0.63, 0.51
and 0.57 s with 1, 2 and 3 bits."""

LAST_ROUND = 15
"""Rounds before the last one; with 4¹⁵ points, the first round has one point."""


@kernel
def curve_positions(relative: FloatArray) -> LongArray:
    """Return the positions of directions, 0 to 4¹⁵ − 1, along a Hilbert curve on the sphere.

    The sphere is unfolded into a square by way of an octahedron. The curve is that of Hilbert,
    "Ueber die stetige Abbildung einer Linie auf ein Flächenstück" (1891).
    """
    position = np.empty(len(relative), np.int64)
    half = 0.5 * (2**CURVE_BITS - 1)
    for index in range(len(relative)):
        x, y, z = relative[index, 0], relative[index, 1], relative[index, 2]
        total = abs(x) + abs(y) + abs(z)
        u, v = (x / total, y / total) if total > 0.0 else (0.0, 0.0)
        if z < 0.0:  # fold the corners of the lower half outwards
            u, v = (
                (1.0 - abs(v)) * (1.0 if u >= 0.0 else -1.0),
                (1.0 - abs(u)) * (1.0 if v >= 0.0 else -1.0),
            )
        position[index] = _hilbert_position(int((u + 1.0) * half), int((v + 1.0) * half))
    return position


@leaf_kernel
def _hilbert_position(column: int, row: int) -> int:
    """Position of a cell of the square along the curve: two bits for each level."""
    position = 0
    for level in range(CURVE_BITS - 1, -1, -1):
        right, upper = column >> level & 1, row >> level & 1
        position = 4 * position + (3 * right ^ upper)
        if not upper:
            if right:
                column, row = ~column, ~row
            column, row = row, column
    return position


def _rounds(count: int) -> LongArray:
    """Random round of each point: three quarters in the last, a fifth in the round before it."""
    # Steele, Lea & Flood, "Fast splittable pseudorandom number generators" (2014): SplitMix64
    bits = np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    bits = (bits ^ (bits >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    bits = bits ^ (bits >> np.uint64(31))
    lowest_bit = bits & (~bits + np.uint64(1))
    trailing_zeros = np.frexp(lowest_bit.astype(np.float64))[1] - 1  # exact for a power of two
    return np.maximum(LAST_ROUND - trailing_zeros.astype(np.int64) // ROUND_BITS, 0)


def insertion_order(positions: LongArray) -> LongArray:
    """Return the order of points by rounds of growing size, and along the curve within a round.

    The order of two points does not depend on the other points.
    """
    keys = _rounds(len(positions)) << 2 * CURVE_BITS | positions
    return np.argsort(keys, kind="stable").astype(np.int64, copy=False)
