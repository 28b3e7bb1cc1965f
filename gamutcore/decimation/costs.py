"""The three costs ``quadric``, ``volume`` and ``finest``: parameters, state and evaluation.

``quadric`` is the published cost. ``volume``, the default, and ``finest`` are the same algorithm
with different parameters. Fine levels use memoryless quadrics. From `Parameters.compared_vertices`
on, the error of an edge is the change of the mismatch with a reference, evaluated by samples.
``volume`` compares with the level at which the comparison begins, and preserves the volume.
``finest`` compares with the full boundary and moves vertices to lower the mismatch.

All costs share one type of state, so the collapse loop is compiled once. Each kernel selects the
algorithm by `Parameters.kind`. A cost only proposes positions. The collapse loop rounds and tests
them, so no cost can break the validity of a level.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.decimation.deviation import find_better_position, mismatch_error, refine_point
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
from gamutcore.decimation.samples import (
    SAMPLES,
    TOP,
    TOTAL_WEIGHT,
    Deviation,
    assign_samples,
    deviation_on_faces,
    empty_deviation,
    reassign_samples,
    sample_capacity,
    take_samples,
    thin_samples,
)
from gamutcore.decimation.surface_mesh import DEFICIT_NOW, Surface, surface_of
from gamutcore.errors import OptionError
from gamutcore.kernels import inlined_kernel, leaf_kernel

ACCUMULATED = 0
"""Kind of a cost: accumulated plane quadrics, in one stage and in strict order."""

MEMORYLESS = 1
"""Kind of a cost: memoryless quadrics, and the change of the mismatch in coarse levels."""

SWEPT_DOWN_TO = 6000
"""Number of vertices at which the sweeps end and strict order begins."""

MOVED_FRACTION = 10
"""Vertices move in levels with at most one in so many of the full boundary's vertices.

A move takes 28 bits of a history, and six neighbours move in a split. Levels with half as many
vertices as the first level with moves are as accurate as if all levels had moves.
"""

MOVED_AT_LEAST = 100
"""Vertices move in levels with so many vertices and fewer, whatever the size of the boundary."""

SAMPLES_OF_REFERENCE_FACE = 12
"""Largest mean number of samples per face of the reference. More samples of a flat face add time
and hardly any information."""


class Parameters(NamedTuple):
    """Numbers that the kernels need. Levels are given by their numbers of vertices.

    Attributes
    ----------
    kind : int
        `ACCUMULATED` or `MEMORYLESS`.
    preserves_volume : bool
        Whether every level has the volume of the full boundary.
    compares_with_full : bool
        Whether the reference is the full boundary. Otherwise it is the first compared level.
    compared_vertices : int
        Levels of at most this size are compared with the reference.
    moved_vertices : int
        In levels of at most this size the new vertex and its neighbours move after a collapse.
    eager_collapses : int
        So many collapses before the end, errors that have changed are evaluated at once. Before,
        they are evaluated when their edge comes to the front of the queue.
    samples : int
        Approximate number of samples of the reference. Each of its faces has at least one.
    largest_samples : int
        If there were more samples, half as many are selected.
    samples_per_face : int
        Half of the samples are removed when a face has twice as many on average. The time for an
        edge then stays the same.
    thinned_vertices : int
        Levels of at most this size keep their samples, because each collapse matters there.
    """

    kind: int
    preserves_volume: bool = False
    compares_with_full: bool = False
    compared_vertices: int = 0
    moved_vertices: int = 0
    eager_collapses: int = 0
    samples: int = 0
    largest_samples: int = 0
    samples_per_face: int = 0
    thinned_vertices: int = 0

    def for_boundary(self, vertices: int, faces: int) -> Parameters:
        """Return the parameters with the limits that depend on the size of the full boundary."""
        moved = min(self.moved_vertices, max(vertices // MOVED_FRACTION, MOVED_AT_LEAST))
        samples = self.samples
        if self.compares_with_full:
            samples = min(samples, SAMPLES_OF_REFERENCE_FACE * faces)
        return self._replace(moved_vertices=moved, samples=samples)


class Trials(NamedTuple):
    """Multi-start search for the coarse levels: several decimations, of which the best one counts.

    Attributes
    ----------
    vertices : int
        Level at which the trials begin. Smaller boundaries begin at once.
    number : int
        Number of trials. The first has the exact errors, the others perturbed ones.
    until : int
        Level at which the trials end and their deviations are compared.
    """

    vertices: int
    number: int
    until: int


class Cost(NamedTuple):
    """A cost, and the stages of a decimation with it.

    Attributes
    ----------
    name : str
    parameters : Parameters
    compacted : tuple of int
        Levels at which the remaining surface is compacted in memory.
    trials : Trials or None
    """

    name: str
    parameters: Parameters
    compacted: tuple[int, ...] = ()
    trials: Trials | None = None


_TRACKED_VERTICES = 2000

_COMPARED_VERTICES = 4000

_COSTS = {
    cost.name: cost
    for cost in (
        Cost(
            "finest",
            Parameters(
                MEMORYLESS,
                compares_with_full=True,
                compared_vertices=_COMPARED_VERTICES,
                moved_vertices=1500,
                eager_collapses=2500,
                samples=40_000,
                largest_samples=160_000,
                samples_per_face=16,
                thinned_vertices=250,
            ),
            compacted=(_COMPARED_VERTICES,),
            trials=Trials(150, 8, 27),
        ),
        Cost("quadric", Parameters(ACCUMULATED)),
        Cost(
            "volume",
            Parameters(
                MEMORYLESS,
                preserves_volume=True,
                compared_vertices=_TRACKED_VERTICES,
                eager_collapses=700,
                samples=16_000,
                largest_samples=1 << 40,
                samples_per_face=12,
                thinned_vertices=100,
            ),
            compacted=(SWEPT_DOWN_TO, _TRACKED_VERTICES),
            trials=Trials(70, 4, 27),
        ),
    )
}

COSTS: tuple[str, ...] = tuple(_COSTS)
"""Names of all costs."""


def cost_named(name: str) -> Cost:
    """Return a cost by its name.

    Parameters
    ----------
    name : str
        One of `COSTS`.

    Raises
    ------
    OptionError
        If there is no such cost.

    Examples
    --------
    >>> cost_named("volume").parameters.preserves_volume
    True
    """
    if name not in _COSTS:
        raise OptionError(
            f"there is no cost {name!r}",
            where={"field": "cost"},
            remedy=f"Give one of {', '.join(COSTS)}.",
        )
    return _COSTS[name]


class Grid(NamedTuple):
    """The grid that all positions of all levels lie on.

    Attributes
    ----------
    position : (V, 3) float32
        Positions of the surface in coordinates of the colour space.
    centre : (3,) float64
        Origin of `Surface.position` in coordinates of the colour space.
    step : float
        Distance of neighbouring grid lines, a power of two.
    """

    position: Float32Array
    centre: FloatArray
    step: float


class Stage(NamedTuple):
    """A surface to decimate, the state of its cost, and its numbers in the full boundary.

    All costs share one type of state, so the collapse loop is compiled once.

    Attributes
    ----------
    deviation : Deviation
        Without samples if the cost never compares levels with a reference.
    level : (1,) int32
        Number of vertices of the present level, as `enter_level` left it.
    trial_point : (3,) float64
        Scratch.
    vertices : (v,) int32
        Numbers of the vertices in the full boundary.
    faces : (f,) int32
        Numbers of the faces in the full boundary.
    """

    parameters: Parameters
    surface: Surface
    grid: Grid
    quadrics: Quadrics
    deviation: Deviation
    level: IndexArray
    trial_point: FloatArray
    vertices: IndexArray
    faces: IndexArray

    @property
    def size(self) -> int:
        """Number of vertices before the first collapse."""
        return len(self.vertices)


def new_stage(
    parameters: Parameters,
    positions: FloatArray,
    faces: IndexArray,
    opposite: IndexArray,
    grid: Grid,
) -> Stage:
    """Return the stage that begins with a full boundary.

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
    return Stage(
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


def compact_stage(stage: Stage) -> Stage:
    """Return the remaining surface of a stage as a stage of its own, in the same order.

    After many collapses each face lies in a cache line of its own. Compacted, the surface fits the
    cache and is small enough to copy for several trials.
    """
    surface, quadrics, deviation = stage.surface, stage.quadrics, stage.deviation
    corners = surface.corner_facing[surface.corner_facing >= 0]
    left = np.union1d(corners // 3, surface.opposite[corners] // 3)
    faces, face_number = _renumber(left, len(stage.faces))
    corner_vertex = surface.vertex.reshape(-1, 3)[faces]
    vertices, vertex_number = _renumber(np.unique(corner_vertex), stage.size)
    opposite = surface.opposite.reshape(-1, 3)[faces].ravel()
    small = surface_of(
        surface.position[vertices],
        vertex_number[corner_vertex],
        3 * face_number[opposite // 3] + opposite % 3,
    )
    small.deficit[:] = surface.deficit
    vectors = quadrics.area_vector
    if stage.parameters.kind == MEMORYLESS:
        vectors, deviation = vectors[faces], deviation_on_faces(deviation, len(faces))
    return stage._replace(
        surface=small,
        grid=stage.grid._replace(position=stage.grid.position[vertices]),
        quadrics=Quadrics(quadrics.sums[vertices], quadrics.fresh[vertices], vectors),
        deviation=deviation,
        level=stage.level.copy(),
        vertices=stage.vertices[vertices],
        faces=stage.faces[faces],
    )


def _renumber(indices: Any, count: int) -> tuple[IndexArray, IndexArray]:  # noqa: ANN401
    """Return ascending indices below `count` as int32, and the number of each of them."""
    number = np.empty(count, np.int32)
    number[indices] = np.arange(len(indices), dtype=np.int32)
    return indices.astype(np.int32), number


def copy_stage(stage: Stage) -> Stage:
    """Return a copy that can be decimated without changing the stage."""
    copy: Stage = _copy(stage)
    return copy


def _copy(values: Any) -> Any:  # noqa: ANN401
    """Copy nested NamedTuples of arrays and numbers."""
    if isinstance(values, tuple):
        return type(values)(*map(_copy, values))
    return values.copy() if isinstance(values, np.ndarray) else values


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


@leaf_kernel
def _is_compared(stage: Stage) -> bool:
    """Whether the present level is compared with the reference."""
    return stage.level[0] <= stage.parameters.compared_vertices


REFINED_SAMPLES = 24
"""Positions are refined in levels with at least so many samples per vertex. With six samples
per face or fewer a position that may change the volume follows the samples instead of the
reference: on spheres of 10,000 vertices the mismatch at 1000 triangles was three times as large."""


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


LARGEST_REPAYMENT = 1.0 / 64.0
"""Fraction of the volume that the next collapse compensates at most.

Moves of `finest` change the volume. On boundaries of devices they change less than half of this
fraction down to 20 triangles. On rugged bodies more accumulates, and compensating it would leave no
valid position for any edge.
"""


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


@inlined_kernel
def find_improvement(stage: Stage, vertex: int, point: FloatArray) -> bool:
    """Write a better position of a vertex; False if there is none or vertices do not move."""
    if stage.level[0] > stage.parameters.moved_vertices:
        return False
    return find_better_position(stage.deviation, stage.surface, vertex, point, stage.trial_point)
