"""CIEDE2000 with its first and second derivatives, without branches.

The functions compute half of the square of ΔE00, which is smooth where ΔE00 is 0. They have no
branches and no library calls, so that the compiler evaluates several colours at once.

The steps follow equations 2 to 22 (see `colour_difference`). ΔH' is written without half angles, as
in `ciede2000_slope`. Suffixes of names state the variables of differentiation: y is a* and z is b*
of the second colour. Quantities of its chroma alone are differentiated by the chroma first, with
the suffixes 1 and 2.
"""

from __future__ import annotations

import numpy as np

from gamutcore.kernels import inlined_kernel
from gamutcore.queries.colour_difference import (
    COS_6,
    COS_30,
    COS_63,
    COS_275,
    ROTATION,
    SIN_6,
    SIN_30,
    SIN_63,
    SIN_275,
    WIDTH,
)

__all__ = [
    "Expansion",
    "arc_tangent",
    "chroma_expansion",
    "lightness_expansion",
    "steepest_rotation",
]

TINY = 1e-18
"""Keeps divisors from 0. Derivatives have no meaning where it matters."""

INVERSE_WIDTH = 1.0 / WIDTH

ROUNDING = 1e-6
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
    angle = INVERSE_WIDTH * arc_tangent(aside, abs(toward))
    power = _exponential(angle * angle)
    turn = ROTATION * power if toward > 0.0 else 0.0
    turn_1 = -2.0 * INVERSE_WIDTH * angle * turn
    turn_2 = INVERSE_WIDTH * INVERSE_WIDTH * (4.0 * angle * angle - 2.0) * turn
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
    angle = INVERSE_WIDTH * max(angle - slack, 0.0)
    return _sine(ROTATION * _exponential(angle * angle)) * (1.0 + ROUNDING)


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
