"""A lower bound of ΔE00 between a colour and a box of lightness, chroma and hue.

It follows from equations 2 to 22 of Sharma, Wu & Dalal (see `colour_difference`). With u = ΔC' ÷
S_C and v = ΔH' ÷ S_H:

    ΔE00² ≥ (ΔL ÷ S_L)² + min (u² + v² − R |u v|)

- |ΔL|, |ΔC'| and |ΔH'| have their smallest values in the box; S_L, S_C, S_H and R = |R_T| have
  their largest. The minimum is over all u and v not smaller than these bounds.
- G falls with the mean chroma. Its largest and smallest value give intervals of both C'.
- ΔH' = 2 √(C'₁ C'₂) sin (Δh ÷ 2). A factor of 1 + G grows differences in hue by no more than
  itself. Hues turn by no more than half of a change of G.
- T changes by at most 2.41 per radian of the mean hue: the sum of the factors of its cosines times
  their multiples. The mean of nearly opposite hues is near one of two normals; the larger T is
  used.
- R falls with the distance of the mean hue from 275°. R_T is never positive, so R is 0 if ΔC' and
  ΔH' have different signs everywhere.
"""

from __future__ import annotations

import numpy as np

from gamutcore.kernels import inlined_kernel
from gamutcore.queries.ciede2000_expansion import steepest_rotation
from gamutcore.queries.colour_difference import COS_275, SIN_275, hue_factors

__all__ = ["interval_bound"]

STEEPNESS = 0.17 + 2.0 * 0.24 + 3.0 * 0.32 + 4.0 * 0.20
"""Bound of the derivative of T."""

LARGEST_T = 1.573
"""T is at most 1.5725, at 234°."""

TINY = 1e-18
"""Keeps divisors from 0. It is below the rounding errors of colours that are not neutral."""


@inlined_kernel
def interval_bound(
    l: float,  # noqa: E741  # L*
    a: float,
    b: float,
    own: float,
    dark: float,
    bright: float,
    ca: float,
    cb: float,
    least: float,
    most: float,
    turn: float,
) -> float:
    """Return a lower bound of half the square of ΔE00 between a colour and a box.

    The colour has C* `own`. The box has L* from `dark` to `bright`, C* from `least` to `most`, and
    hues up to `turn` radians from that of (`ca`, `cb`); from π / 2 on, all hues may occur. There
    are no branches, so that the compiler computes several bounds at once.
    """
    away = max(abs(0.5 * (l + dark) - 50.0), abs(0.5 * (l + bright) - 50.0))
    away *= away
    light = max(dark - l, l - bright, 0.0) / (1.0 + 0.015 * away / np.sqrt(20.0 + away))
    wide, narrow = _stretch(0.5 * (own + least)), _stretch(0.5 * (own + most))
    # chromas C'; the square of the cosine of the hue changes by no more than the hue
    own_low = np.sqrt(narrow * narrow * a * a + b * b)
    own_high = np.sqrt(wide * wide * a * a + b * b)
    square = ca * ca / (ca * ca + cb * cb + TINY)
    low = least * np.sqrt(1.0 + (narrow * narrow - 1.0) * max(square - turn, 0.0))
    high = most * np.sqrt(1.0 + (wide * wide - 1.0) * min(square + turn, 1.0))
    mean = 0.5 * (own_high + high)
    u = max(low - own_high, own_low - high, 0.0) / (1.0 + 0.045 * mean)
    # hues, at the mean of both G
    stretch = 0.5 * (wide + narrow)
    x1, x2 = stretch * a, stretch * ca
    c1, c2 = np.sqrt(x1 * x1 + b * b + TINY), np.sqrt(x2 * x2 + cb * cb + TINY)
    x1, y1, x2, y2 = x1 / c1, b / c1, x2 / c2, cb / c2
    has_hue = turn < 0.5 * np.pi
    # of half the difference, and of the mean: a stretch also turns hues, and spreads them
    slack = 0.5 * (wide * turn + 0.5 * (wide - narrow))
    cosine, across = x1 * x2 + y1 * y2, x1 * y2 - y1 * x2
    half_sine = np.sqrt(max(0.5 * (1.0 - cosine), 0.0))
    half_cosine = np.sqrt(max(0.5 * (1.0 + cosine), 0.0))
    sine = half_sine * max(1.0 - 0.5 * slack * slack, 0.0) - half_cosine * slack
    sine = max(sine, 0.0) if has_hue else 0.0
    # R_T counts if ΔC' and ΔH' have the same sign: mean hues are then on one side of the colour's
    known = half_cosine > slack
    aside = 1.0 if low > own_high else -1.0
    # the mean hue; of opposite hues it is near both normals
    nearer = 1.0 if x1 * SIN_275 >= y1 * COS_275 else -1.0
    normal = aside if u > 0.0 else nearer
    mean_x, mean_y = (x1 + x2, y1 + y2) if known else (-y1 * normal, x1 * normal)
    spread = slack if known else 2.5708 * slack
    mean_x, mean_y = (mean_x, mean_y) if has_hue else (x1 - aside * y1, y1 + aside * x1)
    spread = spread if has_hue else 0.25 * np.pi + 0.5 * (wide - narrow)
    length = 1.0 / np.sqrt(mean_x * mean_x + mean_y * mean_y + TINY)
    mean_x, mean_y = mean_x * length, mean_y * length
    known &= has_hue
    even, odd = hue_factors(mean_x, mean_y)
    t = min(even + (odd if known else abs(odd)) + STEEPNESS * spread, LARGEST_T)
    rotation = steepest_rotation(mean_x, mean_y, spread)
    turned = (sine > 0.0) & (u > 0.0) & ((across > 0.0) != (low > own_high)) & known
    # √(C⁷ ÷ (C⁷ + 25⁷)) in terms of the stretch at this mean
    rotation = 0.0 if turned else rotation * 2.0 * (3.0 - 2.0 * _stretch(mean))
    v = 2.0 * np.sqrt(own_low * low) * sine / (1.0 + 0.015 * mean * t)
    half = 0.5 * rotation
    small, large = min(u, v), max(u, v)
    small = max(small, half * large)
    square = small * small + large * large - rotation * small * large
    return 0.5 * (light * light + square)


@inlined_kernel
def _stretch(chroma: float) -> float:
    """Return 1 + G without overflow or branches (see `stretch_at`)."""
    share = 25.0 / (chroma + TINY)
    power = share * share * share
    return 1.5 - 0.5 / np.sqrt(1.0 + power * power * share)
