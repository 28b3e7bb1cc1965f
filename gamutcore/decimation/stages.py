"""Decimation in stages: what one leaves is compacted for the next.

Of a surface with a hundred thousand vertices that has been decimated to a few thousand, every face
lies in a cache line of its own. Compacted it fits the cache, and is small enough to be copied for
several ways down. A stage numbers its vertices and faces by itself and writes a record of its own;
`joined` puts these together in the numbers of the full boundary.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.decimation.collapse import collapse_all
from gamutcore.decimation.record import Record
from gamutcore.decimation.star import Surface, surface_of

if TYPE_CHECKING:
    from gamutcore.arrays import Float32Array, FloatArray, IndexArray, LongArray
    from gamutcore.decimation.plan import Plan

__all__ = ["UNDISTURBED", "Passage", "Stage", "carried_out", "compacted", "copied", "joined"]

UNDISTURBED = (0, 0.0)
"""The way on which all edges have the errors that they have."""

NOTHING_KNOWN = np.empty(0)
"""No errors are known, nor to be kept."""


class Stage(NamedTuple):
    """A surface to be decimated, and what its vertices and faces are in the full boundary.

    Attributes
    ----------
    state : NamedTuple of arrays
        Of the cost.
    surface : Surface
    delivered : (v, 3) float32
        Positions as delivered.
    centre : (3,) float64
    step : float
        Of the grid that they lie on.
    vertices : (v,) int32
        Their numbers in the full boundary.
    faces : (f,) int32
        The same of the faces.
    """

    state: Any
    surface: Surface
    delivered: Float32Array
    centre: FloatArray
    step: float
    vertices: IndexArray
    faces: IndexArray


class Passage(NamedTuple):
    """A stage that has been carried out.

    Attributes
    ----------
    stage : Stage
        As it was left.
    record : Record
        Its collapses, in its own numbers.
    """

    stage: Stage
    record: Record

    @property
    def left(self) -> int:
        """Vertices that are left."""
        return len(self.stage.delivered) - len(self.record.kept)


def carried_out(
    stage: Stage,
    until: int,
    record: Record,
    done: LongArray,
    *,
    way: tuple[int, float] = UNDISTURBED,
    known: FloatArray = NOTHING_KNOWN,
    sweeping: bool = False,
) -> Passage:
    """Decimate a surface to a number of vertices.

    Parameters
    ----------
    stage : Stage
        Changed.
    until : int
        Vertices to leave.
    record, done, way, known, sweeping
        As for `collapse_all`.

    Returns
    -------
    Passage
        With more vertices left only if there is no edge that could be collapsed validly.
    """
    record = collapse_all(
        stage.state,
        stage.surface,
        stage.delivered,
        stage.centre,
        stage.step,
        record,
        done,
        np.array(way, np.float64),
        known,
        until,
        sweeping,
    )
    return Passage(stage, record)


def compacted(stage: Stage, plan: Plan) -> Stage:
    """Return what is left of a surface as one of its own, in the same order.

    Parameters
    ----------
    stage : Stage
        After some collapses.
    plan : Plan
        Of the cost.

    Returns
    -------
    Stage
    """
    surface = stage.surface
    corners = surface.corner_facing[surface.corner_facing >= 0]
    alive = np.zeros(len(stage.faces), np.bool_)
    alive[corners // 3] = True
    alive[surface.opposite[corners] // 3] = True
    faces = np.flatnonzero(alive).astype(np.int32)
    number = np.empty(len(stage.faces), np.int32)
    number[faces] = np.arange(len(faces), dtype=np.int32)
    named = surface.vertex.reshape(-1, 3)[faces]
    alive = np.zeros(len(stage.vertices), np.bool_)
    alive[named] = True
    vertices = np.flatnonzero(alive).astype(np.int32)
    name = np.empty(len(stage.vertices), np.int32)
    name[vertices] = np.arange(len(vertices), dtype=np.int32)
    opposite = surface.opposite.reshape(-1, 3)[faces].ravel()
    small = surface_of(
        surface.position[vertices], name[named], 3 * number[opposite // 3] + opposite % 3
    )
    small.deficit[:] = surface.deficit
    return Stage(
        plan.state_on(stage.state, vertices, faces),
        small,
        stage.delivered[vertices],
        stage.centre,
        stage.step,
        stage.vertices[vertices],
        stage.faces[faces],
    )


def copied(stage: Stage) -> Stage:
    """Return a copy that can be decimated while the stage stays what it is."""
    return stage._replace(
        state=_copy(stage.state), surface=_copy(stage.surface), delivered=stage.delivered.copy()
    )


def _copy(arrays: Any) -> Any:  # noqa: ANN401
    """Copy a NamedTuple of arrays and such."""
    if isinstance(arrays, tuple):
        return type(arrays)(*map(_copy, arrays))
    return arrays.copy()


def joined(record: Record, passages: list[Passage]) -> tuple[Record, IndexArray, Float32Array]:
    """Put the records of stages together.

    Parameters
    ----------
    record : Record
        With room for all collapses; the first stage's may be in it already.
    passages : list of Passage
        From the full boundary on, each beginning where the one before ended.

    Returns
    -------
    record : Record
        All collapses, in the numbers of the full boundary.
    vertex : (3 F,) int32
        Vertices at the corners of its faces after the last collapse.
    delivered : (V, 3) float32
        Positions after it.
    """
    first = passages[0].stage
    vertex, delivered = first.surface.vertex, first.delivered
    growing: dict[str, list[Any]] = {"moved": [], "shifted": [], "shift": []}
    collapses = moves = shifts = 0
    for number, (stage, part) in enumerate(passages):
        named = part
        if number > 0:
            named = _in_full_numbers(stage, part)
            vertex.reshape(-1, 3)[stage.faces] = stage.vertices[stage.surface.vertex.reshape(-1, 3)]
            delivered[stage.vertices] = stage.delivered
        named = named._replace(
            moved_end=named.moved_end + moves, shifted_end=named.shifted_end + shifts
        )
        until = collapses + len(named.kept)
        for name, values in named._asdict().items():
            if name in growing:
                growing[name].append(values)
            else:
                getattr(record, name)[collapses:until] = values
        collapses = until
        moves, shifts = moves + len(named.moved), shifts + len(named.shifted)
    parts = {name: values[:collapses] for name, values in record._asdict().items()}
    parts.update((name, np.concatenate(values)) for name, values in growing.items())
    return Record(**parts), vertex, delivered


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
