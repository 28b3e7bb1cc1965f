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

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.corner_table import following, preceding, swung
from gamutcore.decimation.candidates import CANDIDATES, candidate
from gamutcore.decimation.costs.interface import (
    depends_on_ring,
    eager_collapses,
    error,
    moves_vertices,
    optimum,
    reach,
)
from gamutcore.decimation.edge_queue import dequeue, empty_queue, enqueue, fill_queue
from gamutcore.decimation.record import Record
from gamutcore.decimation.relaxation import relax
from gamutcore.decimation.star import Surface, link_condition_holds, ring_faces
from gamutcore.decimation.sweeps import SWEPT_DOWN_TO, collapse_in_sweeps
from gamutcore.decimation.workspace import (
    EXACT_ROUNDING,
    Workspace,
    collapse_edge,
    is_stale,
    place_is_valid,
)
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["collapse_all"]

HUB_DEGREE = 64
"""A vertex with more edges than this is a hub."""


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
    enqueue(work.queue, edge, optimum(cost, surface, surface.corner_facing[edge], work.place))


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
            if value < np.inf:
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
    neighbours; there errors are evaluated now, if `eager`, else when their edge comes to the front:
    errors grow as faces do, so an old one is seldom too large. Parked edges around the neighbours,
    whose rings have changed, come back in any case.
    """
    opposite = surface.opposite
    work.changed[kept] = collapses
    first = surface.corner_at[kept]
    spoke = first
    while True:
        if not depends_on_ring(cost):
            _requeue(cost, surface, work, surface.edge_of[preceding(spoke)], collapses)
        neighbour = surface.vertex[following(spoke)]
        work.changed[neighbour] = collapses
        # the edges of a hub are many and expensive, and evaluated when they come to the front
        hub = surface.degree[neighbour] > HUB_DEGREE
        if work.parked[0] > 0 or (depends_on_ring(cost) and eager and not hub):
            begin = surface.corner_at[neighbour]
            around = begin
            while True:
                edge = surface.edge_of[preceding(around)]
                if work.queue.place[edge] < 0 or (
                    depends_on_ring(cost) and eager and not hub and work.evaluated[edge] < collapses
                ):
                    _requeue(cost, surface, work, edge, collapses)
                around = swung(opposite, around)
                if around == begin:
                    break
        spoke = swung(opposite, spoke)
        if spoke == first:
            break


@leaf_kernel
def _queue_all(cost: Any, surface: Surface, work: Workspace, collapses: int) -> None:  # noqa: ANN401
    """Queue all edges that are left, each with the error of its optimum."""
    queue, queued = work.queue, 0
    for edge in range(queue.place.size):
        queue.place[edge] = -1
        corner = surface.corner_facing[edge]
        if corner >= 0:
            queue.priority[edge] = optimum(cost, surface, corner, work.place)
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
) -> tuple[int, Record]:
    """Collapse edges, cheapest first, until four faces are left.

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

    Returns
    -------
    collapses : int
        V − 4 if four faces were reached.
    record : Record
    """
    edges = surface.corner_facing.size
    work = Workspace(
        empty_queue(edges),
        np.zeros(edges, np.uint8),
        np.zeros(edges, np.int32),
        np.zeros(len(delivered), np.int32),
        np.zeros(1, np.int32),
        np.empty(3, np.float64),
        np.empty(3, np.float32),
        np.empty(3, np.float64),
    )
    moved, shifted, shift = record.moved, record.shifted, record.shift
    collapses, wanted, query = 0, len(delivered) - 4, 0
    reach(cost, surface, len(delivered))
    if depends_on_ring(cost) and wanted > SWEPT_DOWN_TO:
        for edge in range(edges):
            corner = surface.corner_facing[edge]
            work.queue.priority[edge] = optimum(cost, surface, corner, work.place)
        collapses, moved = collapse_in_sweeps(
            cost, surface, delivered, centre, step, record, work, moved, wanted - SWEPT_DOWN_TO
        )
    _queue_all(cost, surface, work, collapses)

    ring = np.empty((64, 2), np.int32)
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
        count = ring_faces(surface, kept, dead, ring)
        if count > len(ring):
            ring = np.empty((2 * count, 2), np.int32)
            ring_faces(surface, kept, dead, ring)
        exact = wanted - collapses < EXACT_ROUNDING
        if not place_is_valid(cost, surface, work, edge, ring, count, centre, step, exact):
            _queue_next_candidate(cost, surface, work, edge, ring, count)
            continue
        kept, moved = collapse_edge(cost, surface, delivered, record, work, edge, collapses, moved)
        collapses += 1
        shifts = record.shifted_end[collapses - 2] if collapses > 1 else 0
        if moves_vertices(cost):
            shifted, shift, shifts = relax(
                cost,
                surface,
                delivered,
                centre,
                step,
                record.position[collapses - 1, 2],
                work,
                kept,
                collapses,
                ring,
                shifted,
                shift,
                shifts,
            )
        record.shifted_end[collapses - 1] = shifts
        if reach(cost, surface, len(delivered) - collapses):
            _queue_all(cost, surface, work, collapses)
        else:
            eager = depends_on_ring(cost) and wanted - collapses < eager_collapses(cost)
            _refresh(cost, surface, work, kept, collapses, eager)
    shifts = record.shifted_end[collapses - 1] if collapses > 0 else 0
    whole = Record(
        record.kept,
        record.dead,
        record.position,
        record.sides,
        record.corner,
        record.moved_end,
        moved[: record.moved_end[collapses - 1]] if collapses > 0 else moved[:0],
        record.shifted_end,
        shifted[:shifts],
        shift[:shifts],
    )
    return collapses, whole
