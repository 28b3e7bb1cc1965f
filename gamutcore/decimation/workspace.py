"""One collapse, from a candidate's test to the glued gaps, and what is kept beside the surface.

A candidate position is rounded to the precision that is delivered and then tested; only what holds
there is carried out and written down.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, Float32Array, FloatArray, IndexArray, LongArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.candidates import (
    CANDIDATES,
    candidate,
    rounded_as_delivered,
    rounded_to_volume,
    within_reach,
)
from gamutcore.decimation.costs.interface import merge, preserves_volume, settle
from gamutcore.decimation.edge_queue import EdgeQueue, dequeue, empty_queue
from gamutcore.decimation.record import Record, record_moved_corners, write_collapse
from gamutcore.decimation.star import Surface, keeps_star_shape, star_volume, volume_slope
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

__all__ = [
    "EXACT_ROUNDING",
    "LONGEST_RING",
    "Workspace",
    "collapse_edge",
    "is_stale",
    "mark_changed",
    "place_is_valid",
    "rounded_place_is_valid",
    "workspace",
]

EXACT_ROUNDING = 2000
"""This many collapses before the end, costs that preserve the volume have positions rounded to the
corner of the grid's cell that preserves it best: fewer vertices carry more of it each."""

LONGEST_RING = 64
"""Faces around a vertex that may be gone through to move it and its neighbours."""


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
    around : (n,) int32
        Scratch: a vertex and its neighbours.
    before : (n, 3) float32
        Scratch: where they were.
    done : (1,) int64
        Number of collapses so far, for whoever looks on from another thread.
    way : (2,) float64
        Number of the way down, and by what part of themselves errors are disturbed on it.
    known : (E,) or (0,) float64
        Errors of all edges before the first collapse, undisturbed; NaN where they are not known.
    """

    queue: EdgeQueue
    choice: ByteArray
    evaluated: IndexArray
    changed: IndexArray
    parked: IndexArray
    place: FloatArray
    rounded: Float32Array
    slope: FloatArray
    around: IndexArray
    before: Float32Array
    done: LongArray
    way: FloatArray
    known: FloatArray


@kernel
def workspace(
    edges: int, vertices: int, done: LongArray, way: FloatArray, known: FloatArray
) -> Workspace:
    """Return what is kept beside a surface, with no edge queued yet."""
    return Workspace(
        empty_queue(edges),
        np.zeros(edges, np.uint8),
        np.zeros(edges, np.int32),
        np.zeros(vertices, np.int32),
        np.zeros(1, np.int32),
        np.empty(3, np.float64),
        np.empty(3, np.float32),
        np.empty(3, np.float64),
        np.empty(LONGEST_RING + 1, np.int32),
        np.empty((LONGEST_RING + 1, 3), np.float32),
        done,
        way,
        known,
    )


@leaf_kernel
def _glue(surface: Surface, corner: int) -> int:
    """Close the gap that a vanishing face leaves, by joining its two outer neighbours.

    `corner` faces the collapsed edge; the corners outside the vanishing faces name the kept vertex
    already. Two edges fall together: the smaller id stays, the other is returned.
    """
    vertex, opposite = surface.vertex, surface.opposite
    one, two = opposite[following(corner)], opposite[preceding(corner)]
    opposite[one], opposite[two] = two, one
    surface.swung[preceding(one)], surface.swung[preceding(two)] = following(two), following(one)
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
def is_stale(surface: Surface, work: Workspace, edge: int) -> bool:
    """Whether the faces around an edge have changed since its error was evaluated."""
    corner, since = surface.corner_facing[edge], work.evaluated[edge]
    return (
        work.changed[surface.vertex[following(corner)]] > since
        or work.changed[surface.vertex[preceding(corner)]] > since
    )


@leaf_kernel
def mark_changed(surface: Surface, work: Workspace, kept: int, collapses: int) -> None:
    """Note for a vertex and its neighbours that their faces have changed."""
    work.changed[kept] = collapses
    first = surface.corner_at[kept]
    spoke = first
    while True:
        work.changed[surface.vertex[following(spoke)]] = collapses
        spoke = surface.swung[np.uint64(spoke)]
        if spoke == first:
            break


@leaf_kernel
def place_is_valid(
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
    choice, corner = work.choice[edge], surface.corner_facing[edge]
    if not candidate(cost, surface, corner, choice, ring, count, work.slope, work.place):
        return False
    return rounded_place_is_valid(
        cost, surface, work, corner, choice, ring, count, centre, step, exact
    )


@leaf_kernel
def rounded_place_is_valid(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    work: Workspace,
    corner: int,
    choice: int,
    ring: IndexArray,
    count: int,
    centre: FloatArray,
    step: float,
    exact: bool,
) -> bool:
    """Round the place at hand as delivered; False if it is not valid for an edge there."""
    place = work.place
    kept, dead = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    # the last candidate may have to reach far: it is there so that no edge is lost
    if choice < CANDIDATES - 1 and not within_reach(
        surface.position, ring, count, kept, dead, place
    ):
        return False
    if preserves_volume(cost) and exact:
        volume_slope(surface.position, ring, count, work.slope)
        volume = star_volume(surface, kept, dead) + surface.deficit[0]
        deliverable = rounded_to_volume(place, centre, step, work.slope, volume, work.rounded)
    else:
        deliverable = rounded_as_delivered(place, centre, step, work.rounded)
    return deliverable and keeps_star_shape(
        surface.position, ring, count, place[0], place[1], place[2]
    )


@inlined_kernel
def _contract(
    surface: Surface,
    delivered: Float32Array,
    record: Record,
    work: Workspace,
    edge: int,
    kept: int,
    dead: int,
    start: int,
    end: int,
) -> None:
    """Collapse an edge: move the kept vertex, give it the moved corners, close the two gaps."""
    for axis in range(3):
        surface.position[kept, axis] = work.place[axis]
        delivered[kept, axis] = work.rounded[axis]
    for index in range(start, end):
        surface.vertex[record.moved[index]] = kept
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


@inlined_kernel
def collapse_edge(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    delivered: Float32Array,
    record: Record,
    work: Workspace,
    edge: int,
    collapses: int,
) -> int:
    """Collapse an edge to `work.place` and write it down; returns the vertex that stays.

    The record must have room for the degrees of the edge's ends.
    """
    corner = surface.corner_facing[edge]
    kept, dead = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    if surface.degree[dead] > surface.degree[kept]:
        kept, dead = dead, kept
    write_collapse(record, collapses, surface, delivered, work.rounded, corner, kept, dead)
    start = record.moved_end[collapses - 1] if collapses > 0 else 0
    end = record_moved_corners(surface, record.corner[collapses, 1], record, start)
    record.moved_end[collapses] = end
    record.shifted_end[collapses] = record.shifted_end[collapses - 1] if collapses > 0 else 0
    merge(cost, surface, corner, kept, dead, work.place)
    _contract(surface, delivered, record, work, edge, kept, dead, start, end)
    settle(cost, surface, kept)
    work.done[0] += 1
    return kept
