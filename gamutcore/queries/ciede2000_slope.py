"""CIEDE2000 with its derivatives, for searches of the nearest colour.

The derivatives of equations 2 to 22 (see `colour_difference`) by a* and b* of the second colour
follow from the chain rule. ΔH' is written without half angles,

    ΔH' = √2 (a'₁ b₂ − b₁ a'₂) ÷ √(C'₁ C'₂ + a'₁ a'₂ + b₁ b₂),

so that only equation 16 needs the angle of a hue.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.kernels import leaf_kernel
from gamutcore.queries.colour_difference import (
    COS_6,
    COS_30,
    COS_63,
    COS_95,
    COS_275,
    ROTATION,
    SEVENTH,
    SIN_6,
    SIN_30,
    SIN_63,
    SIN_275,
    WIDTH,
    ciede2000,
)

__all__ = ["CHROMA", "SLOPE", "A", "B", "L", "set_slope"]

SLOPE = 10
"""Numbers that `set_slope` sets."""

L, A, B, CHROMA = range(4)
"""Indices of L*, a*, b* and C* in the numbers of a colour."""

LEAST = 1e-6
"""Below this chroma a colour counts as neutral, and the difference has no derivative."""

OPPOSITE = 1e-6
"""Below this value of 1 + cos Δh hues count as opposite, and the difference has no derivative."""

STEEP = 30.0
"""From this exponent on, equation 16 counts as 0: exp(−30) is 1e-13."""


@leaf_kernel
def set_slope(colour: FloatArray, x: float, y: float, z: float, slope: FloatArray) -> float:
    """Return ΔE00 of a colour (4,), L*, a*, b*, C*, and another; set derivatives by the other.

    `slope` (10,) receives the derivatives of half the square: the gradient; ΔL' ÷ S_L by L*; u =
    ΔC' ÷ S_C and v = ΔH' ÷ S_H by a* and b* each; then R_T and the value. All are 0 where no
    derivative exists.
    """
    for place in range(SLOPE):
        slope[place] = 0.0
    l, a, b, own = colour[L], colour[A], colour[B], colour[CHROMA]  # noqa: E741
    away = 0.5 * (l + x) - 50.0
    square = 20.0 + away * away
    root = np.sqrt(square)
    weight = 1.0 + 0.015 * away * away / root
    light = (x - l) / weight
    light_x = (1.0 - light * 0.0075 * away * (square + 20.0) / (square * root)) / weight
    slope[0], slope[3] = light * light_x, light_x

    other = np.sqrt(y * y + z * z)
    if own < LEAST and other < LEAST:
        value = ciede2000(l, a, b, x, y, z)
        slope[9] = value
        return value
    mean = 0.5 * (own + other)
    power = mean * mean * mean
    power = power * power * mean
    share = power / (power + SEVENTH) if power < 1e300 else 1.0
    half_root = 0.5 * np.sqrt(share)
    stretch = 1.5 - half_root
    factor = -1.75 * half_root * (1.0 - share) / mean
    cy, cz = (y / other, z / other) if other > 0.0 else (0.0, 0.0)
    stretch_y, stretch_z = factor * cy, factor * cz
    x1, x2 = stretch * a, stretch * y
    x1_y, x1_z = stretch_y * a, stretch_z * a
    x2_y, x2_z = stretch_y * y + stretch, stretch_z * y
    c1, c2 = np.sqrt(x1 * x1 + b * b), np.sqrt(x2 * x2 + z * z)
    product = c1 * c2
    whole = product + x1 * x2 + b * z
    if c1 < LEAST and c2 >= LEAST:  # a neutral colour has no hue, and takes that of the other
        c2_y, c2_z = x2 * x2_y / c2, (x2 * x2_z + z) / c2
        scale = 1.0 / (1.0 + 0.0225 * (c1 + c2))
        u = (c2 - c1) * scale
        bend = scale * (1.0 - 0.0225 * u)
        slope[1], slope[2] = u * bend * c2_y, u * bend * c2_z
        slope[4], slope[5] = bend * c2_y, bend * c2_z
        # as wide across as along: at chroma 0 both weights are 1
        slope[6], slope[7] = -c2_z, c2_y
        value = ciede2000(l, a, b, x, y, z)
        slope[9] = value
        return value
    if c2 < LEAST or whole < OPPOSITE * product:
        value = ciede2000(l, a, b, x, y, z)
        slope[9] = value
        return value
    c1_y, c1_z = x1 * x1_y / c1, x1 * x1_z / c1
    c2_y, c2_z = x2 * x2_y / c2, (x2 * x2_z + z) / c2
    middle = 0.5 * (c1 + c2)
    middle_y, middle_z = 0.5 * (c1_y + c2_y), 0.5 * (c1_z + c2_z)

    scale = 1.0 / (1.0 + 0.045 * middle)
    u = (c2 - c1) * scale
    u_y = (c2_y - c1_y - 0.045 * u * middle_y) * scale
    u_z = (c2_z - c1_z - 0.045 * u * middle_z) * scale

    # the mean hue
    cosine, sine = x1 * c2 + x2 * c1, b * c2 + z * c1
    length = 1.0 / np.sqrt(cosine * cosine + sine * sine)
    cosine, sine = cosine * length, sine * length
    one, two = 0.5 / (c1 * c1), 0.5 / (c2 * c2)
    hue_y = -one * b * x1_y - two * z * x2_y
    hue_z = -one * b * x1_z + two * (x2 - z * x2_z)
    double, double_sine = 2.0 * cosine * cosine - 1.0, 2.0 * cosine * sine
    triple = double * cosine - double_sine * sine
    triple_sine = double_sine * cosine + double * sine
    fourfold, fourfold_sine = 2.0 * double * double - 1.0, 2.0 * double * double_sine
    t = (
        1.0
        - 0.17 * (cosine * COS_30 + sine * SIN_30)
        + 0.24 * double
        + 0.32 * (triple * COS_6 - triple_sine * SIN_6)
        - 0.20 * (fourfold * COS_63 + fourfold_sine * SIN_63)
    )
    t_hue = (
        0.17 * (sine * COS_30 - cosine * SIN_30)
        - 0.48 * double_sine
        - 0.96 * (triple_sine * COS_6 + triple * SIN_6)
        + 0.80 * (fourfold_sine * COS_63 - fourfold * SIN_63)
    )

    # ΔH'
    across = x1 * z - b * x2
    across_y, across_z = x1_y * z - b * x2_y, x1_z * z + x1 - b * x2_z
    whole_y = c1_y * c2 + c1 * c2_y + x1_y * x2 + x1 * x2_y
    whole_z = c1_z * c2 + c1 * c2_z + x1_z * x2 + x1 * x2_z + b
    scale = np.sqrt(2.0 / whole)
    d_hue = across * scale
    half = 0.5 * across / whole
    d_hue_y, d_hue_z = scale * (across_y - half * whole_y), scale * (across_z - half * whole_z)
    scale = 1.0 / (1.0 + 0.015 * middle * t)
    v = d_hue * scale
    v_y = (d_hue_y - 0.015 * v * (middle_y * t + middle * t_hue * hue_y)) * scale
    v_z = (d_hue_z - 0.015 * v * (middle_z * t + middle * t_hue * hue_z)) * scale

    # R_T
    rotation = rotation_y = rotation_z = 0.0
    toward = cosine * COS_275 + sine * SIN_275
    if toward > -0.74 and (sine < 0.0 or cosine < COS_95):  # as in `colour_difference`
        angle = np.arctan2(sine * COS_275 - cosine * SIN_275, toward) / WIDTH
        if angle * angle < STEEP:
            power = middle * middle * middle
            power = power * power * middle
            share = power / (power + SEVENTH) if power < 1e300 else 1.0
            root = np.sqrt(share)
            turn = ROTATION * np.exp(-angle * angle)
            turned = np.sin(turn)
            rotation = -2.0 * root * turned
            by_chroma = -7.0 * root * (1.0 - share) / middle * turned
            by_hue = 4.0 * root * np.cos(turn) * turn * angle / WIDTH
            rotation_y = by_chroma * middle_y + by_hue * hue_y
            rotation_z = by_chroma * middle_z + by_hue * hue_z
    along_u, along_v = u + 0.5 * rotation * v, v + 0.5 * rotation * u
    half = 0.5 * u * v
    slope[1] = along_u * u_y + along_v * v_y + half * rotation_y
    slope[2] = along_u * u_z + along_v * v_z + half * rotation_z
    slope[4], slope[5], slope[6], slope[7], slope[8] = u_y, u_z, v_y, v_z, rotation
    value = np.sqrt(max(light * light + u * along_u + v * along_v, 0.0))
    slope[9] = value
    return value
