"""The grid that positions lie on: what a mesh delivers, a history stores and validity is tested on.

A gamut's coordinates are whole multiples of a power of two, at most 10⁻³ ΔE in CIELAB. Such
numbers are exact in float32, so rounding to the grid happens once, before any test, and what is
stored in a few bits, delivered as glTF and tested for validity are the same numbers.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray

__all__ = ["grid_step", "rounded_to_grid"]

STEPS_PER_EXTENT = 19
"""Binary logarithm of the steps in the power of two that is not below the largest extent. Gamuts in
CIELAB extend over 128 to 512, which gives a step of 2⁻¹² to 2⁻¹⁰ < 10⁻³ ΔE."""

MANTISSA = 24
"""Bits of a float32's mantissa: whole numbers up to 2²⁴ are exact."""

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
        2⁻¹⁹ of the power of two that is not below the points' largest extent along an axis; more
        where float32 does not resolve the largest coordinate as finely. 0 extent counts as that of
        the coordinates themselves.
    """
    given = np.asarray(points, np.float64)
    reach = float(np.abs(given).max())
    extent = float(np.ptp(given, axis=0).max())
    step = _power_of_two_above(extent if extent > 0 else reach) * 2.0**-STEPS_PER_EXTENT
    return max(step, _power_of_two_above(reach) * 2.0**-MANTISSA, FINEST)


def rounded_to_grid(points: ArrayLike, step: float) -> FloatArray:
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


def _power_of_two_above(value: float) -> float:
    """Smallest power of two that is not below a value; 0 for 0."""
    if value == 0.0:
        return 0.0
    mantissa, exponent = math.frexp(value)
    return math.ldexp(1.0, exponent - 1 if mantissa == 0.5 else exponent)
