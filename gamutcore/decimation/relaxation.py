"""Moves after a collapse: the new vertex and its neighbours move to lower the mismatch."""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.decimation.candidates import round_to_grid
from gamutcore.decimation.costs.dispatch import find_improvement, update_after_change
from gamutcore.decimation.costs.sample_assignment import NO_FACE
from gamutcore.decimation.edge_collapse import Workspace, mark_changed
from gamutcore.decimation.record import Record, record_shift
from gamutcore.decimation.stage import Stage
from gamutcore.decimation.star import LARGEST_LINK, keeps_star_shape, write_vertex_link
from gamutcore.decimation.vectors import Vector, dot, minus, row, triple
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = ["relax"]

FATNESS = 0.05
"""A move must not leave a face whose solid angle is below this fraction of the mean around the
vertex, unless the face was there before. Slivers close the cones that later collapses need."""

ROUNDS = 4
"""Largest number of passes over the vertices around a collapse."""


@leaf_kernel
def _thinnest(
    position: FloatArray, link: IndexArray, count: int, point: Vector
) -> tuple[float, float]:
    """Smallest and mean det(a, b, p) ÷ (|a| |b| |p|) over the faces around a position."""
    least, total = np.inf, 0.0
    length = np.sqrt(dot(point, point))
    for pair in range(count):
        a, b = row(position, link[pair, 0], 0), row(position, link[pair, 1], 0)
        angle = triple(a, b, point) / (np.sqrt(dot(a, a) * dot(b, b)) * length)
        least = min(least, angle)
        total += angle
    return least, total / count


@leaf_kernel
def _stays_fat(
    position: FloatArray, link: IndexArray, count: int, vertex: int, point: FloatArray
) -> bool:
    """Whether a move creates no sliver and stays within the radius of the star."""
    here, there = row(position, vertex, 0), (point[0], point[1], point[2])
    before, _ = _thinnest(position, link, count, here)
    after, mean = _thinnest(position, link, count, there)
    if after < before and after < FATNESS * mean:
        return False
    squared_radius = 0.0
    for pair in range(count):
        spoke = minus(row(position, link[pair, 0], 0), here)
        squared_radius = max(squared_radius, dot(spoke, spoke))
    move = minus(there, here)
    return dot(move, move) <= squared_radius


@inlined_kernel
def _move(stage: Stage, work: Workspace, vertex: int) -> bool:
    """Move a vertex to a better position that is valid; False if there is none."""
    surface, point, link = stage.surface, work.point, work.link
    if not (
        find_improvement(stage, vertex, point) and round_to_grid(stage.grid, point, work.rounded)
    ):
        return False
    count = write_vertex_link(surface, vertex, link)
    if not (
        keeps_star_shape(surface.position, link, count, point[0], point[1], point[2])
        and _stays_fat(surface.position, link, count, vertex, point)
    ):
        return False
    for axis in range(3):
        surface.position[vertex, axis] = point[axis]
        stage.grid.position[vertex, axis] = work.rounded[axis]
    update_after_change(stage, vertex, NO_FACE, NO_FACE)
    return True


@leaf_kernel
def relax(stage: Stage, record: Record, work: Workspace, kept: int) -> None:
    """Move a new vertex and its neighbours to better positions, and record the moves.

    The position and the end of shifts of the last collapse are replaced. The record has room for
    one shift per neighbour.
    """
    surface, around, position = stage.surface, work.neighbourhood, stage.grid.position
    neighbours = int(surface.degree[kept])
    if neighbours > LARGEST_LINK:
        return
    write_vertex_link(surface, kept, work.link)
    around[0] = kept
    for index in range(neighbours):
        around[index + 1] = work.link[index, 0]
    for index in range(neighbours + 1):
        for axis in range(3):
            work.before[index, axis] = position[around[index], axis]
    for _ in range(ROUNDS):
        moves = 0
        for index in range(neighbours + 1):
            moves += _move(stage, work, int(around[index]))
        if moves == 0:
            break
    last = work.collapses[0] - 1
    for axis in range(3):
        record.position[last, 2, axis] = position[kept, axis]
    for index in range(1, neighbours + 1):
        vertex, moved = int(around[index]), False
        for axis in range(3):
            moved = moved or position[vertex, axis] != work.before[index, axis]
        if moved:
            mark_changed(surface, work, vertex)
            record_shift(record, last, vertex, work.before, index, position)
