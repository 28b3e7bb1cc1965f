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
from gamutcore.geometry import TERMS, cell_of, curve_order, orientation, row
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.queries.face_tree import STACK, WIDTH
from gamutcore.queries.index import Level, LevelIndex, as_index, checked_points
from gamutcore.queries.nearest import nearest_face

__all__ = ["contains", "is_inside", "signed_distance"]

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
    MeshError
        As for `build_index`.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> points = [(0.2, 0.2, 0.2), (0.5, 0.5, 0.0), (0.5, 0.5, 0.1)]
    >>> contains(points, tetrahedron).tolist(), contains(points, tetrahedron, 0.1).tolist()
    ([True, True, False], [True, True, True])
    """
    return _contains(checked_points(points), as_index(level), float(tolerance))


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
    return _signed_distance(checked_points(points), as_index(level))


@kernel
def _contains(points: FloatArray, index: LevelIndex, tolerance: float) -> BooleanArray:
    inside = np.empty(len(points), np.bool_)
    nodes, bounds, squares = np.empty(STACK, np.int64), np.empty(STACK), np.empty(WIDTH)
    terms = np.empty(TERMS)
    # A level is star-shaped about each point of the ball with the radius `inner`. If the surface
    # is within the tolerance of a point, the point is therefore inside after it is moved towards
    # the centre by this factor. The test of the moved point is much faster than the distance.
    centre, share, face = index.centre, index.inner / max(index.inner + SAFE * tolerance, TINY), 0
    for number in range(len(points)):
        x, y, z = row(points, number, 0)
        inside[number] = is_inside(x, y, z, index, terms)
        if inside[number] or tolerance == 0.0:
            continue
        moved_x = centre[0] + share * (x - centre[0])
        moved_y = centre[1] + share * (y - centre[1])
        moved_z = centre[2] + share * (z - centre[2])
        if not is_inside(moved_x, moved_y, moved_z, index, terms):
            continue
        face, square, _, _ = nearest_face(x, y, z, index, face, tolerance, nodes, bounds, squares)
        inside[number] = square <= tolerance * tolerance
    return inside


@kernel
def _signed_distance(points: FloatArray, index: LevelIndex) -> FloatArray:
    distance = np.empty(len(points))
    nodes, bounds, squares = np.empty(STACK, np.int64), np.empty(STACK), np.empty(WIDTH)
    terms = np.empty(TERMS)
    face = 0
    for number in curve_order(points):
        x, y, z = row(points, number, 0)
        face, square, _, _ = nearest_face(x, y, z, index, face, np.inf, nodes, bounds, squares)
        length = np.sqrt(square)
        distance[number] = 0.0 - length if is_inside(x, y, z, index, terms) else length
    return distance


NEAR = 2.0**-10
"""Part of the farthest vertex's distance from the centre beyond which the cell is certain."""


@leaf_kernel
def is_inside(px: float, py: float, pz: float, index: LevelIndex, terms: FloatArray) -> bool:
    """Whether a point is inside a level, or on its surface. `terms` (TERMS,) is a work array."""
    box, planes = index.box, index.planes
    if (
        px < box[0, 0]
        or px > box[1, 0]
        or py < box[0, 1]
        or py > box[1, 1]
        or pz < box[0, 2]
        or pz > box[1, 2]
    ):
        return False
    x, y, z = px - index.centre[0], py - index.centre[1], pz - index.centre[2]
    if x * x + y * y + z * z < index.inner * index.inner:
        return True
    cell = cell_of((x, y, z), index.resolution)
    for place in range(index.cell_start[cell], index.cell_start[cell + 1]):
        face = np.uint64(index.cell_faces[place])
        if (
            planes[face, 0] * x + planes[face, 1] * y + planes[face, 2] * z > 1.0
            and planes[face, 3] * x + planes[face, 4] * y + planes[face, 5] * z > 1.0
            and planes[face, 6] * x + planes[face, 7] * y + planes[face, 8] * z > 1.0
        ):
            below = planes[face, 12] - (
                planes[face, 9] * x + planes[face, 10] * y + planes[face, 11] * z
            )
            if below > 1.0:
                return True
            if below < -1.0:
                return False
            return _height(px, py, pz, index, index.cell_faces[place], terms) >= 0.0
    return _is_inside_exactly(px, py, pz, index, cell, terms)


@leaf_kernel
def _is_inside_exactly(
    px: float, py: float, pz: float, index: LevelIndex, cell: int, terms: FloatArray
) -> bool:
    x, y, z = px - index.centre[0], py - index.centre[1], pz - index.centre[2]
    if x * x + y * y + z * z > (NEAR / index.tree.scale) ** 2:
        # the signs of the cones do not matter if the heights of all possible faces agree
        below = above = 0
        for place in range(index.cell_start[cell], index.cell_start[cell + 1]):
            face = index.cell_faces[place]
            if _may_be_in_cone(x, y, z, index, face):
                if _height(px, py, pz, index, face, terms) >= 0.0:
                    below += 1
                else:
                    above += 1
        if above == 0 and below > 0:
            return True
        if below == 0 and above > 0:
            return False
    for place in range(index.cell_start[cell], index.cell_start[cell + 1]):
        face = index.cell_faces[place]
        if _in_cone(px, py, pz, index, face, terms):
            return _height(px, py, pz, index, face, terms) >= 0.0
    # rounding has moved the direction out of the cell: the point is very near the centre
    for face in range(len(index.faces)):
        if _in_cone(px, py, pz, index, face, terms):
            return _height(px, py, pz, index, face, terms) >= 0.0
    return False


@leaf_kernel
def _may_be_in_cone(x: float, y: float, z: float, index: LevelIndex, face: int) -> bool:
    """Whether a point relative to the centre may be in the cone of a face, within rounding."""
    planes = index.planes
    return (
        planes[face, 0] * x + planes[face, 1] * y + planes[face, 2] * z >= -1.0
        and planes[face, 3] * x + planes[face, 4] * y + planes[face, 5] * z >= -1.0
        and planes[face, 6] * x + planes[face, 7] * y + planes[face, 8] * z >= -1.0
    )


@leaf_kernel
def _in_cone(
    px: float, py: float, pz: float, index: LevelIndex, face: int, terms: FloatArray
) -> bool:
    """Whether a point is in the closed cone of a face. Every point is in one at least."""
    centre = index.centre[0], index.centre[1], index.centre[2]
    for at in range(3):
        one = row(index.vertices, index.faces[face, at], 0)
        two = row(index.vertices, index.faces[face, (at + 1) % 3], 0)
        if orientation(one, two, (px, py, pz), centre, terms) < 0.0:
            return False
    return True


@leaf_kernel
def _height(
    px: float, py: float, pz: float, index: LevelIndex, face: int, terms: FloatArray
) -> float:
    """Return a positive number below the plane of a face, 0 on it, a negative one above."""
    a = row(index.vertices, index.faces[face, 0], 0)
    b = row(index.vertices, index.faces[face, 1], 0)
    c = row(index.vertices, index.faces[face, 2], 0)
    return orientation(a, b, c, (px, py, pz), terms)
