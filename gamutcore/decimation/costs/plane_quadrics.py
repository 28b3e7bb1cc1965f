"""The published cost: accumulated, unweighted plane quadrics.

Garland & Heckbert, "Surface Simplification Using Quadric Error Metrics" (1997), as Bakke & Farup
use it. A face with unit normal n and offset d has the quadric (A, b, c) = (n nᵀ, d n, d²). Its
value D²(v) = vᵀA v + 2 bᵀv + c is the squared distance of v from the plane of the face. A vertex
starts with the sum over its faces, and a collapse adds the quadrics of its two ends.

The quadric of each vertex is stored relative to the vertex and moved to the midpoint of the edge
for a collapse. The polynomial is the same, without the cancellation of absolute coordinates.
`REGULARISATION` and `FLATNESS` are additions to the publication that keep every level valid.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.costs.memoryless_quadrics import FLATNESS, REGULARISATION, Quadrics
from gamutcore.decimation.star import Surface, squared_length
from gamutcore.decimation.vectors import (
    Symmetric,
    Vector,
    add_outer,
    adjugate,
    cross,
    dot,
    linear_combination,
    minus,
    plus,
    product,
    quadratic_form,
    row,
    symmetric_row,
    write_row,
    write_symmetric_row,
)
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["accumulate", "plane_error", "plane_optimum", "vertex_quadrics"]

QUADRIC_SIZE, LINEAR, CONSTANT = 10, 6, 9
"""Numbers of a quadric: A on and above its diagonal, from index 6 on b, and at index 9 c."""


@kernel
def vertex_quadrics(positions: FloatArray, faces: IndexArray) -> FloatArray:
    """Return the quadric of every vertex of a full boundary, relative to the vertex, (V, 10)."""
    quadrics = np.zeros((len(positions), QUADRIC_SIZE))
    for face in range(len(faces)):
        one, two, three = int(faces[face, 0]), int(faces[face, 1]), int(faces[face, 2])
        start = row(positions, one, 0)
        normal = cross(minus(row(positions, two, 0), start), minus(row(positions, three, 0), start))
        length = np.sqrt(dot(normal, normal))
        if length > 0.0:
            normal = (normal[0] / length, normal[1] / length, normal[2] / length)
        for corner in (one, two, three):  # each corner lies in the plane, so d = 0 relative to it
            square = add_outer(symmetric_row(quadrics, corner), 1.0, normal)
            write_symmetric_row(quadrics, corner, square)
    return quadrics


@leaf_kernel
def _sum_at_point(
    sums: FloatArray, surface: Surface, one: int, two: int, origin: FloatArray
) -> tuple[Symmetric, Vector, float]:
    """Sum of two vertices' quadrics, relative to an origin."""
    linear = plus(row(sums, one, LINEAR), row(sums, two, LINEAR))
    c = sums[one, CONSTANT] + sums[two, CONSTANT]
    for end in (one, two):
        offset = minus((origin[0], origin[1], origin[2]), row(surface.position, end, 0))
        change = product(symmetric_row(sums, end), offset)
        linear = plus(linear, change)
        c += 2.0 * dot(row(sums, end, LINEAR), offset) + dot(change, offset)
    square = linear_combination(symmetric_row(sums, one), 1.0, symmetric_row(sums, two))
    return square, linear, c


@leaf_kernel
def plane_optimum(quadrics: Quadrics, surface: Surface, corner: int, point: FloatArray) -> float:
    """Write the position of least error for the vertex that replaces an edge; return the error.

    The position is relative to the centre. The error is a sum of squared distances from planes.
    """
    one, two = int(surface.vertex[following(corner)]), int(surface.vertex[preceding(corner)])
    for axis in range(3):
        point[axis] = 0.5 * (surface.position[one, axis] + surface.position[two, axis])
    square, linear, constant = _sum_at_point(quadrics.sums, surface, one, two, point)
    trace = square[0] + square[3] + square[5]
    inverse, determinant = adjugate(square, REGULARISATION * trace)
    x, y, z = 0.0, 0.0, 0.0
    if determinant > 0.0:
        x, y, z = product(inverse, linear)
        x, y, z = -x / determinant, -y / determinant, -z / determinant
    point[0], point[1], point[2] = point[0] + x, point[1] + y, point[2] + z
    error = quadratic_form(square, (x, y, z)) + 2.0 * dot(linear, (x, y, z)) + constant
    return max(error, 0.0) + FLATNESS * trace * squared_length(surface, corner)


@leaf_kernel
def plane_error(quadrics: Quadrics, surface: Surface, corner: int, point: FloatArray) -> float:
    """Error of replacing an edge by a vertex at a position, as in `plane_optimum`."""
    one, two = int(surface.vertex[following(corner)]), int(surface.vertex[preceding(corner)])
    square, _, constant = _sum_at_point(quadrics.sums, surface, one, two, point)
    trace = square[0] + square[3] + square[5]
    return max(constant, 0.0) + FLATNESS * trace * squared_length(surface, corner)


@leaf_kernel
def accumulate(
    quadrics: Quadrics, surface: Surface, kept: int, dead: int, point: FloatArray
) -> None:
    """Give the kept vertex the sum of both quadrics, relative to its new position."""
    square, linear, constant = _sum_at_point(quadrics.sums, surface, kept, dead, point)
    write_symmetric_row(quadrics.sums, kept, square)
    write_row(quadrics.sums, kept, LINEAR, linear)
    quadrics.sums[kept, CONSTANT] = constant
