"""The three costs ``quadric``, ``volume`` and ``finest``: parameters, state and evaluation.

``quadric`` is the published cost. ``volume``, the default, and ``finest`` are the same algorithm
with different parameters. Fine levels use memoryless quadrics. In levels of at most
`Parameters.compared_vertices` vertices, the error of an edge is the change of the mismatch with a
reference, evaluated by samples. The reference of ``volume`` is the first of these levels, and every
level keeps the volume. The reference of ``finest`` is the full boundary, and vertices move to lower
the mismatch.

All costs share one type of state, so the collapse loop is compiled once. Each kernel selects the
algorithm by `Parameters.kind`. A cost only proposes positions. The collapse loop rounds and tests
them, so no cost can break the validity of a level.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.decimation.deviation import (
    SAMPLES,
    TOP,
    TOTAL_WEIGHT,
    Deviation,
    assign_samples,
    deviation_on_faces,
    empty_deviation,
    find_better_position,
    mismatch_error,
    reassign_samples,
    refine_point,
    sample_capacity,
    take_samples,
    thin_samples,
)
from gamutcore.decimation.quadrics import (
    SUM_SIZE,
    Quadrics,
    account_for_volume,
    accumulate,
    area_vectors,
    constrained_error,
    constrained_optimum,
    plane_error,
    plane_optimum,
    renew_quadrics,
    vertex_quadrics,
)
from gamutcore.decimation.surface_mesh import DEFICIT_NOW, SurfaceMesh, surface_of
from gamutcore.errors import OptionError
from gamutcore.kernels import inlined_kernel, leaf_kernel

ACCUMULATED = 0
"""Kind of a cost: accumulated plane quadrics, in one phase and in strict order."""

MEMORYLESS = 1
"""Kind of a cost: memoryless quadrics, and the change of the mismatch in coarse levels."""

SWEPT_DOWN_TO = 6000
"""Number of vertices at which the sweeps end and strict order begins."""

MOVED_FRACTION = 10
"""Vertices move in levels with at most this part of the full boundary's vertices, one in ten.

A move takes 28 bits of a history, and six neighbours move in a split. Levels with half as many
vertices as the first level with moves are as accurate as if all levels had moves.
"""

MOVED_AT_LEAST = 100
"""Vertices move in levels with at most this number of vertices, whatever the boundary's size."""

SAMPLES_OF_REFERENCE_FACE = 12
"""Largest mean number of samples per face of the reference. More samples of a flat face add time
and hardly any information."""


class Parameters(NamedTuple):
    """Numbers that the kernels need. Levels are given by their numbers of vertices."""

    kind: int  # `ACCUMULATED` or `MEMORYLESS`
    preserves_volume: bool = False  # every level has the volume of the full boundary
    # whether the reference is the full boundary; otherwise it is the first compared level
    compares_with_full: bool = False
    compared_vertices: int = 0  # levels of at most this size are compared with the reference
    # in levels of at most this size the new vertex and its neighbours move after a collapse
    moved_vertices: int = 0
    # so many collapses before the end, errors that have changed are evaluated at once; before, when
    # their edge comes to the front of the queue
    eager_collapses: int = 0
    samples: int = 0  # approximate number of samples of the reference; each face has one at least
    largest_samples: int = 0  # if there were more samples, half as many are selected
    # half of the samples are removed when a face has twice as many on average, so that the time for
    # an edge stays the same
    samples_per_face: int = 0
    # levels of at most this size keep their samples: each collapse counts
    thinned_vertices: int = 0

    def for_boundary(self, vertices: int, faces: int) -> Parameters:
        """Return the parameters with the limits that depend on the size of the full boundary."""
        moved = min(self.moved_vertices, max(vertices // MOVED_FRACTION, MOVED_AT_LEAST))
        samples = self.samples
        if self.compares_with_full:
            samples = min(samples, SAMPLES_OF_REFERENCE_FACE * faces)
        return self._replace(moved_vertices=moved, samples=samples)


class Trials(NamedTuple):
    """Multi-start search for the coarse levels: of several decimations the best one counts."""

    vertices: int  # level at which the trials begin; smaller boundaries begin at once
    number: int  # the first trial has the exact errors, the others perturbed ones
    until: int  # level at which the trials end and their deviations are compared


class Cost(NamedTuple):
    """A cost, and the phases of a decimation with it."""

    name: str
    parameters: Parameters
    compacted: tuple[int, ...] = ()  # levels at which the surface is compacted in memory
    trials: Trials | None = None


_COMPARED_BY_VOLUME = 2000
"""`Parameters.compared_vertices` of ``volume``; the surface is compacted there as well."""

_COMPARED_BY_FINEST = 4000
"""`Parameters.compared_vertices` of ``finest``; the surface is compacted there as well."""

_COSTS = {
    cost.name: cost
    for cost in (
        Cost(
            "finest",
            Parameters(
                MEMORYLESS,
                compares_with_full=True,
                compared_vertices=_COMPARED_BY_FINEST,
                moved_vertices=1500,
                eager_collapses=2500,
                samples=40_000,
                largest_samples=160_000,
                samples_per_face=16,
                thinned_vertices=250,
            ),
            compacted=(_COMPARED_BY_FINEST,),
            trials=Trials(150, 8, 27),
        ),
        Cost("quadric", Parameters(ACCUMULATED)),
        Cost(
            "volume",
            Parameters(
                MEMORYLESS,
                preserves_volume=True,
                compared_vertices=_COMPARED_BY_VOLUME,
                eager_collapses=700,
                samples=16_000,
                largest_samples=1 << 40,
                samples_per_face=12,
                thinned_vertices=100,
            ),
            compacted=(SWEPT_DOWN_TO, _COMPARED_BY_VOLUME),
            trials=Trials(70, 4, 27),
        ),
    )
}

COSTS: tuple[str, ...] = tuple(_COSTS)
"""Names of all costs."""


def cost_named(name: str) -> Cost:
    """Return a cost by its name, one of `COSTS`. Raises `OptionError` if there is no such cost."""
    if name not in _COSTS:
        raise OptionError(
            f"there is no cost {name!r}",
            where={"field": "cost"},
            remedy=f"Give one of {', '.join(COSTS)}.",
        )
    return _COSTS[name]


class GridPositions(NamedTuple):
    """Positions on the grid that all positions of all levels lie on, in the colour space."""

    position: Float32Array  # (V, 3)
    centre: FloatArray  # (3,) origin of `SurfaceMesh.position`
    step: float  # distance of neighbouring grid lines, a power of two


class State(NamedTuple):
    """A surface to decimate, the state of its cost, and its numbers in the full boundary."""

    parameters: Parameters
    surface: SurfaceMesh
    grid: GridPositions
    quadrics: Quadrics
    deviation: Deviation  # without samples if the cost never compares levels with a reference
    level: IndexArray  # (1,) vertices of the present level, as `enter_level` left it
    trial_point: FloatArray  # (3,) scratch
    vertices: IndexArray  # (v,) numbers of the vertices in the full boundary
    faces: IndexArray  # (f,) numbers of the faces in the full boundary

    @property
    def size(self) -> int:
        """Number of vertices before the first collapse."""
        return len(self.vertices)


def initial_state(
    parameters: Parameters,
    positions: FloatArray,
    faces: IndexArray,
    opposite: IndexArray,
    grid: GridPositions,
) -> State:
    """Return the state before the first collapse of a full boundary.

    `positions` are relative to the centre; the grid has them in coordinates of the colour space.
    `opposite` has no −1, because the mesh is closed.
    """
    count = len(positions)
    parameters = parameters.for_boundary(count, len(faces))
    fresh = np.zeros(count, np.uint8)
    if parameters.kind == ACCUMULATED:
        quadrics = Quadrics(vertex_quadrics(positions, faces), fresh, np.empty((0, 4)))
        deviation = empty_deviation(0, 0)
    else:
        quadrics = Quadrics(np.empty((count, SUM_SIZE)), fresh, area_vectors(positions, faces))
        reference = len(faces)
        if not parameters.compares_with_full:
            reference = 2 * min(parameters.compared_vertices, count) - 4
        capacity = sample_capacity(parameters.samples, reference)
        deviation = empty_deviation(min(capacity, parameters.largest_samples), len(faces))
    return State(
        parameters,
        surface_of(positions, faces, opposite),
        grid,
        quadrics,
        deviation,
        np.full(1, count, np.int32),
        np.zeros(3),
        np.arange(count, dtype=np.int32),
        np.arange(len(faces), dtype=np.int32),
    )


def compact_state(state: State) -> State:
    """Return the remaining surface as a state of its own, in the same order.

    After many collapses each face lies in a cache line of its own. Compacted, the surface fits the
    cache and is small enough to copy for several trials.
    """
    surface, quadrics, deviation = state.surface, state.quadrics, state.deviation
    corners = surface.corner_facing[surface.corner_facing >= 0]
    left = np.union1d(corners // 3, surface.opposite[corners] // 3)
    faces, face_number = _renumber(left, len(state.faces))
    corner_vertex = surface.vertex.reshape(-1, 3)[faces]
    vertices, vertex_number = _renumber(np.unique(corner_vertex), state.size)
    opposite = surface.opposite.reshape(-1, 3)[faces].ravel()
    small = surface_of(
        surface.position[vertices],
        vertex_number[corner_vertex],
        3 * face_number[opposite // 3] + opposite % 3,
    )
    small.deficit[:] = surface.deficit
    vectors = quadrics.area_vector
    if state.parameters.kind == MEMORYLESS:
        vectors, deviation = vectors[faces], deviation_on_faces(deviation, len(faces))
    return state._replace(
        surface=small,
        grid=state.grid._replace(position=state.grid.position[vertices]),
        quadrics=Quadrics(quadrics.sums[vertices], quadrics.fresh[vertices], vectors),
        deviation=deviation,
        level=state.level.copy(),
        vertices=state.vertices[vertices],
        faces=state.faces[faces],
    )


def _renumber(indices: Any, count: int) -> tuple[IndexArray, IndexArray]:  # noqa: ANN401
    """Return ascending indices below `count` as int32, and the number of each of them."""
    number = np.empty(count, np.int32)
    number[indices] = np.arange(len(indices), dtype=np.int32)
    return indices.astype(np.int32), number


def copy_state(state: State) -> State:
    """Return a copy that can be decimated without changing the original."""
    copy: State = _copy(state)
    return copy


def _copy(values: Any) -> Any:  # noqa: ANN401
    """Copy nested NamedTuples of arrays and numbers."""
    if isinstance(values, tuple):
        return type(values)(*map(_copy, values))
    return values.copy() if isinstance(values, np.ndarray) else values


@leaf_kernel
def enter_level(state: State, vertices: int) -> bool:
    """Prepare for a level of `vertices` vertices; True if the errors of all edges have changed."""
    parameters, deviation, surface = state.parameters, state.deviation, state.surface
    compared = vertices <= parameters.compared_vertices
    begins = compared and not _is_compared(state)
    state.level[0] = vertices
    if deviation.counts[SAMPLES] == 0 and (compared or parameters.compares_with_full):
        take_samples(deviation, surface, parameters.samples)
    if not compared:
        return False
    # in fine levels nothing depends on the assignment of samples to faces
    if deviation.counts[TOP] == 0:
        assign_samples(deviation, surface)
    most = 4 * parameters.samples_per_face * max(vertices, parameters.thinned_vertices)
    return thin_samples(deviation, surface, min(most, parameters.largest_samples)) or begins


@leaf_kernel
def _is_compared(state: State) -> bool:
    """Whether the present level is compared with the reference."""
    return state.level[0] <= state.parameters.compared_vertices


REFINED_SAMPLES = 24
"""Positions are refined in levels with at least so many samples per vertex. With six samples
per face or fewer a position that may change the volume follows the samples instead of the
reference: on spheres of 10,000 vertices the mismatch at 1000 triangles was three times as large."""


@leaf_kernel
def find_optimum(state: State, corner: int, point: FloatArray) -> float:
    """Write the best position of the vertex that replaces an edge, and return its `error_at`.

    `corner` is one of the two that face the edge. The position is relative to the centre.
    """
    surface, quadrics = state.surface, state.quadrics
    if state.parameters.kind == ACCUMULATED:
        return plane_optimum(quadrics, surface, corner, point)
    value = constrained_optimum(quadrics, surface, corner, point)
    if not _is_compared(state):
        return value
    if state.deviation.counts[SAMPLES] < REFINED_SAMPLES * state.level[0]:
        return mismatch_error(state.deviation, surface, corner, point)
    return refine_point(
        state.deviation,
        quadrics,
        surface,
        corner,
        point,
        state.trial_point,
        state.parameters.preserves_volume,
    )


@leaf_kernel
def error_at(state: State, corner: int, point: FloatArray) -> float:
    """Error of replacing the edge that a corner faces by a vertex at a position."""
    if state.parameters.kind == ACCUMULATED:
        return plane_error(state.quadrics, state.surface, corner, point)
    if not _is_compared(state):
        return constrained_error(state.quadrics, state.surface, corner, point)
    return mismatch_error(state.deviation, state.surface, corner, point)


LARGEST_REPAYMENT = 1.0 / 64.0
"""Fraction of the volume that the next collapse compensates at most.

Moves of `finest` change the volume. On boundaries of devices they change less than half of this
fraction down to 20 triangles. On rugged bodies more accumulates, and compensating it would leave no
valid position for any edge.
"""


@leaf_kernel
def update_before_collapse(
    state: State, corner: int, kept: int, dead: int, point: FloatArray
) -> None:
    """Update the cost and the surface's `deficit` for a collapse to `point`, a rounded position."""
    surface = state.surface
    if state.parameters.kind == ACCUMULATED:
        accumulate(state.quadrics, surface, kept, dead, point)
        return
    account_for_volume(state.quadrics, surface, corner, point)
    if state.parameters.moved_vertices > 0:
        largest = LARGEST_REPAYMENT * state.deviation.sums[TOTAL_WEIGHT]
        if abs(surface.deficit[DEFICIT_NOW]) > largest:
            surface.deficit[DEFICIT_NOW] = 0.0


@inlined_kernel
def update_after_change(state: State, vertex: int, left: int, right: int) -> None:
    """Update the cost after a collapse that removed two faces, or a move (both are `NO_FACE`)."""
    if state.parameters.kind == ACCUMULATED:
        return
    renew_quadrics(state.quadrics, state.surface, vertex)
    if _is_compared(state):
        reassign_samples(state.deviation, state.surface, vertex, left, right)


@inlined_kernel
def find_improvement(state: State, vertex: int, point: FloatArray) -> bool:
    """Write a better position of a vertex; False if there is none or vertices do not move."""
    if state.level[0] > state.parameters.moved_vertices:
        return False
    return find_better_position(state.deviation, state.surface, vertex, point, state.trial_point)
