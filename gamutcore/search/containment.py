"""In gamut: whether points are inside a level, decided without rounding errors.

A level is star-shaped about its centre. A point is therefore inside if it is not beyond the face
whose cone it is in. The cube map of the index gives a few candidates for the face. Points outside
the box, or in the ball around the centre, need none. Where the sign of a product is uncertain in
float64, the exact determinant decides: points near the planes through the edges, or near a face.

The exact determinants are those of `gamutcore.geometry.predicates`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import BooleanArray, FloatArray
from gamutcore.geometry import (
    TERMS,
    Vector,
    cell_of,
    cone_products,
    curve_order,
    dot,
    face_corners,
    minus,
    orientation,
    plus,
    row,
    scaled,
    vector,
)
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.search.face_tree import Search, new_search
from gamutcore.search.index import Level, LevelIndex, as_index, checked_points
from gamutcore.search.nearest import nearest_face

__all__ = ["contains", "height_of", "is_inside", "signed_distance"]

SAFE = 1.001
"""Factor of a tolerance that covers the rounding of a point that is moved towards the centre."""

TINY = 1e-300
"""Divisor in place of 0."""


def contains(points: ArrayLike, level: Level, tolerance: float = 0.0) -> BooleanArray:
    """Whether points are in gamut: inside a level, on its surface, or within a distance of it.

    Parameters
    ----------
    points : (n, 3) array_like
        In the colour space of the level.
    level : LevelIndex or (vertices, faces, centre)
    tolerance : float, optional
        Largest distance of a point outside.

    Returns
    -------
    (n,) bool
        With a tolerance of 0: exact for the given floats, if their magnitudes are 0 or at least
        1e-80.

    Raises
    ------
    InvalidPointsError
        A point is not three finite numbers; ``where["row"]`` names it.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> points = [(0.2, 0.2, 0.2), (0.5, 0.5, 0.0), (0.5, 0.5, 0.1)]
    >>> contains(points, tetrahedron).tolist(), contains(points, tetrahedron, 0.1).tolist()
    ([True, True, False], [True, True, True])
    """
    return _contains(checked_points(points), as_index(level), float(tolerance), new_search())


def signed_distance(points: ArrayLike, level: Level) -> FloatArray:
    """Return the distances of points from a level's surface, negative inside.

    Parameters
    ----------
    points : (n, 3) array_like
        In the colour space of the level.
    level : LevelIndex or (vertices, faces, centre)

    Returns
    -------
    (n,) float64
        The sign is that of `contains`, without rounding errors.

    Raises
    ------
    InvalidPointsError, MeshError
        As for `nearest`.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> signed_distance([(0.25, 0.25, 0.125), (0.25, 0.25, -0.125)], tetrahedron).tolist()
    [-0.125, 0.125]
    """
    return _signed_distance(checked_points(points), as_index(level), new_search())


@kernel
def _contains(
    points: FloatArray, index: LevelIndex, tolerance: float, search: Search
) -> BooleanArray:
    inside = np.empty(len(points), np.bool_)
    terms = np.empty(TERMS)
    # A level is star-shaped about each point of the ball with the radius `inner`. If the surface
    # is within the tolerance of a point, the point is therefore inside after it is moved towards
    # the centre by this factor. The test of the moved point is much faster than the distance.
    share, face = index.inner / max(index.inner + SAFE * tolerance, TINY), 0
    centre = vector(index.centre)
    for number in range(len(points)):
        point = row(points, number, 0)
        inside[number] = is_inside(point, index, terms)
        if inside[number] or tolerance == 0.0:
            continue
        moved = plus(centre, scaled(share, minus(point, centre)))
        if not is_inside(moved, index, terms):
            continue
        face, square, _, _ = nearest_face(point, index, face, tolerance, search)
        inside[number] = square <= tolerance * tolerance
    return inside


@kernel
def _signed_distance(points: FloatArray, index: LevelIndex, search: Search) -> FloatArray:
    distance = np.empty(len(points))
    terms = np.empty(TERMS)
    face = 0
    for number in curve_order(points):
        point = row(points, number, 0)
        face, square, _, _ = nearest_face(point, index, face, np.inf, search)
        length = np.sqrt(square)
        distance[number] = 0.0 - length if is_inside(point, index, terms) else length
    return distance


NEAR = 2.0**-10
"""Part of the farthest vertex's distance from the centre beyond which the cell is certain."""


@leaf_kernel
def is_inside(point: Vector, index: LevelIndex, terms: FloatArray) -> bool:
    """Whether a point is inside a level, or on its surface. `terms` (TERMS,) is a work array."""
    (x, y, z), box, planes = point, index.box, index.planes
    if (
        x < box[0, 0]
        or x > box[1, 0]
        or y < box[0, 1]
        or y > box[1, 1]
        or z < box[0, 2]
        or z > box[1, 2]
    ):
        return False
    relative = minus(point, vector(index.centre))
    if dot(relative, relative) < index.inner * index.inner:
        return True
    cell = cell_of(relative, index.resolution)
    for place in range(index.cell_start[cell], index.cell_start[cell + 1]):
        face = np.uint64(index.cell_faces[place])
        one, two, three = cone_products(planes, face, relative)
        if one > 1.0 and two > 1.0 and three > 1.0:
            below = planes[face, 12] - dot(row(planes, face, 9), relative)
            if below > 1.0:
                return True
            if below < -1.0:
                return False
            return height_of(point, index, index.cell_faces[place], terms) >= 0.0
    return _is_inside_exactly(point, index, cell, terms)


@leaf_kernel
def _is_inside_exactly(point: Vector, index: LevelIndex, cell: int, terms: FloatArray) -> bool:
    relative = minus(point, vector(index.centre))
    if dot(relative, relative) > (NEAR / index.tree.scale) ** 2:
        # the signs of the cones do not matter if the heights of all possible faces agree
        below = above = 0
        for place in range(index.cell_start[cell], index.cell_start[cell + 1]):
            face = index.cell_faces[place]
            if min(cone_products(index.planes, face, relative)) >= -1.0:
                if height_of(point, index, face, terms) >= 0.0:
                    below += 1
                else:
                    above += 1
        if above == 0 and below > 0:
            return True
        if below == 0 and above > 0:
            return False
    for place in range(index.cell_start[cell], index.cell_start[cell + 1]):
        face = index.cell_faces[place]
        if _in_cone(point, index, face, terms):
            return height_of(point, index, face, terms) >= 0.0
    # rounding has moved the direction out of the cell: the point is very near the centre
    for face in range(len(index.faces)):
        if _in_cone(point, index, face, terms):
            return height_of(point, index, face, terms) >= 0.0
    return False


@leaf_kernel
def _in_cone(point: Vector, index: LevelIndex, face: int, terms: FloatArray) -> bool:
    """Whether a point is in the closed cone of a face. Every point is in one at least."""
    a, b, c = face_corners(index.vertices, index.faces, face)
    for one, two in ((a, b), (b, c), (c, a)):
        if orientation(one, two, point, vector(index.centre), terms) < 0.0:
            return False
    return True


@leaf_kernel
def height_of(point: Vector, index: LevelIndex, face: int, terms: FloatArray) -> float:
    """Return a positive number below the plane of a face, 0 on it, a negative one above."""
    a, b, c = face_corners(index.vertices, index.faces, face)
    return orientation(a, b, c, point, terms)
