"""The collapse loop: the cheapest valid collapse, repeatedly, down to a number of vertices.

Data layout: a `State` (surface, grid and state of the cost), a `LoopWorkspace` with an indexed heap
of edges, and a `Record` that receives every collapse. An edge is queued with the error of its first
candidate position, the optimum of the cost. At the front of the queue the candidate is rounded to
the grid and tested. Only a position that is valid after rounding is used and recorded. Otherwise
the edge is queued again with the error of its next candidate. An edge without a valid candidate is
parked: it stays outside the queue until its link changes.

Fine levels of large boundaries are collapsed in sweeps: edges in the order of memory, below a
rising limit of their error. In strict order the cheapest edge lies anywhere in memory, and each
collapse waits for it. Among hundreds of thousands of nearly equal edges the order hardly matters.
Edges that are near in memory are near on the surface, because `modified_convex_hull` orders them
so. One sweep makes few collapses, so a block of edges that fits the cache is swept several times
with rising limits before the next block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, Float32Array, FloatArray, IndexArray, LongArray
from gamutcore.decimation.costs import (
    MEMORYLESS,
    GridPositions,
    State,
    enter_level,
    error_at,
    find_improvement,
    find_optimum,
    update_after_change,
    update_before_collapse,
)
from gamutcore.decimation.deviation import NO_FACE
from gamutcore.decimation.edge_queue import EdgeQueue, dequeue, empty_queue, enqueue, fill_queue
from gamutcore.decimation.record import Record, has_room, record_collapse, record_shift
from gamutcore.decimation.surface_mesh import (
    LARGEST_LINK,
    SurfaceMesh,
    edge_ends,
    find_inner_direction,
    keeps_star_shape,
    link_condition_holds,
    scale_to_preserve_volume,
    write_edge_link,
    write_vertex_link,
)
from gamutcore.geometry import Vector, dot, minus, next_corner, previous_corner, row, triple
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel


class LoopWorkspace(NamedTuple):
    """Data of the collapse loop besides the state, for V vertices and E edges."""

    queue: EdgeQueue
    collapses: LongArray  # (1,) number of collapses so far
    choice: ByteArray  # (E,) number of the candidate whose error stands in the queue
    evaluated: IndexArray  # (E,) number of collapses before the edge's error was evaluated
    changed: IndexArray  # (V,) number of collapses after which a vertex's faces last changed
    parked: IndexArray  # (1,) number of edges that are neither queued nor removed
    perturbation: FloatArray  # (E,) of errors in the present trial; (0,) for exact errors
    link: IndexArray  # (2 V, 2) scratch: the link of the current edge or vertex
    point: FloatArray  # (3,) the current position, relative to the centre
    rounded: Float32Array  # (3,) the same position rounded to the grid
    neighbourhood: IndexArray  # (LARGEST_LINK + 1,) scratch: a vertex and its neighbours
    before: Float32Array  # (LARGEST_LINK + 1, 3) scratch: their positions before they move
    counter: LongArray  # (1,) counts collapses; another thread reads it to report progress


def empty_workspace(
    edges: int, vertices: int, counter: LongArray, perturbation: FloatArray
) -> LoopWorkspace:
    """Return the workspace for a surface, with no edge queued."""
    return LoopWorkspace(
        empty_queue(edges),
        np.zeros(1, np.int64),
        np.zeros(edges, np.uint8),
        np.zeros(edges, np.int32),
        np.zeros(vertices, np.int32),
        np.zeros(1, np.int32),
        perturbation,
        # as long as the links of both ends of an edge together; only the used part takes memory
        np.empty((2 * vertices, 2), np.int32),
        np.empty(3, np.float64),
        np.empty(3, np.float32),
        np.empty(LARGEST_LINK + 1, np.int32),
        np.empty((LARGEST_LINK + 1, 3), np.float32),
        counter,
    )


@kernel
def collapse_edges(
    state: State, record: Record, work: LoopWorkspace, swept: int, wanted: int
) -> int:
    """Collapse edges, cheapest first, to `wanted` collapses in all; the first `swept` in sweeps.

    A call continues after the collapses of the last one. The result is the number of changes that
    the record has no room for: extend it and call again. It is 0 at the end, or if no edge can be
    collapsed validly.
    """
    enter_level(state, len(state.grid.position) - work.collapses[0])
    if work.collapses[0] < swept and not _collapse_in_sweeps(state, record, work, swept):
        return LARGEST_LINK
    return _collapse_in_order(state, record, work, wanted)


@leaf_kernel
def _collapse_in_order(state: State, record: Record, work: LoopWorkspace, wanted: int) -> int:
    """Collapse the cheapest edge repeatedly. Parameters and result as in `collapse_edges`."""
    surface, parameters, queue = state.surface, state.parameters, work.queue
    on_link, requeued = parameters.kind == MEMORYLESS, -1
    queue.size[0] = 0
    while work.collapses[0] < wanted:
        if queue.size[0] == 0:
            # parked edges return if a collapse has changed anything since
            if work.collapses[0] == requeued:
                break
            _queue_all(state, work)
            requeued = work.collapses[0]
            continue
        edge = int(queue.heap[0])
        if on_link and _is_stale(surface, work, edge):
            _requeue(state, work, edge)
            continue
        _, kept, dead = edge_ends(surface, edge)
        if not link_condition_holds(surface, kept, dead):
            _park(work, edge)
            continue
        around = int(surface.degree[kept] + surface.degree[dead])
        if not has_room(record, work.collapses[0], around):
            return around
        count = write_edge_link(surface, kept, dead, work.link)
        if not _candidate_is_valid(state, work, edge, count):
            _queue_next_candidate(state, work, edge, count)
            continue
        kept = collapse_edge(state, record, work, edge)
        if parameters.moved_vertices > 0:
            _relax(state, record, work, kept)
        left = len(state.grid.position) - work.collapses[0]
        if work.collapses[0] < wanted and enter_level(state, left):
            _queue_all(state, work)
        else:
            _refresh(state, work, kept, left - 4 < parameters.eager_collapses)
    return 0


@leaf_kernel
def _queue_all(state: State, work: LoopWorkspace) -> None:
    """Queue all edges, each with the error of its optimum."""
    queue, queued = work.queue, 0
    for edge in range(queue.heap_index.size):
        queue.heap_index[edge] = -1
        if state.surface.corner_facing[edge] >= 0:
            queue.priority[edge] = _optimum_error(state, work, edge)
            queue.heap[queued] = edge
            queued += 1
    fill_queue(queue, queued)
    work.parked[0] = 0


@leaf_kernel
def _optimum_error(state: State, work: LoopWorkspace, edge: int) -> float:
    """Evaluate an edge: write its optimum and return the error of it in the present trial."""
    work.choice[edge], work.evaluated[edge] = 0, work.collapses[0]
    value = find_optimum(state, int(state.surface.corner_facing[edge]), work.point)
    return _perturb(work, edge, value)


PERTURBATION = 0.1
"""Largest relative perturbation of errors in a trial. From 0.03 to 0.3 the best of as many trials
is the same within the scatter."""


@leaf_kernel
def _perturb(work: LoopWorkspace, edge: int, value: float) -> float:
    """Error of an edge in the present trial."""
    if work.perturbation.size == 0 or not abs(value) < np.inf:
        return value
    return value + PERTURBATION * abs(value) * work.perturbation[edge]


@leaf_kernel
def _requeue(state: State, work: LoopWorkspace, edge: int) -> None:
    """Queue an edge, or move it in the queue, with the error of its optimum."""
    if work.queue.heap_index[edge] < 0:
        work.parked[0] -= 1
    enqueue(work.queue, edge, _optimum_error(state, work, edge))


@leaf_kernel
def _park(work: LoopWorkspace, edge: int) -> None:
    dequeue(work.queue, edge)
    work.parked[0] += 1


@leaf_kernel
def _queue_next_candidate(state: State, work: LoopWorkspace, edge: int, count: int) -> None:
    """Queue an edge with the error of its next candidate; park it if there is none."""
    corner = int(state.surface.corner_facing[edge])
    for choice in range(work.choice[edge] + 1, CANDIDATES):
        work.choice[edge] = choice
        if _write_candidate(state, corner, choice, work.link, count, work.point):
            value = error_at(state, corner, work.point)
            # an infinite error comes last, but may be the only way on
            if not np.isnan(value):
                value = _perturb(work, edge, value)
                enqueue(work.queue, edge, max(work.queue.priority[edge], value))
                return
    _park(work, edge)


LARGE = 4.0
"""Ratio to the error of the cheapest edge above which a changed edge is not evaluated at once. Such
an edge is hardly the next one."""


@leaf_kernel
def _refresh(state: State, work: LoopWorkspace, kept: int, eager: bool) -> None:
    """Update the queue around a new vertex; parked edges of its neighbours return.

    With accumulated quadrics only the edges of the vertex have new errors; otherwise those of its
    neighbours have, too. If `eager`, the latter are evaluated at once unless they were large, else
    at the front of the queue: an old error is seldom too large.
    """
    surface, queue, collapses = state.surface, work.queue, work.collapses[0]
    on_link = state.parameters.kind == MEMORYLESS
    work.changed[kept] = collapses
    large = -np.inf
    if eager and on_link and queue.size[0] > 0:
        large = LARGE * abs(queue.priority[queue.heap[0]])
    spoke = int(surface.corner_at[kept])
    for _ in range(surface.degree[kept]):
        if not on_link:
            _requeue(state, work, int(surface.edge_of[previous_corner(spoke)]))
        neighbour = int(surface.vertex[next_corner(spoke)])
        work.changed[neighbour] = collapses
        # links of such a vertex's edges are not evaluated, so their errors do not change
        limit = large if surface.degree[neighbour] <= LARGEST_LINK else -np.inf
        if work.parked[0] > 0 or limit >= 0.0:
            around = int(surface.corner_at[neighbour])
            for _ in range(surface.degree[neighbour]):
                edge = int(surface.edge_of[previous_corner(around)])
                changes = queue.priority[edge] <= limit and work.evaluated[edge] < collapses
                if queue.heap_index[edge] < 0 or changes:
                    _requeue(state, work, edge)
                around = int(surface.swing[around])
        spoke = int(surface.swing[spoke])


@leaf_kernel
def _is_stale(surface: SurfaceMesh, work: LoopWorkspace, edge: int) -> bool:
    """Whether the faces around an edge have changed since its error was evaluated."""
    _, one, two = edge_ends(surface, edge)
    return max(work.changed[one], work.changed[two]) > work.evaluated[edge]


@leaf_kernel
def _mark_changed(surface: SurfaceMesh, work: LoopWorkspace, vertex: int) -> None:
    """Mark the faces of a vertex and of its neighbours as changed by the last collapse."""
    work.changed[vertex] = work.collapses[0]
    corner = int(surface.corner_at[vertex])
    for _ in range(surface.degree[vertex]):
        work.changed[surface.vertex[next_corner(corner)]] = work.collapses[0]
        corner = int(surface.swing[np.uint64(corner)])


CANDIDATES = 5
"""Number of candidates of an edge: the optimum, the midpoint, its two ends, inside of the cone."""

OPTIMUM, MIDPOINT, FIRST_END, SECOND_END, CONE = range(CANDIDATES)


@leaf_kernel
def _write_candidate(
    state: State, corner: int, choice: int, link: IndexArray, count: int, point: FloatArray
) -> bool:
    """Write candidate `choice` of the edge that `corner` faces; False if the edge has none.

    `link` is the edge's directed link of `count` pairs. The first candidate is the optimum of the
    cost. The others serve edges whose optimum is not valid. They are moved along their radius so
    that the collapse preserves the volume.
    """
    if choice == OPTIMUM:
        find_optimum(state, corner, point)
        return True
    surface, position = state.surface, state.surface.position
    kept, dead = (
        int(surface.vertex[next_corner(corner)]),
        int(surface.vertex[previous_corner(corner)]),
    )
    one = dead if choice == SECOND_END else kept
    two = kept if choice == FIRST_END else dead
    for axis in range(3):
        point[axis] = 0.5 * (position[one, axis] + position[two, axis])
    if choice == CONE and not find_inner_direction(position, link, count, point):
        return False
    return scale_to_preserve_volume(surface, kept, dead, link, count, point)


@leaf_kernel
def _candidate_is_valid(state: State, work: LoopWorkspace, edge: int, count: int) -> bool:
    """Write and round the present candidate of an edge; False if it is not valid."""
    corner, choice = int(state.surface.corner_facing[edge]), int(np.int64(work.choice[edge]))
    if not _write_candidate(state, corner, choice, work.link, count, work.point):
        return False
    return _rounded_point_is_valid(state, work, count)


@leaf_kernel
def _rounded_point_is_valid(state: State, work: LoopWorkspace, count: int) -> bool:
    """Round the current position; False if it is not valid for the current link."""
    point = work.point
    return _round_to_grid(state.grid, point, work.rounded) and keeps_star_shape(
        state.surface.position, work.link, count, point[0], point[1], point[2]
    )


LARGEST_STEPS = 2.0**24
"""Largest number of grid steps that float32 holds exactly, and that a history stores."""


@leaf_kernel
def _round_to_grid(grid: GridPositions, point: FloatArray, rounded: Float32Array) -> bool:
    """Round a position, relative to the centre, in place; `rounded` gets it in the colour space.

    False beyond 2²⁴ steps, where float32 does not hold the grid.
    """
    exact = True
    for axis in range(3):
        # adding 0.0 turns negative zeros into zeros
        on_grid = np.rint((point[axis] + grid.centre[axis]) / grid.step) * grid.step + 0.0
        rounded[axis] = np.float32(on_grid)
        exact = exact and abs(on_grid) <= LARGEST_STEPS * grid.step
        point[axis] = on_grid - grid.centre[axis]
    return exact


@inlined_kernel
def collapse_edge(state: State, record: Record, work: LoopWorkspace, edge: int) -> int:
    """Collapse an edge to `work.point`, record the collapse, and return the vertex that stays.

    The end with more edges stays. The record has room for the degrees of both ends.
    """
    surface, grid, index = state.surface, state.grid, work.collapses[0]
    corner, kept, dead = edge_ends(surface, edge)
    twin = int(surface.opposite[corner])
    if surface.degree[dead] > surface.degree[kept]:
        kept, dead = dead, kept
    record_collapse(record, index, surface, grid.position, work.rounded, corner, kept, dead)
    update_before_collapse(state, corner, kept, dead, work.point)
    for axis in range(3):
        surface.position[kept, axis] = work.point[axis]
        grid.position[kept, axis] = work.rounded[axis]
    for moved in range(record.moved_end[index] - surface.degree[dead] + 2, record.moved_end[index]):
        surface.vertex[record.moved[moved]] = kept
    surface.degree[kept] += surface.degree[dead] - 4
    dequeue(work.queue, edge)
    surface.corner_facing[edge] = -1
    for side in (corner, twin):
        surface.degree[surface.vertex[side]] -= 1
        gone = _close_gap(surface, side)
        if work.queue.heap_index[gone] < 0:
            work.parked[0] -= 1
        dequeue(work.queue, gone)
    update_after_change(state, kept, corner // 3, twin // 3)
    work.collapses[0] += 1
    work.counter[0] += 1
    return kept


@leaf_kernel
def _close_gap(surface: SurfaceMesh, corner: int) -> int:
    """Join the two outer neighbours of a removed face; returns the edge that disappears.

    `corner` faces the collapsed edge. The corners outside the removed faces name the kept vertex
    already. Two edges become one, which keeps the smaller id.
    """
    vertex, opposite = surface.vertex, surface.opposite
    one, two = int(opposite[next_corner(corner)]), int(opposite[previous_corner(corner)])
    opposite[one], opposite[two] = two, one
    surface.swing[previous_corner(one)], surface.swing[previous_corner(two)] = (
        next_corner(two),
        next_corner(one),
    )
    surface.corner_at[vertex[next_corner(one)]] = next_corner(one)
    surface.corner_at[vertex[previous_corner(one)]] = previous_corner(one)
    stays, goes = int(surface.edge_of[one]), int(surface.edge_of[two])
    if goes < stays:
        stays, goes = goes, stays
    surface.edge_of[one] = stays
    surface.edge_of[two] = stays
    surface.corner_facing[stays] = one
    surface.corner_facing[goes] = -1
    return goes


ROUNDS = 4
"""Largest number of passes over the vertices around a collapse."""


@leaf_kernel
def _relax(state: State, record: Record, work: LoopWorkspace, kept: int) -> None:
    """Move a new vertex and its neighbours to better positions, and correct the record."""
    surface, around, position = state.surface, work.neighbourhood, state.grid.position
    neighbours = int(surface.degree[kept])
    if neighbours > LARGEST_LINK:
        return
    write_vertex_link(surface, kept, work.link)
    around[0] = kept
    for index in range(neighbours):
        around[index + 1] = work.link[index, 0]
    for index in range(neighbours + 1):
        for axis in range(3):
            work.before[index, axis] = position[around[index], axis]
    for _ in range(ROUNDS):
        moves = 0
        for index in range(neighbours + 1):
            moves += _move(state, work, int(around[index]))
        if moves == 0:
            break
    last = work.collapses[0] - 1
    for axis in range(3):
        record.position[last, 2, axis] = position[kept, axis]
    for index in range(1, neighbours + 1):
        vertex, moved = int(around[index]), False
        for axis in range(3):
            moved = moved or position[vertex, axis] != work.before[index, axis]
        if moved:
            _mark_changed(surface, work, vertex)
            record_shift(record, last, vertex, work.before, index, position)


@inlined_kernel
def _move(state: State, work: LoopWorkspace, vertex: int) -> bool:
    """Move a vertex to a better position that is valid; False if there is none."""
    surface, point, link = state.surface, work.point, work.link
    if not (
        find_improvement(state, vertex, point) and _round_to_grid(state.grid, point, work.rounded)
    ):
        return False
    count = write_vertex_link(surface, vertex, link)
    if not (
        keeps_star_shape(surface.position, link, count, point[0], point[1], point[2])
        and _stays_fat(surface.position, link, count, vertex, point)
    ):
        return False
    for axis in range(3):
        surface.position[vertex, axis] = point[axis]
        state.grid.position[vertex, axis] = work.rounded[axis]
    update_after_change(state, vertex, NO_FACE, NO_FACE)
    return True


FATNESS = 0.05
"""A move must not leave a face whose solid angle is below this fraction of the mean around the
vertex, unless the face was there before. Slivers close the cones that later collapses need."""


@leaf_kernel
def _stays_fat(
    position: FloatArray, link: IndexArray, count: int, vertex: int, point: FloatArray
) -> bool:
    """Whether a move creates no sliver and stays within the radius of the star."""
    here, there = row(position, vertex, 0), (point[0], point[1], point[2])
    before, _ = _thinnest(position, link, count, here)
    after, mean = _thinnest(position, link, count, there)
    if after < before and after < FATNESS * mean:
        return False
    squared_radius = 0.0
    for pair in range(count):
        spoke = minus(row(position, link[pair, 0], 0), here)
        squared_radius = max(squared_radius, dot(spoke, spoke))
    move = minus(there, here)
    return dot(move, move) <= squared_radius


@leaf_kernel
def _thinnest(
    position: FloatArray, link: IndexArray, count: int, point: Vector
) -> tuple[float, float]:
    """Smallest and mean det(a, b, p) ÷ (|a| |b| |p|) over the faces around a position."""
    least, total = np.inf, 0.0
    length = np.sqrt(dot(point, point))
    for pair in range(count):
        a, b = row(position, link[pair, 0], 0), row(position, link[pair, 1], 0)
        angle = triple(a, b, point) / (np.sqrt(dot(a, a) * dot(b, b)) * length)
        least = min(least, angle)
        total += angle
    return least, total / count


RATIO = 1.7
"""Ratio of the limits of consecutive sweeps."""

BLOCK = 4096
"""Number of edges of a block in the first round: the cache holds their data."""

SWEEPS_PER_BLOCK = 3
"""Number of sweeps of a block in each round."""

WHOLE = 2.5
"""Ratio to the vertices of the last swept level up to which all edges form a single block. The last
limit has to be reached everywhere."""


@leaf_kernel
def _collapse_in_sweeps(state: State, record: Record, work: LoopWorkspace, wanted: int) -> bool:
    """Collapse edges below a rising limit of the error, in the order of memory.

    The queue is empty before and after. False if the record has no room for another collapse; True
    if `wanted` collapses are made, or no edge can be collapsed.
    """
    edges, vertices = work.queue.priority.size, len(state.grid.position)
    limit = _first_limit(state, work)
    block, first = BLOCK, True
    while work.collapses[0] < wanted:
        before, times = work.collapses[0], SWEEPS_PER_BLOCK
        if vertices - before <= WHOLE * (vertices - wanted):
            block, times = edges, 1
        for begin in range(0, edges, block):
            end = min(begin + block, edges)
            if first:
                for edge in range(begin, end):
                    _evaluate(state, work, edge)
            higher = limit
            for _ in range(times):
                if not _sweep(state, record, work, wanted, begin, end, higher):
                    return False
                higher *= RATIO
        if work.collapses[0] == before and not limit < np.inf:
            break
        for _ in range(times):
            limit *= RATIO
        # in each round there are fewer edges in the same memory
        block, first = min(2 * block, edges), False
    return True


FIRST_PART = 16
"""The first limit lies above the errors of one sixteenth of the edges."""

SAMPLED = 16
"""Every sixteenth edge is evaluated to find that limit."""


@leaf_kernel
def _first_limit(state: State, work: LoopWorkspace) -> float:
    """Quantile of the errors of edges from all over the surface, found by the empty queue."""
    queue, sampled = work.queue, 0
    for edge in range(0, state.surface.corner_facing.size, SAMPLED):
        if _evaluate(state, work, edge):
            value = queue.priority[edge]
            queue.priority[edge] = value if value < np.inf else np.inf  # noqa: FURB136  # NaN too
            queue.heap[sampled] = edge
            sampled += 1
    fill_queue(queue, sampled)
    for _ in range(sampled // FIRST_PART):
        dequeue(queue, int(queue.heap[0]))
    limit = queue.priority[queue.heap[0]]
    for index in range(queue.size[0]):
        queue.heap_index[queue.heap[index]] = -1
    queue.size[0] = 0
    return limit


@leaf_kernel
def _evaluate(state: State, work: LoopWorkspace, edge: int) -> bool:
    """Write the optimum of an edge and its error; False if the edge has been removed."""
    corner = int(state.surface.corner_facing[edge])
    if corner < 0:
        return False
    work.queue.priority[edge] = find_optimum(state, corner, work.point)
    work.evaluated[edge] = work.collapses[0]
    return True


@leaf_kernel
def _sweep(
    state: State,
    record: Record,
    work: LoopWorkspace,
    wanted: int,
    begin: int,
    end: int,
    limit: float,
) -> bool:
    """Sweep a block of edges once; False if the record has no room for another collapse."""
    surface, priority = state.surface, work.queue.priority
    for edge in range(begin, end):
        if surface.corner_facing[edge] < 0 or priority[edge] > limit:
            continue
        stale = _is_stale(surface, work, edge)
        if stale:
            _evaluate(state, work, edge)
            if priority[edge] > limit:
                continue
        corner, kept, dead = edge_ends(surface, edge)
        # the two faces at the edge count once for each end
        count = int(surface.degree[kept] + surface.degree[dead] - 4)
        if count > LARGEST_LINK or not link_condition_holds(surface, kept, dead):
            continue
        write_edge_link(surface, kept, dead, work.link)
        if not stale:
            find_optimum(state, corner, work.point)
        if not _rounded_point_is_valid(state, work, count):
            continue
        if work.collapses[0] == wanted:
            break
        if not has_room(record, work.collapses[0], count):
            return False
        _mark_changed(surface, work, collapse_edge(state, record, work, edge))
    return True
