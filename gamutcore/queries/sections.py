"""Sections of a level: slices by a plane, and hue leaves, as closed polygons on the surface.

A face is crossed by the plane if its corners are on both sides. A corner in the plane counts as
above it, as if the plane were moved down by an infinitely small amount: each crossed face then has
exactly two crossed edges, and the polygons close by construction.

Polygons are counter-clockwise around the inside of the gamut, and clockwise around holes, which a
section beside the centre can have. They do not repeat the first corner at the end.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.errors import InvalidPointsError
from gamutcore.kernels import kernel
from gamutcore.queries.index import Level, LevelIndex, as_index
from gamutcore.queries.rows import checked_numbers, checked_points

__all__ = ["Section", "hue_leaf", "slice_polygons"]


class Section(NamedTuple):
    """Polygons of a section, one after the other.

    Attributes
    ----------
    points : (m, 3) float64
        Corners.
    offsets : (k + 1,) int32
        Polygon i has the corners from ``offsets[i]`` to ``offsets[i + 1]``.
    faces : (m,) int32
        The face of each corner.
    weights : (m, 3) float64
        Barycentric coordinates in the face.
    """

    points: FloatArray
    offsets: IndexArray
    faces: IndexArray
    weights: FloatArray

    @property
    def polygons(self) -> list[FloatArray]:
        """The corners of each polygon, (m, 3)."""
        return np.split(self.points, self.offsets[1:-1]) if len(self.offsets) > 1 else []


def slice_polygons(level: Level, normal: ArrayLike, offset: float) -> Section:
    """Return the section of a level by a plane.

    Parameters
    ----------
    level : LevelIndex or (vertices, faces, centre)
    normal : (3,) array_like
        Of the plane, of any length: (1, 0, 0) for a constant lightness.
    offset : float
        The plane has the points p with normal · p = offset.

    Returns
    -------
    Section
        Counter-clockwise seen from the side that the normal points to. Empty if the plane does not
        meet the level, or touches it only.

    Raises
    ------
    InvalidPointsError
        The normal or the offset is not finite, or the normal has no direction.
    MeshError
        As for `build_index`.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> [polygon.tolist() for polygon in slice_polygons(tetrahedron, (1, 0, 0), 0.5).polygons]
    [[[0.5, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5]]]
    """
    direction = checked_points(np.reshape(np.asarray(normal), (1, -1)), "normal")[0]
    distance = float(checked_numbers(np.reshape(np.asarray(offset), -1)[:1], "offset")[0])
    if not direction.any():
        raise InvalidPointsError(
            "The normal of the plane is zero.",
            where={"field": "normal"},
            remedy="Give three numbers that are not all 0.",
        )
    index = as_index(level)
    walk = _walk(index, direction, distance)
    kept, offsets = _without_repetitions(walk.points, walk.ends)
    return Section(walk.points[kept], offsets, walk.faces[kept], walk.entries[kept])


def hue_leaf(level: Level, hue: float) -> Section:
    """Return the section of a level by a half-plane of constant hue.

    Parameters
    ----------
    level : LevelIndex or (vertices, faces, centre)
    hue : float
        Hue angle in degrees.

    Returns
    -------
    Section
        Counter-clockwise with chroma to the right and lightness upwards. A leaf may have several
        polygons, and none of them needs to touch the neutral axis. Edges along the axis are inside
        the gamut, but their ends are on its surface.

    Raises
    ------
    InvalidPointsError
        The hue is not finite.
    MeshError
        As for `build_index`.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)]) - (0, 0.25, 0.25)
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0, 0))
    >>> hue_leaf(tetrahedron, 0).polygons[0].round(9).tolist()
    [[0.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.5, 0.0, 0.0]]
    """
    angle = math.radians(float(checked_numbers([hue], "hue")[0]) % 360.0)
    cosine, sine = math.cos(angle), math.sin(angle)
    walk = _walk(as_index(level), np.array([0.0, sine, -cosine]), 0.0)
    clipped = _half(walk, walk.points @ (0.0, cosine, sine))
    kept, offsets = _without_repetitions(clipped.points, clipped.ends)
    return Section(clipped.points[kept], offsets, clipped.faces[kept], clipped.entries[kept])


class _Walk(NamedTuple):
    """Corners of polygons in order, each with the face that begins there.

    `entries` and `exits` are the barycentric coordinates of a corner and of the next one in the
    corner's face. The corners of polygon i end before ``ends[i]``.
    """

    points: FloatArray
    faces: IndexArray
    entries: FloatArray
    exits: FloatArray
    ends: list[int]


def _walk(index: LevelIndex, normal: FloatArray, offset: float) -> _Walk:
    """Return the polygons of a section by a plane, from face to face."""
    # distances of vertices from a plane should not depend on the length of the normal
    scale = 1.0 / float(np.abs(normal).max())
    heights = index.vertices @ (scale * normal) - scale * offset
    faces, entry, way_out = _crossed(index.faces, heights)
    count = len(heights)
    # an edge is named by its end above and its end below; the next face has it as its way in
    keys = entry[:, 0].astype(np.int64) * count + entry[:, 1]
    order = np.argsort(keys)
    beside = way_out[:, 0].astype(np.int64) * count + way_out[:, 1]
    following = order[np.searchsorted(keys[order], beside)].tolist()
    sequence, ends = _cycles(following)
    above, below = heights[entry[:, 0]], heights[entry[:, 1]]
    share = above / (above - below)
    one, two = index.vertices[entry[:, 0]], index.vertices[entry[:, 1]]
    points = one + share[:, np.newaxis] * (two - one)
    corners = index.faces[faces]
    entries = _weights(corners, entry, share)
    exits = _weights(corners, way_out, share[following])
    chosen = np.array(sequence, np.int64)
    return _Walk(points[chosen], faces[chosen], entries[chosen], exits[chosen], ends)


@kernel
def _crossed(mesh: IndexArray, heights: FloatArray) -> tuple[IndexArray, IndexArray, IndexArray]:
    """Return the crossed faces, and the ends of the edges where a polygon enters and leaves them.

    Of both ends, the first is above the plane and the second below.
    """
    count = 0
    for face in range(len(mesh)):
        first = heights[mesh[face, 0]] >= 0.0
        count += (heights[mesh[face, 1]] >= 0.0) != first or (
            heights[mesh[face, 2]] >= 0.0
        ) != first
    faces = np.empty(count, np.int32)
    entry, way_out = np.empty((count, 2), np.int32), np.empty((count, 2), np.int32)
    count = 0
    for face in range(len(mesh)):
        first = heights[mesh[face, 0]] >= 0.0
        if (heights[mesh[face, 1]] >= 0.0) == first and (heights[mesh[face, 2]] >= 0.0) == first:
            continue
        faces[count] = face
        for at in range(3):
            start, end = mesh[face, at], mesh[face, (at + 1) % 3]
            if heights[start] >= 0.0 and heights[end] < 0.0:
                entry[count, 0], entry[count, 1] = start, end
            elif heights[start] < 0.0 and heights[end] >= 0.0:
                way_out[count, 0], way_out[count, 1] = end, start
        count += 1
    return faces, entry, way_out


def _cycles(following: list[int]) -> tuple[list[int], list[int]]:
    """Return the cycles of a permutation one after the other, and the end of each."""
    waiting = [True] * len(following)
    sequence: list[int] = []
    ends: list[int] = []
    for start in range(len(following)):
        place = start
        while waiting[place]:
            waiting[place] = False
            sequence.append(place)
            place = following[place]
        if len(sequence) > (ends[-1] if ends else 0):
            ends.append(len(sequence))
    return sequence, ends


def _weights(corners: IndexArray, edge: IndexArray, share: FloatArray) -> FloatArray:
    """Return barycentric coordinates on edges; `share` is the weight of the second end."""
    first, second = corners == edge[:, :1], corners == edge[:, 1:]
    part = share[:, np.newaxis]
    return np.asarray(first * (1.0 - part) + second * part)


def _half(walk: _Walk, chroma: FloatArray) -> _Walk:
    """Return the part of a section with chroma of at least 0, cut at the neutral axis.

    Upwards along the axis, the inside begins where a polygon comes to this side. It ends where a
    polygon leaves this side. The ends are joined in this order.
    """
    inside = chroma >= 0.0
    # pieces of polygons on this side: where each comes, its corners, and where it leaves
    closed: list[LongArray] = []
    pieces: list[LongArray] = []
    comes: list[int] = []
    leaves: list[int] = []
    begin = 0
    for end in walk.ends:
        here = inside[begin:end]
        if here.all():
            closed.append(np.arange(begin, end))
        elif here.any():
            starts = np.flatnonzero(here & ~np.roll(here, 1))
            stops = np.flatnonzero(here & ~np.roll(here, -1))
            if stops[0] < starts[0]:
                stops = np.roll(stops, -1)
            for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
                length = (stop - start) % len(here) + 1
                pieces.append(begin + (start + np.arange(length)) % len(here))
                comes.append(begin + (start - 1) % len(here))
                leaves.append(begin + stop)
        begin = end
    following = np.concatenate([np.zeros(0, np.int64), *_next_corners(walk.ends)])
    into, out = _cuts(walk, chroma, following, comes), _cuts(walk, chroma, following, leaves)
    rank_in, rank_out = (np.argsort(cut.points[:, 0], kind="stable") for cut in (into, out))
    partner = np.empty(len(pieces), np.int64)
    partner[rank_out] = rank_in
    parts: list[tuple[FloatArray, IndexArray, FloatArray]] = []
    ends: list[int] = []
    total = 0
    for corners in closed:
        parts.append((walk.points[corners], walk.faces[corners], walk.entries[corners]))
        total += len(corners)
        ends.append(total)
    sequence, piece_ends = _cycles(partner.tolist())
    begin = 0
    for end in piece_ends:
        for number in sequence[begin:end]:
            corners = pieces[number]
            for cut, chosen in ((into, slice(number, number + 1)), (walk, corners), (out, None)):
                at = slice(number, number + 1) if chosen is None else chosen
                parts.append((cut.points[at], cut.faces[at], cut.entries[at]))
                total += len(parts[-1][0])
        ends.append(total)
        begin = end
    if not parts:
        return _Walk(walk.points[:0], walk.faces[:0], walk.entries[:0], walk.exits[:0], [])
    points, faces, entries = (np.concatenate(column) for column in zip(*parts, strict=True))
    return _Walk(points, faces, entries, entries, ends)


def _next_corners(ends: list[int]) -> list[LongArray]:
    """Return, for each polygon, the indices of the corners after its corners."""
    begins = [0, *ends[:-1]]
    return [np.roll(np.arange(begin, end), -1) for begin, end in zip(begins, ends, strict=True)]


def _cuts(walk: _Walk, chroma: FloatArray, following: LongArray, before: list[int]) -> _Walk:
    """Return the points on the neutral axis between corners `before` and the following ones."""
    here = np.array(before, np.int64)
    there = following[here]
    share = (chroma[here] / (chroma[here] - chroma[there]))[:, np.newaxis]
    points = walk.points[here] + share * (walk.points[there] - walk.points[here])
    points[:, 1:] = 0.0
    weights = (1.0 - share) * walk.entries[here] + share * walk.exits[here]
    return _Walk(points, walk.faces[here], weights, weights, [])


def _without_repetitions(points: FloatArray, ends: list[int]) -> tuple[LongArray, IndexArray]:
    """Return the corners that differ from the corner before, and the offsets of their polygons.

    Polygons with fewer than three different corners are dropped: the plane touches the level.
    """
    kept: list[LongArray] = [np.zeros(0, np.int64)]
    offsets = [0]
    begin = 0
    for end in ends:
        corners = points[begin:end]
        different = (corners != np.roll(corners, 1, axis=0)).any(axis=1)
        if different.sum() >= 3:
            kept.append(begin + np.flatnonzero(different))
            offsets.append(offsets[-1] + int(different.sum()))
        begin = end
    return np.concatenate(kept), np.array(offsets, np.int32)
