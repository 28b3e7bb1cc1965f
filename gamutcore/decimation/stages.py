"""Decimation in stages: the remaining surface of one stage is compacted for the next.

When a surface of a hundred thousand vertices has been decimated to a few thousand, each face lies
in a cache line of its own. Compacted, the surface fits the cache and is small enough to copy for
several trials. A stage numbers its vertices and faces from 0 and writes a record of its own.
`join_records` joins the records in the numbers of the full boundary.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.decimation.candidates import Grid
from gamutcore.decimation.collapse import collapse_edges
from gamutcore.decimation.costs.dispatch import CostState, cost_state_on
from gamutcore.decimation.costs.parameters import MEMORYLESS, SWEPT_DOWN_TO
from gamutcore.decimation.edge_collapse import COLLAPSES, ROOM, empty_workspace, new_loop
from gamutcore.decimation.record import Record, empty_record, extend_record, trim_record
from gamutcore.decimation.star import Surface, surface_of

if TYPE_CHECKING:
    from gamutcore.arrays import Float32Array, FloatArray, IndexArray, LongArray

__all__ = [
    "EXACT_ERRORS",
    "Stage",
    "StageResult",
    "compact_stage",
    "copy_stage",
    "join_records",
    "run_stage",
]

EXACT_ERRORS = np.empty(0)
"""Perturbation of a stage whose errors are not perturbed."""


class Stage(NamedTuple):
    """A surface to decimate, and the numbers of its vertices and faces in the full boundary.

    Attributes
    ----------
    state : CostState
    surface : Surface
    grid : Grid
    vertices : (v,) int32
        Their numbers in the full boundary.
    faces : (f,) int32
        Their numbers in the full boundary.
    """

    state: CostState
    surface: Surface
    grid: Grid
    vertices: IndexArray
    faces: IndexArray

    @property
    def size(self) -> int:
        """Number of vertices before the first collapse."""
        return len(self.vertices)


class StageResult(NamedTuple):
    """A stage after its collapses.

    Attributes
    ----------
    stage : Stage
    record : Record
        Its collapses, in its own numbers.
    """

    stage: Stage
    record: Record

    @property
    def left(self) -> int:
        """Number of vertices left."""
        return self.stage.size - len(self.record.kept)


def run_stage(
    stage: Stage,
    until: int,
    counter: LongArray,
    *,
    perturbation: FloatArray = EXACT_ERRORS,
    sweep: bool = False,
) -> StageResult:
    """Decimate a surface to a number of vertices.

    Parameters
    ----------
    stage : Stage
        Changed.
    until : int
        Number of vertices to leave: 4 or more.
    counter : (1,) int64
        Counts up with each collapse.
    perturbation : (E,) or (0,) float64, optional
        Perturbation of each edge's error, from 0 to 1.
    sweep : bool, optional
        Whether to make the collapses down to `SWEPT_DOWN_TO` vertices in sweeps.

    Returns
    -------
    StageResult
        With more vertices left only if no edge can be collapsed validly.
    """
    state, surface, grid = stage.state, stage.surface, stage.grid
    work = empty_workspace(surface.corner_facing.size, stage.size, counter, perturbation)
    record, loop = empty_record(stage.size), new_loop()
    swept = 0
    if sweep and state.parameters.kind == MEMORYLESS:
        swept = max(stage.size - max(until, SWEPT_DOWN_TO), 0)
    wanted = stage.size - until
    # as plain Python, kernels divide by zero like compiled code does: to infinity, without a word
    with np.errstate(all="ignore"):
        while not collapse_edges(state, surface, grid, record, work, loop, swept, wanted):
            record = extend_record(record, int(loop.counts[COLLAPSES]), int(loop.counts[ROOM]))
    return StageResult(stage, trim_record(record, int(loop.counts[COLLAPSES])))


def compact_stage(stage: Stage) -> Stage:
    """Return the remaining surface of a stage as a stage of its own, in the same order.

    Parameters
    ----------
    stage : Stage
        After some collapses.

    Returns
    -------
    Stage
    """
    surface, grid = stage.surface, stage.grid
    corners = surface.corner_facing[surface.corner_facing >= 0]
    alive = np.zeros(len(stage.faces), np.bool_)
    alive[corners // 3] = True
    alive[surface.opposite[corners] // 3] = True
    faces, face_number = _renumber(alive)
    corner_vertex = surface.vertex.reshape(-1, 3)[faces]
    alive = np.zeros(stage.size, np.bool_)
    alive[corner_vertex] = True
    vertices, vertex_number = _renumber(alive)
    opposite = surface.opposite.reshape(-1, 3)[faces].ravel()
    small = surface_of(
        surface.position[vertices],
        vertex_number[corner_vertex],
        3 * face_number[opposite // 3] + opposite % 3,
    )
    small.deficit[:] = surface.deficit
    return Stage(
        cost_state_on(stage.state, vertices, faces),
        small,
        grid._replace(position=grid.position[vertices]),
        stage.vertices[vertices],
        stage.faces[faces],
    )


def _renumber(alive: Any) -> tuple[IndexArray, IndexArray]:  # noqa: ANN401  # an array of bool
    """Return the indices that are alive, and the new number of each of them."""
    indices = np.flatnonzero(alive).astype(np.int32)
    number = np.empty(len(alive), np.int32)
    number[indices] = np.arange(len(indices), dtype=np.int32)
    return indices, number


def copy_stage(stage: Stage) -> Stage:
    """Return a copy that can be decimated without changing the stage."""
    return stage._replace(
        state=_copy(stage.state), surface=_copy(stage.surface), grid=_copy(stage.grid)
    )


def _copy(values: Any) -> Any:  # noqa: ANN401
    """Copy nested NamedTuples of arrays and numbers."""
    if isinstance(values, tuple):
        return type(values)(*map(_copy, values))
    return values.copy() if isinstance(values, np.ndarray) else values


def join_records(results: list[StageResult]) -> tuple[Record, IndexArray, Float32Array]:
    """Join the records of consecutive stages.

    Parameters
    ----------
    results : list of StageResult
        From the full boundary on, each beginning where the one before ended.

    Returns
    -------
    record : Record
        All collapses, in the numbers of the full boundary.
    vertex : (3 F,) int32
        Vertices at the corners of its faces after the last collapse.
    positions : (V, 3) float32
        Positions on the grid after the last collapse.
    """
    first = results[0].stage
    vertex, positions = first.surface.vertex, first.grid.position
    parts: list[Record] = []
    moves = shifts = 0
    for number, (stage, record) in enumerate(results):
        part = record
        if number > 0:
            part = _in_full_numbers(stage, record)
            vertex.reshape(-1, 3)[stage.faces] = stage.vertices[stage.surface.vertex.reshape(-1, 3)]
            positions[stage.vertices] = stage.grid.position
        parts.append(
            part._replace(moved_end=part.moved_end + moves, shifted_end=part.shifted_end + shifts)
        )
        moves, shifts = moves + len(part.moved), shifts + len(part.shifted)
    return Record(*map(np.concatenate, zip(*parts, strict=True))), vertex, positions


def _in_full_numbers(stage: Stage, record: Record) -> Record:
    def corner(corners: IndexArray) -> IndexArray:
        return 3 * stage.faces[corners // 3] + corners % 3

    return record._replace(
        kept=stage.vertices[record.kept],
        dead=stage.vertices[record.dead],
        sides=stage.vertices[record.sides],
        corner=corner(record.corner),
        moved=corner(record.moved),
        shifted=stage.vertices[record.shifted],
    )
