"""Candidate positions for the new vertex of a collapse, and their rounding to the grid.

The first candidate is the optimum of the cost. The others serve edges whose optimum is not valid:
the midpoint, the two ends, and the deepest direction of the cone of valid directions. Each of them
is moved along its radius so that the collapse preserves the volume.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.costs.dispatch import find_optimum
from gamutcore.decimation.stage import Grid, Stage
from gamutcore.decimation.star import find_inner_direction, scale_to_preserve_volume
from gamutcore.kernels import leaf_kernel

__all__ = ["CANDIDATES", "round_to_grid", "write_candidate"]

CANDIDATES = 5
"""Number of candidates of an edge: the optimum, the midpoint, its two ends, inside of the cone."""

OPTIMUM, MIDPOINT, FIRST_END, SECOND_END, CONE = range(CANDIDATES)

LARGEST_STEPS = 2.0**24
"""Largest number of grid steps that float32 holds exactly, and that a history stores."""


@leaf_kernel
def write_candidate(
    stage: Stage, corner: int, choice: int, link: IndexArray, count: int, point: FloatArray
) -> bool:
    """Write candidate `choice` of the edge that `corner` faces; False if the edge has none.

    `link` is the edge's directed link of `count` pairs. `point` receives the position, relative to
    the centre.
    """
    if choice == OPTIMUM:
        find_optimum(stage, corner, point)
        return True
    surface, position = stage.surface, stage.surface.position
    kept, dead = int(surface.vertex[following(corner)]), int(surface.vertex[preceding(corner)])
    one = dead if choice == SECOND_END else kept
    two = kept if choice == FIRST_END else dead
    for axis in range(3):
        point[axis] = 0.5 * (position[one, axis] + position[two, axis])
    if choice == CONE and not find_inner_direction(position, link, count, point):
        return False
    return scale_to_preserve_volume(surface, kept, dead, link, count, point)


@leaf_kernel
def round_to_grid(grid: Grid, point: FloatArray, rounded: Float32Array) -> bool:
    """Round a position, relative to the centre, in place to the nearest grid point.

    `rounded` receives the same position in coordinates of the colour space. The result is False
    beyond 2²⁴ steps, where float32 does not hold the grid.
    """
    exact = True
    for axis in range(3):
        # adding 0.0 turns negative zeros into zeros
        on_grid = np.rint((point[axis] + grid.centre[axis]) / grid.step) * grid.step + 0.0
        rounded[axis] = np.float32(on_grid)
        exact = exact and abs(on_grid) <= LARGEST_STEPS * grid.step
        point[axis] = on_grid - grid.centre[axis]
    return exact
