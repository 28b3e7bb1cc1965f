"""The most accurate cost: the change of the mismatch itself, and vertices moved to lower it.

Every vertex of the full boundary is a sample of it from the start. Down to 20,000 faces edges are
ordered as by `volume`. From there on an edge's error is the change of the mismatch with the full
boundary, and from 4000 faces on the new vertex of each collapse and its neighbours are moved
towards less of it: the history keeps these moves, so every level has them. The volume is not
preserved then; what is inside the full boundary and outside the level is about as much as what is
outside of the one and inside of the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, FloatArray, IndexArray
from gamutcore.decimation.costs import interface
from gamutcore.decimation.deviation import (
    Deviation,
    change_by_collapse,
    change_by_move,
    deviation_around,
    hand_over_samples,
    no_deviation,
    redistribute_samples,
    start_at_vertices,
    step_towards_reference,
)
from gamutcore.decimation.memoryless import (
    Memoryless,
    account_for_volume,
    constrained_optimum,
    error_of_place,
    memoryless,
    renew_planes,
)
from gamutcore.decimation.star import Surface
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["FinestState", "state"]

COMPARED_VERTICES = 10_000
"""Levels with so many vertices and fewer are ordered by the mismatch."""

MOVED_VERTICES = 2000
"""Vertices are moved in levels with so many of them and fewer."""

WORTHWHILE = 1e-3
"""Part of the deviation around a vertex that a move has to save."""

ATTEMPTS = 3
"""Lengths that are tried for a move, each half the one before."""


class FinestState(NamedTuple):
    """The planes around every vertex, and the deviation from the full boundary.

    Attributes
    ----------
    planes : Memoryless
    deviation : Deviation
    phase : (2,) uint8
        Whether the deviation decides yet, and whether vertices are moved yet.
    trial : (3,) float64
        Scratch: a place that is tried.
    """

    planes: Memoryless
    deviation: Deviation
    phase: ByteArray
    trial: FloatArray


def state(positions: FloatArray, faces: IndexArray) -> FinestState:
    """Return the state before the first collapse.

    Parameters
    ----------
    positions : (V, 3) float64
    faces : (F, 3) int32

    Returns
    -------
    FinestState
    """
    return FinestState(
        memoryless(positions, faces),
        no_deviation(len(positions), len(faces)),
        np.zeros(2, np.uint8),
        np.zeros(3),
    )


@leaf_kernel
def _optimum(cost: FinestState, surface: Surface, at: int, place: FloatArray) -> float:
    value = constrained_optimum(cost.planes, surface, at, place)
    return change_by_collapse(cost.deviation, surface, at, place) if cost.phase[0] else value


@leaf_kernel
def _error(cost: FinestState, surface: Surface, at: int, place: FloatArray) -> float:
    if cost.phase[0]:
        return change_by_collapse(cost.deviation, surface, at, place)
    return error_of_place(cost.planes, surface, at, place)


@leaf_kernel
def _merge(
    cost: FinestState, surface: Surface, at: int, kept: int, dead: int, place: FloatArray
) -> None:
    account_for_volume(cost.planes, surface, at, place)
    hand_over_samples(cost.deviation, surface, at)


@leaf_kernel
def _settle(cost: FinestState, surface: Surface, at: int) -> None:
    renew_planes(cost.planes, surface, at)
    redistribute_samples(cost.deviation, surface, at)


@kernel
def _reach(cost: FinestState, surface: Surface, at: int) -> bool:
    if cost.deviation.counts[2] == 0:
        start_at_vertices(cost.deviation, surface)
    cost.phase[1] = at <= MOVED_VERTICES
    if cost.phase[0] or at > COMPARED_VERTICES:
        return False
    cost.phase[0] = 1
    return True


@leaf_kernel
def _improve(cost: FinestState, surface: Surface, at: int, place: FloatArray) -> bool:
    if not cost.phase[1] or not step_towards_reference(cost.deviation, surface, at, cost.trial):
        return False
    position, trial = surface.position, cost.trial
    present = 0.0
    length = 1.0
    for _ in range(ATTEMPTS):
        for axis in range(3):
            place[axis] = position[at, axis] + length * (trial[axis] - position[at, axis])
        change = change_by_move(cost.deviation, surface, at, place)
        present = deviation_around(cost.deviation)
        if change < -WORTHWHILE * present:
            return True
        length *= 0.5
    return False


interface.implement(
    FinestState,
    optimum=_optimum,
    error=_error,
    merge=_merge,
    settle=_settle,
    reach=_reach,
    improve=_improve,
    depends_on_ring=True,
)
