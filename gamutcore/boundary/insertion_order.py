"""The order in which points around a centre are put into a hull: near in direction, near in time.

Directions lie along a Hilbert curve over the whole sphere, so that each point's place in the hull
is a few steps from that of the point before it. The curve is run through in rounds, each with
several times the points of the one before, drawn by chance: a coarse hull is there before the fine
one is begun, and no order of the input can make the work grow with the square of its size (Amenta,
Choi & Rote, "Incremental Constructions con BRIO", 2003). Chance is a hash of a point's number, so
the order is the same in every run.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, LongArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["insertion_order", "places_on_curve"]

CURVE_BITS = 15
"""Levels of the curve: it has 4¹⁵ = 10⁹ places, a thousand for each of a million points."""

ROUND_BITS = 2
"""Each round has 2² times the points of the one before (1, 2 and 3 bits were tried: 0.63, 0.51 and
0.57 s for the hull of 10⁶ points)."""

LAST_ROUND = 15
"""Rounds before the last one; 4¹⁵ points would fill the first with one point."""


@kernel
def places_on_curve(relative: FloatArray) -> LongArray:
    """Where directions lie along a Hilbert curve that covers the sphere.

    The sphere is unfolded into a square by way of an octahedron; the curve is that of Hilbert,
    "Ueber die stetige Abbildung einer Linie auf ein Flächenstück" (1891).

    Parameters
    ----------
    relative : (n, 3) float64
        Points relative to the centre.

    Returns
    -------
    (n,) int64
        0 to 4¹⁵ − 1.
    """
    place = np.empty(len(relative), np.int64)
    half = 0.5 * (2**CURVE_BITS - 1)
    for index in range(len(relative)):
        x, y, z = relative[index, 0], relative[index, 1], relative[index, 2]
        total = abs(x) + abs(y) + abs(z)
        u, v = (x / total, y / total) if total > 0.0 else (0.0, 0.0)
        if z < 0.0:  # the lower half's corners are folded outwards over the upper half's edges
            u, v = (
                (1.0 - abs(v)) * (1.0 if u >= 0.0 else -1.0),
                (1.0 - abs(u)) * (1.0 if v >= 0.0 else -1.0),
            )
        place[index] = _hilbert_place(int((u + 1.0) * half), int((v + 1.0) * half))
    return place


@leaf_kernel
def _hilbert_place(column: int, row: int) -> int:
    """Place along the curve of a cell of the square: two bits a level, from the largest quarter."""
    place = 0
    for level in range(CURVE_BITS - 1, -1, -1):
        right, upper = column >> level & 1, row >> level & 1
        place = 4 * place + (3 * right ^ upper)
        if not upper:
            if right:
                column, row = ~column, ~row
            column, row = row, column
    return place


@kernel
def _rounds(count: int) -> LongArray:
    """Round of each point, by chance: three quarters are in the last, a fifth in that before it."""
    drawn = np.empty(count, np.int64)
    for index in range(count):
        # Steele, Lea & Flood, "Fast splittable pseudorandom number generators" (2014): SplitMix64
        bits = np.uint64(index + 1) * np.uint64(0x9E3779B97F4A7C15)
        bits = (bits ^ (bits >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        bits = bits ^ (bits >> np.uint64(31))
        left = LAST_ROUND
        while left > 0 and bits & np.uint64(2**ROUND_BITS - 1) == np.uint64(0):
            bits >>= np.uint64(ROUND_BITS)
            left -= 1
        drawn[index] = left
    return drawn


def insertion_order(places: LongArray) -> LongArray:
    """Order points by rounds of growing size, within each round along the curve.

    Parameters
    ----------
    places : (n,) int64
        As from `places_on_curve`.

    Returns
    -------
    (n,) int64
        A permutation. Of two points it puts the same one first whatever others there are.
    """
    keys = _rounds(len(places)) << 2 * CURVE_BITS | places
    return np.argsort(keys, kind="stable").astype(np.int64, copy=False)
