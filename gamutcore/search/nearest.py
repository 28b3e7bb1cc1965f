"""The nearest point of a level's surface.

A search goes down the tree over the faces (`gamutcore.search.face_tree`), nearest cylinder first,
and leaves out cylinders that are farther than the best face so far. Rows are answered along a
Hilbert curve, and each starts with the face of the row before, which is seldom far from its own.
Cylinders are left out with a margin for rounding errors, so that the answer does not depend on the
order of the rows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.geometry import (
    Vector,
    closest_point,
    curve_order,
    face_corners,
    minus,
    row,
    scaled,
    vector,
    write_row,
)
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.search.face_tree import WIDTH, Search, new_search, set_lower_bounds
from gamutcore.search.index import Level, LevelIndex, as_index, checked_points, surface_points

__all__ = ["SurfacePoints", "nearest", "nearest_face"]

MARGIN = 2.0**-48
"""Bound of the rounding error of a distance ÷ the magnitude of the coordinates: differences,
weights and the sum of squares have some ten roundings of 2⁻⁵³."""


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

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> surface = nearest([(0.25, 0.5, -2.0)], tetrahedron)
    >>> surface.points.tolist(), surface.distance.tolist(), surface.faces.tolist()
    ([[0.25, 0.5, 0.0]], [2.0], [0])
    >>> surface.weights.tolist()
    [[0.25, 0.5, 0.25]]
    """
    index = as_index(level)
    distance, faces, weights = _nearest(checked_points(points), index, new_search())
    return SurfacePoints(surface_points(index, faces, weights), distance, faces, weights)


@kernel
def _nearest(
    points: FloatArray, index: LevelIndex, search: Search
) -> tuple[FloatArray, IndexArray, FloatArray]:
    """Return the distance, the face and the barycentric coordinates of each nearest point."""
    distance, faces = np.empty(len(points)), np.empty(len(points), np.int32)
    weights = np.empty((len(points), 3))
    face = 0
    for number in curve_order(points):
        point = row(points, number, 0)
        face, square, u, v = nearest_face(point, index, face, np.inf, search)
        distance[number], faces[number] = np.sqrt(square), face
        write_row(weights, number, 0, (max(1.0 - u - v, 0.0), u, v))
    return distance, faces, weights


@leaf_kernel
def nearest_face(
    point: Vector, index: LevelIndex, start: int, within: float, search: Search
) -> tuple[int, float, float, float]:
    """Return the face nearest to a point, the squared distance, and two weights.

    The weights are those of the second and the third corner. Only the time depends on the face
    `start`. Faces farther than `within` need not be found; the answer may then be `start`.
    """
    tree, (nodes, bounds, squares) = index.tree, search
    scale = tree.scale
    here = scaled(scale, minus(point, vector(index.centre)))
    largest = max(abs(point[0]), abs(point[1]), abs(point[2]))
    for axis in range(3):
        largest = max(largest, abs(index.box[0, axis]), abs(index.box[1, axis]))
    margin = MARGIN * largest
    face = start
    square, u, v = _point_in_face(point, index, face)
    limit = ((min(np.sqrt(square), within) + margin) * scale) ** 2
    nodes[0], bounds[0] = 0, 0.0
    height = 1
    while height > 0:
        height -= 1
        if bounds[height] > limit:
            continue
        node = nodes[height]
        set_lower_bounds(here, tree.cylinders, node, squares)
        first = tree.first[node]
        if first < 0:
            for at in range(WIDTH):
                if squares[at] <= limit:
                    other = tree.faces[~first + at]
                    closer, other_u, other_v = _point_in_face(point, index, other)
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
def _point_in_face(point: Vector, index: LevelIndex, face: int) -> tuple[float, float, float]:
    """Return the squared distance of a point from a face, and the weights of two corners.

    The weights are those of the second and the third corner.
    """
    a, b, c = face_corners(index.vertices, index.faces, face)
    return closest_point(minus(point, a), minus(b, a), minus(c, a))
