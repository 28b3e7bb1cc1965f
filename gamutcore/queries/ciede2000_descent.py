"""The point of a triangle with the smallest ΔE00 to a colour, by descent.

Gauss–Newton steps minimise a quadratic approximation of the square on the triangle. The gradients
teach the contribution of the residuals' second derivatives (symmetric rank-one updates; J. Nocedal
& S. J. Wright, "Numerical Optimization" (2006), section 6.2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, LongArray
from gamutcore.kernels import leaf_kernel
from gamutcore.queries.ciede2000_parts import is_blue
from gamutcore.queries.ciede2000_slope import CHROMA, A, B, set_slope

__all__ = ["CLIFF", "TOLERANCE", "Work", "descend", "has_one_minimum"]

TOLERANCE = 1e-7
"""Parts that could be better by less than this are skipped."""

CLIFF = 0.1
"""Radius of the smallest parts, at opposite hues, where ΔE00 is not continuous."""

CONVEX, CONVEX_BLUE, CONVEX_OTHER, WIDE = 8.0, 12.0, 25.0, 16.0
"""Descent from the centroid of a triangle finds the minimum if the minimum is at most CONVEX. Where
hues are not opposite and the radius is at most WIDE, the limit is CONVEX_BLUE, or CONVEX_OTHER
away from blue. None of 240,000 random triangles with radii from 2 to 16 failed."""

SMALL = 2.0
"""Radius below which interpolation looks for the minimum on a part of a face."""

STEPS = 30
"""Gauss–Newton steps; 3 to 5 are usual."""


class Work(NamedTuple):
    """Work arrays of a search.

    Attributes
    ----------
    colour : (4,) float64
        L*, a*, b*, C* of the colour.
    corners : (9,) float64
        First corner of a face and the two sides from it.
    slope : (10,) float64
        See `set_slope`.
    best : (5,) float64
        ΔE00 and weights of the best point, the relative improvement a better point needs, and the
        number of divisions.
    triangles, found, shape, expansions : (72,), (24,), (64,), (88,) float64
        See `set_triangle_bounds`.
    nodes : (STACK,) int64
        Stack of nodes, and of faces f as ~f.
    known : (STACK, 3) float64
        Bounds of each entry, as in `found`.
    parts : (PARTS, 6) float64
        Stack of the parts of a face.
    waiting : (8, 3) float64
        Parts without bounds yet.
    """

    colour: FloatArray
    corners: FloatArray
    slope: FloatArray
    best: FloatArray
    triangles: FloatArray
    found: FloatArray
    shape: FloatArray
    expansions: FloatArray
    nodes: LongArray
    known: FloatArray
    parts: FloatArray
    waiting: FloatArray


@leaf_kernel
def has_one_minimum(colour: FloatArray, y: float, z: float, radius: float, value: float) -> bool:
    """Whether descent in a triangle finds its minimum, given that the minimum is below `value`."""
    if value <= CONVEX or radius <= CLIFF:
        return True
    if is_blue(colour[A] + y, colour[B] + z):
        wide = WIDE if value <= CONVEX_BLUE else SMALL
    else:
        wide = WIDE if value <= CONVEX_OTHER else 2.0 * SMALL
    return radius <= wide and not _meets_cliff(colour, y, z, radius)


@leaf_kernel
def descend(work: Work, u: float, v: float, side: float) -> bool:
    """Descend by Gauss–Newton steps on a part of a face; return whether the best has improved.

    `work.slope` has the derivatives in the middle of the part.
    """
    colour, corners, slope, best = work.colour, work.corners, work.slope, work.best
    bx, by, bz = side * corners[3], side * corners[4], side * corners[5]
    cx, cy, cz = side * corners[6], side * corners[7], side * corners[8]
    x0 = corners[0] + u * corners[3] + v * corners[6]
    y0 = corners[1] + u * corners[4] + v * corners[7]
    z0 = corners[2] + u * corners[5] + v * corners[8]
    s = t = 1.0 / 3.0
    value = slope[9]
    improved = False
    # what the second derivatives of the residuals add to the matrix, learnt from the gradients
    more_ss = more_st = more_tt = 0.0
    step_s = step_t = old_ds = old_dt = 0.0
    secant = False
    for _ in range(STEPS):
        ds = slope[0] * bx + slope[1] * by + slope[2] * bz
        dt = slope[0] * cx + slope[1] * cy + slope[2] * cz
        ls, lt = slope[3] * bx, slope[3] * cx
        us, ut = slope[4] * by + slope[5] * bz, slope[4] * cy + slope[5] * cz
        vs, vt = slope[6] * by + slope[7] * bz, slope[6] * cy + slope[7] * cz
        rotation = slope[8]
        ss = ls * ls + us * us + vs * vs + rotation * us * vs
        st = ls * lt + us * ut + vs * vt + 0.5 * rotation * (us * vt + ut * vs)
        tt = lt * lt + ut * ut + vt * vt + rotation * ut * vt
        ss, st, tt = ss + more_ss, st + more_st, tt + more_tt
        if secant:
            error_s = ds - old_ds - ss * step_s - st * step_t
            error_t = dt - old_dt - st * step_s - tt * step_t
            along = error_s * step_s + error_t * step_t
            size = np.sqrt(
                (error_s * error_s + error_t * error_t) * (step_s * step_s + step_t * step_t)
            )
            if abs(along) > 1e-3 * size:
                more_ss, ss = more_ss + error_s * error_s / along, ss + error_s * error_s / along
                more_st, st = more_st + error_s * error_t / along, st + error_s * error_t / along
                more_tt, tt = more_tt + error_t * error_t / along, tt + error_t * error_t / along
        to_s, to_t = _lowest(ds - ss * s - st * t, dt - st * s - tt * t, 0.5 * ss, st, 0.5 * tt)
        to_s, to_t = to_s - s, to_t - t
        gain = -(ds * to_s + dt * to_t + 0.5 * (ss * to_s + st * to_t) * to_s)
        gain -= 0.5 * (st * to_s + tt * to_t) * to_t
        if gain <= 0.1 * TOLERANCE * value:
            break
        share, other = 1.0, np.inf
        while share > 1e-4:
            at_s, at_t = s + share * to_s, t + share * to_t
            other = set_slope(
                colour,
                x0 + at_s * bx + at_t * cx,
                y0 + at_s * by + at_t * cy,
                z0 + at_s * bz + at_t * cz,
                slope,
            )
            if other < value:
                break
            share *= 0.25
        if not other < value:
            if not secant:
                break
            # start again from here without what was learnt
            more_ss = more_st = more_tt = 0.0
            secant = False
            set_slope(
                colour, x0 + s * bx + t * cx, y0 + s * by + t * cy, z0 + s * bz + t * cz, slope
            )
            continue
        secant = True
        step_s, step_t, old_ds, old_dt = at_s - s, at_t - t, ds, dt
        s, t, value = at_s, at_t, other
        if value < best[0]:
            best[0], best[1], best[2] = value, u + side * s, v + side * t
            improved = True
    return improved


@leaf_kernel
def _lowest(ds: float, dt: float, ss: float, st: float, tt: float) -> tuple[float, float]:
    """Return the minimum of ds s + dt t + ss s² + st s t + tt t² for s, t ≥ 0 and s + t ≤ 1."""
    determinant = 4.0 * ss * tt - st * st
    if determinant > 0.0 and ss > 0.0:
        s, t = (st * dt - 2.0 * tt * ds) / determinant, (st * ds - 2.0 * ss * dt) / determinant
        if s >= 0.0 and t >= 0.0 and s + t <= 1.0:
            return s, t
    s, least = _lowest_on_edge(ds, ss)
    t = 0.0
    other, value = _lowest_on_edge(dt, tt)
    if value < least:
        s, t, least = 0.0, other, value
    # from (1, 0) to (0, 1)
    other, value = _lowest_on_edge(dt - ds - 2.0 * ss + st, ss - st + tt)
    if value + ds + ss < least:
        s, t = 1.0 - other, other
    return s, t


@leaf_kernel
def _lowest_on_edge(slope: float, bend: float) -> tuple[float, float]:
    """Return the t from 0 to 1 at which slope t + bend t² is least, and the value there."""
    place = 1.0 if slope + bend < 0.0 else 0.0
    if bend > 0.0:
        place = min(max(-0.5 * slope / bend, 0.0), 1.0)
    return place, place * (slope + bend * place)


@leaf_kernel
def _meets_cliff(colour: FloatArray, y: float, z: float, radius: float) -> bool:
    """Whether a circle in the a*–b* plane meets the hue opposite to that of a colour."""
    a, b, away = colour[A], colour[B], radius * colour[CHROMA]
    return a * y + b * z <= away and abs(a * z - b * y) < away
