"""In gamut: whether points are inside a level, decided without rounding errors.

A level is star-shaped about its centre. A point is therefore inside if it is not beyond the face
whose cone it is in. The cube map of the index gives a few candidates for the face. Points outside
the box, or in the ball around the centre, need none. Where the sign of a product is uncertain in
float64, the exact determinant decides: points near the planes through the edges, or near a face.

A determinant is first computed in float64 with a bound of its error. If the bound leaves the sign
open, the determinant is summed up exactly as an expansion: a list of floats whose bits do not
overlap, in increasing order. The last float then has the sign of the sum.

Source of the exact predicates: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and
Fast Robust Geometric Predicates", Discrete & Computational Geometry 18 (1997): two-sum,
two-product, Theorem 10 (grow-expansion) and the error bound of ORIENT3D in section 4.3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import BooleanArray, FloatArray
from gamutcore.geometry import curve_order
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.queries.face_tree import STACK, WIDTH
from gamutcore.queries.index import Level, LevelIndex, as_index, cell_of, checked_points
from gamutcore.queries.nearest import nearest_face

__all__ = [
    "TERMS",
    "add_product",
    "area",
    "contains",
    "is_inside",
    "moved_orientation",
    "orientation",
    "sign_of",
    "signed_distance",
]

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
    for row in range(len(points)):
        x, y, z = points[row, 0], points[row, 1], points[row, 2]
        inside[row] = is_inside(x, y, z, index, terms)
        if inside[row] or tolerance == 0.0:
            continue
        moved_x = centre[0] + share * (x - centre[0])
        moved_y = centre[1] + share * (y - centre[1])
        moved_z = centre[2] + share * (z - centre[2])
        if not is_inside(moved_x, moved_y, moved_z, index, terms):
            continue
        face, square, _, _ = nearest_face(x, y, z, index, face, tolerance, nodes, bounds, squares)
        inside[row] = square <= tolerance * tolerance
    return inside


@kernel
def _signed_distance(points: FloatArray, index: LevelIndex) -> FloatArray:
    distance = np.empty(len(points))
    nodes, bounds, squares = np.empty(STACK, np.int64), np.empty(STACK), np.empty(WIDTH)
    terms = np.empty(TERMS)
    face = 0
    for row in curve_order(points):
        x, y, z = points[row, 0], points[row, 1], points[row, 2]
        face, square, _, _ = nearest_face(x, y, z, index, face, np.inf, nodes, bounds, squares)
        length = np.sqrt(square)
        distance[row] = 0.0 - length if is_inside(x, y, z, index, terms) else length
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
    cell = cell_of(x, y, z, index.resolution)
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
    vertices, centre = index.vertices, index.centre
    for at in range(3):
        one, two = index.faces[face, at], index.faces[face, (at + 1) % 3]
        side = orientation(
            vertices[one, 0],
            vertices[one, 1],
            vertices[one, 2],
            vertices[two, 0],
            vertices[two, 1],
            vertices[two, 2],
            px,
            py,
            pz,
            centre[0],
            centre[1],
            centre[2],
            terms,
        )
        if side < 0.0:
            return False
    return True


@leaf_kernel
def _height(
    px: float, py: float, pz: float, index: LevelIndex, face: int, terms: FloatArray
) -> float:
    """Return a positive number below the plane of a face, 0 on it, a negative one above."""
    vertices = index.vertices
    one, two, three = index.faces[face, 0], index.faces[face, 1], index.faces[face, 2]
    return orientation(
        vertices[one, 0],
        vertices[one, 1],
        vertices[one, 2],
        vertices[two, 0],
        vertices[two, 1],
        vertices[two, 2],
        vertices[three, 0],
        vertices[three, 1],
        vertices[three, 2],
        px,
        py,
        pz,
        terms,
    )


TERMS = 160
"""Length of the work array: 36 products of three floats in `moved_orientation` have 144 terms."""

SPLITTER = 2.0**27 + 1.0
"""Splits a float64 into two halves of 26 bits."""

BOUND = (7.0 + 56.0 * 2.0**-53) * 2.0**-53
"""Error of the determinant in float64 ÷ the sum of the magnitudes of its terms."""


@leaf_kernel
def _two_sum(a: float, b: float) -> tuple[float, float]:
    """Return a + b rounded, and the rounding error."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@leaf_kernel
def _two_product(a: float, b: float) -> tuple[float, float]:
    """Return a · b rounded, and the rounding error."""
    product = a * b
    scaled = SPLITTER * a
    a_high = scaled - (scaled - a)
    a_low = a - a_high
    scaled = SPLITTER * b
    b_high = scaled - (scaled - b)
    b_low = b - b_high
    rest = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
    return product, rest


@leaf_kernel
def _add_term(terms: FloatArray, count: int, term: float) -> int:
    """Add a float to an expansion of `count` terms, and return the new number of terms."""
    kept = 0
    for index in range(count):
        term, rest = _two_sum(term, terms[index])
        if rest != 0.0:
            terms[kept] = rest
            kept += 1
    if term != 0.0:
        terms[kept] = term
        kept += 1
    return kept


@leaf_kernel
def add_product(terms: FloatArray, count: int, a: float, b: float, c: float) -> int:
    """Add a · b · c to an expansion, and return the new number of terms."""
    product, rest = _two_product(a, b)
    high, low = _two_product(product, c)
    if low != 0.0:
        count = _add_term(terms, count, low)
    count = _add_term(terms, count, high)
    if rest != 0.0:
        high, low = _two_product(rest, c)
        if low != 0.0:
            count = _add_term(terms, count, low)
        count = _add_term(terms, count, high)
    return count


@leaf_kernel
def sign_of(terms: FloatArray, count: int) -> float:
    """Return the largest term of an expansion, which has its sign, or 0."""
    return terms[count - 1] if count > 0 else 0.0


@leaf_kernel
def _add_determinant(
    terms: FloatArray,
    count: int,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    cx: float,
    cy: float,
    cz: float,
) -> int:
    count = add_product(terms, count, by, cz, ax)
    count = add_product(terms, count, bz, cy, -ax)
    count = add_product(terms, count, bz, cx, ay)
    count = add_product(terms, count, bx, cz, -ay)
    count = add_product(terms, count, bx, cy, az)
    return add_product(terms, count, by, cx, -az)


@leaf_kernel
def orientation(
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    cx: float,
    cy: float,
    cz: float,
    px: float,
    py: float,
    pz: float,
    terms: FloatArray,
) -> float:
    """Return a number with the exact sign of det(a − p, b − p, c − p).

    It is positive if p, as a centre does, sees a, b, c counter-clockwise from inside, and 0 for
    points in a plane. Coordinates are 0 or of magnitudes from 1e-80 to 1e80, which rules out
    overflow and underflow. The relative error is about 2⁻⁵⁰ where the determinant exceeds its
    rounding error. `terms` (TERMS,) is a work array.
    """
    ux, uy, uz = ax - px, ay - py, az - pz
    vx, vy, vz = bx - px, by - py, bz - pz
    wx, wy, wz = cx - px, cy - py, cz - pz
    x1, x2 = vy * wz, vz * wy
    y1, y2 = vz * wx, vx * wz
    z1, z2 = vx * wy, vy * wx
    determinant = ux * (x1 - x2) + uy * (y1 - y2) + uz * (z1 - z2)
    magnitude = (
        abs(ux) * (abs(x1) + abs(x2))
        + abs(uy) * (abs(y1) + abs(y2))
        + abs(uz) * (abs(z1) + abs(z2))
    )
    if abs(determinant) > BOUND * magnitude:
        return determinant
    count = _add_determinant(terms, 0, ax, ay, az, bx, by, bz, cx, cy, cz)
    count = _add_determinant(terms, count, -px, -py, -pz, bx, by, bz, cx, cy, cz)
    count = _add_determinant(terms, count, ax, ay, az, -px, -py, -pz, cx, cy, cz)
    count = _add_determinant(terms, count, ax, ay, az, bx, by, bz, -px, -py, -pz)
    return sign_of(terms, count)


@leaf_kernel
def moved_orientation(
    ex: float,
    ey: float,
    ez: float,
    sx: float,
    sy: float,
    sz: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    px: float,
    py: float,
    pz: float,
    terms: FloatArray,
) -> float:
    """Return a number with the exact sign of det(e − s, a − p, b − p), as for `orientation`.

    It is 0 if the direction from s to e is parallel to the plane through a, b and p.
    """
    count = _add_determinant(terms, 0, ex, ey, ez, ax, ay, az, bx, by, bz)
    count = _add_determinant(terms, count, ex, ey, ez, -px, -py, -pz, bx, by, bz)
    count = _add_determinant(terms, count, ex, ey, ez, ax, ay, az, -px, -py, -pz)
    count = _add_determinant(terms, count, -sx, -sy, -sz, ax, ay, az, bx, by, bz)
    count = _add_determinant(terms, count, -sx, -sy, -sz, -px, -py, -pz, bx, by, bz)
    count = _add_determinant(terms, count, -sx, -sy, -sz, ax, ay, az, -px, -py, -pz)
    return sign_of(terms, count)


@leaf_kernel
def area(
    ax: float, ay: float, bx: float, by: float, px: float, py: float, terms: FloatArray
) -> float:
    """Return a number with the exact sign of det(a − p, b − p) in a plane, as for `orientation`."""
    count = add_product(terms, 0, ax, by, 1.0)
    count = add_product(terms, count, ax, -py, 1.0)
    count = add_product(terms, count, px, -by, 1.0)
    count = add_product(terms, count, ay, -bx, 1.0)
    count = add_product(terms, count, ay, px, 1.0)
    count = add_product(terms, count, py, bx, 1.0)
    return sign_of(terms, count)
