"""Sections of a level: by a plane, by half-planes of hue, and the cusps of hues.

`slice_polygons` and `hue_leaf` give closed polygons on the surface. A face is crossed by the plane
if its corners are on both sides. A corner in the plane counts as above it, as if the plane were
moved down by an infinitely small amount: each crossed face then has exactly two crossed edges, and
the polygons close by construction. Polygons are counter-clockwise around the inside of the gamut,
and clockwise around holes, which a section beside the centre can have. They do not repeat the first
corner at the end.

`leaves` gives the sections of many hues as a table: the intervals of chroma, by hue and lightness.
Every face is visited once. Its corners limit the hues of the table that can cross it. The
half-plane of a hue crosses a face in a segment. Each lightness of the table within the segment is a
crossing of a horizontal line with the surface. The sorted crossings of a line are the ends of its
intervals. A corner in the half-plane's plane, or an end at a lightness of the table, counts as
above. The ends of segments depend on their edge alone, so neighbours agree to the bit. No crossing
is missing or counted twice.

`cusp_points` gives the points of largest chroma at a hue, over all lightnesses.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.errors import InvalidPointsError
from gamutcore.geometry import row, write_row
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.search.hue_tables import WHOLE_TURN, CuspTable, find_cusp, hue_span, write_cusp
from gamutcore.search.index import Level, LevelIndex, as_index, checked_numbers, checked_points

__all__ = ["Cusps", "Leaves", "Section", "cusp_points", "hue_leaf", "leaves", "slice_polygons"]


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
    return _section(_walk(index, direction, distance))


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
    return _section(_half(walk, walk.points @ (0.0, cosine, sine)))


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


def _section(walk: _Walk) -> Section:
    """Return the corners that differ from the corner before.

    Polygons with fewer than three different corners are dropped: the plane touches the level.
    """
    corner_rows: list[LongArray] = [np.zeros(0, np.int64)]
    offsets = [0]
    begin = 0
    for end in walk.ends:
        corners = walk.points[begin:end]
        different = (corners != np.roll(corners, 1, axis=0)).any(axis=1)
        if different.sum() >= 3:
            corner_rows.append(begin + np.flatnonzero(different))
            offsets.append(offsets[-1] + int(different.sum()))
        begin = end
    chosen = np.concatenate(corner_rows)
    return Section(
        walk.points[chosen],
        np.array(offsets, np.int32),
        walk.faces[chosen],
        walk.entries[chosen],
    )


HUE_ROUNDING = 1e-12
"""Tolerance of the hues of a face's corners, in radians."""


class Leaves(NamedTuple):
    """Intervals of chroma inside a level, for every hue and lightness.

    Attributes
    ----------
    hues : (h,) float64
        In degrees, as given.
    lightness : (l,) float64
        As given.
    offsets : (h · l + 1,) int32
        Hue i and lightness j have the intervals from ``offsets[i * l + j]`` to the next offset.
    chroma : (m, 2) float64
        Smallest and largest chroma of each interval. An interval from the neutral axis begins at 0.
    faces : (m, 2) int32
        The faces at both ends; −1 on the neutral axis.
    weights : (m, 2, 3) float64
        Barycentric coordinates in the faces; NaN on the neutral axis.
    """

    hues: FloatArray
    lightness: FloatArray
    offsets: IndexArray
    chroma: FloatArray
    faces: IndexArray
    weights: FloatArray


def leaves(level: Level, hues: ArrayLike, lightness: ArrayLike) -> Leaves:
    """Return the intervals of chroma inside a level, for every hue and lightness.

    Parameters
    ----------
    level : LevelIndex or (vertices, faces, centre)
    hues : (h,) array_like
        Hue angles in degrees.
    lightness : (l,) array_like

    Returns
    -------
    Leaves

    Raises
    ------
    InvalidPointsError
        A number is not finite; ``where["row"]`` names it.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> hue_leaves = leaves(tetrahedron, [45, 225], [0.25, 0.5, 2])
    >>> hue_leaves.offsets.tolist(), hue_leaves.chroma[:, 1].round(6).tolist()
    ([0, 1, 2, 2, 2, 2, 2], [0.53033, 0.353553])
    """
    angles, heights = checked_numbers(hues, "hues"), checked_numbers(lightness, "lightness")
    index = as_index(level)
    turned = np.radians(angles % 360.0)
    hue_order, height_order = np.argsort(turned), np.argsort(heights)
    crossing, chroma, faces, weights = _crossings(
        index.vertices,
        index.faces,
        turned[hue_order],
        heights[height_order],
        hue_order.astype(np.int64) * len(heights),
        height_order.astype(np.int64),
    )
    return Leaves(angles, heights, *_intervals(crossing, chroma, faces, weights))


@leaf_kernel
def _hues_of(triangle: FloatArray, origin: FloatArray, hues: FloatArray) -> tuple[int, int]:
    """Return the first hue that can cross a triangle, and their number, not reduced to one turn."""
    begin, span = hue_span(triangle, 3, origin)
    begin, span = begin - HUE_ROUNDING, span + 2.0 * HUE_ROUNDING
    if span >= WHOLE_TURN:
        return 0, len(hues)
    begin %= WHOLE_TURN
    first = int(np.searchsorted(hues, begin))
    end = begin + span
    if end < WHOLE_TURN:
        return first, int(np.searchsorted(hues, end, "right")) - first
    return first, len(hues) - first + int(np.searchsorted(hues, end - WHOLE_TURN, "right"))


@leaf_kernel
def _visit(
    face: int,
    triangle: FloatArray,
    origin: FloatArray,
    hues: FloatArray,
    lightness: FloatArray,
    hue_cells: LongArray,
    lightness_cells: LongArray,
    slots: IndexArray,
    chroma: FloatArray,
    faces: IndexArray,
    weights: FloatArray,
) -> None:
    """Visit the crossings of a face: count them, or write them if there is room."""
    writing = len(chroma) > 0
    first, number = _hues_of(triangle, origin, hues)
    for step in range(first, first + number):
        hue = step % len(hues)
        cosine, sine = np.cos(hues[hue]), np.sin(hues[hue])
        # up to two edges are crossed; each end of the segment: lightness, chroma, corners, share
        found = 0
        l_one = c_one = t_one = l_two = c_two = t_two = 0.0
        above_one = below_one = above_two = below_two = 0
        for at in range(3):
            one, two = at, (at + 1) % 3
            side_one = cosine * triangle[one, 2] - sine * triangle[one, 1]
            side_two = cosine * triangle[two, 2] - sine * triangle[two, 1]
            if (side_one >= 0.0) == (side_two >= 0.0):
                continue
            if side_one < 0.0:
                one, two = two, one
                side_one, side_two = side_two, side_one
            share = side_one / (side_one - side_two)
            c_start = cosine * triangle[one, 1] + sine * triangle[one, 2]
            c_end = cosine * triangle[two, 1] + sine * triangle[two, 2]
            height = triangle[one, 0] + share * (triangle[two, 0] - triangle[one, 0])
            along = c_start + share * (c_end - c_start)
            if found == 0:
                l_one, c_one, t_one, above_one, below_one = height, along, share, one, two
            else:
                l_two, c_two, t_two, above_two, below_two = height, along, share, one, two
            found += 1
        if found < 2:
            continue
        low = np.searchsorted(lightness, min(l_one, l_two), "right")
        high = np.searchsorted(lightness, max(l_one, l_two), "right")
        for line in range(low, high):
            part = (lightness[line] - l_one) / (l_two - l_one)
            distance = c_one + part * (c_two - c_one)
            if distance < 0.0:
                continue
            cell = hue_cells[hue] + lightness_cells[line]
            place = slots[cell]
            slots[cell] += 1
            if writing:
                chroma[place], faces[place] = distance, face
                for at in range(3):
                    weights[place, at] = 0.0
                weights[place, above_one] += (1.0 - part) * (1.0 - t_one)
                weights[place, below_one] += (1.0 - part) * t_one
                weights[place, above_two] += part * (1.0 - t_two)
                weights[place, below_two] += part * t_two


@kernel
def _crossings(
    vertices: FloatArray,
    mesh: IndexArray,
    hues: FloatArray,
    lightness: FloatArray,
    hue_cells: LongArray,
    lightness_cells: LongArray,
) -> tuple[IndexArray, FloatArray, IndexArray, FloatArray]:
    """Return the crossings of each cell in order of chroma, compressed by start (h l + 1,).

    Hues (h,) in radians and lightnesses (l,) increase. The sum of `hue_cells` (h,) and
    `lightness_cells` (l,) is the cell. The result is start, chroma (m,), faces (m,) and weights (m,
    3).
    """
    cells = len(hues) * len(lightness)
    slots = np.zeros(cells + 1, np.int32)
    chroma, faces, weights = np.empty(0), np.empty(0, np.int32), np.empty((0, 3))
    start = np.zeros(cells + 1, np.int32)
    triangle, origin = np.empty((3, 3)), np.zeros(3)
    for _ in range(2):
        for face in range(len(mesh)):
            for corner in range(3):
                write_row(triangle, corner, 0, row(vertices, mesh[face, corner], 0))
            _visit(
                face,
                triangle,
                origin,
                hues,
                lightness,
                hue_cells,
                lightness_cells,
                slots,
                chroma,
                faces,
                weights,
            )
        if len(chroma) == 0:
            total = 0
            for cell in range(cells + 1):
                start[cell] = total
                total += slots[cell]
                slots[cell] = start[cell]
            chroma, faces, weights = (
                np.empty(total),
                np.empty(total, np.int32),
                np.empty((total, 3)),
            )
    for cell in range(cells):
        for place in range(start[cell] + 1, start[cell + 1]):
            at = place
            while at > start[cell] and chroma[at] < chroma[at - 1]:
                chroma[at], chroma[at - 1] = chroma[at - 1], chroma[at]
                faces[at], faces[at - 1] = faces[at - 1], faces[at]
                for axis in range(3):
                    weights[at, axis], weights[at - 1, axis] = (
                        weights[at - 1, axis],
                        weights[at, axis],
                    )
                at -= 1
    return start, chroma, faces, weights


def _intervals(
    start: IndexArray, chroma: FloatArray, faces: IndexArray, weights: FloatArray
) -> tuple[IndexArray, FloatArray, IndexArray, FloatArray]:
    """Return offsets and both ends of the intervals from the sorted crossings of each cell."""
    counts = np.diff(start)
    # an odd number: the axis is inside, and the first interval begins there
    odd = counts % 2 == 1
    offsets = np.concatenate([[0], np.cumsum((counts + 1) // 2)]).astype(np.int32)
    ends = 2 * offsets[-1]
    at = np.arange(len(chroma)) + np.repeat(np.cumsum(odd), counts)
    all_chroma, all_faces = np.zeros(ends), np.full(ends, -1, np.int32)
    all_weights = np.full((ends, 3), np.nan)
    all_chroma[at], all_faces[at], all_weights[at] = chroma, faces, weights
    return (
        offsets,
        all_chroma.reshape(-1, 2),
        all_faces.reshape(-1, 2),
        all_weights.reshape(-1, 2, 3),
    )


class Cusps(NamedTuple):
    """Cusps, one for each hue. Rows without one are NaN, and their face is −1.

    Attributes
    ----------
    points : (n, 3) float64
        On the surface of the level.
    chroma : (n,) float64
    faces : (n,) int32
    weights : (n, 3) float64
        Barycentric coordinates in the face.
    """

    points: FloatArray
    chroma: FloatArray
    faces: IndexArray
    weights: FloatArray


def cusp_points(hues: ArrayLike, level: Level) -> Cusps:
    """Return the points of largest chroma at given hues.

    Parameters
    ----------
    hues : (n,) array_like
        Hue angles in degrees.
    level : LevelIndex or (vertices, faces, centre)

    Returns
    -------
    Cusps
        A hue has none if its half-plane does not meet the level.

    Raises
    ------
    InvalidPointsError
        A hue is not a finite number; ``where["row"]`` names it.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), 100 * np.eye(3)]) - (0, 20, 20)
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (20, 0, 0))
    >>> cusp_points([0, 90], tetrahedron).points.round(9).tolist()
    [[0.0, 60.0, 0.0], [0.0, 0.0, 60.0]]
    """
    angles = np.radians(checked_numbers(hues, "hues"))
    return Cusps(*_cusps(np.cos(angles), np.sin(angles), as_index(level).cusps))


@kernel
def _cusps(
    cosines: FloatArray, sines: FloatArray, table: CuspTable
) -> tuple[FloatArray, FloatArray, IndexArray, FloatArray]:
    count = len(cosines)
    points, chromas = np.full((count, 3), np.nan), np.full(count, np.nan)
    faces, weights = np.full(count, -1, np.int32), np.full((count, 3), np.nan)
    for number in range(count):
        ca, cb = cosines[number], sines[number]
        chroma, lightness, edge, share = find_cusp(ca, cb, table)
        if edge < 0:
            continue
        write_row(points, number, 0, (lightness, chroma * ca, chroma * cb))
        chromas[number] = chroma
        faces[number] = write_cusp(table, edge, share, weights, number)
    return points, chromas, faces, weights
