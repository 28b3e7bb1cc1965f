"""The fine end of a decimation in sweeps: edges in the order of memory, below a rising limit.

In strict order the cheapest edge lies somewhere in memory, and each collapse waits for it. Among
hundreds of thousands of nearly equal edges the order hardly matters, and edges that are near in
memory are near on the surface (`modified_convex_hull` orders them so). A sweep of all edges still
fetches all of them from far away for the few collapses that it makes, so a block of them that the
cache holds is swept several times, each time below a higher limit, before it is the next one's
turn.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray, LongArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.costs.interface import optimum, reach
from gamutcore.decimation.record import Record, has_room
from gamutcore.decimation.star import Surface, link_condition_holds, ring_faces
from gamutcore.decimation.workspace import (
    Workspace,
    collapse_edge,
    is_stale,
    mark_changed,
    rounded_place_is_valid,
)
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["SWEPT_DOWN_TO", "Sweeps", "begun_sweeps", "collapse_in_sweeps"]

SWEPT_DOWN_TO = 6000
"""Vertices with which strict order begins."""

SWEEP_RATIO = 1.7
"""How much the limit rises from sweep to sweep."""

FIRST_SWEEP = 16
"""The first limit leaves one in so many edges below it."""

SAMPLED = 16
"""One in so many edges counts for that."""

BLOCK = 4096
"""Edges that are swept several times before the next ones are: the cache holds what they need."""

SWEEPS_OF_BLOCK = 3
"""How often, each time below a higher limit."""

WHOLE = 2.5
"""Levels with fewer vertices than so many times those of the last one are swept as a whole: the
last limit has to be reached everywhere."""


class Sweeps(NamedTuple):
    """How far the sweeps are.

    Attributes
    ----------
    counts : (6,) int64
        Collapses so far; queries; the round, and of it the first edge of the block at hand and how
        often that was swept; 1 when all errors have changed.
    limit : (1,) float64
        Above which the limits of the round begin.
    """

    counts: LongArray
    limit: FloatArray


@kernel
def begun_sweeps(cost: Any, surface: Surface, work: Workspace) -> Sweeps:  # noqa: ANN401
    """Return where the sweeps begin."""
    some = np.empty(surface.corner_facing.size // SAMPLED + 1)
    _sample_errors(cost, surface, work, some)
    counts = np.zeros(6, np.int64)
    counts[1] = -1  # marks begin with −1, and the queries of the strict order count up from 1
    return Sweeps(counts, np.full(1, np.sort(some)[some.size // FIRST_SWEEP] / SWEEP_RATIO))


@leaf_kernel
def _sample_errors(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    some: FloatArray,
) -> None:
    """Write the errors of edges from all over the surface."""
    for index in range(some.size):
        edge = min(SAMPLED * index, surface.corner_facing.size - 1)
        some[index] = optimum(cost, surface, surface.corner_facing[edge], work.place)


@leaf_kernel
def _evaluate(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    begin: int,
    end: int,
    collapses: int,
) -> None:
    """Evaluate some of the edges."""
    for edge in range(begin, end):
        corner = surface.corner_facing[edge]
        if corner >= 0:
            work.queue.priority[edge] = optimum(cost, surface, corner, work.place)
            work.evaluated[edge] = collapses


@leaf_kernel
def collapse_in_sweeps(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    delivered: Float32Array,
    centre: FloatArray,
    step: float,
    record: Record,
    work: Workspace,
    sweeps: Sweeps,
    ring: IndexArray,
    wanted: int,
) -> bool:
    """Collapse edges below a rising limit of the error, in their order in memory.

    Parameters
    ----------
    cost, surface, delivered, centre, step, record
        As for `collapse_all`.
    work : Workspace
    sweeps : Sweeps
        Brought up to date.
    ring : (m, 2) int32
        Scratch; edges with longer rings wait.
    wanted : int
        Collapses to make.

    Returns
    -------
    bool
        False if the record has no room for another collapse: to be called again with more. True if
        there are as many collapses as are wanted, or all errors have changed, or no edge is left
        that can be collapsed.
    """
    counts, edges = sweeps.counts, work.queue.priority.size
    whole = WHOLE * (len(delivered) - wanted)
    while counts[0] < wanted:
        before = counts[0]
        several = len(delivered) - before > whole
        times = SWEEPS_OF_BLOCK if several else 1
        # in each round there are fewer edges in as much memory
        block = BLOCK << min(counts[2], 16) if several else edges
        while counts[3] < edges:
            begin, end = counts[3], min(counts[3] + block, edges)
            if counts[2] == 0 and counts[4] == 0:
                _evaluate(cost, surface, work, begin, end, counts[0])
            while counts[4] < times:
                limit = sweeps.limit[0] * SWEEP_RATIO ** (counts[4] + 1)
                if not _sweep(
                    cost,
                    surface,
                    delivered,
                    centre,
                    step,
                    record,
                    work,
                    counts,
                    ring,
                    wanted,
                    begin,
                    end,
                    limit,
                ):
                    return False
                if counts[0] == wanted or counts[5] == 1:
                    return True
                counts[4] += 1
            counts[3], counts[4] = end, 0
        counts[2], counts[3] = counts[2] + 1, 0
        if counts[0] == before and not sweeps.limit[0] < np.inf:
            break
        sweeps.limit[0] *= SWEEP_RATIO**times
    return True


@leaf_kernel
def _sweep(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    delivered: Float32Array,
    centre: FloatArray,
    step: float,
    record: Record,
    work: Workspace,
    counts: LongArray,
    ring: IndexArray,
    wanted: int,
    begin: int,
    end: int,
    limit: float,
) -> bool:
    """Sweep some of the edges once; False if the record has no room for another collapse."""
    priority = work.queue.priority
    collapses, query = counts[0], counts[1]
    room = True
    for edge in range(begin, end):
        corner = surface.corner_facing[edge]
        if corner < 0 or priority[edge] > limit:
            continue
        stale = is_stale(surface, work, edge)
        if stale:
            work.evaluated[edge] = collapses
            priority[edge] = optimum(cost, surface, corner, work.place)
            if priority[edge] > limit:
                continue
        kept, dead = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
        query -= 1
        if not link_condition_holds(surface, kept, dead, query):
            continue
        count = ring_faces(surface, kept, dead, ring)
        if count > len(ring):
            continue
        if not stale:
            optimum(cost, surface, corner, work.place)
        if not rounded_place_is_valid(
            cost, surface, work, corner, 0, ring, count, centre, step, False
        ):
            continue
        room = has_room(record, collapses, count)
        if not room:
            break
        kept = collapse_edge(cost, surface, delivered, record, work, edge, collapses)
        collapses += 1
        mark_changed(surface, work, kept, collapses)
        if collapses == wanted:
            break
        if reach(cost, surface, len(delivered) - collapses):
            counts[5] = 1
            break
    counts[0], counts[1] = collapses, query
    return room
