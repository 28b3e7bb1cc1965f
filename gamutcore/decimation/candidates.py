"""Where the new vertex of a collapse may go: candidate positions, their reach and their rounding.

The first candidate is the cost's optimum. The others are there for edges where it is not valid: the
midpoint, the two ends, and the deepest direction of the cone of valid ones, each moved along its
radius to where the enclosed volume is kept.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.costs.interface import optimum
from gamutcore.decimation.star import (
    Surface,
    kernel_direction,
    scale_to_preserve_volume,
    volume_slope,
)
from gamutcore.kernels import leaf_kernel

__all__ = [
    "CANDIDATES",
    "candidate",
    "rounded_as_delivered",
    "rounded_to_volume",
    "within_reach",
]

CANDIDATES = 5
"""Positions tried for an edge: optimum, midpoint, its two ends, the middle of the valid cone."""

LARGEST_STEPS = 2.0**24
"""Steps of the grid that float32 holds exactly, and that a history stores."""

REACH = 2.0
"""How far from the edge's midpoint a vertex may be placed, in radii of its star: beyond lie spikes
(CGAL issue 8213)."""


@leaf_kernel
def candidate(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    corner: int,
    choice: int,
    ring: IndexArray,
    count: int,
    slope: FloatArray,
    place: FloatArray,
) -> bool:
    """Write candidate number `choice` for an edge; False if there is none of that number.

    Parameters
    ----------
    cost : NamedTuple of arrays
    surface : Surface
    corner : int
        One of the two corners that face the edge.
    choice : int
        0 to `CANDIDATES` − 1.
    ring : (m, 2) int32
        The edge's directed link, `count` pairs of it.
    count : int
    slope : (3,) float64
        Scratch.
    place : (3,) float64
        Receives the position, relative to the centre.

    Returns
    -------
    bool
    """
    position = surface.position
    if choice == 0:
        optimum(cost, surface, corner, place)
        return True
    kept, dead = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    if choice == 2 or choice == 3:
        end = kept if choice == 2 else dead
        place[0], place[1], place[2] = position[end, 0], position[end, 1], position[end, 2]
    else:
        for axis in range(3):
            place[axis] = 0.5 * (position[kept, axis] + position[dead, axis])
        if choice == 4 and not kernel_direction(position, ring, count, place):
            return False
    volume_slope(position, ring, count, slope)
    return scale_to_preserve_volume(surface, kept, dead, slope, place)


@leaf_kernel
def within_reach(
    position: FloatArray, ring: IndexArray, count: int, kept: int, dead: int, place: FloatArray
) -> bool:
    """Whether a position is at most `REACH` star radii from the edge's midpoint."""
    mx = 0.5 * (position[kept, 0] + position[dead, 0])
    my = 0.5 * (position[kept, 1] + position[dead, 1])
    mz = 0.5 * (position[kept, 2] + position[dead, 2])
    squared_radius = 0.0
    for pair in range(count):
        one = ring[pair, 0]
        x, y, z = position[one, 0] - mx, position[one, 1] - my, position[one, 2] - mz
        squared_radius = max(squared_radius, x * x + y * y + z * z)
    x, y, z = place[0] - mx, place[1] - my, place[2] - mz
    return x * x + y * y + z * z <= REACH * REACH * squared_radius


@leaf_kernel
def rounded_as_delivered(
    place: FloatArray, centre: FloatArray, step: float, delivered: Float32Array
) -> bool:
    """Round a position to the grid that is delivered.

    Parameters
    ----------
    place : (3,) float64
        Relative to the centre; replaced by the rounded position.
    centre : (3,) float64
    step : float
        The grid's, a power of two.
    delivered : (3,) float32
        Receives the rounded position in coordinates of the space.

    Returns
    -------
    bool
        Whether it is on the grid that is delivered: False far outside, beyond 2²⁴ steps.
    """
    exact = True
    for axis in range(3):
        # + 0.0: no negative zeros
        on_grid = np.rint((place[axis] + centre[axis]) / step) * step + 0.0
        delivered[axis] = np.float32(on_grid)
        exact = exact and abs(on_grid) <= LARGEST_STEPS * step
        place[axis] = on_grid - centre[axis]
    return exact


@leaf_kernel
def rounded_to_volume(
    place: FloatArray,
    centre: FloatArray,
    step: float,
    slope: FloatArray,
    volume: float,
    delivered: Float32Array,
) -> bool:
    """Round a position to that corner of its cell of the grid which comes closest to a volume.

    Parameters
    ----------
    place, centre, step, delivered
        As for `rounded_as_delivered`.
    slope : (3,) float64
        `volume_slope` of the ring around the position.
    volume : float
        Six times the volume that should be enclosed between the ring, the position and the centre.

    Returns
    -------
    bool
        As for `rounded_as_delivered`.
    """
    exact = True
    x = np.floor((place[0] + centre[0]) / step)
    y = np.floor((place[1] + centre[1]) / step)
    z = np.floor((place[2] + centre[2]) / step)
    best, chosen = np.inf, 0
    for corner in range(8):
        px = (x + (corner & 1)) * step - centre[0]
        py = (y + (corner >> 1 & 1)) * step - centre[1]
        pz = (z + (corner >> 2)) * step - centre[2]
        miss = abs(px * slope[0] + py * slope[1] + pz * slope[2] - volume)
        if miss < best:
            best, chosen = miss, corner
    for axis in range(3):
        below = x if axis == 0 else (y if axis == 1 else z)
        on_grid = (below + (chosen >> axis & 1)) * step + 0.0
        delivered[axis] = np.float32(on_grid)
        exact = exact and abs(on_grid) <= LARGEST_STEPS * step
        place[axis] = on_grid - centre[axis]
    return exact
