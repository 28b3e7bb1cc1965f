"""The radial envelope of crossing triangles: in each direction from a centre, the outermost point.

Vertices are the outermost corners of triangles, and the outermost points at which an edge passes
through a triangle. Their directions are triangulated by a convex hull on the unit sphere. Flips
then restore the edges of the triangles, and the lines along which two triangles cross. Pieces of
triangles are left between these lines, or walls where the outermost surface ends above another. The
result is star-shaped because the hull is, and because flips keep it so.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import BooleanArray, FloatArray, IndexArray, LongArray
from gamutcore.boundary.edge_recovery import recover_edges
from gamutcore.boundary.insertion_order import curve_positions, insertion_order
from gamutcore.boundary.outermost import (
    Crossings,
    Sheets,
    arrange,
    edge_crossings,
    is_hidden,
)
from gamutcore.boundary.radial_hull import radial_hull
from gamutcore.boundary.radial_volume import COARSE, radial_volume
from gamutcore.grid import nearest_grid_points

__all__ = ["Envelope", "radial_envelope"]


class Envelope(NamedTuple):
    """A closed surface, star-shaped about the origin.

    Attributes
    ----------
    position : (m, 3) float64
        On the grid.
    faces : (f, 3) int32
    ends : (m, 2) int32
        The two points on whose edge each vertex is; twice the same for a vertex that is a point.
    share : (m,) float64
        Position between them, 0 to 1.
    """

    position: FloatArray
    faces: IndexArray
    ends: IndexArray
    share: FloatArray


def radial_envelope(position: FloatArray, corners: IndexArray, step: float) -> Envelope:
    """Return the outermost surface of triangles (m, 3), of any orientation, around the origin.

    Points (n, 3) are relative to the centre, on a grid with the given step. The envelope has no
    faces if the triangles do not surround the centre.
    """
    if radial_volume(position, corners, np.zeros(3), COARSE).uncovered:
        return Envelope(position, np.empty((0, 3), np.int32), *_no_cuts(len(position)))
    sheets = arrange(position, corners, step)
    vertices = np.unique(sheets.corner)
    seen = np.zeros(len(position), bool)
    seen[vertices] = ~is_hidden(sheets, position[vertices])
    rims = _rims(sheets.corner, seen)
    crossings = _outermost_crossings(sheets, rims.edges, seen)
    cut = nearest_grid_points(_points_on(position, rims.edges, crossings), step)

    count = len(position)
    points = np.concatenate([position, cut])
    own_ends, own_share = _no_cuts(count)
    ends = np.concatenate([own_ends, rims.edges[crossings.edge]])
    share = np.concatenate([own_share, crossings.share])
    chosen = np.concatenate([np.flatnonzero(seen), np.arange(count, len(points))])
    pairs = np.concatenate(
        [_creases(rims, crossings, count), _pieces(sheets, rims, crossings, seen)]
    )

    distinct, number = _distinct(points, chosen, step)
    order = distinct[insertion_order(curve_positions(points[distinct]))]
    ordered = points[order]
    faces = radial_hull(ordered / np.linalg.norm(ordered, axis=1)[:, np.newaxis])
    place = np.full(len(points), -1, np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    faces, _ = recover_edges(ordered, faces, place[number[pairs]])
    return Envelope(ordered, faces, ends[order], share[order])


def _no_cuts(count: int) -> tuple[IndexArray, FloatArray]:
    """Ends and shares of points that are not between others."""
    own = np.arange(count, dtype=np.int32)
    return np.column_stack([own, own]), np.zeros(count)


class Rims(NamedTuple):
    """The edges of the triangles that have an outermost corner.

    Attributes
    ----------
    edges : (e, 2) int32
    start : (e + 1,) int64
        First entry of each edge in `triangle`.
    triangle : (k,) int32
        The triangles on both sides of the edges.
    """

    edges: IndexArray
    start: LongArray
    triangle: IndexArray


def _rims(corner: IndexArray, seen: BooleanArray) -> Rims:
    partly = np.flatnonzero(seen[corner].any(axis=1)).astype(np.int32)
    sides = np.concatenate([corner[partly][:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    keys = sides.min(axis=1).astype(np.int64) * len(seen) + sides.max(axis=1)
    order = np.argsort(keys, kind="stable")
    found, start = np.unique(keys[order], return_index=True)
    edges = np.column_stack(np.divmod(found, len(seen))).astype(np.int32)
    return Rims(edges, np.append(start, len(keys)), np.tile(partly, 3)[order])


def _points_on(position: FloatArray, edges: IndexArray, crossings: Crossings) -> FloatArray:
    start, end = (position[edges[crossings.edge, side]] for side in (0, 1))
    return np.asarray(start + crossings.share[:, np.newaxis] * (end - start))


def _outermost_crossings(sheets: Sheets, edges: IndexArray, seen: BooleanArray) -> Crossings:
    """Crossings that no triangle hides, edge by edge from the first end.

    Triangles that cross continue below each other. Only edges of triangles with a hidden corner,
    and edges between these triangles, are therefore examined.
    """
    count = seen[sheets.corner].sum(axis=1)
    near = np.zeros(len(seen), bool)
    near[sheets.corner[(count > 0) & (count < 3)]] = True
    examined = np.flatnonzero(near[edges].all(axis=1)).astype(np.int32)
    room = len(examined)
    found, crossings = edge_crossings(sheets, edges[examined], room)
    if found > room:
        _, crossings = edge_crossings(sheets, edges[examined], found)
    crossings = Crossings(examined[crossings.edge], crossings.triangle, crossings.share)
    kept = np.flatnonzero(~is_hidden(sheets, _points_on(sheets.position, edges, crossings)))
    kept = kept[np.lexsort((crossings.share[kept], crossings.edge[kept]))]
    return Crossings(crossings.edge[kept], crossings.triangle[kept], crossings.share[kept])


def _creases(rims: Rims, crossings: Crossings, first: int) -> IndexArray:
    """Pairs of crossings at the ends of the line along which two triangles cross."""
    begin, end = rims.start[crossings.edge], rims.start[crossings.edge + 1]
    crossing = np.repeat(np.arange(len(begin)), end - begin)
    entry = np.arange(len(crossing)) - np.repeat(
        np.cumsum(end - begin) - (end - begin), end - begin
    )
    one = rims.triangle[np.repeat(begin, end - begin) + entry].astype(np.int64)
    two = crossings.triangle[crossing].astype(np.int64)
    keys = np.minimum(one, two) << 32 | np.maximum(one, two)
    order = np.argsort(keys, kind="stable")
    keys, crossing = keys[order], crossing[order]
    same = np.flatnonzero(keys[1:] == keys[:-1])
    return (np.column_stack([crossing[same], crossing[same + 1]]) + first).astype(np.int32)


def _pieces(sheets: Sheets, rims: Rims, crossings: Crossings, seen: BooleanArray) -> IndexArray:
    """Pairs of points at the ends of the outermost pieces of edges, the cut edges first."""
    first, edges = len(sheets.position), rims.edges
    whole = seen[edges[:, 0]] & seen[edges[:, 1]]
    whole[crossings.edge] = False
    count = len(crossings.edge)
    opens = np.ones(count + 1, bool)
    opens[1:-1] = crossings.edge[1:] != crossings.edge[:-1]
    number = np.arange(count) + first
    before = np.where(opens[:-1], edges[crossings.edge, 0], number - 1)
    low = np.where(opens[:-1], 0.0, np.concatenate([[0.0], crossings.share[:-1]])[:count])
    last = opens[1:]
    pairs = np.concatenate(
        [
            np.column_stack([before, number]),
            np.column_stack([number[last], edges[crossings.edge[last], 1]]),
        ]
    )
    middles = Crossings(
        np.concatenate([crossings.edge, crossings.edge[last]]),
        np.empty(0, np.int32),
        np.concatenate([(low + crossings.share) / 2, (crossings.share[last] + 1) / 2]),
    )
    shown = ~is_hidden(sheets, _points_on(sheets.position, edges, middles))
    known = np.append(seen, np.ones(count, bool))
    shown &= known[pairs].all(axis=1)
    return np.concatenate([pairs[shown], edges[whole]]).astype(np.int32)


def _distinct(points: FloatArray, chosen: LongArray, step: float) -> tuple[LongArray, LongArray]:
    """One of each group of equal points, and for every point the one of its group."""
    # odd factors, so that different points have different keys but for rare collisions
    whole = np.rint(points[chosen] / step).astype(np.int64)
    keys = whole @ np.array([0x9E3779B97F4A7C1, 0xBF58476D1CE4E5B, 0x94D049BB133111E | 1])
    order = np.argsort(keys, kind="stable")
    opens = np.append(True, keys[order[1:]] != keys[order[:-1]])
    own = np.empty(len(chosen), np.int64)
    own[order] = chosen[order[opens]][np.cumsum(opens) - 1]
    collided = (points[own] != points[chosen]).any(axis=1)
    own[collided] = chosen[collided]
    number = np.arange(len(points))
    number[chosen] = own
    return chosen[own == chosen], number
