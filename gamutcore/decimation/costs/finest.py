"""The cost for few triangles: the change of the mismatch itself, and vertices moved to lower it.

Points on the faces of the full boundary are samples of it from the start. Down to 16,000 faces
edges are ordered as by `volume`. From there on an edge's error is the change of the mismatch with
the full boundary, and from 7000 faces on, or a tenth of the full boundary's, or 200, the new vertex
of each collapse and its neighbours are moved towards less of it: the history keeps these moves, so
every coarser level has them. The volume is not preserved then; what is inside the full boundary and
outside the level is about as much as what is outside of the one and inside of the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.decimation.costs import interface
from gamutcore.decimation.deviation import (
    ask_for_vertex,
    change_at,
    deviation_around,
    evaluate_present,
)
from gamutcore.decimation.memoryless import (
    Memoryless,
    account_for_volume,
    constrained_optimum,
    error_of_place,
    memoryless,
    memoryless_on,
    renew_planes,
)
from gamutcore.decimation.plan import Fork, Plan
from gamutcore.decimation.redistribution import (
    hand_over_samples,
    locate_samples,
    redistribute_samples,
    thin_samples,
)
from gamutcore.decimation.refinement import error_by_mismatch, refined_place
from gamutcore.decimation.samples import (
    Deviation,
    deviation_on,
    no_deviation,
    room_for_samples,
    take_samples,
)
from gamutcore.decimation.star import Surface
from gamutcore.decimation.steps import step_towards_reference
from gamutcore.kernels import leaf_kernel

__all__ = ["PLAN", "PRESERVES_VOLUME", "FinestState", "state"]

PRESERVES_VOLUME = False
"""Where vertices are moved, the volume follows the mismatch."""

COMPARED_VERTICES = 8000
"""Levels with so many vertices and fewer are ordered by the mismatch."""

MOVED_VERTICES = 3500
"""Vertices are moved in levels with so many of them and fewer, if it is few of all:"""

MOVED_PART = 10
"""What part of the full boundary's vertices that is at most. A move takes 28 bits of a history, and
six neighbours move in a split; levels with half as many vertices as the first that has moves, and
fewer, are as accurate as if all had them (docs/decisions/costs.md)."""

MOVED_AT_LEAST = 100
"""In levels with so many vertices and fewer they are moved in any case."""

WORTHWHILE = 1e-3
"""Part of the deviation around a vertex that a move has to save."""

ATTEMPTS = 3
"""Lengths that are tried for a move, each half the one before."""

LONGEST = 2.0
"""The first of them, as a part of the step: neighbours move the same way in their turn, so that
going beyond one's own optimum converges sooner (successive over-relaxation)."""

REFINED_VERTICES = 1000
"""In levels with so many vertices and fewer the place of a collapse is itself moved to lower the
mismatch before its error counts."""

REFINEMENTS = 1
"""Steps of such a move: with four, the levels are the same within 1 %."""


MOST_PAID_BACK = 1.0 / 64.0
"""Part of the volume up to which the next collapse pays back what moves have added or taken; more
has come together where the surface follows dents, and paying it back would turn places around. On
boundaries of devices it is less than half of that down to 20 triangles."""

SAMPLES = 40_000
"""Samples of the reference, at least about: every face has one, larger ones have several."""

SAMPLES_OF_FACE = 12
"""Samples of a face of the reference, on average, at most: of a boundary with few faces there are
fewer of them, for a face is flat, and what more of them tell is not worth the time they take."""

MOST_SAMPLES = 160_000
"""If there would be more, half as many are chosen: not every face has one then."""

SAMPLES_PER_FACE = 14
"""When there are twice as many on average, half of the samples go: what an edge's error takes to
evaluate stays the same, and the errors of large faces are as well known as those of small ones."""


THINNED_DOWN_TO = 250
"""Vertices below which no more samples go: the few collapses that are left decide most."""


class FinestState(NamedTuple):
    """The planes around every vertex, and the deviation from the full boundary.

    Attributes
    ----------
    planes : Memoryless
    deviation : Deviation
    vertices : (2,) int32
        How many there are at the present level, and at the first one where they are moved.
    trial : (3,) float64
        Scratch: a place that is tried.
    """

    planes: Memoryless
    deviation: Deviation
    vertices: IndexArray
    trial: FloatArray


@leaf_kernel
def _samples_of(faces: int) -> int:
    """Return about how many samples there are at least of a reference of so many faces."""
    return min(SAMPLES, SAMPLES_OF_FACE * faces)


def state(positions: FloatArray, faces: IndexArray) -> FinestState:
    """Return the state before the first collapse.

    Parameters
    ----------
    positions : (V, 3) float64
    faces : (F, 3) int32

    Returns
    -------
    FinestState
    """
    count = len(positions)
    moved = min(MOVED_VERTICES, max(count // MOVED_PART, MOVED_AT_LEAST))
    return FinestState(
        memoryless(positions, faces),
        no_deviation(
            min(room_for_samples(_samples_of(len(faces)), len(faces)), MOST_SAMPLES),
            len(faces),
        ),
        np.array([count, moved], np.int32),
        np.zeros(3),
    )


def _state_on(state: FinestState, vertices: IndexArray, faces: IndexArray) -> FinestState:
    return FinestState(
        memoryless_on(state.planes, vertices, faces),
        deviation_on(state.deviation, faces),
        state.vertices.copy(),
        state.trial.copy(),
    )


def _deviation(state: FinestState) -> float:
    return float(state.deviation.error.sum())


PLAN = Plan(
    compacted=(COMPARED_VERTICES,),
    forks=(Fork(200, 6, (52, 27)), Fork(27, 4, (12,))),
    state_on=_state_on,
    deviation=_deviation,
)
"""Six ways from 400 triangles on are compared at 100 and 50, and four from there on at 20."""


@leaf_kernel
def _optimum(cost: FinestState, surface: Surface, at: int, place: FloatArray) -> float:
    value = constrained_optimum(cost.planes, surface, at, place)
    if cost.vertices[0] > COMPARED_VERTICES:
        return value
    steps = REFINEMENTS if cost.vertices[0] <= REFINED_VERTICES else 0
    return refined_place(cost.deviation, cost.planes, surface, at, place, cost.trial, steps, False)


@leaf_kernel
def _error(cost: FinestState, surface: Surface, at: int, place: FloatArray) -> float:
    if cost.vertices[0] > COMPARED_VERTICES:
        return error_of_place(cost.planes, surface, at, place)
    return error_by_mismatch(cost.deviation, surface, at, place)


@leaf_kernel
def _merge(
    cost: FinestState, surface: Surface, at: int, kept: int, dead: int, place: FloatArray
) -> None:
    account_for_volume(cost.planes, surface, at, place)
    if abs(surface.deficit[0]) > MOST_PAID_BACK * cost.deviation.residual[3]:
        surface.deficit[0] = 0.0
    if cost.vertices[0] <= COMPARED_VERTICES:
        hand_over_samples(cost.deviation, surface, at)


@leaf_kernel
def _settle(cost: FinestState, surface: Surface, at: int) -> None:
    renew_planes(cost.planes, surface, at)
    if cost.vertices[0] <= COMPARED_VERTICES:
        redistribute_samples(cost.deviation, surface, at)


@leaf_kernel
def _reach(cost: FinestState, surface: Surface, at: int) -> bool:
    if cost.deviation.counts[2] == 0:
        # in fine levels nothing depends on what is in which face
        take_samples(cost.deviation, surface, _samples_of(2 * at - 4), at <= COMPARED_VERTICES)
    begins = at <= COMPARED_VERTICES and cost.vertices[0] > COMPARED_VERTICES
    cost.vertices[0] = at
    if at > COMPARED_VERTICES:
        return False
    if begins:
        locate_samples(cost.deviation, surface)
    most = min(4 * SAMPLES_PER_FACE * max(at, THINNED_DOWN_TO), MOST_SAMPLES)
    return thin_samples(cost.deviation, surface, most) or begins


@leaf_kernel
def _improve(cost: FinestState, surface: Surface, at: int, place: FloatArray) -> bool:
    if cost.vertices[0] > cost.vertices[1]:
        return False
    deviation, position, trial = cost.deviation, surface.position, cost.trial
    x, y, z = position[at, 0], position[at, 1], position[at, 2]
    place[0], place[1], place[2] = x, y, z
    if not ask_for_vertex(deviation, surface, at):
        return False
    evaluate_present(deviation, surface, place)
    present = deviation_around(deviation)
    if not step_towards_reference(deviation, place, trial):
        return False
    length = LONGEST
    for _ in range(ATTEMPTS):
        place[0] = x + length * (trial[0] - x)
        place[1] = y + length * (trial[1] - y)
        place[2] = z + length * (trial[2] - z)
        if change_at(deviation, surface, place) < -WORTHWHILE * present:
            return True
        length *= 0.5
    return False


interface.implement(
    FinestState,
    optimum=_optimum,
    error=_error,
    merge=_merge,
    settle=_settle,
    reach=_reach,
    improve=_improve,
    depends_on_ring=True,
    eager_collapses=4000,
)
