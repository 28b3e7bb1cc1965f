"""Nearest by CIEDE2000: the point of a level's surface with the smallest ΔE00 to a colour.

A branch and bound over the tree of faces finds the global minimum. Nodes, faces and parts of faces
are left out where a lower bound of ΔE00 is above the smallest value so far. The bounds of
`ciede2000_metric` are quadratic; for large differences that of `ciede2000_bound` is used as well.

In what remains of a face, descent finds the minimum (`ciede2000_descent`). The face is divided
where there might be more than one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.queries.ciede2000_bound import ball_bound
from gamutcore.queries.ciede2000_descent import TOLERANCE, Work, descend, has_one_minimum
from gamutcore.queries.ciede2000_metric import (
    BLUE,
    curvature,
    least_chroma,
    metric_bound,
    metric_slack,
    set_metric,
    set_metric_bounds,
    tangent_curvature,
)
from gamutcore.queries.ciede2000_slope import CHROMA, SLOPE, A, B, L, set_slope
from gamutcore.queries.colour_difference import ciede2000
from gamutcore.queries.curve import curve_order
from gamutcore.queries.face_tree import AXIS, HEIGHT, RADIUS, STACK, WIDTH
from gamutcore.queries.index import Level, LevelIndex, as_index
from gamutcore.queries.nearest import SurfacePoints
from gamutcore.queries.rows import checked_points

__all__ = ["nearest_ciede2000"]

ORDER = 1e-10
"""Share of the distance that is added to bounds, so that the nearest of equal ones comes first."""

PARTS = 128
"""Places for parts of a face: three for each halving, from 1e10 to `SMALL` units."""


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
        0.1 where the nearest point has the opposite hue: the formula is not continuous there.

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


@kernel
def _nearest(
    points: FloatArray, index: LevelIndex
) -> tuple[FloatArray, FloatArray, IndexArray, FloatArray]:
    vertices = index.vertices
    count = len(points)
    found, weights = np.empty((count, 3)), np.empty((count, 3))
    distance = np.empty(count)
    faces = np.empty(count, np.int32)
    nodes, bounds, squares = np.empty(STACK, np.int64), np.empty(STACK), np.empty(WIDTH)
    work = Work(
        np.empty(4),
        np.empty(7),
        np.empty(7),
        np.empty(5),
        np.empty(9),
        np.empty(SLOPE),
        np.empty((PARTS, 3)),
        np.empty(3),
    )
    colour, best = work.colour, work.best
    best[1] = best[2] = 1.0 / 3.0
    face = 0
    for row in curve_order(points):
        for axis in range(3):
            colour[axis] = points[row, axis]
        colour[CHROMA] = np.sqrt(colour[A] ** 2 + colour[B] ** 2)
        face = _search(index, face, nodes, bounds, squares, work)
        one, two, three = index.faces[face, 0], index.faces[face, 1], index.faces[face, 2]
        u, v = best[1], best[2]
        w = max(1.0 - u - v, 0.0)
        for axis in range(3):
            found[row, axis] = (
                w * vertices[one, axis] + u * vertices[two, axis] + v * vertices[three, axis]
            )
        distance[row] = ciede2000(
            colour[L], colour[A], colour[B], found[row, 0], found[row, 1], found[row, 2]
        )
        faces[row] = face
        weights[row, 0], weights[row, 1], weights[row, 2] = w, u, v
    return found, distance, faces, weights


@leaf_kernel
def _search(
    index: LevelIndex,
    start: int,
    nodes: LongArray,
    bounds: FloatArray,
    squares: FloatArray,
    work: Work,
) -> int:
    """Find the face and set the best: ΔE00, and the weights of its second and third corner.

    The search starts with the weights that the best has in the face `start`.
    """
    tree, colour, best = index.tree, work.colour, work.best
    face = start
    ax, ay, az, bx, by, bz, cx, cy, cz = _set_corners(index, face, work.corners)
    u, v = best[1], best[2]
    best[0] = ciede2000(
        colour[L],
        colour[A],
        colour[B],
        ax + u * bx + v * cx,
        ay + u * by + v * cy,
        az + u * bz + v * cz,
    )
    # the step is for neutral colours, which have no hue
    set_slope(colour, colour[L], colour[A] + 1e-3, colour[B], work.slope)
    set_metric(work.slope, colour[L], colour[A], colour[B], work.own)
    nodes[0], bounds[0] = -1, 0.0
    height = 1
    while height > 0:
        height -= 1
        least = bounds[height]
        if least > best[0] - TOLERANCE:
            continue
        code = nodes[height]
        if code < 0:
            set_metric_bounds(work.own, index.centre, tree, 0, squares)
            height = _push_children(index, 0, code, 0.0, squares, work, nodes, bounds, height)
            continue
        first = tree.first[code // WIDTH]
        if first < 0:
            other = tree.faces[~first + code % WIDTH]
            if _search_face(index, other, work):
                face = other
            continue
        least = max(least, _bound(index, code, work))
        if least > best[0] - TOLERANCE:
            continue
        node = first + code % WIDTH
        metric = work.metric if work.around[4] > 0.0 else work.own
        set_metric_bounds(metric, index.centre, tree, node, squares)
        height = _push_children(index, node, code, least, squares, work, nodes, bounds, height)
    return face


@leaf_kernel
def _bound(index: LevelIndex, code: int, work: Work) -> float:
    """Return a lower bound for a node, and set what its children's bounds need.

    `work.around` receives the middle of the node, the minimum of the polynomial there, and κ, which
    is 0 if the polynomial is no good.
    """
    tree, centre, colour, slope = index.tree, index.centre, work.colour, work.slope
    size = 1.0 / tree.scale
    parent, at = code // WIDTH, code % WIDTH
    x = centre[0] + size * tree.cylinders[parent, at]
    y = centre[1] + size * tree.cylinders[parent, WIDTH + at]
    z = centre[2] + size * tree.cylinders[parent, 2 * WIDTH + at]
    wide = size * tree.cylinders[parent, RADIUS * WIDTH + at]
    thick = size * tree.cylinders[parent, HEIGHT * WIDTH + at]
    radius = wide + thick
    work.around[0], work.around[1], work.around[2], work.around[4] = x, y, z, 0.0
    bound = 0.0
    chroma = least_chroma(colour, y, z, radius)
    if chroma > 0.0:
        value = set_slope(colour, x, y, z, slope)
        scale = 1.0 / max(value, 1e-300)
        gx, gy, gz = scale * slope[0], scale * slope[1], scale * slope[2]
        along = (
            gx * tree.cylinders[parent, AXIS * WIDTH + at]
            + gy * tree.cylinders[parent, (AXIS + 1) * WIDTH + at]
            + gz * tree.cylinders[parent, (AXIS + 2) * WIDTH + at]
        )
        across = np.sqrt(max(gx * gx + gy * gy + gz * gz - along * along, 0.0))
        bound = value - wide * across - thick * abs(along)
        bound -= tangent_curvature(colour, value, chroma, y, z) * radius * radius
        bend = curvature(colour, value, chroma, y, z)
        if bend * radius * radius <= 0.5 * value:
            work.around[3] = set_metric(slope, x, y, z, work.metric)
            work.around[4] = bend
    slack, _, near = metric_slack(colour)
    best = work.best[0]
    if bound <= best - TOLERANCE and (best > near or (work.around[4] == 0.0 and slack == BLUE)):
        ball = ball_bound(colour[L], colour[A], colour[B], x, y, z, radius, radius)
        bound = max(bound, ball)
    return bound


@leaf_kernel
def _push_children(
    index: LevelIndex,
    node: int,
    code: int,
    least: float,
    squares: FloatArray,
    work: Work,
    nodes: LongArray,
    bounds: FloatArray,
    height: int,
) -> int:
    """Put the children of a node that may be better on the stack, and return its height."""
    tree, centre, around, best = index.tree, index.centre, work.around, work.best
    size = 1.0 / tree.scale
    bend = around[4] if code >= 0 else 0.0
    slack, growth, near = metric_slack(work.colour)
    bottom = height
    for at in range(WIDTH):
        if not squares[at] < np.inf:
            break
        away = size * np.sqrt(squares[at])
        if bend > 0.0:
            ox = centre[0] + size * tree.cylinders[node, at] - around[0]
            oy = centre[1] + size * tree.cylinders[node, WIDTH + at] - around[1]
            oz = centre[2] + size * tree.cylinders[node, 2 * WIDTH + at] - around[2]
            long = np.sqrt(ox * ox + oy * oy + oz * oz) + size * (
                tree.cylinders[node, RADIUS * WIDTH + at]
                + tree.cylinders[node, HEIGHT * WIDTH + at]
            )
            bound = np.sqrt(max(around[3] + away * away, 0.0)) - bend * long * long
        else:
            bound = min(metric_bound(away, slack, growth), near)
        bound = max(bound, least) + ORDER * away
        if bound <= best[0] - TOLERANCE:  # keep the nearest on top
            place = height
            while place > bottom and bounds[place - 1] < bound:
                nodes[place], bounds[place] = nodes[place - 1], bounds[place - 1]
                place -= 1
            nodes[place], bounds[place] = node * WIDTH + at, bound
            height += 1
    return height


@leaf_kernel
def _search_face(index: LevelIndex, face: int, work: Work) -> bool:
    """Replace the best if a point of a face is better; return whether one is."""
    colour, slope, parts, best = work.colour, work.slope, work.parts, work.best
    ax, ay, az, bx, by, bz, cx, cy, cz = _set_corners(index, face, work.corners)
    # the distances of the corners from the centroid, three times as long
    long = (bx + cx) ** 2 + (by + cy) ** 2 + (bz + cz) ** 2
    long = max(long, (2.0 * bx - cx) ** 2 + (2.0 * by - cy) ** 2 + (2.0 * bz - cz) ** 2)
    long = max(long, (2.0 * cx - bx) ** 2 + (2.0 * cy - by) ** 2 + (2.0 * cz - bz) ** 2)
    whole = np.sqrt(long) / 3.0
    improved = False
    parts[0, 0], parts[0, 1], parts[0, 2] = 0.0, 0.0, 1.0
    height = 1
    while height > 0:
        height -= 1
        # the corner of the right angle, and the side, in coordinates u and v
        u, v, side = parts[height, 0], parts[height, 1], parts[height, 2]
        radius = abs(side) * whole
        middle_u, middle_v = u + side / 3.0, v + side / 3.0
        x = ax + middle_u * bx + middle_v * cx
        y = ay + middle_u * by + middle_v * cy
        z = az + middle_u * bz + middle_v * cz
        value = set_slope(colour, x, y, z, slope)
        if value < best[0]:
            best[0], best[1], best[2] = value, middle_u, middle_v
            improved = True
        chroma = least_chroma(colour, y, z, radius)
        error = np.inf
        if chroma > 0.0:
            scale = side / max(value, 1e-300)
            along_b = scale * (slope[0] * bx + slope[1] * by + slope[2] * bz)
            along_c = scale * (slope[0] * cx + slope[1] * cy + slope[2] * cz)
            linear = value - (along_b + along_c) / 3.0 + min(0.0, along_b, along_c)
            flat = tangent_curvature(colour, value, chroma, y, z) * radius * radius
            if linear - flat > best[0] - TOLERANCE:
                continue
            error = curvature(colour, value, chroma, y, z) * radius * radius
        single = has_one_minimum(colour, y, z, radius, best[0])
        if not single:
            ball = ball_bound(colour[L], colour[A], colour[B], x, y, z, radius, radius)
            if ball > best[0] - TOLERANCE:
                continue
        better, done = descend(work, u, v, side, error, single)
        improved = improved or better
        if done:
            continue
        half = 0.5 * side
        for part in range(4):
            parts[height, 0] = u + half if part == 1 or part == 3 else u
            parts[height, 1] = v + half if part >= 2 else v
            parts[height, 2] = -half if part == 3 else half
            height += 1
    return improved


@leaf_kernel
def _set_corners(
    index: LevelIndex, face: int, corners: FloatArray
) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Set the first corner of a face and the two sides from it, and return them."""
    vertices = index.vertices
    one, two, three = index.faces[face, 0], index.faces[face, 1], index.faces[face, 2]
    for axis in range(3):
        corners[axis] = vertices[one, axis]
        corners[3 + axis] = vertices[two, axis] - vertices[one, axis]
        corners[6 + axis] = vertices[three, axis] - vertices[one, axis]
    return (
        corners[0],
        corners[1],
        corners[2],
        corners[3],
        corners[4],
        corners[5],
        corners[6],
        corners[7],
        corners[8],
    )
