"""The default cost: memoryless quadrics under exact preservation of volume.

Positions are those of `gamutcore.decimation.memoryless` at all levels, and so are the errors down
to 2000 faces. From there on, where the order of few collapses decides, an edge's error is the
change of the mismatch itself, against the surface as it was when they began: by samples of it, so
the time that takes does not depend on the size of the boundary.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, FloatArray, IndexArray
from gamutcore.decimation.costs import interface
from gamutcore.decimation.deviation import (
    Deviation,
    change_by_collapse,
    hand_over_samples,
    no_deviation,
    redistribute_samples,
    start_at_surface,
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

__all__ = ["VolumeState", "state"]

TRACKED_VERTICES = 1000
"""Levels with so many vertices and fewer are compared with samples of the first of them."""


class VolumeState(NamedTuple):
    """The planes around every vertex, and the deviation from the reference of the coarse levels.

    Attributes
    ----------
    planes : Memoryless
    deviation : Deviation
    tracks : (1,) uint8
        Whether the deviation counts yet.
    """

    planes: Memoryless
    deviation: Deviation
    tracks: ByteArray


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
    samples = 4 * (2 * min(TRACKED_VERTICES, len(positions)) - 4)
    return VolumeState(
        memoryless(positions, faces), no_deviation(samples, len(faces)), np.zeros(1, np.uint8)
    )


@leaf_kernel
def _optimum(cost: VolumeState, surface: Surface, at: int, place: FloatArray) -> float:
    value = constrained_optimum(cost.planes, surface, at, place)
    return change_by_collapse(cost.deviation, surface, at, place) if cost.tracks[0] else value


@leaf_kernel
def _error(cost: VolumeState, surface: Surface, at: int, place: FloatArray) -> float:
    if cost.tracks[0]:
        return change_by_collapse(cost.deviation, surface, at, place)
    return error_of_place(cost.planes, surface, at, place)


@leaf_kernel
def _merge(
    cost: VolumeState, surface: Surface, at: int, kept: int, dead: int, place: FloatArray
) -> None:
    account_for_volume(cost.planes, surface, at, place)
    if cost.tracks[0]:
        hand_over_samples(cost.deviation, surface, at)


@leaf_kernel
def _settle(cost: VolumeState, surface: Surface, at: int) -> None:
    renew_planes(cost.planes, surface, at)
    if cost.tracks[0]:
        redistribute_samples(cost.deviation, surface, at)


@kernel
def _reach(cost: VolumeState, surface: Surface, at: int) -> bool:
    if cost.tracks[0] or at > TRACKED_VERTICES:
        return False
    start_at_surface(cost.deviation, surface)
    cost.tracks[0] = 1
    return True


interface.implement(
    VolumeState,
    optimum=_optimum,
    error=_error,
    merge=_merge,
    settle=_settle,
    reach=_reach,
    depends_on_ring=True,
    preserves_volume=True,
)
