"""Errors of collapses by the change of the mismatch, and positions moved to lower it.

A step of a vertex minimises the deviation by one step of iteratively reweighted least squares. It
uses the results of the last `change_at`: the samples around a point and their faces.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.decimation.costs.deviation import (
    LENGTH,
    NORMAL,
    OPPOSITE,
    change_at,
    current_deviation,
    length_penalty,
    query_edge,
    query_vertex,
)
from gamutcore.decimation.costs.memoryless_quadrics import Quadrics, shift_to_preserve_volume
from gamutcore.decimation.costs.samples import (
    QUERY_AREA,
    QUERY_DISTANCE,
    QUERY_PAIRS,
    QUERY_SAMPLES,
    Deviation,
)
from gamutcore.decimation.star import Surface
from gamutcore.decimation.vectors import add_outer, adjugate, plus, product, row, scaled
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = ["find_better_position", "mismatch_error", "refine_point", "step_towards_reference"]

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

REFINEMENTS = 2
"""Largest number of steps of the position of a collapse."""

LEAST_GAIN = 1e-3
"""Fraction of the deviation around a vertex that a move must save."""

RELAXATION_FACTOR = 2.0
"""Length of a move, in units of the least-squares step.

Neighbours move the same way in their turn, so a step beyond the own optimum converges sooner
(successive over-relaxation).
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
            plane[pair, OPPOSITE] * xs[number]
            + plane[pair, OPPOSITE + 1] * ys[number]
            + plane[pair, OPPOSITE + 2] * zs[number]
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

    `point` is the position of the last `change_at`. Let n be the normal of a sample's face and λ
    the sample's barycentric coordinate for the vertex. A move δ shifts the surface at the sample
    along n by λ n·δ. δ minimises Σ ω |e − λ n·δ| by one step of iteratively reweighted least
    squares. Here e is the distance of a sample from the plane of its face, and ω the area that it
    represents. The result is False if the samples determine no step.
    """
    plane, sums, pairs = deviation.plane, deviation.face_sum, deviation.counts[QUERY_PAIRS]
    if not deviation.sums[QUERY_DISTANCE] > 0.0:
        return False
    soft = SOFTNESS * deviation.sums[QUERY_DISTANCE] / deviation.sums[QUERY_AREA]
    for around in range(pairs):
        for column in range(8):
            sums[around, column] = 0.0
    _sum_normal_equations(deviation, soft)
    matrix, right = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for around in range(pairs):
        normal = scaled(1.0 / plane[around, LENGTH], row(plane, around, NORMAL))
        square = (sums[around, 0] + sums[around, 2]) + (sums[around, 4] + sums[around, 6])
        pulled = (sums[around, 1] + sums[around, 3]) + (sums[around, 5] + sums[around, 7])
        if square > 0.0:
            matrix = add_outer(matrix, square, normal)
            right = plus(right, scaled(pulled, normal))
    inverse, determinant = adjugate(matrix, PULL * (matrix[0] + matrix[3] + matrix[5]))
    if not determinant > 0.0:
        return False
    step = product(inverse, right)
    for axis in range(3):
        better[axis] = point[axis] + step[axis] / determinant
    return True


@leaf_kernel
def mismatch_error(deviation: Deviation, surface: Surface, corner: int, point: FloatArray) -> float:
    """Error of replacing an edge by a vertex: the change of the deviation from the reference.

    The error is six times a volume; it is infinite for large and dense links.
    """
    if not query_edge(deviation, surface, corner):
        return np.inf
    return change_at(deviation, surface, point) + length_penalty(deviation, surface, corner)


@leaf_kernel
def refine_point(
    deviation: Deviation,
    quadrics: Quadrics,
    surface: Surface,
    corner: int,
    point: FloatArray,
    trial_point: FloatArray,
    preserves_volume: bool,
) -> float:
    """Move a position towards less deviation while that helps; return its `mismatch_error`.

    The position moves at most `REFINEMENTS` times. With `preserves_volume` it stays where the
    collapse preserves the volume.
    """
    if not query_edge(deviation, surface, corner):
        return np.inf
    least = change_at(deviation, surface, point)
    penalty = length_penalty(deviation, surface, corner)
    for _ in range(REFINEMENTS):
        if not step_towards_reference(deviation, point, trial_point):
            break
        if preserves_volume:
            shift_to_preserve_volume(quadrics, surface, corner, trial_point)
        change = change_at(deviation, surface, trial_point)
        if not change < least:
            break
        least = change
        point[0], point[1], point[2] = trial_point[0], trial_point[1], trial_point[2]
    return least + penalty


@inlined_kernel
def find_better_position(
    deviation: Deviation,
    surface: Surface,
    vertex: int,
    point: FloatArray,
    trial_point: FloatArray,
) -> bool:
    """Write a position for a vertex that lowers the deviation; False if none was found."""
    for axis in range(3):
        point[axis] = surface.position[vertex, axis]
    if not query_vertex(deviation, surface, vertex):
        return False
    change_at(deviation, surface, point)
    if not step_towards_reference(deviation, point, trial_point):
        return False
    present = current_deviation(deviation)
    for axis in range(3):
        point[axis] += RELAXATION_FACTOR * (trial_point[axis] - point[axis])
    return change_at(deviation, surface, point) < -LEAST_GAIN * present
