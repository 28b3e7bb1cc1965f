"""Uniform segment visualization (USV): a modified hull over the farthest colours of even segments.

Bakke, Farup & Hardeberg, "Multispectral gamut mapping and visualization" (2005): a tetrahedron, an
octahedron or an icosahedron is split, each triangle into four, as often as wanted, and projected
onto the sphere. Every triangle makes a segment with the centre; the segment of a colour is found by
walking over the triangles. Around the farthest colour of each segment the modified convex hull is
taken, with a γ of 0.05, so that nearly all of them are on the surface. Empty segments add nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, cast

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.boundary.modified_convex_hull import Boundary, modified_convex_hull
from gamutcore.boundary.points import centred_points, farthest_points
from gamutcore.corner_table import opposite_corners
from gamutcore.errors import BoundaryError, InvalidPointsError
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.option_types import Choice, WholeNumber, check_option

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = [
    "BASES",
    "BASIS",
    "SUBDIVISIONS",
    "sphere_triangles",
    "triangles_towards",
    "usv",
]

GOLDEN = (1 + 5**0.5) / 2

BASES: dict[str, FloatArray] = {
    "tetrahedron": np.array([(1.0, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]),
    "octahedron": np.vstack([np.eye(3), -np.eye(3)]),
    "icosahedron": np.array(
        [
            np.roll((0.0, one, other * GOLDEN), shift)
            for shift in range(3)
            for one in (1, -1)
            for other in (1, -1)
        ]
    ),
}
"""Corners of the regular bodies that directions can be divided by, in the usual coordinates."""

BASIS = Choice(tuple(BASES))
"""Accepted values of `basis`."""

SUBDIVISIONS = WholeNumber(0, 7)
"""Accepted values of `subdivisions`. Seven subdivisions of an icosahedron make 327,680 segments,
three for each colour that a device model is asked for by default."""


def usv(
    points: ArrayLike,
    basis: str = "icosahedron",
    subdivisions: int = 4,
    gamma: float = 0.05,
    centre: ArrayLike | Literal["auto"] = "auto",
) -> Boundary:
    """Wrap the farthest points of even segments about a centre in a modified convex hull.

    Parameters
    ----------
    points : (n, 3) array_like
        Colours, in the order of the colour space. They are rounded to their grid first.
    basis : str, optional
        The body that is split; one of `BASES`.
    subdivisions : int, optional
        How often it is split, 0 to 7: an icosahedron's 20 faces become
        20 · 4ⁿ segments, and the boundary has 2 · 20 · 4ⁿ − 4 triangles if none is empty and all
        farthest points are on the hull.
    gamma : float, optional
        Power that radii are raised to for the hull, in (0, 1]; 0.05 as published unless told.
    centre : (3,) array_like or "auto", optional
        As for `modified_convex_hull`.

    Returns
    -------
    Boundary

    Raises
    ------
    OptionError
        If the basis, the subdivisions or γ are not accepted or the centre is not three numbers.
    InvalidPointsError
        If the points are not an (n, 3) array of finite numbers below 10¹².
    TooFewPointsError, FlatPointsError, CentreError
        If the points enclose no volume, or the centre is not inside it.
    BoundaryError
        If the farthest points of the segments do not surround the centre.
    """
    body = str(check_option("basis", basis, BASIS))
    splits = cast("int", check_option("subdivisions", subdivisions, SUBDIVISIONS))
    rounded, middle = centred_points(points, centre)
    relative = rounded - middle
    radii = np.linalg.norm(relative, axis=1)
    usable = np.flatnonzero(radii > radii.max() * 1e-12)
    # at one length, products with the triangles' sides neither vanish nor overflow
    directions = relative[usable] / radii[usable, np.newaxis]
    segment = triangles_towards(directions, body, splits)
    count = (2 * len(BASES[body]) - 4) * 4**splits
    farthest = farthest_points(segment, radii[usable], count)
    chosen = usable[farthest[farthest >= 0]]
    try:
        hull = modified_convex_hull(rounded[chosen], gamma, middle)
    except InvalidPointsError as cause:
        raise BoundaryError(
            f"the farthest colours of the {count} segments, {len(chosen)} in all, do not"
            f" surround the centre {tuple(middle.tolist())}",
            where={"field": "subdivisions"},
            remedy="more subdivisions, another basis, or a centre farther inside the gamut",
        ) from cause
    return Boundary(hull.mesh, hull.centre, chosen[hull.sources], hull.gamma)


def sphere_triangles(basis: str, subdivisions: int) -> tuple[FloatArray, list[IndexArray]]:
    """Triangles on the unit sphere from a regular body, each split into four and projected.

    Parameters
    ----------
    basis : str
        One of `BASES`.
    subdivisions : int

    Returns
    -------
    corners : (m, 3) float64
        Unit vectors.
    faces : list of (n · 4ⁱ, 3) int32
        The triangles of each level i from 0 to `subdivisions`, counter-clockwise from outside. Face
        f of a level is split into the faces 4 f, 4 f + 1 and 4 f + 2 at its corners, in their
        order, and 4 f + 3 in its middle.
    """
    corners = BASES[basis] / np.linalg.norm(BASES[basis], axis=1)[:, np.newaxis]
    hull = modified_convex_hull(corners, 1.0, (0.0, 0.0, 0.0))
    faces = [hull.sources[hull.mesh.faces].astype(np.int32)]
    for _ in range(subdivisions):
        ends = np.stack([faces[-1], np.roll(faces[-1], -1, axis=1)], axis=-1).reshape(-1, 2)
        pairs, side = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
        halves = corners[pairs].sum(axis=1)
        (a, b, c), (ab, bc, ca) = faces[-1].T, len(corners) + side.reshape(-1, 3).T
        corners = np.vstack([corners, halves / np.linalg.norm(halves, axis=1)[:, np.newaxis]])
        parts = np.array([(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)], np.int32)
        faces.append(parts.transpose(2, 0, 1).reshape(-1, 3))
    return corners, faces


def triangles_towards(directions: FloatArray, basis: str, subdivisions: int) -> LongArray:
    """The triangle of `sphere_triangles` that each direction goes through.

    Parameters
    ----------
    directions : (n, 3) float64
        Of about unit length.
    basis : str
    subdivisions : int

    Returns
    -------
    (n,) int64
        A triangle on no side of which the direction is outside; one of several on a border.
    """
    corners, levels = sphere_triangles(basis, subdivisions)
    neighbours = opposite_corners(levels[0], len(corners)).reshape(-1, 3) // 3
    sides = [_sides(corners, np.roll(levels[0], -1, axis=1))]
    # beyond the three sides of a middle triangle are the parts at the corners a, b and c
    sides += [_sides(corners, np.roll(faces[3::4], 1, axis=1)) for faces in levels[1:]]
    return _walked(directions, neighbours, np.concatenate(sides), subdivisions)


def _sides(corners: FloatArray, faces: IndexArray) -> FloatArray:
    """Normals, pointing inwards, of the planes through the centre and a triangle's sides.

    Side i goes from corner i to the next one. Two triangles have exactly opposite normals for the
    side that they have in common.
    """
    return np.cross(corners[faces], corners[np.roll(faces, -1, axis=1)])


@kernel
def _walked(
    directions: FloatArray, neighbours: IndexArray, sides: FloatArray, subdivisions: int
) -> LongArray:
    """Walk to each direction's triangle of the regular body, and down its subdivisions.

    Over the body each step crosses the side that the direction is farthest outside of, beginning
    where the direction before ended. In a subdivision the walk begins in the middle one of four
    parts and crosses at most one side, because the other three have no side in common. So it ends
    after a step per subdivision, also on a tetrahedron, whose subdivisions are not Delaunay and
    could let a walk over the finest triangles alone go round for ever.

    Parameters
    ----------
    directions : (n, 3) float64
    neighbours : (k, 3) int32
        The body's faces across the side facing each corner.
    sides : (k + k + 4 k + 16 k + ..., 3, 3) float64
        Inward normals of the sides: of the body's faces, then of the middle parts of all faces of
        each level that is split.
    subdivisions : int

    Returns
    -------
    (n,) int64
    """
    found = np.empty(len(directions), np.int64)
    start = 0
    for index in range(len(directions)):
        x, y, z = directions[index, 0], directions[index, 1], directions[index, 2]
        crossed = _farthest_outside(sides, start, x, y, z)
        while crossed < 3:
            start = neighbours[start, crossed]
            crossed = _farthest_outside(sides, start, x, y, z)
        face, offset, size = start, len(neighbours), len(neighbours)
        for _ in range(subdivisions):
            face = 4 * face + _farthest_outside(sides, offset + face, x, y, z)
            offset += size
            size *= 4
        found[index] = face
    return found


@leaf_kernel
def _farthest_outside(sides: FloatArray, face: int, x: float, y: float, z: float) -> int:
    """The side of a triangle that a direction is farthest outside of; 3 if it is inside."""
    farthest, lowest = 3, 0.0
    for side in range(3):
        height = sides[face, side, 0] * x + sides[face, side, 1] * y + sides[face, side, 2] * z
        if height < lowest:
            farthest, lowest = side, height
    return farthest
