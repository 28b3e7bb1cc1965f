"""The colour difference CIEDE2000 between colours in CIELAB, and its derivatives.

Source: G. Sharma, W. Wu & E. N. Dalal, "The CIEDE2000 color-difference formula: Implementation
notes, supplementary test data, and mathematical observations", Color Research & Application 30
(2005), equations 2 to 22, with all parametric factors 1.

Hues are unit vectors in place of angles. The mean hue is then the direction between two vectors,
and cosines of its multiples are polynomials. Hues beyond 360° need no case.

Searches of the nearest colour need derivatives by L*, a* and b* of the second colour, which follow
from the chain rule. ΔH' is written without half angles,

    ΔH' = √2 (a'₁ b₂ − b₁ a'₂) ÷ √(C'₁ C'₂ + a'₁ a'₂ + b₁ b₂),

so that only equation 16 needs the angle of a hue. The derivatives are of half the square of ΔE00,
which is smooth where ΔE00 is 0.

- `set_slope` gives first derivatives of one pair, also at the neutral axis and at opposite hues.
- `chroma_expansion` and `lightness_expansion` give first and second derivatives, without branches
  and library calls, so that the compiler evaluates several colours at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray
from gamutcore.errors import InvalidPointsError
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel
from gamutcore.search.index import checked_points

__all__ = [
    "CHROMA",
    "COS_275",
    "SIN_275",
    "SLOPE",
    "A",
    "B",
    "L",
    "arc_tangent",
    "chroma_expansion",
    "ciede2000",
    "delta_e_2000",
    "hue_factors",
    "lightness_expansion",
    "set_slope",
    "steepest_rotation",
]

SEVENTH = 25.0**7

COS_30, SIN_30 = float(np.cos(np.pi / 6)), 0.5
COS_6, SIN_6 = float(np.cos(np.radians(6))), float(np.sin(np.radians(6)))
COS_63, SIN_63 = float(np.cos(np.radians(63))), float(np.sin(np.radians(63)))
COS_275, SIN_275 = float(np.cos(np.radians(275))), float(np.sin(np.radians(275)))
"""Constants of equations 15 and 16, where hues are in degrees."""

BLUE_WIDTH, ROTATION = float(np.radians(25)), float(np.radians(60))
"""Constants of equation 16."""

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
    stretch = _stretch_at(chroma)
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

    even, odd = hue_factors(cosine, height)
    middle = (0.5 * (l1 + l2) - 50.0) ** 2
    light = (l2 - l1) / (1.0 + 0.015 * middle / np.sqrt(20.0 + middle))
    colourful = (c2 - c1) / (1.0 + 0.045 * chroma)
    hue = d_hue / (1.0 + 0.015 * chroma * (even + odd))
    rotation = 0.0
    if height < 0.0 or cosine < COS_95:
        rotation = -2.0 * np.sqrt(_saturation(chroma)) * _hue_rotation(cosine, height)
    square = light * light + colourful * colourful + hue * hue + rotation * colourful * hue
    return np.sqrt(max(square, 0.0))


@leaf_kernel
def _saturation(chroma: float) -> float:
    """Return C⁷ ÷ (C⁷ + 25⁷)."""
    square = chroma * chroma
    seventh = square * square * square * chroma
    return seventh / (seventh + SEVENTH) if seventh < 1e300 else 1.0


@leaf_kernel
def _stretch_at(chroma: float) -> float:
    """Return a' ÷ a, which is 1 + G, for a mean chroma C* (equation 4)."""
    return 1.5 - 0.5 * np.sqrt(_saturation(chroma))


@inlined_kernel
def hue_factors(cosine: float, sine: float) -> tuple[float, float]:
    """Return two terms of T for a mean hue (equation 15), which is their sum.

    At the opposite hue the second term changes its sign.
    """
    double, double_sine = 2.0 * cosine * cosine - 1.0, 2.0 * cosine * sine
    triple = double * cosine - double_sine * sine
    triple_sine = double_sine * cosine + double * sine
    fourfold, fourfold_sine = 2.0 * double * double - 1.0, 2.0 * double * double_sine
    even = 1.0 + 0.24 * double - 0.20 * (fourfold * COS_63 + fourfold_sine * SIN_63)
    odd = 0.32 * (triple * COS_6 - triple_sine * SIN_6)
    return even, odd - 0.17 * (cosine * COS_30 + sine * SIN_30)


@leaf_kernel
def _hue_rotation(cosine: float, sine: float) -> float:
    """Return sin 2Δθ for a mean hue (equations 16 and 19)."""
    angle = np.arctan2(cosine * SIN_275 - sine * COS_275, cosine * COS_275 + sine * SIN_275)
    share = angle / BLUE_WIDTH
    return np.sin(ROTATION * np.exp(-share * share))


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
    if toward > -0.74 and (sine < 0.0 or cosine < COS_95):  # as in `ciede2000`
        angle = np.arctan2(sine * COS_275 - cosine * SIN_275, toward) / BLUE_WIDTH
        if angle * angle < STEEP:
            power = middle * middle * middle
            power = power * power * middle
            share = power / (power + SEVENTH) if power < 1e300 else 1.0
            root = np.sqrt(share)
            turn = ROTATION * np.exp(-angle * angle)
            turned = np.sin(turn)
            rotation = -2.0 * root * turned
            by_chroma = -7.0 * root * (1.0 - share) / middle * turned
            by_hue = 4.0 * root * np.cos(turn) * turn * angle / BLUE_WIDTH
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


TINY = 1e-18
"""Keeps divisors from 0. Derivatives have no meaning where it matters."""

INVERSE_BLUE_WIDTH = 1.0 / BLUE_WIDTH

ROTATION_ROUNDING = 1e-6
"""Bound of the relative error of sin 2Δθ."""

Expansion = tuple[float, float, float, float, float, float, float, float]
"""A value, two first and three second derivatives, u and v."""


@inlined_kernel
def lightness_expansion(l: float, x: float) -> tuple[float, float, float]:  # noqa: E741
    """Return ½ (ΔL' ÷ S_L)² and its two derivatives by the second lightness."""
    away = 0.5 * (l + x) - 50.0
    square = 20.0 + away * away
    root = np.sqrt(square)
    share = 1.0 / (square * root)
    weight = 1.0 + 0.015 * away * away / root
    weight_x = 0.0075 * away * (square + 20.0) * share
    weight_xx = 0.00375 * (1200.0 - 20.0 * square) * share / square
    scale = 1.0 / weight
    light = (x - l) * scale
    light_x = (1.0 - light * weight_x) * scale
    light_xx = -(2.0 * light_x * weight_x + light * weight_xx) * scale
    return 0.5 * light * light, light * light_x, light_x * light_x + light * light_xx


@inlined_kernel
def chroma_expansion(a: float, b: float, own: float, y: float, z: float) -> Expansion:
    """Return half the square without lightness, and its derivatives by the second a* and b*.

    The first colour has a*, b* and C* `a`, `b` and `own`; the second has a* and b* `y` and `z`. The
    value is ½ (u² + v² + R_T u v) with u = ΔC' ÷ S_C and v = ΔH' ÷ S_H. The result has the value,
    its derivatives by y, z, yy, yz and zz, then u and v.
    """
    # C* of the second colour
    other = np.sqrt(y * y + z * z + TINY)
    inverse = 1.0 / other
    other_y, other_z = y * inverse, z * inverse
    other_yy, other_yz = other_z * other_z * inverse, -other_y * other_z * inverse
    other_zz = other_y * other_y * inverse
    # 1 + G
    mean = 0.5 * (own + other)
    inverse_mean = 1.0 / mean
    power = 25.0 * inverse_mean
    power = power * power * power
    power = power * power * 25.0 * inverse_mean
    share = 1.0 / (1.0 + power)
    half_root = 0.5 * np.sqrt(share)
    fall = half_root * (1.0 - share) * inverse_mean
    s, s_1 = 1.5 - half_root, -1.75 * fall
    s_2 = -0.875 * fall * inverse_mean * (2.5 - 10.5 * share)
    s_y, s_z = s_1 * other_y, s_1 * other_z
    s_yy = s_2 * other_y * other_y + s_1 * other_yy
    s_yz = s_2 * other_y * other_z + s_1 * other_yz
    s_zz = s_2 * other_z * other_z + s_1 * other_zz
    # C' of the first colour
    x1 = s * a
    square = x1 * x1 + b * b + TINY
    c1 = np.sqrt(square)
    inverse = 1.0 / c1
    square = inverse * inverse
    c1_1 = x1 * a * s_1 * inverse
    c1_2 = (a * a * (s_1 * s_1 + s * s_2) - c1_1 * c1_1) * inverse
    c1_y, c1_z = c1_1 * other_y, c1_1 * other_z
    c1_yy = c1_2 * other_y * other_y + c1_1 * other_yy
    c1_yz = c1_2 * other_y * other_z + c1_1 * other_yz
    c1_zz = c1_2 * other_z * other_z + c1_1 * other_zz
    # its hue
    h1_1 = -a * b * square * s_1
    h1_2 = -a * b * square * (s_2 - 2.0 * x1 * a * square * s_1 * s_1)
    # a' and C' of the second colour
    x2 = s * y
    x2_y, x2_z = s + s_y * y, s_z * y
    x2_yy, x2_yz, x2_zz = 2.0 * s_y + s_yy * y, s_z + s_yz * y, s_zz * y
    c2 = np.sqrt(x2 * x2 + z * z + TINY)
    inverse = 1.0 / c2
    c2_y, c2_z = x2 * x2_y * inverse, (x2 * x2_z + z) * inverse
    c2_yy = (x2_y * x2_y + x2 * x2_yy - c2_y * c2_y) * inverse
    c2_yz = (x2_y * x2_z + x2 * x2_yz - c2_y * c2_z) * inverse
    c2_zz = (x2_z * x2_z + x2 * x2_zz + 1.0 - c2_z * c2_z) * inverse
    # the mean hue
    square = inverse * inverse
    p_y, p_z = -z * x2_y, x2 - z * x2_z
    h_y = 0.5 * (h1_1 * other_y + p_y * square)
    h_z = 0.5 * (h1_1 * other_z + p_z * square)
    cube = 2.0 * square * inverse
    h_yy = h1_2 * other_y * other_y + h1_1 * other_yy - z * x2_yy * square - cube * p_y * c2_y
    h_yz = h1_2 * other_y * other_z + h1_1 * other_yz - cube * p_y * c2_z
    h_yz -= (x2_y + z * x2_yz) * square
    h_zz = h1_2 * other_z * other_z + h1_1 * other_zz - z * x2_zz * square - cube * p_z * c2_z
    h_yy, h_yz, h_zz = 0.5 * h_yy, 0.5 * h_yz, 0.5 * h_zz
    # mean C'
    m = 0.5 * (c1 + c2)
    m_y, m_z = 0.5 * (c1_y + c2_y), 0.5 * (c1_z + c2_z)
    m_yy, m_yz, m_zz = 0.5 * (c1_yy + c2_yy), 0.5 * (c1_yz + c2_yz), 0.5 * (c1_zz + c2_zz)
    # u
    scale = 1.0 / (1.0 + 0.045 * m)
    u = (c2 - c1) * scale
    u_y = (c2_y - c1_y - 0.045 * u * m_y) * scale
    u_z = (c2_z - c1_z - 0.045 * u * m_z) * scale
    u_yy = (c2_yy - c1_yy - 0.045 * (2.0 * u_y * m_y + u * m_yy)) * scale
    u_yz = (c2_yz - c1_yz - 0.045 * (u_y * m_z + u_z * m_y + u * m_yz)) * scale
    u_zz = (c2_zz - c1_zz - 0.045 * (2.0 * u_z * m_z + u * m_zz)) * scale
    # ΔH'
    w = c1 * c2 + x1 * x2 + b * z + TINY
    w_y = c1_y * c2 + c1 * c2_y + a * (s_y * x2 + s * x2_y)
    w_z = c1_z * c2 + c1 * c2_z + a * (s_z * x2 + s * x2_z) + b
    w_yy = c1_yy * c2 + 2.0 * c1_y * c2_y + c1 * c2_yy
    w_yy += a * (s_yy * x2 + 2.0 * s_y * x2_y + s * x2_yy)
    w_yz = c1_yz * c2 + c1_y * c2_z + c1_z * c2_y + c1 * c2_yz
    w_yz += a * (s_yz * x2 + s_y * x2_z + s_z * x2_y + s * x2_yz)
    w_zz = c1_zz * c2 + 2.0 * c1_z * c2_z + c1 * c2_zz
    w_zz += a * (s_zz * x2 + 2.0 * s_z * x2_z + s * x2_zz)
    inverse = 1.0 / w
    w_y, w_z = 0.5 * w_y * inverse, 0.5 * w_z * inverse
    w_yy, w_yz, w_zz = 0.5 * w_yy * inverse, 0.5 * w_yz * inverse, 0.5 * w_zz * inverse
    scale = np.sqrt(2.0 * inverse)
    n = x1 * z - b * x2
    n_y, n_z = a * s_y * z - b * x2_y, a * (s_z * z + s) - b * x2_z
    n_yy, n_yz = a * s_yy * z - b * x2_yy, a * (s_yz * z + s_y) - b * x2_yz
    n_zz = a * (s_zz * z + 2.0 * s_z) - b * x2_zz
    d = n * scale
    d_y, d_z = scale * (n_y - n * w_y), scale * (n_z - n * w_z)
    d_yy = scale * (n_yy - 2.0 * n_y * w_y + n * (3.0 * w_y * w_y - w_yy))
    d_yz = scale * (n_yz - n_y * w_z - n_z * w_y + n * (3.0 * w_y * w_z - w_yz))
    d_zz = scale * (n_zz - 2.0 * n_z * w_z + n * (3.0 * w_z * w_z - w_zz))
    # T
    cosine, sine = x1 * c2 + x2 * c1, b * c2 + z * c1
    length = 1.0 / np.sqrt(cosine * cosine + sine * sine + TINY)
    cosine, sine = cosine * length, sine * length
    double, double_sine = 2.0 * cosine * cosine - 1.0, 2.0 * cosine * sine
    triple = double * cosine - double_sine * sine
    triple_sine = double_sine * cosine + double * sine
    fourfold, fourfold_sine = 2.0 * double * double - 1.0, 2.0 * double * double_sine
    first = 0.17 * (cosine * COS_30 + sine * SIN_30)
    third = 0.32 * (triple * COS_6 - triple_sine * SIN_6)
    fourth = 0.20 * (fourfold * COS_63 + fourfold_sine * SIN_63)
    t = 1.0 - first + 0.24 * double + third - fourth
    t_1 = (
        0.17 * (sine * COS_30 - cosine * SIN_30)
        - 0.48 * double_sine
        - 0.96 * (triple_sine * COS_6 + triple * SIN_6)
        + 0.80 * (fourfold_sine * COS_63 - fourfold * SIN_63)
    )
    t_2 = first - 0.96 * double - 9.0 * third + 16.0 * fourth
    t_y, t_z = t_1 * h_y, t_1 * h_z
    # v
    weight_y, weight_z = 0.015 * (m_y * t + m * t_y), 0.015 * (m_z * t + m * t_z)
    weight_yy = m_yy * t + 2.0 * m_y * t_y + m * (t_1 * h_yy + t_2 * h_y * h_y)
    weight_yz = m_yz * t + m_y * t_z + m_z * t_y + m * (t_1 * h_yz + t_2 * h_y * h_z)
    weight_zz = m_zz * t + 2.0 * m_z * t_z + m * (t_1 * h_zz + t_2 * h_z * h_z)
    scale = 1.0 / (1.0 + 0.015 * m * t)
    v = d * scale
    v_y, v_z = (d_y - v * weight_y) * scale, (d_z - v * weight_z) * scale
    v_yy = (d_yy - 2.0 * v_y * weight_y - 0.015 * v * weight_yy) * scale
    v_yz = (d_yz - v_y * weight_z - v_z * weight_y - 0.015 * v * weight_yz) * scale
    v_zz = (d_zz - 2.0 * v_z * weight_z - 0.015 * v * weight_zz) * scale
    # half of R_T: q of C', z of the hue
    inverse = 1.0 / (m + TINY)
    power = 25.0 * inverse
    power = power * power * power
    power = power * power * 25.0 * inverse
    share = 1.0 / (1.0 + power)
    q = np.sqrt(share)
    q_1 = 3.5 * q * (1.0 - share) * inverse
    q_2 = q_1 * inverse * (2.5 - 10.5 * share)
    r, r_1, r_2 = _rotation_expansion(cosine, sine)
    q_y, q_z, r_y, r_z = q_1 * m_y, q_1 * m_z, r_1 * h_y, r_1 * h_z
    r_yy, r_yz = r_1 * h_yy + r_2 * h_y * h_y, r_1 * h_yz + r_2 * h_y * h_z
    r_zz = r_1 * h_zz + r_2 * h_z * h_z
    r_yy = (q_1 * m_yy + q_2 * m_y * m_y) * r + 2.0 * q_y * r_y + q * r_yy
    r_yz = (q_1 * m_yz + q_2 * m_y * m_z) * r + q_y * r_z + q_z * r_y + q * r_yz
    r_zz = (q_1 * m_zz + q_2 * m_z * m_z) * r + 2.0 * q_z * r_z + q * r_zz
    r_y, r_z, r = q_y * r + q * r_y, q_z * r + q * r_z, q * r

    uv, uv_y, uv_z = u * v, u_y * v + u * v_y, u_z * v + u * v_z
    uv_yy = u_yy * v + 2.0 * u_y * v_y + u * v_yy
    uv_yz = u_yz * v + u_y * v_z + u_z * v_y + u * v_yz
    uv_zz = u_zz * v + 2.0 * u_z * v_z + u * v_zz
    return (
        0.5 * (u * u + v * v) - r * uv,
        u * u_y + v * v_y - r_y * uv - r * uv_y,
        u * u_z + v * v_z - r_z * uv - r * uv_z,
        u_y * u_y + u * u_yy + v_y * v_y + v * v_yy - r_yy * uv - 2.0 * r_y * uv_y - r * uv_yy,
        u_y * u_z
        + u * u_yz
        + v_y * v_z
        + v * v_yz
        - r_yz * uv
        - r_y * uv_z
        - r_z * uv_y
        - r * uv_yz,
        u_z * u_z + u * u_zz + v_z * v_z + v * v_zz - r_zz * uv - 2.0 * r_z * uv_z - r * uv_zz,
        u,
        v,
    )


@inlined_kernel
def _rotation_expansion(cosine: float, sine: float) -> tuple[float, float, float]:
    """Return sin 2Δθ and its derivatives by the mean hue (equations 16 and 19)."""
    toward = cosine * COS_275 + sine * SIN_275
    aside = sine * COS_275 - cosine * SIN_275
    angle = INVERSE_BLUE_WIDTH * arc_tangent(aside, abs(toward))
    power = _exponential(angle * angle)
    turn = ROTATION * power if toward > 0.0 else 0.0
    turn_1 = -2.0 * INVERSE_BLUE_WIDTH * angle * turn
    turn_2 = INVERSE_BLUE_WIDTH * INVERSE_BLUE_WIDTH * (4.0 * angle * angle - 2.0) * turn
    sine = _sine(turn)
    square = turn * turn
    cosine = 1.0 - square * (1.0 / 90.0)
    cosine = 1.0 - square * (1.0 / 56.0) * cosine
    cosine = 1.0 - square * (1.0 / 30.0) * cosine
    cosine = 1.0 - square * (1.0 / 12.0) * cosine
    cosine = 1.0 - square * 0.5 * cosine
    return sine, cosine * turn_1, cosine * turn_2 - sine * turn_1 * turn_1


@inlined_kernel
def steepest_rotation(cosine: float, sine: float, slack: float) -> float:
    """Return an upper bound of sin 2Δθ for hues that differ by up to `slack`."""
    toward = cosine * COS_275 + sine * SIN_275
    aside = abs(sine * COS_275 - cosine * SIN_275)
    # an angle from 0 to 90°, which is not above the difference of the hues
    angle = arc_tangent(aside, toward) if toward > 0.0 else 0.5 * np.pi
    angle = INVERSE_BLUE_WIDTH * max(angle - slack, 0.0)
    return _sine(ROTATION * _exponential(angle * angle)) * (1.0 + ROTATION_ROUNDING)


@inlined_kernel
def arc_tangent(aside: float, toward: float) -> float:
    """Return the angle of a unit vector, within ±90°, with an error of 4e-8.

    Source: M. Abramowitz & I. A. Stegun, "Handbook of Mathematical Functions" (1964), 4.4.49, for
    half of the angle.
    """
    half = aside / (1.0 + toward)
    square = half * half
    angle = 0.0028662257 * square - 0.0161657367
    angle = angle * square + 0.0429096138
    angle = angle * square - 0.0752896400
    angle = angle * square + 0.1065626393
    angle = angle * square - 0.1420889944
    angle = angle * square + 0.1999355085
    angle = angle * square - 0.3333314528
    return 2.0 * half * (angle * square + 1.0)


@inlined_kernel
def _exponential(number: float) -> float:
    """Return exp(−x) for 0 ≤ x ≤ 13: the series at x ÷ 64, to the 64th. Relative error 2e-7."""
    small = number * (-1.0 / 64.0)
    power = 1.0 + small * (1.0 / 6.0)
    power = 1.0 + small * 0.2 * power
    power = 1.0 + small * 0.25 * power
    power = 1.0 + small * (1.0 / 3.0) * power
    power = 1.0 + small * 0.5 * power
    power = 1.0 + small * power
    power *= power
    power *= power
    power *= power
    power *= power
    power *= power
    return power * power


@inlined_kernel
def _sine(turn: float) -> float:
    """Return the sine of an angle from 0 to 60°, by its series."""
    square = turn * turn
    sine = 1.0 - square * (1.0 / 110.0)
    sine = 1.0 - square * (1.0 / 72.0) * sine
    sine = 1.0 - square * (1.0 / 42.0) * sine
    sine = 1.0 - square * (1.0 / 20.0) * sine
    return turn * (1.0 - square * (1.0 / 6.0) * sine)
