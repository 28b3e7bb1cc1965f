"""Decimation in stages: the remaining surface of one stage is compacted for the next.

A stage numbers its vertices and faces from 0 and writes a record of its own. `join_records` joins
the records in the numbers of the full boundary.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.decimation.collapse import collapse_edges
from gamutcore.decimation.costs.parameters import MEMORYLESS, SWEPT_DOWN_TO
from gamutcore.decimation.edge_collapse import empty_workspace
from gamutcore.decimation.record import Record, empty_record, extend_record, trim_record
from gamutcore.decimation.stage import Stage

if TYPE_CHECKING:
    from gamutcore.arrays import Float32Array, FloatArray, IndexArray, LongArray

__all__ = ["EXACT_ERRORS", "StageResult", "join_records", "run_stage"]

EXACT_ERRORS = np.empty(0)
"""Perturbation of a stage whose errors are not perturbed."""


class StageResult(NamedTuple):
    """A stage after its collapses, and their record in the stage's own numbers."""

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
    """Decimate the surface of a stage in place to `until` vertices, 4 or more.

    More are left only if no edge can be collapsed validly. `counter` counts up with each collapse.
    With `sweep`, the collapses down to `SWEPT_DOWN_TO` vertices are made in sweeps.
    """
    parameters, edges = stage.parameters, stage.surface.corner_facing.size
    record = empty_record(stage.size, parameters.moved_vertices)
    work = empty_workspace(edges, stage.size, counter, perturbation)
    swept = 0
    if sweep and parameters.kind == MEMORYLESS:
        swept = stage.size - max(until, SWEPT_DOWN_TO, parameters.compared_vertices)
    # as plain Python, kernels divide by zero like compiled code does: to infinity, without a word
    with np.errstate(all="ignore"):
        while missing := collapse_edges(stage, record, work, swept, stage.size - until):
            record = extend_record(record, int(work.collapses[0]), int(missing))
    return StageResult(stage, trim_record(record, int(work.collapses[0])))


def join_records(results: list[StageResult]) -> tuple[Record, IndexArray, Float32Array]:
    """Join the records of consecutive stages in the numbers of the full boundary.

    The other results are the (3 F,) vertices at the boundary's corners and the (V, 3) positions on
    the grid, both after the last collapse.
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
