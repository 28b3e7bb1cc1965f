"""Moves after a collapse: the new vertex and its neighbours go to where the cost wants them."""

from __future__ import annotations

from typing import Any

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.decimation.candidates import rounded_as_delivered
from gamutcore.decimation.costs.interface import improve, settle
from gamutcore.decimation.record import record_shift
from gamutcore.decimation.star import Surface, keeps_star_shape, vertex_ring
from gamutcore.decimation.workspace import Workspace, mark_changed
from gamutcore.kernels import kernel

__all__ = ["relax"]

RELAXATIONS = 2
"""How often the vertices around a collapse are gone through to move them, at most."""


@kernel
def relax(
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
        for number in around:
            vertex = int(number)
            if not improve(cost, surface, vertex, place):
                continue
            if not rounded_as_delivered(place, centre, step, work.rounded):
                continue
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
            mark_changed(surface, work, vertex, collapses)
            shifted, shift, shifts = record_shift(
                shifted, shift, shifts, vertex, before[index], delivered[vertex]
            )
    return shifted, shift, shifts
