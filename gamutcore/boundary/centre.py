"""Points and centre of a boundary: validation, rounding to the grid, and the automatic centre.

All boundary methods use these functions, so they refuse the same input with the same messages.

A face sees the points of a half-space from inside. The points that all faces see form a convex
body. Geometry calls it the kernel of a star-shaped body. Here it is the star-kernel, because a
kernel is a compiled function in this project. Its deepest point is the centre of the largest ball
in the body (Chebyshev centre), a linear programme in four unknowns. The dual simplex method solves
it: four planes determine a point, and the plane that is violated most replaces one of the four
(Dantzig, "Linear Programming and Extensions", 1963).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.boundary.radial_hull import radial_hull
from gamutcore.errors import (
    CentreError,
    FlatPointsError,
    InvalidPointsError,
    OptionError,
    TooFewPointsError,
)
from gamutcore.geometry import (
    Vector,
    cross,
    curve_positions,
    dot,
    grid_step,
    insertion_order,
    minus,
    nearest_grid_points,
    plus,
    row,
    triple,
    write_row,
)
from gamutcore.kernels import inlined_kernel, kernel
from gamutcore.number_text import number_text

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

LARGEST_COORDINATE = 1e12
"""Larger coordinates are refused: products of several coordinates must stay far from overflow."""

FLATNESS = 1e-6
"""Points are flat if their hull fills less than this share of the cube of their largest extent."""

SIMPLEX_PART = 1 / 48
"""Lower bound of the volume of the simplex of `_point_inside` ÷ volume of the hull. The hull
lies in a box twice as long, wide and high as the simplex, and a tetrahedron is a sixth of its
box."""

SAMPLE = 1000
"""Number of points in which a simplex is searched first. The points are in random order."""

MAX_EXCHANGES = 2000
"""Largest number of exchanged planes. Real gamuts need 10 to 100."""

GAP = 1e-4
"""Relative difference to the largest margin at which the search ends. Thousands of faces are almost
equally far from the middle of a ball."""

TOLERANCE = 1e-9
"""The same for margins near zero, relative to the extent of the surface."""

FAR_PLANES = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / np.sqrt(3)
"""Normals of a regular tetrahedron around the surface, where the search starts."""

FAR = 4.0
"""Distance of these planes from the middle, in extents of the surface."""


class Centre(NamedTuple):
    """A centre, how it was found, and how deep inside of the surface it is.

    Attributes
    ----------
    point : (3,) float64
    origin : str
        ``"middle of the bounding box"`` or ``"centroid of the convex hull"`` of points;
        ``"star-kernel"``, ``"least hidden area"`` or ``"deep point within the faces"`` of a
        device's surface; ``"the option centre"``.
    depth : float or None
        Distance from the nearest plane of a face: of the convex hull of points, or of the faces of
        a device's surface that are not hidden. None if it is not known.
    hidden : float
        Share of the area of a device's surface that turns its back to the centre.
    """

    point: FloatArray
    origin: str
    depth: float | None = None
    hidden: float = 0.0


def points_on_grid(points: ArrayLike) -> tuple[FloatArray, float]:
    """Return (n, 3) points rounded to their grid, and the step of the grid.

    Points that are not finite, not below 10¹², or not at least four distinct ones raise an
    `InvalidPointsError` or a `TooFewPointsError`.
    """
    try:
        # without this, NumPy drops imaginary parts and only warns
        array = np.asarray(points, None if np.iscomplexobj(points) else np.float64)
    except (TypeError, ValueError) as cause:
        raise InvalidPointsError(
            f"The points are not numbers: {cause}.", remedy="Give an (n, 3) array of numbers."
        ) from cause
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype != np.float64:
        raise InvalidPointsError(
            f"The points have the shape {array.shape} and the type {array.dtype}.",
            remedy="Give an (n, 3) array of real numbers.",
        )
    faulty = np.flatnonzero(~(np.abs(array) < LARGEST_COORDINATE).all(axis=1))
    if faulty.size:
        raise InvalidPointsError(
            f"{faulty.size} of {len(array)} points are not finite or too large. The first is point "
            f"{faulty[0]}: {array[faulty[0]].tolist()}.",
            where={"row": int(faulty[0])},
            remedy=f"Give finite numbers below {number_text(LARGEST_COORDINATE)}.",
        )
    step = grid_step(array) if len(array) else 1.0
    rounded = np.ascontiguousarray(nearest_grid_points(array, step))  # for kernels
    distinct = len(np.unique(rounded, axis=0)) if len(rounded) < 1000 else 4
    if distinct < 4:
        raise TooFewPointsError(
            f"The number of distinct points is {distinct}, which enclose no volume.",
            remedy="Give at least four points that are not in one plane.",
        )
    return rounded, step


@kernel
def bounds(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the smallest and largest coordinates; many times faster than NumPy's reductions."""
    lowest, highest = points[0].copy(), points[0].copy()
    for index in range(len(points)):
        for axis in range(3):
            lowest[axis] = min(lowest[axis], points[index, axis])
            highest[axis] = max(highest[axis], points[index, axis])
    return lowest, highest


def centre_on_grid(centre: object, points: FloatArray, step: float) -> FloatArray | None:
    """Return a given centre rounded to the grid of the points; None for "auto".

    The centre is inside the bounding box of the points, but not always inside their hull.
    """
    if isinstance(centre, str) and centre == "auto":
        return None
    try:
        position = np.asarray(centre, np.float64)
    except (TypeError, ValueError):
        position = np.empty(0)
    if position.shape != (3,) or not (np.abs(position) < LARGEST_COORDINATE).all():
        raise OptionError(
            f"The centre is {centre!r}.",
            where={"field": "centre"},
            remedy="Give 'auto' or three finite numbers.",
        )
    rounded = nearest_grid_points(position, step)
    lowest, highest = bounds(points)
    if not ((lowest < rounded) & (rounded < highest)).all():
        automatic_centre(points, step)  # raises the better error if the points are flat
        raise CentreError(
            f"The centre {tuple(rounded.tolist())} is not inside the points, which extend from"
            f" {lowest.tolist()} to {highest.tolist()}.",
            where={"field": "centre"},
            remedy="Give a point inside the gamut, or 'auto'.",
        )
    return rounded


def centre_of_points(points: ArrayLike) -> Centre:
    """Return the automatic centre of points that are not yet on a grid."""
    rounded, step = points_on_grid(points)
    order = insertion_order(curve_positions(rounded - sum(bounds(rounded)) / 2))
    return automatic_centre(rounded[order], step)


def automatic_centre(points: FloatArray, step: float) -> Centre:
    """Return the middle of the points' bounding box, or the centroid of their hull.

    From the middle, radii meet the surface of a display or a press nearly at right angles, and the
    modified hull overshoots least (figures: ``docs/decisions/centre.md``). The centroid is used
    where the middle is outside of the hull or close to its surface. The result is on the grid, and
    strictly inside a hull that is thicker than a few steps.
    """
    lowest, highest = bounds(points)
    extent, middle = float((highest - lowest).max()), (lowest + highest) / 2
    # the grid is fine enough to stay inside, and differences from points are exact on it: coplanar
    # faces are recognised only with exact differences
    inside = _point_inside(points[:SAMPLE], extent)
    if inside is None:
        inside = _point_inside(points, extent)
    if inside is None:
        raise FlatPointsError(
            "The points are nearly in one place, on one line or in one plane: the volume of their"
            f" hull is less than {number_text(FLATNESS)} of the cube of their extent.",
            remedy="Give points that enclose a volume.",
        )
    inside = nearest_grid_points(inside, step * 2.0**-20)
    relative = points - inside
    faces = radial_hull(relative)
    volume, *moment = _moments(relative, faces)
    if volume < FLATNESS * extent**3:
        raise FlatPointsError(
            f"The points are flat: their hull fills {number_text(volume / extent**3, 2)} of the "
            "cube of their extent.",
            remedy="Give points that enclose a volume.",
        )
    centroid = np.array(moment) / volume
    middle_depth = _depth(relative, faces, middle - inside)
    depth = _depth(relative, faces, centroid)
    if middle_depth >= 0.5 * depth:
        point = nearest_grid_points(middle, step)
        return Centre(point, "middle of the bounding box", middle_depth)
    point = nearest_grid_points(inside + centroid, step)
    return Centre(point, "centroid of the convex hull", depth)


def _point_inside(points: FloatArray, extent: float) -> FloatArray | None:
    """Centroid of a large simplex of points; None if all such simplices are flat.

    Each vertex is the point farthest from the point, line or plane of the vertices before. The
    first is an extreme point.
    """
    if not extent > 0:
        return None
    lowest, highest = bounds(points)
    start = points[points[:, (highest - lowest).argmax()].argmin()]
    relative = (points - start) / extent
    squares = np.einsum("ij,ij->i", relative, relative)
    second = relative[squares.argmax()]
    if not second.any():
        return None
    third = relative[(squares - (relative @ second) ** 2 / (second @ second)).argmax()]
    normal = np.cross(second, third)
    heights = np.abs(relative @ normal)
    fourth = relative[heights.argmax()]
    if heights.max() / 6 < FLATNESS * SIMPLEX_PART:
        return None
    return np.asarray(start + (second + third + fourth) / 4 * extent)


@kernel
def _moments(points: FloatArray, faces: IndexArray) -> tuple[float, float, float, float]:
    """Volume of a closed surface around the origin, and its integrals of x, y and z."""
    volume, along_x, along_y, along_z = 0.0, 0.0, 0.0, 0.0
    for face in range(len(faces)):
        a, b = row(points, faces[face, 0], 0), row(points, faces[face, 1], 0)
        c = row(points, faces[face, 2], 0)
        part = triple(a, b, c) / 6.0
        x, y, z = plus(plus(a, b), c)
        volume += part
        along_x += part * x / 4.0
        along_y += part * y / 4.0
        along_z += part * z / 4.0
    return volume, along_x, along_y, along_z


@inlined_kernel
def _corner_and_normal(points: FloatArray, faces: IndexArray, face: int) -> tuple[Vector, Vector]:
    """Return the first corner of a face, and its normal, twice as long as the area."""
    a, b = row(points, faces[face, 0], 0), row(points, faces[face, 1], 0)
    return a, cross(minus(b, a), minus(row(points, faces[face, 2], 0), a))


@kernel
def _depth(points: FloatArray, faces: IndexArray, point: FloatArray) -> float:
    """Smallest distance of a point from the planes of a convex surface; negative outside."""
    depth = np.inf
    for face in range(len(faces)):
        corner, normal = _corner_and_normal(points, faces, face)
        below = dot(normal, minus(corner, (point[0], point[1], point[2])))
        depth = min(depth, below / np.sqrt(dot(normal, normal)))
    return depth


class Planes(NamedTuple):
    """Planes of faces: the inside of face i has ``normals[i] @ point <= offsets[i]``."""

    normals: FloatArray  # (n, 3) unit vectors; zero for a face without area
    offsets: FloatArray  # (n,) infinite for a face without area
    areas: FloatArray  # (n,)


class StarKernelPoint(NamedTuple):
    """A point well inside the star-kernel, or the proof that the star-kernel is empty."""

    point: FloatArray  # (3,)
    # distance of the point from the nearest plane of a face, within `GAP` of the largest possible
    # distance; not positive if no point sees all faces from inside: the planes would have to move
    # outwards by at least this distance
    margin: float
    decisive: LongArray  # (k,) at most four faces that determine the margin


def star_kernel_point(planes: Planes, extent: float) -> StarKernelPoint:
    """Return the point farthest inside of the planes of a closed surface around the origin.

    Faces without area are ignored. Tolerances are relative to `extent`, the largest extent of the
    surface.
    """
    rows = np.column_stack([FAR_PLANES, np.ones(4)])
    limits = np.full(4, FAR * extent)
    chosen, weights = np.full(4, -1), np.full(4, 0.25)
    deepest, most, margin = np.zeros(3), -np.inf, np.inf
    for _ in range(MAX_EXCHANGES):
        # the point that is equally far from the four planes has an upper bound of the margin
        *coordinates, margin = np.linalg.solve(rows, limits)
        point = np.array(coordinates)
        entering, room = _nearest_plane(planes, point)
        if room > most:
            deepest, most = point, room
        if most >= margin - max(TOLERANCE * extent, GAP * margin):
            break
        row = np.append(planes.normals[entering], 1.0)
        shares = np.linalg.solve(rows.T, row)
        ratios = np.where(shares > TOLERANCE, weights / np.maximum(shares, TOLERANCE), np.inf)
        leaving = int(ratios.argmin())
        step = ratios[leaving]
        weights = np.maximum(weights - step * shares, 0.0)
        rows[leaving], limits[leaving] = row, planes.offsets[entering]
        chosen[leaving], weights[leaving] = entering, step
    return StarKernelPoint(deepest, float(min(most, margin)), chosen[chosen >= 0])


@kernel
def face_planes(points: FloatArray, faces: IndexArray) -> Planes:
    """Return the planes of faces that are counter-clockwise from outside."""
    count = len(faces)
    normals, offsets, areas = np.zeros((count, 3)), np.empty(count), np.empty(count)
    for face in range(count):
        corner, normal = _corner_and_normal(points, faces, face)
        length = np.sqrt(dot(normal, normal))
        areas[face], offsets[face] = length / 2.0, np.inf
        if length > 0.0:
            write_row(
                normals, face, 0, (normal[0] / length, normal[1] / length, normal[2] / length)
            )
            offsets[face] = dot(normal, corner) / length
    return Planes(normals, offsets, areas)


@kernel
def _nearest_plane(planes: Planes, point: FloatArray) -> tuple[int, float]:
    """The plane with the least room between itself and a point, and this room."""
    nearest, least = 0, np.inf
    for face in range(len(planes.offsets)):
        along = dot(row(planes.normals, face, 0), (point[0], point[1], point[2]))
        room = planes.offsets[face] - along
        if room < least:
            nearest, least = face, room
    return nearest, least
