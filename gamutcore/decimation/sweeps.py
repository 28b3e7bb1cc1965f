"""The fine levels in sweeps: edges in the order of memory, below a rising limit of their error.

In strict order the cheapest edge lies anywhere in memory, and each collapse waits for it. Among
hundreds of thousands of nearly equal edges the order hardly matters. Edges that are near in memory
are near on the surface, because `modified_convex_hull` orders them so. One sweep makes few
collapses, so a block of edges that fits the cache is swept several times with rising limits before
the next block.
"""

from __future__ import annotations

import numpy as np

from gamutcore.decimation.costs.dispatch import find_optimum
from gamutcore.decimation.edge_collapse import (
    Workspace,
    collapse_edge,
    is_stale,
    mark_changed,
    rounded_point_is_valid,
)
from gamutcore.decimation.edge_queue import dequeue, fill_queue
from gamutcore.decimation.record import Record, has_room
from gamutcore.decimation.stage import Stage
from gamutcore.decimation.star import (
    LARGEST_LINK,
    edge_ends,
    link_condition_holds,
    write_edge_link,
)
from gamutcore.kernels import leaf_kernel

__all__ = ["collapse_in_sweeps"]

RATIO = 1.7
"""Ratio of the limits of consecutive sweeps."""

FIRST_PART = 16
"""The first limit lies above the errors of one in so many edges."""

SAMPLED = 16
"""One in so many edges is evaluated to find that limit."""

BLOCK = 4096
"""Number of edges of a block in the first round: the cache holds their data."""

SWEEPS_PER_BLOCK = 3
"""Number of sweeps of a block in each round."""

WHOLE = 2.5
"""Levels of at most so many times the vertices of the last swept level form a single block, because
the last limit has to be reached everywhere."""


@leaf_kernel
def _evaluate(stage: Stage, work: Workspace, edge: int) -> bool:
    """Write the optimum of an edge and its error; False if the edge has been removed."""
    corner = int(stage.surface.corner_facing[edge])
    if corner < 0:
        return False
    work.queue.priority[edge] = find_optimum(stage, corner, work.point)
    work.evaluated[edge] = work.collapses[0]
    return True


@leaf_kernel
def _first_limit(stage: Stage, work: Workspace) -> float:
    """Quantile of the errors of edges from all over the surface, found by the empty queue."""
    queue, sampled = work.queue, 0
    for edge in range(0, stage.surface.corner_facing.size, SAMPLED):
        if _evaluate(stage, work, edge):
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
def collapse_in_sweeps(stage: Stage, record: Record, work: Workspace, wanted: int) -> bool:
    """Collapse edges below a rising limit of the error, in the order of memory.

    The queue is empty before and after. The result is False if the record has no room for another
    collapse. It is True if `wanted` collapses are made, or no edge can be collapsed.
    """
    edges, vertices = work.queue.priority.size, len(stage.grid.position)
    limit = _first_limit(stage, work)
    block, first = BLOCK, True
    while work.collapses[0] < wanted:
        before, times = work.collapses[0], SWEEPS_PER_BLOCK
        if vertices - before <= WHOLE * (vertices - wanted):
            block, times = edges, 1
        for begin in range(0, edges, block):
            end = min(begin + block, edges)
            if first:
                for edge in range(begin, end):
                    _evaluate(stage, work, edge)
            higher = limit
            for _ in range(times):
                if not _sweep(stage, record, work, wanted, begin, end, higher):
                    return False
                higher *= RATIO
        if work.collapses[0] == before and not limit < np.inf:
            break
        for _ in range(times):
            limit *= RATIO
        # in each round there are fewer edges in the same memory
        block, first = min(2 * block, edges), False
    return True


@leaf_kernel
def _sweep(
    stage: Stage,
    record: Record,
    work: Workspace,
    wanted: int,
    begin: int,
    end: int,
    limit: float,
) -> bool:
    """Sweep a block of edges once; False if the record has no room for another collapse."""
    surface, priority = stage.surface, work.queue.priority
    for edge in range(begin, end):
        if surface.corner_facing[edge] < 0 or priority[edge] > limit:
            continue
        stale = is_stale(surface, work, edge)
        if stale:
            _evaluate(stage, work, edge)
            if priority[edge] > limit:
                continue
        corner, kept, dead = edge_ends(surface, edge)
        # the two faces at the edge count once for each end
        count = int(surface.degree[kept] + surface.degree[dead] - 4)
        if count > LARGEST_LINK or not link_condition_holds(surface, kept, dead):
            continue
        write_edge_link(surface, kept, dead, work.link)
        if not stale:
            find_optimum(stage, corner, work.point)
        if not rounded_point_is_valid(stage, work, count):
            continue
        if work.collapses[0] == wanted:
            break
        if not has_room(record, work.collapses[0], count):
            return False
        mark_changed(surface, work, collapse_edge(stage, record, work, edge))
    return True
