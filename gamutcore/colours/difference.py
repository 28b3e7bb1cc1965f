"""The colour difference CIEDE2000 of two colours in CIELAB, with its derivatives.

Source: G. Sharma, W. Wu & E. N. Dalal, "The CIEDE2000 color-difference formula: Implementation
notes, supplementary test data, and mathematical observations", Color Research & Application 30
(2005), equations 2 to 22, with all parametric factors 1.

Hues are unit vectors in place of angles. The mean hue is then the direction between two vectors,
and cosines of its multiples are polynomials. Hues beyond 360° need no case.

The formula is written once, for jets: a number with its first and second derivatives by two
variables (A. Griewank & A. Walther, "Evaluating Derivatives" (2008), chapter 13). Where only the
value is used, the compiler leaves the derivatives out. Half the square of ΔE00 is smooth where
ΔE00 is 0. It has no derivatives where the second colour is neutral, or where hues are opposite.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

__all__ = [
    "BLUE_WIDTH",
    "COS_275",
    "ROTATION",
    "SIN_275",
    "Jet",
    "chroma_and_hue",
    "ciede2000",
    "ciede2000_of_pairs",
    "composed",
    "half_square",
    "half_square_without_lightness",
    "half_squared",
    "lightness_term",
    "plus",
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

TINY = 1e-30
"""Keeps divisors from 0."""


@kernel
def ciede2000_of_pairs(one: FloatArray, two: FloatArray) -> FloatArray:
    """Return ΔE00 (n,) of pairs of colours (n, 3)."""
    difference = np.empty(len(one))
    for row in range(len(one)):
        difference[row] = ciede2000(
            one[row, 0], one[row, 1], one[row, 2], two[row, 0], two[row, 1], two[row, 2]
        )
    return difference


@leaf_kernel
def ciede2000(l1: float, a1: float, b1: float, l2: float, a2: float, b2: float) -> float:
    """Return ΔE00 of two colours in CIELAB."""
    light = lightness_term(l1, l2)[0]
    u, v, root, _, cosine, sine = chroma_and_hue(a1, b1, a2, b2)
    rotation = -2.0 * root[0] * _hue_rotation(cosine, sine)[0]
    square = light * light + u[0] * u[0] + v[0] * v[0] + rotation * u[0] * v[0]
    return float(np.sqrt(max(square, 0.0)))


@leaf_kernel
def half_square(
    l1: float, a1: float, b1: float, l2: float, a2: float, b2: float
) -> tuple[Jet, Jet, Jet, Jet]:
    """Return terms of ½ ΔE00², a jet by L* (its first variable), and one by a* and b*.

    u = ΔC' ÷ S_C and v = ΔH' ÷ S_H follow.
    """
    light = lightness_term(l1, l2)
    u, v, root, hue, cosine, sine = chroma_and_hue(a1, b1, a2, b2)
    turn = _hue_rotation(cosine, sine)
    chroma = half_square_without_lightness(u, v, root, composed(hue, turn[0], turn[1], turn[2]))
    return half_squared(light), chroma, u, v


Jet = tuple[float, float, float, float, float, float]
"""A number, and its derivatives by y, z, yy, yz and zz."""


@inlined_kernel
def plus(p: Jet, q: Jet) -> Jet:
    """Return the sum of two jets."""
    return p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3], p[4] + q[4], p[5] + q[5]


@inlined_kernel
def _shifted(p: Jet, number: float) -> Jet:
    return p[0] + number, p[1], p[2], p[3], p[4], p[5]


@inlined_kernel
def _scaled(p: Jet, factor: float) -> Jet:
    return (
        factor * p[0],
        factor * p[1],
        factor * p[2],
        factor * p[3],
        factor * p[4],
        factor * p[5],
    )


@inlined_kernel
def _times(p: Jet, q: Jet) -> Jet:
    return (
        p[0] * q[0],
        p[1] * q[0] + p[0] * q[1],
        p[2] * q[0] + p[0] * q[2],
        p[3] * q[0] + 2.0 * p[1] * q[1] + p[0] * q[3],
        p[4] * q[0] + p[1] * q[2] + p[2] * q[1] + p[0] * q[4],
        p[5] * q[0] + 2.0 * p[2] * q[2] + p[0] * q[5],
    )


@inlined_kernel
def _divided(p: Jet, q: Jet) -> Jet:
    share, value = 1.0 / q[0], p[0] / q[0]
    y, z = share * (p[1] - value * q[1]), share * (p[2] - value * q[2])
    return (
        value,
        y,
        z,
        share * (p[3] - 2.0 * y * q[1] - value * q[3]),
        share * (p[4] - y * q[2] - z * q[1] - value * q[4]),
        share * (p[5] - 2.0 * z * q[2] - value * q[5]),
    )


@inlined_kernel
def composed(p: Jet, value: float, first: float, second: float) -> Jet:
    """Return f(p), given f and its derivatives at the value of p."""
    return (
        value,
        first * p[1],
        first * p[2],
        first * p[3] + second * p[1] * p[1],
        first * p[4] + second * p[1] * p[2],
        first * p[5] + second * p[2] * p[2],
    )


@inlined_kernel
def _square_root(p: Jet) -> Jet:
    root = np.sqrt(p[0])
    first = 0.5 / root
    return composed(p, root, first, -0.5 * first / p[0])


@inlined_kernel
def half_squared(p: Jet) -> Jet:
    """Return ½ p²."""
    return _scaled(_times(p, p), 0.5)


@inlined_kernel
def lightness_term(l1: float, l2: float) -> Jet:
    """Return ΔL' ÷ S_L, a jet by the second lightness."""
    second = l2, 1.0, 0.0, 0.0, 0.0, 0.0
    middle = _shifted(_scaled(_shifted(second, l1), 0.5), -50.0)
    middle = _times(middle, middle)
    weight = _divided(_scaled(middle, 0.015), _square_root(_shifted(middle, 20.0)))
    return _divided(_shifted(second, -l1), _shifted(weight, 1.0))


@inlined_kernel
def chroma_and_hue(
    a1: float, b1: float, a2: float, b2: float
) -> tuple[Jet, Jet, Jet, Jet, float, float]:
    """Return terms of ΔE00 as jets by a* and b* of the second colour.

    They are u = ΔC' ÷ S_C, v = ΔH' ÷ S_H, R_C ÷ 2, and the mean hue, whose value is left out. The
    cosine and the sine of the mean hue follow.
    """
    second_a, second_b = (a2, 1.0, 0.0, 0.0, 0.0, 0.0), (b2, 0.0, 1.0, 0.0, 0.0, 0.0)
    square = plus(_times(second_a, second_a), _times(second_b, second_b))
    chroma = _square_root(_shifted(square, TINY))
    chroma = _scaled(_shifted(chroma, np.sqrt(a1 * a1 + b1 * b1)), 0.5)
    stretch = _shifted(_scaled(_saturation(chroma), -0.5), 1.5)  # 1 + G
    x1, x2 = _scaled(stretch, a1), _times(stretch, second_a)
    c1 = _square_root(_shifted(_times(x1, x1), b1 * b1 + TINY))
    c2 = _square_root(_shifted(plus(_times(x2, x2), _times(second_b, second_b)), TINY))
    mean = _scaled(plus(c1, c2), 0.5)
    # unit vectors of the hues; a neutral colour takes the hue of the other one
    unit_x1, unit_y1 = _divided(x1, c1), _divided((b1, 0.0, 0.0, 0.0, 0.0, 0.0), c1)
    unit_x2, unit_y2 = _divided(x2, c2), _divided(second_b, c2)
    h1 = plus(_scaled(unit_y1, unit_x1[0]), _scaled(unit_x1, -unit_y1[0]))
    h2 = plus(_scaled(unit_y2, unit_x2[0]), _scaled(unit_x2, -unit_y2[0]))
    u1, v1, u2, v2 = unit_x1[0], unit_y1[0], unit_x2[0], unit_y2[0]
    neutral_1, neutral_2 = (u1 == 0.0) & (v1 == 0.0), (u2 == 0.0) & (v2 == 0.0)
    u2, v2 = (u1, v1) if neutral_2 else (u2, v2)
    u1, v1 = (u2, v2) if neutral_1 else (u1, v1)
    cosine, sine, half_cosine, double_half_sine = _mean_hue(u1, v1, u2, v2)
    hue, turn = _scaled(plus(h1, h2), 0.5), plus(h2, _scaled(h1, -1.0))
    d_hue = composed(turn, double_half_sine, half_cosine, -0.25 * double_half_sine)
    d_hue = _times(_square_root(_times(c1, c2)), d_hue)

    t, t_1, t_2 = _hue_weight(cosine, sine)
    weight = composed(hue, t, t_1, t_2)
    u = _divided(plus(c2, _scaled(c1, -1.0)), _shifted(_scaled(mean, 0.045), 1.0))
    v = _divided(d_hue, _shifted(_times(_scaled(mean, 0.015), weight), 1.0))
    return u, v, _saturation(mean), hue, cosine, sine


@inlined_kernel
def half_square_without_lightness(u: Jet, v: Jet, root: Jet, turn: Jet) -> Jet:
    """Return ½ (u² + v² + R_T u v), where `turn` is sin 2Δθ."""
    both = _scaled(plus(_times(u, u), _times(v, v)), 0.5)
    return plus(both, _scaled(_times(_times(root, turn), _times(u, v)), -1.0))


@inlined_kernel
def _saturation(chroma: Jet) -> Jet:
    """Return √(C⁷ ÷ (C⁷ + 25⁷))."""
    square = chroma[0] * chroma[0]
    seventh = square * square * square * chroma[0]
    share = seventh / (seventh + SEVENTH) if seventh < 1e300 else 1.0
    root = np.sqrt(share)
    inverse = 1.0 / chroma[0]
    first = 3.5 * root * (1.0 - share) * inverse
    return composed(chroma, root, first, first * inverse * (2.5 - 10.5 * share))


@inlined_kernel
def _mean_hue(u1: float, v1: float, u2: float, v2: float) -> tuple[float, float, float, float]:
    """Return cosine and sine of the mean of two hues, then cos (Δh ÷ 2) and 2 sin (Δh ÷ 2)."""
    across = u1 * v2 - v1 * u2
    along = u1 * u2 + v1 * v2
    sine = np.sqrt((u2 - u1) ** 2 + (v2 - v1) ** 2)
    half_cosine = 0.5 * np.sqrt((u2 + u1) ** 2 + (v2 + v1) ** 2)
    first_is_larger = (v1 < 0.0) | ((v1 == 0.0) & (u1 < 0.0))  # if hues are opposite
    # nearly opposite: the sum of the vectors is inaccurate
    turned_x, turned_y = v2 - v1, u1 - u2
    side = turned_x * (u1 + u2) + turned_y * (v1 + v2)
    # exactly opposite: a quarter turn from the smaller angle
    sign = -1.0 if (side < 0.0) | ((side == 0.0) & first_is_larger) else 1.0
    x = sign * turned_x if along < 0.0 else u1 + u2
    y = sign * turned_y if along < 0.0 else v1 + v2
    length = np.sqrt(x * x + y * y)
    has_hue = length > 0.0
    x, y = (x / length if has_hue else 1.0), (y / length if has_hue else 0.0)
    negative = (across < 0.0) | ((across == 0.0) & (along < 0.0) & first_is_larger)
    return x, y, half_cosine, -sine if negative else sine


@inlined_kernel
def _hue_weight(cosine: float, sine: float) -> tuple[float, float, float]:
    """Return T for a mean hue (equation 15), and two derivatives by the hue."""
    double, double_sine = 2.0 * cosine * cosine - 1.0, 2.0 * cosine * sine
    triple = double * cosine - double_sine * sine
    triple_sine = double_sine * cosine + double * sine
    fourfold, fourfold_sine = 2.0 * double * double - 1.0, 2.0 * double * double_sine
    first = 0.17 * (cosine * COS_30 + sine * SIN_30)
    third = 0.32 * (triple * COS_6 - triple_sine * SIN_6)
    fourth = 0.20 * (fourfold * COS_63 + fourfold_sine * SIN_63)
    slope = 0.17 * (sine * COS_30 - cosine * SIN_30) - 0.48 * double_sine
    slope -= 0.96 * (triple_sine * COS_6 + triple * SIN_6)
    slope += 0.80 * (fourfold_sine * COS_63 - fourfold * SIN_63)
    bend = first - 0.96 * double - 9.0 * third + 16.0 * fourth
    return (1.0 + 0.24 * double - fourth) + (third - first), slope, bend


@leaf_kernel
def _hue_rotation(cosine: float, sine: float) -> tuple[float, float, float]:
    """Return sin 2Δθ for a mean hue (equations 16 and 19), and two derivatives by the hue."""
    if sine >= 0.0 and cosine >= COS_95:
        return 0.0, 0.0, 0.0
    angle = np.arctan2(cosine * SIN_275 - sine * COS_275, cosine * COS_275 + sine * SIN_275)
    share = -angle / BLUE_WIDTH
    turn = ROTATION * np.exp(-share * share)
    first = -2.0 * share * turn / BLUE_WIDTH
    second = (4.0 * share * share - 2.0) * turn / (BLUE_WIDTH * BLUE_WIDTH)
    value, slope = np.sin(turn), np.cos(turn)
    return value, slope * first, slope * second - value * first * first
