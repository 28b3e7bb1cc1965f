"""One collapse: the test of a candidate position, the change of connectivity, and the workspace.

A candidate position is rounded to the grid and then tested. Only a position that is valid after
rounding is used and recorded.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, Float32Array, FloatArray, IndexArray, LongArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.candidates import round_to_grid, write_candidate
from gamutcore.decimation.costs.dispatch import update_after_change, update_before_collapse
from gamutcore.decimation.edge_queue import EdgeQueue, dequeue, empty_queue
from gamutcore.decimation.record import Record, record_collapse
from gamutcore.decimation.stage import Stage
from gamutcore.decimation.star import LARGEST_LINK, Surface, edge_ends, keeps_star_shape
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "Workspace",
    "candidate_is_valid",
    "collapse_edge",
    "empty_workspace",
    "is_stale",
    "mark_changed",
    "rounded_point_is_valid",
]


class Workspace(NamedTuple):
    """Data of a decimation besides the stage.

    Attributes
    ----------
    queue : EdgeQueue
    collapses : (1,) int64
        Number of collapses of the stage so far.
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
    neighbourhood : (LARGEST_LINK + 1,) int32
        Scratch: a vertex and its neighbours.
    before : (LARGEST_LINK + 1, 3) float32
        Scratch: their positions before they move.
    counter : (1,) int64
        Counts up with each collapse. Another thread reads it to report progress.
    """

    queue: EdgeQueue
    collapses: LongArray
    choice: ByteArray
    evaluated: IndexArray
    changed: IndexArray
    parked: IndexArray
    perturbation: FloatArray
    link: IndexArray
    point: FloatArray
    rounded: Float32Array
    neighbourhood: IndexArray
    before: Float32Array
    counter: LongArray


def empty_workspace(
    edges: int, vertices: int, counter: LongArray, perturbation: FloatArray
) -> Workspace:
    """Return the workspace for a surface, with no edge queued."""
    return Workspace(
        empty_queue(edges),
        np.zeros(1, np.int64),
        np.zeros(edges, np.uint8),
        np.zeros(edges, np.int32),
        np.zeros(vertices, np.int32),
        np.zeros(1, np.int32),
        perturbation,
        # as long as the links of both ends of an edge together; only the used part takes memory
        np.empty((2 * vertices, 2), np.int32),
        np.empty(3, np.float64),
        np.empty(3, np.float32),
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
    stays, goes = int(surface.edge_of[one]), int(surface.edge_of[two])
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
    _, one, two = edge_ends(surface, edge)
    return max(work.changed[one], work.changed[two]) > work.evaluated[edge]


@leaf_kernel
def mark_changed(surface: Surface, work: Workspace, vertex: int) -> None:
    """Mark the faces of a vertex and of its neighbours as changed by the last collapse."""
    work.changed[vertex] = work.collapses[0]
    corner = int(surface.corner_at[vertex])
    for _ in range(surface.degree[vertex]):
        work.changed[surface.vertex[following(corner)]] = work.collapses[0]
        corner = int(surface.swung[np.uint64(corner)])


@leaf_kernel
def candidate_is_valid(stage: Stage, work: Workspace, edge: int, count: int) -> bool:
    """Write and round the present candidate of an edge; False if it is not valid.

    `work.link` holds the edge's link of `count` pairs. `work.point` and `work.rounded` receive the
    position.
    """
    corner, choice = int(stage.surface.corner_facing[edge]), int(np.int64(work.choice[edge]))
    if not write_candidate(stage, corner, choice, work.link, count, work.point):
        return False
    return rounded_point_is_valid(stage, work, count)


@leaf_kernel
def rounded_point_is_valid(stage: Stage, work: Workspace, count: int) -> bool:
    """Round the current position; False if it is not valid for the current link."""
    point = work.point
    return round_to_grid(stage.grid, point, work.rounded) and keeps_star_shape(
        stage.surface.position, work.link, count, point[0], point[1], point[2]
    )


@inlined_kernel
def collapse_edge(stage: Stage, record: Record, work: Workspace, edge: int) -> int:
    """Collapse an edge to `work.point`, record the collapse, and return the vertex that stays.

    The end with more edges stays. The record has room for the degrees of both ends.
    """
    surface, grid, index = stage.surface, stage.grid, work.collapses[0]
    corner, kept, dead = edge_ends(surface, edge)
    twin = int(surface.opposite[corner])
    if surface.degree[dead] > surface.degree[kept]:
        kept, dead = dead, kept
    record_collapse(record, index, surface, grid.position, work.rounded, corner, kept, dead)
    update_before_collapse(stage, corner, kept, dead, work.point)
    for axis in range(3):
        surface.position[kept, axis] = work.point[axis]
        grid.position[kept, axis] = work.rounded[axis]
    for moved in range(record.moved_end[index] - surface.degree[dead] + 2, record.moved_end[index]):
        surface.vertex[record.moved[moved]] = kept
    surface.degree[kept] += surface.degree[dead] - 4
    dequeue(work.queue, edge)
    surface.corner_facing[edge] = -1
    for side in (corner, twin):
        surface.degree[surface.vertex[side]] -= 1
        gone = _close_gap(surface, side)
        if work.queue.heap_index[gone] < 0:
            work.parked[0] -= 1
        dequeue(work.queue, gone)
    update_after_change(stage, kept, corner // 3, twin // 3)
    work.collapses[0] += 1
    work.counter[0] += 1
    return kept
