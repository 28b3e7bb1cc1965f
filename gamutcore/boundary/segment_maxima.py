"""Segment maxima: the farthest colour of every segment of a uniform polar and azimuth grid.

Morovic & Luo, "Calculating medium and image gamut boundaries for gamut mapping" (2000): directions
from the centre are divided uniformly by their polar angle from the first axis (L* in CIELAB) and by
their azimuth about it (the hue angle); the farthest colour of each segment is a vertex, and the
grid of segments says which vertices are joined.

What the description of the method leaves open is decided here (``docs/decisions/other-boundaries``
has the reasons): empty segments and the two poles, which are vertices of their own, get a radius
from a membrane stretched over the grid; of a quadrilateral's two diagonals the one with the larger
volume is taken; and where maxima in neighbouring segments stand so badly that a face would not see
the centre, they are turned towards the middles of their segments just as far as is needed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, cast

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.boundary.modified_convex_hull import Boundary
from gamutcore.boundary.points import centred_points, farthest_points
from gamutcore.errors import BoundaryError
from gamutcore.grid import grid_step, nearest_grid_points
from gamutcore.mesh import TriangleMesh
from gamutcore.option_types import WholeNumber, WholeNumbers, check_option
from gamutcore.star_shape import faces_not_seeing_centre

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["SEGMENTS", "SEGMENT_COUNTS", "segment_maxima"]

SEGMENTS = (16, 16)
"""Polar and azimuth segments unless told: those of Morovic & Luo, and of Little CMS."""

SEGMENT_COUNTS = WholeNumbers(
    (WholeNumber(2, 180), WholeNumber(3, 360)), "polar and azimuth segments"
)
"""Accepted values of `segments`. Fewer do not surround the centre. One degree each way makes 64,800
segments: most are empty, and at the poles they are as narrow as the grid of positions resolves."""

TURNS = 8
"""Steps in which a vertex is turned from its own direction to the middle of its segment."""

ATTEMPTS = 100
"""How often faces that do not see the centre are looked for; on real devices hardly ever twice."""

RESOLVED = 8.0
"""A vertex is told apart from its neighbours if it is this many grid steps away from them: rounding
moves either by 0.87 steps at most."""


def segment_maxima(
    points: ArrayLike,
    segments: tuple[int, int] = SEGMENTS,
    centre: ArrayLike | Literal["auto"] = "auto",
) -> Boundary:
    """Join the farthest points of uniform polar and azimuth segments about a centre.

    Parameters
    ----------
    points : (n, 3) array_like
        Colours, in the order of the colour space. They are rounded to their grid first.
    segments : (polar, azimuth) int, optional
        Numbers of segments; see `SEGMENT_COUNTS`.
    centre : (3,) array_like or "auto", optional
        As for `modified_convex_hull`.

    Returns
    -------
    Boundary
        Of polar × azimuth + 2 vertices: the segments row by row from the positive end of the first
        axis, then the two poles. A vertex that is not one of the points, because its segment is
        empty, because it is a pole or because it had to be moved, has the source −1. γ is 0: radii
        do not decide which maxima are on the surface.

    Raises
    ------
    OptionError
        If the numbers of segments are not accepted or the centre is not three numbers.
    InvalidPointsError
        If the points are not an (n, 3) array of finite numbers below 10¹².
    TooFewPointsError, FlatPointsError, CentreError
        If the points enclose no volume, or the centre is not inside it.
    BoundaryError
        If the grid of positions does not resolve the segments about this centre.
    """
    polar, azimuth = cast("tuple[int, int]", check_option("segments", segments, SEGMENT_COUNTS))
    rounded, middle = centred_points(points, centre)
    relative = rounded - middle
    radii = np.linalg.norm(relative, axis=1)
    usable = np.flatnonzero(radii > radii.max() * 1e-12)
    segment = _segments_of(relative[usable], polar, azimuth)
    farthest = farthest_points(segment, radii[usable], polar * azimuth)
    sources: LongArray = np.full(polar * azimuth + 2, -1, np.int64)
    sources[:-2][farthest >= 0] = usable[farthest[farthest >= 0]]

    filled = sources >= 0
    directions, sizes = _middles(polar, azimuth)
    own, reach = directions.copy(), np.zeros(len(sources))
    own[filled] = relative[sources[filled]] / radii[sources[filled], np.newaxis]
    reach[filled] = radii[sources[filled]]
    reach = _stretched(reach, filled, polar, azimuth)

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
            " positions are resolved",
            where={"field": "segments"},
            remedy="fewer segments, or a centre farther inside the gamut",
        )
    mesh = TriangleMesh(vertices, faces)
    return Boundary(mesh, middle, np.where(at_colour, sources, -1), 0.0)


def _segments_of(relative: FloatArray, polar: int, azimuth: int) -> LongArray:
    """Number of the segment that each point is in, row by row from the positive first axis."""
    slope = np.arctan2(np.hypot(relative[:, 1], relative[:, 2]), relative[:, 0])
    turn = np.arctan2(relative[:, 2], relative[:, 1]) / (2 * np.pi) % 1.0
    row = np.minimum((slope / np.pi * polar).astype(np.int64), polar - 1)
    return row * azimuth + np.minimum((turn * azimuth).astype(np.int64), azimuth - 1)


def _middles(polar: int, azimuth: int) -> tuple[FloatArray, FloatArray]:
    """Directions of the middles of all segments and of the poles, and how far apart they are.

    Returns
    -------
    directions : (polar · azimuth + 2, 3) float64
        Unit vectors; the last two are the poles.
    sizes : (polar · azimuth + 2,) float64
        Angle to the nearest neighbour, in radians.
    """
    slope = np.repeat((np.arange(polar) + 0.5) * np.pi / polar, azimuth)
    turn = np.tile((np.arange(azimuth) + 0.5) * 2 * np.pi / azimuth, polar)
    middles = np.stack(
        [np.cos(slope), np.sin(slope) * np.cos(turn), np.sin(slope) * np.sin(turn)], axis=1
    )
    sizes = np.minimum(np.sin(slope) * 2 * np.pi / azimuth, np.pi / (2 * polar))
    poles = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    return np.vstack([middles, poles]), np.append(sizes, [np.pi / (2 * polar)] * 2)


def _stretched(
    reach: FloatArray, filled: NDArray[np.bool_], polar: int, azimuth: int
) -> FloatArray:
    """Radii with those of empty segments and poles from a membrane fixed at the filled ones.

    The membrane's discrete Laplacian (finite volumes over the segments, so that it is the sphere's)
    is zero where it is free: no radius is outside the range of the filled ones around it.

    Parameters
    ----------
    reach : (polar · azimuth + 2,) float64
        Radii where filled.
    filled : (polar · azimuth + 2,) bool
    polar, azimuth : int

    Returns
    -------
    (polar · azimuth + 2,) float64
    """
    from scipy.sparse import coo_array, diags_array  # noqa: PLC0415  # slow, for this method alone
    from scipy.sparse.linalg import spsolve  # noqa: PLC0415

    number = np.arange(polar * azimuth).reshape(polar, azimuth)
    high, wide = np.pi / polar, 2 * np.pi / azimuth
    middle, border = (np.arange(polar) + 0.5) * high, np.arange(1, polar) * high
    along = np.repeat(high / (np.sin(middle) * wide), azimuth)
    across = np.repeat(np.sin(border) * wide / high, azimuth)
    # a pole is half a segment from the middles around it: the border is at a quarter
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
    stretched = reach.copy()
    stretched[free] = np.clip(
        spsolve(stiffness.tocsc(), pull), reach[filled].min(), reach[filled].max()
    )
    return stretched


def _faces(positions: FloatArray, polar: int, azimuth: int) -> IndexArray:
    """Triangles of the grid of segments: fans at the poles, two for every four segments between.

    Of the diagonals of a quadrilateral along which both of its triangles see the centre, the one
    with the larger volume is taken: gamuts are more convex than not.

    Parameters
    ----------
    positions : (polar · azimuth + 2, 3) float64
        Relative to the centre.
    polar, azimuth : int

    Returns
    -------
    (2 · polar · azimuth, 3) int32
    """
    number = np.arange(polar * azimuth, dtype=np.int32).reshape(polar, azimuth)
    east = np.roll(number, -1, axis=1)
    first = np.full(azimuth, polar * azimuth, np.int32)
    a, b, c, d = (
        each.ravel() for each in (number[:-1], number[1:], east[1:], east[:-1])
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
