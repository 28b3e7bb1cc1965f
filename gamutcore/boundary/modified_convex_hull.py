"""The modified convex hull: an accurate, star-shaped surface around the colours of a device.

The radii of all colours about a centre are raised to the power γ. A convex hull is taken of the
result, and its triangles are kept on the original colours (Balasubramanian & Dalal, "A method for
quantifying the color gamut of an output device", 1997). Bakke & Farup use it in this form. γ = 1
gives the convex hull. With γ → 0, every colour would be on the surface. In between, the surface
follows concavities.

Scaling a radius keeps the direction of a point, and with it the sign of each face's determinant
about the centre. The surface is therefore star-shaped, because the hull is.

A large γ bridges concave regions. A small γ makes vertices of points inside the gamut: between two
neighbours at an angle θ, a point deeper by the share θ² ÷ 8 γ still sticks out of the raised hull.

- Scattered points get the paper's 0.2.
- The surface of a device with three channels gets the smallest value, because it has no inner
  points unless it is folded.
- Other device surfaces have inner points. Both errors together are least if γ is proportional to
  θ, that is to 1 ÷ √points.
- A boundary smaller than the device's surface has fallen into inner points. γ is then doubled
  until the boundary is large enough.

``docs/decisions/gamma.md`` has the figures.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import numpy as np

from gamutcore.arguments import Choice, Number
from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.boundary.centre import automatic_centre, bounds, centre_on_grid, points_on_grid
from gamutcore.boundary.radial_hull import radial_hull
from gamutcore.errors import BoundaryError, CentreError, FlatPointsError
from gamutcore.geometry import (
    TriangleMesh,
    curve_positions,
    faces_not_seeing_centre,
    insertion_order,
)
from gamutcore.kernels import kernel
from gamutcore.number_text import number_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike

GAMMA = Annotated[str, Choice(("auto",))] | Annotated[float, Number(0, 1, above_least=True)]
"""Accepted values of `gamma`."""

SCATTERED = 0.2
"""γ of scattered points (Balasubramanian & Dalal 1997; Bakke & Farup)."""

SMALLEST = 5e-5
"""γ of surfaces without inner points. Smaller values change volumes by less than 0.02 %. Larger
ones bridge the concave faces of film spaces."""

PER_ANGLE = 10.0
"""γ times √points for surfaces with inner points. Presses of four inks are exact to 0.01 % from 5
to 15, and the errors of seven inks balance at 11."""

LOST = 3e-4
"""Smallest relative loss of volume by which a boundary counts as fallen into inner points."""

LOST_PER_POINT = 10.0
"""The same, times the number of points: coarse surfaces lose some volume between their points."""


class Cuts(NamedTuple):
    """The points between which the vertices of a boundary are.

    Attributes
    ----------
    ends : (m, 2) int64
        Twice the same point for a vertex that is a point.
    share : (m,) float64
        Position between the two points, 0 to 1.
    """

    ends: LongArray
    share: FloatArray


@dataclass(frozen=True, eq=False)
class Boundary:
    """A full boundary: the surface at which decimation starts.

    Attributes
    ----------
    mesh : TriangleMesh
        Closed, oriented outwards, star-shaped about `centre`. Vertices are float32, on the grid of
        the points (`gamutcore.geometry.mesh`).
    centre : (3,) float64
        On the same grid.
    sources : (m,) int64
        Index of the point at each vertex; −1 for a constructed vertex, which is none of the points.
    gamma : float
        Power of the radii; 0 for a method without it.
    cuts : Cuts, optional
        For a boundary whose vertices are all on the lines between two points.
    """

    mesh: TriangleMesh
    centre: FloatArray
    sources: LongArray
    gamma: float
    cuts: Cuts | None = None


def modified_convex_hull(
    points: ArrayLike,
    gamma: float | Literal["auto"] = "auto",
    centre: ArrayLike | Literal["auto"] = "auto",
) -> Boundary:
    """Return a closed surface around points that is star-shaped about a centre.

    Parameters
    ----------
    points : (n, 3) array_like
        Colours, in coordinates of the colour space. They are first rounded to a grid, the precision
        of delivered levels. Duplicates and points at the centre are allowed.
    gamma : float or "auto", optional
        Power that radii are raised to, in (0, 1]; 1 for the convex hull. "auto" is the paper's 0.2
        here, because nothing is known of the points. `gamutcore.boundary.wrapping` chooses by the
        surface of a device.
    centre : (3,) array_like or "auto", optional
        Point that radii are taken from, rounded to the same grid. It must lie strictly inside the
        convex hull of the points. "auto" is explained at `automatic_centre`.

    Returns
    -------
    Boundary

    Raises
    ------
    OptionError
        The centre is not three numbers.
    InvalidPointsError
        The points are not an (n, 3) array of finite numbers below 10¹².
    TooFewPointsError, FlatPointsError, CentreError
        The points enclose no volume, or the centre is not inside it.
    BoundaryError
        The surface is not valid, which is a fault of the program.

    Examples
    --------
    >>> octahedron = np.vstack([np.eye(3), -np.eye(3)])
    >>> modified_convex_hull(octahedron, gamma=0.2).mesh.triangles
    8
    """
    power = SCATTERED if gamma == "auto" else float(gamma)
    rounded, step = points_on_grid(points)
    option_centre = centre_on_grid(centre, rounded, step)
    about = sum(bounds(rounded)) / 2 if option_centre is None else option_centre
    positions = curve_positions(rounded - about)
    order = insertion_order(positions)
    ordered = rounded[order]
    middle = automatic_centre(ordered, step).point if option_centre is None else option_centre

    relative = ordered - middle
    faces = radial_hull(_radii_to_power(relative, power))
    if len(faces) == 0:
        if option_centre is None:
            raise FlatPointsError(
                f"The points are flat: no centre on their grid of {number_text(step)} is inside "
                "of them.",
                remedy="Give points that enclose a volume.",
            )
        automatic_centre(ordered, step)  # raises the better error if the points are flat
        raise CentreError(
            f"The centre {tuple(middle.tolist())} is not strictly inside the convex hull of"
            " the points.",
            where={"field": "centre"},
            remedy="Give a point inside the gamut, or 'auto'.",
        )
    if faces_not_seeing_centre(relative, faces).size:
        raise BoundaryError(
            "The surface around the points is not star-shaped about the centre.",
            remedy="Give points that are not nearly in one plane, and a centre well inside them.",
        )
    corners, packed = coherent_order(faces, positions[order])
    mesh = TriangleMesh(ordered[corners].astype(np.float32), packed)
    return Boundary(mesh, middle, order[corners], power)


def _radii_to_power(relative: FloatArray, gamma: float) -> FloatArray:
    """Points around the origin with their radii raised to a power.

    Points are first divided by a power of two near the largest radius. The result stays in the
    range of floats and does not depend on a power of two in the unit of the points.
    """
    squares = np.einsum("ij,ij->i", relative, relative)
    scale = 2.0 ** -np.frexp(np.sqrt(squares.max()))[1]
    with np.errstate(divide="ignore"):
        factor = (squares * scale**2) ** ((gamma - 1.0) / 2.0) * scale
    factor[squares == 0.0] = 0.0
    return np.asarray(relative * factor[:, np.newaxis])


def coherent_order(faces: IndexArray, positions: LongArray) -> tuple[LongArray, IndexArray]:
    """Return the vertices of faces in order along a curve, and the faces over them by first vertex.

    Neighbours are then near in memory. `positions` are those of the points along the curve. Each
    face starts with its smallest vertex.
    """
    corners = np.flatnonzero(np.bincount(faces.ravel(), minlength=len(positions))).astype(np.int64)
    corners = corners[np.argsort(positions[corners], kind="stable")]
    number = np.empty(len(positions), np.int32)
    number[corners] = np.arange(len(corners), dtype=np.int32)
    return corners, _faces_in_order(faces, number, len(corners))


@kernel
def _faces_in_order(faces: IndexArray, number: IndexArray, vertices: int) -> IndexArray:
    """Renumber the vertices of faces, and order the faces by first and second vertex."""
    count = len(faces)
    renumbered = np.empty((count, 3), np.int32)
    for face in range(count):
        one, two, three = number[faces[face, 0]], number[faces[face, 1]], number[faces[face, 2]]
        while one > two or one > three:
            one, two, three = two, three, one
        renumbered[face, 0], renumbered[face, 1], renumbered[face, 2] = one, two, three
    source, target = renumbered, np.empty((count, 3), np.int32)
    for column in (1, 0):  # stable counting sorts: by the second vertex, then by the first
        next_row = np.zeros(vertices + 1, np.int64)
        for face in range(count):
            next_row[source[face, column] + 1] += 1
        for vertex in range(vertices):
            next_row[vertex + 1] += next_row[vertex]
        for face in range(count):
            row = next_row[source[face, column]]
            next_row[source[face, column]] += 1
            for corner in range(3):
                target[row, corner] = source[face, corner]
        source, target = target, source
    return source


def surface_gammas(points: int, *, closed: bool) -> Iterator[float]:
    """Yield the values of γ to try for the surface of a device, ascending; the last is `SCATTERED`.

    A surface is `closed` with three channels.
    """
    if closed:
        yield SMALLEST
    gamma = round(PER_ANGLE / sqrt(points), 4)
    while gamma < SCATTERED:
        yield gamma
        gamma *= 2
    yield SCATTERED


def has_fallen(volume: float, surface_volume: float, points: int) -> bool:
    """Whether a boundary has lost so much volume that it has fallen into inner points."""
    return volume < surface_volume * (1 - max(LOST, LOST_PER_POINT / points))
