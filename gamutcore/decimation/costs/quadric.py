"""The published cost: accumulated, unweighted plane quadrics.

Garland & Heckbert, "Surface Simplification Using Quadric Error Metrics" (1997), as Bakke & Farup
use it. A face with unit normal n and offset d has the quadric (A, b, c) = (n nᵀ, d n, d²), whose
value D²(v) = vᵀA v + 2 bᵀv + c is the squared distance of v to its plane. A vertex starts with
the sum over its faces, a collapse adds the quadrics of its two ends.

Each vertex's quadric is kept relative to the vertex itself and moved to the edge's midpoint for a
collapse: the same polynomial, without the cancellation that absolute coordinates bring.

Beyond the publication, so that every level is valid: `REGULARISATION` and `FLATNESS`, below; and
where the best place is not, or lies more than `REACH` star radii from the edge
(`gamutcore.decimation.candidates`), the midpoint or an end is taken instead, moved towards or away
from the centre so that the collapse preserves the volume.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.costs import interface
from gamutcore.decimation.plan import Plan
from gamutcore.decimation.star import Surface
from gamutcore.decimation.symmetric import adjugate
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["PLAN", "PRESERVES_VOLUME", "QuadricState", "state"]

PRESERVES_VOLUME = False
"""The publication leaves the volume alone."""

PLAN = Plan()
"""One way, in one stage, as published."""

REGULARISATION = 1e-5
"""Weight of the midpoint in the solve, as a part of A's trace.

The publication falls back to an end of the edge where A is not invertible, which on nearly flat
sides is a question of rounding; a small pull towards the midpoint decides it continuously.
"""


FLATNESS = 1e-10
"""Weight of the squared edge length in the error, as a part of A's trace.

On an exactly flat side every collapse is free, and without an order of their own the same vertex
would take in one neighbour after the other, until its faces are slivers and each step costs the
whole side. Where distances to the planes exceed 10⁻⁵ edge lengths this weighs nothing.
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
        for corner in (one, two, three):  # all three lie in the plane: seen from each of them d = 0
            quadrics[corner, 0] += nx * nx
            quadrics[corner, 1] += nx * ny
            quadrics[corner, 2] += nx * nz
            quadrics[corner, 3] += ny * ny
            quadrics[corner, 4] += ny * nz
            quadrics[corner, 5] += nz * nz
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


@leaf_kernel
def _sum_about(
    cost: QuadricState, surface: Surface, one: int, two: int, origin: FloatArray
) -> None:
    """Write the sum of two vertices' quadrics to `cost.pair`, relative to an origin."""
    quadric, position, pair = cost.quadric, surface.position, cost.pair
    for index in range(10):
        pair[index] = quadric[one, index] + quadric[two, index]
    for end in (one, two):
        x = origin[0] - position[end, 0]
        y = origin[1] - position[end, 1]
        z = origin[2] - position[end, 2]
        a00, a01, a02 = quadric[end, 0], quadric[end, 1], quadric[end, 2]
        a11, a12, a22 = quadric[end, 3], quadric[end, 4], quadric[end, 5]
        ax = a00 * x + a01 * y + a02 * z
        ay = a01 * x + a11 * y + a12 * z
        az = a02 * x + a12 * y + a22 * z
        pair[6] += ax
        pair[7] += ay
        pair[8] += az
        pair[9] += 2.0 * (quadric[end, 6] * x + quadric[end, 7] * y + quadric[end, 8] * z) + (
            ax * x + ay * y + az * z
        )


@leaf_kernel
def _shortness(surface: Surface, kept: int, dead: int, pair: FloatArray) -> float:
    """What makes shorter edges come first where the quadric makes no difference."""
    position, squared = surface.position, 0.0
    for axis in range(3):
        difference = position[kept, axis] - position[dead, axis]
        squared += difference * difference
    return FLATNESS * (pair[0] + pair[3] + pair[5]) * squared


@leaf_kernel
def _optimum(cost: QuadricState, surface: Surface, corner: int, place: FloatArray) -> float:
    pair, position = cost.pair, surface.position
    kept, dead = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    for axis in range(3):
        place[axis] = 0.5 * (position[kept, axis] + position[dead, axis])
    _sum_about(cost, surface, kept, dead, place)
    pull = REGULARISATION * (pair[0] + pair[3] + pair[5])
    i00, i01, i02, i11, i12, i22, determinant = adjugate(
        pair[0] + pull, pair[1], pair[2], pair[3] + pull, pair[4], pair[5] + pull
    )
    short = _shortness(surface, kept, dead, pair)
    if not determinant > 0.0:
        return max(pair[9], 0.0) + short
    bx, by, bz = pair[6], pair[7], pair[8]
    x = -(i00 * bx + i01 * by + i02 * bz) / determinant
    y = -(i01 * bx + i11 * by + i12 * bz) / determinant
    z = -(i02 * bx + i12 * by + i22 * bz) / determinant
    place[0] += x
    place[1] += y
    place[2] += z
    quadratic = (
        pair[0] * x * x
        + pair[3] * y * y
        + pair[5] * z * z
        + 2.0 * (pair[1] * x * y + pair[2] * x * z + pair[4] * y * z)
    )
    return max(quadratic + 2.0 * (bx * x + by * y + bz * z) + pair[9], 0.0) + short


@leaf_kernel
def _error(cost: QuadricState, surface: Surface, corner: int, place: FloatArray) -> float:
    kept, dead = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    _sum_about(cost, surface, kept, dead, place)
    return max(cost.pair[9], 0.0) + _shortness(surface, kept, dead, cost.pair)


@leaf_kernel
def _merge(
    cost: QuadricState, surface: Surface, at: int, kept: int, dead: int, place: FloatArray
) -> None:
    _sum_about(cost, surface, kept, dead, place)
    for index in range(10):
        cost.quadric[kept, index] = cost.pair[index]


interface.implement(QuadricState, optimum=_optimum, error=_error, merge=_merge)
