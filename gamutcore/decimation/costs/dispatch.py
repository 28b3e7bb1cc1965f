"""The state of a cost, and the kernels through which decimation evaluates and updates it.

Each kernel selects the algorithm by `Parameters.kind`. All costs share one type of state, so the
collapse loop is compiled once. A cost only proposes positions. The collapse loop rounds and tests
them, so no cost can break the validity of a level.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.decimation.costs.memoryless_quadrics import (
    EDGE_SIZE,
    SUM_SIZE,
    Quadrics,
    account_for_volume,
    area_vectors,
    constrained_error,
    constrained_optimum,
    renew_quadrics,
)
from gamutcore.decimation.costs.parameters import ACCUMULATED, MEMORYLESS, Parameters
from gamutcore.decimation.costs.plane_quadrics import (
    accumulate,
    plane_error,
    plane_optimum,
    vertex_quadrics,
)
from gamutcore.decimation.costs.refinement import (
    find_better_position,
    mismatch_error,
    refine_point,
)
from gamutcore.decimation.costs.sample_assignment import (
    assign_samples,
    reassign_samples,
    release_samples,
    thin_samples,
)
from gamutcore.decimation.costs.samples import (
    SAMPLES,
    TOP,
    TOTAL_WEIGHT,
    Deviation,
    deviation_on_faces,
    empty_deviation,
    sample_capacity,
    take_samples,
)
from gamutcore.decimation.star import DEFICIT_NOW, Surface
from gamutcore.kernels import leaf_kernel

__all__ = [
    "CostState",
    "cost_state",
    "cost_state_on",
    "enter_level",
    "error_at",
    "find_improvement",
    "find_optimum",
    "total_deviation",
    "update_after_change",
    "update_before_collapse",
]

LARGEST_REPAYMENT = 1.0 / 64.0
"""Fraction of the volume that the next collapse compensates at most.

Moves of `finest` change the volume. On boundaries of devices they change less than half of this
fraction down to 20 triangles. On rugged bodies more accumulates, and compensating it would leave no
valid position for any edge.
"""


class CostState(NamedTuple):
    """The state of a cost.

    Attributes
    ----------
    parameters : Parameters
    quadrics : Quadrics
    deviation : Deviation
        Without samples if the cost never compares levels with a reference.
    level : (1,) int32
        Number of vertices of the present level.
    trial_point : (3,) float64
        Scratch.
    """

    parameters: Parameters
    quadrics: Quadrics
    deviation: Deviation
    level: IndexArray
    trial_point: FloatArray


def cost_state(parameters: Parameters, positions: FloatArray, faces: IndexArray) -> CostState:
    """Return the state of a cost before the first collapse.

    Parameters
    ----------
    parameters : Parameters
    positions : (V, 3) float64
        Positions of the full boundary, relative to the centre.
    faces : (F, 3) int32

    Returns
    -------
    CostState
    """
    count = len(positions)
    parameters = parameters.for_boundary(count, len(faces))
    fresh, edge = np.zeros(count, np.uint8), np.zeros(EDGE_SIZE)
    if parameters.kind == ACCUMULATED:
        quadrics = Quadrics(vertex_quadrics(positions, faces), fresh, np.empty((0, 4)), edge)
        deviation = empty_deviation(0, 0)
    else:
        vectors = area_vectors(positions, faces)
        quadrics = Quadrics(np.empty((count, SUM_SIZE)), fresh, vectors, edge)
        reference = len(faces)
        if not parameters.compares_with_full:
            reference = 2 * min(parameters.compared_vertices, count) - 4
        capacity = sample_capacity(parameters.samples, reference)
        deviation = empty_deviation(min(capacity, parameters.largest_samples), len(faces))
    return CostState(parameters, quadrics, deviation, np.full(1, count, np.int32), np.zeros(3))


def cost_state_on(state: CostState, vertices: IndexArray, faces: IndexArray) -> CostState:
    """Return the state on a surface that consists of some of the vertices and faces.

    Parameters
    ----------
    state : CostState
    vertices : (v,) int32
        Their numbers in the present surface.
    faces : (f,) int32

    Returns
    -------
    CostState
    """
    quadrics, deviation = state.quadrics, state.deviation
    vectors = quadrics.area_vector
    if state.parameters.kind == MEMORYLESS:
        vectors, deviation = vectors[faces], deviation_on_faces(deviation, faces)
    return CostState(
        state.parameters,
        Quadrics(quadrics.sums[vertices], quadrics.fresh[vertices], vectors, quadrics.edge.copy()),
        deviation,
        state.level.copy(),
        state.trial_point.copy(),
    )


def total_deviation(state: CostState) -> float:
    """Deviation of the present level from the reference."""
    return float(state.deviation.error.sum())


@leaf_kernel
def _is_compared(state: CostState) -> bool:
    """Whether the present level is compared with the reference."""
    return state.level[0] <= state.parameters.compared_vertices


@leaf_kernel
def find_optimum(state: CostState, surface: Surface, corner: int, point: FloatArray) -> float:
    """Write the best position of the vertex that replaces an edge, and return its error.

    Parameters
    ----------
    state : CostState
    surface : Surface
    corner : int
        One of the two corners that face the edge.
    point : (3,) float64
        Receives the position, relative to the centre.

    Returns
    -------
    float
        As `error_at` returns it for that position.
    """
    parameters, quadrics = state.parameters, state.quadrics
    if parameters.kind == ACCUMULATED:
        return plane_optimum(quadrics, surface, corner, point)
    value = constrained_optimum(quadrics, surface, corner, point)
    if not _is_compared(state):
        return value
    steps = 0
    if state.level[0] <= parameters.refined_vertices:
        steps = 2 if state.level[0] <= parameters.refined_twice_vertices else 1
    return refine_point(
        state.deviation,
        quadrics,
        surface,
        corner,
        point,
        state.trial_point,
        steps,
        parameters.preserves_volume,
    )


@leaf_kernel
def error_at(state: CostState, surface: Surface, corner: int, point: FloatArray) -> float:
    """Error of replacing the edge that a corner faces by a vertex at a position."""
    if state.parameters.kind == ACCUMULATED:
        return plane_error(state.quadrics, surface, corner, point)
    if not _is_compared(state):
        return constrained_error(state.quadrics, surface, corner, point)
    return mismatch_error(state.deviation, surface, corner, point)


@leaf_kernel
def update_before_collapse(
    state: CostState, surface: Surface, corner: int, kept: int, dead: int, point: FloatArray
) -> None:
    """Update the state for a collapse that is about to happen.

    Parameters
    ----------
    state : CostState
    surface : Surface
        Before the collapse. Its `deficit` is updated.
    corner : int
        One of the two corners that face the edge.
    kept, dead : int
        The ends of the edge.
    point : (3,) float64
        The rounded position of the new vertex, relative to the centre.
    """
    if state.parameters.kind == ACCUMULATED:
        accumulate(state.quadrics, surface, kept, dead, point)
        return
    account_for_volume(state.quadrics, surface, corner, point)
    if state.parameters.moved_vertices > 0:
        largest = LARGEST_REPAYMENT * state.deviation.sums[TOTAL_WEIGHT]
        if abs(surface.deficit[DEFICIT_NOW]) > largest:
            surface.deficit[DEFICIT_NOW] = 0.0
    if _is_compared(state):
        release_samples(state.deviation, surface, corner)


@leaf_kernel
def update_after_change(state: CostState, surface: Surface, vertex: int) -> None:
    """Update the state after a collapse to a vertex or a move of it."""
    if state.parameters.kind == ACCUMULATED:
        return
    renew_quadrics(state.quadrics, surface, vertex)
    if _is_compared(state):
        reassign_samples(state.deviation, surface, vertex)


@leaf_kernel
def enter_level(state: CostState, surface: Surface, vertices: int) -> bool:
    """Prepare for levels with at most `vertices` vertices.

    Parameters
    ----------
    state : CostState
    surface : Surface
    vertices : int

    Returns
    -------
    bool
        Whether the errors of all edges have changed.
    """
    parameters, deviation = state.parameters, state.deviation
    if parameters.kind == ACCUMULATED:
        return False
    compared = vertices <= parameters.compared_vertices
    begins = compared and not _is_compared(state)
    state.level[0] = vertices
    if deviation.counts[SAMPLES] == 0 and (compared or parameters.compares_with_full):
        # in fine levels nothing depends on the assignment of samples to faces
        take_samples(deviation, surface, parameters.samples, compared)
    if not compared:
        return False
    if deviation.counts[TOP] == 0:
        assign_samples(deviation, surface)
    most = 4 * parameters.samples_per_face * max(vertices, parameters.thinned_vertices)
    return thin_samples(deviation, surface, min(most, parameters.largest_samples)) or begins


@leaf_kernel
def find_improvement(state: CostState, surface: Surface, vertex: int, point: FloatArray) -> bool:
    """Write a better position of a vertex; False if there is none or vertices do not move.

    Parameters
    ----------
    state : CostState
    surface : Surface
    vertex : int
    point : (3,) float64
        Receives the position, relative to the centre.

    Returns
    -------
    bool
    """
    if state.level[0] > state.parameters.moved_vertices:
        return False
    return find_better_position(state.deviation, surface, vertex, point, state.trial_point)
