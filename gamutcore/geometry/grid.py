"""The grid of coordinates: positions are whole multiples of a power of two.

The step is below 10⁻³ ΔE in CIELAB, and its multiples are exact in float32. A boundary rounds its
points before any test. Decimation rounds again, without effect on rounded points. Histories, levels
and the validity test therefore have the same numbers.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray

__all__ = ["grid_step", "mesh_grid_step", "nearest_grid_points"]

STEPS_PER_EXTENT = 18
"""Binary logarithm of the number of steps in the power of two that is not below the extent.
Lightness extends over 64 to 128 units in gamuts of devices, which gives a step of 2⁻¹² to 2⁻¹¹ <
10⁻³ ΔE. Thinner sets of points have finer steps, because a shift changes their volume more."""

MIDDLE = 0.9
"""Share of the points that determines the extent along an axis. A few outliers must not coarsen the
grid of the other points."""

MANTISSA = 24
"""Bits of the mantissa of a float32: whole numbers up to 2²⁴ are exact."""

ROOM = 2
"""Spare bits for vertices that decimation moves outside the original surface. The last four
triangles of a sphere reach to three times its radius."""

FINEST = 2.0**-149
"""The smallest positive float32."""


def grid_step(points: ArrayLike) -> float:
    """Return the step of the grid for at least one finite point (n, 3).

    It is 2⁻¹⁸ of the power of two that is not below the smallest extent along an axis. Where
    float32 resolves only coarser steps at the largest coordinate, the finest of these is the step.
    """
    given = np.asarray(points, np.float64)
    lowest, highest = np.quantile(given, ((1 - MIDDLE) / 2, (1 + MIDDLE) / 2), axis=0)
    extent = float((highest - lowest).min())
    return max(_power_of_two_above(extent) * 2.0**-STEPS_PER_EXTENT, _float32_step(given))


def mesh_grid_step(vertices: ArrayLike) -> float:
    """Return the step of the grid for vertices (m, 3) that may be on a grid already.

    It is `grid_step`, or the largest power of two that divides all coordinates if that is smaller.
    It is never finer than float32 resolves at four times the largest coordinate.
    """
    given = np.asarray(vertices, np.float64)
    finest = _float32_step(given)
    bits = int(np.bitwise_or.reduce(np.rint(given / finest).astype(np.int64), axis=None))
    own = finest * (bits & -bits)
    return min(grid_step(given), own) if own > 0 else grid_step(given)


def nearest_grid_points(points: ArrayLike, step: float) -> FloatArray:
    """Return the nearest points on a grid, exact in float32 if the step is that of `grid_step`.

    Halves round to even, and there are no negative zeros.
    """
    return np.asarray(np.rint(np.asarray(points, np.float64) / step) * step + 0.0)


def _float32_step(points: FloatArray) -> float:
    """Finest step at which float32 is exact up to four times the largest coordinate."""
    return max(_power_of_two_above(float(np.abs(points).max())) * 2.0 ** (ROOM - MANTISSA), FINEST)


def _power_of_two_above(value: float) -> float:
    """Smallest power of two that is not below a value; 0 for 0."""
    if value == 0.0:
        return 0.0
    mantissa, exponent = math.frexp(value)
    return math.ldexp(1.0, exponent - 1 if mantissa == 0.5 else exponent)
