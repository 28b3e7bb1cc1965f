"""Nearest by CIEDE2000: the point of a level's surface with the smallest ΔE00 to a colour.

A branch and bound over the tree of faces finds the global minimum. Nodes, faces and parts of faces
are skipped where a lower bound of ΔE00 (`gamutcore.search.ciede2000_bounds`) is above the smallest
value so far. Eight bounds are computed at once. Where a part may hold the minimum, descent finds
it. Other parts are divided until their bounds exclude them.

Descent minimises a quadratic approximation of the square on a triangle by Gauss–Newton steps. The
gradients teach the contribution of the residuals' second derivatives (symmetric rank-one updates;
J. Nocedal & S. J. Wright, "Numerical Optimization" (2006), section 6.2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.geometry import Vector, curve_order, face_corners, minus, write_row
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel
from gamutcore.search.ciede2000 import CHROMA, SLOPE, A, B, L, ciede2000, delta_e_2000, set_slope
from gamutcore.search.ciede2000_bounds import (
    BOUND,
    ESTIMATE,
    MIDDLE,
    is_blue,
    set_node_bounds,
    set_triangle_bounds,
)
from gamutcore.search.face_tree import STACK, WIDTH
from gamutcore.search.index import Level, LevelIndex, as_index, checked_points, surface_points
from gamutcore.search.nearest import SurfacePoints

__all__ = ["nearest_ciede2000"]

PARTS = 256
"""Capacity for parts of a face: six for each halving, from 1e10 to `CLIFF` units."""

MEDIUM = 2.0
"""From this radius on, descent starts in a part only if its middle is better than the best."""

ORDINARY, FLAT = 1000.0, 1e-3
"""Beyond this magnitude of coordinates, where the formula is nearly constant, the difference is
within this share of the smallest."""

MOST = 50_000
"""Most divisions for one colour; a thousand are many for a gamut of colours. Beyond, each part gets
one descent."""

STEP = 1e-6
"""Distance of points beside a discontinuity ÷ the length of an edge that crosses it."""


def nearest_ciede2000(points: ArrayLike, level: Level) -> SurfacePoints:
    """Find the points of a level's surface with the smallest ΔE00.

    Parameters
    ----------
    points : (n, 3) array_like
        CIELAB.
    level : LevelIndex or (vertices, faces, centre)
        In CIELAB.

    Returns
    -------
    SurfacePoints
        `distance` is the colour difference CIEDE2000, within 1e-6 of the smallest. It is within
        0.1 where the nearest point has the opposite hue: the formula is not continuous there. For
        coordinates beyond 1,000 it is within 0.1 %.

    Raises
    ------
    InvalidPointsError
        A point is not three finite numbers; ``where["row"]`` names it.

    Examples
    --------
    >>> corners = np.array([(0, 0, 0), (60, 60, 0), (60, -30, 50), (60, -30, -50), (100, 0, 0)])
    >>> ring = [(1, 2), (2, 3), (3, 1)]
    >>> faces = [(0, two, one) for one, two in ring] + [(4, one, two) for one, two in ring]
    >>> surface = nearest_ciede2000([(110, 0, 0)], (corners, faces, (60, 0, 0)))
    >>> surface.points.round(3).tolist(), surface.distance.round(4).tolist()
    ([[100.0, 0.0, 0.0]], [5.4876])
    """
    colours, index = checked_points(points), as_index(level)
    faces, weights = _nearest(colours, index)
    surface = surface_points(index, faces, weights)
    return SurfacePoints(surface, delta_e_2000(colours, surface), faces, weights)


class _SearchWorkspace(NamedTuple):
    """Work arrays of a search.

    `best` has ΔE00 and weights of the best point, the relative improvement that a better point
    needs, and the number of divisions. For `triangles`, `bounds`, `shape` and `expansions` see
    `set_triangle_bounds`.
    """

    colour: FloatArray  # (4,) L*, a*, b*, C* of the colour
    corners: FloatArray  # (9,) first corner of a face and the two sides from it
    slope: FloatArray  # (10,) as `set_slope` sets
    best: FloatArray  # (5,)
    triangles: FloatArray  # (72,)
    bounds: FloatArray  # (24,)
    shape: FloatArray  # (64,)
    expansions: FloatArray  # (88,)
    nodes: LongArray  # (STACK,) stack of nodes, and of faces f as ~f
    known: FloatArray  # (STACK, 3) bounds of each entry, as in `bounds`
    parts: FloatArray  # (PARTS, 6) stack of the parts of a face
    waiting: FloatArray  # (8, 3) parts without bounds yet


@kernel
def _nearest(points: FloatArray, index: LevelIndex) -> tuple[IndexArray, FloatArray]:
    """Return the face and the barycentric coordinates of each nearest point."""
    faces, weights = np.empty(len(points), np.int32), np.empty((len(points), 3))
    work = _SearchWorkspace(
        np.empty(4),
        np.empty(9),
        np.empty(SLOPE),
        np.empty(5),
        np.zeros(9 * WIDTH),
        np.empty(3 * WIDTH),
        np.empty(8 * WIDTH),
        np.empty(11 * WIDTH),
        np.empty(STACK, np.int64),
        np.empty((STACK, 3)),
        np.empty((PARTS, 6)),
        np.empty((WIDTH, 3)),
    )
    colour, best = work.colour, work.best
    best[1] = best[2] = 1.0 / 3.0
    reach = np.abs(index.box).max()
    face = 0
    for number in curve_order(points):
        for axis in range(3):
            colour[axis] = points[number, axis]
        colour[CHROMA] = np.sqrt(colour[A] ** 2 + colour[B] ** 2)
        far = max(reach, abs(colour[L]), colour[CHROMA]) > ORDINARY
        best[3], best[4] = FLAT if far else 0.0, 0.0
        face = _search(index, face, work)
        u, v = best[1], best[2]
        faces[number] = face
        write_row(weights, number, 0, (max(1.0 - u - v, 0.0), u, v))
    return faces, weights


@leaf_kernel
def _search(index: LevelIndex, start: int, work: _SearchWorkspace) -> int:
    """Find the face, and set `work.best`, from the weights of the best in the face `start`."""
    tree, colour, best, bounds = index.tree, work.colour, work.best, work.bounds
    nodes, known = work.nodes, work.known
    face = start
    _set_corners(index, face, work.corners)
    best[0] = _difference(work, best[1], best[2])
    nodes[0], known[0, BOUND] = 0, 0.0
    height = 1
    while height > 0:
        height -= 1
        limit = _limit(best)
        if known[height, BOUND] >= limit:
            continue
        node = nodes[height]
        if node < 0:
            if _search_face(index, ~node, known[height, BOUND], known[height, ESTIMATE], work):
                face = ~node
            continue
        first = tree.first[node]
        if first < 0:
            _set_leaf(index, ~first, work.triangles)
            set_triangle_bounds(colour, work.triangles, bounds, work.shape, work.expansions)
        else:
            set_node_bounds(colour, index.centre, tree, node, bounds, work.shape, work.expansions)
        bottom = height
        for at in range(WIDTH if first >= 0 else min(WIDTH, len(tree.faces) - ~first)):
            middle = bounds[MIDDLE * WIDTH + at]
            if bounds[at] < limit and middle < np.inf:  # keep the nearest middle on top
                place = height
                while place > bottom and known[place - 1, MIDDLE] < middle:
                    nodes[place] = nodes[place - 1]
                    for item in range(3):
                        known[place, item] = known[place - 1, item]
                    place -= 1
                nodes[place] = first + at if first >= 0 else ~np.int64(tree.faces[~first + at])
                for item in range(3):
                    known[place, item] = bounds[item * WIDTH + at]
                height += 1
    return face


@inlined_kernel
def _limit(best: FloatArray) -> float:
    """Return the half square of ΔE00 above which parts are skipped."""
    least = max(best[0] * (1.0 - best[3]) - TOLERANCE, 0.0)
    return 0.5 * least * least


@leaf_kernel
def _difference(work: _SearchWorkspace, u: float, v: float) -> float:
    """Return ΔE00 between the colour and a point of the face in `work.corners`."""
    colour, corners = work.colour, work.corners
    return ciede2000(
        colour[L],
        colour[A],
        colour[B],
        corners[0] + u * corners[3] + v * corners[6],
        corners[1] + u * corners[4] + v * corners[7],
        corners[2] + u * corners[5] + v * corners[8],
    )


@inlined_kernel
def _set_leaf(index: LevelIndex, first: int, triangles: FloatArray) -> None:
    """Set the corners of the faces of a leaf. The first face fills places without a face."""
    faces = index.tree.faces
    for at in range(WIDTH):
        face = faces[first + at if first + at < len(faces) else first]
        for corner in range(3):
            vertex = index.faces[face, corner]
            for axis in range(3):
                triangles[(3 * corner + axis) * WIDTH + at] = index.vertices[vertex, axis]


@inlined_kernel
def _search_face(
    index: LevelIndex, face: int, bound: float, estimate: float, work: _SearchWorkspace
) -> bool:
    """Replace the best if a point of a face is better; return whether the best was replaced."""
    colour, slope, parts, best, bounds = (
        work.colour,
        work.slope,
        work.parts,
        work.best,
        work.bounds,
    )
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = _set_corners(index, face, work.corners)
    # the distances of the corners from the centroid, three times as long
    long = (bx + cx) ** 2 + (by + cy) ** 2 + (bz + cz) ** 2
    long = max(long, (2.0 * bx - cx) ** 2 + (2.0 * by - cy) ** 2 + (2.0 * bz - cz) ** 2)
    long = max(long, (2.0 * cx - bx) ** 2 + (2.0 * cy - by) ** 2 + (2.0 * cz - bz) ** 2)
    whole = np.sqrt(long) / 3.0
    improved = False
    # known of a part, then the corner of the right angle and the side, in coordinates u and v
    parts[0, BOUND], parts[0, MIDDLE], parts[0, ESTIMATE] = bound, 0.0, estimate
    parts[0, 3], parts[0, 4], parts[0, 5] = 0.0, 0.0, 1.0
    height, waiting = 1, 0
    while height > 0 or waiting > 0:
        if height > 0:
            height -= 1
            limit = _limit(best)
            if parts[height, BOUND] >= limit:
                continue
            u, v, side = parts[height, 3], parts[height, 4], parts[height, 5]
            radius = abs(side) * whole
            middle_u, middle_v = u + side / 3.0, v + side / 3.0
            x = ax + middle_u * bx + middle_v * cx
            y = ay + middle_u * by + middle_v * cy
            z = az + middle_u * bz + middle_v * cz
            value = best[0]
            if radius <= CLIFF and _search_cliff(work, u, v, side):
                improved = improved or best[0] < value
                continue
            promising = parts[height, ESTIMATE] < limit
            promising &= (radius <= MEDIUM) | (parts[height, MIDDLE] < limit)
            # a gamut far larger than any of colours is not divided to the end
            hurried = best[4] >= MOST or height + WIDTH > PARTS
            if hurried or (
                (promising or radius <= CLIFF) and _has_one_minimum(colour, y, z, radius, best[0])
            ):
                value = set_slope(colour, x, y, z, slope)
                if value < best[0]:
                    best[0], best[1], best[2] = value, middle_u, middle_v
                    improved = True
                improved = _descend(work, u, v, side) or improved
                continue
            best[4] += 1.0
            _divide(work, u, v, side, 4 * waiting)
            waiting += 1
            if waiting < 2 and height > 0:
                continue
        # eight bounds at once are those of two divided parts
        set_triangle_bounds(colour, work.triangles, bounds, work.shape, work.expansions)
        limit = _limit(best)
        for part in range(4 * waiting):
            if bounds[part] < limit:
                for item in range(3):
                    parts[height, item] = bounds[item * WIDTH + part]
                    parts[height, 3 + item] = work.waiting[part, item]
                height += 1
        waiting = 0
    return improved


@inlined_kernel
def _divide(work: _SearchWorkspace, u: float, v: float, side: float, first: int) -> None:
    """Divide a part into four, and write them from the index `first` on."""
    corners, triangles, half = work.corners, work.triangles, 0.5 * side
    for part in range(4):
        p = u + half if part == 1 or part == 3 else u
        q = v + half if part >= 2 else v
        step = -half if part == 3 else half
        at = first + part
        work.waiting[at, 0], work.waiting[at, 1], work.waiting[at, 2] = p, q, step
        for axis in range(3):
            b, c = corners[3 + axis], corners[6 + axis]
            place = corners[axis] + p * b + q * c
            triangles[axis * WIDTH + at] = place
            triangles[(3 + axis) * WIDTH + at] = place + step * b
            triangles[(6 + axis) * WIDTH + at] = place + step * c


@leaf_kernel
def _search_cliff(work: _SearchWorkspace, u: float, v: float, side: float) -> bool:
    """Try points of a part beside the opposite hue; return whether the part has that hue.

    ΔE00 is not continuous there. The points are on the edges that cross the hue, on both sides.
    """
    colour, corners, best = work.colour, work.corners, work.best
    meets = False
    for edge in range(3):
        p = u + side if edge == 1 else u
        q = v + side if edge == 2 else v
        to_p = u + side if edge == 0 else u
        to_q = v + side if edge == 1 else v
        y = corners[1] + p * corners[4] + q * corners[7]
        z = corners[2] + p * corners[5] + q * corners[8]
        to_y = corners[1] + to_p * corners[4] + to_q * corners[7]
        to_z = corners[2] + to_p * corners[5] + to_q * corners[8]
        here, there = colour[A] * z - colour[B] * y, colour[A] * to_z - colour[B] * to_y
        if (here < 0.0) == (there < 0.0):
            continue
        share = here / (here - there)
        y, z = y + share * (to_y - y), z + share * (to_z - z)
        if colour[A] * y + colour[B] * z >= 0.0:
            continue
        meets = True
        for step in (-STEP, STEP):
            at = min(max(share + step, 0.0), 1.0)
            at_u, at_v = p + at * (to_p - p), q + at * (to_q - q)
            value = _difference(work, at_u, at_v)
            if value < best[0]:
                best[0], best[1], best[2] = value, at_u, at_v
    return meets


@leaf_kernel
def _set_corners(
    index: LevelIndex, face: int, corners: FloatArray
) -> tuple[Vector, Vector, Vector]:
    """Set the first corner of a face and the two sides from it, and return them."""
    a, b, c = face_corners(index.vertices, index.faces, face)
    b, c = minus(b, a), minus(c, a)
    for axis in range(3):
        corners[axis], corners[3 + axis], corners[6 + axis] = a[axis], b[axis], c[axis]
    return a, b, c


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


@leaf_kernel
def _has_one_minimum(colour: FloatArray, y: float, z: float, radius: float, value: float) -> bool:
    """Whether descent in a triangle finds its minimum, given that the minimum is below `value`."""
    if value <= CONVEX or radius <= CLIFF:
        return True
    if is_blue(colour[A] + y, colour[B] + z):
        wide = WIDE if value <= CONVEX_BLUE else SMALL
    else:
        wide = WIDE if value <= CONVEX_OTHER else 2.0 * SMALL
    return radius <= wide and not _meets_cliff(colour, y, z, radius)


@leaf_kernel
def _descend(work: _SearchWorkspace, u: float, v: float, side: float) -> bool:
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
