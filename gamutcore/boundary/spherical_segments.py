"""Boundaries through the farthest colour of each segment of the sphere of directions.

**Segment maxima**: Morovic & Luo, "Calculating medium and image gamut boundaries for gamut mapping"
(2000). Directions from the centre are divided uniformly by two angles: the polar angle from the
first axis (L* in CIELAB) and the azimuth about it (the hue angle). The farthest colour of each
segment is a vertex, and the grid determines the faces.

The published method leaves three points open (``docs/decisions/other-boundaries.md`` has the
reasons). Empty segments and the two poles, which are vertices of their own, get a radius by
interpolation over the grid. Quadrilaterals are divided by the diagonal that gives the larger
volume. Vertices of a face that would not see the centre are turned towards the middles of their
segments as far as needed.

**Uniform segment visualization** (USV): Bakke, Farup & Hardeberg, "Multispectral gamut mapping and
visualization" (2005). The faces of a tetrahedron, an octahedron or an icosahedron are repeatedly
split into four and projected onto the sphere. Every triangle and the centre form a segment. The
modified convex hull is taken of the farthest colour of each segment. With a γ of 0.05, nearly all
of these colours are on the surface. Empty segments add nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, cast

import numpy as np

from gamutcore.arguments import Array, Choice, WholeNumber, check_option
from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.boundary.modified_convex_hull import Boundary, modified_convex_hull
from gamutcore.errors import BoundaryError, InvalidPointsError
from gamutcore.geometry import (
    TriangleMesh,
    faces_not_seeing_centre,
    grid_step,
    nearest_grid_points,
    opposite_corners,
)
from gamutcore.kernels import kernel, leaf_kernel

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

SEGMENTS = (16, 16)
"""Default numbers of polar and azimuth segments, as in Morovic & Luo and in Little CMS."""

_POLAR, _AZIMUTH = WholeNumber(2, 180), WholeNumber(3, 360)

SEGMENT_COUNTS = Annotated[
    tuple[Annotated[int, _POLAR], Annotated[int, _AZIMUTH]],
    Array(
        "2 whole numbers (polar and azimuth segments), from "
        f"{[_POLAR.least, _AZIMUTH.least]} to {[_POLAR.most, _AZIMUTH.most]}",
        2,
    ),
]
"""Accepted values of `segments`. Fewer do not surround the centre. One degree each way makes 64,800
segments: most are empty, and at the poles they are as narrow as the grid of positions resolves."""

TURNS = 8
"""Steps in which a vertex is turned from its own direction to the middle of its segment."""

ATTEMPTS = 100
"""Largest number of searches for faces that do not see the centre. Real devices need one or two."""

RESOLVED = 8.0
"""Distance of neighbouring vertices, in grid steps, at which rounding keeps them apart. Rounding
moves each by at most 0.87 steps."""

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


def segment_maxima(
    points: ArrayLike,
    segments: tuple[int, int] = SEGMENTS,
    centre: ArrayLike | Literal["auto"] = "auto",
) -> Boundary:
    """Return the surface through the farthest points of uniform segments about a centre.

    Parameters
    ----------
    points : (n, 3) array_like
        Colours, in coordinates of the colour space. They are first rounded to their grid.
    segments : (polar, azimuth) int, optional
        Numbers of segments, within `SEGMENT_COUNTS`.
    centre : (3,) array_like or "auto", optional
        As for `modified_convex_hull`.

    Returns
    -------
    Boundary
        polar × azimuth + 2 vertices: the segments row by row from the positive end of the first
        axis, then the two poles. A vertex has the source −1 if its segment is empty, if it is a
        pole, or if it was moved. γ is 0, because no power is used.

    Raises
    ------
    OptionError
        The numbers of segments are not accepted, or the centre is not three numbers.
    InvalidPointsError
        The points are not an (n, 3) array of finite numbers below 10¹².
    TooFewPointsError, FlatPointsError, CentreError
        The points enclose no volume, or the centre is not inside it.
    BoundaryError
        The grid of positions does not resolve the segments about this centre.
    """
    polar, azimuth = cast("tuple[int, int]", check_option("segments", segments, SEGMENT_COUNTS))
    rounded, middle = _centred_points(points, centre)
    relative = rounded - middle
    radii = np.linalg.norm(relative, axis=1)
    usable = np.flatnonzero(radii > radii.max() * 1e-12)
    segment = _segments_of(relative[usable], polar, azimuth)
    farthest = _farthest_points(segment, radii[usable], polar * azimuth)
    sources: LongArray = np.full(polar * azimuth + 2, -1, np.int64)
    sources[:-2][farthest >= 0] = usable[farthest[farthest >= 0]]

    filled = sources >= 0
    directions, sizes = _middles(polar, azimuth)
    own, reach = directions.copy(), np.zeros(len(sources))
    own[filled] = relative[sources[filled]] / radii[sources[filled], np.newaxis]
    reach[filled] = radii[sources[filled]]
    reach = _harmonic_radii(reach, filled, polar, azimuth)

    step = grid_step(rounded)
    resolved = RESOLVED * step / sizes
    lowest, highest = rounded.min(axis=0) - middle, rounded.max(axis=0) - middle
    turns = np.where(filled, 0, TURNS)
    lifted = np.zeros(len(sources), bool)
    for _ in range(ATTEMPTS):
        towards = own + (turns / TURNS)[:, np.newaxis] * (directions - own)
        towards /= np.linalg.norm(towards, axis=1)[:, np.newaxis]
        outside = np.maximum(towards / lowest, towards / highest).max(axis=1)
        radius = np.minimum(reach, 1 / outside)
        radius = np.where(lifted, np.maximum(radius, resolved), radius)
        positions = nearest_grid_points(towards * radius[:, np.newaxis], step)
        at_colour = (turns == 0) & ~lifted
        positions[at_colour] = relative[sources[at_colour]]
        faces = _faces(positions, polar, azimuth)
        corners = np.unique(faces[faces_not_seeing_centre(positions, faces)])
        if corners.size == 0:
            break
        turnable = corners[turns[corners] < TURNS]
        turns[turnable] += 1
        lifted[corners] |= turnable.size == 0
    vertices = (positions + middle).astype(np.float32)
    if corners.size or not np.array_equal(vertices, positions + middle):
        raise BoundaryError(
            f"{polar} × {azimuth} segments about the centre {tuple(middle.tolist())} are finer than"
            " the grid of positions.",
            where={"field": "segments"},
            remedy="Give fewer segments, or a centre farther inside the gamut.",
        )
    mesh = TriangleMesh(vertices, faces)
    return Boundary(mesh, middle, np.where(at_colour, sources, -1), 0.0)


def _segments_of(relative: FloatArray, polar: int, azimuth: int) -> LongArray:
    """Segment of each point, row by row from the positive first axis."""
    slope = np.arctan2(np.hypot(relative[:, 1], relative[:, 2]), relative[:, 0])
    turn = np.arctan2(relative[:, 2], relative[:, 1]) / (2 * np.pi) % 1.0
    row = np.minimum((slope / np.pi * polar).astype(np.int64), polar - 1)
    return row * azimuth + np.minimum((turn * azimuth).astype(np.int64), azimuth - 1)


def _middles(polar: int, azimuth: int) -> tuple[FloatArray, FloatArray]:
    """Unit vectors to the middles of all segments and to the two poles, and their angular sizes.

    A size is the angle to the nearest neighbour, in radians. The poles come last.
    """
    slope = np.repeat((np.arange(polar) + 0.5) * np.pi / polar, azimuth)
    turn = np.tile((np.arange(azimuth) + 0.5) * 2 * np.pi / azimuth, polar)
    middles = np.stack(
        [np.cos(slope), np.sin(slope) * np.cos(turn), np.sin(slope) * np.sin(turn)], axis=1
    )
    sizes = np.minimum(np.sin(slope) * 2 * np.pi / azimuth, np.pi / (2 * polar))
    poles = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    return np.vstack([middles, poles]), np.append(sizes, [np.pi / (2 * polar)] * 2)


def _harmonic_radii(
    reach: FloatArray, filled: NDArray[np.bool_], polar: int, azimuth: int
) -> FloatArray:
    """Radii of all segments and poles, with empty ones filled by harmonic interpolation.

    The radii satisfy a discrete Laplace equation (finite volumes on the sphere) in the empty
    segments, with fixed values in the filled ones. No interpolated radius is outside the range of
    the others.
    """
    from scipy.sparse import coo_array, diags_array  # noqa: PLC0415  # slow; only this method needs it
    from scipy.sparse.linalg import spsolve  # noqa: PLC0415

    number = np.arange(polar * azimuth).reshape(polar, azimuth)
    high, wide = np.pi / polar, 2 * np.pi / azimuth
    middle, border = (np.arange(polar) + 0.5) * high, np.arange(1, polar) * high
    along = np.repeat(high / (np.sin(middle) * wide), azimuth)
    across = np.repeat(np.sin(border) * wide / high, azimuth)
    # a pole is half a segment from the middles around it: their border is at a quarter
    polewards = np.full(2 * azimuth, np.sin(high / 4) * wide / (high / 2))
    poles = polar * azimuth + np.repeat([0, 1], azimuth)
    one = np.concatenate([number.ravel(), number[:-1].ravel(), poles])
    other = np.concatenate(
        [np.roll(number, -1, axis=1).ravel(), number[1:].ravel(), number[0], number[-1]]
    )
    weight = np.concatenate([along, across, polewards])
    size = len(reach)
    joined = coo_array(
        (np.append(weight, weight), (np.append(one, other), np.append(other, one))), (size, size)
    ).tocsr()
    free = ~filled
    pull = joined[free][:, filled] @ reach[filled]
    stiffness = diags_array(joined.sum(axis=1)[free]) - joined[free][:, free]
    radii = reach.copy()
    radii[free] = np.clip(
        spsolve(stiffness.tocsc(), pull), reach[filled].min(), reach[filled].max()
    )
    return radii


def _faces(positions: FloatArray, polar: int, azimuth: int) -> IndexArray:
    """Triangles of the grid of segments: fans at the poles, two for each quadrilateral between.

    A diagonal is valid if both of its triangles see the centre. Of two valid diagonals, the one
    with the larger volume is taken, because gamuts are mostly convex. Positions are relative to the
    centre.
    """
    number = np.arange(polar * azimuth, dtype=np.int32).reshape(polar, azimuth)
    east = np.roll(number, -1, axis=1)
    first = np.full(azimuth, polar * azimuth, np.int32)
    a, b, c, d = (
        corner.ravel() for corner in (number[:-1], number[1:], east[1:], east[:-1])
    )  # counter-clockwise from outside
    falling = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 2, 3)
    rising = np.stack([a, b, d, b, c, d], axis=1).reshape(-1, 2, 3)
    lengths = np.linalg.norm(positions, axis=1)
    volumes, seen = [], []
    for pair in (falling, rising):
        corners = positions[pair] / lengths.max()
        volume = np.linalg.det(corners)
        volumes.append(volume.sum(axis=1))
        seen.append((volume > 0).all(axis=1))
    better = np.where(seen[0] == seen[1], volumes[0] >= volumes[1], seen[0])
    return np.concatenate(
        [
            np.stack([first, number[0], east[0]], axis=1),
            np.where(better[:, np.newaxis, np.newaxis], falling, rising).reshape(-1, 3),
            np.stack([first + 1, east[-1], number[-1]], axis=1),
        ]
    ).astype(np.int32)


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
        The basis, the subdivisions or γ are not accepted, or the centre is not three numbers.
    InvalidPointsError
        The points are not an (n, 3) array of finite numbers below 10¹².
    TooFewPointsError, FlatPointsError, CentreError
        The points enclose no volume, or the centre is not inside it.
    BoundaryError
        The farthest points of the segments do not surround the centre.
    """
    body = str(check_option("basis", basis, BASIS))
    splits = cast("int", check_option("subdivisions", subdivisions, SUBDIVISIONS))
    rounded, middle = _centred_points(points, centre)
    relative = rounded - middle
    radii = np.linalg.norm(relative, axis=1)
    usable = np.flatnonzero(radii > radii.max() * 1e-12)
    # unit length: products with the sides of triangles neither vanish nor overflow
    directions = relative[usable] / radii[usable, np.newaxis]
    segment = triangles_towards(directions, body, splits)
    count = (2 * len(BASES[body]) - 4) * 4**splits
    farthest = _farthest_points(segment, radii[usable], count)
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


def _centred_points(
    points: ArrayLike, centre: ArrayLike | Literal["auto"]
) -> tuple[FloatArray, FloatArray]:
    """Return points rounded to their grid, and the given or automatic centre on the same grid.

    The centre is strictly inside the convex hull. Raises what `modified_convex_hull` raises.
    """
    # only the convex hull tells whether the centre is inside
    middle = modified_convex_hull(points, 1.0, centre).centre
    array = np.asarray(points, np.float64)
    return nearest_grid_points(array, grid_step(array)), middle


def _farthest_points(segment: LongArray, radii: FloatArray, count: int) -> LongArray:
    """Return the index of the farthest point of each of `count` segments; −1 for an empty segment.

    The first of equally far points is taken.
    """
    outwards = np.lexsort((-np.arange(len(radii)), radii))
    farthest = np.full(count, -1, np.int64)
    farthest[segment[outwards]] = outwards  # the last of several assignments remains
    return farthest
