"""Moves after a collapse: the new vertex and its neighbours go to where the cost wants them."""

from __future__ import annotations

from typing import Any

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.decimation.candidates import rounded_as_delivered
from gamutcore.decimation.costs.interface import improve, settle
from gamutcore.decimation.record import Record, record_shift
from gamutcore.decimation.star import Surface, keeps_star_shape, vertex_ring
from gamutcore.decimation.workspace import Workspace, mark_changed
from gamutcore.kernels import leaf_kernel

__all__ = ["relax"]

FATNESS = 0.05
"""A move must leave no face whose solid angle is less than this part of the mean around the vertex,
unless it was there before: the room that later collapses need goes with such slivers."""

RELAXATIONS = 4
"""How often the vertices around a collapse are gone through to move them, at most."""


@leaf_kernel
def _thinnest(
    position: FloatArray, ring: IndexArray, count: int, x: float, y: float, z: float
) -> tuple[float, float]:
    """Smallest and mean det(a, b, x) ÷ (|a| |b| |x|) over the faces around a place."""
    least, total = np.inf, 0.0
    length = np.sqrt(x * x + y * y + z * z)
    for pair in range(count):
        one, two = ring[pair, 0], ring[pair, 1]
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
    position: FloatArray, ring: IndexArray, count: int, vertex: int, place: FloatArray
) -> bool:
    """Whether a move leaves no sliver that was not there before, and does not reach far."""
    x, y, z = position[vertex, 0], position[vertex, 1], position[vertex, 2]
    before, _ = _thinnest(position, ring, count, x, y, z)
    after, mean = _thinnest(position, ring, count, place[0], place[1], place[2])
    if after < before and after < FATNESS * mean:
        return False
    squared_radius = 0.0
    for pair in range(count):
        one = ring[pair, 0]
        dx, dy, dz = position[one, 0] - x, position[one, 1] - y, position[one, 2] - z
        squared_radius = max(squared_radius, dx * dx + dy * dy + dz * dz)
    dx, dy, dz = place[0] - x, place[1] - y, place[2] - z
    return dx * dx + dy * dy + dz * dz <= squared_radius


@leaf_kernel
def relax(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    delivered: Float32Array,
    centre: FloatArray,
    step: float,
    record: Record,
    work: Workspace,
    kept: int,
    collapses: int,
    ring: IndexArray,
) -> None:
    """Move a new vertex and its neighbours to better places, and write down where from and to.

    Parameters
    ----------
    cost, surface, delivered, centre, step
        As for `collapse_all`.
    record : Record
        With room for as many shifts as there are neighbours. Of the last collapse the position of
        the new vertex is replaced if it moves, and the end of its shifts.
    work : Workspace
    kept : int
        The new vertex.
    collapses : int
        The last one included.
    ring : (m, 2) int32
        Scratch.
    """
    place, around, before = work.place, work.around, work.before
    neighbours = vertex_ring(surface, kept, ring)
    if neighbours > len(ring) or neighbours >= len(around):
        return
    around[0] = kept
    for index in range(neighbours):
        around[index + 1] = ring[index, 0]
    for index in range(neighbours + 1):
        for axis in range(3):
            before[index, axis] = delivered[around[index], axis]
    for _ in range(RELAXATIONS):
        still = True
        for index in range(neighbours + 1):
            vertex = around[index]
            if not improve(cost, surface, vertex, place):
                continue
            if not rounded_as_delivered(place, centre, step, work.rounded):
                continue
            count = vertex_ring(surface, vertex, ring)
            if (
                count > len(ring)
                or not keeps_star_shape(surface.position, ring, count, place[0], place[1], place[2])
                or not _stays_fat(surface.position, ring, count, vertex, place)
            ):
                continue
            for axis in range(3):
                surface.position[vertex, axis] = place[axis]
                delivered[vertex, axis] = work.rounded[axis]
            settle(cost, surface, vertex)
            still = False
        if still:
            break
    _record_moves(surface, delivered, record, work, neighbours, collapses)


@leaf_kernel
def _record_moves(
    surface: Surface,
    delivered: Float32Array,
    record: Record,
    work: Workspace,
    neighbours: int,
    collapses: int,
) -> None:
    """Write down where the new vertex and its neighbours are, as far as that is elsewhere."""
    around, before = work.around, work.before
    for axis in range(3):
        record.position[collapses - 1, 2, axis] = delivered[around[0], axis]
    shifts = record.shifted_end[collapses - 1]
    for index in range(1, neighbours + 1):
        vertex, moved = around[index], False
        for axis in range(3):
            moved = moved or delivered[vertex, axis] != before[index, axis]
        if moved:
            mark_changed(surface, work, vertex, collapses)
            record_shift(record, shifts, vertex, before, index, delivered)
            shifts += 1
    record.shifted_end[collapses - 1] = shifts
