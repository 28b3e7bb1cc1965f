"""The colour difference CIEDE2000 between colours in CIELAB.

Source: G. Sharma, W. Wu & E. N. Dalal, "The CIEDE2000 color-difference formula: Implementation
notes, supplementary test data, and mathematical observations", Color Research & Application 30
(2005), equations 2 to 22, with all parametric factors 1.

Hues are unit vectors in place of angles. The mean hue is then the direction between two vectors,
and cosines of its multiples are polynomials. Hues beyond 360° need no case.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray
from gamutcore.errors import InvalidPointsError
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel
from gamutcore.queries.rows import checked_points

__all__ = ["ciede2000", "delta_e_2000", "hue_factor", "hue_factors", "hue_rotation", "stretch_at"]

SEVENTH = 25.0**7

COS_30, SIN_30 = float(np.cos(np.pi / 6)), 0.5
COS_6, SIN_6 = float(np.cos(np.radians(6))), float(np.sin(np.radians(6)))
COS_63, SIN_63 = float(np.cos(np.radians(63))), float(np.sin(np.radians(63)))
COS_275, SIN_275 = float(np.cos(np.radians(275))), float(np.sin(np.radians(275)))
"""Constants of equations 15 and 16, where hues are in degrees."""

WIDTH = float(np.radians(25))
ROTATION = float(np.radians(60))
COS_95 = float(np.cos(np.radians(95)))
"""Between 0 and 95°, equation 16 is the exponential of less than −51: nothing in float64."""


def delta_e_2000(one: ArrayLike, two: ArrayLike) -> FloatArray:
    """Return the colour differences CIEDE2000 (ΔE00) of pairs of colours.

    Parameters
    ----------
    one, two : (n, 3) array_like
        L*, a*, b*.

    Returns
    -------
    (n,) float64

    Raises
    ------
    InvalidPointsError
        A colour is not three finite numbers, or the numbers of rows differ.

    Examples
    --------
    >>> delta_e_2000([(50, 2.6772, -79.7751)], [(50, 0, -82.7485)]).round(4).tolist()
    [2.0425]
    """
    first, second = checked_points(one, "one"), checked_points(two, "two")
    if len(first) != len(second):
        raise InvalidPointsError(
            f"one has {len(first)} rows and two has {len(second)}.",
            where={"field": "two"},
            remedy="Give pairs of colours.",
        )
    return _delta_e_2000(first, second)


@kernel
def _delta_e_2000(one: FloatArray, two: FloatArray) -> FloatArray:
    difference = np.empty(len(one))
    for row in range(len(one)):
        difference[row] = ciede2000(
            one[row, 0], one[row, 1], one[row, 2], two[row, 0], two[row, 1], two[row, 2]
        )
    return difference


@leaf_kernel
def ciede2000(l1: float, a1: float, b1: float, l2: float, a2: float, b2: float) -> float:
    """Return ΔE00 of two colours in CIELAB."""
    chroma = 0.5 * (np.sqrt(a1 * a1 + b1 * b1) + np.sqrt(a2 * a2 + b2 * b2))
    stretch = stretch_at(chroma)
    x1, x2 = stretch * a1, stretch * a2
    c1, c2 = np.sqrt(x1 * x1 + b1 * b1), np.sqrt(x2 * x2 + b2 * b2)
    chroma = 0.5 * (c1 + c2)
    # unit vectors of the hues; an achromatic colour takes the hue of the other one
    u1 = x1 / c1 if c1 > 0.0 else 0.0
    v1 = b1 / c1 if c1 > 0.0 else 0.0
    u2 = x2 / c2 if c2 > 0.0 else u1
    v2 = b2 / c2 if c2 > 0.0 else v1
    if c1 == 0.0:
        u1, v1 = u2, v2
    across = u1 * v2 - v1 * u2
    along = u1 * u2 + v1 * v2
    # 2 sin(Δh ÷ 2), with the sign of Δh
    sine = np.sqrt((u2 - u1) ** 2 + (v2 - v1) ** 2)
    cosine, height = u1 + u2, v1 + v2
    first_is_larger = v1 < 0.0 or (v1 == 0.0 and u1 < 0.0)  # if hues are opposite
    if along < 0.0:  # nearly opposite: the sum of the vectors is inaccurate
        cosine, height = v2 - v1, u1 - u2
        side = cosine * (u1 + u2) + height * (v1 + v2)
        # exactly opposite: a quarter turn from the smaller angle
        if side < 0.0 or (side == 0.0 and first_is_larger):
            cosine, height = -cosine, -height
    length = np.sqrt(cosine * cosine + height * height)
    if length > 0.0:
        cosine, height = cosine / length, height / length
    else:
        cosine, height = 1.0, 0.0
    if across < 0.0 or (across == 0.0 and along < 0.0 and first_is_larger):
        sine = -sine
    d_hue = np.sqrt(c1 * c2) * sine

    t = hue_factor(cosine, height)
    middle = (0.5 * (l1 + l2) - 50.0) ** 2
    light = (l2 - l1) / (1.0 + 0.015 * middle / np.sqrt(20.0 + middle))
    colourful = (c2 - c1) / (1.0 + 0.045 * chroma)
    hue = d_hue / (1.0 + 0.015 * chroma * t)
    rotation = 0.0
    if height < 0.0 or cosine < COS_95:
        rotation = -2.0 * np.sqrt(_saturation(chroma)) * hue_rotation(cosine, height, 0.0)
    square = light * light + colourful * colourful + hue * hue + rotation * colourful * hue
    return np.sqrt(max(square, 0.0))


@leaf_kernel
def _saturation(chroma: float) -> float:
    """Return C⁷ ÷ (C⁷ + 25⁷)."""
    square = chroma * chroma
    seventh = square * square * square * chroma
    return seventh / (seventh + SEVENTH) if seventh < 1e300 else 1.0


@leaf_kernel
def stretch_at(chroma: float) -> float:
    """Return a' ÷ a, which is 1 + G, for a mean chroma C* (equation 4)."""
    return 1.5 - 0.5 * np.sqrt(_saturation(chroma))


@inlined_kernel
def hue_factor(cosine: float, sine: float) -> float:
    """Return T for a mean hue (equation 15)."""
    even, odd = hue_factors(cosine, sine)
    return even + odd


@inlined_kernel
def hue_factors(cosine: float, sine: float) -> tuple[float, float]:
    """Return two terms of T. At the opposite hue the second term changes its sign."""
    double, double_sine = 2.0 * cosine * cosine - 1.0, 2.0 * cosine * sine
    triple = double * cosine - double_sine * sine
    triple_sine = double_sine * cosine + double * sine
    fourfold, fourfold_sine = 2.0 * double * double - 1.0, 2.0 * double * double_sine
    even = 1.0 + 0.24 * double - 0.20 * (fourfold * COS_63 + fourfold_sine * SIN_63)
    odd = 0.32 * (triple * COS_6 - triple_sine * SIN_6)
    return even, odd - 0.17 * (cosine * COS_30 + sine * SIN_30)


@leaf_kernel
def hue_rotation(cosine: float, sine: float, slack: float) -> float:
    """Return the largest sin 2Δθ over hues up to `slack` from a mean hue (equations 16 and 19)."""
    angle = np.arctan2(cosine * SIN_275 - sine * COS_275, cosine * COS_275 + sine * SIN_275)
    share = max(abs(angle) - slack, 0.0) / WIDTH
    return np.sin(ROTATION * np.exp(-share * share))
