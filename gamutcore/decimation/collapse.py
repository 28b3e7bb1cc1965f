"""The decimation kernel: the cheapest valid collapse, again and again, down to four triangles.

Data layout: a `Surface` (positions, corner table, edges), a `Workspace` with an indexed heap of
edges and one byte per edge that says which candidate position stands in the queue for it, and a
`Record` that receives every collapse. An edge is queued with the error of its first candidate (the
cost's optimum). When it comes to the front, that candidate is rounded to the precision that is
delivered and tested; if it is not valid, the edge goes back with the error of the next one. An edge
with no valid candidate is parked: it stays alive outside the queue and comes back when its ring
changes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray, LongArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.candidates import CANDIDATES, candidate
from gamutcore.decimation.costs.interface import (
    depends_on_ring,
    eager_collapses,
    error,
    moves_vertices,
    optimum,
    reach,
)
from gamutcore.decimation.edge_queue import dequeue, enqueue, fill_queue
from gamutcore.decimation.record import Record, has_room, in_use, with_room
from gamutcore.decimation.relaxation import relax
from gamutcore.decimation.star import Surface, link_condition_holds, ring_faces
from gamutcore.decimation.sweeps import SWEPT_DOWN_TO, begun_sweeps, collapse_in_sweeps
from gamutcore.decimation.workspace import (
    EXACT_ROUNDING,
    LONGEST_RING,
    Workspace,
    collapse_edge,
    is_stale,
    place_is_valid,
    workspace,
)
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["collapse_all"]

HUB_DEGREE = 64
"""A vertex with more edges than this is a hub."""

LARGE = 4.0
"""An edge whose error is so many times that of the cheapest one waits for its turn to be evaluated
again even where others do not: it will hardly become the next one."""

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
"""2⁶⁴ ÷ the golden ratio, which keeps small numbers from giving small hashes."""


@leaf_kernel
def _disturbed(work: Workspace, edge: int, value: float) -> float:
    """An error on the present way: up to a part of itself more, the same for an edge each time."""
    if work.way[1] == 0.0 or not abs(value) < np.inf:
        return value
    # SplitMix64 of the edge and the way (Steele, Lea & Flood, "Fast Splittable Pseudorandom Number
    # Generators", 2014)
    bits = (np.uint64(work.way[0]) << np.uint64(32)) + np.uint64(edge) + GOLDEN
    bits = (bits ^ (bits >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    bits ^= bits >> np.uint64(31)
    return value + work.way[1] * abs(value) * (np.float64(bits >> np.uint64(11)) * 2.0**-53)


@leaf_kernel
def _requeue(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    edge: int,
    collapses: int,
) -> None:
    """Queue an edge, or move it, with the error of its optimum."""
    if work.queue.place[edge] < 0:
        work.parked[0] -= 1
    work.choice[edge], work.evaluated[edge] = 0, collapses
    value = optimum(cost, surface, surface.corner_facing[edge], work.place)
    enqueue(work.queue, edge, _disturbed(work, edge, value))


@leaf_kernel
def _park(work: Workspace, edge: int) -> None:
    dequeue(work.queue, edge)
    work.parked[0] += 1


@leaf_kernel
def _queue_next_candidate(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    edge: int,
    ring: IndexArray,
    count: int,
) -> None:
    """Queue an edge with the error of its next candidate; park it if there is none."""
    corner = surface.corner_facing[edge]
    while work.choice[edge] < CANDIDATES - 1:
        work.choice[edge] += 1
        choice = work.choice[edge]
        if candidate(cost, surface, corner, choice, ring, count, work.slope, work.place):
            value = error(cost, surface, corner, work.place)
            # an infinite one comes last: it may be the only way on
            if not np.isnan(value):
                value = _disturbed(work, edge, value)
                enqueue(work.queue, edge, max(work.queue.priority[edge], value))
                return
    _park(work, edge)


@leaf_kernel
def _refresh(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    kept: int,
    collapses: int,
    eager: bool,
) -> None:
    """Bring the queue up to date around a new vertex.

    Its own edges have new errors. So have, if the cost depends on the ring, the edges around its
    neighbours; there errors are evaluated now, if `eager` and they were not large, else when their
    edge comes to the front: errors grow as faces do, so an old one is seldom too large. Parked
    edges around the neighbours, whose rings have changed, come back in any case.
    """
    work.changed[kept] = collapses
    # of edges below which errors are evaluated again at once
    large = -np.inf
    if depends_on_ring(cost) and eager and work.queue.size[0] > 0:
        large = LARGE * abs(work.queue.priority[work.queue.heap[0]])
    first = surface.corner_at[kept]
    spoke = first
    while True:
        if not depends_on_ring(cost):
            _requeue(cost, surface, work, surface.edge_of[preceding(spoke)], collapses)
        neighbour = surface.vertex[following(spoke)]
        work.changed[neighbour] = collapses
        # the edges of a hub are many and expensive, and evaluated when they come to the front
        hub = surface.degree[neighbour] > HUB_DEGREE
        if work.parked[0] > 0 or (depends_on_ring(cost) and large >= 0.0 and not hub):
            begin = surface.corner_at[neighbour]
            around = begin
            while True:
                edge = surface.edge_of[preceding(around)]
                if work.queue.place[edge] < 0 or (
                    depends_on_ring(cost)
                    and not hub
                    and work.queue.priority[edge] <= large
                    and work.evaluated[edge] < collapses
                ):
                    _requeue(cost, surface, work, edge, collapses)
                around = surface.swung[around]
                if around == begin:
                    break
        spoke = surface.swung[spoke]
        if spoke == first:
            break


@leaf_kernel
def _unpark_beyond(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    kept: int,
    collapses: int,
) -> None:
    """Bring parked edges back whose rings have changed since neighbours of a new vertex moved.

    These are edges of the neighbours' neighbours.
    """
    first = surface.corner_at[kept]
    spoke = first
    while True:
        begin = surface.corner_at[surface.vertex[following(spoke)]]
        around = begin
        while True:
            last = surface.corner_at[surface.vertex[following(around)]]
            at = last
            while True:
                edge = surface.edge_of[preceding(at)]
                if work.queue.place[edge] < 0 and is_stale(surface, work, edge):
                    _requeue(cost, surface, work, edge, collapses)
                at = surface.swung[at]
                if at == last:
                    break
            around = surface.swung[around]
            if around == begin:
                break
        spoke = surface.swung[spoke]
        if spoke == first:
            break


@leaf_kernel
def _queue_all(cost: Any, surface: Surface, work: Workspace, collapses: int) -> None:  # noqa: ANN401
    """Queue all edges that are left, each with the error of its optimum."""
    queue, queued = work.queue, 0
    keeps = collapses == 0 and work.known.size > 0
    for edge in range(queue.place.size):
        queue.place[edge] = -1
        corner = surface.corner_facing[edge]
        if corner >= 0:
            value = work.known[edge] if keeps else np.nan
            if np.isnan(value):
                value = optimum(cost, surface, corner, work.place)
                if keeps:
                    work.known[edge] = value
            queue.priority[edge] = _disturbed(work, edge, value)
            work.choice[edge], work.evaluated[edge] = 0, collapses
            queue.heap[queued] = edge
            queued += 1
    fill_queue(queue, queued)
    work.parked[0] = 0


@kernel
def collapse_all(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    delivered: Float32Array,
    centre: FloatArray,
    step: float,
    record: Record,
    done: LongArray,
    way: FloatArray,
    known: FloatArray,
    until: int,
    sweeping: bool,
) -> Record:
    """Collapse edges, cheapest first, until so many vertices are left.

    Parameters
    ----------
    cost : NamedTuple of arrays
        State of one of `costs`.
    surface : Surface
        Left in the state of the last level.
    delivered : (V, 3) float32
        The positions as delivered; kept up to date with the surface.
    centre : (3,) float64
    step : float
        Of the grid that positions are rounded to.
    record : Record
        Receives the collapses; what it has no room for goes into the one that is returned.
    done : (1,) int64
        Counts up with each collapse.
    way : (2,) float64
        The number of a way, and by what part of themselves errors are disturbed on it, at most.
    known : (E,) or (0,) float64
        Errors of the edges before the first collapse, as far as they are known, else NaN: written.
        Without room for them they are not kept.
    until : int
        Vertices to leave: 4 or more.
    sweeping : bool
        Whether the fine end, down to `SWEPT_DOWN_TO` vertices, may be taken in sweeps.

    Returns
    -------
    Record
        The collapses that have been made: V − `until` if there were so many valid ones.
    """
    wanted = len(delivered) - until
    work = workspace(surface.corner_facing.size, len(delivered), done, way, known)
    ring = np.empty((LONGEST_RING, 2), np.int32)
    collapses = 0
    reach(cost, surface, len(delivered))
    swept = len(delivered) - max(until, SWEPT_DOWN_TO)
    if depends_on_ring(cost) and sweeping and swept > 0:
        sweeps = begun_sweeps(cost, surface, work)
        while not collapse_in_sweeps(
            cost,
            surface,
            delivered,
            centre,
            step,
            record,
            work,
            sweeps,
            ring,
            swept,
        ):
            record = with_room(record, sweeps.counts[0], len(ring))
        collapses = sweeps.counts[0]
    counts = np.array([collapses, 0, 0])
    if collapses < wanted:
        _queue_all(cost, surface, work, collapses)
    while not _collapse_in_order(
        cost, surface, delivered, centre, step, record, work, ring, counts, wanted
    ):
        if counts[2] > len(ring):
            ring = np.empty((2 * counts[2], 2), np.int32)
        record = with_room(record, counts[0], counts[2])
    return in_use(record, counts[0])


@leaf_kernel
def _collapse_in_order(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    delivered: Float32Array,
    centre: FloatArray,
    step: float,
    record: Record,
    work: Workspace,
    ring: IndexArray,
    counts: LongArray,
    wanted: int,
) -> bool:
    """Collapse the cheapest edge, again and again; False if the next one needs more room.

    Parameters
    ----------
    cost, surface, delivered, centre, step, record
        As for `collapse_all`.
    work : Workspace
        With all edges queued.
    ring : (m, 2) int32
        Scratch.
    counts : (3,) int64
        Collapses so far and queries, brought up to date; written: edges around the next one, where
        there is no room for as many pairs in `ring` or changes in the record.
    wanted : int
        Collapses to make.

    Returns
    -------
    bool
    """
    collapses, query = counts[0], counts[1]
    while collapses < wanted and work.queue.size[0] > 0:
        edge = work.queue.heap[0]
        if depends_on_ring(cost) and is_stale(surface, work, edge):
            _requeue(cost, surface, work, edge, collapses)
            continue
        corner = surface.corner_facing[edge]
        kept, dead = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
        query += 1
        if not link_condition_holds(surface, kept, dead, query):
            _park(work, edge)
            continue
        around = surface.degree[kept] + surface.degree[dead]
        if around > len(ring) or not has_room(record, collapses, around):
            counts[0], counts[1], counts[2] = collapses, query, around
            return False
        count = ring_faces(surface, kept, dead, ring)
        exact = len(delivered) - collapses - 4 < EXACT_ROUNDING
        if not place_is_valid(cost, surface, work, edge, ring, count, centre, step, exact):
            _queue_next_candidate(cost, surface, work, edge, ring, count)
            continue
        kept = collapse_edge(cost, surface, delivered, record, work, edge, collapses)
        collapses += 1
        if moves_vertices(cost):
            relax(cost, surface, delivered, centre, step, record, work, kept, collapses, ring)
        if collapses == wanted:
            break
        left = len(delivered) - collapses - 4
        if reach(cost, surface, left + 4):
            _queue_all(cost, surface, work, collapses)
        else:
            eager = depends_on_ring(cost) and left < eager_collapses(cost)
            _refresh(cost, surface, work, kept, collapses, eager)
            if moves_vertices(cost) and work.parked[0] > 0:
                _unpark_beyond(cost, surface, work, kept, collapses)
    counts[0] = collapses
    return True
