"""Errors of collapses by the change of the mismatch, and places that are moved to lower it."""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.decimation.deviation import (
    ask_for_edge,
    change_at,
    shortness,
)
from gamutcore.decimation.memoryless import Memoryless, keep_volume
from gamutcore.decimation.samples import Deviation
from gamutcore.decimation.star import Surface
from gamutcore.decimation.steps import step_towards_reference
from gamutcore.kernels import leaf_kernel

__all__ = ["error_by_mismatch", "refined_place"]


@leaf_kernel
def error_by_mismatch(
    deviation: Deviation, surface: Surface, corner: int, place: FloatArray
) -> float:
    """Error of replacing an edge by a vertex: how the deviation from the reference changes.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
    corner : int
        One of the two corners that face the edge.
    place : (3,) float64
        Relative to the centre.

    Returns
    -------
    float
        In six times the volume's unit; infinite for very large rings and for hubs.
    """
    if not ask_for_edge(deviation, surface, corner):
        return np.inf
    return change_at(deviation, surface, place) + shortness(deviation, surface, corner)


@leaf_kernel
def refined_place(
    deviation: Deviation,
    planes: Memoryless,
    surface: Surface,
    corner: int,
    place: FloatArray,
    trial: FloatArray,
    steps: int,
    keeps_volume: bool,
) -> float:
    """Move a place towards less deviation as long as that helps, and return its error.

    Parameters
    ----------
    deviation : Deviation
    planes : Memoryless
        As `constrained_optimum` left it for the edge.
    surface : Surface
    corner : int
        One of the two corners that face the edge.
    place : (3,) float64
        Relative to the centre; moved.
    trial : (3,) float64
        Scratch.
    steps : int
        Moves at most.
    keeps_volume : bool
        Whether the place stays where the volume is preserved.

    Returns
    -------
    float
        As `error_by_mismatch`.
    """
    if not ask_for_edge(deviation, surface, corner):
        return np.inf
    least = change_at(deviation, surface, place)
    short = shortness(deviation, surface, corner)
    for _ in range(steps):
        if not step_towards_reference(deviation, place, trial):
            break
        if keeps_volume:
            keep_volume(planes, trial)
        change = change_at(deviation, surface, trial)
        if not change < least:
            break
        least = change
        place[0], place[1], place[2] = trial[0], trial[1], trial[2]
    return least + short
