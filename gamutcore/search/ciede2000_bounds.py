"""Lower bounds of ΔE00 for the children of a node, or for triangles, several at once.

Around the middle c of a part of the surface, half of the square of ΔE00 is at least

    F + g · d + ½ d · H d − M |d|³ − ε F,    d = x − c,

with the value F, the gradient g and the matrix H of second derivatives at c
(`gamutcore.search.ciede2000`). M limits the third-order remainder, and ε covers rounding. No
expansion exists at the neutral axis, nor where a part meets the opposite hue. M has no proof. It
was found as an upper limit on millions of random pairs, and tests repeat the measurement on other
pairs.

A second bound, proved, is for the box of lightness, chroma and hue around a part. The larger of
both applies. It follows from equations 2 to 22 of Sharma, Wu & Dalal. With u = ΔC' ÷ S_C and v =
ΔH' ÷ S_H:

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

from gamutcore.arrays import FloatArray
from gamutcore.kernels import inlined_kernel, leaf_kernel
from gamutcore.search.ciede2000 import (
    CHROMA,
    COS_275,
    SIN_275,
    A,
    B,
    L,
    arc_tangent,
    chroma_expansion,
    hue_factors,
    lightness_expansion,
    steepest_rotation,
)
from gamutcore.search.face_tree import ROUNDING, FaceTree

__all__ = ["BOUND", "ESTIMATE", "MIDDLE", "is_blue", "set_node_bounds", "set_triangle_bounds"]

BOUND, MIDDLE, ESTIMATE = range(3)
"""Figures of a part: the lower bound of half the square of ΔE00, the value in the middle, and an
estimate of the minimum. Arrays have eight numbers for each."""

LEAST_CHROMA = 1.0
"""Parts with a lower chroma have no expansion."""

THIRD = 1.0 / 3.0

TINY = 1e-18
"""Keeps divisors from 0. It is below the rounding errors of colours that are not neutral."""

SHAPE = 8
"""Numbers of a part: its middle; least and largest L*; least and largest C*; and the largest
difference of hues from that of the middle."""

RELATIVE = 3e-5
"""ε: bound of the relative error of the half square. Equation 16 jumps by nearly 1e-5 at hue 0."""


@leaf_kernel
def set_node_bounds(
    colour: FloatArray,
    centre: FloatArray,
    tree: FaceTree,
    node: int,
    bounds: FloatArray,
    shape: FloatArray,
    known: FloatArray,
) -> None:
    """Set `bounds` (24,) to lower bounds of half the square of ΔE00 for the children of a node.

    The second eight numbers are the half squares at the middles, infinite without a child; the
    third eight stay. The colour (4,) is L*, a*, b*, C*. `shape` (64,) and `known` (88,) are work
    arrays.
    """
    cylinders = tree.cylinders
    size = 1.0 / tree.scale
    row = np.uint64(node)
    for each in range(cylinders.shape[1] // 8):
        at = np.uint64(each)
        x = centre[0] + size * cylinders[row, at]
        y = centre[1] + size * cylinders[row, at + np.uint64(8)]
        z = centre[2] + size * cylinders[row, at + np.uint64(16)]
        nx = float(cylinders[row, at + np.uint64(24)])
        ny = float(cylinders[row, at + np.uint64(32)])
        nz = float(cylinders[row, at + np.uint64(40)])
        wide = size * cylinders[row, at + np.uint64(48)]
        thick = size * cylinders[row, at + np.uint64(56)]
        tall = _reach(nx, wide, thick)
        other = np.sqrt(y * y + z * z)
        inverse = 1.0 / max(other, 1e-9)
        out = _reach((ny * y + nz * z) * inverse, wide, thick)
        aside = _reach((nz * y - ny * z) * inverse, wide, thick)
        shape[at], shape[at + np.uint64(8)], shape[at + np.uint64(16)] = x, y, z
        shape[at + np.uint64(24)] = x - tall
        shape[at + np.uint64(32)] = x + tall
        shape[at + np.uint64(40)] = other - out
        shape[at + np.uint64(48)] = np.sqrt((other + out) ** 2 + aside * aside)
        shape[at + np.uint64(56)] = _turn(aside, other - out)
    _set_expansions(colour, shape, known)
    a, b, own = colour[A], colour[B], colour[CHROMA]
    inverse_own = 1.0 / max(own, 1e-9)
    for each in range(cylinders.shape[1] // 8):
        at = np.uint64(each)
        x, y, z = shape[at], shape[at + np.uint64(8)], shape[at + np.uint64(16)]
        nx = float(cylinders[row, at + np.uint64(24)])
        ny = float(cylinders[row, at + np.uint64(32)])
        nz = float(cylinders[row, at + np.uint64(40)])
        wide = size * cylinders[row, at + np.uint64(48)]
        thick = size * cylinders[row, at + np.uint64(56)]
        value, gx = known[at], known[at + np.uint64(8)]
        gy, gz = known[at + np.uint64(16)], known[at + np.uint64(24)]
        hxx, hyy = known[at + np.uint64(32)], known[at + np.uint64(40)]
        hyz, hzz = known[at + np.uint64(48)], known[at + np.uint64(56)]
        turned = (a * y + b * z) * inverse_own
        turned -= _reach((a * ny + b * nz) * inverse_own, wide, thick)
        beside = abs(a * z - b * y) * inverse_own
        beside -= _reach((a * nz - b * ny) * inverse_own, wide, thick)
        radius = np.sqrt(wide * wide + thick * thick)
        tall = shape[at + np.uint64(32)] - x
        error = known[at + np.uint64(64)] * tall * tall * tall
        error += known[at + np.uint64(72)] * radius * radius * radius
        along = gx * nx + gy * ny + gz * nz
        across = np.sqrt(max(gx * gx + gy * gy + gz * gz - along * along, 0.0))
        half = 0.5 * (hyy - hzz)
        bend = min(0.5 * (hyy + hzz) - np.sqrt(half * half + hyz * hyz), hxx)
        reach = across / bend if bend * wide > across else wide
        low = value * (1.0 - RELATIVE) - reach * (across - 0.5 * bend * reach) - thick * abs(along)
        low += 0.5 * min(bend, 0.0) * thick * thick - error
        expanded = shape[at + np.uint64(40)] > LEAST_CHROMA
        expanded &= (turned >= 0.0) | (beside > 0.0)
        other_low = known[at + np.uint64(80)]
        bounds[at] = low if expanded & (low > other_low) else other_low
        bounds[at + np.uint64(8)] = value if wide >= 0.0 else np.inf


@inlined_kernel
def _reach(cosine: float, wide: float, thick: float) -> float:
    """Return the extent of a cylinder in a direction, given the cosine of its angle to the axis."""
    return wide * np.sqrt(max(1.0 - cosine * cosine, 0.0) + ROUNDING) + thick * abs(cosine)


@leaf_kernel
def set_triangle_bounds(
    colour: FloatArray,
    corners: FloatArray,
    bounds: FloatArray,
    shape: FloatArray,
    known: FloatArray,
) -> None:
    """Set `bounds` (24,) to lower bounds of half the square of ΔE00 for eight triangles.

    The second eight numbers are the half squares at the centroids. The third eight estimate the
    minima from the polynomials, or repeat the second without an expansion. `corners` (72,) has
    eight numbers for each of L*, a*, b* of the first corners, then of the second and third.
    `colour` and the work arrays are as for `set_node_bounds`.
    """
    for each in range(len(corners) // 9):
        at = np.uint64(each)
        px, py = corners[at], corners[at + np.uint64(8)]
        pz, qx = corners[at + np.uint64(16)], corners[at + np.uint64(24)]
        qy, qz = corners[at + np.uint64(32)], corners[at + np.uint64(40)]
        rx, ry = corners[at + np.uint64(48)], corners[at + np.uint64(56)]
        rz = corners[at + np.uint64(64)]
        y, z = (py + qy + ry) * THIRD, (pz + qz + rz) * THIRD
        inverse = 1.0 / max(np.sqrt(y * y + z * z), 1e-9)
        least = min(py * y + pz * z, qy * y + qz * z, ry * y + rz * z) * inverse
        aside = max(abs(pz * y - py * z), abs(qz * y - qy * z), abs(rz * y - ry * z)) * inverse
        shape[at] = (px + qx + rx) * THIRD
        shape[at + np.uint64(8)] = y
        shape[at + np.uint64(16)] = z
        shape[at + np.uint64(24)] = min(px, qx, rx)
        shape[at + np.uint64(32)] = max(px, qx, rx)
        shape[at + np.uint64(40)] = least
        shape[at + np.uint64(48)] = np.sqrt(
            max(py * py + pz * pz, qy * qy + qz * qz, ry * ry + rz * rz)
        )
        shape[at + np.uint64(56)] = _turn(aside, least)
    _set_expansions(colour, shape, known)
    a, b = colour[A], colour[B]
    for each in range(len(corners) // 9):
        at = np.uint64(each)
        x, y, z = shape[at], shape[at + np.uint64(8)], shape[at + np.uint64(16)]
        value, gx = known[at], known[at + np.uint64(8)]
        gy, gz = known[at + np.uint64(16)], known[at + np.uint64(24)]
        hxx, hyy = known[at + np.uint64(32)], known[at + np.uint64(40)]
        hyz, hzz = known[at + np.uint64(48)], known[at + np.uint64(56)]
        px, py = corners[at], corners[at + np.uint64(8)]
        pz, qx = corners[at + np.uint64(16)], corners[at + np.uint64(24)]
        qy, qz = corners[at + np.uint64(32)], corners[at + np.uint64(40)]
        rx, ry = corners[at + np.uint64(48)], corners[at + np.uint64(56)]
        rz = corners[at + np.uint64(64)]
        turned = min(a * py + b * pz, a * qy + b * qz, a * ry + b * rz)
        p, q, r = a * pz - b * py, a * qz - b * qy, a * rz - b * ry
        beside = max(min(p, q, r), -max(p, q, r))
        px, py, pz = px - x, py - y, pz - z
        qx, qy, qz = qx - x, qy - y, qz - z
        rx, ry, rz = rx - x, ry - y, rz - z
        tall = max(abs(px), abs(qx), abs(rx))
        square = max(py * py + pz * pz, qy * qy + qz * qz, ry * ry + rz * rz)
        error = known[at + np.uint64(64)] * tall * tall * tall
        error += known[at + np.uint64(72)] * square * np.sqrt(square)
        half = 0.5 * (hyy - hzz)
        bend = min(0.5 * (hyy + hzz) - np.sqrt(half * half + hyz * hyz), hxx, 0.0)
        # the tangent in the middle
        p = gx * px + gy * py + gz * pz
        q = gx * qx + gy * qy + gz * qz
        r = gx * rx + gy * ry + gz * rz
        first = min(p, q, r) + 0.5 * bend * (tall * tall + square)
        # the tangent where the polynomial is least towards the corner that is lowest on the first
        lowest, second = p <= min(q, r), q <= r
        dx = px if lowest else (qx if second else rx)
        dy = py if lowest else (qy if second else ry)
        dz = pz if lowest else (qz if second else rz)
        hx, hy, hz = hxx * dx, hyy * dy + hyz * dz, hyz * dy + hzz * dz
        down, up = -min(p, q, r), hx * dx + hy * dy + hz * dz
        share = down / up if up > down else 1.0
        hx, hy, hz = share * hx, share * hy, share * hz
        p += hx * px + hy * py + hz * pz
        q += hx * qx + hy * qy + hz * qz
        r += hx * rx + hy * ry + hz * rz
        second_low = min(p, q, r) - 0.5 * share * share * up + 2.0 * bend * (tall * tall + square)
        estimate = value + max(first, second_low)
        low = estimate - value * RELATIVE - error
        expanded = (shape[at + np.uint64(40)] > LEAST_CHROMA) & ((turned >= 0.0) | (beside > 0.0))
        other_low = known[at + np.uint64(80)]
        bounds[at] = low if expanded & (low > other_low) else other_low
        bounds[at + np.uint64(8)] = value
        bounds[at + np.uint64(16)] = estimate if expanded else value


@inlined_kernel
def _turn(aside: float, along: float) -> float:
    """Return the angle of a vector, at most a quarter turn, rounded up slightly."""
    length = 1.0 / np.sqrt(aside * aside + along * along + TINY)
    angle = arc_tangent(aside * length, along * length) + 1e-7
    return angle if along > 0.0 else np.pi


@leaf_kernel
def _set_expansions(colour: FloatArray, shape: FloatArray, known: FloatArray) -> None:
    """Set `known` of eight parts: F, gradient, H (four numbers), both M, and the interval bound."""
    l, a, b, own = colour[L], colour[A], colour[B], colour[CHROMA]  # noqa: E741
    # a loop whose length the compiler knows is unrolled first, and then not vectorised
    for each in range(len(shape) // SHAPE):
        at = np.uint64(each)
        x, y, z = shape[at], shape[at + np.uint64(8)], shape[at + np.uint64(16)]
        dark, bright = shape[at + np.uint64(24)], shape[at + np.uint64(32)]
        least, most = shape[at + np.uint64(40)], shape[at + np.uint64(48)]
        turn = shape[at + np.uint64(56)]
        f, gy, gz, hyy, hyz, hzz, u, v = chroma_expansion(a, b, own, y, z)
        light, gx, hxx = lightness_expansion(l, x)
        by_lightness, by_chroma = _remainder(
            0.5 * (l + x),
            light,
            0.5 * max(bright - x, x - dark),
            u,
            v,
            max(least, 1e-3),
            is_blue(a + y, b + z),
        )
        known[at] = light + f
        known[at + np.uint64(8)] = gx
        known[at + np.uint64(16)] = gy
        known[at + np.uint64(24)] = gz
        known[at + np.uint64(32)] = hxx
        known[at + np.uint64(40)] = hyy
        known[at + np.uint64(48)] = hyz
        known[at + np.uint64(56)] = hzz
        known[at + np.uint64(64)] = by_lightness
        known[at + np.uint64(72)] = by_chroma
        known[at + np.uint64(80)] = _interval_bound(
            l, a, b, own, dark, bright, y, z, max(least, 0.0), most, turn
        )


@inlined_kernel
def _remainder(
    middle: float,
    away: float,
    half: float,
    u: float,
    v: float,
    chroma: float,
    blue: bool,
) -> tuple[float, float]:
    """Return M for differences in lightness, and for differences in a* and b*.

    `middle` is the mean lightness of the colour and the middle of the part. At the middle, `away`
    is half the square of ΔL' ÷ S_L, `u` is ΔC' ÷ S_C and `v` is ΔH' ÷ S_H. `half` is half the
    largest difference in lightness from the middle of the part, `chroma` the least C* on the way to
    any of its points. `blue` states whether R_T counts (`is_blue`).
    """
    far = max(abs(middle - 50.0) - half, 0.0)
    steep = far * far * (1.0 / 6.25)
    by_lightness = 0.009 + away * (1.5e-5 + 2.8e-4 / (1.0 + steep * steep))
    share = 1.0 / chroma
    square = share * share
    along, across = abs(u), v * v
    first, second, third = (20.0, 3.0, 0.06) if blue else (13.5, 0.34, 0.014)
    cube, most = (200.0, 2.5) if blue else (60.0, 0.7)
    flat = (first + second * along + third * across) * (1.0 + min(cube * square * share, most))
    return by_lightness, 0.06 * share + square * (flat + 1.1 * along * across * square)


@inlined_kernel
def is_blue(a: float, b: float) -> bool:
    """Whether the hue of a mean colour is between 215° and 330°, where R_T counts."""
    return (b < 0.0) & (a > 1.43 * b) & (a < -1.73 * b)


STEEPNESS = 0.17 + 2.0 * 0.24 + 3.0 * 0.32 + 4.0 * 0.20
"""Bound of the derivative of T."""

LARGEST_T = 1.573
"""T is at most 1.5725, at 234°."""


@inlined_kernel
def _interval_bound(
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
    """Return 1 + G without overflow or branches (equation 4)."""
    share = 25.0 / (chroma + TINY)
    power = share * share * share
    return 1.5 - 0.5 / np.sqrt(1.0 + power * power * share)
