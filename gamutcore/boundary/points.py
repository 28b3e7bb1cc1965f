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
    """Return the points on their grid, and the given or automatic centre.

    Parameters
    ----------
    points : (n, 3) array_like
    centre : (3,) array_like or "auto"

    Returns
    -------
    rounded : (n, 3) float64
        The points, rounded to their grid.
    middle : (3,) float64
        The centre on the same grid, strictly inside the convex hull of the points.

    Raises
    ------
    InvalidPointsError, TooFewPointsError, FlatPointsError, CentreError, OptionError, BoundaryError
        As `modified_convex_hull`.
    """
    # only the convex hull tells whether the centre is inside
    middle = modified_convex_hull(points, 1.0, centre).centre
    given = np.asarray(points, np.float64)
    return nearest_grid_points(given, grid_step(given)), middle


def farthest_points(segment: LongArray, radii: FloatArray, count: int) -> LongArray:
    """Return the farthest point of every segment.

    Parameters
    ----------
    segment : (n,) int64
        Segment of each point, 0 to `count` − 1.
    radii : (n,) float64
        Distances from the centre.
    count : int
        Number of segments.

    Returns
    -------
    (count,) int64
        Index of a point, the first of equally far ones; −1 for a segment without points.

    Examples
    --------
    >>> farthest_points(np.array([0, 0, 2]), np.array([1.0, 2.0, 3.0]), 3).tolist()
    [1, -1, 2]
    """
    outwards = np.lexsort((-np.arange(len(radii)), radii))
    farthest = np.full(count, -1, np.int64)
    farthest[segment[outwards]] = outwards  # the last of several assignments remains
    return farthest
