"""The decimation kernel: the cheapest valid collapse, again and again, down to four triangles.

Data layout: a `Surface` (positions, corner table, edges), an indexed heap of edges, one byte per
edge that says which candidate position stands in the queue for it, and a `Record` that receives
every collapse. An edge is queued with the error of its first candidate (the cost's optimum). When
it comes to the front, that candidate is rounded to the precision that is delivered and tested; if
it is not valid, the edge goes back with the error of the next one. An edge with no valid
candidate is parked: it stays alive outside the queue and comes back when its ring changes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, Float32Array, FloatArray, IndexArray
from gamutcore.corner_table import following, preceding, swung
from gamutcore.decimation.candidates import (
    CANDIDATES,
    candidate,
    rounded_as_delivered,
    within_reach,
)
from gamutcore.decimation.costs.interface import depends_on_ring, error, merge, optimum
from gamutcore.decimation.edge_queue import EdgeQueue, dequeue, empty_queue, enqueue, fill_queue
from gamutcore.decimation.record import Record, record_moved_corners, write_collapse
from gamutcore.decimation.star import (
    Surface,
    keeps_star_shape,
    link_condition_holds,
    ring_faces,
)
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["collapse_all"]

EAGER_COLLAPSES = 2500
"""This many collapses before the end, errors that a collapse may have changed are evaluated at once
instead of when their edge comes to the front: with few faces left, the order matters most."""

HUB_DEGREE = 64
"""A vertex with more edges than this is a hub. A cost that depends on the ring visits all faces
around an edge, so evaluating the edges of a hub takes the square of their number: they wait at the
end of the queue until the hub has lost enough of them to collapses among its neighbours."""


class Workspace(NamedTuple):
    """What the kernel keeps beside the surface while it decimates.

    Attributes
    ----------
    queue : EdgeQueue
    choice : (E,) uint8
        The candidate that stands in the queue for an edge.
    stale : (E,) uint8
        1: the error in the queue is from before a change of the edge's ring.
    parked : (1,) int32
        Number of edges that are neither queued nor gone.
    place : (3,) float64
        The position at hand, relative to the centre.
    rounded : (3,) float32
        The same as it is delivered.
    """

    queue: EdgeQueue
    choice: ByteArray
    stale: ByteArray
    parked: IndexArray
    place: FloatArray
    rounded: Float32Array


@leaf_kernel
def _glue(surface: Surface, corner: int) -> int:
    """Close the gap that a vanishing face leaves, by joining its two outer neighbours.

    `corner` faces the collapsed edge; the corners outside the vanishing faces name the kept vertex
    already. Two edges fall together: the smaller id stays, the other is returned.
    """
    vertex, opposite = surface.vertex, surface.opposite
    one, two = opposite[following(corner)], opposite[preceding(corner)]
    opposite[one], opposite[two] = two, one
    for outer in (following(one), preceding(one)):
        surface.corner_at[vertex[outer]] = outer
    stays, goes = surface.edge_of[one], surface.edge_of[two]
    if goes < stays:
        stays, goes = goes, stays
    surface.edge_of[one] = stays
    surface.edge_of[two] = stays
    surface.corner_facing[stays] = one
    surface.corner_facing[goes] = -1
    return goes


@leaf_kernel
def _edge_ends(surface: Surface, edge: int) -> tuple[int, int]:
    """Ends of an edge in the order of its own corner, however the edge was reached."""
    corner = surface.corner_facing[edge]
    return surface.vertex[following(corner)], surface.vertex[preceding(corner)]


@leaf_kernel
def _error_of_optimum(cost: Any, surface: Surface, edge: int, place: FloatArray) -> float:  # noqa: ANN401
    """Priority of an edge: the error of its optimum, infinite for the edges of hubs."""
    one, two = _edge_ends(surface, edge)
    if depends_on_ring(cost) and max(surface.degree[one], surface.degree[two]) > HUB_DEGREE:
        return np.inf
    return optimum(cost, surface, one, two, place)


@leaf_kernel
def _requeue(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    edge: int,
) -> None:
    """Queue an edge, or move it, with the error of its optimum."""
    if work.queue.place[edge] < 0:
        work.parked[0] -= 1
    work.choice[edge], work.stale[edge] = 0, 0
    enqueue(work.queue, edge, _error_of_optimum(cost, surface, edge, work.place))


@leaf_kernel
def _park(work: Workspace, edge: int) -> None:
    dequeue(work.queue, edge)
    work.parked[0] += 1


@leaf_kernel
def _place_is_valid(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    edge: int,
    kept: int,
    dead: int,
    ring: IndexArray,
    count: int,
    centre: FloatArray,
    step: float,
) -> bool:
    """Write the place of an edge's present candidate, as delivered; False if it is not valid."""
    place, choice = work.place, work.choice[edge]
    if not candidate(cost, surface, kept, dead, choice, ring, count, place):
        return False
    # the last candidate may have to reach far: it is there so that no edge is lost
    if choice < CANDIDATES - 1 and not within_reach(
        surface.position, ring, count, kept, dead, place
    ):
        return False
    rounded_as_delivered(place, centre, step, work.rounded)
    return keeps_star_shape(surface.position, ring, count, place[0], place[1], place[2])


@leaf_kernel
def _queue_next_candidate(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    edge: int,
    kept: int,
    dead: int,
    ring: IndexArray,
    count: int,
) -> None:
    """Queue an edge with the error of its next candidate; park it if there is none."""
    while work.choice[edge] < CANDIDATES - 1:
        work.choice[edge] += 1
        if candidate(cost, surface, kept, dead, work.choice[edge], ring, count, work.place):
            value = error(cost, surface, kept, dead, work.place)
            if value < np.inf:
                enqueue(work.queue, edge, max(work.queue.priority[edge], value))
                return
    _park(work, edge)


@leaf_kernel
def _contract(
    surface: Surface,
    delivered: Float32Array,
    work: Workspace,
    edge: int,
    kept: int,
    dead: int,
    moved: IndexArray,
    start: int,
    end: int,
) -> None:
    """Collapse an edge: move the kept vertex, give it the moved corners, close the two gaps."""
    for axis in range(3):
        surface.position[kept, axis] = work.place[axis]
        delivered[kept, axis] = work.rounded[axis]
    for index in range(start, end):
        surface.vertex[moved[index]] = kept
    corner = surface.corner_facing[edge]
    twin = surface.opposite[corner]
    surface.degree[kept] += surface.degree[dead] - 4
    dequeue(work.queue, edge)
    surface.corner_facing[edge] = -1
    for side in (corner, twin):
        surface.degree[surface.vertex[side]] -= 1
        gone = _glue(surface, side)
        if work.queue.place[gone] < 0:
            work.parked[0] -= 1
        dequeue(work.queue, gone)


@leaf_kernel
def _refresh(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    kept: int,
    eager: bool,
) -> None:
    """Bring the queue up to date around a new vertex.

    Its own edges have new errors. So have, if the cost depends on the ring, the edges around its
    neighbours; there errors are evaluated now, if `eager`, else when their edge comes to the front:
    errors grow as faces do, so an old one is seldom too large. Parked edges around the neighbours,
    whose rings have changed, come back in any case.
    """
    opposite = surface.opposite
    first = surface.corner_at[kept]
    spoke = first
    while True:
        if not depends_on_ring(cost):
            _requeue(cost, surface, work, surface.edge_of[preceding(spoke)])
        neighbour = surface.vertex[following(spoke)]
        hub = depends_on_ring(cost) and surface.degree[neighbour] > HUB_DEGREE
        begin = surface.corner_at[neighbour]
        around = begin
        while work.parked[0] > 0 or (depends_on_ring(cost) and not hub):
            edge = surface.edge_of[preceding(around)]
            if work.queue.place[edge] < 0:
                _requeue(cost, surface, work, edge)
            elif depends_on_ring(cost) and not hub:
                if eager or work.queue.priority[edge] == np.inf:
                    _requeue(cost, surface, work, edge)
                else:
                    work.stale[edge] = 1
            around = swung(opposite, around)
            if around == begin:
                break
        spoke = swung(opposite, spoke)
        if spoke == first:
            break


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
        np.zeros(edges, np.uint8),
        np.zeros(1, np.int32),
        np.empty(3, np.float64),
        np.empty(3, np.float32),
    )
    ring = np.empty((64, 2), np.int32)
    moved, filled = record.moved, 0
    for edge in range(edges):
        work.queue.priority[edge] = _error_of_optimum(cost, surface, edge, work.place)
    fill_queue(work.queue)

    collapses, wanted, query = 0, len(delivered) - 4, 0
    while collapses < wanted and work.queue.size[0] > 0:
        edge = work.queue.heap[0]
        if depends_on_ring(cost) and work.stale[edge]:
            _requeue(cost, surface, work, edge)
            continue
        kept, dead = _edge_ends(surface, edge)
        query += 1
        if not link_condition_holds(surface, kept, dead, query):
            _park(work, edge)
            continue
        count = ring_faces(surface, kept, dead, ring)
        if count > len(ring):
            ring = np.empty((2 * count, 2), np.int32)
            ring_faces(surface, kept, dead, ring)
        if surface.degree[dead] > surface.degree[kept]:
            kept, dead = dead, kept
        if not _place_is_valid(cost, surface, work, edge, kept, dead, ring, count, centre, step):
            _queue_next_candidate(cost, surface, work, edge, kept, dead, ring, count)
            continue

        corner = surface.corner_facing[edge]
        write_collapse(record, collapses, surface, delivered, work.rounded, corner, kept, dead)
        start = filled
        moved, filled = record_moved_corners(surface, record.corner[collapses, 1], moved, filled)
        record.moved_end[collapses] = filled
        record.shifted_end[collapses] = 0
        merge(cost, surface, kept, dead, work.place)
        _contract(surface, delivered, work, edge, kept, dead, moved, start, filled)
        collapses += 1
        eager = depends_on_ring(cost) and wanted - collapses < EAGER_COLLAPSES
        _refresh(cost, surface, work, kept, eager)
    whole = Record(
        record.kept,
        record.dead,
        record.position,
        record.sides,
        record.corner,
        record.moved_end,
        moved[:filled],
        record.shifted_end,
        record.shifted[:0],
        record.shift[:0],
    )
    return collapses, whole
