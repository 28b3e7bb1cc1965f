"""The fine levels in sweeps: edges in the order of memory, below a rising limit of their error.

In strict order the cheapest edge lies anywhere in memory, and each collapse waits for it. Among
hundreds of thousands of nearly equal edges the order hardly matters, and edges that are near in
memory are near on the surface (`modified_convex_hull` orders them so). One sweep makes few
collapses, so a block of edges that fits the cache is swept several times with rising limits before
the next block.
"""

from __future__ import annotations

import numpy as np

from gamutcore.corner_table import following, preceding
from gamutcore.decimation.candidates import Grid
from gamutcore.decimation.costs.dispatch import CostState, enter_level, find_optimum
from gamutcore.decimation.edge_collapse import (
    BLOCK_BEGIN,
    BLOCK_SWEEPS,
    COLLAPSES,
    ERRORS_CHANGED,
    QUERIES,
    ROUND,
    Loop,
    Workspace,
    collapse_edge,
    is_stale,
    mark_changed,
    rounded_point_is_valid,
)
from gamutcore.decimation.edge_queue import dequeue, fill_queue
from gamutcore.decimation.record import Record, has_room
from gamutcore.decimation.star import LARGEST_LINK, Surface, link_condition_holds, write_edge_link
from gamutcore.kernels import leaf_kernel

__all__ = ["begin_sweeps", "collapse_in_sweeps"]

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
def begin_sweeps(state: CostState, surface: Surface, work: Workspace, loop: Loop) -> None:
    """Set the first limit: a quantile of the errors of edges from all over the surface.

    Parameters
    ----------
    state : CostState
    surface : Surface
    work : Workspace
        Its queue is empty before and after.
    loop : Loop
        Its limit is written.
    """
    queue, edges = work.queue, surface.corner_facing.size
    sampled = edges // SAMPLED + 1
    for index in range(sampled):
        edge = min(SAMPLED * index, edges - 1)
        value = find_optimum(state, surface, int(surface.corner_facing[edge]), work.point)
        queue.priority[edge] = value if value < np.inf else np.inf  # noqa: FURB136  # NaN too
        queue.heap[index] = edge
    fill_queue(queue, sampled)
    for _ in range(sampled // FIRST_PART):
        dequeue(queue, int(np.int64(queue.heap[0])))
    loop.limit[0] = queue.priority[queue.heap[0]] / RATIO
    for index in range(queue.size[0]):
        queue.heap_index[queue.heap[index]] = -1
    queue.size[0] = 0


@leaf_kernel
def _evaluate(
    state: CostState, surface: Surface, work: Workspace, begin: int, end: int, collapses: int
) -> None:
    """Evaluate the edges of a block."""
    for edge in range(begin, end):
        corner = int(surface.corner_facing[edge])
        if corner >= 0:
            work.queue.priority[edge] = find_optimum(state, surface, corner, work.point)
            work.evaluated[edge] = collapses


@leaf_kernel
def collapse_in_sweeps(
    state: CostState,
    surface: Surface,
    grid: Grid,
    record: Record,
    work: Workspace,
    loop: Loop,
    wanted: int,
) -> bool:
    """Collapse edges below a rising limit of the error, in the order of memory.

    Parameters
    ----------
    state, surface, grid, record, work
        As in `collapse_edges`.
    loop : Loop
        Updated.
    wanted : int
        Number of collapses to make.

    Returns
    -------
    bool
        False if the record has no room for another collapse; call again with more room. True if the
        wanted number is reached, the errors of all edges have changed, or no edge can be collapsed.
    """
    counts, edges = loop.counts, work.queue.priority.size
    whole = WHOLE * (len(grid.position) - wanted)
    while counts[COLLAPSES] < wanted:
        before = counts[COLLAPSES]
        in_blocks = len(grid.position) - before > whole
        times = SWEEPS_PER_BLOCK if in_blocks else 1
        # in each round there are fewer edges in the same memory
        block = BLOCK << min(counts[ROUND], 16) if in_blocks else edges
        while counts[BLOCK_BEGIN] < edges:
            begin, end = counts[BLOCK_BEGIN], min(counts[BLOCK_BEGIN] + block, edges)
            if counts[ROUND] == 0 and counts[BLOCK_SWEEPS] == 0:
                _evaluate(state, surface, work, begin, end, counts[COLLAPSES])
            while counts[BLOCK_SWEEPS] < times:
                limit = loop.limit[0] * RATIO ** (counts[BLOCK_SWEEPS] + 1)
                if not _sweep(state, surface, grid, record, work, loop, wanted, begin, end, limit):
                    return False
                if counts[COLLAPSES] == wanted or counts[ERRORS_CHANGED] == 1:
                    return True
                counts[BLOCK_SWEEPS] += 1
            counts[BLOCK_BEGIN], counts[BLOCK_SWEEPS] = end, 0
        counts[ROUND], counts[BLOCK_BEGIN] = counts[ROUND] + 1, 0
        if counts[COLLAPSES] == before and not loop.limit[0] < np.inf:
            break
        loop.limit[0] *= RATIO**times
    return True


@leaf_kernel
def _sweep(
    state: CostState,
    surface: Surface,
    grid: Grid,
    record: Record,
    work: Workspace,
    loop: Loop,
    wanted: int,
    begin: int,
    end: int,
    limit: float,
) -> bool:
    """Sweep a block of edges once; False if the record has no room for another collapse."""
    priority, counts = work.queue.priority, loop.counts
    collapses, query = counts[COLLAPSES], counts[QUERIES]
    room = True
    for edge in range(begin, end):
        corner = int(surface.corner_facing[edge])
        if corner < 0 or priority[edge] > limit:
            continue
        stale = is_stale(surface, work, edge)
        if stale:
            work.evaluated[edge] = collapses
            priority[edge] = find_optimum(state, surface, corner, work.point)
            if priority[edge] > limit:
                continue
        kept = int(surface.vertex[following(corner)])
        dead = int(surface.vertex[preceding(corner)])
        query += 1
        if not link_condition_holds(surface, kept, dead, query):
            continue
        # the two faces at the edge count once for each end
        count = surface.degree[kept] + surface.degree[dead] - 4
        if count > LARGEST_LINK:
            continue
        count = write_edge_link(surface, kept, dead, work.link)
        if not stale:
            find_optimum(state, surface, corner, work.point)
        if not rounded_point_is_valid(surface, grid, work, count):
            continue
        room = has_room(record, collapses, count)
        if not room:
            break
        kept = collapse_edge(state, surface, grid, record, work, edge, collapses)
        collapses += 1
        mark_changed(surface, work, kept, collapses)
        if collapses == wanted:
            break
        if enter_level(state, surface, len(grid.position) - collapses):
            counts[ERRORS_CHANGED] = 1
            break
    counts[COLLAPSES], counts[QUERIES] = collapses, query
    return room
