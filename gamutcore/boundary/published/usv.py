"""Uniform segment visualization (USV): a hull of the farthest colour of each even segment.

Source: Bakke, Farup & Hardeberg, "Multispectral gamut mapping and visualization" (2005).

The faces of a tetrahedron, an octahedron or an icosahedron are repeatedly split into four and
projected onto the sphere. Every triangle and the centre form a segment. The modified convex hull is
taken of the farthest colour of each segment. With a γ of 0.05, nearly all of these colours are on
the surface. Empty segments add nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np

from gamutcore.arguments import Choice, WholeNumber
from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.boundary.modified_convex_hull import Boundary, modified_convex_hull
from gamutcore.boundary.published.segments import centred_points, farthest_points
from gamutcore.errors import BoundaryError, InvalidPointsError
from gamutcore.geometry import opposite_corners
from gamutcore.kernels import kernel, leaf_kernel

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

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
"""Corners of the regular polyhedra that directions are divided by, in the usual coordinates."""

BASIS = Annotated[str, Choice(tuple(BASES))]
"""Accepted values of `basis`."""

SUBDIVISIONS = Annotated[int, WholeNumber(0, 7)]
"""Accepted values of `subdivisions`. Seven subdivisions of an icosahedron make 327,680 segments,
three for each colour that a device model is asked for by default."""


def usv(
    points: ArrayLike,
    basis: str = "icosahedron",
    subdivisions: int = 4,
    gamma: float = 0.05,
    centre: ArrayLike | Literal["auto"] = "auto",
) -> Boundary:
    """Return the modified convex hull of the farthest points of even segments about a centre.

    Parameters
    ----------
    points : (n, 3) array_like
        Colours, in coordinates of the colour space. They are first rounded to their grid.
    basis : str, optional
        Polyhedron that is split; one of `BASES`.
    subdivisions : int, optional
        Number of splits, 0 to 7. The 20 faces of an icosahedron become 20 · 4ⁿ segments. The
        boundary has 2 · 20 · 4ⁿ − 4 triangles if no segment is empty and all farthest points are on
        the hull.
    gamma : float, optional
        Power that radii are raised to for the hull, in (0, 1]; 0.05 as published.
    centre : (3,) array_like or "auto", optional
        As for `modified_convex_hull`.

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
        The farthest points of the segments do not surround the centre.
    """
    rounded, middle = centred_points(points, centre)
    relative = rounded - middle
    radii = np.linalg.norm(relative, axis=1)
    usable = np.flatnonzero(radii > radii.max() * 1e-12)
    # unit length: products with the sides of triangles neither vanish nor overflow
    directions = relative[usable] / radii[usable, np.newaxis]
    segment = triangles_towards(directions, basis, subdivisions)
    count = (2 * len(BASES[basis]) - 4) * 4**subdivisions
    farthest = farthest_points(segment, radii[usable], count)
    chosen = usable[farthest[farthest >= 0]]
    try:
        hull = modified_convex_hull(rounded[chosen], gamma, middle)
    except InvalidPointsError as cause:
        raise BoundaryError(
            f"The farthest colours of the {count} segments ({len(chosen)} colours) do not surround"
            f" the centre {tuple(middle.tolist())}.",
            where={"field": "subdivisions"},
            remedy="Give more subdivisions, another basis, or a centre farther inside the gamut.",
        ) from cause
    return Boundary(hull.mesh, hull.centre, chosen[hull.sources], hull.gamma)


def sphere_triangles(basis: str, subdivisions: int) -> tuple[FloatArray, list[IndexArray]]:
    """Return unit vectors, and the triangles over them at each level of a split polyhedron.

    Each level has four times the faces of the last, counter-clockwise from outside. Face f is split
    into 4 f, 4 f + 1 and 4 f + 2 at its corners, in their order. Face 4 f + 3 is in its middle.
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
    """Return the finest triangle of `sphere_triangles` in each direction of about unit length.

    A direction on a border gets one of the triangles that meet there.
    """
    corners, levels = sphere_triangles(basis, subdivisions)
    neighbours = opposite_corners(levels[0], len(corners)).reshape(-1, 3) // 3
    sides = [_sides(corners, np.roll(levels[0], -1, axis=1))]
    # beyond the sides of a middle triangle are the parts at the corners a, b and c
    sides += [_sides(corners, np.roll(faces[3::4], 1, axis=1)) for faces in levels[1:]]
    return _triangles_by_walk(directions, neighbours, np.concatenate(sides), subdivisions)


def _sides(corners: FloatArray, faces: IndexArray) -> FloatArray:
    """Inward normals of the planes through the centre and the sides of each triangle.

    Side i goes from corner i to the next one. Two triangles have exactly opposite normals for their
    common side.
    """
    return np.cross(corners[faces], corners[np.roll(faces, -1, axis=1)])


@kernel
def _triangles_by_walk(
    directions: FloatArray, neighbours: IndexArray, sides: FloatArray, subdivisions: int
) -> LongArray:
    """Triangle of each direction, by a walk over the polyhedron and down its subdivisions.

    In a subdivision, the walk starts in the middle part and crosses at most one side, because the
    other three parts have no common side. A walk over the finest triangles alone might not end: the
    subdivisions of a tetrahedron are not Delaunay. `sides`, (n, 3, 3), are inward normals: of the
    polyhedron's faces, then of the middle parts of all faces of each level that is split.
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
    """Side of a triangle that a direction is farthest outside of; 3 if it is inside."""
    farthest, lowest = 3, 0.0
    for side in range(3):
        height = sides[face, side, 0] * x + sides[face, side, 1] * y + sides[face, side, 2] * z
        if height < lowest:
            farthest, lowest = side, height
    return farthest
