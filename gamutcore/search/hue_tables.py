"""Tables by hue: the edges that may have cusps, and the faces that a half-plane of hue meets.

The circle of hues is divided into sectors of about equal size, without trigonometry (`hue_turn`).
Lightness is axis 0; the other two coordinates are 0 on the neutral axis.

- `CuspTable` lists edges. The section of a level by a half-plane of constant hue consists of one
  segment for each face that it meets. Chroma is linear along a segment, so its maximum is on an
  edge. Both faces of that edge lie on the same side of it, seen along the axis of lightness. Only
  the edges of the silhouette do so.
- `HueTable` lists faces. For each face that meets a sector, a rectangle holds the lightness and
  chroma of all its points in the sector. The rectangles of a sector are sorted by their direction
  from the neutral axis, so that neighbours are consecutive. Rectangles of nodes enclose eight
  others each. The search in a half-plane is thus two-dimensional.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np

from gamutcore.arrays import ByteArray, Float32Array, FloatArray, IndexArray
from gamutcore.geometry import grouped, next_corner, previous_corner
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.search.face_tree import WIDTH

__all__ = [
    "RECTANGLE",
    "WHOLE_TURN",
    "CuspTable",
    "HueTable",
    "cusp_table",
    "find_cusp",
    "hue_part",
    "hue_sector",
    "hue_span",
    "hue_table",
    "hue_turn",
    "write_cusp",
]

WHOLE_TURN = 2.0 * np.pi


@leaf_kernel
def hue_turn(a: float, b: float) -> float:
    """Return a number from 0 to 4 that increases with the hue, by 2 in half a turn, from −b on."""
    length = abs(a) + abs(b)
    across = b / length if length > 0.0 else 0.0
    return across + 1.0 if a >= 0.0 else 3.0 - across


@leaf_kernel
def hue_sector(a: float, b: float, sectors: int) -> int:
    """Return the sector of a hue: in order of hue, of about equal size, without trigonometry.

    The vector (a, b) may have any length, and rounding matters only at the bounds of sectors.
    """
    return min(int(0.25 * hue_turn(a, b) * sectors), sectors - 1)


@leaf_kernel
def hue_span(polygon: FloatArray, count: int, origin: FloatArray) -> tuple[float, float]:
    """Return the first hue of a convex polygon, from −2 π to π, and its span, in radians.

    The span is a whole turn for a polygon around the neutral axis. Corners on the axis have no hue.
    """
    start, low, high = np.inf, 0.0, 0.0
    for index in range(count):
        a, b = polygon[index, 1] + origin[1], polygon[index, 2] + origin[2]
        if a == 0.0 and b == 0.0:
            continue
        hue = np.arctan2(b, a)
        if start == np.inf:
            start = hue
        turn = hue - start
        if turn > np.pi:
            turn -= WHOLE_TURN
        elif turn < -np.pi:
            turn += WHOLE_TURN
        low, high = min(low, turn), max(high, turn)
    if start == np.inf:
        return 0.0, 0.0
    if high - low >= np.pi:
        return 0.0, WHOLE_TURN
    return start + low, high - low


MOST_CUSP_SECTORS = 1 << 14

AREA_ROUNDING = 2.0**-49
"""Bound of the rounding error of a projected area ÷ the products of its terms."""


class CuspTable(NamedTuple):
    """The edges that may have cusps, listed by hue."""

    ends: FloatArray  # (m, 6) both ends of each edge
    corners: IndexArray  # (m,) corner that faces the edge: 3 · face + its place in the face
    sector_start: IndexArray  # (sectors + 1,)
    sector_edges: IndexArray  # (k,) the edges of each sector


def cusp_table(vertices: FloatArray, faces: IndexArray, opposite: IndexArray) -> CuspTable:
    """Return the table of cusps of a closed mesh; `opposite` (3 F,) is that of its corner table."""
    return CuspTable(*_cusp_arrays(vertices, faces, opposite))


@kernel
def _cusp_arrays(
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
        one, two = flat[next_corner(corners[edge])], flat[previous_corner(corners[edge])]
        for axis in range(3):
            ends[edge, axis], ends[edge, 3 + axis] = vertices[one, axis], vertices[two, axis]

    sectors = min(max(4, 2 * count), MOST_CUSP_SECTORS)
    start = np.zeros(sectors + 1, np.int32)
    for edge in range(count):
        first, length = _sectors_of_edge(ends, edge, sectors)
        for step in range(length):
            start[(first + step) % sectors + 1] += 1
    for sector in range(sectors):
        start[sector + 1] += start[sector]
    listed = np.empty(start[sectors], np.int32)
    free = start[:-1].copy()
    for edge in range(count):
        first, length = _sectors_of_edge(ends, edge, sectors)
        for step in range(length):
            sector = (first + step) % sectors
            listed[free[sector]] = edge
            free[sector] += 1
    return ends, corners, start, listed


@leaf_kernel
def _upward(vertices: FloatArray, faces: IndexArray, face: int) -> int:
    """Return 1 for a face visible from high lightness, −1 from low lightness; 0 if uncertain."""
    one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
    ua, ub = vertices[two, 1] - vertices[one, 1], vertices[two, 2] - vertices[one, 2]
    va, vb = vertices[three, 1] - vertices[one, 1], vertices[three, 2] - vertices[one, 2]
    area, bound = ua * vb - ub * va, AREA_ROUNDING * (abs(ua * vb) + abs(ub * va))
    return 1 if area > bound else (-1 if area < -bound else 0)


@leaf_kernel
def _sectors_of_edge(ends: FloatArray, edge: int, sectors: int) -> tuple[int, int]:
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
def write_cusp(table: CuspTable, edge: int, share: float, weights: FloatArray, number: int) -> int:
    """Write the barycentric coordinates of a point on an edge to a row; return the face."""
    face, at = divmod(table.corners[edge], 3)
    weights[number, at] = 0.0
    weights[number, (at + 1) % 3], weights[number, (at + 2) % 3] = 1.0 - share, share
    return face


RECTANGLE = 4
"""Numbers of a rectangle: smallest lightness and chroma, largest lightness and chroma."""

SECTORS, MOST_HUE_SECTORS = 4.0, 160
"""Sectors ÷ the square root of the number of faces, and their limit. A face of the full boundary
then is in 1.6 sectors. With more, searches are faster, but the table takes more memory."""

LAST_PART = 255
"""Sectors are divided into 256 parts, which exclude most faces that miss a hue."""

BESIDE = 2.0**-20
"""Corners within this part of a sector beside it count as in it. The position of other corners on
an edge is then certain within `WIDENING`, though the sines of small angles are rounded."""

WIDENING = 2.0**-20
"""Widening of rectangles, relative to the reach of the level and to the coordinate."""

DIRECTIONS = 4096
"""Steps of the order within a sector."""

Rectangle: TypeAlias = tuple[float, float, float, float]


class HueTable(NamedTuple):
    """The faces of each sector of hues, in a tree of rectangles.

    `rectangles` has eight numbers for each side of the rectangles of a node's children. Lightness
    is relative to the centre of the level. Both coordinates are scaled as the tree of faces.
    Rectangles without a child are empty: from ∞ to −∞.
    """

    roots: IndexArray  # (sectors,) first node of each sector; −1 for sectors without faces
    rectangles: Float32Array  # (N, 32)
    first: IndexArray  # (N,) first child, before the others; in leaves ~first is an index of faces
    faces: IndexArray  # (m,)
    spans: ByteArray  # (m, 2) first and last part of the sector that the face meets (`hue_part`)


def hue_table(vertices: FloatArray, faces: IndexArray, middle: float, scale: float) -> HueTable:
    """Return the table of hues of a level, with the centre's lightness and the tree's scale."""
    sectors = min(max(4, round(SECTORS * math.sqrt(len(faces)))), MOST_HUE_SECTORS)
    return HueTable(*_hue_arrays(vertices, faces, middle, scale, sectors))


@leaf_kernel
def _turned(turn: float, sectors: int) -> float:
    """Return a difference of two turns, from 0 to a whole turn."""
    return turn if turn >= 0.0 else turn + sectors


@leaf_kernel
def _sectors_of_face(
    turns: FloatArray, faces: IndexArray, face: int, sectors: int
) -> tuple[int, int]:
    """Return the first sector that a face meets, and the number: all if it may meet the axis."""
    p, q, r = turns[faces[face, 0]], turns[faces[face, 1]], turns[faces[face, 2]]
    if np.isnan(p + q + r):  # a corner on the axis
        return 0, sectors
    begin, length = p, max(_turned(q - p, sectors), _turned(r - p, sectors))
    other = max(_turned(p - q, sectors), _turned(r - q, sectors))
    if other < length:
        begin, length = q, other
    other = max(_turned(p - r, sectors), _turned(q - r, sectors))
    if other < length:
        begin, length = r, other
    first = math.floor(begin - BESIDE)
    count = math.floor(begin + length + BESIDE) - first + 1
    if length >= 0.5 * sectors - BESIDE or count >= sectors:
        return 0, sectors
    return first % sectors, count


@leaf_kernel
def _add_point(rectangle: Rectangle, lightness: float, chroma: float) -> Rectangle:
    low, least, high, most = rectangle
    return min(low, lightness), min(least, chroma), max(high, lightness), max(most, chroma)


@leaf_kernel
def _united(one: Rectangle, two: Rectangle) -> Rectangle:
    return (
        min(one[0], two[0]),
        min(one[1], two[1]),
        max(one[2], two[2]),
        max(one[3], two[3]),
    )


@leaf_kernel
def _add_crossings(
    rectangle: Rectangle,
    vertices: FloatArray,
    faces: IndexArray,
    face: int,
    ca: float,
    cb: float,
) -> Rectangle:
    """Return a rectangle that also holds the crossings of a face's edges with a half-plane."""
    for at in range(3):
        p, q = faces[face, at], faces[face, at - 2]
        side_p = ca * vertices[p, 2] - cb * vertices[p, 1]
        side_q = ca * vertices[q, 2] - cb * vertices[q, 1]
        if (side_p >= 0.0) != (side_q >= 0.0):
            share = side_p / (side_p - side_q)
            along = ca * vertices[p, 1] + cb * vertices[p, 2]
            rectangle = _add_point(
                rectangle,
                vertices[p, 0] + share * (vertices[q, 0] - vertices[p, 0]),
                along + share * (ca * vertices[q, 1] + cb * vertices[q, 2] - along),
            )
    return rectangle


@kernel
def _hue_arrays(
    vertices: FloatArray, faces: IndexArray, middle: float, scale: float, sectors: int
) -> tuple[IndexArray, Float32Array, IndexArray, IndexArray, ByteArray]:
    count = len(faces)
    turns, chromas = np.empty(len(vertices)), np.empty(len(vertices))
    for vertex in range(len(vertices)):
        a, b = vertices[vertex, 1], vertices[vertex, 2]
        chromas[vertex] = np.sqrt(a * a + b * b)
        turns[vertex] = 0.25 * sectors * hue_turn(a, b) if chromas[vertex] > 0.0 else np.nan
    # the hues between the sectors
    ca, cb = np.empty(sectors + 1), np.empty(sectors + 1)
    for edge in range(sectors + 1):
        turn = 4.0 * edge / sectors
        b = turn - 1.0 if turn < 2.0 else 3.0 - turn
        a = (1.0 - abs(b)) * (1.0 if turn < 2.0 else -1.0)
        length = np.sqrt(a * a + b * b)
        ca[edge], cb[edge] = a / length, b / length
    cosines = np.empty(sectors)
    for sector in range(sectors):
        cosine = ca[sector] * ca[sector + 1] + cb[sector] * cb[sector + 1]
        cosines[sector] = np.sqrt(max(0.5 + 0.5 * cosine, 0.0))  # of half the angle

    begins, lengths = np.empty(count, np.int32), np.empty(count, np.int32)
    held = np.zeros(sectors, np.int32)
    for face in range(count):
        begins[face], lengths[face] = _sectors_of_face(turns, faces, face, sectors)
        for sector in range(begins[face], begins[face] + lengths[face]):
            held[sector if sector < sectors else sector - sectors] += 1
    # a tree for each sector: the root, the nodes below it, and so on to the leaves
    roots, leaves = np.full(sectors, -1, np.int32), np.empty(sectors, np.int32)
    places = np.zeros(sectors + 1, np.int32)
    nodes = 0
    for sector in range(sectors):
        places[sector + 1] = places[sector] + held[sector]
        size = bottom = (held[sector] + WIDTH - 1) // WIDTH
        if size > 0:
            roots[sector] = nodes
            nodes += size
        while size > 1:
            size = (size + WIDTH - 1) // WIDTH
            nodes += size
        leaves[sector] = nodes - bottom
    rectangles = np.empty((nodes, RECTANGLE * WIDTH), np.float32)
    rectangles[:, : 2 * WIDTH] = np.inf
    rectangles[:, 2 * WIDTH :] = -np.inf
    first, listed = np.empty(nodes, np.int32), np.empty(places[sectors], np.int32)
    spans = np.empty((places[sectors], 2), np.uint8)
    held[:] = 0
    order = _order_by_direction(vertices, faces, chromas, middle)
    for index in range(count):
        face = order[index]
        _add_face(
            (vertices, faces, turns, chromas),
            (ca, cb, cosines),
            (middle, scale),
            face,
            begins[face],
            lengths[face],
            (places, leaves, held),
            (rectangles, first, listed, spans),
        )
    for sector in range(sectors):
        _add_nodes(leaves[sector], (held[sector] + WIDTH - 1) // WIDTH, rectangles, first)
    return roots, rectangles, first, listed, spans


@kernel
def _order_by_direction(
    vertices: FloatArray, faces: IndexArray, chromas: FloatArray, middle: float
) -> IndexArray:
    """Return an order of faces by the approximate direction from the neutral axis."""
    steps = np.empty(len(faces), np.int32)
    for face in range(len(faces)):
        one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
        up = vertices[one, 0] + vertices[two, 0] + vertices[three, 0] - 3.0 * middle
        out = chromas[one] + chromas[two] + chromas[three]
        slope = up / (abs(up) + out) if out > 0.0 else 0.0
        steps[face] = min(int((0.5 + 0.5 * slope) * DIRECTIONS), DIRECTIONS - 1)
    return grouped(steps, DIRECTIONS)[1]


@leaf_kernel
def _add_face(
    mesh: tuple[FloatArray, IndexArray, FloatArray, FloatArray],
    hues: tuple[FloatArray, FloatArray, FloatArray],
    frame: tuple[float, float],
    face: int,
    begin: int,
    length: int,
    arrays: tuple[IndexArray, IndexArray, IndexArray],
    table: tuple[Float32Array, IndexArray, IndexArray, ByteArray],
) -> None:
    """Add a face to the leaves of all sectors that it meets."""
    vertices, faces, turns, chromas = mesh
    ca, cb, cosines = hues
    middle, scale = frame
    places, leaves, held = arrays
    rectangles, first, listed, spans = table
    sectors = len(leaves)
    everywhere = length == sectors
    nothing = np.inf, np.inf, -np.inf, -np.inf
    before = nothing
    least_turn, most_turn = np.inf, -np.inf
    for at in range(3):
        turn = _turned(turns[faces[face, at]] - begin + BESIDE, sectors) - BESIDE
        least_turn, most_turn = min(least_turn, turn), max(most_turn, turn)
    for step in range(length):
        sector = begin + step if begin + step < sectors else begin + step - sectors
        rectangle, before = before, nothing
        for at in range(3):
            vertex = faces[face, at]
            turn = _turned(turns[vertex] - begin + BESIDE, sectors) - step
            if everywhere or 0.0 <= turn <= 1.0 + 2.0 * BESIDE:
                rectangle = _add_point(rectangle, vertices[vertex, 0], chromas[vertex])
        if step + 1 < length and not everywhere:
            before = _add_crossings(nothing, vertices, faces, face, ca[sector + 1], cb[sector + 1])
            rectangle = _united(rectangle, before)
        # a chord has a smaller chroma than its ends
        shrunk = 0.0 if everywhere else cosines[sector]
        low, least, high, most = rectangle
        place = held[sector]
        held[sector] += 1
        node, at = leaves[sector] + place // WIDTH, place % WIDTH
        first[node] = ~(places[sector] + place - at)
        rectangles[node, at] = _widened(scale * (low - middle), -1.0)
        rectangles[node, WIDTH + at] = _widened(scale * least * shrunk, -1.0)
        rectangles[node, 2 * WIDTH + at] = _widened(scale * (high - middle), 1.0)
        rectangles[node, 3 * WIDTH + at] = _widened(scale * most, 1.0)
        place += places[sector]
        listed[place] = face
        spans[place, 0] = 0 if everywhere else hue_part(least_turn - step - BESIDE)
        spans[place, 1] = LAST_PART if everywhere else hue_part(most_turn - step + BESIDE)


@leaf_kernel
def hue_part(turn: float) -> int:
    """Return the part of a sector of a number between 0 and 1; other numbers are clamped."""
    return int(min(max(turn, 0.0) * (LAST_PART + 1), float(LAST_PART)))


@leaf_kernel
def _add_nodes(start: int, size: int, rectangles: Float32Array, first: IndexArray) -> None:
    """Set the nodes above the leaves of a sector that begins at `start`."""
    while size > 1:
        below, below_start = size, start
        size = (size + WIDTH - 1) // WIDTH
        start -= size
        for each in range(below):
            node, at, child = start + each // WIDTH, each % WIDTH, below_start + each
            first[node] = child - at
            for side in range(2):
                low, high = np.float32(np.inf), np.float32(-np.inf)
                for part in range(WIDTH):
                    low = min(low, rectangles[child, side * WIDTH + part])
                    high = max(high, rectangles[child, (2 + side) * WIDTH + part])
                rectangles[node, side * WIDTH + at] = low
                rectangles[node, (2 + side) * WIDTH + at] = high


@leaf_kernel
def _widened(value: float, sign: float) -> np.float32:
    return np.float32(value + sign * WIDENING * (1.0 + abs(value)))
