"""Nearest by CIEDE2000: the point of a level's surface with the smallest ΔE00 to a colour.

A branch and bound goes down the tree of faces, nearest middle first. Nodes, faces and parts of
faces are skipped where a lower bound of F = ½ ΔE00² is above the smallest value so far. A face that
meets the hue opposite to that of the colour, where F is not continuous, is cut there. Newton steps
find the minimum in a part of a face. A part that may have several minima is divided into four.

**Proved** is a bound for the box of lightness, chroma and hue around a part. With u = ΔC' ÷ S_C and
v = ΔH' ÷ S_H, equations 2 to 22 of Sharma, Wu & Dalal give

    2 F ≥ (ΔL' ÷ S_L)² + min (u² + v² − R |u v|).

- |ΔL'|, |ΔC'| and |ΔH'| have their smallest values in the box; S_L, S_C, S_H and R = |R_T| have
  their largest. The minimum is over all u and v not smaller than these bounds. T is at most 1.5725.
- G falls with the mean chroma. Its largest and smallest value bound both C'.
- ΔH' = 2 √(C'₁ C'₂) sin (Δh ÷ 2). A factor of 1 + G grows differences in hue by no more than
  itself. Hues turn by no more than half of a change of G.
- R falls with the distance of the mean hue from 275°. The mean of nearly opposite hues is near one
  of two normals.

**Measured** is a closer bound around the middle c of a part. With d = x − c,

    F ≥ F(c) + g · d + ½ d · H d − M |d|³ − ε F(c),

with the gradient g and the matrix H of second derivatives (`gamutcore.colours.difference`). M
limits the third-order remainder, and ε covers rounding. M was found as an upper limit on millions
of random pairs, and tests repeat the measurement on other pairs. The bound does not hold near the
neutral axis, nor for nodes that meet the opposite hue.

**Tested** only is that Newton steps find the minimum (`_has_one_minimum`), by brute force.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.colours.difference import (
    BLUE_WIDTH,
    COS_275,
    ROTATION,
    SIN_275,
    Jet,
    chroma_and_hue,
    ciede2000,
    ciede2000_of_pairs,
    composed,
    half_square,
    half_square_without_lightness,
    half_squared,
    lightness_term,
    plus,
)
from gamutcore.errors import InvalidPointsError
from gamutcore.geometry import curve_order
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel
from gamutcore.queries.face_tree import ROUNDING, STACK, WIDTH
from gamutcore.queries.index import Level, LevelIndex, as_index, checked_points
from gamutcore.queries.nearest import SurfacePoints

__all__ = ["delta_e_2000", "nearest_ciede2000"]

TOLERANCE = 1e-7
"""Parts that could be better by less than this are skipped."""

ORDINARY, FLAT = 1000.0, 1e-3
"""Beyond this magnitude of coordinates, where the formula is nearly constant, the difference is
within this share of the smallest."""

MOST = 50_000
"""Most divisions for one colour; a thousand are many for a gamut of colours. Beyond, each part gets
one descent."""

ENTRIES = STACK + 256
"""Capacity for nodes and parts: three more parts for each halving, from 1e10 to `CLIFF` units."""


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
    return ciede2000_of_pairs(first, second)


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
    MeshError
        As for `build_index`.

    Examples
    --------
    >>> corners = np.array([(0, 0, 0), (60, 60, 0), (60, -30, 50), (60, -30, -50), (100, 0, 0)])
    >>> ring = [(1, 2), (2, 3), (3, 1)]
    >>> faces = [(0, two, one) for one, two in ring] + [(4, one, two) for one, two in ring]
    >>> found = nearest_ciede2000([(110, 0, 0)], (corners, faces, (60, 0, 0)))
    >>> found.points.round(3).tolist(), found.distance.round(4).tolist()
    ([[100.0, 0.0, 0.0]], [5.4876])
    """
    return SurfacePoints(*_nearest(checked_points(points), as_index(level)))


class _Search(NamedTuple):
    """Arrays of a search."""

    colour: FloatArray  # (3,) L*, a*, b*
    best: FloatArray  # (3,) ΔE00, and the weights of the second and the third corner
    corners: FloatArray  # (9,) first corner of a face, and the two sides from it
    items: LongArray  # (ENTRIES,) stack of nodes, and of faces f as ~f
    known: FloatArray  # (ENTRIES, 9) figures of the items
    parts: FloatArray  # (4, 6) weights u and v of the corners of parts of a face
    cylinders: FloatArray  # (8, 8) their parts as in a node of the tree, in units of colour
    found: FloatArray  # (2, 8) lower bounds of F, and F in the middles


THIRD = 1.0 / 3.0

TINY = 1e-18
"""Keeps divisors from 0. It is below the rounding errors of colours that are not neutral."""

BOUND, MIDDLE, IS_PART, CORNERS = range(4)
"""Figures of an item: bound and middle as in `found`; whether a face was cut or divided; and from
there on u and v of three corners."""


@kernel
def _nearest(
    points: FloatArray, index: LevelIndex
) -> tuple[FloatArray, FloatArray, IndexArray, FloatArray]:
    vertices = index.vertices
    count = len(points)
    found, weights = np.empty((count, 3)), np.empty((count, 3))
    distance = np.empty(count)
    faces = np.empty(count, np.int32)
    search = _Search(
        np.empty(3),
        np.full(3, 1.0 / 3.0),
        np.empty(9),
        np.empty(ENTRIES, np.int64),
        np.empty((ENTRIES, 9)),
        np.zeros((4, 6)),
        np.zeros((8, WIDTH)),
        np.empty((2, WIDTH)),
    )
    reach = np.abs(index.box).max()
    face = 0
    for row in curve_order(points):
        l, a, b = points[row, 0], points[row, 1], points[row, 2]  # noqa: E741
        search.colour[0], search.colour[1], search.colour[2] = l, a, b
        far = max(reach, abs(l), np.sqrt(a * a + b * b)) > ORDINARY
        face = _nearest_face(index, face, 1.0 - FLAT if far else 1.0, search)
        one, two, three = index.faces[face, 0], index.faces[face, 1], index.faces[face, 2]
        u, v = search.best[1], search.best[2]
        w = max(1.0 - u - v, 0.0)
        for axis in range(3):
            found[row, axis] = (
                w * vertices[one, axis] + u * vertices[two, axis] + v * vertices[three, axis]
            )
        distance[row] = ciede2000(l, a, b, found[row, 0], found[row, 1], found[row, 2])
        faces[row] = face
        weights[row, 0], weights[row, 1], weights[row, 2] = w, u, v
    return found, distance, faces, weights


@leaf_kernel
def _nearest_face(index: LevelIndex, start: int, share: float, search: _Search) -> int:
    """Find the face, and set `search.best`, from the weights of the best in the face `start`.

    What is not better than the best times `share` may be skipped.
    """
    tree, best, found = index.tree, search.best, search.found
    items, known, parts = search.items, search.known, search.parts
    face = start
    _set_corners(index, face, search.corners)
    x, y, z = _position(search.corners, best[1], best[2])
    best[0] = ciede2000(search.colour[0], search.colour[1], search.colour[2], x, y, z)
    items[0], known[0, BOUND] = 0, 0.0
    height, divisions = 1, 0
    # a loop whose length the compiler knows is unrolled first, and then not vectorised
    lanes = np.uint64(tree.cylinders.shape[1] // 8)
    while height > 0:
        height -= 1
        item, count = items[height], WIDTH
        limit = _limit(best[0], share)
        if known[height, BOUND] >= limit:
            continue
        if item >= 0:
            _set_cylinders(index, item, search.cylinders)
            set_bounds(search.colour, search.cylinders, lanes, found)
        else:
            _set_corners(index, ~item, search.corners)
            count = 0 if known[height, IS_PART] > 0.0 else _cut(search)
            if count == 0:
                sides = _sides(search.corners, known, height, CORNERS)
                hurried = divisions >= MOST or height + WIDTH > ENTRIES
                if hurried or _has_one_minimum(search, sides):
                    face = ~item if _descend(search, height, sides) else face
                    continue
                count = _divide(search, height)
            divisions += 1
            for at in range(count):
                sides = _sides(search.corners, parts, at, 0)
                found[0, at], found[1, at] = part_bound(search.colour, sides)
        bottom, limit = height, _limit(best[0], share)
        for at in range(count):
            if found[0, at] < limit and found[1, at] < np.inf:
                _push(index, item, at, bottom, height, search)
                height += 1
    return face


@inlined_kernel
def _limit(best: float, share: float) -> float:
    """Return the F from which on parts are skipped."""
    least = max(best * share - TOLERANCE, 0.0)
    return 0.5 * least * least


@inlined_kernel
def _push(index: LevelIndex, item: int, at: int, bottom: int, height: int, search: _Search) -> None:
    """Insert a part of an item into the stack above `bottom`, with the nearest middle on top."""
    tree, items, known, found = index.tree, search.items, search.known, search.found
    place = height
    while place > bottom and known[place - 1, MIDDLE] < found[1, at]:
        items[place] = items[place - 1]
        for figure in range(9):
            known[place, figure] = known[place - 1, figure]
        place -= 1
    known[place, BOUND], known[place, MIDDLE] = found[0, at], found[1, at]
    if item < 0:
        items[place], known[place, IS_PART] = item, 1.0
        for figure in range(6):
            known[place, CORNERS + figure] = search.parts[at, figure]
    else:
        first = tree.first[item]
        items[place] = first + at if first >= 0 else ~np.int64(tree.faces[~first + at])
        known[place, IS_PART] = 0.0
        for figure in range(6):  # (0, 0), (1, 0) and (0, 1)
            known[place, CORNERS + figure] = 1.0 if figure == 2 or figure == 5 else 0.0


@leaf_kernel
def _set_corners(index: LevelIndex, face: int, corners: FloatArray) -> None:
    """Set the first corner of a face and the two sides from it."""
    vertices = index.vertices
    one, two, three = index.faces[face, 0], index.faces[face, 1], index.faces[face, 2]
    for axis in range(3):
        corners[axis] = vertices[one, axis]
        corners[3 + axis] = vertices[two, axis] - vertices[one, axis]
        corners[6 + axis] = vertices[three, axis] - vertices[one, axis]


@inlined_kernel
def _position(corners: FloatArray, u: float, v: float) -> tuple[float, float, float]:
    """Return the point of a face at two weights."""
    return (
        corners[0] + u * corners[3] + v * corners[6],
        corners[1] + u * corners[4] + v * corners[7],
        corners[2] + u * corners[5] + v * corners[8],
    )


@inlined_kernel
def _set_cylinders(index: LevelIndex, node: int, cylinders: FloatArray) -> None:
    """Set the cylinders of the children of a node."""
    tree, centre = index.tree, index.centre
    row, size = np.uint64(node), 1.0 / tree.scale
    for part in range(8):
        for at in range(WIDTH):
            value = float(tree.cylinders[row, part * WIDTH + at])
            if part < 3:
                value = centre[part] + size * value
            cylinders[part, at] = size * value if part >= 6 else value


BESIDE = 1e-8
"""Distance of a cut from the opposite hue ÷ the distance of a corner."""


@leaf_kernel
def _cut(search: _Search) -> int:
    """Cut a face along the hue opposite to that of the colour, where F is not continuous.

    Return the number of the parts, 0 if the face does not meet this hue.
    """
    colour, corners, parts = search.colour, search.corners, search.parts
    a, b = colour[1], colour[2]
    p = a * corners[2] - b * corners[1]
    q = p + a * corners[5] - b * corners[4]
    r = p + a * corners[8] - b * corners[7]
    alone_p, alone_q = (q < 0.0) == (r < 0.0), (p < 0.0) == (r < 0.0)
    if alone_p and alone_q:
        return 0
    # the corner that is alone on its side, then the others
    first = 0 if alone_p else (1 if alone_q else 2)
    p, q, r = (p, q, r) if first == 0 else ((q, r, p) if first == 1 else (r, p, q))
    u0, v0 = (1.0 if first == 1 else 0.0), (1.0 if first == 2 else 0.0)
    u1, v1 = (1.0 if first == 0 else 0.0), (1.0 if first == 1 else 0.0)
    u2, v2 = 1.0 - u0 - u1, 1.0 - v0 - v1
    to_1, to_2 = p / (p - q), p / (p - r)
    _, y, z = _position(corners, u0 + to_1 * (u1 - u0), v0 + to_1 * (v1 - v0))
    _, s, t = _position(corners, u0 + to_2 * (u2 - u0), v0 + to_2 * (v2 - v0))
    if a * y + b * z >= 0.0 and a * s + b * t >= 0.0:
        return 0
    for axis in range(2):
        p, q, r = (u0, u1, u2) if axis == 0 else (v0, v1, v2)
        near_1, near_2 = (1.0 - BESIDE) * to_1, (1.0 - BESIDE) * to_2
        far_1, far_2 = min((1.0 + BESIDE) * to_1, 1.0), min((1.0 + BESIDE) * to_2, 1.0)
        parts[0, axis] = p
        parts[0, 2 + axis] = p + near_1 * (q - p)
        parts[0, 4 + axis] = p + near_2 * (r - p)
        parts[1, axis] = parts[2, axis] = p + far_1 * (q - p)
        parts[1, 2 + axis] = q
        parts[1, 4 + axis] = parts[2, 2 + axis] = r
        parts[2, 4 + axis] = p + far_2 * (r - p)
    return 3


@leaf_kernel
def _divide(search: _Search, place: int) -> int:
    """Divide a part of a face into four."""
    known, parts = search.known, search.parts
    for axis in range(2):
        p, q = known[place, CORNERS + axis], known[place, CORNERS + 2 + axis]
        r = known[place, CORNERS + 4 + axis]
        parts[0, axis], parts[1, axis], parts[2, axis] = p, q, r
        parts[0, 2 + axis] = parts[1, 4 + axis] = parts[3, axis] = 0.5 * (p + q)
        parts[1, 2 + axis] = parts[2, 4 + axis] = parts[3, 2 + axis] = 0.5 * (q + r)
        parts[2, 2 + axis] = parts[0, 4 + axis] = parts[3, 4 + axis] = 0.5 * (r + p)
    return 4


CERTAIN, LIKELY, WIDE, WIDE_BLUE = 12.0, 25.0, 16.0, 8.0
"""Descent is taken to find the minimum of a part if the minimum is at most CERTAIN. Otherwise the
radius must be at most WIDE, or WIDE_BLUE where R_T counts. Beyond LIKELY, it must be at most the
chroma of the middle as well. Of random triangles at these limits one in 5,000 fails; of those as
wide as their chroma, up to LIKELY, one in 500."""

CLIFF = 0.1
"""Radius of the smallest parts near the neutral axis."""

STEPS = 30
"""Newton steps; 2 to 4 are usual."""


Sides = tuple[float, float, float, float, float, float, float, float, float]
"""A corner of a part of a face, and the two sides from it."""


@inlined_kernel
def _sides(corners: FloatArray, table: FloatArray, row: int, first: int) -> Sides:
    """Return a corner of a part, and the two sides from it, given the weights in a table."""
    x, y, z = _position(corners, table[row, first], table[row, first + 1])
    p, q, r = _position(corners, table[row, first + 2], table[row, first + 3])
    s, t, u = _position(corners, table[row, first + 4], table[row, first + 5])
    return x, y, z, p - x, q - y, r - z, s - x, t - y, u - z


@inlined_kernel
def _radius(sides: Sides) -> float:
    """Return the largest distance of a corner of a part from its middle."""
    _, _, _, bx, by, bz, cx, cy, cz = sides
    one = (bx + cx) ** 2 + (by + cy) ** 2 + (bz + cz) ** 2
    two = (2.0 * bx - cx) ** 2 + (2.0 * by - cy) ** 2 + (2.0 * bz - cz) ** 2
    three = (2.0 * cx - bx) ** 2 + (2.0 * cy - by) ** 2 + (2.0 * cz - bz) ** 2
    return THIRD * np.sqrt(max(one, two, three))


@inlined_kernel
def _point(sides: Sides, s: float, t: float) -> tuple[float, float, float]:
    """Return the point of a part at the weights of its second and third corner."""
    x, y, z, bx, by, bz, cx, cy, cz = sides
    return x + s * bx + t * cx, y + s * by + t * cy, z + s * bz + t * cz


@inlined_kernel
def _has_one_minimum(search: _Search, sides: Sides) -> bool:
    """Whether descent in a part finds its minimum, if the minimum is better than the best."""
    _, y, z = _point(sides, THIRD, THIRD)
    wide = WIDE_BLUE if _is_blue(search.colour[1] + y, search.colour[2] + z) else WIDE
    if search.best[0] > LIKELY:
        wide = min(wide, max(np.sqrt(y * y + z * z), CLIFF))
    return search.best[0] <= CERTAIN or _radius(sides) <= wide


@inlined_kernel
def _step(light: Jet, chroma: Jet, sides: Sides, s: float, t: float) -> tuple[float, float, float]:
    """Return the weights where an expansion of F is least in a part, and the F gained there."""
    _, _, _, bx, by, bz, cx, cy, cz = sides
    _, gy, gz, hyy, hyz, hzz = chroma
    gx, hxx = light[1], light[3]
    ds, dt = gx * bx + gy * by + gz * bz, gx * cx + gy * cy + gz * cz
    hx, hy, hz = hxx * bx, hyy * by + hyz * bz, hyz * by + hzz * bz
    ss, st = hx * bx + hy * by + hz * bz, hx * cx + hy * cy + hz * cz
    tt = hxx * cx * cx + hyy * cy * cy + 2.0 * hyz * cy * cz + hzz * cz * cz
    p, q = _lowest(ds - ss * s - st * t, dt - st * s - tt * t, 0.5 * ss, st, 0.5 * tt)
    u, v = p - s, q - t
    return p, q, -ds * u - dt * v - 0.5 * (ss * u * u + tt * v * v) - st * u * v


@leaf_kernel
def part_bound(colour: FloatArray, sides: Sides) -> tuple[float, float]:
    """Return a lower bound of F in a part of a face, and F in its middle.

    The part does not meet the opposite hue. The measured bound is closer than that of a cylinder.
    """
    l, a, b = colour[0], colour[1], colour[2]  # noqa: E741
    x, y, z = _point(sides, THIRD, THIRD)
    radius, other = _radius(sides), np.sqrt(y * y + z * z)
    least, p, q = other - radius, sides[3], sides[6]
    light, chroma, u, v = half_square(l, a, b, x, y, z)
    value = light[0] + chroma[0]
    if least > LEAST_CHROMA:
        tall = THIRD * max(abs(p + q), abs(2.0 * p - q), abs(2.0 * q - p))
        is_blue = _is_blue(a + y, b + z)
        bound = value * (1.0 - RELATIVE) - _step(light, chroma, sides, THIRD, THIRD)[2]
        bound -= _remainder(0.5 * (l + x), light[0], tall, u[0], v[0], least, radius, is_blue)
        return bound, value
    low, high = sides[0] + min(p, q, 0.0), sides[0] + max(p, q, 0.0)
    own, turn = np.sqrt(a * a + b * b), _turn(radius, least)
    least = max(least, 0.0)
    return _interval_bound(l, a, b, own, low, high, y, z, least, other + radius, turn), value


@leaf_kernel
def _descend(search: _Search, place: int, sides: Sides) -> bool:
    """Replace the best if Newton steps in a part of a face find a better point.

    They start at the best of the corners and the middle. Return whether the best was replaced.
    """
    l, a, b = search.colour[0], search.colour[1], search.colour[2]  # noqa: E741
    best, known = search.best, search.known
    at_s, at_t, least = THIRD, THIRD, np.sqrt(2.0 * known[place, MIDDLE])
    for corner in range(3):
        p, q = (1.0 if corner == 1 else 0.0), (1.0 if corner == 2 else 0.0)
        x, y, z = _point(sides, p, q)
        value = ciede2000(l, a, b, x, y, z)
        if value < least:
            least, at_s, at_t = value, p, q
    s, t, to_s, to_t = at_s, at_t, at_s, at_t
    least, share, limit = np.inf, 1.0, 0.5 * best[0] * best[0]
    for _ in range(STEPS):
        x, y, z = _point(sides, at_s, at_t)
        light, chroma, _, _ = half_square(l, a, b, x, y, z)
        value = light[0] + chroma[0]
        if value < least:
            least, s, t, share = value, at_s, at_t, 1.0
            to_s, to_t, gain = _step(light, chroma, sides, s, t)
            # also where even three times the gain is not enough
            if not gain > max(0.2 * TOLERANCE * np.sqrt(value), (value - limit) * THIRD):
                break
        else:
            share *= 0.25
            if share < 1e-4:
                break
        at_s, at_t = s + share * (to_s - s), t + share * (to_t - t)
    value = np.sqrt(2.0 * max(least, 0.0))
    if not value < best[0]:
        return False
    best[0] = value
    for axis in range(2):
        p = known[place, CORNERS + axis]
        q, r = known[place, CORNERS + 2 + axis], known[place, CORNERS + 4 + axis]
        best[1 + axis] = max(p + s * (q - p) + t * (r - p), 0.0)
    return True


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


LEAST_CHROMA = 1.0
"""The measured bound is for parts with at least this chroma."""

RELATIVE = 3e-5
"""ε: bound of the relative error of F. Equation 16 jumps by nearly 1e-5 at hue 0."""


@leaf_kernel
def set_bounds(
    colour: FloatArray, cylinders: FloatArray, lanes: np.uint64, found: FloatArray
) -> None:
    """Set `found` to lower bounds of F in eight cylinders, and to F in their middles.

    F is infinite for a cylinder with a negative radius. `lanes` is 8.
    """
    l, a, b = colour[0], colour[1], colour[2]  # noqa: E741
    own = np.sqrt(a * a + b * b)
    for at in range(lanes):
        x, y, z = cylinders[0, at], cylinders[1, at], cylinders[2, at]
        nx, ny, nz = cylinders[3, at], cylinders[4, at], cylinders[5, at]
        wide, thick = cylinders[6, at], cylinders[7, at]
        # the box of lightness, chroma and hue around the cylinder
        tall = _reach(nx, wide, thick)
        other = np.sqrt(y * y + z * z)
        inverse = 1.0 / max(other, 1e-9)
        out = _reach((ny * y + nz * z) * inverse, wide, thick)
        aside = _reach((nz * y - ny * z) * inverse, wide, thick)
        inner = other - out
        outer = np.sqrt((other + out) ** 2 + aside * aside)
        proved = _interval_bound(
            l, a, b, own, x - tall, x + tall, y, z, max(inner, 0.0), outer, _turn(aside, inner)
        )
        u, v, root, hue, cosine, sine = chroma_and_hue(a, b, y, z)
        turn, turn_1, turn_2 = _rotation(cosine, sine)
        chroma = half_square_without_lightness(u, v, root, composed(hue, turn, turn_1, turn_2))
        light = half_squared(lightness_term(l, x))
        value, gy, gz, hyy, hyz, hzz = plus(chroma, (light[0], 0.0, 0.0, 0.0, 0.0, 0.0))
        gx, hxx = light[1], light[3]
        along = gx * nx + gy * ny + gz * nz
        across = np.sqrt(max(gx * gx + gy * gy + gz * gz - along * along, 0.0))
        half = 0.5 * (hyy - hzz)
        bend = min(0.5 * (hyy + hzz) - np.sqrt(half * half + hyz * hyz), hxx)
        far = across / bend if bend * wide > across else wide
        low = value * (1.0 - RELATIVE) - far * (across - 0.5 * bend * far) - thick * abs(along)
        low += 0.5 * min(bend, 0.0) * thick * thick
        is_blue, radius = _is_blue(a + y, b + z), np.sqrt(wide * wide + thick * thick)
        least, middle = max(inner, LEAST_CHROMA), 0.5 * (l + x)
        low -= _remainder(middle, light[0], tall, u[0], v[0], least, radius, is_blue)
        # on one side of the opposite hue, or nowhere near it
        share = 1.0 / max(own, 1e-9)
        turned = (a * y + b * z) * share - _reach((a * ny + b * nz) * share, wide, thick)
        beside = abs(a * z - b * y) * share - _reach((a * nz - b * ny) * share, wide, thick)
        is_measured = (turned >= 0.0) | (beside > 0.0)
        is_measured &= (inner > LEAST_CHROMA) & (low > proved)
        found[0, at] = low if is_measured else proved
        found[1, at] = value if wide >= 0.0 else np.inf


@inlined_kernel
def _reach(cosine: float, wide: float, thick: float) -> float:
    """Return the extent of a cylinder in a direction, given the cosine of its angle to the axis."""
    return wide * np.sqrt(max(1.0 - cosine * cosine, 0.0) + ROUNDING) + thick * abs(cosine)


@inlined_kernel
def _turn(aside: float, along: float) -> float:
    """Return the angle of a vector, at most a quarter turn, rounded up slightly."""
    length = 1.0 / np.sqrt(aside * aside + along * along + TINY)
    angle = _arc_tangent(aside * length, along * length) + 1e-7
    return angle if along > 0.0 else np.pi


@inlined_kernel
def _remainder(
    middle: float,
    light: float,
    tall: float,
    u: float,
    v: float,
    chroma: float,
    radius: float,
    blue: bool,
) -> float:
    """Return M |d|³, of differences in lightness, and of differences in a* and b*.

    `middle` is the mean lightness of the colour and the middle of the part. At the middle, `light`
    is half the square of ΔL' ÷ S_L, `u` is ΔC' ÷ S_C and `v` is ΔH' ÷ S_H. `chroma` is the least C*
    on the way to any point, `tall` and `radius` the largest |d|, and `blue` whether R_T counts.
    """
    far = max(abs(middle - 50.0) - 0.5 * tall, 0.0)
    steep = far * far * (1.0 / 6.25)
    by_lightness = 0.009 + light * (1.5e-5 + 2.8e-4 / (1.0 + steep * steep))
    share = 1.0 / chroma
    square = share * share
    along, across = abs(u), v * v
    first, second, third = (20.0, 3.0, 0.06) if blue else (13.5, 0.34, 0.014)
    cube, most = (200.0, 2.5) if blue else (60.0, 0.7)
    flat = (first + second * along + third * across) * (1.0 + min(cube * square * share, most))
    by_chroma = 0.06 * share + square * (flat + 1.1 * along * across * square)
    return by_lightness * tall * tall * tall + by_chroma * radius * radius * radius


@inlined_kernel
def _is_blue(a: float, b: float) -> bool:
    """Whether the hue of a mean colour is between 215° and 330°, where R_T counts."""
    return (b < 0.0) & (a > 1.43 * b) & (a < -1.73 * b)


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
    # bounds of both C'
    own_low = np.sqrt(narrow * narrow * a * a + b * b)
    own_high = np.sqrt(wide * wide * a * a + b * b)
    low, high = least, most * wide
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
    cosine = x1 * x2 + y1 * y2
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
    rotation = _steepest_rotation(mean_x, mean_y, spread)
    # √(C⁷ ÷ (C⁷ + 25⁷)) in terms of the stretch at this mean
    rotation = rotation * 2.0 * (3.0 - 2.0 * _stretch(mean))
    v = 2.0 * np.sqrt(own_low * low) * sine / (1.0 + 0.015 * mean * LARGEST_T)
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


ROTATION_ROUNDING = 1e-6
"""Bound of the relative error of sin 2Δθ."""


@inlined_kernel
def _rotation(cosine: float, sine: float) -> tuple[float, float, float]:
    """Return sin 2Δθ and its derivatives by the mean hue, without calls of functions."""
    toward = cosine * COS_275 + sine * SIN_275
    angle = _arc_tangent(sine * COS_275 - cosine * SIN_275, abs(toward)) / BLUE_WIDTH
    turn = ROTATION * _exponential(angle * angle) if toward > 0.0 else 0.0
    first = -2.0 / BLUE_WIDTH * angle * turn
    second = (4.0 * angle * angle - 2.0) / (BLUE_WIDTH * BLUE_WIDTH) * turn
    sine = _sine(turn)
    cosine = np.sqrt(1.0 - sine * sine)
    return sine, cosine * first, cosine * second - sine * first * first


@inlined_kernel
def _steepest_rotation(cosine: float, sine: float, slack: float) -> float:
    """Return an upper bound of sin 2Δθ for hues that differ by up to `slack`."""
    toward = cosine * COS_275 + sine * SIN_275
    aside = abs(sine * COS_275 - cosine * SIN_275)
    # an angle from 0 to 90°, which is not above the difference of the hues
    angle = _arc_tangent(aside, toward) if toward > 0.0 else 0.5 * np.pi
    angle = 1.0 / BLUE_WIDTH * max(angle - slack, 0.0)
    return _sine(ROTATION * _exponential(angle * angle)) * (1.0 + ROTATION_ROUNDING)


@inlined_kernel
def _arc_tangent(aside: float, toward: float) -> float:
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
    power = 1.0 + small * 0.25 * (1.0 + small * 0.2 * (1.0 + small * (1.0 / 6.0)))
    power = 1.0 + small * (1.0 + small * 0.5 * (1.0 + small * (1.0 / 3.0) * power))
    for _ in range(6):
        power *= power
    return power


@inlined_kernel
def _sine(turn: float) -> float:
    """Return the sine of an angle from 0 to 60°, by its series."""
    square = turn * turn
    sine = 1.0 - square * (1.0 / 110.0)
    sine = 1.0 - square * (1.0 / 72.0) * sine
    sine = 1.0 - square * (1.0 / 42.0) * sine
    sine = 1.0 - square * (1.0 / 20.0) * sine
    return turn * (1.0 - square * (1.0 / 6.0) * sine)
