"""The decimation kernel: the cheapest valid collapse, again and again, down to four triangles.

Data layout: a `Surface` (positions, corner table, edges), an indexed heap of edges, one byte per edge
that says which candidate position stands in the queue for it, and a `Record` that receives every
collapse. An edge is queued with the error of its first candidate (the cost's optimum). When it comes
to the front, that candidate is rounded to the precision that is delivered and tested; if it is not
valid, the edge goes back with the error of the next one. An edge with no valid candidate is parked:
it stays alive outside the queue and comes back when its ring changes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.corner_table import following, preceding, swung
from gamutcore.decimation.costs.interface import depends_on_ring, error, merge, optimum
from gamutcore.decimation.edge_queue import (
    EdgeQueue,
    dequeue,
    empty_queue,
    enqueue,
    fill_queue,
)
from gamutcore.decimation.star import (
    Surface,
    keeps_star_shape,
    kernel_direction,
    link_condition_holds,
    ring_faces,
    scale_to_preserve_volume,
)
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["CANDIDATES", "Record", "collapse_all", "surface_of"]

CANDIDATES = 5
"""Positions tried for an edge: optimum, midpoint, its two ends, and the middle of the valid cone."""

EAGER_COLLAPSES = 2500
"""This many collapses before the end, errors that a collapse may have changed are evaluated at once
instead of when their edge comes to the front: with few faces left, the order matters most."""

REACH = 2.0
"""How far from the edge's midpoint a vertex may be placed, in radii of its star (CGAL #8213: spikes)."""


class Record(NamedTuple):
    """Every collapse in the order in which it happened.

    Attributes
    ----------
    kept, dead : (V − 4,) int32
        The vertex that stays and the one that goes.
    position : (V − 4, 3, 3) float32
        Where the kept vertex was, where the dead one was, where the kept one is after it.
    face : (V − 4, 2) int32
        The two faces that go.
    face_corners : (V − 4, 2, 3) int32
        Their vertices.
    moved_end : (V − 4,) int64
        Where this collapse's part of `moved` ends.
    moved : (≥ moved_end[-1],) int32
        Corners that pass from the dead vertex to the kept one.
    """

    kept: IndexArray
    dead: IndexArray
    position: FloatArray
    face: IndexArray
    face_corners: IndexArray
    moved_end: IndexArray
    moved: IndexArray


@kernel
def surface_of(positions: FloatArray, faces: IndexArray, opposite: IndexArray) -> Surface:
    """Arrange a closed mesh for decimation.

    Parameters
    ----------
    positions : (V, 3) float64
        Relative to the centre.
    faces : (F, 3) int32
    opposite : (3 F,) int32
        Of a closed mesh: no −1.

    Returns
    -------
    Surface
    """
    vertex = faces.copy().ravel()
    corner_at = np.empty(len(positions), np.int32)
    edge_of = np.empty(vertex.size, np.int32)
    corner_facing = np.empty(vertex.size // 2, np.int32)
    edges = 0
    for corner in range(vertex.size):
        corner_at[vertex[corner]] = corner
        if corner < opposite[corner]:
            edge_of[corner] = edges
            edge_of[opposite[corner]] = edges
            corner_facing[edges] = corner
            edges += 1
    mark = np.full(len(positions), -1, np.int64)
    return Surface(
        positions.copy(), vertex, opposite.copy(), corner_at, edge_of, corner_facing, mark
    )


@leaf_kernel
def _degree(surface: Surface, vertex: int) -> int:
    first = surface.corner_at[vertex]
    corner, degree = swung(surface.opposite, first), 1
    while corner != first:
        corner = swung(surface.opposite, corner)
        degree += 1
    return degree


@leaf_kernel
def _candidate(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    kept: int,
    dead: int,
    choice: int,
    ring: IndexArray,
    count: int,
    place: FloatArray,
) -> bool:
    """Write candidate number `choice` for an edge; False if there is none of that number."""
    position = surface.position
    if choice == 0:
        optimum(cost, surface, kept, dead, place)
        return True
    if choice == 2 or choice == 3:
        end = kept if choice == 2 else dead
        place[0], place[1], place[2] = position[end, 0], position[end, 1], position[end, 2]
    else:
        for axis in range(3):
            place[axis] = 0.5 * (position[kept, axis] + position[dead, axis])
        if choice == 4 and not kernel_direction(position, ring, count, place):
            return False
    return scale_to_preserve_volume(surface, ring, count, kept, dead, place)


@leaf_kernel
def _within_reach(
    position: FloatArray, ring: IndexArray, count: int, kept: int, dead: int, place: FloatArray
) -> bool:
    """Whether a position is at most `REACH` star radii from the edge's midpoint."""
    mx = 0.5 * (position[kept, 0] + position[dead, 0])
    my = 0.5 * (position[kept, 1] + position[dead, 1])
    mz = 0.5 * (position[kept, 2] + position[dead, 2])
    squared_radius = 0.0
    for pair in range(count):
        one = ring[pair, 0]
        x, y, z = position[one, 0] - mx, position[one, 1] - my, position[one, 2] - mz
        squared_radius = max(squared_radius, x * x + y * y + z * z)
    x, y, z = place[0] - mx, place[1] - my, place[2] - mz
    return x * x + y * y + z * z <= REACH * REACH * squared_radius


@leaf_kernel
def _round_as_delivered(place: FloatArray, centre: FloatArray, delivered: FloatArray) -> None:
    """Round to the float32 coordinates that are delivered, and take `place` from them."""
    for axis in range(3):
        delivered[axis] = np.float32(place[axis] + centre[axis])
        place[axis] = np.float64(delivered[axis]) - centre[axis]


@kernel
def _moved_corners(
    surface: Surface, kept: int, dead: int, moved: IndexArray, filled: int
) -> tuple[IndexArray, int]:
    """Append the corners that pass from the dead vertex to the kept one; the array grows if need be."""
    vertex = surface.vertex
    first = surface.corner_at[dead]
    corner = first
    while True:
        if vertex[following(corner)] != kept and vertex[preceding(corner)] != kept:
            if filled == moved.size:
                longer = np.empty(2 * moved.size, np.int32)
                longer[:filled] = moved
                moved = longer
            moved[filled] = corner
            filled += 1
        corner = swung(surface.opposite, corner)
        if corner == first:
            break
    return moved, filled


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
def _requeue(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    queue: EdgeQueue,
    choice: IndexArray,
    stale: IndexArray,
    edge: int,
    place: FloatArray,
) -> None:
    """Queue an edge, or move it, with the error of its optimum."""
    facing = surface.corner_facing[edge]
    # the ends in the order of the edge's own corner: the result never depends on how it was reached
    one, two = surface.vertex[following(facing)], surface.vertex[preceding(facing)]
    choice[edge], stale[edge] = 0, 0
    enqueue(queue, edge, optimum(cost, surface, one, two, place))


@kernel
def collapse_all(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    delivered: FloatArray,
    centre: FloatArray,
    record: Record,
) -> tuple[int, IndexArray]:
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
    record : Record
        Receives the collapses; its `moved` may be outgrown.

    Returns
    -------
    collapses : int
        V − 4 if four faces were reached.
    moved : (m,) int32
        The record's moved corners, all of them.
    """
    position, vertex, opposite = surface.position, surface.vertex, surface.opposite
    edges = surface.corner_facing.size
    queue = empty_queue(edges)
    heap, place_of, size, priority = queue.heap, queue.place, queue.size, queue.priority
    choice, stale = np.zeros(edges, np.uint8), np.zeros(edges, np.uint8)
    place, rounded = np.empty(3, np.float64), np.empty(3, np.float32)
    ring = np.empty((64, 2), np.int32)
    moved, filled = record.moved, 0
    for edge in range(edges):
        corner = surface.corner_facing[edge]
        kept, dead = vertex[following(corner)], vertex[preceding(corner)]
        priority[edge] = optimum(cost, surface, kept, dead, place)
    fill_queue(queue)

    collapses, wanted, query, parked = 0, len(position) - 4, 0, 0
    while collapses < wanted and size[0] > 0:
        edge = heap[0]
        if depends_on_ring(cost) and stale[edge]:
            _requeue(cost, surface, queue, choice, stale, edge, place)
            continue
        corner = surface.corner_facing[edge]
        kept, dead = vertex[following(corner)], vertex[preceding(corner)]
        query += 1
        if not link_condition_holds(surface, kept, dead, query):
            dequeue(queue, edge)
            parked += 1
            continue
        count = ring_faces(surface, kept, dead, ring)
        if count > len(ring):
            ring = np.empty((2 * count, 2), np.int32)
            ring_faces(surface, kept, dead, ring)
        if _degree(surface, dead) > _degree(surface, kept):
            kept, dead = dead, kept

        valid = _candidate(cost, surface, kept, dead, choice[edge], ring, count, place)
        # the last candidate may have to reach far: it is there so that no edge is lost
        if valid and choice[edge] < CANDIDATES - 1:
            valid = _within_reach(position, ring, count, kept, dead, place)
        if valid:
            _round_as_delivered(place, centre, rounded)
            valid = keeps_star_shape(position, ring, count, place[0], place[1], place[2])
        if not valid:
            following_error = np.inf
            while choice[edge] < CANDIDATES - 1 and following_error == np.inf:
                choice[edge] += 1
                if _candidate(cost, surface, kept, dead, choice[edge], ring, count, place):
                    following_error = error(cost, surface, kept, dead, place)
            if following_error < np.inf:
                enqueue(queue, edge, max(priority[edge], following_error))
            else:
                dequeue(queue, edge)
                parked += 1
            continue

        # the edge is collapsed: first everything that refers to the state before
        record.kept[collapses], record.dead[collapses] = kept, dead
        for axis in range(3):
            record.position[collapses, 0, axis] = delivered[kept, axis]
            record.position[collapses, 1, axis] = delivered[dead, axis]
            record.position[collapses, 2, axis] = rounded[axis]
        twin = opposite[corner]
        for side in range(2):
            face = (corner if side == 0 else twin) // 3
            record.face[collapses, side] = face
            for index in range(3):
                record.face_corners[collapses, side, index] = vertex[3 * face + index]
        start = filled
        moved, filled = _moved_corners(surface, kept, dead, moved, filled)
        record.moved_end[collapses] = filled
        merge(cost, surface, kept, dead, place)

        for axis in range(3):
            position[kept, axis] = place[axis]
            delivered[kept, axis] = rounded[axis]
        for index in range(start, filled):
            vertex[moved[index]] = kept
        dequeue(queue, edge)
        surface.corner_facing[edge] = -1
        for side in (corner, twin):
            gone = _glue(surface, side)
            parked -= place_of[gone] < 0
            dequeue(queue, gone)
        collapses += 1

        # new priorities for the spokes; parked edges whose ring has changed come back
        first = surface.corner_at[kept]
        spoke = first
        while True:
            edge = surface.edge_of[preceding(spoke)]
            parked -= place_of[edge] < 0
            _requeue(cost, surface, queue, choice, stale, edge, place)
            begin = surface.corner_at[vertex[following(spoke)]]
            around = begin
            while parked > 0 or depends_on_ring(cost):
                edge = surface.edge_of[preceding(around)]
                if place_of[edge] < 0:
                    parked -= 1
                    _requeue(cost, surface, queue, choice, stale, edge, place)
                elif depends_on_ring(cost) and vertex[following(around)] != kept:
                    if wanted - collapses < EAGER_COLLAPSES:
                        _requeue(cost, surface, queue, choice, stale, edge, place)
                    else:
                        stale[edge] = 1
                around = swung(opposite, around)
                if around == begin:
                    break
            spoke = swung(opposite, spoke)
            if spoke == first:
                break
    return collapses, moved[:filled]
