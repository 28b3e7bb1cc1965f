"""Single triangles and convex polygons: the closest point, and clipping by a plane."""

from __future__ import annotations

from typing import SupportsIndex

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.geometry.vectors import Vector, cross, dot, minus, row, scaled
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = ["clip", "closest_point", "face_corners"]

THIN = 1e-6
"""Squared sine of the angle of a triangle below which it counts as thin. The weights of the
projection are then corrected once, and the edges are tried as well."""


@inlined_kernel
def face_corners(
    position: FloatArray, faces: IndexArray, face: SupportsIndex
) -> tuple[Vector, Vector, Vector]:
    """Return the corners of a face of a mesh with vertices (V, 3) and faces (F, 3)."""
    one, two, three = row(faces, np.uint64(face), 0)
    return (
        row(position, np.uint64(one), 0),
        row(position, np.uint64(two), 0),
        row(position, np.uint64(three), 0),
    )


@inlined_kernel
def closest_point(point: Vector, b: Vector, c: Vector) -> tuple[float, float, float]:
    """Return the squared distance of a point from a triangle, and the weights of two corners there.

    All are relative to the first corner; b and c are the second and the third. The weights are
    within rounding of the best, and the point u b + v c has this distance. The region of the point
    is found as in C. Ericson, "Real-Time Collision Detection" (2005), section 5.1.5, except that a
    point outside is projected on all edges. This is also right for triangles so thin that rounding
    errors leave their normal open.
    """
    normal = cross(b, c)
    bb, cc, whole = dot(b, b), dot(c, c), dot(normal, normal)
    square, u, v = np.inf, 0.0, 0.0
    # the projection on the plane, if there is one and it is inside the triangle
    towards_b, towards_c = cross(c, normal), cross(normal, b)
    u, v = dot(towards_b, point), dot(towards_c, point)
    if whole > 0.0 and u >= 0.0 and v >= 0.0 and u + v <= whole:
        u, v = u / whole, v / whole
        rest = _rest(point, b, c, u, v)
        if whole > THIN * bb * cc:
            return dot(rest, rest), u, v
        u = max(u + dot(towards_b, rest) / whole, 0.0)
        v = min(max(v + dot(towards_c, rest) / whole, 0.0), 1.0)
        u = min(u, 1.0 - v)
        rest = _rest(point, b, c, u, v)
        square = dot(rest, rest)
    share = min(max(dot(b, point) / bb, 0.0), 1.0)
    rest = _rest(point, b, c, share, 0.0)
    if dot(rest, rest) < square:
        square, u, v = dot(rest, rest), share, 0.0
    share = min(max(dot(c, point) / cc, 0.0), 1.0)
    rest = _rest(point, b, c, 0.0, share)
    if dot(rest, rest) < square:
        square, u, v = dot(rest, rest), 0.0, share
    edge = minus(c, b)
    share = min(max(dot(edge, minus(point, b)) / dot(edge, edge), 0.0), 1.0)
    rest = _rest(point, b, c, 1.0 - share, share)
    if dot(rest, rest) < square:
        square, u, v = dot(rest, rest), 1.0 - share, share
    return square, u, v


@inlined_kernel
def _rest(point: Vector, b: Vector, c: Vector, u: float, v: float) -> Vector:
    """Return point − u b − v c."""
    return minus(minus(point, scaled(u, b)), scaled(v, c))


@leaf_kernel
def clip(
    source: FloatArray, count: int, normal: Vector, constant: float, target: FloatArray
) -> int:
    """Clip a convex polygon to normal · p + constant ≥ 0; return the number of corners.

    The first `count` rows of `source` are the corners. The part is written to `target`, which has
    room for one corner more. Source: I. E. Sutherland & G. W. Hodgman, "Reentrant polygon
    clipping" (1974).
    """
    kept, last = 0, count - 1
    if count == 0:
        return 0
    before = dot(normal, row(source, last, 0)) + constant
    for index in range(count):
        here = dot(normal, row(source, index, 0)) + constant
        if (before < 0.0) != (here < 0.0):
            share = before / (before - here)
            for axis in range(3):
                start = source[last, axis]
                target[kept, axis] = start + share * (source[index, axis] - start)
            kept += 1
        if here >= 0.0:
            for axis in range(3):
                target[kept, axis] = source[index, axis]
            kept += 1
        last, before = index, here
    return kept
