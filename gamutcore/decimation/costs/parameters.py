"""The three costs as sets of parameters: ``quadric``, ``volume`` and ``finest``.

``quadric`` is the published cost. ``volume``, the default, and ``finest`` are the same algorithm
with different parameters. Fine levels use memoryless quadrics. From `Parameters.compared_vertices`
on, the error of an edge is the change of the mismatch with a reference, evaluated by samples.
``volume`` compares with the level at which the comparison begins, and preserves the volume.
``finest`` compares with the full boundary and moves vertices to lower the mismatch.
"""

from __future__ import annotations

from typing import NamedTuple

from gamutcore.errors import OptionError

__all__ = [
    "ACCUMULATED",
    "COSTS",
    "MEMORYLESS",
    "SWEPT_DOWN_TO",
    "Cost",
    "Parameters",
    "Trials",
    "cost_named",
]

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
