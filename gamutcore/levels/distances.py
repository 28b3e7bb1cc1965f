"""Certain bounds of the largest distance between two overlaid surfaces, within a few per cent.

The overlay (module `overlay`) gives triangles that are each seen through one face of the other
surface. Distances along rays bound distances to the surface, cheaply. Where these bounds do not
suffice, `raise_bound` halves the triangle.

The distance from a point to one face is a convex function of the point. Over a piece of surface its
maximum is at a corner of the piece. The distance from a piece to a surface is therefore at most the
largest distance of its corners to any one face. Pieces without a good bound are halved. The bound
is valid for any choice of faces, and tight for the nearest faces. Descent from face to adjacent
face finds them.

Data layout: an array of `BOUNDS` numbers has the bounds in both directions, the points where they
are attained, and the halvings that are left. The stack of pieces has the shape `STACK`.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.geometry import Vector, closest_point, dot, minus, row, scaled, write_row
from gamutcore.kernels import inlined_kernel, leaf_kernel
from gamutcore.levels.cones import INDEX, Locations, Surface

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

SLACK = 1.03
"""Ratio of a bound to an attained distance at which the bound is not improved further."""

HALVINGS = 16
"""Most halvings of a piece; its bound then stays."""

FACE, HALVED, NEAREST, SQUARED, COLUMNS = 9, 10, 11, 14, 17
"""Columns of the stack of `raise_bound`, after nine coordinates: a face near the piece, the number
of halvings, then for each corner the nearest face (−1 if unknown) and its squared distance."""

ATTAINED = HALVINGS + 2
"""Row of the stack with the point at which the lower bound was attained last."""

STACK = (HALVINGS + 3, COLUMNS)
"""Shape of the work array of `raise_bound`."""


def new_bounds(halvings: float, slack: float) -> FloatArray:
    """Return an array of bounds with nothing known."""
    bounds = np.zeros(BOUNDS)
    bounds[HALVINGS_LEFT], bounds[SLACK_USED] = halvings, slack
    return bounds


def halving_limit(surface: Surface, least: float = 10_000.0) -> float:
    """Return the most halvings of a comparison with a surface.

    A halving takes 1 to 4 µs. A quarter of the number of faces is a few times the need of device
    gamuts in CIELAB. `least` is added; smaller values give looser bounds for very flat bodies.
    """
    return least + len(surface.corner) // 12


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
        point = row(position, vertex, 0)
        face = reference.fan[INDEX(reference.fan_start[vertex + 1] - 1)]
        own = deviation[INDEX(face)]
        if locations.along[vertex] + own > bounds[FROM_LOWER]:
            _, squared = nearest_face(point, other, locations.face[vertex])
            if np.sqrt(squared) + own > bounds[FROM_LOWER]:
                bounds[FROM_LOWER] = np.sqrt(squared) + own
                bounds[FROM_POINT], bounds[FROM_POINT + 1], bounds[FROM_POINT + 2] = point
        if locations.along[vertex] + own > bounds[TO_LOWER]:
            point = scaled(1.0 / (1.0 + locations.beyond[vertex]), point)
            face, squared = nearest_face(point, reference, face)
            if np.sqrt(squared) + deviation[face] > bounds[TO_LOWER]:
                bounds[TO_LOWER] = np.sqrt(squared) + deviation[face]
                bounds[TO_POINT], bounds[TO_POINT + 1], bounds[TO_POINT + 2] = point
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
    for index in range(3):
        point = row(triangle, index, 0)
        shift = 1.0 - 1.0 / (1.0 + triangle[index, 3])
        furthest = max(furthest, shift * shift * dot(point, point))
    furthest = np.sqrt(furthest) + own
    if furthest > deviation[through]:
        # on steep faces the distance along rays is far larger than the distance from the face
        squared = 0.0
        for index in range(3):
            point = row(triangle, index, 0)
            squared = max(squared, squared_distance(point, other, through))
            point = scaled(1.0 / (1.0 + triangle[index, 3]), point)
            squared = max(squared, squared_distance(point, reference, face))
        deviation[through] = max(deviation[through], own + np.sqrt(squared))
    if furthest > bounds[FROM_UPPER]:
        for index in range(3):
            write_row(stack, 0, 3 * index, row(triangle, index, 0))
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
        for index in range(3):
            for axis in range(3):
                stack[0, 3 * index + axis] = triangle[index, axis] / (1.0 + triangle[index, 3])
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
def raise_bound(
    stack: FloatArray,
    surface: Surface,
    face: int,
    deviation: float,
    lower: float,
    upper: float,
    halvings: float,
    slack: float,
) -> tuple[float, float, float]:
    """Raise bounds of the largest distance to a surface so that they hold for a triangle too.

    `stack` begins with the corners of the triangle; `ATTAINED` receives the point if `lower` rises.
    `face` is near the triangle, and `deviation` is added to all distances. Bounds of at most
    `slack` times an attained distance are not improved. The result is `lower`, `upper` and the
    halvings left. `upper` is certain; `lower` is attained if descent found the nearest faces.
    """
    stack[0, FACE], stack[0, HALVED] = face, 0.0
    for corner in range(3):
        stack[0, NEAREST + corner] = -1.0
    top = 1
    while top > 0:
        top -= 1
        face = int(stack[top, FACE])
        accepted = max(upper, slack * lower)
        if (
            np.sqrt(_bound(stack, top, surface, face)) + surface.deviation[face] + deviation
            <= accepted
        ):
            upper = accepted
            continue
        # a half shares two corners with the whole; their nearest faces are known
        for corner in range(3):
            if stack[top, NEAREST + corner] < 0.0:
                near, squared = nearest_face(row(stack, top, 3 * corner), surface, face)
                stack[top, NEAREST + corner], stack[top, SQUARED + corner] = near, squared
        one, two = int(stack[top, NEAREST]), int(stack[top, NEAREST + 1])
        three = int(stack[top, NEAREST + 2])
        attained = max(
            np.sqrt(stack[top, SQUARED]) + surface.deviation[one],
            np.sqrt(stack[top, SQUARED + 1]) + surface.deviation[two],
            np.sqrt(stack[top, SQUARED + 2]) + surface.deviation[three],
        )
        bound = np.sqrt(_bound(stack, top, surface, one)) + surface.deviation[one]
        if two != one:
            bound = min(bound, np.sqrt(_bound(stack, top, surface, two)) + surface.deviation[two])
        if three not in (one, two):
            bound = min(
                bound, np.sqrt(_bound(stack, top, surface, three)) + surface.deviation[three]
            )
        attained, bound = attained + deviation, bound + deviation
        # after a descent that ended too early, the bound may be below the distance found
        lower = _raised(lower, min(attained, bound), stack, top)
        if bound <= max(upper, slack * lower) or halvings <= 0.0 or stack[top, HALVED] >= HALVINGS:
            upper = max(upper, bound)
            continue
        # halve the longest edge; each half starts from the face nearest to its own end
        longest, greatest = 0, -1.0
        for edge in range(3):
            along = minus(row(stack, top, 3 * edge), row(stack, top, 3 * ((edge + 1) % 3)))
            if dot(along, along) > greatest:
                longest, greatest = edge, dot(along, along)
        first, second = 3 * longest, 3 * ((longest + 1) % 3)
        for column in range(COLUMNS):
            stack[top + 1, column] = stack[top, column]
        for axis in range(3):
            middle = 0.5 * (stack[top, first + axis] + stack[top, second + axis])
            stack[top, second + axis] = middle
            stack[top + 1, first + axis] = middle
        stack[top, HALVED] += 1.0
        stack[top + 1, HALVED] = stack[top, HALVED]
        stack[top, FACE] = one if first == 0 else two if first == 3 else three
        stack[top + 1, FACE] = one if second == 0 else two if second == 3 else three
        stack[top, NEAREST + second // 3] = stack[top + 1, NEAREST + first // 3] = -1.0
        top += 2
        halvings -= 1.0
    return lower, upper, halvings


@inlined_kernel
def _raised(lower: float, attained: float, stack: FloatArray, top: int) -> float:
    """Return the larger bound; keep the furthest corner as `ATTAINED` if `attained` is larger."""
    if attained <= lower:
        return lower
    furthest = 0
    for corner in range(1, 3):
        if stack[top, SQUARED + corner] > stack[top, SQUARED + furthest]:
            furthest = corner
    write_row(stack, ATTAINED, 0, row(stack, top, 3 * furthest))
    return attained


@inlined_kernel
def _bound(piece: FloatArray, top: int, surface: Surface, face: int) -> float:
    """Largest squared distance from the corners of a piece to a face."""
    return max(
        squared_distance(row(piece, top, 0), surface, face),
        squared_distance(row(piece, top, 3), surface, face),
        squared_distance(row(piece, top, 6), surface, face),
    )


@leaf_kernel
def nearest_face(point: Vector, surface: Surface, face: int) -> tuple[int, float]:
    """Return a face near a point and its squared distance, by descent from a face.

    No face that shares a vertex with the result is nearer. On concave surfaces the result may be a
    local minimum; its distance is then an upper bound.
    """
    corner, fan_start, fan = surface.corner, surface.fan_start, surface.fan
    least = squared_distance(point, surface, face)
    before_one, before_two, before_three = -1, -1, -1
    while True:
        best = face
        for place in range(3):
            vertex = corner[3 * face + place]
            # all faces at the vertices of the previous face have been visited
            if vertex in (before_one, before_two, before_three):
                continue
            for index in range(fan_start[vertex], fan_start[vertex + 1]):
                other = fan[index]
                if other != face:
                    distance = squared_distance(point, surface, other)
                    if distance < least:
                        least, best = distance, other
        if best == face:
            return face, least
        before_one, before_two = corner[3 * face], corner[3 * face + 1]
        before_three = corner[3 * face + 2]
        face = best


@inlined_kernel
def squared_distance(point: Vector, surface: Surface, face: int) -> float:
    """Squared distance from a point to a face; rounding never makes it too small."""
    position = surface.position
    a = row(position, surface.corner[3 * face], 0)
    b = minus(row(position, surface.corner[3 * face + 1], 0), a)
    c = minus(row(position, surface.corner[3 * face + 2], 0), a)
    return closest_point(minus(point, a), b, c)[0]


@leaf_kernel
def set_corner(triangle: FloatArray, at: int, position: FloatArray, vertex: int, d: float) -> None:
    """Set a corner of a triangle to a vertex, where N · p − 1 is `d`."""
    write_row(triangle, at, 0, row(position, vertex, 0))
    triangle[at, 3] = d


@leaf_kernel
def set_crossing(
    triangle: FloatArray, at: int, position: FloatArray, one: int, two: int, share: float, d: float
) -> None:
    """Set a corner of a triangle to the point at a share of an edge, where N · p − 1 is `d`."""
    for axis in range(3):
        start = position[one, axis]
        triangle[at, axis] = start + share * (position[two, axis] - start)
    triangle[at, 3] = d
