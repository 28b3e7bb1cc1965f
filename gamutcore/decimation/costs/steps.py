"""A step of a vertex that lowers the deviation: iteratively reweighted least squares.

The step uses the results of the last `change_at`: the samples around a point and their faces.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.decimation.costs.samples import (
    QUERY_AREA,
    QUERY_DISTANCE,
    QUERY_PAIRS,
    QUERY_SAMPLES,
    Deviation,
)
from gamutcore.decimation.costs.symmetric import adjugate
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = ["step_towards_reference"]

SOFTNESS = 1.0
"""Fraction of the mean residual that is the lower bound of residuals in the weights 1 ÷ |e|.

The bound keeps the weights of iteratively reweighted least squares finite (Lawson 1961). With a
small bound the few samples next to the present surface hold it in place: 10⁻³ instead of 1 is a
tenth less accurate on spheres.
"""

PULL = 1e-5
"""Weight of the present position in the solve, as a fraction of the trace of the normal equations.

The samples determine moves along a flat surface poorly and moves along a curved one well: 10⁻²
instead is a tenth less accurate.
"""


@inlined_kernel
def _sum_normal_equations(deviation: Deviation, soft: float) -> None:
    """Sum the samples' contributions to the normal equations of a step, face by face."""
    plane, pairs, weights = deviation.plane, deviation.pair, deviation.query_weight
    inverses, norms, sums = deviation.inverse, deviation.norm, deviation.face_sum
    xs, ys, zs = deviation.query_x, deviation.query_y, deviation.query_z
    squares, pulls, count = deviation.term, deviation.other_term, deviation.counts[QUERY_SAMPLES]
    for number in range(count):
        pair = np.uint64(pairs[number])
        squares[number] = (
            plane[pair, 6] * xs[number] + plane[pair, 7] * ys[number] + plane[pair, 8] * zs[number]
        )
    for number in range(count):
        inverse, norm = inverses[number], norms[number]
        inside = inverse > 0.0
        e = (inverse - 1.0) * (1.0 / norm)
        distance = abs(e)
        size = distance if distance > soft else soft  # noqa: FURB136
        # the reciprocal of both needs one division only
        reciprocal = 1.0 / (inverse * size)
        part = squares[number] * (reciprocal * size)
        weight = weights[number] * part * norm * reciprocal
        squares[number] = weight * part if inside else 0.0
        pulls[number] = weight * e if inside else 0.0
    # Consecutive samples mostly lie in the same face, so each addition would wait for the one
    # before. Four partial sums do not wait for each other.
    for number in range(0, count, 4):
        for lane in range(4):
            at = np.uint64(number + lane)
            pair = np.uint64(pairs[at])
            sums[pair, 2 * lane] += squares[at]
            sums[pair, 2 * lane + 1] += pulls[at]


@leaf_kernel
def step_towards_reference(deviation: Deviation, point: FloatArray, better: FloatArray) -> bool:
    """Write the position that the queried vertex should take, to first order.

    A move δ of the vertex shifts the surface at a sample along the normal n of its face by λ n·δ,
    where λ is the sample's barycentric coordinate for the vertex. δ minimises Σ ω |e − λ n·δ| over
    the samples by one step of iteratively reweighted least squares. Here e is the distance of a
    sample from the plane of its face, and ω the area that it represents.

    Parameters
    ----------
    deviation : Deviation
        As the last `change_at` left it.
    point : (3,) float64
        The position that `change_at` evaluated.
    better : (3,) float64
        Receives the position.

    Returns
    -------
    bool
        False if the samples determine no step.
    """
    plane, sums, pairs = deviation.plane, deviation.face_sum, deviation.counts[QUERY_PAIRS]
    if not deviation.sums[QUERY_DISTANCE] > 0.0:
        return False
    soft = SOFTNESS * deviation.sums[QUERY_DISTANCE] / deviation.sums[QUERY_AREA]
    for around in range(pairs):
        for column in range(8):
            sums[around, column] = 0.0
    _sum_normal_equations(deviation, soft)
    a00, a01, a02, a11, a12, a22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    b0, b1, b2 = 0.0, 0.0, 0.0
    for around in range(pairs):
        distance = 1.0 / plane[around, 9]
        nx, ny, nz = (
            plane[around, 3] * distance,
            plane[around, 4] * distance,
            plane[around, 5] * distance,
        )
        square = (sums[around, 0] + sums[around, 2]) + (sums[around, 4] + sums[around, 6])
        pulled = (sums[around, 1] + sums[around, 3]) + (sums[around, 5] + sums[around, 7])
        if not square > 0.0:
            continue
        a00 += square * nx * nx
        a01 += square * nx * ny
        a02 += square * nx * nz
        a11 += square * ny * ny
        a12 += square * ny * nz
        a22 += square * nz * nz
        b0 += pulled * nx
        b1 += pulled * ny
        b2 += pulled * nz
    pull = PULL * (a00 + a11 + a22)
    i00, i01, i02, i11, i12, i22, determinant = adjugate(
        a00 + pull, a01, a02, a11 + pull, a12, a22 + pull
    )
    if not determinant > 0.0:
        return False
    better[0] = point[0] + (i00 * b0 + i01 * b1 + i02 * b2) / determinant
    better[1] = point[1] + (i01 * b0 + i11 * b1 + i12 * b2) / determinant
    better[2] = point[2] + (i02 * b0 + i12 * b1 + i22 * b2) / determinant
    return True
