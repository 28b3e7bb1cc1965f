"""Helpers of the methods that divide directions into segments: points, centre, outermost points.

`modified_convex_hull` checks points and centre here as well, so these methods use the same centre
and refuse the same input with the same messages.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from gamutcore.arrays import FloatArray, LongArray
from gamutcore.boundary.modified_convex_hull import modified_convex_hull
from gamutcore.grid import grid_step, nearest_grid_points

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["centred_points", "farthest_points"]


def centred_points(
    points: ArrayLike, centre: ArrayLike | Literal["auto"]
) -> tuple[FloatArray, FloatArray]:
    """Return points rounded to their grid, and the given or automatic centre on the same grid.

    The centre is strictly inside the convex hull. Raises what `modified_convex_hull` raises.
    """
    # only the convex hull tells whether the centre is inside
    middle = modified_convex_hull(points, 1.0, centre).centre
    given = np.asarray(points, np.float64)
    return nearest_grid_points(given, grid_step(given)), middle


def farthest_points(segment: LongArray, radii: FloatArray, count: int) -> LongArray:
    """Return the index of the farthest point of each of `count` segments; −1 for an empty segment.

    The first of equally far points is taken.
    """
    outwards = np.lexsort((-np.arange(len(radii)), radii))
    farthest = np.full(count, -1, np.int64)
    farthest[segment[outwards]] = outwards  # the last of several assignments remains
    return farthest
