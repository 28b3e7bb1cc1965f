"""Side of an edge or a face on which a line or a point is, where float64 leaves it open.

Where a determinant is 0, the sign is that of an infinitely small change:

1. The surface is scaled by 1 + ε about the centre, because it belongs to the gamut. A line that
   touches the surface crosses it twice, and an end on the surface is inside, as for `contains`.
2. The second point of the line is moved by (δ, δ², δ³), with δ far smaller than ε.

No line then meets an edge or a vertex. The signs follow H. Edelsbrunner & E. P. Mücke, "Simulation
of Simplicity", ACM Transactions on Graphics 9 (1990).
"""

from __future__ import annotations

from typing import TypeAlias

from gamutcore.arrays import FloatArray
from gamutcore.kernels import leaf_kernel
from gamutcore.queries.exact import area, moved_orientation, orientation
from gamutcore.queries.index import LevelIndex

__all__ = ["Point", "exact_sides", "is_below"]

Point: TypeAlias = tuple[float, float, float]


@leaf_kernel
def _vertex(index: LevelIndex, vertex: int) -> Point:
    return index.vertices[vertex, 0], index.vertices[vertex, 1], index.vertices[vertex, 2]


@leaf_kernel
def exact_sides(
    start: Point, end: Point, index: LevelIndex, face: int, terms: FloatArray
) -> tuple[int, float, float, float]:
    """Return the direction in which a line crosses a face, and its determinants with the edges.

    The direction is 1 if the line leaves the gamut, −1 if it enters, 0 if it misses the face. For
    the edge p, q opposite to each corner, the determinant is det(end − start, p − start, q −
    start).
    """
    one, two, three = index.faces[face, 0], index.faces[face, 1], index.faces[face, 2]
    a, b, c = _vertex(index, one), _vertex(index, two), _vertex(index, three)
    side_a, sign_a = _exact_side(start, end, b, c, index, terms)
    side_b, sign_b = _exact_side(start, end, c, a, index, terms)
    if sign_a != sign_b:
        return 0, side_a, side_b, 0.0
    side_c, sign_c = _exact_side(start, end, a, b, index, terms)
    return (sign_a if sign_a == sign_c else 0), side_a, side_b, side_c


@leaf_kernel
def _exact_side(
    start: Point, end: Point, p: Point, q: Point, index: LevelIndex, terms: FloatArray
) -> tuple[float, int]:
    """Return det(end − start, p − start, q − start), and its sign, which is not 0."""
    sx, sy, sz = start
    ex, ey, ez = end
    px, py, pz = p
    qx, qy, qz = q
    side = orientation(ex, ey, ez, px, py, pz, qx, qy, qz, sx, sy, sz, terms)
    found = side
    if found == 0.0:
        # the coefficients of ε; δ, δ², δ³; ε δ, ε δ², ε δ³, of which one is not 0
        cx, cy, cz = index.centre[0], index.centre[1], index.centre[2]
        found = moved_orientation(ex, ey, ez, sx, sy, sz, px, py, pz, qx, qy, qz, cx, cy, cz, terms)
        if found == 0.0:
            found = area(py, pz, qy, qz, sy, sz, terms)
        if found == 0.0:
            found = area(pz, px, qz, qx, sz, sx, terms)
        if found == 0.0:
            found = area(px, py, qx, qy, sx, sy, terms)
        if found == 0.0:
            found = area(py, pz, qy, qz, cy, cz, terms)
        if found == 0.0:
            found = area(pz, px, qz, qx, cz, cx, terms)
        if found == 0.0:
            found = area(px, py, qx, qy, cx, cy, terms)
    return side, (1 if found > 0.0 else -1)


@leaf_kernel
def is_below(point: Point, index: LevelIndex, face: int, terms: FloatArray) -> bool:
    """Whether a point is on the plane of a face, or on its inner side."""
    planes, centre = index.planes, index.centre
    px, py, pz = point
    x, y, z = px - centre[0], py - centre[1], pz - centre[2]
    height = planes[face, 9] * x + planes[face, 10] * y + planes[face, 11] * z - planes[face, 12]
    # the planes are scaled for points in the box
    if abs(height) > 1.0 + (abs(x) + abs(y) + abs(z)) * index.tree.scale:
        return height < 0.0
    one, two, three = index.faces[face, 0], index.faces[face, 1], index.faces[face, 2]
    ax, ay, az = _vertex(index, one)
    bx, by, bz = _vertex(index, two)
    cx, cy, cz = _vertex(index, three)
    return orientation(ax, ay, az, bx, by, bz, cx, cy, cz, px, py, pz, terms) >= 0.0
