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
from gamutcore.decimation.costs.symmetric import adjugate
from gamutcore.decimation.star import Surface, squared_length
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["QUADRIC_SIZE", "accumulate", "plane_error", "plane_optimum", "vertex_quadrics"]

QUADRIC_SIZE = 10
"""Numbers of a quadric: a00, a01, a02, a11, a12, a22, b0, b1, b2, c."""


@kernel
def vertex_quadrics(positions: FloatArray, faces: IndexArray) -> FloatArray:
    """Return the quadric of every vertex of a full boundary, relative to the vertex.

    Parameters
    ----------
    positions : (V, 3) float64
    faces : (F, 3) int32

    Returns
    -------
    (V, 10) float64
    """
    quadrics = np.zeros((len(positions), QUADRIC_SIZE))
    for face in range(len(faces)):
        one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
        ux = positions[two, 0] - positions[one, 0]
        uy = positions[two, 1] - positions[one, 1]
        uz = positions[two, 2] - positions[one, 2]
        vx = positions[three, 0] - positions[one, 0]
        vy = positions[three, 1] - positions[one, 1]
        vz = positions[three, 2] - positions[one, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        if length > 0.0:
            nx, ny, nz = nx / length, ny / length, nz / length
        for corner in (one, two, three):  # each corner lies in the plane, so d = 0 relative to it
            quadrics[corner, 0] += nx * nx
            quadrics[corner, 1] += nx * ny
            quadrics[corner, 2] += nx * nz
            quadrics[corner, 3] += ny * ny
            quadrics[corner, 4] += ny * nz
            quadrics[corner, 5] += nz * nz
    return quadrics


@leaf_kernel
def _sum_at_point(
    quadrics: Quadrics, surface: Surface, one: int, two: int, origin: FloatArray
) -> None:
    """Write the sum of two vertices' quadrics, relative to an origin, to `quadrics.edge`."""
    sums, position, pair = quadrics.sums, surface.position, quadrics.edge
    for index in range(QUADRIC_SIZE):
        pair[index] = sums[one, index] + sums[two, index]
    for end in (one, two):
        x = origin[0] - position[end, 0]
        y = origin[1] - position[end, 1]
        z = origin[2] - position[end, 2]
        a00, a01, a02 = sums[end, 0], sums[end, 1], sums[end, 2]
        a11, a12, a22 = sums[end, 3], sums[end, 4], sums[end, 5]
        ax = a00 * x + a01 * y + a02 * z
        ay = a01 * x + a11 * y + a12 * z
        az = a02 * x + a12 * y + a22 * z
        pair[6] += ax
        pair[7] += ay
        pair[8] += az
        pair[9] += 2.0 * (sums[end, 6] * x + sums[end, 7] * y + sums[end, 8] * z) + (
            ax * x + ay * y + az * z
        )


@leaf_kernel
def _length_penalty(surface: Surface, corner: int, pair: FloatArray) -> float:
    """Penalty of an edge's length, which orders edges whose quadrics are equal."""
    return FLATNESS * (pair[0] + pair[3] + pair[5]) * squared_length(surface, corner)


@leaf_kernel
def plane_optimum(quadrics: Quadrics, surface: Surface, corner: int, point: FloatArray) -> float:
    """Write the position of least error for the vertex that replaces an edge; return the error.

    Parameters
    ----------
    quadrics : Quadrics
    surface : Surface
    corner : int
        One of the two corners that face the edge.
    point : (3,) float64
        Receives the position, relative to the centre.

    Returns
    -------
    float
        Sum of squared distances from the planes.
    """
    pair, position = quadrics.edge, surface.position
    kept = int(surface.vertex[following(corner)])
    dead = int(surface.vertex[preceding(corner)])
    for axis in range(3):
        point[axis] = 0.5 * (position[kept, axis] + position[dead, axis])
    _sum_at_point(quadrics, surface, kept, dead, point)
    pull = REGULARISATION * (pair[0] + pair[3] + pair[5])
    i00, i01, i02, i11, i12, i22, determinant = adjugate(
        pair[0] + pull, pair[1], pair[2], pair[3] + pull, pair[4], pair[5] + pull
    )
    penalty = _length_penalty(surface, corner, pair)
    if not determinant > 0.0:
        return max(pair[9], 0.0) + penalty
    bx, by, bz = pair[6], pair[7], pair[8]
    x = -(i00 * bx + i01 * by + i02 * bz) / determinant
    y = -(i01 * bx + i11 * by + i12 * bz) / determinant
    z = -(i02 * bx + i12 * by + i22 * bz) / determinant
    point[0] += x
    point[1] += y
    point[2] += z
    quadratic = (
        pair[0] * x * x
        + pair[3] * y * y
        + pair[5] * z * z
        + 2.0 * (pair[1] * x * y + pair[2] * x * z + pair[4] * y * z)
    )
    return max(quadratic + 2.0 * (bx * x + by * y + bz * z) + pair[9], 0.0) + penalty


@leaf_kernel
def plane_error(quadrics: Quadrics, surface: Surface, corner: int, point: FloatArray) -> float:
    """Error of replacing an edge by a vertex at a position, as in `plane_optimum`."""
    kept = int(surface.vertex[following(corner)])
    dead = int(surface.vertex[preceding(corner)])
    _sum_at_point(quadrics, surface, kept, dead, point)
    return max(quadrics.edge[9], 0.0) + _length_penalty(surface, corner, quadrics.edge)


@leaf_kernel
def accumulate(
    quadrics: Quadrics, surface: Surface, kept: int, dead: int, point: FloatArray
) -> None:
    """Give the kept vertex the sum of both quadrics, relative to its new position."""
    _sum_at_point(quadrics, surface, kept, dead, point)
    for index in range(QUADRIC_SIZE):
        quadrics.sums[kept, index] = quadrics.edge[index]
