"""Cones of faces seen from a centre, and the cube map that finds them by direction.

The cube map projects the directions from the centre on the six sides of a cube, each of n × n
cells. The cone of a face is a triangle on a side. A cell lists all faces whose triangles meet it,
largest first. The list of a direction's cell therefore has the face of the direction. Cells are
numbered (side · n + row) · n + column, and the lists are compressed (CSR): the faces of cell i are
``faces[start[i]:start[i + 1]]``. The sides are +x, −x, +y, −y, +z, −z. On a side, u and v are the
two other coordinates in cyclic order, divided by the magnitude of the side's own.

A triangle may be degenerate: an edge is a triangle with two equal corners.
"""

from __future__ import annotations

from typing import SupportsIndex

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.geometry.curves import grouped
from gamutcore.geometry.triangle import face_corners
from gamutcore.geometry.vectors import Vector, cross, dot, row
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

__all__ = ["add_cells", "cell_of", "cone_products", "direction_cells"]

WIDENING = 2.0**-40
"""How far the cells and triangles of a side reach beyond their edges. Directions are rounded by
some 2⁻⁵²."""

SPANS = 1024
"""Faces are ordered by the number of their cells, up to this number."""

ROOM = 16
"""Initial room in cells per face. With two cells per face, a face meets seven."""


@leaf_kernel
def cell_of(direction: Vector, resolution: int) -> int:
    """Return the cell of a direction, which is not 0 and has any length."""
    x, y, z = direction
    wide, deep, high = abs(x), abs(y), abs(z)
    if wide >= deep and wide >= high:
        side, w, u, v = (0 if x > 0.0 else 1), wide, y, z
    elif deep >= high:
        side, w, u, v = (2 if y > 0.0 else 3), deep, z, x
    else:
        side, w, u, v = (4 if z > 0.0 else 5), high, x, y
    scale = 0.5 * resolution
    line, column = int((u / w + 1.0) * scale), int((v / w + 1.0) * scale)
    last = resolution - 1
    return (side * resolution + min(line, last)) * resolution + min(column, last)


@leaf_kernel
def _cell_range(low: float, high: float, resolution: int) -> tuple[int, int]:
    """Return the first and the last cell along an edge that an interval meets; empty if none."""
    if high < -1.0 - WIDENING or low > 1.0 + WIDENING:
        return 0, -1
    scale = 0.5 * resolution
    first = int(max((low - WIDENING + 1.0) * scale, 0.0))
    last = int(max((high + WIDENING + 1.0) * scale, 0.0))
    return min(first, resolution - 1), min(last, resolution - 1)


@leaf_kernel
def _on_side(side: int, x: float, y: float, z: float) -> Vector:
    """Return the coordinate of a vector towards a side of the cube, and the two along the side."""
    w, u, v = (x, y, z) if side < 2 else ((y, z, x) if side < 4 else (z, x, y))
    return (w if side % 2 == 0 else -w), u, v


@leaf_kernel
def _is_beside(a: Vector, b: Vector, c: Vector) -> bool:
    """Whether a face, in coordinates of a side, is behind the centre or beside the side."""
    in_front = left = right = below = above = 0
    for w, u, v in (a, b, c):
        in_front += w > 0.0
        left += w + u < -WIDENING * w
        right += w - u < -WIDENING * w
        below += w + v < -WIDENING * w
        above += w - v < -WIDENING * w
    return in_front == 0 or left == 3 or right == 3 or below == 3 or above == 3


@leaf_kernel
def _plane(a: Vector, b: Vector, half: float) -> Vector:
    """Return the plane (constant, across, along) through the centre and an edge, in a side.

    The plane is moved outwards by half a cell and the rounding error. A cell therefore meets the
    cone if constant + across · u + along · v ≥ 0 for its middle.
    """
    towards, across, along = cross(a, b)
    beyond = (abs(across) + abs(along)) * half
    return towards + beyond + WIDENING * (abs(towards) + abs(across) + abs(along)), across, along


@leaf_kernel
def _add_cells_of_side(
    side: int, a: Vector, b: Vector, c: Vector, resolution: int, cells: IndexArray, end: int
) -> int:
    """Append the cells of a side that a face meets; return the new length, or −1 if full.

    The corners are in coordinates of the side.
    """
    first_row = first_column = 0
    last_row = last_column = resolution - 1
    if a[0] > 0.0 and b[0] > 0.0 and c[0] > 0.0:
        one, two, three = a[1] / a[0], b[1] / b[0], c[1] / c[0]
        first_row, last_row = _cell_range(min(one, two, three), max(one, two, three), resolution)
        one, two, three = a[2] / a[0], b[2] / b[0], c[2] / c[0]
        first_column, last_column = _cell_range(
            min(one, two, three), max(one, two, three), resolution
        )
    if end + (last_row - first_row + 1) * (last_column - first_column + 1) > len(cells):
        return -1
    half = 1.0 / resolution
    p, p_across, p_along = _plane(b, c, half)
    q, q_across, q_along = _plane(c, a, half)
    r, r_across, r_along = _plane(a, b, half)
    for line in range(first_row, last_row + 1):
        u = (2 * line + 1) * half - 1.0
        p_row, q_row, r_row = p + p_across * u, q + q_across * u, r + r_across * u
        cell = (side * resolution + line) * resolution
        for column in range(first_column, last_column + 1):
            v = (2 * column + 1) * half - 1.0
            cells[end] = cell + column  # without branches, which processors cannot predict here
            end += (
                (p_row + p_along * v >= 0.0)
                & (q_row + q_along * v >= 0.0)
                & (r_row + r_along * v >= 0.0)
            )
    return end


@leaf_kernel
def add_cells(a: Vector, b: Vector, c: Vector, resolution: int, cells: IndexArray, end: int) -> int:
    """Append the cells of all sides that a face meets, as `_add_cells_of_side` for one side."""
    wide, deep, high = abs(a[0]), abs(a[1]), abs(a[2])
    axis = 0 if wide >= deep and wide >= high else (1 if deep >= high else 2)
    own = 2 * axis + (a[axis] < 0.0)
    within = True
    for corner in (a, b, c):
        w, u, v = _on_side(own, *corner)
        within &= max(abs(u), abs(v)) < (1.0 - 2.0 * WIDENING) * w
    for side in range(own if within else 0, own + 1 if within else 6):
        p, q, r = _on_side(side, *a), _on_side(side, *b), _on_side(side, *c)
        if side % 2 == 1:  # a mirror image
            q, r = r, q
        if not _is_beside(p, q, r):
            end = _add_cells_of_side(side, p, q, r, resolution, cells, end)
            if end < 0:
                return -1
    return end


@kernel
def direction_cells(
    position: FloatArray, mesh: IndexArray, resolution: int
) -> tuple[IndexArray, IndexArray]:
    """Return start (6 n² + 1,) and faces (m,): the faces that each cell meets, largest cone first.

    `position` (V, 3) is relative to the centre, which sees each face from inside. `resolution` is
    n, the number of cells along an edge of the cube.
    """
    count = len(mesh)
    # the cells of each face
    ends = np.zeros(count + 1, np.int64)
    cells = np.empty(ROOM * count, np.int32)
    face = 0
    while face < count:
        a, b, c = face_corners(position, mesh, face)
        end = add_cells(a, b, c, resolution, cells, ends[face])
        if end < 0:
            longer = np.empty(2 * len(cells), np.int32)
            # numba takes 3 s to compile an assignment of slices
            for entry in range(ends[face]):
                longer[entry] = cells[entry]
            cells = longer
        else:
            face += 1
            ends[face] = end
    # the faces by their number of cells, most first
    span = np.empty(count, np.int32)
    for face in range(count):
        span[face] = SPANS - min(ends[face + 1] - ends[face], SPANS)
    order = grouped(span, SPANS + 1)[1]

    # where the list of each cell begins, one place further for the next loop
    start = np.zeros(6 * resolution * resolution + 2, np.int32)
    for entry in range(ends[count]):
        start[cells[entry] + 2] += 1
    for cell in range(2, len(start)):
        start[cell] += start[cell - 1]
    faces = np.empty(ends[count], np.int32)
    for index in range(count):
        face = order[index]
        for entry in range(ends[face], ends[face + 1]):
            free = cells[entry] + 1
            faces[start[free]] = face
            start[free] += 1
    return start[:-1].copy(), faces


@inlined_kernel
def cone_products(planes: FloatArray, face: SupportsIndex, point: Vector) -> Vector:
    """Return the products of a point with three planes through the centre, in a row of `planes`.

    The planes of a cone (a, b, c) are multiples of b × c, c × a and a × b. Products are positive on
    the side of the cone.
    """
    return (
        dot(row(planes, face, 0), point),
        dot(row(planes, face, 3), point),
        dot(row(planes, face, 6), point),
    )
