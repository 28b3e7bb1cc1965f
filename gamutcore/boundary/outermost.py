"""Which points of crossing triangles are outermost, and where edges pass through triangles.

The directions from the centre are divided into cells: a grid on each face of a cube around the
centre. A cell lists the triangles that rays through it may meet. A central projection maps
triangles to triangles, so the bounding box of the projected corners covers all of these cells.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import BooleanArray, FloatArray, IndexArray, LongArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["Crossings", "Sheets", "arrange", "edge_crossings", "is_hidden"]

TRIANGLES_PER_CELL = 2
"""Mean number of triangles that begin in a cell. Measured: 1 and 4 are slower."""

MOST_CELLS = 400
"""Largest number of cells along a side of the cube."""

STEEP = 1e-3
"""Smallest distance of a corner from the plane through the centre that is parallel to a side of
the cube, as a share of its radius, for the projection on this side."""

RIM = 1e-12
"""Distance from a triangle, as a share of the largest possible, that counts as within it."""


class Sheets(NamedTuple):
    """Triangles around the centre, sorted into cells.

    Attributes
    ----------
    position : (n, 3) float64
        Relative to the centre.
    corner : (m, 3) int32
        Counter-clockwise, seen from outside.
    plane : (m, 5) float64
        Unit normal, distance of the plane from the centre, and largest radius of a corner.
    cells : int
        Number of cells along a side of the cube.
    start : (6 cells² + 1,) int64
        First entry of each cell in `listed`.
    listed : (k,) int32
        Triangles of the cells.
    tolerance : float
        Radial distance that does not hide a point.
    """

    position: FloatArray
    corner: IndexArray
    plane: FloatArray
    cells: int
    start: LongArray
    listed: IndexArray
    tolerance: float


class Crossings(NamedTuple):
    """Points at which edges pass through triangles.

    Attributes
    ----------
    edge, triangle : (k,) int32
    share : (k,) float64
        Position along the edge, 0 to 1.
    """

    edge: IndexArray
    triangle: IndexArray
    share: FloatArray


@leaf_kernel
def _project(
    position: FloatArray, one: int, two: int, three: int, side: int, cells: int, box: LongArray
) -> bool:
    """Write the range of cells of a triangle on a side of the cube; return whether there is any."""
    axis, sign = side // 2, 1.0 - 2.0 * (side % 2)
    low_u, low_v, high_u, high_v = np.inf, np.inf, -np.inf, -np.inf
    beyond_0, beyond_1, beyond_2, beyond_3, behind, flat = True, True, True, True, True, False
    for corner in range(3):
        vertex = one if corner == 0 else (two if corner == 1 else three)
        w = sign * position[vertex, axis]
        u, v = position[vertex, (axis + 1) % 3], position[vertex, (axis + 2) % 3]
        beyond_0, beyond_1 = beyond_0 and u > w, beyond_1 and -u > w
        beyond_2, beyond_3 = beyond_2 and v > w, beyond_3 and -v > w
        behind = behind and w <= 0.0
        flat = flat or w <= STEEP * (abs(u) + abs(v) + abs(w))
        if not flat:
            low_u, high_u = min(low_u, u / w), max(high_u, u / w)
            low_v, high_v = min(low_v, v / w), max(high_v, v / w)
    if behind or beyond_0 or beyond_1 or beyond_2 or beyond_3:
        return False
    if flat:  # a triangle of a wide angle
        low_u, low_v, high_u, high_v = -1.0, -1.0, 1.0, 1.0
    box[0], box[1] = _cell(low_u, cells), _cell(high_u, cells)
    box[2], box[3] = _cell(low_v, cells), _cell(high_v, cells)
    return True


@leaf_kernel
def _cell(value: float, cells: int) -> int:
    """Return the row or column of a projected coordinate."""
    scaled = (min(max(value, -1.0), 1.0) + 1.0) * 0.5 * cells
    return min(int(scaled), cells - 1)


@leaf_kernel
def _side_of(x: float, y: float, z: float) -> int:
    """Return the side of the cube that a direction meets."""
    if abs(x) >= abs(y) and abs(x) >= abs(z):
        return 0 if x > 0 else 1
    if abs(y) >= abs(z):
        return 2 if y > 0 else 3
    return 4 if z > 0 else 5


@leaf_kernel
def _sides_of(position: FloatArray, one: int, two: int, three: int) -> tuple[int, int]:
    """Return the range of sides of the cube that a triangle may meet: one, or all six."""
    first = _side_of(position[one, 0], position[one, 1], position[one, 2])
    second = _side_of(position[two, 0], position[two, 1], position[two, 2])
    third = _side_of(position[three, 0], position[three, 1], position[three, 2])
    return (first, first + 1) if first == second == third else (0, 6)


@leaf_kernel
def _cell_of(x: float, y: float, z: float, cells: int) -> int:
    """Return the cell of a direction."""
    side = _side_of(x, y, z)
    if side < 2:
        u, v, w = y, z, abs(x)
    elif side < 4:
        u, v, w = z, x, abs(y)
    else:
        u, v, w = x, y, abs(z)
    return (side * cells + _cell(u / w, cells)) * cells + _cell(v / w, cells)


@leaf_kernel
def _set_planes(position: FloatArray, corner: IndexArray, plane: FloatArray) -> None:
    """Turn triangles outwards, and write their planes; 0 for those seen on edge."""
    for face in range(len(corner)):
        one, two, three = corner[face, 0], corner[face, 1], corner[face, 2]
        ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
        ux, uy, uz = position[two, 0] - ax, position[two, 1] - ay, position[two, 2] - az
        vx, vy, vz = position[three, 0] - ax, position[three, 1] - ay, position[three, 2] - az
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(x * x + y * y + z * z)
        distance = ax * x + ay * y + az * z
        if distance < 0.0:
            corner[face, 1], corner[face, 2] = three, two
            length = -length
        reach = 0.0
        for index in range(3):
            vertex = corner[face, index]
            px, py, pz = position[vertex, 0], position[vertex, 1], position[vertex, 2]
            reach = max(reach, px * px + py * py + pz * pz)
        reach = np.sqrt(reach)
        if abs(distance) > RIM * abs(length) * reach:
            plane[face, 0], plane[face, 1], plane[face, 2] = x / length, y / length, z / length
            plane[face, 3], plane[face, 4] = distance / length, reach


@kernel
def arrange(position: FloatArray, corner: IndexArray, tolerance: float) -> Sheets:
    """Turn triangles outwards and sort them into cells; positions are relative to the centre.

    Triangles seen from the centre on edge, or with a corner there, hide nothing.
    """
    count = len(corner)
    cells = min(max(int(np.sqrt(count / (6.0 * TRIANGLES_PER_CELL))), 4), MOST_CELLS)
    turned, plane = corner.copy(), np.zeros((count, 5))
    _set_planes(position, turned, plane)
    start = np.zeros(6 * cells * cells + 1, np.int64)
    box = np.empty(4, np.int64)
    listed = np.empty(0, np.int32)
    for fill in range(2):
        for face in range(count):
            if plane[face, 4] == 0.0:
                continue
            one, two, three = corner[face, 0], corner[face, 1], corner[face, 2]
            first, last = _sides_of(position, one, two, three)
            for side in range(first, last):
                if _project(position, one, two, three, side, cells, box):
                    for u in range(box[0], box[1] + 1):
                        for v in range(box[2], box[3] + 1):
                            cell = (side * cells + u) * cells + v
                            if fill:
                                start[cell] -= 1
                                listed[start[cell]] = face
                            else:
                                start[cell] += 1
        if not fill:
            for cell in range(len(start) - 1):
                start[cell + 1] += start[cell]
            listed = np.empty(start[-1], np.int32)
    return Sheets(position, turned, plane, cells, start, listed, tolerance)


@leaf_kernel
def _is_within(sheets: Sheets, face: int, x: float, y: float, z: float) -> bool:
    """Whether the ray through a point meets a triangle."""
    position, corner = sheets.position, sheets.corner
    radius = np.sqrt(x * x + y * y + z * z)
    for index in range(3):
        one, two = corner[face, index], corner[face, (index + 1) % 3]
        ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
        bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
        side = x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)
        if side < -RIM * radius * sheets.plane[face, 4] * sheets.plane[face, 4]:
            return False
    return True


@leaf_kernel
def _point_is_hidden(sheets: Sheets, x: float, y: float, z: float) -> bool:
    """Whether a triangle is further out than a point, on the same ray."""
    plane, radius = sheets.plane, np.sqrt(x * x + y * y + z * z)
    if radius == 0.0:
        return True
    cell = _cell_of(x, y, z, sheets.cells)
    for entry in range(sheets.start[cell], sheets.start[cell + 1]):
        face = sheets.listed[entry]
        if plane[face, 4] <= radius + sheets.tolerance:
            continue
        slope = plane[face, 0] * x + plane[face, 1] * y + plane[face, 2] * z
        # further out than the point: distance ÷ slope > 1 + tolerance ÷ radius
        if (
            slope > 0.0
            and plane[face, 3] * radius > slope * (radius + sheets.tolerance)
            and _is_within(sheets, face, x, y, z)
        ):
            return True
    return False


@kernel
def is_hidden(sheets: Sheets, points: FloatArray) -> BooleanArray:
    """Return whether each point is nearer to the centre than a triangle on the same ray.

    Points are relative to the centre.
    """
    hidden = np.empty(len(points), np.bool_)
    for index in range(len(points)):
        hidden[index] = _point_is_hidden(
            sheets, points[index, 0], points[index, 1], points[index, 2]
        )
    return hidden


@kernel
def edge_crossings(sheets: Sheets, edges: IndexArray, room: int) -> tuple[int, Crossings]:
    """Return the number of crossings of edges and triangles, and the first `room` crossings."""
    position, plane = sheets.position, sheets.plane
    found_edge, found_face = np.empty(room, np.int32), np.empty(room, np.int32)
    found_share, box, count = np.empty(room), np.empty(4, np.int64), 0
    for edge in range(len(edges)):
        one, two = edges[edge, 0], edges[edge, 1]
        ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
        bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
        ux, uy, uz = bx - ax, by - ay, bz - az
        share = -(ax * ux + ay * uy + az * uz) / (ux * ux + uy * uy + uz * uz)
        share = min(max(share, 0.0), 1.0)
        x, y, z = ax + share * ux, ay + share * uy, az + share * uz
        nearest = np.sqrt(x * x + y * y + z * z)
        first, last = _sides_of(position, one, two, two)
        for side in range(first, last):
            if not _project(position, one, two, two, side, sheets.cells, box):
                continue
            for u in range(box[0], box[1] + 1):
                for v in range(box[2], box[3] + 1):
                    cell = (side * sheets.cells + u) * sheets.cells + v
                    for entry in range(sheets.start[cell], sheets.start[cell + 1]):
                        face = sheets.listed[entry]
                        nx, ny, nz = plane[face, 0], plane[face, 1], plane[face, 2]
                        if plane[face, 4] < nearest:
                            continue
                        over_a = nx * ax + ny * ay + nz * az - plane[face, 3]
                        over_b = nx * bx + ny * by + nz * bz - plane[face, 3]
                        if (over_a > 0.0) == (over_b > 0.0) or (
                            abs(over_a) <= sheets.tolerance and abs(over_b) <= sheets.tolerance
                        ):
                            continue
                        if _has_corner(sheets.corner, face, one, two):
                            continue
                        share = over_a / (over_a - over_b)
                        x, y, z = ax + share * ux, ay + share * uy, az + share * uz
                        # each crossing once: in its own cell
                        if _cell_of(x, y, z, sheets.cells) == cell and _is_within(
                            sheets, face, x, y, z
                        ):
                            if count < room:
                                found_edge[count], found_face[count] = edge, face
                                found_share[count] = share
                            count += 1
    kept = min(count, room)
    return count, Crossings(
        found_edge[:kept].copy(), found_face[:kept].copy(), found_share[:kept].copy()
    )


@leaf_kernel
def _has_corner(corner: IndexArray, face: int, one: int, two: int) -> bool:
    first, second, third = corner[face, 0], corner[face, 1], corner[face, 2]
    return first in (one, two) or second in (one, two) or third in (one, two)
