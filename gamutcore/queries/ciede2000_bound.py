"""A lower bound of ΔE00 between a colour and all colours of a ball, for searches of the nearest.

It follows from equations 2 to 22 of Sharma, Wu & Dalal (see `colour_difference`). With
u = ΔC' ÷ S_C and v = ΔH' ÷ S_H:

    ΔE00² ≥ (ΔL ÷ S_L)² + min (u² + v² − R |u v|)

- |ΔL|, |ΔC'| and |ΔH'| are at least the smallest that occur in the ball; S_L, S_C, S_H and
  R = |R_T| at most the largest. The minimum is over all u and v not smaller than the bounds.
- G falls with the mean chroma. Its largest and smallest value give intervals of both C'.
- ΔH' = 2 √(C'₁ C'₂) sin (Δh ÷ 2). The hues of the ball differ from that of its middle by no more
  than the arcsine of radius ÷ chroma, and hues turn by no more than half of a change of G.
- T changes by at most 2.41 per radian of the mean hue, which is the sum of the factors of its
  cosines times their multiples. Its maximum is used where the hues may be opposite.
- R falls with the distance of the mean hue from 275°. R_T is never positive, so that R is 0 if ΔC'
  and ΔH' have different signs in the whole ball.
"""

from __future__ import annotations

import numpy as np

from gamutcore.kernels import leaf_kernel
from gamutcore.queries.colour_difference import hue_factor, hue_rotation, stretch_at

__all__ = ["ball_bound"]

STEEPNESS = 0.17 + 2.0 * 0.24 + 3.0 * 0.32 + 4.0 * 0.20
"""Bound of the derivative of T."""

LARGEST_T = 1.573
"""T is at most 1.5725, at 234°."""

LARGEST_SINE = 0.8660255
"""The sine of 60°, rounded up: 2 Δθ is at most 60°."""


@leaf_kernel
def ball_bound(
    l: float,  # noqa: E741  # L*
    a: float,
    b: float,
    cl: float,
    ca: float,
    cb: float,
    tall: float,
    radius: float,
) -> float:
    """Return a lower bound of ΔE00 between a colour and the colours of a ball.

    Parameters
    ----------
    l, a, b : float
        The colour.
    cl, ca, cb : float
        The middle of the ball.
    tall : float
        Largest difference of L* from that of the middle.
    radius : float
        Largest distance from the middle in the plane of a* and b*.
    """
    away = max(abs(0.5 * (l + cl) - 50.0) + 0.5 * tall, 0.0)
    light = max(abs(cl - l) - tall, 0.0) / (1.0 + 0.015 * away * away / np.sqrt(20.0 + away * away))
    own, other = np.sqrt(a * a + b * b), np.sqrt(ca * ca + cb * cb)
    wide = stretch_at(0.5 * (own + max(other - radius, 0.0)))
    narrow = stretch_at(0.5 * (own + other + radius))
    reach = wide * radius
    # chromas C'
    own_low = np.sqrt(narrow * narrow * a * a + b * b)
    own_high = np.sqrt(wide * wide * a * a + b * b)
    low = max(np.sqrt(narrow * narrow * ca * ca + cb * cb) - reach, 0.0)
    high = np.sqrt(wide * wide * ca * ca + cb * cb) + reach
    mean = 0.5 * (own_high + high)
    u = max(low - own_high, own_low - high, 0.0) / (1.0 + 0.045 * mean)
    # hues, at the mean of both G
    stretch = 0.5 * (wide + narrow)
    x1, x2 = stretch * a, stretch * ca
    c1, c2 = np.sqrt(x1 * x1 + b * b), np.sqrt(x2 * x2 + cb * cb)
    v, t, rotation = 0.0, LARGEST_T, LARGEST_SINE
    share = reach / c2 if c2 > 0.0 else 1.0
    if c1 > 0.0 and share < 1.0:
        slack = share + 0.5708 * share * share * share  # not below the arcsine
        slack = 0.5 * (slack + 0.5 * (wide - narrow))  # of half the difference, and of the mean
        cosine, across = (x1 * x2 + b * cb) / (c1 * c2), x1 * cb - b * x2
        half_sine = np.sqrt(max(0.5 * (1.0 - cosine), 0.0))
        half_cosine = np.sqrt(max(0.5 * (1.0 + cosine), 0.0))
        sine = half_sine * max(1.0 - 0.5 * slack * slack, 0.0) - half_cosine * slack
        if half_cosine > slack:  # the hues are not opposite
            mean_x, mean_y = x1 / c1 + x2 / c2, b / c1 + cb / c2
            length = np.sqrt(mean_x * mean_x + mean_y * mean_y)
            mean_x, mean_y = mean_x / length, mean_y / length
            t = min(hue_factor(mean_x, mean_y) + STEEPNESS * slack, LARGEST_T)
            if sine > 0.0 and u > 0.0 and (across > 0.0) != (low > own_high):
                rotation = 0.0
            else:
                rotation = hue_rotation(mean_x, mean_y, slack)
        else:  # mean hues are near both normals of the colour's own hue
            mean_x, mean_y, wider = -b / c1, x1 / c1, 2.5708 * slack
            t = max(hue_factor(mean_x, mean_y), hue_factor(-mean_x, -mean_y))
            t = min(t + STEEPNESS * wider, LARGEST_T)
            rotation = max(
                hue_rotation(mean_x, mean_y, wider), hue_rotation(-mean_x, -mean_y, wider)
            )
        if sine > 0.0:
            v = 2.0 * np.sqrt(own_low * low) * sine / (1.0 + 0.015 * mean * t)
    if rotation > 0.0:
        # √(C⁷ ÷ (C⁷ + 25⁷)) in terms of the stretch at this mean
        rotation *= 2.0 * (3.0 - 2.0 * stretch_at(mean))
    half = 0.5 * rotation
    small, large = min(u, v), max(u, v)
    if small <= half * large:
        square = large * large * (1.0 - half * half)
    else:
        square = u * u + v * v - rotation * u * v
    return np.sqrt(light * light + square)
