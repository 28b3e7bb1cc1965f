"""The cones of the faces of a star-shaped surface, and location of points in them.

The cone of a face is the set of all rays from the centre through the face. The cones of a
star-shaped surface fill space without a gap, so every point is in one of them. A walk from cone to
adjacent cone finds it. All positions are relative to the centre.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.corner_table import opposite_corners
from gamutcore.kernels import inlined_kernel, kernel

if TYPE_CHECKING:
    from gamutcore.metric.distance_bound import Surface

__all__ = [
    "INDEX",
    "MOVES",
    "Cones",
    "Locations",
    "compute_cones",
    "find_crossing",
    "locate",
    "relocate",
]

ROUNDING = 1e-15
"""A determinant of three points counts as zero up to this part of the product of their lengths. Its
rounding error is a few times 2⁻⁵³ of the product."""

INDEX = np.uint64
"""Type of indices in inner loops. Unsigned indices need no test for negative numbers, so that loops
can be vectorised."""

MOVES = 1000
"""Steps of a walk before all cones are tried. A walk can go in circles if the triangulation is not
Delaunay. Walks from a face nearby are shorter than this on the largest surfaces."""


class Cones(NamedTuple):
    """The cones of the faces of a star-shaped surface.

    Attributes
    ----------
    neighbour : (F, 3) int32
        The face across the edge opposite to each corner.
    planes : (F, 9) float64
        For each corner, the vector product of the two other corners. It is normal to the plane
        through the centre and the opposite edge, and points into the cone.
    normal : (F, 3) float64
        The vector N with N · p = 1 on the face.
    slope : (F,) float64
        Length of N: 1 ÷ distance of the plane of the face from the centre.
    rounding : (F,) float64
        Products of the planes with unit vectors count as zero up to this value.
    """

    neighbour: IndexArray
    planes: FloatArray
    normal: FloatArray
    slope: FloatArray
    rounding: FloatArray


class Locations(NamedTuple):
    """Locations of points relative to a star-shaped surface.

    Attributes
    ----------
    face : (n,) int32
        The face whose cone has the point.
    beyond : (n,) float64
        N · p − 1: distance of the point from the centre ÷ that of the face on the same ray, − 1.
    along : (n,) float64
        Distance from the face along the ray.
    """

    face: IndexArray
    beyond: FloatArray
    along: FloatArray


def compute_cones(surface: Surface) -> Cones:
    """Return the cones of a closed, oriented surface that is star-shaped about the origin."""
    opposite = opposite_corners(surface.corner.reshape(-1, 3), len(surface.position))
    return Cones(opposite.reshape(-1, 3) // 3, *_cones(surface.position, surface.corner))


@kernel
def _cones(
    position: FloatArray, corner: IndexArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    faces = len(corner) // 3
    planes, normal = np.empty((faces, 9)), np.empty((faces, 3))
    slope, rounding = np.empty(faces), np.empty(faces)
    for face in range(faces):
        one, two, three = corner[3 * face], corner[3 * face + 1], corner[3 * face + 2]
        ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
        bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
        cx, cy, cz = position[three, 0], position[three, 1], position[three, 2]
        planes[face, 0] = by * cz - bz * cy
        planes[face, 1] = bz * cx - bx * cz
        planes[face, 2] = bx * cy - by * cx
        planes[face, 3] = cy * az - cz * ay
        planes[face, 4] = cz * ax - cx * az
        planes[face, 5] = cx * ay - cy * ax
        planes[face, 6] = ay * bz - az * by
        planes[face, 7] = az * bx - ax * bz
        planes[face, 8] = ax * by - ay * bx
        rounding[face] = ROUNDING * max(
            ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz, cx * cx + cy * cy + cz * cz
        )
        # from the edges: a sum of the three planes would lose digits
        bx, by, bz, cx, cy, cz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        x, y, z = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        height = ax * x + ay * y + az * z
        normal[face, 0], normal[face, 1], normal[face, 2] = x / height, y / height, z / height
        slope[face] = np.sqrt(x * x + y * y + z * z) / height
    return planes, normal, slope, rounding


@kernel
def locate(
    position: FloatArray, order: IndexArray, near: IndexArray, cones: Cones, moves: int = MOVES
) -> Locations:
    """Locate points (n, 3), of which none is the origin, in the cones of a surface.

    They are located in the given order. A walk starts from the location of `near`, a close point
    earlier in the order; it is unused for the first point. All cones are tried after `moves` steps.
    """
    count = len(position)
    face, beyond, along = np.empty(count, np.int32), np.empty(count), np.empty(count)
    for index in range(count):
        point = order[INDEX(index)]
        x, y, z = position[INDEX(point), 0], position[INDEX(point), 1], position[INDEX(point), 2]
        radius = np.sqrt(x * x + y * y + z * z)
        start = face[INDEX(near[INDEX(point)])] if index > 0 else 0
        found = _walk(x, y, z, radius, start, cones, moves)
        ratio = (
            cones.normal[INDEX(found), 0] * x
            + cones.normal[INDEX(found), 1] * y
            + cones.normal[INDEX(found), 2] * z
        )
        face[INDEX(point)], beyond[INDEX(point)] = found, ratio - 1.0
        along[INDEX(point)] = abs(1.0 - 1.0 / ratio) * radius
    return Locations(face, beyond, along)


@kernel
def relocate(
    position: FloatArray,
    points: IndexArray,
    cones: Cones,
    locations: Locations,
    moves: int = MOVES,
) -> None:
    """Update the locations of some points, from their present faces.

    `locations` has all points. Their faces may be faces near the points, such as those of another
    level.
    """
    for index in range(len(points)):
        point = points[INDEX(index)]
        face = locations.face[INDEX(point)]
        x, y, z = position[INDEX(point), 0], position[INDEX(point), 1], position[INDEX(point), 2]
        radius = np.sqrt(x * x + y * y + z * z)
        face = _walk(x, y, z, radius, face, cones, moves)
        ratio = (
            cones.normal[INDEX(face), 0] * x
            + cones.normal[INDEX(face), 1] * y
            + cones.normal[INDEX(face), 2] * z
        )
        locations.face[INDEX(point)], locations.beyond[INDEX(point)] = face, ratio - 1.0
        locations.along[INDEX(point)] = abs(1.0 - 1.0 / ratio) * radius


@inlined_kernel
def _walk(x: float, y: float, z: float, radius: float, face: int, cones: Cones, moves: int) -> int:
    """Walk to the face whose cone has a point, across the plane the point is furthest behind."""
    planes = cones.planes
    for _ in range(moves):
        one = planes[INDEX(face), 0] * x + planes[INDEX(face), 1] * y + planes[INDEX(face), 2] * z
        two = planes[INDEX(face), 3] * x + planes[INDEX(face), 4] * y + planes[INDEX(face), 5] * z
        three = planes[INDEX(face), 6] * x + planes[INDEX(face), 7] * y + planes[INDEX(face), 8] * z
        through, least = 0, one
        if two < least:
            through, least = 1, two
        if three < least:
            through, least = 2, three
        if least >= -cones.rounding[INDEX(face)] * radius:
            return face
        face = cones.neighbour[INDEX(face), through]
    chosen, best = face, -np.inf
    for face in range(len(planes)):
        one = planes[INDEX(face), 0] * x + planes[INDEX(face), 1] * y + planes[INDEX(face), 2] * z
        two = planes[INDEX(face), 3] * x + planes[INDEX(face), 4] * y + planes[INDEX(face), 5] * z
        three = planes[INDEX(face), 6] * x + planes[INDEX(face), 7] * y + planes[INDEX(face), 8] * z
        least = min(one, two, three) / (abs(one) + abs(two) + abs(three))
        if least > best:
            chosen, best = face, least
    return chosen


@inlined_kernel
def _plane_product(
    planes: FloatArray, face: int, side: int, position: FloatArray, vertex: int
) -> float:
    """Product of a vertex with a plane of a cone, positive on the side of the cone."""
    product: float = (
        planes[INDEX(face), INDEX(3 * side)] * position[INDEX(vertex), 0]
        + planes[INDEX(face), INDEX(3 * side + 1)] * position[INDEX(vertex), 1]
        + planes[INDEX(face), INDEX(3 * side + 2)] * position[INDEX(vertex), 2]
    )
    return product


@inlined_kernel
def find_crossing(
    position: FloatArray, one: int, two: int, three: int, face: int, beyond: int, cones: Cones
) -> tuple[bool, float, float]:
    """Find where a triangle with two corners in a cone leaves the cone through a single plane.

    The first result states whether the cones of `face` and `beyond` hold the whole triangle. The
    others are the parts in the cone of `face` of the edges from the second and the first to the
    third corner.
    """
    side = -1
    for candidate in range(3):
        if cones.neighbour[INDEX(face), candidate] == beyond:
            side = candidate
    if side < 0:
        return False, 0.0, 0.0
    planes = cones.planes
    start_one = _plane_product(planes, face, side, position, one)
    start_two = _plane_product(planes, face, side, position, two)
    end = _plane_product(planes, face, side, position, three)
    if not (start_one > 0.0 and start_two > 0.0 and end < 0.0):
        return False, 0.0, 0.0
    from_one, from_two = start_one / (start_one - end), start_two / (start_two - end)
    for turn in range(1, 3):
        other = (side + turn) % 3
        start_one = _plane_product(planes, face, other, position, one)
        start_two = _plane_product(planes, face, other, position, two)
        end = _plane_product(planes, face, other, position, three)
        if (
            start_one + from_one * (end - start_one) < 0.0
            or start_two + from_two * (end - start_two) < 0.0
        ):
            return False, 0.0, 0.0
    return True, from_two, from_one
