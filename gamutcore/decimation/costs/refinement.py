"""Errors of collapses by the change of the mismatch, and positions moved to lower it."""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.decimation.costs.deviation import (
    change_at,
    current_deviation,
    length_penalty,
    query_edge,
    query_vertex,
)
from gamutcore.decimation.costs.memoryless_quadrics import Quadrics, shift_to_preserve_volume
from gamutcore.decimation.costs.samples import Deviation
from gamutcore.decimation.costs.steps import step_towards_reference
from gamutcore.decimation.star import Surface
from gamutcore.kernels import leaf_kernel

__all__ = ["find_better_position", "mismatch_error", "refine_point"]

LEAST_GAIN = 1e-3
"""Fraction of the deviation around a vertex that a move must save."""

RELAXATION_FACTOR = 2.0
"""Length of a move, in units of the least-squares step.

Neighbours move the same way in their turn, so a step beyond the own optimum converges sooner
(successive over-relaxation).
"""


@leaf_kernel
def mismatch_error(deviation: Deviation, surface: Surface, corner: int, point: FloatArray) -> float:
    """Error of replacing an edge by a vertex: the change of the deviation from the reference.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
    corner : int
        One of the two corners that face the edge.
    point : (3,) float64
        Relative to the centre.

    Returns
    -------
    float
        Six times a volume; infinite for large and dense links.
    """
    if not query_edge(deviation, surface, corner):
        return np.inf
    return change_at(deviation, surface, point) + length_penalty(deviation, surface, corner)


@leaf_kernel
def refine_point(
    deviation: Deviation,
    quadrics: Quadrics,
    surface: Surface,
    corner: int,
    point: FloatArray,
    trial_point: FloatArray,
    steps: int,
    preserves_volume: bool,
) -> float:
    """Move a position towards less deviation while that helps, and return its error.

    Parameters
    ----------
    deviation : Deviation
    quadrics : Quadrics
        As `constrained_optimum` left it for the edge.
    surface : Surface
    corner : int
        One of the two corners that face the edge.
    point : (3,) float64
        Relative to the centre; moved.
    trial_point : (3,) float64
        Scratch.
    steps : int
        Largest number of moves.
    preserves_volume : bool
        Whether to keep the position where the collapse preserves the volume.

    Returns
    -------
    float
        As in `mismatch_error`.
    """
    if not query_edge(deviation, surface, corner):
        return np.inf
    least = change_at(deviation, surface, point)
    penalty = length_penalty(deviation, surface, corner)
    for _ in range(steps):
        if not step_towards_reference(deviation, point, trial_point):
            break
        if preserves_volume:
            shift_to_preserve_volume(quadrics, trial_point)
        change = change_at(deviation, surface, trial_point)
        if not change < least:
            break
        least = change
        point[0], point[1], point[2] = trial_point[0], trial_point[1], trial_point[2]
    return least + penalty


@leaf_kernel
def find_better_position(
    deviation: Deviation,
    surface: Surface,
    vertex: int,
    point: FloatArray,
    trial_point: FloatArray,
) -> bool:
    """Write a position for a vertex that lowers the deviation; False if none was found.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
    vertex : int
    point : (3,) float64
        Receives the position, relative to the centre.
    trial_point : (3,) float64
        Scratch.

    Returns
    -------
    bool
    """
    position = surface.position
    x, y, z = position[vertex, 0], position[vertex, 1], position[vertex, 2]
    point[0], point[1], point[2] = x, y, z
    if not query_vertex(deviation, surface, vertex):
        return False
    change_at(deviation, surface, point)
    if not step_towards_reference(deviation, point, trial_point):
        return False
    present = current_deviation(deviation)
    point[0] = x + RELAXATION_FACTOR * (trial_point[0] - x)
    point[1] = y + RELAXATION_FACTOR * (trial_point[1] - y)
    point[2] = z + RELAXATION_FACTOR * (trial_point[2] - z)
    return change_at(deviation, surface, point) < -LEAST_GAIN * present
