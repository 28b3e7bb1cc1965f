"""The nearest point of a level's surface.

A search goes down the tree over the faces (`gamutcore.queries.face_tree`), nearest cylinder first,
and leaves out cylinders that are farther than the best face so far. Rows are answered along a
Hilbert curve, and each starts with the face of the row before, which is seldom far from its own.
Cylinders are left out with a margin for rounding errors, so that the answer does not depend on the
order of the rows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.geometry import curve_order
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.queries.face_tree import STACK, WIDTH, set_lower_bounds
from gamutcore.queries.index import Level, LevelIndex, as_index, checked_points

__all__ = ["SurfacePoints", "nearest", "nearest_face"]

MARGIN = 2.0**-48
"""Bound of the rounding error of a distance ÷ the magnitude of the coordinates: differences,
weights and the sum of squares have some ten roundings of 2⁻⁵³."""

THIN = 1e-6
"""Squared sine of the angle of a face below which the face counts as thin. The weights of the
projection are then corrected once, and the edges are tried as well."""


class SurfacePoints(NamedTuple):
    """Points of a level's surface.

    Attributes
    ----------
    points : (n, 3) float64
        Coordinates.
    distance : (n,) float64
        From the points of the query.
    faces : (n,) int32
        Faces that hold the points.
    weights : (n, 3) float64
        Barycentric coordinates in the faces, not negative, with the sum 1.
    """

    points: FloatArray
    distance: FloatArray
    faces: IndexArray
    weights: FloatArray


def nearest(points: ArrayLike, level: Level) -> SurfacePoints:
    """Find the nearest points of a level's surface.

    Parameters
    ----------
    points : (n, 3) array_like
        In the colour space of the level.
    level : LevelIndex or (vertices, faces, centre)

    Returns
    -------
    SurfacePoints
        `distance` is the Euclidean distance, within rounding. Of faces at the same distance, the
        one with the lowest number is given.

    Raises
    ------
    InvalidPointsError
        A point is not three finite numbers; ``where["row"]`` names it.
    MeshError
        As for `build_index`.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> found = nearest([(0.25, 0.5, -2.0)], tetrahedron)
    >>> found.points.tolist(), found.distance.tolist(), found.faces.tolist()
    ([[0.25, 0.5, 0.0]], [2.0], [0])
    >>> found.weights.tolist()
    [[0.25, 0.5, 0.25]]
    """
    return SurfacePoints(*_nearest(checked_points(points), as_index(level)))


@kernel
def _nearest(
    points: FloatArray, index: LevelIndex
) -> tuple[FloatArray, FloatArray, IndexArray, FloatArray]:
    vertices = index.vertices
    count = len(points)
    found = np.empty((count, 3))
    distance = np.empty(count)
    faces = np.empty(count, np.int32)
    weights = np.empty((count, 3))
    nodes, bounds, squares = np.empty(STACK, np.int64), np.empty(STACK), np.empty(WIDTH)
    face = 0
    for row in curve_order(points):
        x, y, z = points[row, 0], points[row, 1], points[row, 2]
        face, square, u, v = nearest_face(x, y, z, index, face, np.inf, nodes, bounds, squares)
        one, two, three = index.faces[face, 0], index.faces[face, 1], index.faces[face, 2]
        w = max(1.0 - u - v, 0.0)
        for axis in range(3):
            found[row, axis] = (
                w * vertices[one, axis] + u * vertices[two, axis] + v * vertices[three, axis]
            )
        distance[row] = np.sqrt(square)
        faces[row] = face
        weights[row, 0], weights[row, 1], weights[row, 2] = w, u, v
    return found, distance, faces, weights


@leaf_kernel
def nearest_face(
    px: float,
    py: float,
    pz: float,
    index: LevelIndex,
    start: int,
    within: float,
    nodes: LongArray,
    bounds: FloatArray,
    squares: FloatArray,
) -> tuple[int, float, float, float]:
    """Return the face nearest to a point, the squared distance, and two weights.

    The weights are those of the second and the third corner. Only the time depends on the face
    `start`. Faces farther than `within` need not be found; the answer may then be `start`. `nodes`
    and `bounds` (STACK,) and `squares` (WIDTH,) are work arrays.
    """
    tree, centre = index.tree, index.centre
    scale = tree.scale
    x, y, z = (px - centre[0]) * scale, (py - centre[1]) * scale, (pz - centre[2]) * scale
    largest = max(abs(px), abs(py), abs(pz))
    for axis in range(3):
        largest = max(largest, abs(index.box[0, axis]), abs(index.box[1, axis]))
    margin = MARGIN * largest
    face = start
    square, u, v = _point_in_face(px, py, pz, index, face)
    limit = ((min(np.sqrt(square), within) + margin) * scale) ** 2
    nodes[0], bounds[0] = 0, 0.0
    height = 1
    while height > 0:
        height -= 1
        if bounds[height] > limit:
            continue
        node = nodes[height]
        set_lower_bounds(x, y, z, tree.cylinders, node, squares)
        first = tree.first[node]
        if first < 0:
            for at in range(WIDTH):
                if squares[at] <= limit:
                    other = tree.faces[~first + at]
                    closer, other_u, other_v = _point_in_face(px, py, pz, index, other)
                    if closer < square or (closer == square and other < face):
                        face, square, u, v = other, closer, other_u, other_v
                        limit = ((min(np.sqrt(square), within) + margin) * scale) ** 2
        else:
            bottom = height
            for at in range(WIDTH):
                bound = squares[at]
                if bound <= limit:  # keep the nearest on top
                    place = height
                    while place > bottom and bounds[place - 1] < bound:
                        nodes[place], bounds[place] = nodes[place - 1], bounds[place - 1]
                        place -= 1
                    nodes[place], bounds[place] = first + at, bound
                    height += 1
    return face, square, u, v


@leaf_kernel
def _point_in_face(
    px: float, py: float, pz: float, index: LevelIndex, face: int
) -> tuple[float, float, float]:
    """Return the squared distance of a point from a face, and the weights of two corners.

    The weights are those of the second and the third corner, within rounding of the best; the point
    at these weights has this distance. The region of the point is found as in C. Ericson,
    "Real-Time Collision Detection" (2005), section 5.1.5, except that a point outside is projected
    on all edges. This is also right for faces so thin that rounding errors leave their normal open.
    """
    vertices = index.vertices
    row = np.uint64(face)
    one = np.uint64(index.faces[row, 0])
    two = np.uint64(index.faces[row, 1])
    three = np.uint64(index.faces[row, 2])
    ax, ay, az = vertices[one, 0], vertices[one, 1], vertices[one, 2]
    bx, by, bz = vertices[two, 0] - ax, vertices[two, 1] - ay, vertices[two, 2] - az
    cx, cy, cz = vertices[three, 0] - ax, vertices[three, 1] - ay, vertices[three, 2] - az
    qx, qy, qz = px - ax, py - ay, pz - az
    nx, ny, nz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    bb, cc = bx * bx + by * by + bz * bz, cx * cx + cy * cy + cz * cz
    whole = nx * nx + ny * ny + nz * nz
    square, u, v = np.inf, 0.0, 0.0
    # the projection on the plane, if it is inside the face
    mx, my, mz = cy * nz - cz * ny, cz * nx - cx * nz, cx * ny - cy * nx
    lx, ly, lz = ny * bz - nz * by, nz * bx - nx * bz, nx * by - ny * bx
    u, v = mx * qx + my * qy + mz * qz, lx * qx + ly * qy + lz * qz
    if u >= 0.0 and v >= 0.0 and u + v <= whole:
        u, v = u / whole, v / whole
        if whole > THIN * bb * cc:
            return _square(qx, qy, qz, bx, by, bz, cx, cy, cz, u, v), u, v
        rx, ry, rz = qx - u * bx - v * cx, qy - u * by - v * cy, qz - u * bz - v * cz
        u = max(u + (mx * rx + my * ry + mz * rz) / whole, 0.0)
        v = min(max(v + (lx * rx + ly * ry + lz * rz) / whole, 0.0), 1.0)
        u = min(u, 1.0 - v)
        square = _square(qx, qy, qz, bx, by, bz, cx, cy, cz, u, v)
    share = min(max((bx * qx + by * qy + bz * qz) / bb, 0.0), 1.0)
    other = _square(qx, qy, qz, bx, by, bz, cx, cy, cz, share, 0.0)
    if other < square:
        square, u, v = other, share, 0.0
    share = min(max((cx * qx + cy * qy + cz * qz) / cc, 0.0), 1.0)
    other = _square(qx, qy, qz, bx, by, bz, cx, cy, cz, 0.0, share)
    if other < square:
        square, u, v = other, 0.0, share
    ex, ey, ez = cx - bx, cy - by, cz - bz
    share = (ex * (qx - bx) + ey * (qy - by) + ez * (qz - bz)) / (ex * ex + ey * ey + ez * ez)
    share = min(max(share, 0.0), 1.0)
    other = _square(qx, qy, qz, bx, by, bz, cx, cy, cz, 1.0 - share, share)
    if other < square:
        square, u, v = other, 1.0 - share, share
    return square, u, v


@leaf_kernel
def _square(
    qx: float,
    qy: float,
    qz: float,
    bx: float,
    by: float,
    bz: float,
    cx: float,
    cy: float,
    cz: float,
    u: float,
    v: float,
) -> float:
    """Return the squared length of q − u b − v c."""
    x, y, z = qx - u * bx - v * cx, qy - u * by - v * cy, qz - u * bz - v * cz
    return x * x + y * y + z * z
