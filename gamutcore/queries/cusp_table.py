"""The table of cusps: the edges of a level that may have its largest chroma, listed by hue.

The section of a level by a half-plane of constant hue consists of one segment for each face that it
meets. Chroma is linear along a segment, so its maximum is on an edge. Both faces of that edge lie
on the same side of it, seen along the axis of lightness. Only the edges of the silhouette do so.

Lightness is axis 0; the other two coordinates are 0 on the neutral axis.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.corner_table import following, preceding
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["CuspTable", "cusp_table", "find_cusp", "hue_sector", "hue_turn"]

MOST_SECTORS = 1 << 14

AREA_ROUNDING = 2.0**-49
"""Bound of the rounding error of a projected area ÷ the products of its terms."""


class CuspTable(NamedTuple):
    """The edges that may have cusps, listed by hue.

    Attributes
    ----------
    ends : (m, 6) float64
        Both ends of each edge.
    corners : (m,) int32
        The corner that faces the edge: 3 · face + its place in the face.
    sector_start : (sectors + 1,) int32
    sector_edges : (k,) int32
        The edges of each sector of hues.
    """

    ends: FloatArray
    corners: IndexArray
    sector_start: IndexArray
    sector_edges: IndexArray

    @property
    def nbytes(self) -> int:
        """Memory of the arrays in bytes."""
        return sum(field.nbytes for field in self)


def cusp_table(vertices: FloatArray, faces: IndexArray, opposite: IndexArray) -> CuspTable:
    """Return the table of cusps of a closed mesh; `opposite` (3 F,) is that of its corner table."""
    return CuspTable(*_table(vertices, faces, opposite))


@leaf_kernel
def hue_sector(a: float, b: float, sectors: int) -> int:
    """Return the sector of a hue: in order of hue, of about equal size, without trigonometry.

    The vector (a, b) may have any length, and rounding matters only at the bounds of sectors.
    """
    return min(int(0.25 * hue_turn(a, b) * sectors), sectors - 1)


@leaf_kernel
def hue_turn(a: float, b: float) -> float:
    """Return a number from 0 to 4 that increases with the hue, by 2 in half a turn, from −b on."""
    length = abs(a) + abs(b)
    across = b / length if length > 0.0 else 0.0
    return across + 1.0 if a >= 0.0 else 3.0 - across


@leaf_kernel
def find_cusp(ca: float, cb: float, table: CuspTable) -> tuple[float, float, int, float]:
    """Return chroma, lightness, edge and share of the cusp of a hue, given its cosine and sine.

    The edge is a row of the table, and the share is the weight of its second end. Chroma is −1 if
    the hue has no cusp.
    """
    sector = hue_sector(ca, cb, len(table.sector_start) - 1)
    largest, lightness, best, part = -1.0, np.nan, -1, 0.0
    for place in range(table.sector_start[sector], table.sector_start[sector + 1]):
        edge = table.sector_edges[place]
        pa, pb = table.ends[edge, 1], table.ends[edge, 2]
        qa, qb = table.ends[edge, 4], table.ends[edge, 5]
        p, q = ca * pb - cb * pa, ca * qb - cb * qa
        if (p > 0.0 and q > 0.0) or (p < 0.0 and q < 0.0):
            continue
        along_p, along_q = ca * pa + cb * pb, ca * qa + cb * qb
        # an edge within the half-plane has its largest chroma at an end
        share = p / (p - q) if p != q else (1.0 if along_q > along_p else 0.0)
        chroma = along_p + share * (along_q - along_p)
        if chroma >= 0.0 and chroma > largest:
            largest, best, part = chroma, edge, share
    if best >= 0:
        first, second = table.ends[best, 0], table.ends[best, 3]
        lightness = first + part * (second - first)
    return largest, lightness, best, part


@leaf_kernel
def _upward(vertices: FloatArray, faces: IndexArray, face: int) -> int:
    """Return 1 for a face visible from high lightness, −1 from low lightness; 0 if uncertain."""
    one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
    ua, ub = vertices[two, 1] - vertices[one, 1], vertices[two, 2] - vertices[one, 2]
    va, vb = vertices[three, 1] - vertices[one, 1], vertices[three, 2] - vertices[one, 2]
    area, bound = ua * vb - ub * va, AREA_ROUNDING * (abs(ua * vb) + abs(ub * va))
    return 1 if area > bound else (-1 if area < -bound else 0)


@leaf_kernel
def _sectors_of(ends: FloatArray, edge: int, sectors: int) -> tuple[int, int]:
    """Return the first sector that an edge may meet, and their number."""
    pa, pb, qa, qb = ends[edge, 1], ends[edge, 2], ends[edge, 4], ends[edge, 5]
    turn, reach = pa * qb - pb * qa, abs(pa * qb) + abs(pb * qa)
    if abs(turn) <= AREA_ROUNDING * reach:
        # an end on the axis, or an edge along a hue, maybe through the axis
        if pa * qa + pb * qb <= 0.0:
            return 0, sectors
        turn = 0.0
    first, last = hue_sector(pa, pb, sectors), hue_sector(qa, qb, sectors)
    if turn < 0.0 or (turn == 0.0 and (last - first) % sectors > sectors // 2):
        first, last = last, first
    # one more on each side for rounding
    return (first - 1) % sectors, min((last - first) % sectors + 3, sectors)


@kernel
def _table(
    vertices: FloatArray, faces: IndexArray, opposite: IndexArray
) -> tuple[FloatArray, IndexArray, IndexArray, IndexArray]:
    sides = np.empty(len(faces), np.int8)
    for face in range(len(faces)):
        sides[face] = _upward(vertices, faces, face)
    corners = np.empty(len(opposite) // 2, np.int32)
    count = 0
    for corner in range(len(opposite)):
        other = opposite[corner]
        if corner < other and sides[corner // 3] * sides[other // 3] <= 0:
            corners[count] = corner
            count += 1
    corners = corners[:count].copy()
    flat = faces.ravel()
    ends = np.empty((count, 6))
    for edge in range(count):
        one, two = flat[following(corners[edge])], flat[preceding(corners[edge])]
        for axis in range(3):
            ends[edge, axis], ends[edge, 3 + axis] = vertices[one, axis], vertices[two, axis]

    sectors = min(max(4, 2 * count), MOST_SECTORS)
    start = np.zeros(sectors + 1, np.int32)
    for edge in range(count):
        first, length = _sectors_of(ends, edge, sectors)
        for step in range(length):
            start[(first + step) % sectors + 1] += 1
    for sector in range(sectors):
        start[sector + 1] += start[sector]
    listed = np.empty(start[sectors], np.int32)
    free = start[:-1].copy()
    for edge in range(count):
        first, length = _sectors_of(ends, edge, sectors)
        for step in range(length):
            sector = (first + step) % sectors
            listed[free[sector]] = edge
            free[sector] += 1
    return ends, corners, start, listed
