"""Segment maxima: the surface through the farthest colour of each segment of two angles.

Source: Morovic & Luo, "Calculating medium and image gamut boundaries for gamut mapping" (2000).

Directions from the centre are divided uniformly by two angles: the polar angle from the first axis
(L* in CIELAB) and the azimuth about it (the hue angle). The farthest colour of each segment is a
vertex, and the grid determines the faces.

The published method leaves three points open (``docs/decisions/other-boundaries.md`` has the
reasons). Empty segments and the two poles, which are vertices of their own, get a radius by
interpolation over the grid. Quadrilaterals are divided by the diagonal that gives the larger
volume. Vertices of a face that would not see the centre are turned towards the middles of their
segments as far as needed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np

from gamutcore.arguments import Array, WholeNumber
from gamutcore.boundary.modified_convex_hull import Boundary
from gamutcore.boundary.published.segments import centred_points, farthest_points
from gamutcore.errors import BoundaryError
from gamutcore.geometry import (
    TriangleMesh,
    faces_not_seeing_centre,
    grid_step,
    nearest_grid_points,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from gamutcore.arrays import FloatArray, IndexArray, LongArray

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
        The centre is not three numbers.
    InvalidPointsError
        The points are not an (n, 3) array of finite numbers below 10¹².
    TooFewPointsError, FlatPointsError, CentreError
        The points enclose no volume, or the centre is not inside it.
    BoundaryError
        The grid of positions does not resolve the segments about this centre.
    """
    polar, azimuth = segments
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
