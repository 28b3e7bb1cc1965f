"""Moves after a collapse: the new vertex and its neighbours move to lower the mismatch."""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.decimation.candidates import Grid, round_to_grid
from gamutcore.decimation.costs.dispatch import CostState, find_improvement, update_after_change
from gamutcore.decimation.edge_collapse import Workspace, mark_changed
from gamutcore.decimation.record import Record, record_shift
from gamutcore.decimation.star import LARGEST_LINK, Surface, keeps_star_shape, write_vertex_link
from gamutcore.kernels import leaf_kernel

__all__ = ["relax"]

FATNESS = 0.05
"""A move must not leave a face whose solid angle is below this fraction of the mean around the
vertex, unless the face was there before. Slivers close the cones that later collapses need."""

ROUNDS = 4
"""Largest number of passes over the vertices around a collapse."""


@leaf_kernel
def _thinnest(
    position: FloatArray, link: IndexArray, count: int, x: float, y: float, z: float
) -> tuple[float, float]:
    """Smallest and mean det(a, b, x) ÷ (|a| |b| |x|) over the faces around a position."""
    least, total = np.inf, 0.0
    length = np.sqrt(x * x + y * y + z * z)
    for pair in range(count):
        one, two = link[pair, 0], link[pair, 1]
        ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
        bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
        determinant = x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)
        lengths = np.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
        angle = determinant / (lengths * length)
        least = min(least, angle)
        total += angle
    return least, total / count


@leaf_kernel
def _stays_fat(
    position: FloatArray, link: IndexArray, count: int, vertex: int, point: FloatArray
) -> bool:
    """Whether a move creates no sliver and stays within the radius of the star."""
    x, y, z = position[vertex, 0], position[vertex, 1], position[vertex, 2]
    before, _ = _thinnest(position, link, count, x, y, z)
    after, mean = _thinnest(position, link, count, point[0], point[1], point[2])
    if after < before and after < FATNESS * mean:
        return False
    squared_radius = 0.0
    for pair in range(count):
        one = link[pair, 0]
        dx, dy, dz = position[one, 0] - x, position[one, 1] - y, position[one, 2] - z
        squared_radius = max(squared_radius, dx * dx + dy * dy + dz * dz)
    dx, dy, dz = point[0] - x, point[1] - y, point[2] - z
    return dx * dx + dy * dy + dz * dz <= squared_radius


@leaf_kernel
def relax(
    state: CostState,
    surface: Surface,
    grid: Grid,
    record: Record,
    work: Workspace,
    kept: int,
    collapses: int,
) -> None:
    """Move a new vertex and its neighbours to better positions, and record the moves.

    Parameters
    ----------
    state, surface, grid
        Updated.
    record : Record
        With room for one shift per neighbour. The position and the end of shifts of the last
        collapse are replaced.
    work : Workspace
    kept : int
        The new vertex.
    collapses : int
        Number of collapses, including the last one.
    """
    point, link, around = work.point, work.link, work.neighbourhood
    neighbours = int(surface.degree[kept])
    if neighbours > LARGEST_LINK:
        return
    write_vertex_link(surface, kept, link)
    around[0] = kept
    for index in range(neighbours):
        around[index + 1] = link[index, 0]
    for index in range(neighbours + 1):
        for axis in range(3):
            work.before[index, axis] = grid.position[around[index], axis]
    for _ in range(ROUNDS):
        moved = False
        for index in range(neighbours + 1):
            vertex = int(around[index])
            if not find_improvement(state, surface, vertex, point):
                continue
            if not round_to_grid(grid, point, work.rounded):
                continue
            count = write_vertex_link(surface, vertex, link)
            if not (
                keeps_star_shape(surface.position, link, count, point[0], point[1], point[2])
                and _stays_fat(surface.position, link, count, vertex, point)
            ):
                continue
            for axis in range(3):
                surface.position[vertex, axis] = point[axis]
                grid.position[vertex, axis] = work.rounded[axis]
            update_after_change(state, surface, vertex)
            moved = True
        if not moved:
            break
    _record_moves(surface, grid, record, work, neighbours, collapses)


@leaf_kernel
def _record_moves(
    surface: Surface,
    grid: Grid,
    record: Record,
    work: Workspace,
    neighbours: int,
    collapses: int,
) -> None:
    """Record the present positions of the new vertex and of the neighbours that moved."""
    around, before = work.neighbourhood, work.before
    for axis in range(3):
        record.position[collapses - 1, 2, axis] = grid.position[around[0], axis]
    shifts = int(record.shifted_end[collapses - 1])
    for index in range(1, neighbours + 1):
        vertex, moved = int(around[index]), False
        for axis in range(3):
            moved = moved or grid.position[vertex, axis] != before[index, axis]
        if moved:
            mark_changed(surface, work, vertex, collapses)
            record_shift(record, shifts, vertex, before, index, grid.position)
            shifts += 1
    record.shifted_end[collapses - 1] = shifts
