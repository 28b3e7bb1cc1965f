"""The published cost: accumulated, unweighted plane quadrics.

Garland & Heckbert, "Surface Simplification Using Quadric Error Metrics" (1997), as Bakke & Farup use
it. A face with unit normal n and offset d has the quadric (A, b, c) = (n nᵀ, d n, d²), whose value
D²(v) = vᵀA v + 2 bᵀv + c is the squared distance of v to its plane. A vertex starts with the sum over
its faces, a collapse adds the quadrics of its two ends.

Each vertex's quadric is kept relative to the vertex itself and moved to the edge's midpoint for a
collapse: the same polynomial, without the cancellation that absolute coordinates bring.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.decimation.costs import interface
from gamutcore.decimation.star import Surface
from gamutcore.kernels import kernel

__all__ = ["QuadricState", "state"]

REGULARISATION = 1e-5
"""Weight of the midpoint in the solve, as a part of A's trace.

The publication falls back to an end of the edge where A is not invertible, which on nearly flat
sides is a question of rounding; a small pull towards the midpoint decides it continuously.
"""


class QuadricState(NamedTuple):
    """The quadrics of all vertices.

    Attributes
    ----------
    quadric : (V, 10) float64
        a00, a01, a02, a11, a12, a22, b0, b1, b2, c, relative to the vertex's own position.
    pair : (10,) float64
        Scratch: the sum for the edge at hand, relative to its midpoint.
    """

    quadric: FloatArray
    pair: FloatArray


@kernel
def _vertex_quadrics(positions: FloatArray, faces: IndexArray) -> FloatArray:
    quadrics = np.zeros((len(positions), 10))
    for face in faces:
        p, q, r = positions[face[0]], positions[face[1]], positions[face[2]]
        ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        vx, vy, vz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        if length > 0.0:
            nx, ny, nz = nx / length, ny / length, nz / length
        for corner in face:  # all three lie in the plane: seen from each of them d = 0
            total = quadrics[corner]
            total[0] += nx * nx
            total[1] += nx * ny
            total[2] += nx * nz
            total[3] += ny * ny
            total[4] += ny * nz
            total[5] += nz * nz
    return quadrics


def state(positions: FloatArray, faces: IndexArray) -> QuadricState:
    """Return the quadrics of a full boundary.

    Parameters
    ----------
    positions : (V, 3) float64
    faces : (F, 3) int32

    Returns
    -------
    QuadricState
    """
    return QuadricState(_vertex_quadrics(positions, faces), np.zeros(10))


@kernel
def _add_moved(
    total: FloatArray, quadric: FloatArray, position: FloatArray, origin: FloatArray
) -> None:
    """Add a quadric that is relative to `position` to one that is relative to `origin`."""
    x, y, z = origin[0] - position[0], origin[1] - position[1], origin[2] - position[2]
    a00, a01, a02 = quadric[0], quadric[1], quadric[2]
    a11, a12, a22 = quadric[3], quadric[4], quadric[5]
    ax = a00 * x + a01 * y + a02 * z
    ay = a01 * x + a11 * y + a12 * z
    az = a02 * x + a12 * y + a22 * z
    for index in range(6):
        total[index] += quadric[index]
    total[6] += quadric[6] + ax
    total[7] += quadric[7] + ay
    total[8] += quadric[8] + az
    total[9] += (
        quadric[9]
        + 2.0 * (quadric[6] * x + quadric[7] * y + quadric[8] * z)
        + (ax * x + ay * y + az * z)
    )


@kernel
def _pair_quadric(
    quadric: FloatArray, position: FloatArray, kept: int, dead: int, origin: FloatArray, pair: FloatArray
) -> None:
    pair[:] = 0.0
    _add_moved(pair, quadric[kept], position[kept], origin)
    _add_moved(pair, quadric[dead], position[dead], origin)


@kernel
def _midpoint(position: FloatArray, kept: int, dead: int, place: FloatArray) -> None:
    for axis in range(3):
        place[axis] = 0.5 * (position[kept, axis] + position[dead, axis])


@kernel
def _quadric_optimum(
    cost: QuadricState, surface: Surface, kept: int, dead: int, place: FloatArray
) -> None:
    pair = cost.pair
    _midpoint(surface.position, kept, dead, place)
    _pair_quadric(cost.quadric, surface.position, kept, dead, place, pair)
    pull = REGULARISATION * (pair[0] + pair[3] + pair[5])
    a, b, c = pair[0] + pull, pair[1], pair[2]
    d, e, f = pair[3] + pull, pair[4], pair[5] + pull
    # inverse of a symmetric 3 × 3 matrix by its cofactors
    i00, i01, i02 = d * f - e * e, c * e - b * f, b * e - c * d
    i11, i12, i22 = a * f - c * c, b * c - a * e, a * d - b * b
    determinant = a * i00 + b * i01 + c * i02
    if determinant > 0.0:
        x, y, z = pair[6], pair[7], pair[8]
        place[0] -= (i00 * x + i01 * y + i02 * z) / determinant
        place[1] -= (i01 * x + i11 * y + i12 * z) / determinant
        place[2] -= (i02 * x + i12 * y + i22 * z) / determinant


@kernel
def _quadric_error(
    cost: QuadricState, surface: Surface, kept: int, dead: int, place: FloatArray
) -> float:
    _pair_quadric(cost.quadric, surface.position, kept, dead, place, cost.pair)
    return max(cost.pair[9], 0.0)


@kernel
def _quadric_merge(
    cost: QuadricState, surface: Surface, kept: int, dead: int, place: FloatArray
) -> None:
    _pair_quadric(cost.quadric, surface.position, kept, dead, place, cost.pair)
    cost.quadric[kept] = cost.pair


interface.implement(
    QuadricState, optimum=_quadric_optimum, error=_quadric_error, merge=_quadric_merge
)
