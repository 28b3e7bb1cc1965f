"""The grid that positions lie on: what a mesh delivers, a history stores and validity is tested on.

A gamut's coordinates are whole multiples of a power of two, below 10⁻³ ΔE in CIELAB. Such
numbers are exact in float32, so rounding to the grid happens once, before any test, and what is
stored in a few bits, delivered as glTF and tested for validity are the same numbers.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray

__all__ = ["grid_step", "mesh_grid_step", "nearest_grid_points"]

STEPS_PER_EXTENT = 18
"""Binary logarithm of the steps in the power of two that is not below the extent. Lightness extends
over 64 to 128 units in gamuts of devices, which gives a step of 2⁻¹² to 2⁻¹¹ < 10⁻³ ΔE; thinner
sets of points, whose volume a shift of their surface changes more, have finer steps."""

MIDDLE = 0.9
"""Part of the points that counts for the extent along an axis: a few spikes must not coarsen the
grid of the rest."""

MANTISSA = 24
"""Bits of a float32's mantissa: whole numbers up to 2²⁴ are exact."""

ROOM = 2
"""Bits that are left for vertices that decimation places outside of what it is given: the last four
triangles of a sphere reach to three times its radius."""

FINEST = 2.0**-149
"""The smallest float32 above zero."""


def grid_step(points: ArrayLike) -> float:
    """Step of the grid for points: a power of two.

    Parameters
    ----------
    points : (n, 3) array_like
        Finite numbers, at least one point.

    Returns
    -------
    float
        2⁻¹⁸ of the power of two that is not below the smallest of the points' extents along the
        axes; more where float32 does not resolve the largest coordinate as finely.
    """
    given = np.asarray(points, np.float64)
    lowest, highest = np.quantile(given, ((1 - MIDDLE) / 2, (1 + MIDDLE) / 2), axis=0)
    extent = float((highest - lowest).min())
    return max(_power_of_two_above(extent) * 2.0**-STEPS_PER_EXTENT, _float32_step(given))


def mesh_grid_step(vertices: ArrayLike) -> float:
    """Step of the grid for a mesh: fine enough for its size and for the grid that it is on already.

    Parameters
    ----------
    vertices : (m, 3) array_like
        Finite numbers, at least one vertex.

    Returns
    -------
    float
        `grid_step` of the vertices, or the largest power of two that divides all of their
        coordinates if that is less; never finer than float32 resolves four times the largest of
        them.
    """
    given = np.asarray(vertices, np.float64)
    finest = _float32_step(given)
    bits = int(np.bitwise_or.reduce(np.rint(given / finest).astype(np.int64), axis=None))
    own = finest * (bits & -bits)
    return min(grid_step(given), own) if own > 0 else grid_step(given)


def nearest_grid_points(points: ArrayLike, step: float) -> FloatArray:
    """Points rounded to the nearest multiples of a step, halves to even, without negative zeros.

    Parameters
    ----------
    points : array_like
    step : float
        A power of two.

    Returns
    -------
    float64 array of the same shape
        Exact in float32 if the step is that of `grid_step` for these points.
    """
    return np.asarray(np.rint(np.asarray(points, np.float64) / step) * step + 0.0)


def _float32_step(points: FloatArray) -> float:
    """Finest grid on which float32 holds all numbers up to four times the largest coordinate."""
    return max(_power_of_two_above(float(np.abs(points).max())) * 2.0 ** (ROOM - MANTISSA), FINEST)


def _power_of_two_above(value: float) -> float:
    """Smallest power of two that is not below a value; 0 for 0."""
    if value == 0.0:
        return 0.0
    mantissa, exponent = math.frexp(value)
    return math.ldexp(1.0, exponent - 1 if mantissa == 0.5 else exponent)
