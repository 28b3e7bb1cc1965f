"""Recipes of three chromatic inks and black: all of a colour's solutions along the black axis.

A set of inks has a table of colours, sampled from the device model: n nodes along each chromatic
ink, and `layers` levels of black. Within a layer, cells are cut into six tetrahedra (Kuhn), on
which the colours are linear; between layers, they are linear in black. For one colour, the
solutions of all layers are found exactly. Those of neighbouring layers are joined to a *path*, and
its ends, where an ink is used up, are bisected. They are the possible range of black. A rule
chooses the amount of black on the path.

Data layout
-----------
Device values are fractions of the range of each ink: x = (a, b, c, k). `nodes` (layers · n³, 3) has
the colours at the nodes, with c the fastest index. `scale` (4,) has the ranges of the inks and
`room` the largest sum of x · scale. `boxes` (layers · (n − 1)³, 6) are the bounds of the colours of
each cell. A grid of cubes covers the colours: `low` (3,) is its corner, `size` the edge of a cube
and `counts` (3,) the cubes along each axis. `members` [first[v] : first[v + 1]] are the cells
whose box meets cube v of a layer; cubes of all layers are numbered one after the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import BooleanArray, FloatArray, IndexArray, LongArray
from gamutcore.geometry import (
    Symmetric,
    Vector,
    add_outer,
    adjugate,
    copy_row,
    dot,
    minus,
    plus,
    product,
    row,
    scaled,
    triple,
    write_row,
)
from gamutcore.kernels import kernel, leaf_kernel

__all__ = [
    "GCR",
    "LEAST_INK",
    "SHARE",
    "WANTED",
    "InkTable",
    "correct_recipes",
    "ink_table",
    "trace_paths",
]

SHARE, WANTED, LEAST_INK, GCR = 0, 1, 2, 3
"""Rules of black: a share of the possible range, a wanted amount, the least cost of inks, or a
share of the most possible black (gray component replacement)."""

CUBE = 5.0
"""Edge of the cubes of the index in CIELAB; most meet a dozen cells."""

MOST_BRANCHES = 8
"""Largest number of solutions in one layer that are kept."""

NEAR = 0.35
"""Largest change of an ink between the solutions of neighbouring layers of one path."""

SLACK = 1e-9
"""Rounding error of the coordinates of a solution in its tetrahedron."""

BISECTIONS = 10
"""Steps to the end of a path: a layer's distance ÷ 1024 is 0.006 % of black for 17 layers."""

SOLVED = 1e-5
"""Residual in CIELAB of a solution in the table."""

BEYOND = 1e-6
"""Share of the range by which a device value may exceed it by rounding."""

LONGEST_STEP = 0.3
"""Largest change of an ink in a step, as a share of its range."""

DAMPING = 1e-6
"""Levenberg's damping of least-squares steps, as a share of the trace of the normal matrix."""


class InkTable(NamedTuple):
    """The table of a set of inks and its index, as the module describes."""

    nodes: FloatArray
    per_axis: int
    layers: int
    boxes: FloatArray
    low: FloatArray
    size: float
    counts: LongArray
    first: LongArray
    members: IndexArray

    @property
    def nbytes(self) -> int:
        """Memory in bytes."""
        return sum(field.nbytes for field in self if isinstance(field, np.ndarray))


def ink_table(nodes: FloatArray, per_axis: int, layers: int) -> InkTable:
    """Return the table of colours at the nodes, with its index."""
    low = nodes.min(axis=0) - CUBE / 2
    counts = np.floor((nodes.max(axis=0) - low) / CUBE).astype(np.int64) + 1
    boxes = np.empty((layers * (per_axis - 1) ** 3, 6))
    first = np.zeros(layers * int(counts.prod()) + 1, np.int64)
    count_members(nodes, per_axis, boxes, low, CUBE, counts, first)
    np.cumsum(first, out=first)
    members = np.empty(first[-1], np.int32)
    # filling moves each start to its end, which is the next start
    fill_members(boxes, layers, low, CUBE, counts, first, members)
    first = np.concatenate([[0], first[:-1]])
    return InkTable(nodes, per_axis, layers, boxes, low, CUBE, counts, first, members)


@kernel
def count_members(
    nodes: FloatArray,
    per_axis: int,
    boxes: FloatArray,
    low: FloatArray,
    size: float,
    counts: LongArray,
    first: LongArray,
) -> None:
    """Write the boxes of all cells, and to `first[v + 1]` how many boxes meet cube v."""
    n, m = per_axis, per_axis - 1
    cubes = counts[0] * counts[1] * counts[2]
    for cell in range(len(boxes)):
        layer, rest = divmod(cell, m * m * m)
        i, rest = divmod(rest, m * m)
        j, k = divmod(rest, m)
        corner = layer * n * n * n + (i * n + j) * n + k
        for axis in range(3):
            least, most = np.inf, -np.inf
            for step in (0, 1, n, n + 1, n * n, n * n + 1, n * n + n, n * n + n + 1):
                value = nodes[corner + step, axis]
                least, most = min(least, value), max(most, value)
            boxes[cell, axis], boxes[cell, 3 + axis] = least, most
        x0, x1 = _span(boxes, cell, 0, low, size)
        y0, y1 = _span(boxes, cell, 1, low, size)
        z0, z1 = _span(boxes, cell, 2, low, size)
        for x in range(x0, x1 + 1):
            for y in range(y0, y1 + 1):
                for z in range(z0, z1 + 1):
                    first[layer * cubes + (x * counts[1] + y) * counts[2] + z + 1] += 1


@kernel
def fill_members(
    boxes: FloatArray,
    layers: int,
    low: FloatArray,
    size: float,
    counts: LongArray,
    first: LongArray,
    members: IndexArray,
) -> None:
    """Write the cells of each cube, from `first[v]` on, which is moved to their end."""
    cubes = counts[0] * counts[1] * counts[2]
    per_layer = len(boxes) // layers
    for cell in range(len(boxes)):
        layer = cell // per_layer
        x0, x1 = _span(boxes, cell, 0, low, size)
        y0, y1 = _span(boxes, cell, 1, low, size)
        z0, z1 = _span(boxes, cell, 2, low, size)
        for x in range(x0, x1 + 1):
            for y in range(y0, y1 + 1):
                for z in range(z0, z1 + 1):
                    v = layer * cubes + (x * counts[1] + y) * counts[2] + z
                    members[first[v]] = cell
                    first[v] += 1


@leaf_kernel
def _span(boxes: FloatArray, cell: int, axis: int, low: FloatArray, size: float) -> tuple[int, int]:
    """Return the first and the last cube that the box of a cell meets along an axis."""
    return (
        int(np.floor((boxes[cell, axis] - low[axis]) / size)),
        int(np.floor((boxes[cell, 3 + axis] - low[axis]) / size)),
    )


@leaf_kernel
def _layer_solutions(table: InkTable, layer: int, target: Vector, solutions: FloatArray) -> int:
    """Write the solutions (s, 3) of a colour in a layer, and return their number."""
    n, m, counts = table.per_axis, table.per_axis - 1, table.counts
    x = int(np.floor((target[0] - table.low[0]) / table.size))
    y = int(np.floor((target[1] - table.low[1]) / table.size))
    z = int(np.floor((target[2] - table.low[2]) / table.size))
    if not (0 <= x < counts[0] and 0 <= y < counts[1] and 0 <= z < counts[2]):
        return 0
    v = ((layer * counts[0] + x) * counts[1] + y) * counts[2] + z
    count = 0
    for place in range(table.first[v], table.first[v + 1]):
        cell, inside = table.members[place], True
        for axis in range(3):
            inside &= table.boxes[cell, axis] <= target[axis] <= table.boxes[cell, 3 + axis]
        if not inside:
            continue
        i, rest = divmod(cell - layer * m * m * m, m * m)
        j, k = divmod(rest, m)
        corner = layer * n * n * n + (i * n + j) * n + k
        zero = row(table.nodes, corner, 0)
        offset = minus(target, zero)
        for order in range(6):
            p, q = order // 2, (order // 2 + 1 + order % 2) % 3
            r = 3 - p - q
            one = row(table.nodes, corner + _stride(n, p), 0)
            two = row(table.nodes, corner + _stride(n, p) + _stride(n, q), 0)
            three = row(table.nodes, corner + n * n + n + 1, 0)
            first, second, third = minus(one, zero), minus(two, one), minus(three, two)
            volume = triple(first, second, third)
            if volume == 0.0:
                continue
            alpha = triple(offset, second, third) / volume
            beta = triple(first, offset, third) / volume
            gamma = triple(first, second, offset) / volume
            if alpha > 1.0 + SLACK or beta > alpha + SLACK:
                continue
            if gamma > beta + SLACK or gamma < -SLACK:
                continue
            if count == len(solutions):
                return count
            base = (i, j, k)
            solutions[count, p] = (base[p] + alpha) / m
            solutions[count, q] = (base[q] + beta) / m
            solutions[count, r] = (base[r] + gamma) / m
            count += 1
    return count


@leaf_kernel
def _stride(n: int, axis: int) -> int:
    return n * n if axis == 0 else (n if axis == 1 else 1)


@leaf_kernel
def _layer_colour(
    table: InkTable, layer: int, a: float, b: float, c: float
) -> tuple[Vector, Vector, Vector, Vector]:
    """Return the colour of a place in a layer, and its derivatives by the three inks."""
    n, m = table.per_axis, table.per_axis - 1
    i = min(max(int(a * m), 0), m - 1)
    j = min(max(int(b * m), 0), m - 1)
    k = min(max(int(c * m), 0), m - 1)
    u, v, w = a * m - i, b * m - j, c * m - k
    # the axes in the order of falling coordinates
    if u >= v:
        p, q = (0, 1) if v >= w else ((0, 2) if u >= w else (2, 0))
    else:
        p, q = (1, 0) if u >= w else ((1, 2) if v >= w else (2, 1))
    corner = layer * n * n * n + (i * n + j) * n + k
    zero = row(table.nodes, corner, 0)
    one = row(table.nodes, corner + _stride(n, p), 0)
    two = row(table.nodes, corner + _stride(n, p) + _stride(n, q), 0)
    three = row(table.nodes, corner + n * n + n + 1, 0)
    by_p, by_q = scaled(float(m), minus(one, zero)), scaled(float(m), minus(two, one))
    by_r = scaled(float(m), minus(three, two))
    by_a = by_p if p == 0 else (by_q if q == 0 else by_r)
    by_b = by_p if p == 1 else (by_q if q == 1 else by_r)
    by_c = by_p if p == 2 else (by_q if q == 2 else by_r)
    value = plus(zero, scaled(u / m, by_a))
    value = plus(plus(value, scaled(v / m, by_b)), scaled(w / m, by_c))
    return value, by_a, by_b, by_c


@leaf_kernel
def _between(one: Vector, two: Vector, share: float) -> Vector:
    return plus(scaled(1.0 - share, one), scaled(share, two))


@leaf_kernel
def _colour(
    table: InkTable, a: float, b: float, c: float, k: float
) -> tuple[Vector, Vector, Vector, Vector, Vector]:
    """Return the colour of a device value, and its derivatives by the three inks and black."""
    if table.layers == 1:
        value, by_a, by_b, by_c = _layer_colour(table, 0, a, b, c)
        return value, by_a, by_b, by_c, (0.0, 0.0, 0.0)
    steps = table.layers - 1
    layer = min(max(int(k * steps), 0), steps - 1)
    s = k * steps - layer
    one, one_a, one_b, one_c = _layer_colour(table, layer, a, b, c)
    two, two_a, two_b, two_c = _layer_colour(table, layer + 1, a, b, c)
    return (
        _between(one, two, s),
        _between(one_a, two_a, s),
        _between(one_b, two_b, s),
        _between(one_c, two_c, s),
        scaled(float(steps), minus(two, one)),
    )


@leaf_kernel
def _is_solved_at(table: InkTable, k: float, target: Vector, x: FloatArray) -> bool:
    """Solve for the chromatic inks at an amount of black, from x and into it, by Newton's method.

    The table is linear in pieces, so few steps are exact. The solution may be out of range.
    """
    for _ in range(16):
        value, by_a, by_b, by_c, _by_k = _colour(table, x[0, 0], x[0, 1], x[0, 2], k)
        rest = minus(target, value)
        if dot(rest, rest) < SOLVED * SOLVED:
            return True
        volume = triple(by_a, by_b, by_c)
        if volume == 0.0:
            return False
        steps = (
            triple(rest, by_b, by_c) / volume,
            triple(by_a, rest, by_c) / volume,
            triple(by_a, by_b, rest) / volume,
        )
        longest = max(abs(steps[0]), abs(steps[1]), abs(steps[2]))
        factor = min(1.0, LONGEST_STEP / longest)
        for axis in range(3):
            x[0, axis] = min(max(x[0, axis] + factor * steps[axis], -0.2), 1.2)
    return False


@leaf_kernel
def _is_printable(points: FloatArray, place: int, k: float, scale: FloatArray, room: float) -> bool:
    """Whether inks and their sum are within the limits, up to rounding."""
    total = k * scale[3]
    for axis in range(3):
        value = points[place, axis]
        if value < -BEYOND or value > 1.0 + BEYOND:
            return False
        total += value * scale[axis]
    return bool(total <= room + BEYOND)


@leaf_kernel
def _path_end(
    table: InkTable,
    target: Vector,
    scale: FloatArray,
    room: float,
    inside: float,
    outside: float,
    x: FloatArray,
    tried: FloatArray,
) -> float:
    """Return the amount of black where a path ends, between two amounts; x becomes its solution."""
    for _ in range(BISECTIONS):
        middle = 0.5 * (inside + outside)
        write_row(tried, 0, 0, row(x, 0, 0))
        if _is_solved_at(table, middle, target, tried) and _is_printable(
            tried, 0, middle, scale, room
        ):
            inside = middle
            write_row(x, 0, 0, row(tried, 0, 0))
        else:
            outside = middle
    return inside


@leaf_kernel
def _ink_sum(points: FloatArray, place: int, k: float, scale: FloatArray) -> float:
    chromatic = row(points, place, 0)
    return float(dot(chromatic, (scale[0], scale[1], scale[2])) + k * scale[3])


@leaf_kernel
def _chosen(
    solutions: FloatArray,
    count: int,
    k: float,
    scale: FloatArray,
    cost: FloatArray,
    room: float,
    path: FloatArray,
    before: int,
) -> tuple[int, float]:
    """Return the printable solution nearest to a row of the path, and its largest change of an ink.

    With a negative row, it is the solution of least cost. −1: there is none.
    """
    chosen, least = -1, np.inf
    for solution in range(count):
        if not _is_printable(solutions, solution, k, scale, room):
            continue
        change = _ink_sum(solutions, solution, k, cost)
        if before >= 0:
            change = 0.0
            for axis in range(3):
                change = max(change, abs(solutions[solution, axis] - path[before, axis]))
        if change < least:
            chosen, least = solution, change
    return chosen, least


@leaf_kernel
def _solutions_by_layer(
    table: InkTable,
    target: Vector,
    scale: FloatArray,
    cost: FloatArray,
    room: float,
    solutions: FloatArray,
    path: FloatArray,
) -> int:
    """Write the longest path through the layers, by rising black, from row 1 on; return its length.

    `path` (layers + 2, 4) has room for a row before and one after.
    """
    start, best_start, best_length = 0, 0, 0
    for layer in range(table.layers):
        k = layer / max(table.layers - 1, 1)
        count = _layer_solutions(table, layer, target, solutions)
        before = layer if layer > start else -1
        chosen, change = _chosen(solutions, count, k, scale, cost, room, path, before)
        if before >= 0 and change > NEAR:
            start = layer
            chosen, _least = _chosen(solutions, count, k, scale, cost, room, path, -1)
        if chosen < 0:
            start = layer + 1
            continue
        write_row(path, layer + 1, 0, row(solutions, chosen, 0))
        path[layer + 1, 3] = k
        if layer + 1 - start > best_length:
            best_start, best_length = start, layer + 1 - start
    for place in range(1, best_length + 1):
        for axis in range(4):
            path[place, axis] = path[best_start + place, axis]
    return best_length


@leaf_kernel
def _project(
    table: InkTable, target: Vector, scale: FloatArray, room: float, x: FloatArray, work: FloatArray
) -> bool:
    """Move x to a printable device value with the colour; return whether there is one near."""
    for _ in range(20):
        value, by_a, by_b, by_c, by_k = _colour(table, x[0, 0], x[0, 1], x[0, 2], x[0, 3])
        rest = minus(target, value)
        if dot(rest, rest) < SOLVED:
            return True
        write_row(work, 0, 0, by_a)
        write_row(work, 1, 0, by_b)
        write_row(work, 2, 0, by_c)
        write_row(work, 3, 0, by_k)
        if not _step_within(work, rest, scale, room, table.layers > 1, x):
            return False
    return False


@leaf_kernel
def _step_within(
    by: FloatArray,
    rest: Vector,
    scale: FloatArray,
    room: float,
    has_black: bool,  # of a kernel
    x: FloatArray,
) -> bool:
    """Change x (1, 4) by the shortest least-squares step that stays printable.

    `by` (4, 3) has the derivatives of the colour. Inks that would leave their range are set to its
    end, and the others share the rest. Return whether x moved.
    """
    free = (True, True, True, has_black)
    tight, moved = False, 0.0
    for _ in range(6):
        along, back, y = _least_squares(by, rest, scale, room, free, tight, x)
        longest, total = 0.0, -room
        for axis in range(4):
            step = _axis_step(by, axis, along, back, y, scale) if free[axis] else 0.0
            longest = max(longest, abs(step))
            total += (x[0, axis] + step) * scale[axis]
        if total > BEYOND and not tight:
            tight = True
            continue
        factor, kept = min(1.0, LONGEST_STEP / max(longest, BEYOND)), free
        for axis in range(4):
            step = factor * _axis_step(by, axis, along, back, y, scale) if free[axis] else 0.0
            end = min(max(x[0, axis] + step, 0.0), 1.0)
            if free[axis] and end != x[0, axis] + step:
                rest = minus(rest, scaled(end - x[0, axis], row(by, axis, 0)))
                moved += abs(end - x[0, axis])
                x[0, axis] = end
                kept = (
                    kept[0] and axis != 0,
                    kept[1] and axis != 1,
                    kept[2] and axis != 2,
                    kept[3] and axis != 3,
                )
        if kept == free:
            for axis in range(4):
                if free[axis]:
                    step = factor * _axis_step(by, axis, along, back, y, scale)
                    x[0, axis] += step
                    moved += abs(step)
            break
        free = kept
    return moved > SLACK


@leaf_kernel
def _least_squares(
    by: FloatArray,
    rest: Vector,
    scale: FloatArray,
    room: float,
    free: tuple[bool, bool, bool, bool],
    tight: bool,  # of a kernel
    x: FloatArray,
) -> tuple[Vector, float, Vector]:
    """Return the shortest step of the free inks to a change of colour, for `_axis_step`.

    If `tight`, the step leads to the limit of the sum and stays there. `along` is the mean
    derivative along the inks' sum, which is then taken out of all derivatives.
    """
    along, back, norm = (0.0, 0.0, 0.0), 0.0, 0.0
    if tight:
        excess = -room
        for axis in range(4):
            excess += x[0, axis] * scale[axis]
            if free[axis]:
                norm += scale[axis] * scale[axis]
                along = plus(along, scaled(scale[axis], row(by, axis, 0)))
        if norm > 0.0:
            along, back = scaled(1.0 / norm, along), -excess / norm
    matrix: Symmetric = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for axis in range(4):
        if free[axis]:
            change = minus(row(by, axis, 0), scaled(scale[axis], along))
            matrix = add_outer(matrix, 1.0, change)
    pull = DAMPING * (matrix[0] + matrix[3] + matrix[5]) + SLACK
    inverse, determinant = adjugate(matrix, pull)
    wanted = minus(rest, scaled(back * norm, along))
    return along, back, scaled(1.0 / determinant, product(inverse, wanted))


@leaf_kernel
def _axis_step(
    by: FloatArray, axis: int, along: Vector, back: float, y: Vector, scale: FloatArray
) -> float:
    """Return the step of one ink."""
    change = minus(row(by, axis, 0), scaled(scale[axis], along))
    return float(dot(change, y) + back * scale[axis])


@leaf_kernel
def _black(
    table: InkTable,
    target: Vector,
    cost: FloatArray,
    rule: int,
    wanted: float,
    path: FloatArray,
    length: int,
    tried: FloatArray,
) -> float:
    """Return the amount of black that a rule chooses on a path (length, 4)."""
    low, high = path[0, 3], path[length - 1, 3]
    if rule == SHARE:
        return float(low + wanted * (high - low))
    if rule == WANTED:
        return float(min(max(wanted, low), high))
    if rule == GCR:
        return float(max(wanted * high, low))
    best, least = 0, np.inf
    for place in range(length):
        ink = _ink_sum(path, place, path[place, 3], cost)
        if ink < least - BEYOND:
            best, least = place, ink
    one, two = path[max(best - 1, 0), 3], path[min(best + 1, length - 1), 3]
    for _ in range(BISECTIONS):  # by thirds: the cost has one minimum between neighbours
        first, second = one + (two - one) / 3, two - (two - one) / 3
        _place_on_path(path, length, first, tried)
        _is_solved_at(table, first, target, tried)
        ink = _ink_sum(tried, 0, first, cost)
        _place_on_path(path, length, second, tried)
        _is_solved_at(table, second, target, tried)
        if ink < _ink_sum(tried, 0, second, cost):
            two = second
        else:
            one = first
    return float(0.5 * (one + two))


@leaf_kernel
def _place_on_path(path: FloatArray, length: int, k: float, x: FloatArray) -> None:
    """Write the chromatic inks at an amount of black, interpolated on a path."""
    place = 0
    while place + 2 < length and path[place + 1, 3] < k:
        place += 1
    after = min(place + 1, length - 1)
    width = path[after, 3] - path[place, 3]
    share = 0.0 if width <= 0.0 else min(max((k - path[place, 3]) / width, 0.0), 1.0)
    for axis in range(3):
        x[0, axis] = (1.0 - share) * path[place, axis] + share * path[after, axis]


@kernel
def trace_paths(
    table: InkTable,
    targets: FloatArray,
    scale: FloatArray,
    cost: FloatArray,
    room: float,
    rule: int,
    wanted: FloatArray,
    starts: FloatArray,
    recipes: FloatArray,
    ranges: FloatArray,
    solved: BooleanArray,
) -> None:
    """Write recipes (m, 4) of colours (m, 3), and the possible range of black (m, 2).

    Of several solutions, that of the least sum of x · `cost` (4,) is taken. The rule of black has
    one number of `wanted` (m,) for each colour. Without `starts` (0, 4),
    solutions are searched in all layers. Rows of `starts` (m, 4) are device values near one of the
    solutions. `solved` (m,) tells which colours the table has within the limits.
    """
    solutions, path = np.empty((MOST_BRANCHES, 3)), np.empty((table.layers + 2, 4))
    x, tried, work = np.empty((1, 4)), np.empty((1, 4)), np.empty((4, 3))
    step = 1.0 / max(table.layers - 1, 1)
    for number in range(len(targets)):
        target = row(targets, number, 0)
        if len(starts) > 0:
            copy_row(x, 0, starts, number)
            solved[number] = _project(table, target, scale, room, x, work)
            copy_row(path, 1, x, 0)
            length = 1
        else:
            length = _solutions_by_layer(table, target, scale, cost, room, solutions, path)
            solved[number] = length > 0
        if length > 0:
            copy_row(recipes, number, path, 1)
            ranges[number] = path[1, 3]
        if not solved[number] or table.layers == 1:
            continue
        # the ends lie between the outermost solutions and the layers beyond
        for end in range(2):
            place, beyond = (1, 0) if end == 0 else (length, length + 1)
            inside = path[place, 3]
            outside = max(inside - step, 0.0) if end == 0 else min(inside + step, 1.0)
            copy_row(x, 0, path, place)
            x[0, 3] = _path_end(table, target, scale, room, inside, outside, x, tried)
            copy_row(path, beyond, x, 0)
            ranges[number, end] = x[0, 3]
        length += 2
        k = _black(table, target, cost, rule, wanted[number], path, length, tried)
        _place_on_path(path, length, k, x)
        write_row(tried, 0, 0, row(x, 0, 0))
        if _is_solved_at(table, k, target, tried):
            write_row(x, 0, 0, row(tried, 0, 0))
        for axis in range(3):
            recipes[number, axis] = min(max(x[0, axis], 0.0), 1.0)
        recipes[number, 3] = k


@kernel
def correct_recipes(
    table: InkTable, scale: FloatArray, room: float, rests: FloatArray, recipes: FloatArray
) -> None:
    """Change recipes (m, 4) so that their colours change by `rests` (m, 3), by the table's slopes.

    Black stays if the other inks stay printable, else all inks take the shortest step.
    """
    work, x = np.empty((4, 3)), np.empty((1, 4))
    for number in range(len(recipes)):
        copy_row(x, 0, recipes, number)
        rest = row(rests, number, 0)
        _value, by_a, by_b, by_c, by_k = _colour(table, x[0, 0], x[0, 1], x[0, 2], x[0, 3])
        volume = triple(by_a, by_b, by_c)
        if volume != 0.0:
            steps = (
                triple(rest, by_b, by_c) / volume,
                triple(by_a, rest, by_c) / volume,
                triple(by_a, by_b, rest) / volume,
            )
            write_row(x, 0, 0, plus(row(x, 0, 0), steps))
            longest = max(abs(steps[0]), abs(steps[1]), abs(steps[2]))
            if longest < LONGEST_STEP and _is_printable(x, 0, x[0, 3], scale, room):
                for axis in range(3):
                    recipes[number, axis] = min(max(x[0, axis], 0.0), 1.0)
                continue
        copy_row(x, 0, recipes, number)
        write_row(work, 0, 0, by_a)
        write_row(work, 1, 0, by_b)
        write_row(work, 2, 0, by_c)
        write_row(work, 3, 0, by_k)
        _step_within(work, rest, scale, room, table.layers > 1, x)
        copy_row(recipes, number, x, 0)
