"""Volumes of one gamut or two by hue and lightness: comparison and gamut rings.

The vector field F = (0, a / 2, b / 2) has the divergence 1. By the divergence theorem, its flux out
of a closed surface is the volume inside. F is parallel to every plane of constant hue and to every
plane of constant lightness. The volume of a cell between such planes therefore flows through its
part of the surface alone. The pieces are clipped, and no caps are needed. Polygons are rows of
corners in counter-clockwise order from outside, relative to an origin; the coordinates are
lightness, a and b.

The surface of the intersection of A and B is the part of A's surface inside B and the part of B's
surface inside A. Each level may have its own centre. Surfaces that coincide have no side. B is
therefore magnified by `STRETCH` about its centre, so that a surface which both gamuts share counts
as A's alone.

A level is the disjoint union of tetrahedra between its centre and its faces. The part of a triangle
in a tetrahedron is a convex polygon: the triangle clipped by the three planes of the face's cone
and by the plane of the face. No intersection curve is traced, and no topology is needed. The cones
that a triangle meets are adjacent. The search starts in the cone of one corner, and passes to
neighbours across the planes that the triangle reaches. The areas of the parts must add up to that
of the triangle. Otherwise rounding has hidden a cone, and all others are tried.

Gamut rings draw the volume by hue and lightness in a plane. The ring of the lightness L* is a
closed curve around the neutral axis. In each sector of hue, the area within the ring is the volume
of the gamut in this sector from the darkest colour up to L*:

    r(L*, h)² Δh / 2 = V(L*, h),   so   r(L*, h) = √(2 V(L*, h) / Δh),

with the width Δh of the sector in radians. The outer ring therefore encloses an area as large as
the volume of the gamut. The radius is the root of the sum of squared chromas over unit steps of
lightness, hence the names a*_RSS and b*_RSS of the axes. With a reference, the band between the
rings of L₁ and L₂ is divided. The intersection of both gamuts, V∩, takes its area from the inner
ring on:

    r∩(L₂, h)² = r(L₁, h)² + 2 (V∩(L₂, h) − V∩(L₁, h)) / Δh.

Source of the rings: K. Masaoka, F. Jiang, M. D. Fairchild and R. L. Heckaman, "2D representation of
display color gamut", SID Digest 49 (2018); E. Smith et al., "Measuring the color capability of
modern display systems", Journal of the SID 28 (2020); Information Display Measurements Standard
1.1, section 5.32. The division by the intersection is that of their program, gamut-volume-m.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.errors import InvalidPointsError, OptionError
from gamutcore.geometry import (
    Vector,
    cell_of,
    clip,
    cone_products,
    cross,
    dot,
    minus,
    opposite_corners,
    plus,
    row,
    scaled,
    write_row,
)
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.results import Comparison, GamutRings, Overlap
from gamutcore.search.hue_tables import WHOLE_TURN, hue_span
from gamutcore.search.index import Level, LevelIndex, as_index, checked_numbers

__all__ = [
    "MOST_SECTORS",
    "RING_LIGHTNESSES",
    "compare",
    "gamut_rings",
]

MOST_SECTORS = 3600
"""Largest number of sectors: tenths of a degree."""


def compare(level_a: Level, level_b: Level, sectors: int = 36) -> Comparison:
    """Compare two gamuts in the same colour space.

    Parameters
    ----------
    level_a, level_b : LevelIndex or (vertices, faces, centre)
        The centres may differ.
    sectors : int, optional
        Number of equal sectors of hue, the angle of the second and third coordinate, from 1 to
        `MOST_SECTORS`. The first sector begins at 0°.

    Returns
    -------
    Comparison
        Exact to about 10⁻¹⁰ of the volumes.

    Raises
    ------
    OptionError
        The number of sectors is not accepted.

    Notes
    -----
    Exchanging the levels changes the intersection by rounding errors and by the effect of
    `STRETCH`.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> faces, centre = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], np.full(3, 0.1)
    >>> comparison = compare((corners, faces, centre), (corners / 2, faces, centre))
    >>> round(comparison.a_covers_b, 9), round(comparison.b_covers_a, 9)
    (1.0, 0.125)
    """
    count = _checked_sectors(sectors)
    cells = _cells_of(count, np.empty(0))
    by_hue = [volumes[0] for volumes in _cell_volumes(as_index(level_a), as_index(level_b), cells)]
    totals = [float(volumes.sum()) for volumes in by_hue]
    hues = np.linspace(0.0, 360.0, count + 1)
    return Comparison(totals[0], totals[1], totals[2], hues, Overlap[FloatArray](*by_hue))


def _checked_sectors(sectors: int) -> int:
    """Return the number of sectors; OptionError unless it is whole, from 1 to `MOST_SECTORS`."""
    if isinstance(sectors, bool) or not 1 <= sectors <= MOST_SECTORS or sectors != int(sectors):
        raise OptionError.refusal("sectors", sectors, f"a whole number from 1 to {MOST_SECTORS}")
    return int(sectors)


RING_LIGHTNESSES = tuple(range(10, 101, 10))
"""Lightnesses of the rings in the standard, which is for CIELAB."""


def gamut_rings(
    level: Level,
    reference: Level | None = None,
    lightness: ArrayLike = RING_LIGHTNESSES,
    sectors: int = 360,
) -> GamutRings:
    """Return the gamut rings of a level, alone or compared with a reference.

    Parameters
    ----------
    level : LevelIndex or (vertices, faces, centre)
    reference : LevelIndex or (vertices, faces, centre), optional
        In the same colour space.
    lightness : (n,) array_like, optional
        Of the rings, in increasing order. Colours lighter than the last are in no ring.
    sectors : int, optional
        Number of equal sectors of hue, from 1 to `MOST_SECTORS`.

    Returns
    -------
    GamutRings
        Exact for the level except for rounding: no lines of sight are sampled.

    Raises
    ------
    InvalidPointsError
        The lightnesses are not increasing numbers; ``where["row"]`` names the first that is not.
    OptionError
        The number of sectors is not accepted.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> round(6 * gamut_rings(tetrahedron).volume, 9)
    1.0
    """
    bounds = checked_numbers(lightness, "lightness")
    falls = np.flatnonzero(np.diff(bounds) <= 0.0) + 1
    if len(bounds) == 0 or len(falls):
        row = int(falls[0]) if len(falls) else 0
        raise InvalidPointsError(
            f"Row {row} of lightness is not larger than the one before."
            if len(falls)
            else "There is no lightness.",
            where={"field": "lightness", "row": row},
            remedy="Give one or more numbers in increasing order.",
        )
    count = _checked_sectors(sectors)
    width = 2.0 * np.pi / count
    cells = _cells_of(count, bounds)
    index = as_index(level)
    hues = (np.arange(count) + 0.5) * 360.0 / count
    if reference is None:
        bands = _squares(_enclosed_cells(index.vertices, index.faces, cells), width)
        squares = bands.cumsum(axis=0)
        return GamutRings(bounds, hues, np.sqrt(squares), float(squares[-1].sum() * width / 2.0))
    cell_volumes = _cell_volumes(index, as_index(reference), cells)
    bands, of_reference, common = (_squares(volumes, width) for volumes in cell_volumes)
    squares = bands.cumsum(axis=0)
    inner = squares - bands
    return GamutRings(
        bounds,
        hues,
        np.sqrt(squares),
        float(squares[-1].sum() * width / 2.0),
        np.sqrt(of_reference.cumsum(axis=0)),
        np.sqrt(inner + common),
    )


def _squares(volumes: FloatArray, width: float) -> FloatArray:
    """Return the differences of squared radii for the volumes of bands, without the last band."""
    return np.maximum(volumes[:-1], 0.0) * (2.0 / width)


STRETCH = 1.0 + 2.0**-36
"""Magnification of the second level. It separates shared surfaces by 10⁻⁹ units in CIELAB, ten
thousand times the rounding errors. Volumes change by less than 5 × 10⁻¹¹ of the second volume."""


def _cell_volumes(
    one: LevelIndex, other: LevelIndex, cells: _Cells
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the volumes of two levels and of their intersection in cells, (bands, sectors)."""
    stretched = other.centre + STRETCH * (other.vertices - other.centre)
    common = _overlap_cells(one.vertices, one.faces, other, _neighbours(other), STRETCH, cells)
    common += _overlap_cells(stretched, other.faces, one, _neighbours(one), 1.0, cells)
    a = _enclosed_cells(one.vertices, one.faces, cells)
    b = _enclosed_cells(other.vertices, other.faces, cells)
    return a, b, np.clip(common, 0.0, np.minimum(a, b))


def _neighbours(level: LevelIndex) -> IndexArray:
    """Return the face across the edge opposite to each corner of each face, (F, 3)."""
    return opposite_corners(level.faces, len(level.vertices)).reshape(-1, 3) // np.int32(3)


CORNERS = 24
"""Most corners of a polygon: a triangle gets one more from each of at most eight planes."""

UPWARDS, DOWNWARDS = (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)
"""Directions along the axis of lightness."""

BUFFERS = 9
"""Number of work polygons. The first five are free for the caller of `_add_polygon`."""


class _Cells(NamedTuple):
    """Planes that divide a colour space into sectors of hue and bands of lightness."""

    # (sectors + 1, 2) cosine and sine of the hues between the sectors; the last repeats the first
    directions: FloatArray
    bounds: FloatArray  # (bands − 1,) lightnesses between the bands, in increasing order


def _cells_of(sectors: int, bounds: FloatArray) -> _Cells:
    """Return equal sectors of hue from 0°, and bands between lightnesses (bands − 1,)."""
    hues = WHOLE_TURN * np.arange(sectors + 1) / sectors
    return _Cells(np.column_stack([np.cos(hues), np.sin(hues)]), bounds)


@kernel
def _enclosed_cells(vertices: FloatArray, faces: IndexArray, cells: _Cells) -> FloatArray:
    """Return the volume within a closed surface in each cell, (bands, sectors)."""
    volumes = np.zeros((len(cells.bounds) + 1, len(cells.directions) - 1))
    buffers, origin = np.empty((BUFFERS, CORNERS, 3)), np.zeros(3)
    for face in range(len(faces)):
        for corner in range(3):
            write_row(buffers[0], corner, 0, row(vertices, faces[face, corner], 0))
        _add_polygon(buffers[0], 3, origin, cells, buffers, volumes)
    return volumes


@leaf_kernel
def _add_polygon(
    polygon: FloatArray,
    count: int,
    origin: FloatArray,
    cells: _Cells,
    buffers: FloatArray,
    volumes: FloatArray,
) -> None:
    """Add the flux through a convex polygon to the cells that it meets, `volumes` (bands, sectors).

    The polygon (`CORNERS`, 3) is relative to `origin`. The last four of `buffers` (`BUFFERS`,
    `CORNERS`, 3) are overwritten.
    """
    if count < 3:
        return
    bounds, directions = cells.bounds, cells.directions
    sectors = len(directions) - 1
    first_band = last_band = 0
    if len(bounds) > 0:
        low = high = polygon[0, 0]
        for index in range(1, count):
            low, high = min(low, polygon[index, 0]), max(high, polygon[index, 0])
        first_band = np.searchsorted(bounds, low + origin[0])
        last_band = np.searchsorted(bounds, high + origin[0])
    first = last = 0
    if sectors > 1:
        begin, span = hue_span(polygon, count, origin)
        scale = sectors / WHOLE_TURN
        first = int(np.floor(begin * scale))
        # a whole turn ends where it begins
        last = min(int(np.floor((begin + span) * scale)), first + sectors - 1)
    if first == last and first_band == last_band:
        volumes[first_band, first % sectors] += _flux(polygon, count, origin)
        return
    wedge = polygon
    for turn in range(first, last + 1):
        sector = turn % sectors
        corners = count
        if first < last:
            a, b = directions[sector, 0], directions[sector, 1]
            constant = a * origin[2] - b * origin[1]
            corners = clip(polygon, count, (0.0, -b, a), constant, buffers[5])
            a, b = directions[sector + 1, 0], directions[sector + 1, 1]
            constant = b * origin[1] - a * origin[2]
            corners = clip(buffers[5], corners, (0.0, b, -a), constant, buffers[6])
            wedge = buffers[6]
        for band in range(first_band, last_band + 1):
            part, rest = wedge, corners
            if band > first_band:
                rest = clip(part, rest, UPWARDS, origin[0] - bounds[band - 1], buffers[7])
                part = buffers[7]
            if band < last_band:
                rest = clip(part, rest, DOWNWARDS, bounds[band] - origin[0], buffers[8])
                part = buffers[8]
            volumes[band, sector] += _flux(part, rest, origin)


@leaf_kernel
def _flux(polygon: FloatArray, count: int, origin: FloatArray) -> float:
    """Return the flux of F through a polygon."""
    first = row(polygon, 0, 0)
    _, y, z = first
    total = 0.0
    for index in range(1, count - 1):
        u = minus(row(polygon, index, 0), first)
        v = minus(row(polygon, index + 1, 0), first)
        # the mean of F over a triangle is that of its corners; the vector area is u × v ÷ 2
        _, across, along = cross(u, v)
        total += across * (3.0 * (y + origin[1]) + u[1] + v[1])
        total += along * (3.0 * (z + origin[2]) + u[2] + v[2])
    return total / 12.0


NEAR = 8.0
"""A triangle reaches a plane if a product is at most this. Rounding changes products of the index
by less than 1, and cut corners are rounded once more."""

MISSING = 1e-10
"""Accepted part of a triangle's area that is in no cone."""

FLAT = 1e-14
"""Parts up to this area ÷ square of the triangle's size are ignored."""


@kernel
def _overlap_cells(
    vertices: FloatArray,
    faces: IndexArray,
    level: LevelIndex,
    neighbours: IndexArray,
    stretch: float,
    cells: _Cells,
) -> FloatArray:
    """Return the flux (bands, sectors) out of a surface through its part inside a level.

    `neighbours` (G, 3) has the face across the edge opposite to each corner of the level. `stretch`
    magnifies the level about its centre.
    """
    volumes = np.zeros((len(cells.bounds) + 1, len(cells.directions) - 1))
    buffers = np.empty((BUFFERS, CORNERS, 3))
    triangle, centre, box = buffers[0], level.centre, level.box
    seen = np.full(len(level.faces), -1, np.int32)
    queue = np.empty(len(level.faces), np.int32)
    reach = 0.0
    for axis in range(3):
        reach += max(abs(box[0, axis] - centre[axis]), abs(box[1, axis] - centre[axis])) ** 2
    for face in range(len(faces)):
        farthest, largest = _set_triangle(vertices, faces, face, level, stretch, triangle)
        if farthest < 0:
            continue
        if largest < level.inner * level.inner:
            _add_polygon(triangle, 3, centre, cells, buffers, volumes)
            continue
        axis, area, size = _projection(triangle)
        near, least = NEAR * max(1.0, np.sqrt(largest / reach)), FLAT * size[1]
        # an inner point, as corners often lie between cones; the weights keep it off the centre
        one, two, three = farthest, (farthest + 1) % 3, (farthest + 2) % 3
        inner = plus(scaled(0.6, row(triangle, one, 0)), scaled(0.25, row(triangle, two, 0)))
        start = _face_towards(plus(inner, scaled(0.15, row(triangle, three, 0))), level)
        seen[start], queue[0], waiting, done = face, start, 1, 0
        while done < waiting:
            part, reached = _part(
                queue[done], level, near, least, stretch, cells, buffers, axis, volumes
            )
            area -= part
            for side in range(3):
                beside = neighbours[queue[done], side]
                if reached & (1 << side) and seen[beside] != face:
                    seen[beside] = face
                    queue[waiting] = beside
                    waiting += 1
            done += 1
        if abs(area) > MISSING * size[0] + 10.0 * least:
            for other in range(len(level.faces)):
                if seen[other] != face:
                    _part(other, level, near, least, stretch, cells, buffers, axis, volumes)
    return volumes


@leaf_kernel
def _set_triangle(
    vertices: FloatArray,
    faces: IndexArray,
    face: int,
    level: LevelIndex,
    stretch: float,
    triangle: FloatArray,
) -> tuple[int, float]:
    """Set a triangle's corners relative to the level's centre; return the farthest, and its square.

    The corner is −1 if the triangle is outside the box of the level.
    """
    centre, box = level.centre, level.box
    outside = False
    for axis in range(3):
        low, high = np.inf, -np.inf
        for corner in range(3):
            value = vertices[faces[face, corner], axis] - centre[axis]
            triangle[corner, axis] = value
            low, high = min(low, value), max(high, value)
        below, above = box[0, axis] - centre[axis], box[1, axis] - centre[axis]
        outside = outside or high < stretch * below or low > stretch * above
    if outside:
        return -1, 0.0
    farthest, largest = 0, -1.0
    for corner in range(3):
        square = dot(row(triangle, corner, 0), row(triangle, corner, 0))
        if square > largest:
            farthest, largest = corner, square
    return farthest, largest


@leaf_kernel
def _projection(triangle: FloatArray) -> tuple[int, float, tuple[float, float]]:
    """Return the axis of a triangle's largest projection, and twice its signed area.

    The third result is the magnitude of the area, and the square of the triangle's size.
    """
    axis, area, size = 0, 0.0, 0.0
    for candidate in range(3):
        doubled_area = _doubled_area(triangle, 3, candidate)
        if abs(doubled_area) > abs(area):
            axis, area = candidate, doubled_area
        edge = max(
            abs(triangle[1, candidate] - triangle[0, candidate]),
            abs(triangle[2, candidate] - triangle[0, candidate]),
        )
        size = max(size, edge * edge)
    return axis, area, (abs(area), size)


@leaf_kernel
def _doubled_area(polygon: FloatArray, count: int, axis: int) -> float:
    """Return twice the signed area of a polygon's projection along an axis."""
    second, third = (axis + 1) % 3, (axis + 2) % 3
    y, z = polygon[0, second], polygon[0, third]
    total = 0.0
    for index in range(1, count - 1):
        total += (polygon[index, second] - y) * (polygon[index + 1, third] - z)
        total -= (polygon[index, third] - z) * (polygon[index + 1, second] - y)
    return total


@leaf_kernel
def _face_towards(point: Vector, level: LevelIndex) -> int:
    """Return the face whose cone a point relative to the centre is in, up to rounding."""
    cell = cell_of(point, level.resolution)
    nearest_face, best = 0, -np.inf
    for place in range(level.cell_start[cell], level.cell_start[cell + 1]):
        face = level.cell_faces[place]
        least = min(cone_products(level.planes, face, point))
        if least > best:
            nearest_face, best = face, least
    return nearest_face


@leaf_kernel
def _part(  # noqa: C901, PLR0912  # the time is in these branches
    face: int,
    level: LevelIndex,
    near: float,
    least: float,
    stretch: float,
    cells: _Cells,
    buffers: FloatArray,
    axis: int,
    volumes: FloatArray,
) -> tuple[float, int]:
    """Add the flux through a triangle's part below a face; return area and planes reached.

    The area is twice that of the projection along `axis` of the triangle in the cone. Bit i of the
    second result is set if the triangle reaches the plane opposite to corner i: a product is at
    most `near`. Parts up to the area `least` are skipped. They only touch the cone, and many cones
    may meet in a vertex. The first of `buffers` is the triangle, relative to the centre of the
    level.
    """
    planes, triangle = level.planes, buffers[0]
    cut = 0
    for side in range(3):
        plane, low, high = row(planes, face, 3 * side), np.inf, -np.inf
        for corner in range(3):
            value = dot(plane, row(triangle, corner, 0))
            low, high = min(low, value), max(high, value)
        if high < -near:
            return 0.0, 0
        if high <= near and low >= -near:
            # in the plane: the part belongs to the cone on one side of it
            if level.faces[face, (side + 1) % 3] > level.faces[face, (side + 2) % 3]:
                return 0.0, 7
            cut |= 8
        elif low < 0.0:
            cut |= 1 << side
    polygon, count = triangle, 3
    for side in range(3):
        if cut & (1 << side):
            target = buffers[1 + side]
            count = clip(polygon, count, row(planes, face, 3 * side), 0.0, target)
            polygon = target
    area = _doubled_area(polygon, count, axis) if count >= 3 else 0.0
    reached = 7 if cut & 8 else 0
    if abs(area) <= least:
        return 0.0, reached
    for side in range(3):
        plane = row(planes, face, 3 * side)
        for index in range(count):
            if dot(plane, row(polygon, index, 0)) <= near:
                reached |= 1 << side
    plane = row(planes, face, 9)
    offset = stretch * planes[face, 12]
    low, high = np.inf, -np.inf
    for index in range(count):
        value = offset - dot(plane, row(polygon, index, 0))
        low, high = min(low, value), max(high, value)
    if low >= 0.0:
        _add_polygon(polygon, count, level.centre, cells, buffers, volumes)
    elif high > 0.0:
        below = clip(polygon, count, scaled(-1.0, plane), offset, buffers[4])
        _add_polygon(buffers[4], below, level.centre, cells, buffers, volumes)
    return area, reached
