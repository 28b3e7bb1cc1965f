"""Hue leaves as a table: the intervals of chroma inside a level, by hue and lightness.

Every face is visited once. Its corners limit the hues of the table that can cross it. The
half-plane of a hue crosses a face in a segment. Each lightness of the table within the segment is a
crossing of a horizontal line with the surface. The sorted crossings of a line are the ends of its
intervals.

A corner in the half-plane's plane, or an end at a lightness of the table, counts as above. The ends
of segments depend on their edge alone, so neighbours agree to the bit. No crossing is missing or
counted twice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.queries.index import Level, as_index
from gamutcore.queries.rows import checked_numbers
from gamutcore.queries.volume_cells import WHOLE_TURN, hue_span

__all__ = ["Leaves", "leaves"]

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
    MeshError
        As for `build_index`.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> found = leaves(tetrahedron, [45, 225], [0.25, 0.5, 2])
    >>> found.offsets.tolist(), found.chroma[:, 1].round(6).tolist()
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
def _count_below(numbers: FloatArray, limit: float, including: bool) -> int:
    """Return the number of sorted numbers below a limit, or up to it if `including`."""
    low, high = 0, len(numbers)
    while low < high:
        middle = (low + high) // 2
        if numbers[middle] < limit or (including and numbers[middle] == limit):
            low = middle + 1
        else:
            high = middle
    return low


@leaf_kernel
def _hues_of(triangle: FloatArray, origin: FloatArray, hues: FloatArray) -> tuple[int, int]:
    """Return the first hue that can cross a triangle, and their number, not reduced to one turn."""
    begin, span = hue_span(triangle, 3, origin)
    begin, span = begin - HUE_ROUNDING, span + 2.0 * HUE_ROUNDING
    if span >= WHOLE_TURN:
        return 0, len(hues)
    begin %= WHOLE_TURN
    first = _count_below(hues, begin, False)
    end = begin + span
    if end < WHOLE_TURN:
        return first, _count_below(hues, end, True) - first
    return first, len(hues) - first + _count_below(hues, end - WHOLE_TURN, True)


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
        low = _count_below(lightness, min(l_one, l_two), True)
        high = _count_below(lightness, max(l_one, l_two), True)
        for row in range(low, high):
            part = (lightness[row] - l_one) / (l_two - l_one)
            distance = c_one + part * (c_two - c_one)
            if distance < 0.0:
                continue
            cell = hue_cells[hue] + lightness_cells[row]
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
                for axis in range(3):
                    triangle[corner, axis] = vertices[mesh[face, corner], axis]
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
