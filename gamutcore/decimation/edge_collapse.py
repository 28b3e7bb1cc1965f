"""One collapse: the test of a candidate position, the change of connectivity, and the workspace.

A candidate position is rounded to the grid and then tested. Only a position that is valid after
rounding is used and recorded.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, Float32Array, FloatArray, IndexArray, LongArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.candidates import Grid, round_to_grid, write_candidate
from gamutcore.decimation.costs.dispatch import (
    CostState,
    update_after_change,
    update_before_collapse,
)
from gamutcore.decimation.edge_queue import EdgeQueue, dequeue, empty_queue
from gamutcore.decimation.record import Record, record_collapse, record_moved_corners
from gamutcore.decimation.star import LARGEST_LINK, Surface, keeps_star_shape
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "BLOCK_BEGIN",
    "BLOCK_SWEEPS",
    "COLLAPSES",
    "ERRORS_CHANGED",
    "ORDERED",
    "PHASE",
    "QUERIES",
    "REQUEUED",
    "ROOM",
    "ROUND",
    "START",
    "SWEEPING",
    "Loop",
    "Workspace",
    "candidate_is_valid",
    "collapse_edge",
    "empty_workspace",
    "is_stale",
    "mark_changed",
    "new_loop",
    "rounded_point_is_valid",
]

START, SWEEPING, ORDERED = range(3)
"""Phases of the collapse loop: not begun, in sweeps, in strict order."""

COLLAPSES, QUERIES, PHASE, REQUEUED, ROOM = range(5)
"""Indices into `Loop.counts`.

Number of collapses; number of queries of the link condition; phase of the loop; number of collapses
when all edges were last queued; number of changes that the record has no room for.
"""

ROUND, BLOCK_BEGIN, BLOCK_SWEEPS, ERRORS_CHANGED = range(5, 9)
"""Indices into `Loop.counts`, for the sweeps.

Number of the round; first edge of the current block; completed sweeps of the block; 1 if the errors
of all edges have changed.
"""


class Loop(NamedTuple):
    """Progress of the collapse loop.

    Attributes
    ----------
    counts : (9,) int64
        Indexed by `COLLAPSES` to `ERRORS_CHANGED`.
    limit : (1,) float64
        Sweeps: the limits of a round lie above this one.
    """

    counts: LongArray
    limit: FloatArray


def new_loop() -> Loop:
    """Return the progress of a loop that has not begun."""
    return Loop(np.zeros(9, np.int64), np.zeros(1))


class Workspace(NamedTuple):
    """Data of a decimation besides the surface.

    Attributes
    ----------
    queue : EdgeQueue
    choice : (E,) uint8
        Number of the candidate whose error stands in the queue.
    evaluated : (E,) int32
        Number of collapses before the edge's error was evaluated.
    changed : (V,) int32
        Number of collapses after which the faces of a vertex last changed.
    parked : (1,) int32
        Number of edges that are neither queued nor removed.
    perturbation : (E,) or (0,) float64
        Relative perturbation of each edge's error in the present trial; empty for exact errors.
    link : (2 V, 2) int32
        Scratch: the link of the current edge or vertex.
    point : (3,) float64
        The current position, relative to the centre.
    rounded : (3,) float32
        The same position rounded to the grid.
    gradient : (3,) float64
        Scratch: volume gradient of the current link.
    neighbourhood : (LARGEST_LINK + 1,) int32
        Scratch: a vertex and its neighbours.
    before : (LARGEST_LINK + 1, 3) float32
        Scratch: their positions before they move.
    counter : (1,) int64
        Number of collapses so far. Another thread reads it to report progress.
    """

    queue: EdgeQueue
    choice: ByteArray
    evaluated: IndexArray
    changed: IndexArray
    parked: IndexArray
    perturbation: FloatArray
    link: IndexArray
    point: FloatArray
    rounded: Float32Array
    gradient: FloatArray
    neighbourhood: IndexArray
    before: Float32Array
    counter: LongArray


def empty_workspace(
    edges: int, vertices: int, counter: LongArray, perturbation: FloatArray
) -> Workspace:
    """Return the workspace for a surface, with no edge queued."""
    return Workspace(
        empty_queue(edges),
        np.zeros(edges, np.uint8),
        np.zeros(edges, np.int32),
        np.zeros(vertices, np.int32),
        np.zeros(1, np.int32),
        perturbation,
        # as long as the links of both ends of an edge together; only the used part takes memory
        np.empty((2 * vertices, 2), np.int32),
        np.empty(3, np.float64),
        np.empty(3, np.float32),
        np.empty(3, np.float64),
        np.empty(LARGEST_LINK + 1, np.int32),
        np.empty((LARGEST_LINK + 1, 3), np.float32),
        counter,
    )


@leaf_kernel
def _close_gap(surface: Surface, corner: int) -> int:
    """Join the two outer neighbours of a removed face; returns the edge that disappears.

    `corner` faces the collapsed edge. The corners outside the removed faces name the kept vertex
    already. Two edges become one, which keeps the smaller id.
    """
    vertex, opposite = surface.vertex, surface.opposite
    one, two = int(opposite[following(corner)]), int(opposite[preceding(corner)])
    opposite[one], opposite[two] = two, one
    surface.swung[preceding(one)], surface.swung[preceding(two)] = following(two), following(one)
    surface.corner_at[vertex[following(one)]] = following(one)
    surface.corner_at[vertex[preceding(one)]] = preceding(one)
    stays, goes = int(np.int64(surface.edge_of[one])), int(np.int64(surface.edge_of[two]))
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
    corner, since = int(surface.corner_facing[edge]), work.evaluated[edge]
    return (
        work.changed[surface.vertex[following(corner)]] > since
        or work.changed[surface.vertex[preceding(corner)]] > since
    )


@leaf_kernel
def mark_changed(surface: Surface, work: Workspace, vertex: int, collapses: int) -> None:
    """Mark the faces of a vertex and of its neighbours as changed."""
    work.changed[vertex] = collapses
    first = int(surface.corner_at[vertex])
    spoke = first
    while True:
        work.changed[surface.vertex[following(spoke)]] = collapses
        spoke = int(surface.swung[np.uint64(spoke)])
        if spoke == first:
            break


@leaf_kernel
def candidate_is_valid(
    state: CostState, surface: Surface, grid: Grid, work: Workspace, edge: int, count: int
) -> bool:
    """Write and round the present candidate of an edge; False if it is not valid.

    Parameters
    ----------
    state : CostState
    surface : Surface
    grid : Grid
    work : Workspace
        `link` holds the edge's link. `point` and `rounded` receive the position.
    edge : int
    count : int
        Number of pairs of the link.

    Returns
    -------
    bool
    """
    corner = int(surface.corner_facing[edge])
    choice = int(np.int64(work.choice[edge]))
    if not write_candidate(
        state, surface, corner, choice, work.link, count, work.gradient, work.point
    ):
        return False
    return rounded_point_is_valid(surface, grid, work, count)


@leaf_kernel
def rounded_point_is_valid(surface: Surface, grid: Grid, work: Workspace, count: int) -> bool:
    """Round the current position; False if it is not valid for the current link."""
    point = work.point
    return round_to_grid(grid, point, work.rounded) and keeps_star_shape(
        surface.position, work.link, count, point[0], point[1], point[2]
    )


@inlined_kernel
def _contract(
    surface: Surface,
    grid: Grid,
    record: Record,
    work: Workspace,
    edge: int,
    kept: int,
    dead: int,
    start: int,
    end: int,
) -> None:
    """Move the kept vertex, give it the moved corners and close the two gaps."""
    for axis in range(3):
        surface.position[kept, axis] = work.point[axis]
        grid.position[kept, axis] = work.rounded[axis]
    for index in range(start, end):
        surface.vertex[record.moved[index]] = kept
    corner = int(surface.corner_facing[edge])
    twin = int(surface.opposite[corner])
    surface.degree[kept] += surface.degree[dead] - 4
    dequeue(work.queue, edge)
    surface.corner_facing[edge] = -1
    for side in (corner, twin):
        surface.degree[surface.vertex[side]] -= 1
        gone = _close_gap(surface, side)
        if work.queue.heap_index[gone] < 0:
            work.parked[0] -= 1
        dequeue(work.queue, gone)


@inlined_kernel
def collapse_edge(
    state: CostState,
    surface: Surface,
    grid: Grid,
    record: Record,
    work: Workspace,
    edge: int,
    collapses: int,
) -> int:
    """Collapse an edge to `work.point` and record the collapse.

    Parameters
    ----------
    state, surface, grid
        Updated.
    record : Record
        With room for the degrees of the edge's ends.
    work : Workspace
    edge : int
    collapses : int
        Number of earlier collapses.

    Returns
    -------
    int
        The vertex that stays: the end with more edges.
    """
    corner = int(surface.corner_facing[edge])
    kept = int(surface.vertex[following(corner)])
    dead = int(surface.vertex[preceding(corner)])
    if surface.degree[dead] > surface.degree[kept]:
        kept, dead = dead, kept
    record_collapse(record, collapses, surface, grid.position, work.rounded, corner, kept, dead)
    start = int(record.moved_end[collapses - 1]) if collapses > 0 else 0
    end = record_moved_corners(surface, int(record.corner[collapses, 1]), record, start)
    record.moved_end[collapses] = end
    record.shifted_end[collapses] = record.shifted_end[collapses - 1] if collapses > 0 else 0
    update_before_collapse(state, surface, corner, kept, dead, work.point)
    _contract(surface, grid, record, work, edge, kept, dead, start, end)
    update_after_change(state, surface, kept)
    work.counter[0] += 1
    return kept
