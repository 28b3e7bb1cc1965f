"""The modified convex hull: an accurate, star-shaped surface around the colours of a device.

Balasubramanian & Dalal, "A method for quantifying the color gamut of an output device" (1997), as
Bakke & Farup use it: the radii of all colours about a centre are raised to the power γ, a convex
hull is taken of the result, and its triangles are kept on the original colours. γ = 1 gives the
convex hull, γ → 0 would put every colour on the surface; in between the surface follows
concavities.

Radial scaling keeps the direction of every point and with it the sign of every face's determinant
about the centre, so the surface is star-shaped because the hull is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.corner_table import opposite_corners
from gamutcore.errors import (
    BoundaryError,
    CentreError,
    FlatPointsError,
    InvalidPointsError,
    OptionError,
    TooFewPointsError,
)
from gamutcore.grid import grid_step, rounded_to_grid
from gamutcore.kernels import kernel
from gamutcore.mesh import TriangleMesh
from gamutcore.star_shape import faces_not_seeing_centre

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["Boundary", "modified_convex_hull"]

LARGEST_COORDINATE = 1e12
"""Coordinates beyond this are refused: products of three and more must stay far from overflow."""

FLATNESS = 1e-6
"""Points are flat if their hull fills less than this part of the cube of their largest extent."""

REPAIRS = 20
"""How often slivers that rounding has turned over are taken out before giving up."""


@dataclass(frozen=True, eq=False)
class Boundary:
    """A full boundary: the surface that decimation starts from.

    Attributes
    ----------
    mesh : TriangleMesh
        Closed, oriented outwards, star-shaped about `centre`; vertices are float32.
    centre : (3,) float64
        Representable in float32.
    sources : (m,) int64
        For each vertex of the mesh, which of the given points it is.
    gamma : float
    """

    mesh: TriangleMesh
    centre: FloatArray
    sources: LongArray
    gamma: float


def modified_convex_hull(
    points: ArrayLike,
    gamma: float = 0.2,
    centre: ArrayLike | Literal["auto"] = "auto",
) -> Boundary:
    """Wrap points in a closed surface that is star-shaped about a centre.

    Parameters
    ----------
    points : (n, 3) array_like
        Colours, in the order of the colour space. They are rounded to float32 first, the precision
        in which a gamut is delivered; duplicates and points at the centre do no harm.
    gamma : float, optional
        Power that radii are raised to, in (0, 1]; 0.2 unless told, 1 for the convex hull.
    centre : (3,) array_like or "auto", optional
        The point radii are taken from; it must lie strictly inside the convex hull of the points.
        "auto" takes the middle of the points' bounding box, or the centroid of their convex hull
        where the middle is outside it or close to it. It is rounded to float32.

    Returns
    -------
    Boundary

    Raises
    ------
    OptionError
        If γ is not in (0, 1] or the centre is not three numbers.
    InvalidPointsError
        If the points are not an (n, 3) array of finite numbers below 10¹².
    TooFewPointsError, FlatPointsError, CentreError
        If the points enclose no volume, or the centre is not inside it.
    BoundaryError
        If no valid surface was found in spite of taking out slivers.

    Notes
    -----
    Rounding can turn over a sliver whose three directions lie (nearly) on one great circle. The
    middle one of the three is then taken out of the set and the hull built again: it lies on the
    line between the other two within rounding, so nothing is lost.
    """
    if not _is_power(gamma):
        raise OptionError(
            f"gamma is {gamma!r}", where={"field": "gamma"}, remedy="a number above 0, at most 1"
        )
    rounded = _checked_points(points)
    if isinstance(centre, str):
        if centre != "auto":
            raise OptionError(
                f"the centre is {centre!r}",
                where={"field": "centre"},
                remedy="'auto' or three numbers",
            )
        middle = rounded_to_grid(_automatic_centre(rounded), grid_step(rounded))
    else:
        middle = _checked_centre(centre, rounded)

    relative = rounded - middle
    radii = np.linalg.norm(relative, axis=1)
    usable: LongArray = np.flatnonzero(radii > radii.max() * 1e-12).astype(np.int64)
    for _ in range(REPAIRS):
        if len(usable) < 4:
            break
        # radii relative to the largest: the power must not leave the range of floats
        scaled = relative[usable] / radii.max()
        transformed = scaled * np.linalg.norm(scaled, axis=1)[:, np.newaxis] ** (gamma - 1.0)
        hull = _qhull(transformed)
        if hull.equations[:, 3].max() > -1e-9:
            raise CentreError(
                f"the centre {tuple(middle.tolist())} is not strictly inside the convex hull of"
                " the points",
                where={"field": "centre"},
                remedy="a point inside the gamut, or 'auto'",
            )
        faces = _outward_faces(hull.simplices, hull.equations, transformed)
        spoilt = _spoilt_vertices(faces, relative[usable])
        if spoilt.size == 0:
            corners, packed = _coherent_order(faces, scaled)
            sources = usable[corners]
            mesh = TriangleMesh(rounded[sources].astype(np.float32), packed)
            return Boundary(mesh, middle, sources, float(gamma))
        usable = np.delete(usable, spoilt)
    raise BoundaryError(
        "no closed surface that is star-shaped about the centre could be wrapped around the points",
        remedy="points that are not nearly in one plane, seen from a centre well inside them",
    )


def _is_power(gamma: object) -> bool:
    real = isinstance(gamma, int | float | np.integer | np.floating) and not isinstance(gamma, bool)
    return real and 0 < float(gamma) <= 1  # type: ignore[arg-type]


def _checked_points(points: ArrayLike) -> FloatArray:
    """Return the points as float64 numbers that float32 can hold."""
    try:
        # without this, NumPy drops imaginary parts and only warns
        given = np.asarray(points, None if np.iscomplexobj(points) else np.float64)
    except (TypeError, ValueError) as cause:
        raise InvalidPointsError(
            f"the points are not numbers: {cause}", remedy="an (n, 3) array of numbers"
        ) from cause
    if given.ndim != 2 or given.shape[1] != 3 or given.dtype != np.float64:
        raise InvalidPointsError(
            f"the points have the shape {given.shape} and the type {given.dtype}",
            remedy="an (n, 3) array of real numbers",
        )
    faulty = np.flatnonzero(~(np.abs(given) < LARGEST_COORDINATE).all(axis=1))
    if faulty.size:
        raise InvalidPointsError(
            f"{faulty.size} of {len(given)} points are not finite or too large, the first of them"
            f" number {faulty[0]}: {given[faulty[0]].tolist()}",
            where={"row": int(faulty[0])},
            remedy=f"finite numbers below {LARGEST_COORDINATE:g}",
        )
    if len(given) < 4:
        raise TooFewPointsError(
            f"{len(given)} points enclose no volume",
            remedy="at least four points that are not in one plane",
        )
    rounded = rounded_to_grid(given, grid_step(given))
    if len(rounded) < 4 or (len(rounded) < 1000 and len(np.unique(rounded, axis=0)) < 4):
        raise TooFewPointsError(
            f"{len(np.unique(rounded, axis=0))} distinct points enclose no volume",
            remedy="at least four points that are not in one plane",
        )
    return rounded


def _checked_centre(centre: ArrayLike, points: FloatArray) -> FloatArray:
    try:
        given = np.asarray(centre, np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape != (3,) or not (np.abs(given) < LARGEST_COORDINATE).all():
        raise OptionError(
            f"the centre is {centre!r}",
            where={"field": "centre"},
            remedy="'auto' or three finite numbers",
        )
    rounded = rounded_to_grid(given, grid_step(points))
    lowest, highest = points.min(axis=0), points.max(axis=0)
    if not ((lowest < rounded) & (rounded < highest)).all():
        _automatic_centre(points)  # flat points are the better explanation where they are flat
        raise CentreError(
            f"the centre {tuple(rounded.tolist())} is not inside the points, which reach from"
            f" {lowest.tolist()} to {highest.tolist()}",
            where={"field": "centre"},
            remedy="a point inside the gamut, or 'auto'",
        )
    return rounded


def _qhull(points: FloatArray) -> ConvexHull:
    try:
        return ConvexHull(points)
    except QhullError as cause:
        raise FlatPointsError(
            "the points lie in one plane, on one line or in one point (within rounding)",
            remedy="points that enclose a volume",
        ) from cause


def _automatic_centre(points: FloatArray) -> FloatArray:
    """Middle of the points' bounding box if it is well inside their convex hull, else its centroid.

    The middle of the box is halfway between black and white, and between the opponent hues: from
    there radii meet the surface of a display or a press most squarely, and the modified hull
    overshoots least (``docs/decisions/centre.md`` has the figures).
    """
    extent = float(np.ptp(points, axis=0).max())
    origin = (points.min(axis=0) + points.max(axis=0)) / 2
    if not extent > 0:
        raise FlatPointsError("all points are the same", remedy="points that enclose a volume")
    scaled = (points - origin) / extent
    hull = _qhull(scaled)
    if hull.volume < FLATNESS:
        raise FlatPointsError(
            f"the points are flat: their hull fills {hull.volume:.1e} of the cube of their extent",
            remedy="points that enclose a volume",
        )
    inside = scaled[hull.vertices].mean(axis=0)
    first, second, third = (scaled[hull.simplices[:, corner]] - inside for corner in range(3))
    volumes = np.abs(np.einsum("ij,ij->i", first, np.cross(second, third)))
    centroid = inside + ((first + second + third) * volumes[:, np.newaxis]).sum(axis=0) / (
        4 * volumes.sum()
    )
    depth_of_middle = -hull.equations[:, 3].max()
    depth_of_centroid = -(hull.equations[:, :3] @ centroid + hull.equations[:, 3]).max()
    well_inside = depth_of_middle >= 0.5 * depth_of_centroid
    return np.asarray(origin if well_inside else origin + centroid * extent)


@kernel
def _outward_faces(simplices: IndexArray, equations: FloatArray, points: FloatArray) -> IndexArray:
    """Triangles of a hull, counter-clockwise from outside, by the hull's own outward normals."""
    faces = np.empty((len(simplices), 3), np.int32)
    for face in range(len(simplices)):
        one, two, three = simplices[face, 0], simplices[face, 1], simplices[face, 2]
        ux = points[two, 0] - points[one, 0]
        uy = points[two, 1] - points[one, 1]
        uz = points[two, 2] - points[one, 2]
        vx = points[three, 0] - points[one, 0]
        vy = points[three, 1] - points[one, 1]
        vz = points[three, 2] - points[one, 2]
        outwards = (
            (uy * vz - uz * vy) * equations[face, 0]
            + (uz * vx - ux * vz) * equations[face, 1]
            + (ux * vy - uy * vx) * equations[face, 2]
        )
        faces[face, 0] = one
        faces[face, 1], faces[face, 2] = (two, three) if outwards >= 0.0 else (three, two)
    return faces


def _coherent_order(faces: IndexArray, points: FloatArray) -> tuple[LongArray, IndexArray]:
    """Order vertices along a Morton curve, faces by first vertex: near in space, near in memory.

    Parameters
    ----------
    faces : (n, 3) int32
    points : (m, 3) float64
        Within −1 to 1.

    Returns
    -------
    corners : (v,) int64
        The points that are vertices, in their new order.
    packed : (n, 3) int32
        The faces over them, each starting with its smallest vertex.
    """
    corners = np.flatnonzero(np.bincount(faces.ravel(), minlength=len(points))).astype(np.int64)
    cells = ((points[corners] + 1.0) * 511.5).astype(np.int64)
    code = np.zeros(len(corners), np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    corners = corners[np.argsort(code, kind="stable")]
    place = np.empty(len(points), np.int32)
    place[corners] = np.arange(len(corners), dtype=np.int32)
    packed = place[faces]
    start = packed.argmin(axis=1)[:, np.newaxis]
    packed = np.take_along_axis(packed, (start + np.arange(3)) % 3, axis=1)
    order = np.argsort(packed[:, 0].astype(np.int64) * len(corners) + packed[:, 1])
    return corners, packed[order]


def _spoilt_vertices(faces: IndexArray, relative: FloatArray) -> IndexArray:
    """Points to take out so that a valid surface remains; none if the faces make one already."""
    bad = faces_not_seeing_centre(relative, faces)
    if bad.size == 0:
        opposite = opposite_corners(faces, len(relative))
        bad = np.unique(np.flatnonzero(opposite < 0) // 3).astype(np.int32)
        used = np.count_nonzero(np.bincount(faces.ravel()))
        if bad.size == 0 and len(faces) == 2 * used - 4:
            return np.empty(0, np.int32)
        if bad.size == 0:  # closed, yet not a sphere: Qhull merged facets; nothing to single out
            return np.unique(faces[:, 0])
    # the middle one of three directions on a great circle faces the longest side
    corners = relative[faces[bad]]
    corners = corners / np.linalg.norm(corners, axis=2)[:, :, np.newaxis]
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1), axis=2)
    return np.unique(faces[bad, sides.argmax(axis=1)])
