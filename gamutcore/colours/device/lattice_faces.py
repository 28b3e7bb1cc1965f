"""Triangles of a lattice whose cells are divided to different degrees, without T-junctions.

A patch has k × k cells. Each cell is divided into its own numbers of parts along s and t, and each
side of a cell into as many parts as the finer of the two cells beside it. A ring of triangles
joins the sides of a cell to its inner points. Patches share their corners and edges.

Points are numbered in this order: the corners, the inner points of the edges, and patch by patch
the inner coarse nodes, the inner points of the inner sides, and the inner points of the cells.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import BooleanArray, FloatArray, IndexArray, LongArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["Layout", "inside_count", "lattice_faces"]

BELOW, ABOVE, BEFORE, AFTER = range(4)
"""Sides of a patch or cell: t = 0 and t = 1 (along s), s = 0 and s = 1 (along t)."""


class Layout(NamedTuple):
    """How patches share edges, and how finely everything is divided.

    Attributes
    ----------
    knots : (p, 2, k + 1) float64
        Lines of the cells along s and t.
    parts : (p, k, k, 2) int64
        Numbers of parts of each cell along s and t.
    which : (p, 4) int64
        Edge at each side of each patch.
    is_reversed : (p, 4) bool
        Whether the edge runs against s or t.
    edges : (e, 2) int64
        Corners at the ends of each edge.
    reached : (e, k + 1) int64
        Number of parts of each edge before each of its coarse nodes; all 0 for an edge of length 0.
    edge_start : (e,) int64
        Number of the first inner point of each edge.
    turned : (p,) bool
        Whether the triangles of a patch are clockwise in s and t.
    """

    knots: FloatArray
    parts: LongArray
    which: LongArray
    is_reversed: BooleanArray
    edges: LongArray
    reached: LongArray
    edge_start: LongArray
    turned: BooleanArray


def inside_count(parts: LongArray) -> int:
    """Return the number of points inside of all patches, from their parts (p, k, k, 2)."""
    along, across = parts[..., 0], parts[..., 1]
    nodes = len(parts) * (parts.shape[1] - 1) ** 2
    level = int(np.maximum(along[:, :, 1:], along[:, :, :-1]).sum()) - along[:, :, 1:].size
    upright = int(np.maximum(across[:, 1:], across[:, :-1]).sum()) - across[:, 1:].size
    return int(nodes + level + upright + ((along - 1) * (across - 1)).sum())


@leaf_kernel
def _side_parts(layout: Layout, patch: int, i: int, j: int, side: int) -> int:
    """Return the number of parts of a side of the cell (i, j)."""
    parts, last = layout.parts, layout.parts.shape[1] - 1
    direction = 0 if side <= ABOVE else 1
    x, y = i, j  # the cell beyond
    if side == BELOW:
        y -= 1
    elif side == ABOVE:
        y += 1
    elif side == BEFORE:
        x -= 1
    else:
        x += 1
    if 0 <= x <= last and 0 <= y <= last:
        return int(max(parts[patch, i, j, direction], parts[patch, x, y, direction]))
    edge, piece = layout.which[patch, side], i if direction == 0 else j
    if layout.is_reversed[patch, side]:
        piece = last - piece
    return int(layout.reached[edge, piece + 1] - layout.reached[edge, piece])


@leaf_kernel
def _edge_point(layout: Layout, patch: int, side: int, node: int, further: int) -> int:
    """Return the point on an edge of a patch, by its number of parts beyond a coarse node."""
    edge, last = layout.which[patch, side], layout.reached.shape[1] - 1
    reached = layout.reached
    if layout.is_reversed[patch, side]:
        at = reached[edge, last - node] - further
    else:
        at = reached[edge, node] + further
    if at == 0:
        return int(layout.edges[edge, 0])
    if at == reached[edge, last]:
        return int(layout.edges[edge, 1])
    return int(layout.edge_start[edge] + at - 1)


@leaf_kernel
def _node(layout: Layout, patch: int, start: int, i: int, j: int) -> int:
    """Return the point at a coarse node of a patch, whose inner nodes have numbers from `start`."""
    cells = layout.parts.shape[1]
    if j == 0:
        return _edge_point(layout, patch, BELOW, i, 0)
    if j == cells:
        return _edge_point(layout, patch, ABOVE, i, 0)
    if i == 0:
        return _edge_point(layout, patch, BEFORE, j, 0)
    if i == cells:
        return _edge_point(layout, patch, AFTER, j, 0)
    return int(start + (i - 1) * (cells - 1) + j - 1)


@leaf_kernel
def _emit(faces: IndexArray, count: int, turned: bool, one: int, two: int, three: int) -> int:
    """Write a triangle unless two of its corners are the same; return the number of triangles."""
    if one == two or two == three or three == one:
        return count
    faces[count, 0] = one
    faces[count, 1], faces[count, 2] = (three, two) if turned else (two, three)
    return count + 1


@leaf_kernel
def _zip_ring(
    faces: IndexArray, count: int, turned: bool, chain: LongArray, outer: int, inner: int
) -> int:
    """Write the triangles between a side of a cell and the inner points next to it.

    `chain` (m,) has the points of the side, then the inner points on its left. The side has `outer`
    parts; its `inner` points are at multiples of 1 ÷ (inner + 1). The result is the number of
    triangles.
    """
    i, j, left = 0, 0, outer + 1
    while i < outer or j < inner - 1:
        if j == inner - 1 or (i < outer and (i + 1) * (inner + 1) <= (j + 2) * outer):
            count = _emit(faces, count, turned, chain[i], chain[i + 1], chain[left + j])
            i += 1
        else:
            count = _emit(faces, count, turned, chain[i], chain[left + j + 1], chain[left + j])
            j += 1
    return count


@leaf_kernel
def _zip_chains(
    faces: IndexArray,
    count: int,
    turned: bool,
    chain: LongArray,
    rights: int,
    left: int,
    lefts: int,
) -> int:
    """Write the triangles between two chains of points in the same direction.

    `chain` (m,) has the right chain from 0 and the left one from `left`, with `rights` and `lefts`
    parts. They may share their first and last point. The result is the number of triangles.
    """
    i, j, i_end, j_end = 0, 0, rights, lefts
    if chain[0] == chain[left]:
        i, j = 1, 1
        count = _emit(faces, count, turned, chain[0], chain[1], chain[left + 1])
    joined = chain[rights] == chain[left + lefts]
    if joined:
        i_end, j_end = rights - 1, lefts - 1
    while i < i_end or j < j_end:
        if j == j_end or (i < i_end and (i + 1) * lefts <= (j + 1) * rights):
            count = _emit(faces, count, turned, chain[i], chain[i + 1], chain[left + j])
            i += 1
        else:
            count = _emit(faces, count, turned, chain[i], chain[left + j + 1], chain[left + j])
            j += 1
    if joined:
        count = _emit(faces, count, turned, chain[i_end], chain[rights], chain[left + j_end])
    return count


@leaf_kernel
def _append(chain: LongArray, at: int, sides: LongArray, side: int, parts: int, back: bool) -> int:
    """Append a side of a cell to a chain, without its first point if the chain has one."""
    for index in range(parts + 1):
        chain[at + index] = sides[side, parts - index if back else index]
    return at + parts


@leaf_kernel
def _fill_small_cell(
    faces: IndexArray,
    count: int,
    turned: bool,
    chain: LongArray,
    sides: LongArray,
    below: int,
    above: int,
    before: int,
    after: int,
) -> int:
    """Write the triangles of a cell without inner points, given the parts of its sides."""
    if before <= 1 and after <= 1:
        _append(chain, 0, sides, BELOW, below, False)
        _append(chain, below + 1, sides, ABOVE, above, False)
        return _zip_chains(faces, count, turned, chain, below, below + 1, above)
    if below <= 1 and above <= 1:
        _append(chain, 0, sides, AFTER, after, False)
        _append(chain, after + 1, sides, BEFORE, before, False)
        return _zip_chains(faces, count, turned, chain, after, after + 1, before)
    # along a diagonal, so that no triangle has three corners on one side
    if before + below >= 2 and above + after >= 2:
        at = _append(chain, 0, sides, BEFORE, before, True)
        rights = _append(chain, at, sides, BELOW, below, False)
        at = _append(chain, rights + 1, sides, ABOVE, above, False)
        _append(chain, at, sides, AFTER, after, True)
        return _zip_chains(faces, count, turned, chain, rights, rights + 1, above + after)
    at = _append(chain, 0, sides, BELOW, below, False)
    rights = _append(chain, at, sides, AFTER, after, False)
    at = _append(chain, rights + 1, sides, BEFORE, before, False)
    _append(chain, at, sides, ABOVE, above, False)
    return _zip_chains(faces, count, turned, chain, rights, rights + 1, before + above)


@leaf_kernel
def _fill_cell(
    faces: IndexArray,
    count: int,
    turned: bool,
    chain: LongArray,
    sides: LongArray,
    side_parts: LongArray,
    along: int,
    across: int,
    start: int,
) -> int:
    """Write the triangles of a cell whose inner points have numbers from `start`."""
    rows, columns = along - 1, across - 1
    for side in range(4):
        outer = side_parts[side]
        _append(chain, 0, sides, side, outer, False)
        inner, length = outer + 1, rows if side <= ABOVE else columns
        for index in range(length):
            if side <= ABOVE:
                x, y = index, 0 if side == BELOW else columns - 1
            else:
                x, y = 0 if side == BEFORE else rows - 1, index
            chain[inner + index] = start + x * columns + y
        # the inner points are on the right of the two other sides
        is_right = side in (ABOVE, BEFORE)
        count = _zip_ring(faces, count, turned != is_right, chain, outer, length)
    for x in range(rows - 1):
        for y in range(columns - 1):
            one = start + x * columns + y
            two, three, four = one + columns, one + columns + 1, one + 1
            count = _emit(faces, count, turned, one, two, three)
            count = _emit(faces, count, turned, one, three, four)
    return count


@leaf_kernel
def _gather_side(
    layout: Layout,
    sides: LongArray,
    side_parts: LongArray,
    level: LongArray,
    upright: LongArray,
    nodes: int,
    patch: int,
    i: int,
    j: int,
    side: int,
) -> None:
    """Write the points of a side of the cell (i, j), in the direction of s or t.

    Row `side` of `sides` (4, m) and `side_parts` (4,) is written. `level` and `upright` (k, k) have
    the first inner points of the cells' sides ABOVE and AFTER. `nodes` is the number of the patch's
    first inner coarse node.
    """
    cells, some = layout.parts.shape[1], side_parts[side]
    if side <= ABOVE:
        line, piece = (j if side == BELOW else j + 1), i
        sides[side, 0] = _node(layout, patch, nodes, i, line)
        sides[side, some] = _node(layout, patch, nodes, i + 1, line)
        start = level[i, line - 1]
    else:
        line, piece = (i if side == BEFORE else i + 1), j
        sides[side, 0] = _node(layout, patch, nodes, line, j)
        sides[side, some] = _node(layout, patch, nodes, line, j + 1)
        start = upright[line - 1, j]
    on_edge = line in (0, cells)
    for index in range(1, some):
        if on_edge:
            sides[side, index] = _edge_point(layout, patch, side, piece, index)
        else:
            sides[side, index] = start + index - 1


@kernel
def lattice_faces(  # noqa: C901, PLR0912  # one pass over all cells
    layout: Layout, outside: int, inside: int, triangles: int, longest: int
) -> tuple[LongArray, FloatArray, IndexArray, IndexArray]:
    """Return the inner points of all patches, and the triangles of all patches.

    Parameters
    ----------
    layout : Layout
    outside, inside : int
        Numbers of points: corners and on edges; and inside of patches (`inside_count`).
    triangles, longest : int
        Upper bound of the number of triangles; largest number of parts of any side.

    Returns
    -------
    patch : (inside,) int64
        Patch of each inner point.
    position : (inside, 2) float64
        Its s and t.
    faces : (m, 3) int32
    labels : (m,) int32
        Patch of each triangle.
    """
    knots, parts = layout.knots, layout.parts
    cells = parts.shape[1]
    owner, position = np.empty(inside, np.int64), np.empty((inside, 2))
    faces, labels = np.empty((triangles, 3), np.int32), np.empty(triangles, np.int32)
    side_parts, sides = np.empty(4, np.int64), np.empty((4, longest + 1), np.int64)
    chain = np.empty(4 * longest + 8, np.int64)
    level, upright = np.zeros((cells, cells), np.int64), np.zeros((cells, cells), np.int64)
    count, used = 0, 0
    for patch in range(len(parts)):
        nodes = outside + used
        for i in range(1, cells):
            for j in range(1, cells):
                position[used, 0], position[used, 1] = knots[patch, 0, i], knots[patch, 1, j]
                used += 1
        for i in range(cells):
            for j in range(cells):
                low_s, low_t = knots[patch, 0, i], knots[patch, 1, j]
                wide, high = knots[patch, 0, i + 1] - low_s, knots[patch, 1, j + 1] - low_t
                for side in range(4):
                    side_parts[side] = _side_parts(layout, patch, i, j, side)
                # points of the sides towards lower cells exist already
                if j + 1 < cells:
                    level[i, j] = outside + used
                    for index in range(1, side_parts[ABOVE]):
                        position[used, 0] = low_s + index / side_parts[ABOVE] * wide
                        position[used, 1] = knots[patch, 1, j + 1]
                        used += 1
                if i + 1 < cells:
                    upright[i, j] = outside + used
                    for index in range(1, side_parts[AFTER]):
                        position[used, 0] = knots[patch, 0, i + 1]
                        position[used, 1] = low_t + index / side_parts[AFTER] * high
                        used += 1
                for side in range(4):
                    _gather_side(
                        layout, sides, side_parts, level, upright, nodes, patch, i, j, side
                    )
                along, across = parts[patch, i, j, 0], parts[patch, i, j, 1]
                first, turned = count, layout.turned[patch]
                if along > 1 and across > 1:
                    start = outside + used
                    for x in range(1, along):
                        for y in range(1, across):
                            position[used, 0] = low_s + x / along * wide
                            position[used, 1] = low_t + y / across * high
                            used += 1
                    count = _fill_cell(
                        faces, count, turned, chain, sides, side_parts, along, across, start
                    )
                else:
                    count = _fill_small_cell(
                        faces,
                        count,
                        turned,
                        chain,
                        sides,
                        side_parts[BELOW],
                        side_parts[ABOVE],
                        side_parts[BEFORE],
                        side_parts[AFTER],
                    )
                labels[first:count] = patch
        owner[nodes - outside : used] = patch
    return owner, position, faces[:count].copy(), labels[:count].copy()
