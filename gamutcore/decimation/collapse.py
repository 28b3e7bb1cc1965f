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
    rounded_to_volume,
    within_reach,
)
from gamutcore.decimation.costs.interface import (
    depends_on_ring,
    error,
    improve,
    merge,
    moves_vertices,
    optimum,
    preserves_volume,
    reach,
    settle,
)
from gamutcore.decimation.edge_queue import EdgeQueue, dequeue, empty_queue, enqueue, fill_queue
from gamutcore.decimation.record import Record, record_moved_corners, record_shift, write_collapse
from gamutcore.decimation.star import (
    Surface,
    keeps_star_shape,
    link_condition_holds,
    ring_faces,
    star_volume,
    vertex_ring,
    volume_slope,
)
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["collapse_all"]

EAGER_COLLAPSES = 2500
"""This many collapses before the end, errors that a collapse may have changed are evaluated at once
instead of when their edge comes to the front: with few faces left, the order matters most."""

EXACT_ROUNDING = 2000
"""This many collapses before the end, costs that preserve the volume have their positions rounded to
the corner of the grid's cell that preserves it best: fewer vertices carry more of it each."""


RELAXATIONS = 2
"""How often the vertices around a collapse are gone through to move them, at most."""

SWEPT_DOWN_TO = 20_000
"""Collapses before the end at which strict order begins. Before that, the cheapest edge lies somewhere
in memory and each collapse waits for it; a cost that may be evaluated late is swept instead: edges
are taken in the order of memory, all that are below a limit, and the limit rises."""

SWEEP_RATIO = 1.4
"""How much the limit rises from sweep to sweep."""

FIRST_SWEEP = 16
"""The first limit leaves one in so many edges below it."""


class Workspace(NamedTuple):
    """What the kernel keeps beside the surface while it decimates.

    Attributes
    ----------
    queue : EdgeQueue
    choice : (E,) uint8
        The candidate that stands in the queue for an edge.
    evaluated : (E,) int32
        Number of collapses before the edge's error was evaluated.
    changed : (V,) int32
        Number of collapses after which a vertex had other faces than before.
    parked : (1,) int32
        Number of edges that are neither queued nor gone.
    place : (3,) float64
        The position at hand, relative to the centre.
    rounded : (3,) float32
        The same as it is delivered.
    slope : (3,) float64
        Scratch: how the volume depends on the position at hand.
    """

    queue: EdgeQueue
    choice: ByteArray
    evaluated: IndexArray
    changed: IndexArray
    parked: IndexArray
    place: FloatArray
    rounded: Float32Array
    slope: FloatArray


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
def _is_stale(surface: Surface, work: Workspace, edge: int) -> bool:
    """Whether the faces around an edge have changed since its error was evaluated."""
    corner, since = surface.corner_facing[edge], work.evaluated[edge]
    return (
        work.changed[surface.vertex[following(corner)]] > since
        or work.changed[surface.vertex[preceding(corner)]] > since
    )


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
def _place_is_valid(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    edge: int,
    ring: IndexArray,
    count: int,
    centre: FloatArray,
    step: float,
    exact: bool,
) -> bool:
    """Write the place of an edge's present candidate, as delivered; False if it is not valid."""
    place, choice, corner = work.place, work.choice[edge], surface.corner_facing[edge]
    if not candidate(cost, surface, corner, choice, ring, count, work.slope, place):
        return False
    kept, dead = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    # the last candidate may have to reach far: it is there so that no edge is lost
    if choice < CANDIDATES - 1 and not within_reach(
        surface.position, ring, count, kept, dead, place
    ):
        return False
    if preserves_volume(cost) and exact:
        volume_slope(surface.position, ring, count, work.slope)
        volume = star_volume(surface, kept, dead) + surface.deficit[0]
        rounded_to_volume(place, centre, step, work.slope, volume, work.rounded)
    else:
        rounded_as_delivered(place, centre, step, work.rounded)
    return keeps_star_shape(surface.position, ring, count, place[0], place[1], place[2])


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
        if work.parked[0] > 0 or (depends_on_ring(cost) and eager):
            begin = surface.corner_at[neighbour]
            around = begin
            while True:
                edge = surface.edge_of[preceding(around)]
                if work.queue.place[edge] < 0 or (
                    depends_on_ring(cost) and eager and work.evaluated[edge] < collapses
                ):
                    _requeue(cost, surface, work, edge, collapses)
                around = swung(opposite, around)
                if around == begin:
                    break
        spoke = swung(opposite, spoke)
        if spoke == first:
            break


@kernel
def _collapse(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    delivered: Float32Array,
    record: Record,
    work: Workspace,
    edge: int,
    collapses: int,
    moved: IndexArray,
) -> tuple[int, IndexArray]:
    """Collapse an edge to `work.place` and write it down; the vertex that stays, and `moved`."""
    corner = surface.corner_facing[edge]
    kept, dead = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    if surface.degree[dead] > surface.degree[kept]:
        kept, dead = dead, kept
    write_collapse(record, collapses, surface, delivered, work.rounded, corner, kept, dead)
    start = record.moved_end[collapses - 1] if collapses > 0 else 0
    moved, end = record_moved_corners(surface, record.corner[collapses, 1], moved, start)
    record.moved_end[collapses] = end
    merge(cost, surface, corner, kept, dead, work.place)
    _contract(surface, delivered, work, edge, kept, dead, moved, start, end)
    settle(cost, surface, kept)
    return kept, moved


@leaf_kernel
def _mark_changed(surface: Surface, work: Workspace, kept: int, collapses: int) -> None:
    """Note for a vertex and its neighbours that their faces have changed."""
    work.changed[kept] = collapses
    first = surface.corner_at[kept]
    spoke = first
    while True:
        work.changed[surface.vertex[following(spoke)]] = collapses
        spoke = swung(surface.opposite, spoke)
        if spoke == first:
            break


@kernel
def _collapse_in_sweeps(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    delivered: Float32Array,
    centre: FloatArray,
    step: float,
    record: Record,
    work: Workspace,
    moved: IndexArray,
    wanted: int,
) -> tuple[int, IndexArray]:
    """Collapse edges below a rising limit of the error, in their order in memory.

    Parameters
    ----------
    cost, surface, delivered, centre, step, record
        As for `collapse_all`.
    work : Workspace
        With the errors of all edges.
    moved : (m,) int32
        The record's moved corners.
    wanted : int
        Collapses to make.

    Returns
    -------
    collapses : int
    moved : (≥ m,) int32
    """
    priority = work.queue.priority
    edges = priority.size
    ring = np.empty((64, 2), np.int32)
    limit, collapses, query = np.sort(priority)[edges // FIRST_SWEEP], 0, 0
    while collapses < wanted:
        before = collapses
        for edge in range(edges):
            corner = surface.corner_facing[edge]
            if corner < 0 or priority[edge] > limit:
                continue
            if _is_stale(surface, work, edge):
                work.evaluated[edge] = collapses
                priority[edge] = optimum(cost, surface, corner, work.place)
                if priority[edge] > limit:
                    continue
            kept, dead = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
            query -= 1
            if not link_condition_holds(surface, kept, dead, query):
                continue
            count = ring_faces(surface, kept, dead, ring)
            if count > len(ring) or not _place_is_valid(
                cost, surface, work, edge, ring, count, centre, step, False
            ):
                continue
            kept, moved = _collapse(
                cost, surface, delivered, record, work, edge, collapses, moved
            )
            collapses += 1
            record.shifted_end[collapses - 1] = 0
            _mark_changed(surface, work, kept, collapses)
            if reach(cost, surface, len(delivered) - collapses) or collapses == wanted:
                return collapses, moved
        if collapses == before and not limit < np.inf:
            break
        limit *= SWEEP_RATIO
    return collapses, moved


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
def _relax(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    delivered: Float32Array,
    centre: FloatArray,
    step: float,
    kept_position: Float32Array,
    work: Workspace,
    kept: int,
    collapses: int,
    ring: IndexArray,
    shifted: IndexArray,
    shift: Float32Array,
    shifts: int,
) -> tuple[IndexArray, Float32Array, int]:
    """Move a new vertex and its neighbours to better places, and write down where from and to.

    Parameters
    ----------
    cost, surface, delivered, centre, step
        As for `collapse_all`.
    kept_position : (3,) float32
        The record's position of the new vertex; replaced if it moves.
    work : Workspace
    kept : int
        The new vertex.
    collapses : int
    ring : (m, 2) int32
        Scratch.
    shifted, shift, shifts
        As for `record_shift`.

    Returns
    -------
    shifted : (≥ m,) int32
    shift : (≥ m, 2, 3) float32
    shifts : int
    """
    place = work.place
    neighbours = vertex_ring(surface, kept, ring)
    if neighbours > len(ring):
        return shifted, shift, shifts
    around = np.empty(neighbours + 1, np.int32)
    around[0] = kept
    around[1:] = ring[:neighbours, 0]
    before = delivered[around]
    for _ in range(RELAXATIONS):
        still = True
        for vertex in around:
            if not improve(cost, surface, vertex, place):
                continue
            rounded_as_delivered(place, centre, step, work.rounded)
            count = vertex_ring(surface, vertex, ring)
            if count > len(ring) or not keeps_star_shape(
                surface.position, ring, count, place[0], place[1], place[2]
            ):
                continue
            for axis in range(3):
                surface.position[vertex, axis] = place[axis]
                delivered[vertex, axis] = work.rounded[axis]
            settle(cost, surface, vertex)
            still = False
        if still:
            break
    kept_position[:] = delivered[kept]
    for index in range(1, len(around)):
        vertex = around[index]
        if (delivered[vertex] != before[index]).any():
            _mark_changed(surface, work, vertex, collapses)
            shifted, shift, shifts = record_shift(
                shifted, shift, shifts, vertex, before[index], delivered[vertex]
            )
    return shifted, shift, shifts


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
        collapses, moved = _collapse_in_sweeps(
            cost, surface, delivered, centre, step, record, work, moved, wanted - SWEPT_DOWN_TO
        )
    _queue_all(cost, surface, work, collapses)

    ring = np.empty((64, 2), np.int32)
    while collapses < wanted and work.queue.size[0] > 0:
        edge = work.queue.heap[0]
        if depends_on_ring(cost) and _is_stale(surface, work, edge):
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
        if not _place_is_valid(cost, surface, work, edge, ring, count, centre, step, exact):
            _queue_next_candidate(cost, surface, work, edge, ring, count)
            continue
        kept, moved = _collapse(cost, surface, delivered, record, work, edge, collapses, moved)
        collapses += 1
        shifts = record.shifted_end[collapses - 2] if collapses > 1 else 0
        if moves_vertices(cost):
            shifted, shift, shifts = _relax(
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
            eager = depends_on_ring(cost) and wanted - collapses < EAGER_COLLAPSES
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
