"""Candidate positions for the new vertex of a collapse, their reach and their rounding.

The first candidate is the optimum of the cost. The others serve edges whose optimum is not valid:
the midpoint, the two ends, and the deepest direction of the cone of valid directions. Each of them
is moved along its radius so that the collapse preserves the volume.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.costs.dispatch import CostState, find_optimum
from gamutcore.decimation.star import (
    Surface,
    find_inner_direction,
    scale_to_preserve_volume,
    write_volume_gradient,
)
from gamutcore.kernels import leaf_kernel

__all__ = [
    "CANDIDATES",
    "Grid",
    "round_to_grid",
    "write_candidate",
]

CANDIDATES = 5
"""Number of candidates of an edge: the optimum, the midpoint, its two ends, inside of the cone."""

OPTIMUM, MIDPOINT, FIRST_END, SECOND_END, CONE = range(CANDIDATES)

LARGEST_STEPS = 2.0**24
"""Largest number of grid steps that float32 holds exactly, and that a history stores."""


class Grid(NamedTuple):
    """The grid that all positions of all levels lie on.

    Attributes
    ----------
    position : (V, 3) float32
        Positions of the surface in coordinates of the colour space.
    centre : (3,) float64
        Origin of `Surface.position` in coordinates of the colour space.
    step : float
        Distance of neighbouring grid lines, a power of two.
    """

    position: Float32Array
    centre: FloatArray
    step: float


@leaf_kernel
def write_candidate(
    state: CostState,
    surface: Surface,
    corner: int,
    choice: int,
    link: IndexArray,
    count: int,
    gradient: FloatArray,
    point: FloatArray,
) -> bool:
    """Write a candidate position of an edge.

    Parameters
    ----------
    state : CostState
    surface : Surface
    corner : int
        One of the two corners that face the edge.
    choice : int
        Number of the candidate: 0 to `CANDIDATES` − 1.
    link : (m, 2) int32
        The edge's directed link of `count` pairs.
    count : int
    gradient : (3,) float64
        Scratch.
    point : (3,) float64
        Receives the position, relative to the centre.

    Returns
    -------
    bool
        False if the edge has no such candidate.
    """
    position = surface.position
    if choice == OPTIMUM:
        find_optimum(state, surface, corner, point)
        return True
    kept = int(surface.vertex[following(corner)])
    dead = int(surface.vertex[preceding(corner)])
    if choice in (FIRST_END, SECOND_END):
        end = kept if choice == FIRST_END else dead
        point[0], point[1], point[2] = position[end, 0], position[end, 1], position[end, 2]
    else:
        for axis in range(3):
            point[axis] = 0.5 * (position[kept, axis] + position[dead, axis])
        if choice == CONE and not find_inner_direction(position, link, count, point):
            return False
    write_volume_gradient(position, link, count, gradient)
    return scale_to_preserve_volume(surface, kept, dead, gradient, point)


@leaf_kernel
def round_to_grid(grid: Grid, point: FloatArray, rounded: Float32Array) -> bool:
    """Round a position to the nearest grid point.

    Parameters
    ----------
    grid : Grid
    point : (3,) float64
        Relative to the centre; replaced by the rounded position.
    rounded : (3,) float32
        Receives the rounded position in coordinates of the colour space.

    Returns
    -------
    bool
        False if the position lies beyond 2²⁴ steps, where float32 does not hold the grid.
    """
    exact = True
    for axis in range(3):
        # adding 0.0 turns negative zeros into zeros
        on_grid = np.rint((point[axis] + grid.centre[axis]) / grid.step) * grid.step + 0.0
        rounded[axis] = np.float32(on_grid)
        exact = exact and abs(on_grid) <= LARGEST_STEPS * grid.step
        point[axis] = on_grid - grid.centre[axis]
    return exact
