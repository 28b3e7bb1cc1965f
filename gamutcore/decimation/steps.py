"""Where a vertex should go to lower the deviation: a step of reweighted least squares.

By what `gamutcore.decimation.deviation` has left in its scratch: the samples around a place, and
the faces that they are in.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.decimation.samples import Deviation
from gamutcore.decimation.symmetric import adjugate
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = ["step_towards_reference"]

SOFTNESS = 1.0
"""Part of the mean residual below which a residual counts as that: keeps the weights 1 ÷ |e| of
iteratively reweighted least squares finite (Lawson 1961). With less of it the few samples next to
the present surface hold it where it is: 1e-3 instead of 1 is a tenth less accurate on spheres."""

PULL = 1e-5
"""Weight of staying in place in the solve for a move, as a part of the normal equations' trace; the
samples say little about moves along a flat surface, but what they say of curved ones is worth much:
1e-2 instead is a tenth less accurate."""


@inlined_kernel
def _add_steps(deviation: Deviation, soft: float) -> None:
    """Sum up for each face what its samples add to the normal equations of a step."""
    plane, pairs, weights = deviation.pair_plane, deviation.pair, deviation.asked_weight
    inverses, norms, sums = deviation.inverse, deviation.norm, deviation.pair_sum
    xs, ys, zs = deviation.asked_x, deviation.asked_y, deviation.asked_z
    squares, pulls = deviation.term, deviation.other_term
    for number in range(deviation.counts[5]):
        pair = np.uint64(pairs[number])
        squares[number] = (
            plane[pair, 6] * xs[number] + plane[pair, 7] * ys[number] + plane[pair, 8] * zs[number]
        )
    for number in range(deviation.counts[5]):
        inverse, norm = inverses[number], norms[number]
        inside = inverse > 0.0
        e = (inverse - 1.0) * (1.0 / norm)
        away = abs(e)
        size = away if away > soft else soft  # noqa: FURB136
        # 1 ÷ both, for there is time for one division only
        reciprocal = 1.0 / (inverse * size)
        part = squares[number] * (reciprocal * size)
        weight = weights[number] * part * norm * reciprocal
        squares[number] = weight * part if inside else 0.0
        pulls[number] = weight * e if inside else 0.0
    # samples of a face mostly follow each other, so each adds to what the one before has written:
    # in four parts that do not wait for each other
    for number in range(0, deviation.counts[5], 4):
        for lane in range(4):
            at = np.uint64(number + lane)
            pair = np.uint64(pairs[at])
            sums[pair, 2 * lane] += squares[at]
            sums[pair, 2 * lane + 1] += pulls[at]


@leaf_kernel
def step_towards_reference(deviation: Deviation, place: FloatArray, better: FloatArray) -> bool:
    """Write where the vertex should go that a change was asked for, to first order.

    A move δ of the vertex shifts the surface at a sample along the normal n of its face by λ n·δ, λ
    being the sample's barycentric coordinate for the vertex. δ minimises Σ ω |e − λ n·δ| over the
    samples, e being their distances from the faces' planes and ω the area that they stand for, by a
    step of iteratively reweighted least squares.

    Parameters
    ----------
    deviation : Deviation
        As the last `change_at` left it.
    place : (3,) float64
        The place that it was asked for.
    better : (3,) float64
        Receives the position.

    Returns
    -------
    bool
        False if the samples give no direction.
    """
    plane, sums, pairs = deviation.pair_plane, deviation.pair_sum, deviation.counts[0]
    if not deviation.residual[0] > 0.0:
        return False
    soft = SOFTNESS * deviation.residual[0] / deviation.residual[1]
    for around in range(pairs):
        sums[around, :] = 0.0
    _add_steps(deviation, soft)
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
    better[0] = place[0] + (i00 * b0 + i01 * b1 + i02 * b2) / determinant
    better[1] = place[1] + (i01 * b0 + i11 * b1 + i12 * b2) / determinant
    better[2] = place[2] + (i02 * b0 + i12 * b1 + i22 * b2) / determinant
    return True
