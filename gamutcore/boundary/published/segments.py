"""What the methods by segments share: points about a centre, and the farthest of each segment."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from gamutcore.boundary.modified_convex_hull import modified_convex_hull
from gamutcore.geometry import grid_step, nearest_grid_points

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.arrays import FloatArray, LongArray


def centred_points(
    points: ArrayLike, centre: ArrayLike | Literal["auto"]
) -> tuple[FloatArray, FloatArray]:
    """Return points rounded to their grid, and the given or automatic centre on the same grid.

    The centre is strictly inside the convex hull. Raises what `modified_convex_hull` raises.
    """
    # only the convex hull tells whether the centre is inside
    middle = modified_convex_hull(points, 1.0, centre).centre
    array = np.asarray(points, np.float64)
    return nearest_grid_points(array, grid_step(array)), middle


def farthest_points(segment: LongArray, radii: FloatArray, count: int) -> LongArray:
    """Return the index of the farthest point of each of `count` segments; −1 for an empty segment.

    The first of equally far points is taken.
    """
    outwards = np.lexsort((-np.arange(len(radii)), radii))
    farthest = np.full(count, -1, np.int64)
    farthest[segment[outwards]] = outwards  # the last of several assignments remains
    return farthest
