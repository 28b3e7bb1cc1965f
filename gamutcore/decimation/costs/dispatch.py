"""The kernels through which decimation evaluates and updates a cost.

Each kernel selects the algorithm by `Parameters.kind`. A cost only proposes positions. The collapse
loop rounds and tests them, so no cost can break the validity of a level.
"""

from __future__ import annotations

from gamutcore.arrays import FloatArray
from gamutcore.decimation.costs.memoryless_quadrics import (
    account_for_volume,
    constrained_error,
    constrained_optimum,
    renew_quadrics,
)
from gamutcore.decimation.costs.parameters import ACCUMULATED
from gamutcore.decimation.costs.plane_quadrics import accumulate, plane_error, plane_optimum
from gamutcore.decimation.costs.refinement import (
    find_better_position,
    mismatch_error,
    refine_point,
)
from gamutcore.decimation.costs.sample_assignment import (
    assign_samples,
    reassign_samples,
    thin_samples,
)
from gamutcore.decimation.costs.samples import SAMPLES, TOP, TOTAL_WEIGHT, take_samples
from gamutcore.decimation.stage import Stage
from gamutcore.decimation.star import DEFICIT_NOW
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "enter_level",
    "error_at",
    "find_improvement",
    "find_optimum",
    "update_after_change",
    "update_before_collapse",
]

LARGEST_REPAYMENT = 1.0 / 64.0
"""Fraction of the volume that the next collapse compensates at most.

Moves of `finest` change the volume. On boundaries of devices they change less than half of this
fraction down to 20 triangles. On rugged bodies more accumulates, and compensating it would leave no
valid position for any edge.
"""

REFINED_SAMPLES = 24
"""Positions are refined in levels with at least so many samples per vertex. With six samples
per face or fewer a position that may change the volume follows the samples instead of the
reference: on spheres of 10,000 vertices the mismatch at 1000 triangles was three times as large."""


@leaf_kernel
def _is_compared(stage: Stage) -> bool:
    """Whether the present level is compared with the reference."""
    return stage.level[0] <= stage.parameters.compared_vertices


@leaf_kernel
def find_optimum(stage: Stage, corner: int, point: FloatArray) -> float:
    """Write the best position of the vertex that replaces an edge, and return its `error_at`.

    `corner` is one of the two that face the edge. The position is relative to the centre.
    """
    surface, quadrics = stage.surface, stage.quadrics
    if stage.parameters.kind == ACCUMULATED:
        return plane_optimum(quadrics, surface, corner, point)
    value = constrained_optimum(quadrics, surface, corner, point)
    if not _is_compared(stage):
        return value
    if stage.deviation.counts[SAMPLES] < REFINED_SAMPLES * stage.level[0]:
        return mismatch_error(stage.deviation, surface, corner, point)
    return refine_point(
        stage.deviation,
        quadrics,
        surface,
        corner,
        point,
        stage.trial_point,
        stage.parameters.preserves_volume,
    )


@leaf_kernel
def error_at(stage: Stage, corner: int, point: FloatArray) -> float:
    """Error of replacing the edge that a corner faces by a vertex at a position."""
    if stage.parameters.kind == ACCUMULATED:
        return plane_error(stage.quadrics, stage.surface, corner, point)
    if not _is_compared(stage):
        return constrained_error(stage.quadrics, stage.surface, corner, point)
    return mismatch_error(stage.deviation, stage.surface, corner, point)


@leaf_kernel
def update_before_collapse(
    stage: Stage, corner: int, kept: int, dead: int, point: FloatArray
) -> None:
    """Update the cost and the surface's `deficit` for a collapse that is about to happen.

    `corner` faces the edge. `point` is the rounded position of the new vertex, relative to the
    centre.
    """
    surface = stage.surface
    if stage.parameters.kind == ACCUMULATED:
        accumulate(stage.quadrics, surface, kept, dead, point)
        return
    account_for_volume(stage.quadrics, surface, corner, point)
    if stage.parameters.moved_vertices > 0:
        largest = LARGEST_REPAYMENT * stage.deviation.sums[TOTAL_WEIGHT]
        if abs(surface.deficit[DEFICIT_NOW]) > largest:
            surface.deficit[DEFICIT_NOW] = 0.0


@inlined_kernel
def update_after_change(stage: Stage, vertex: int, left: int, right: int) -> None:
    """Update the cost after a move of a vertex, or a collapse to it that removed two faces.

    After a move, `left` and `right` are `NO_FACE`.
    """
    if stage.parameters.kind == ACCUMULATED:
        return
    renew_quadrics(stage.quadrics, stage.surface, vertex)
    if _is_compared(stage):
        reassign_samples(stage.deviation, stage.surface, vertex, left, right)


@leaf_kernel
def enter_level(stage: Stage, vertices: int) -> bool:
    """Prepare for levels with at most `vertices` vertices.

    The result says whether the errors of all edges have changed.
    """
    parameters, deviation, surface = stage.parameters, stage.deviation, stage.surface
    compared = vertices <= parameters.compared_vertices
    begins = compared and not _is_compared(stage)
    stage.level[0] = vertices
    if deviation.counts[SAMPLES] == 0 and (compared or parameters.compares_with_full):
        take_samples(deviation, surface, parameters.samples)
    if not compared:
        return False
    # in fine levels nothing depends on the assignment of samples to faces
    if deviation.counts[TOP] == 0:
        assign_samples(deviation, surface)
    most = 4 * parameters.samples_per_face * max(vertices, parameters.thinned_vertices)
    return thin_samples(deviation, surface, min(most, parameters.largest_samples)) or begins


@inlined_kernel
def find_improvement(stage: Stage, vertex: int, point: FloatArray) -> bool:
    """Write a better position of a vertex; False if there is none or vertices do not move."""
    if stage.level[0] > stage.parameters.moved_vertices:
        return False
    return find_better_position(stage.deviation, stage.surface, vertex, point, stage.trial_point)
