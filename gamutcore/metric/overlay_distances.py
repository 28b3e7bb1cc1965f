"""Bounds of the largest distance between two overlaid surfaces.

The overlay (`gamutcore.metric.radial_overlay`) gives pieces that are each seen through one face of
the other surface. Distances along rays bound distances to the surface, cheaply. Where these bounds
do not suffice, `raise_bound` halves the piece.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import inlined_kernel, leaf_kernel
from gamutcore.metric.cones import INDEX, Locations
from gamutcore.metric.distance_bound import (
    ATTAINED,
    Surface,
    nearest_face,
    raise_bound,
    squared_distance,
)

__all__ = [
    "BOUNDS",
    "FROM_LOWER",
    "FROM_POINT",
    "FROM_UPPER",
    "TO_FACE",
    "TO_LOWER",
    "TO_POINT",
    "TO_UPPER",
    "new_bounds",
    "raise_bounds",
    "raise_lower_bounds",
    "set_corner",
    "set_crossing",
]

FROM_LOWER, FROM_UPPER, TO_LOWER, TO_UPPER, HALVINGS_LEFT, SLACK_USED = range(6)
FROM_POINT, TO_POINT, TO_FACE, BOUNDS = 6, 9, 12, 13
"""Elements of the array of bounds, and their number.

`FROM_LOWER` and `FROM_UPPER` bound the distances from the reference to the other surface.
`TO_LOWER` and `TO_UPPER` bound those from the other surface to the reference. `HALVINGS_LEFT` is
the number of halvings that are still allowed. An upper bound of at most `SLACK_USED` times the
lower is not improved. `FROM_POINT` and `TO_POINT` are the first of the three coordinates of points
at which `FROM_LOWER` and `TO_LOWER` are attained. `TO_FACE` is the face of the other surface that
the latter point is on.
"""


def new_bounds(halvings: float, slack: float) -> FloatArray:
    """Return an array of bounds with nothing known."""
    bounds = np.zeros(BOUNDS)
    bounds[HALVINGS_LEFT], bounds[SLACK_USED] = halvings, slack
    return bounds


@leaf_kernel
def raise_lower_bounds(
    reference: Surface,
    other: Surface,
    locations: Locations,
    points: IndexArray,
    bounds: FloatArray,
) -> None:
    """Raise all bounds by some vertices (m,) of the reference, and the other surface on their rays.

    `locations` has the vertices of the reference relative to the other surface.
    """
    position, deviation = reference.position, reference.deviation
    for index in range(len(points)):
        vertex = points[index]
        x, y, z = position[vertex, 0], position[vertex, 1], position[vertex, 2]
        face = reference.fan[INDEX(reference.fan_end[vertex] - 1)]
        own = deviation[INDEX(face)]
        if locations.along[vertex] + own > bounds[FROM_LOWER]:
            _, squared = nearest_face(x, y, z, other, locations.face[vertex])
            if np.sqrt(squared) + own > bounds[FROM_LOWER]:
                bounds[FROM_LOWER] = np.sqrt(squared) + own
                bounds[FROM_POINT], bounds[FROM_POINT + 1], bounds[FROM_POINT + 2] = x, y, z
        if locations.along[vertex] + own > bounds[TO_LOWER]:
            t = 1.0 / (1.0 + locations.beyond[vertex])
            x, y, z = t * x, t * y, t * z
            face, squared = nearest_face(x, y, z, reference, face)
            if np.sqrt(squared) + deviation[face] > bounds[TO_LOWER]:
                bounds[TO_LOWER] = np.sqrt(squared) + deviation[face]
                bounds[TO_POINT], bounds[TO_POINT + 1], bounds[TO_POINT + 2] = x, y, z
                bounds[TO_FACE] = locations.face[vertex]
    slack = bounds[SLACK_USED]
    bounds[FROM_UPPER] = max(bounds[FROM_UPPER], slack * bounds[FROM_LOWER])
    bounds[TO_UPPER] = max(bounds[TO_UPPER], slack * bounds[TO_LOWER])


@leaf_kernel
def raise_bounds(
    triangle: FloatArray,
    stack: FloatArray,
    reference: Surface,
    face: int,
    other: Surface,
    through: int,
    bounds: FloatArray,
    deviation: FloatArray,
) -> None:
    """Raise the bounds so that they hold for a triangle of the reference, seen through a face.

    The distance of a corner along its ray is at least its distance from the face, in both
    directions. The largest distance of a corner holds for the whole triangle, also for `deviation`.
    """
    furthest, own = 0.0, reference.deviation[face]
    for row in range(3):
        x, y, z = triangle[row, 0], triangle[row, 1], triangle[row, 2]
        shift = 1.0 - 1.0 / (1.0 + triangle[row, 3])
        furthest = max(furthest, shift * shift * (x * x + y * y + z * z))
    furthest = np.sqrt(furthest) + own
    if furthest > deviation[through]:
        # on steep faces the distance along rays is far larger than the distance from the face
        squared = 0.0
        for row in range(3):
            x, y, z = triangle[row, 0], triangle[row, 1], triangle[row, 2]
            squared = max(squared, squared_distance(x, y, z, other, through))
            t = 1.0 / (1.0 + triangle[row, 3])
            squared = max(squared, squared_distance(t * x, t * y, t * z, reference, face))
        deviation[through] = max(deviation[through], own + np.sqrt(squared))
    if furthest > bounds[FROM_UPPER]:
        for row in range(3):
            for axis in range(3):
                stack[0, 3 * row + axis] = triangle[row, axis]
        before = bounds[FROM_LOWER]
        bounds[FROM_LOWER], bounds[FROM_UPPER], bounds[HALVINGS_LEFT] = raise_bound(
            stack,
            other,
            through,
            own,
            bounds[FROM_LOWER],
            bounds[FROM_UPPER],
            bounds[HALVINGS_LEFT],
            bounds[SLACK_USED],
        )
        if bounds[FROM_LOWER] > before:
            _keep_point(bounds, FROM_POINT, stack)
    if furthest > bounds[TO_UPPER]:
        for row in range(3):
            for axis in range(3):
                stack[0, 3 * row + axis] = triangle[row, axis] / (1.0 + triangle[row, 3])
        before = bounds[TO_LOWER]
        bounds[TO_LOWER], bounds[TO_UPPER], bounds[HALVINGS_LEFT] = raise_bound(
            stack,
            reference,
            face,
            0.0,
            bounds[TO_LOWER],
            bounds[TO_UPPER],
            bounds[HALVINGS_LEFT],
            bounds[SLACK_USED],
        )
        if bounds[TO_LOWER] > before:
            bounds[TO_FACE] = through
            _keep_point(bounds, TO_POINT, stack)


@inlined_kernel
def _keep_point(bounds: FloatArray, start: int, stack: FloatArray) -> None:
    for axis in range(3):
        bounds[start + axis] = stack[ATTAINED, axis]


@leaf_kernel
def set_corner(triangle: FloatArray, row: int, position: FloatArray, vertex: int, d: float) -> None:
    """Set a corner of a triangle to a vertex, where N · p − 1 is `d`."""
    for axis in range(3):
        triangle[row, axis] = position[vertex, axis]
    triangle[row, 3] = d


@leaf_kernel
def set_crossing(
    triangle: FloatArray, row: int, position: FloatArray, one: int, two: int, share: float, d: float
) -> None:
    """Set a corner of a triangle to the point at a share of an edge, where N · p − 1 is `d`."""
    for axis in range(3):
        start = position[one, axis]
        triangle[row, axis] = start + share * (position[two, axis] - start)
    triangle[row, 3] = d
