"""The data of a decimation that the kernels read and change."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.decimation.costs.memoryless_quadrics import SUM_SIZE, Quadrics, area_vectors
from gamutcore.decimation.costs.parameters import ACCUMULATED, MEMORYLESS, Parameters
from gamutcore.decimation.costs.plane_quadrics import vertex_quadrics
from gamutcore.decimation.costs.samples import (
    Deviation,
    deviation_on_faces,
    empty_deviation,
    sample_capacity,
)
from gamutcore.decimation.star import Surface, surface_of

__all__ = ["Grid", "Stage", "compact_stage", "copy_stage", "new_stage"]


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
