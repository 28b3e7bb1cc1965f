"""The collapse loop: the cheapest valid collapse, repeatedly, down to a number of vertices.

Data layout: a `Surface` (positions, corner table, edges), a `CostState`, a `Workspace` with an
indexed heap of edges, and a `Record` that receives every collapse. An edge is queued with the error
of its first candidate position, the optimum of the cost. At the front of the queue the candidate is
rounded to the grid and tested. If it is not valid, the edge is queued again with the error of its
next candidate. An edge without a valid candidate is parked: it stays outside the queue until its
link changes.
"""

from __future__ import annotations

import numpy as np

from gamutcore.corner_table import following, preceding
from gamutcore.decimation.candidates import CANDIDATES, Grid, write_candidate
from gamutcore.decimation.costs.dispatch import CostState, enter_level, error_at, find_optimum
from gamutcore.decimation.costs.parameters import MEMORYLESS
from gamutcore.decimation.edge_collapse import (
    COLLAPSES,
    ORDERED,
    PHASE,
    QUERIES,
    REQUEUED,
    ROOM,
    START,
    SWEEPING,
    Loop,
    Workspace,
    candidate_is_valid,
    collapse_edge,
    is_stale,
)
from gamutcore.decimation.edge_queue import dequeue, enqueue, fill_queue
from gamutcore.decimation.record import Record, has_room
from gamutcore.decimation.relaxation import relax
from gamutcore.decimation.star import LARGEST_LINK, Surface, link_condition_holds, write_edge_link
from gamutcore.decimation.sweeps import begin_sweeps, collapse_in_sweeps
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["PERTURBATION", "collapse_edges"]

PERTURBATION = 0.1
"""Largest relative perturbation of errors in a trial. From 0.03 to 0.3 the best of as many trials
is the same within the scatter."""

LARGE = 4.0
"""An edge with more than so many times the error of the cheapest one is not evaluated at once when
its link changes. It will hardly be the next one."""


@leaf_kernel
def _perturb(work: Workspace, edge: int, value: float) -> float:
    """Error of an edge in the present trial."""
    if work.perturbation.size == 0 or not abs(value) < np.inf:
        return value
    return value + PERTURBATION * abs(value) * work.perturbation[edge]


@leaf_kernel
def _requeue(
    state: CostState, surface: Surface, work: Workspace, edge: int, collapses: int
) -> None:
    """Queue an edge, or move it in the queue, with the error of its optimum."""
    if work.queue.heap_index[edge] < 0:
        work.parked[0] -= 1
    work.choice[edge], work.evaluated[edge] = 0, collapses
    value = find_optimum(state, surface, int(surface.corner_facing[edge]), work.point)
    enqueue(work.queue, edge, _perturb(work, edge, value))


@leaf_kernel
def _park(work: Workspace, edge: int) -> None:
    dequeue(work.queue, edge)
    work.parked[0] += 1


@leaf_kernel
def _queue_next_candidate(
    state: CostState, surface: Surface, work: Workspace, edge: int, count: int
) -> None:
    """Queue an edge with the error of its next candidate; park it if there is none."""
    corner = int(surface.corner_facing[edge])
    for choice in range(work.choice[edge] + 1, CANDIDATES):
        work.choice[edge] = choice
        if write_candidate(
            state, surface, corner, choice, work.link, count, work.gradient, work.point
        ):
            value = error_at(state, surface, corner, work.point)
            # an infinite error comes last, but may be the only way on
            if not np.isnan(value):
                value = _perturb(work, edge, value)
                enqueue(work.queue, edge, max(work.queue.priority[edge], value))
                return
    _park(work, edge)


@leaf_kernel
def _refresh(
    state: CostState,
    surface: Surface,
    work: Workspace,
    kept: int,
    collapses: int,
    in_order: bool,
) -> None:
    """Update the queue around a new vertex.

    With accumulated quadrics only the edges of the vertex have new errors. Otherwise the edges of
    its neighbours have as well. Near the end these are evaluated at once unless they were large,
    before that when they come to the front of the queue. Errors grow as faces do, so an old error
    is seldom too large. Parked edges of the neighbours return in any case.
    """
    queue = work.queue
    on_link = state.parameters.kind == MEMORYLESS
    work.changed[kept] = collapses
    eager = on_link and in_order and queue.size[0] > 0
    large = LARGE * abs(queue.priority[queue.heap[0]]) if eager else -np.inf
    eager = large >= 0.0
    first = int(surface.corner_at[kept])
    spoke = first
    while True:
        if not on_link:
            _requeue(
                state, surface, work, int(np.int64(surface.edge_of[preceding(spoke)])), collapses
            )
        neighbour = int(surface.vertex[following(spoke)])
        work.changed[neighbour] = collapses
        # links of such a vertex's edges are not evaluated, so their errors do not change
        few = surface.degree[neighbour] <= LARGEST_LINK
        if work.parked[0] > 0 or (eager and few):
            begin = int(surface.corner_at[neighbour])
            around = begin
            while True:
                edge = int(np.int64(surface.edge_of[preceding(around)]))
                if queue.heap_index[edge] < 0 or (
                    eager
                    and few
                    and queue.priority[edge] <= large
                    and work.evaluated[edge] < collapses
                ):
                    _requeue(state, surface, work, edge, collapses)
                around = int(surface.swung[around])
                if around == begin:
                    break
        spoke = int(surface.swung[spoke])
        if spoke == first:
            break


@leaf_kernel
def _queue_all(state: CostState, surface: Surface, work: Workspace, collapses: int) -> None:
    """Queue all edges, each with the error of its optimum."""
    queue, queued = work.queue, 0
    for edge in range(queue.heap_index.size):
        queue.heap_index[edge] = -1
        corner = int(surface.corner_facing[edge])
        if corner >= 0:
            value = find_optimum(state, surface, corner, work.point)
            queue.priority[edge] = _perturb(work, edge, value)
            work.choice[edge], work.evaluated[edge] = 0, collapses
            queue.heap[queued] = edge
            queued += 1
    fill_queue(queue, queued)
    work.parked[0] = 0


@kernel
def collapse_edges(
    state: CostState,
    surface: Surface,
    grid: Grid,
    record: Record,
    work: Workspace,
    loop: Loop,
    swept: int,
    wanted: int,
) -> bool:
    """Collapse edges, cheapest first.

    Parameters
    ----------
    state : CostState
    surface : Surface
        Left at the last level.
    grid : Grid
        Its positions follow those of the surface.
    record : Record
        Receives the collapses.
    work : Workspace
    loop : Loop
        Progress of the loop, updated. A call continues where the last one ended.
    swept : int
        Number of collapses to make in sweeps, before strict order begins.
    wanted : int
        Number of collapses to make in all.

    Returns
    -------
    bool
        False if the record has no room for `loop.counts[ROOM]` changes: extend it and call again.
        True if the wanted number is reached, or no edge can be collapsed validly.
    """
    counts = loop.counts
    if counts[PHASE] == START:
        enter_level(state, surface, len(grid.position))
        if swept > 0:
            begin_sweeps(state, surface, work, loop)
        counts[PHASE] = SWEEPING
    if counts[PHASE] == SWEEPING:
        if swept > 0 and not collapse_in_sweeps(state, surface, grid, record, work, loop, swept):
            counts[ROOM] = LARGEST_LINK
            return False
        if counts[COLLAPSES] < wanted:
            _queue_all(state, surface, work, counts[COLLAPSES])
        counts[REQUEUED] = counts[COLLAPSES]
        counts[PHASE] = ORDERED
    return _collapse_in_order(state, surface, grid, record, work, loop, wanted)


@leaf_kernel
def _collapse_in_order(
    state: CostState,
    surface: Surface,
    grid: Grid,
    record: Record,
    work: Workspace,
    loop: Loop,
    wanted: int,
) -> bool:
    """Collapse the cheapest edge repeatedly. Parameters and result as in `collapse_edges`."""
    parameters, queue, counts = state.parameters, work.queue, loop.counts
    on_link = parameters.kind == MEMORYLESS
    collapses, query = counts[COLLAPSES], counts[QUERIES]
    while collapses < wanted:
        if queue.size[0] == 0:
            # parked edges return if a collapse has changed anything since
            if collapses == counts[REQUEUED]:
                break
            _queue_all(state, surface, work, collapses)
            counts[REQUEUED] = collapses
            continue
        # int64, as in the sweeps, so that every kernel has one signature
        edge = int(np.int64(queue.heap[0]))
        if on_link and is_stale(surface, work, edge):
            _requeue(state, surface, work, edge, collapses)
            continue
        corner = int(surface.corner_facing[edge])
        kept = int(surface.vertex[following(corner)])
        dead = int(surface.vertex[preceding(corner)])
        query += 1
        if not link_condition_holds(surface, kept, dead, query):
            _park(work, edge)
            continue
        around = int(surface.degree[kept] + surface.degree[dead])
        if not has_room(record, collapses, around):
            counts[COLLAPSES], counts[QUERIES], counts[ROOM] = collapses, query, around
            return False
        count = write_edge_link(surface, kept, dead, work.link)
        if not candidate_is_valid(state, surface, grid, work, edge, count):
            _queue_next_candidate(state, surface, work, edge, count)
            continue
        kept = collapse_edge(state, surface, grid, record, work, edge, collapses)
        collapses += 1
        if parameters.moved_vertices > 0:
            relax(state, surface, grid, record, work, kept, collapses)
        if collapses == wanted:
            break
        left = len(grid.position) - collapses
        if enter_level(state, surface, left):
            _queue_all(state, surface, work, collapses)
        else:
            in_order = left - 4 < parameters.eager_collapses
            _refresh(state, surface, work, kept, collapses, in_order)
    counts[COLLAPSES], counts[QUERIES] = collapses, query
    return True
