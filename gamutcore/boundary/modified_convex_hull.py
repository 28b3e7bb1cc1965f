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
from typing import TYPE_CHECKING, Literal, cast

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.boundary.centre import automatic_centre, bounds, centre_on_grid, points_on_grid
from gamutcore.boundary.insertion_order import insertion_order, places_on_curve
from gamutcore.boundary.radial_hull import radial_hull
from gamutcore.errors import BoundaryError, CentreError, FlatPointsError
from gamutcore.kernels import kernel
from gamutcore.mesh import TriangleMesh
from gamutcore.option_types import Number, check_option
from gamutcore.star_shape import faces_not_seeing_centre

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["GAMMA", "Boundary", "modified_convex_hull"]

GAMMA = Number(0, 1, above_least=True)
"""Accepted values of `gamma`."""


@dataclass(frozen=True, eq=False)
class Boundary:
    """A full boundary: the surface that decimation starts from.

    Attributes
    ----------
    mesh : TriangleMesh
        Closed, oriented outwards, star-shaped about `centre`; vertices are float32, on the grid of
        the points (`gamutcore.grid`).
    centre : (3,) float64
        On the same grid.
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
        Colours, in the order of the colour space. They are rounded to a grid first, the precision
        in which a gamut is delivered; duplicates and points at the centre do no harm.
    gamma : float, optional
        Power that radii are raised to, in (0, 1]; 0.2 unless told, 1 for the convex hull.
    centre : (3,) array_like or "auto", optional
        The point radii are taken from; it must lie strictly inside the convex hull of the points.
        "auto" takes the middle of the points' bounding box, or the centroid of their convex hull
        where the middle is outside it or close to it. It is rounded to the same grid.

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
        If the surface is not valid, which is a fault of the program.
    """
    power = cast("float", check_option("gamma", gamma, GAMMA))
    rounded, step = points_on_grid(points)
    given = centre_on_grid(centre, rounded, step)
    about = sum(bounds(rounded)) / 2 if given is None else given
    places = places_on_curve(rounded - about)
    order = insertion_order(places)
    ordered = rounded[order]
    middle = automatic_centre(ordered, step) if given is None else given

    relative = ordered - middle
    faces = radial_hull(_with_raised_radii(relative, power))
    if len(faces) == 0:
        if given is None:
            raise FlatPointsError(
                f"the points are so flat that no centre on their grid, of {step:g}, is inside",
                remedy="points that enclose a volume",
            )
        automatic_centre(ordered, step)  # flat points are the better explanation if they are flat
        raise CentreError(
            f"the centre {tuple(middle.tolist())} is not strictly inside the convex hull of"
            " the points",
            where={"field": "centre"},
            remedy="a point inside the gamut, or 'auto'",
        )
    if faces_not_seeing_centre(relative, faces).size:
        raise BoundaryError(
            "no closed surface that is star-shaped about the centre could be wrapped around the"
            " points",
            remedy="points that are not nearly in one plane, seen from a centre well inside them",
        )
    corners, packed = _coherent_order(faces, places[order])
    mesh = TriangleMesh(ordered[corners].astype(np.float32), packed)
    return Boundary(mesh, middle, order[corners], power)


def _with_raised_radii(relative: FloatArray, gamma: float) -> FloatArray:
    """Points around the origin with radii to a power, relative to the largest radius' magnitude.

    They are divided by a power of two first: the result neither leaves the range of floats nor
    depends on the units of points that differ by such a factor.
    """
    squares = np.einsum("ij,ij->i", relative, relative)
    scale = 2.0 ** -np.frexp(np.sqrt(squares.max()))[1]
    with np.errstate(divide="ignore"):
        factor = (squares * scale**2) ** ((gamma - 1.0) / 2.0) * scale
    factor[squares == 0.0] = 0.0
    return np.asarray(relative * factor[:, np.newaxis])


def _coherent_order(faces: IndexArray, places: LongArray) -> tuple[LongArray, IndexArray]:
    """Order vertices along a curve, faces by first vertex: near in space, near in memory.

    Parameters
    ----------
    faces : (n, 3) int32
    places : (m,) int64
        Where the points are along the curve.

    Returns
    -------
    corners : (v,) int64
        The points that are vertices, in their new order.
    packed : (n, 3) int32
        The faces over them, each starting with its smallest vertex.
    """
    corners = np.flatnonzero(np.bincount(faces.ravel(), minlength=len(places))).astype(np.int64)
    corners = corners[np.argsort(places[corners], kind="stable")]
    number = np.empty(len(places), np.int32)
    number[corners] = np.arange(len(corners), dtype=np.int32)
    return corners, _faces_in_order(faces, number, len(corners))


@kernel
def _faces_in_order(faces: IndexArray, number: IndexArray, vertices: int) -> IndexArray:
    """Renumber the vertices of faces and order these by first and second vertex."""
    count = len(faces)
    turned = np.empty((count, 3), np.int32)
    for face in range(count):
        one, two, three = number[faces[face, 0]], number[faces[face, 1]], number[faces[face, 2]]
        while one > two or one > three:
            one, two, three = two, three, one
        turned[face, 0], turned[face, 1], turned[face, 2] = one, two, three
    source, target = turned, np.empty((count, 3), np.int32)
    for column in (1, 0):  # a stable counting sort by the second vertex, then one by the first
        next_place = np.zeros(vertices + 1, np.int64)
        for face in range(count):
            next_place[source[face, column] + 1] += 1
        for vertex in range(vertices):
            next_place[vertex + 1] += next_place[vertex]
        for face in range(count):
            place = next_place[source[face, column]]
            next_place[source[face, column]] += 1
            for corner in range(3):
                target[place, corner] = source[face, corner]
        source, target = target, source
    return source
