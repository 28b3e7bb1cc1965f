"""The part of a surface that is inside a level, cell by cell of hue and lightness.

A level is the disjoint union of tetrahedra between its centre and its faces. The part of a triangle
in a tetrahedron is a convex polygon: the triangle clipped by the three planes of the face's cone
and by the plane of the face. No intersection curve is traced, and no topology is needed.

The cones that a triangle meets are adjacent. The search starts in the cone of one corner, and
passes to neighbours across the planes that the triangle reaches. The areas of the parts must add up
to that of the triangle. Otherwise rounding has hidden a cone, and all others are tried.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.queries.directions import cell_of
from gamutcore.queries.index import LevelIndex
from gamutcore.queries.volume_cells import BUFFERS, CORNERS, Cells, add_polygon, clip

__all__ = ["overlap_cells"]

NEAR = 8.0
"""A triangle reaches a plane if a product is at most this. Rounding changes products of the index
by less than 1, and cut corners are rounded once more."""

MISSING = 1e-10
"""Accepted part of a triangle's area that is in no cone."""

FLAT = 1e-14
"""Parts up to this area ÷ square of the triangle's size are ignored."""


@kernel
def overlap_cells(
    vertices: FloatArray,
    faces: IndexArray,
    level: LevelIndex,
    neighbours: IndexArray,
    stretch: float,
    cells: Cells,
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
            add_polygon(triangle, 3, centre, cells, buffers, volumes)
            continue
        axis, area, size = _projection(triangle)
        near, least = NEAR * max(1.0, np.sqrt(largest / reach)), FLAT * size[1]
        # an inner point, as corners often lie between cones; the weights keep it off the centre
        one, two, three = farthest, (farthest + 1) % 3, (farthest + 2) % 3
        start = _face_towards(
            0.6 * triangle[one, 0] + 0.25 * triangle[two, 0] + 0.15 * triangle[three, 0],
            0.6 * triangle[one, 1] + 0.25 * triangle[two, 1] + 0.15 * triangle[three, 1],
            0.6 * triangle[one, 2] + 0.25 * triangle[two, 2] + 0.15 * triangle[three, 2],
            level,
        )
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
        x, y, z = triangle[corner, 0], triangle[corner, 1], triangle[corner, 2]
        square = x * x + y * y + z * z
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
        found = _doubled_area(triangle, 3, candidate)
        if abs(found) > abs(area):
            axis, area = candidate, found
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
def _face_towards(x: float, y: float, z: float, level: LevelIndex) -> int:
    """Return the face whose cone a point relative to the centre is in, up to rounding."""
    planes = level.planes
    cell = cell_of(x, y, z, level.resolution)
    found, best = 0, -np.inf
    for place in range(level.cell_start[cell], level.cell_start[cell + 1]):
        face = level.cell_faces[place]
        least = min(
            planes[face, 0] * x + planes[face, 1] * y + planes[face, 2] * z,
            planes[face, 3] * x + planes[face, 4] * y + planes[face, 5] * z,
            planes[face, 6] * x + planes[face, 7] * y + planes[face, 8] * z,
        )
        if least > best:
            found, best = face, least
    return found


@leaf_kernel
def _part(  # noqa: C901, PLR0912  # the time is in these branches
    face: int,
    level: LevelIndex,
    near: float,
    least: float,
    stretch: float,
    cells: Cells,
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
        x, y, z = planes[face, 3 * side], planes[face, 3 * side + 1], planes[face, 3 * side + 2]
        low, high = np.inf, -np.inf
        for corner in range(3):
            value = x * triangle[corner, 0] + y * triangle[corner, 1] + z * triangle[corner, 2]
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
            x, y, z = planes[face, 3 * side], planes[face, 3 * side + 1], planes[face, 3 * side + 2]
            target = buffers[1 + side]
            count = clip(polygon, count, x, y, z, 0.0, target)
            polygon = target
    area = _doubled_area(polygon, count, axis) if count >= 3 else 0.0
    reached = 7 if cut & 8 else 0
    if abs(area) <= least:
        return 0.0, reached
    for side in range(3):
        x, y, z = planes[face, 3 * side], planes[face, 3 * side + 1], planes[face, 3 * side + 2]
        for index in range(count):
            if x * polygon[index, 0] + y * polygon[index, 1] + z * polygon[index, 2] <= near:
                reached |= 1 << side
    x, y, z = planes[face, 9], planes[face, 10], planes[face, 11]
    offset = stretch * planes[face, 12]
    low, high = np.inf, -np.inf
    for index in range(count):
        value = offset - x * polygon[index, 0] - y * polygon[index, 1] - z * polygon[index, 2]
        low, high = min(low, value), max(high, value)
    if low >= 0.0:
        add_polygon(polygon, count, level.centre, cells, buffers, volumes)
    elif high > 0.0:
        below = clip(polygon, count, -x, -y, -z, offset, buffers[4])
        add_polygon(buffers[4], below, level.centre, cells, buffers, volumes)
    return area, reached
