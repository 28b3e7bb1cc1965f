"""The collapse loop: the cheapest valid collapse, repeatedly, down to a number of vertices.

Data layout: a `Stage` (surface, grid and state of the cost), a `Workspace` with an indexed heap of
edges, and a `Record` that receives every collapse. An edge is queued with the error of its first
candidate position, the optimum of the cost. At the front of the queue the candidate is rounded to
the grid and tested. If it is not valid, the edge is queued again with the error of its next
candidate. An edge without a valid candidate is parked: it stays outside the queue until its link
changes.
"""

from __future__ import annotations

import numpy as np

from gamutcore.corner_table import following, preceding
from gamutcore.decimation.candidates import CANDIDATES, write_candidate
from gamutcore.decimation.costs.dispatch import enter_level, error_at, find_optimum
from gamutcore.decimation.costs.parameters import MEMORYLESS
from gamutcore.decimation.edge_collapse import (
    Workspace,
    candidate_is_valid,
    collapse_edge,
    is_stale,
)
from gamutcore.decimation.edge_queue import dequeue, enqueue, fill_queue
from gamutcore.decimation.record import Record, has_room
from gamutcore.decimation.relaxation import relax
from gamutcore.decimation.stage import Stage
from gamutcore.decimation.star import (
    LARGEST_LINK,
    edge_ends,
    link_condition_holds,
    write_edge_link,
)
from gamutcore.decimation.sweeps import collapse_in_sweeps
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
def _optimum_error(stage: Stage, work: Workspace, edge: int) -> float:
    """Evaluate an edge: write its optimum and return the error of it in the present trial."""
    work.choice[edge], work.evaluated[edge] = 0, work.collapses[0]
    value = find_optimum(stage, int(stage.surface.corner_facing[edge]), work.point)
    return _perturb(work, edge, value)


@leaf_kernel
def _requeue(stage: Stage, work: Workspace, edge: int) -> None:
    """Queue an edge, or move it in the queue, with the error of its optimum."""
    if work.queue.heap_index[edge] < 0:
        work.parked[0] -= 1
    enqueue(work.queue, edge, _optimum_error(stage, work, edge))


@leaf_kernel
def _park(work: Workspace, edge: int) -> None:
    dequeue(work.queue, edge)
    work.parked[0] += 1


@leaf_kernel
def _queue_next_candidate(stage: Stage, work: Workspace, edge: int, count: int) -> None:
    """Queue an edge with the error of its next candidate; park it if there is none."""
    corner = int(stage.surface.corner_facing[edge])
    for choice in range(work.choice[edge] + 1, CANDIDATES):
        work.choice[edge] = choice
        if write_candidate(stage, corner, choice, work.link, count, work.point):
            value = error_at(stage, corner, work.point)
            # an infinite error comes last, but may be the only way on
            if not np.isnan(value):
                value = _perturb(work, edge, value)
                enqueue(work.queue, edge, max(work.queue.priority[edge], value))
                return
    _park(work, edge)


@leaf_kernel
def _refresh(stage: Stage, work: Workspace, kept: int, eager: bool) -> None:
    """Update the queue around a new vertex.

    With accumulated quadrics only the edges of the vertex have new errors; otherwise those of its
    neighbours have, too. If `eager`, the latter are evaluated at once unless they were large, else
    at the front of the queue: an old error is seldom too large. Parked edges of the neighbours
    return.
    """
    surface, queue, collapses = stage.surface, work.queue, work.collapses[0]
    on_link = stage.parameters.kind == MEMORYLESS
    work.changed[kept] = collapses
    large = -np.inf
    if eager and on_link and queue.size[0] > 0:
        large = LARGE * abs(queue.priority[queue.heap[0]])
    spoke = int(surface.corner_at[kept])
    for _ in range(surface.degree[kept]):
        if not on_link:
            _requeue(stage, work, int(surface.edge_of[preceding(spoke)]))
        neighbour = int(surface.vertex[following(spoke)])
        work.changed[neighbour] = collapses
        # links of such a vertex's edges are not evaluated, so their errors do not change
        limit = large if surface.degree[neighbour] <= LARGEST_LINK else -np.inf
        if work.parked[0] > 0 or limit >= 0.0:
            around = int(surface.corner_at[neighbour])
            for _ in range(surface.degree[neighbour]):
                edge = int(surface.edge_of[preceding(around)])
                changes = queue.priority[edge] <= limit and work.evaluated[edge] < collapses
                if queue.heap_index[edge] < 0 or changes:
                    _requeue(stage, work, edge)
                around = int(surface.swung[around])
        spoke = int(surface.swung[spoke])


@leaf_kernel
def _queue_all(stage: Stage, work: Workspace) -> None:
    """Queue all edges, each with the error of its optimum."""
    queue, queued = work.queue, 0
    for edge in range(queue.heap_index.size):
        queue.heap_index[edge] = -1
        if stage.surface.corner_facing[edge] >= 0:
            queue.priority[edge] = _optimum_error(stage, work, edge)
            queue.heap[queued] = edge
            queued += 1
    fill_queue(queue, queued)
    work.parked[0] = 0


@kernel
def collapse_edges(stage: Stage, record: Record, work: Workspace, swept: int, wanted: int) -> int:
    """Collapse edges, cheapest first, until `wanted` collapses are made; `swept` of them in sweeps.

    Sweeps come before strict order. A call continues after the collapses of the last one. The
    result is the number of changes that the record has no room for: extend it and call again. It is
    0 at the end, or if no edge can be collapsed validly.
    """
    enter_level(stage, len(stage.grid.position) - work.collapses[0])
    if work.collapses[0] < swept and not collapse_in_sweeps(stage, record, work, swept):
        return LARGEST_LINK
    return _collapse_in_order(stage, record, work, wanted)


@leaf_kernel
def _collapse_in_order(stage: Stage, record: Record, work: Workspace, wanted: int) -> int:
    """Collapse the cheapest edge repeatedly. Parameters and result as in `collapse_edges`."""
    surface, parameters, queue = stage.surface, stage.parameters, work.queue
    on_link, requeued = parameters.kind == MEMORYLESS, -1
    queue.size[0] = 0
    while work.collapses[0] < wanted:
        if queue.size[0] == 0:
            # parked edges return if a collapse has changed anything since
            if work.collapses[0] == requeued:
                break
            _queue_all(stage, work)
            requeued = work.collapses[0]
            continue
        edge = int(queue.heap[0])
        if on_link and is_stale(surface, work, edge):
            _requeue(stage, work, edge)
            continue
        _, kept, dead = edge_ends(surface, edge)
        if not link_condition_holds(surface, kept, dead):
            _park(work, edge)
            continue
        around = int(surface.degree[kept] + surface.degree[dead])
        if not has_room(record, work.collapses[0], around):
            return around
        count = write_edge_link(surface, kept, dead, work.link)
        if not candidate_is_valid(stage, work, edge, count):
            _queue_next_candidate(stage, work, edge, count)
            continue
        kept = collapse_edge(stage, record, work, edge)
        if parameters.moved_vertices > 0:
            relax(stage, record, work, kept)
        left = len(stage.grid.position) - work.collapses[0]
        if work.collapses[0] < wanted and enter_level(stage, left):
            _queue_all(stage, work)
        else:
            _refresh(stage, work, kept, left - 4 < parameters.eager_collapses)
    return 0
