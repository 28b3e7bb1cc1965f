"""The default cost: memoryless quadrics under exact preservation of volume.

Positions are those of `gamutcore.decimation.memoryless` at all levels, and so are the errors down
to 4000 faces. From there on, where the order of few collapses decides, an edge's error is the
change of the mismatch itself, against the surface as it was when they began: by samples of it, so
the time that takes does not depend on the size of the boundary.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.decimation.costs import interface
from gamutcore.decimation.memoryless import (
    Memoryless,
    account_for_volume,
    constrained_optimum,
    error_of_place,
    memoryless,
    memoryless_on,
    renew_planes,
)
from gamutcore.decimation.plan import Fork, Plan
from gamutcore.decimation.redistribution import (
    hand_over_samples,
    redistribute_samples,
    thin_samples,
)
from gamutcore.decimation.refinement import error_by_mismatch, refined_place
from gamutcore.decimation.samples import (
    Deviation,
    deviation_on,
    no_deviation,
    room_for_samples,
    take_samples,
)
from gamutcore.decimation.star import Surface
from gamutcore.decimation.sweeps import SWEPT_DOWN_TO
from gamutcore.kernels import leaf_kernel

__all__ = ["PLAN", "PRESERVES_VOLUME", "VolumeState", "state"]

PRESERVES_VOLUME = True
"""Every level encloses the full boundary's volume, to 10⁻⁵ of it where the grid allows that."""

TRACKED_VERTICES = 2000
"""Levels with so many vertices and fewer are compared with samples of the first of them."""


REFINED_VERTICES = 700
"""In levels with so many vertices and fewer the place of a collapse is moved, at the same volume,
to lower the mismatch before its error counts."""

REFINED_FURTHER = 200
"""In levels with so many vertices and fewer it is moved twice: few collapses decide most."""


SAMPLES = 16_000
"""Samples of the reference, at least about: every face has one, larger ones have several."""

SAMPLES_PER_FACE = 12
"""When there are twice as many on average, half of the samples go: what an edge's error takes to
evaluate stays the same, and the errors of large faces are as well known as those of small ones."""


THINNED_DOWN_TO = 100
"""Vertices below which no more samples go: the few collapses that are left decide most."""


class VolumeState(NamedTuple):
    """The planes around every vertex, and the deviation from the reference of the coarse levels.

    Attributes
    ----------
    planes : Memoryless
    deviation : Deviation
    vertices : (1,) int32
        How many there are at the present level.
    trial : (3,) float64
        Scratch: a place that is tried.
    """

    planes: Memoryless
    deviation: Deviation
    vertices: IndexArray
    trial: FloatArray


def state(positions: FloatArray, faces: IndexArray) -> VolumeState:
    """Return the state before the first collapse.

    Parameters
    ----------
    positions : (V, 3) float64
    faces : (F, 3) int32

    Returns
    -------
    VolumeState
    """
    tracked_faces = 2 * min(TRACKED_VERTICES, len(positions)) - 4
    return VolumeState(
        memoryless(positions, faces),
        no_deviation(room_for_samples(SAMPLES, tracked_faces), len(faces)),
        # more than are tracked, so that samples are taken however few there are
        np.full(1, max(len(positions), TRACKED_VERTICES) + 1, np.int32),
        np.zeros(3),
    )


def _state_on(state: VolumeState, vertices: IndexArray, faces: IndexArray) -> VolumeState:
    return VolumeState(
        memoryless_on(state.planes, vertices, faces),
        deviation_on(state.deviation, faces),
        state.vertices.copy(),
        state.trial.copy(),
    )


def _deviation(state: VolumeState) -> float:
    return float(state.deviation.error.sum())


PLAN = Plan(
    compacted=(SWEPT_DOWN_TO, TRACKED_VERTICES),
    forks=(Fork(100, 4, (27,)),),
    state_on=_state_on,
    deviation=_deviation,
)
"""Four ways from 200 triangles on are compared at 50, where levels scatter most."""


@leaf_kernel
def _optimum(cost: VolumeState, surface: Surface, at: int, place: FloatArray) -> float:
    value = constrained_optimum(cost.planes, surface, at, place)
    if cost.vertices[0] > TRACKED_VERTICES:
        return value
    steps = 0
    if cost.vertices[0] <= REFINED_VERTICES:
        steps = 2 if cost.vertices[0] <= REFINED_FURTHER else 1
    return refined_place(cost.deviation, cost.planes, surface, at, place, cost.trial, steps, True)


@leaf_kernel
def _error(cost: VolumeState, surface: Surface, at: int, place: FloatArray) -> float:
    if cost.vertices[0] > TRACKED_VERTICES:
        return error_of_place(cost.planes, surface, at, place)
    return error_by_mismatch(cost.deviation, surface, at, place)


@leaf_kernel
def _merge(
    cost: VolumeState, surface: Surface, at: int, kept: int, dead: int, place: FloatArray
) -> None:
    account_for_volume(cost.planes, surface, at, place)
    if cost.vertices[0] <= TRACKED_VERTICES:
        hand_over_samples(cost.deviation, surface, at)


@leaf_kernel
def _settle(cost: VolumeState, surface: Surface, at: int) -> None:
    renew_planes(cost.planes, surface, at)
    if cost.vertices[0] <= TRACKED_VERTICES:
        redistribute_samples(cost.deviation, surface, at)


@leaf_kernel
def _reach(cost: VolumeState, surface: Surface, at: int) -> bool:
    begins = at <= TRACKED_VERTICES and cost.vertices[0] > TRACKED_VERTICES
    if begins:
        take_samples(cost.deviation, surface, SAMPLES, True)
    cost.vertices[0] = at
    most = 4 * SAMPLES_PER_FACE * max(at, THINNED_DOWN_TO)
    return thin_samples(cost.deviation, surface, most) or begins


interface.implement(
    VolumeState,
    optimum=_optimum,
    error=_error,
    merge=_merge,
    settle=_settle,
    reach=_reach,
    depends_on_ring=True,
    eager_collapses=1000,
    preserves_volume=PRESERVES_VOLUME,
)
