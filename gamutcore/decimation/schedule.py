"""The decimation of a full boundary: checks, the schedule of its phases, and the joined record.

A *phase* leads from one level to a coarser one; the *schedule* is the list of phases. `decimate`
rounds the boundary to the grid and runs the schedule. Before each phase but the first, the
remaining surface is compacted: its vertices and faces are numbered from 0. A phase writes a record
in its own numbers. `_join_records` joins the records in the numbers of the full boundary.

The coarse end of a decimation is chaotic. Any change of a rounding leads to other levels, whose
mismatch scatters by some per cent. From a small level on, several trials with perturbed errors are
therefore made (multi-start search), and the trial with the least deviation is kept.

A kernel releases the interpreter lock and only counts its collapses. A thread reads the counter to
report progress. Collapses take more time in some parts of the work than in others, so each part has
a weight.
"""

from __future__ import annotations

import contextlib
import threading
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.decimation.collapse import collapse_edges, empty_workspace
from gamutcore.decimation.costs import (
    MEMORYLESS,
    SWEPT_DOWN_TO,
    Cost,
    GridPositions,
    State,
    Trials,
    compact_state,
    copy_state,
    cost_named,
    initial_state,
)
from gamutcore.decimation.record import Record, empty_record, extend_record, trim_record
from gamutcore.decimation.surface_mesh import DEFICIT_LARGEST
from gamutcore.errors import DecimationError, MeshError
from gamutcore.geometry import (
    GOLDEN,
    faces_not_seeing_centre,
    mesh_grid_step,
    mixed_bits,
    nearest_grid_points,
    opposite_corners,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import ArrayLike

    from gamutcore.arrays import Float32Array, FloatArray, IndexArray, LongArray
    from gamutcore.geometry import TriangleMesh


class Decimation(NamedTuple):
    """A boundary's decimation to four triangles.

    Attributes
    ----------
    record : Record
        Every collapse, in order.
    vertex : (3 F,) int32
        Vertices at the corners of the boundary's faces after the last collapse.
    positions : (V, 3) float32
        Positions after the last collapse.
    centre : (3,) float64
        The centre that every level is star-shaped about.
    step : float
        Step of the grid that the positions of all levels lie on.
    volume_error : float or None
        Largest difference of the volume of a level from the volume of the full boundary; None if
        the cost does not preserve the volume.
    """

    record: Record
    vertex: IndexArray
    positions: Float32Array
    centre: FloatArray
    step: float
    volume_error: float | None


UNIT_STEPS = 18
"""Binary logarithm of the number of grid steps in the internal unit of length. By the choice of the
grid the unit is about the thickness of the mesh."""


def decimate(
    mesh: TriangleMesh,
    centre: ArrayLike,
    cost: str = "volume",
    *,
    progress: Callable[[float], None] | None = None,
) -> Decimation:
    """Decimate a boundary to four triangles and return the record of all collapses.

    Parameters
    ----------
    mesh : TriangleMesh
        A closed, oriented mesh of genus 0. With its positions rounded to the grid of
        `gamutcore.geometry.mesh`, it is star-shaped about the centre.
    centre : (3,) array_like
    cost : str, optional
        The error of a collapse; one of `gamutcore.decimation.COSTS`.
    progress : callable, optional
        Called with the approximate fraction of the work that is done, ten times a second, from
        another thread.

    Returns
    -------
    Decimation
        Every level is a closed, oriented mesh of genus 0, star-shaped about the centre.

    Raises
    ------
    OptionError
        If there is no such cost.
    MeshError
        If the mesh is not closed, oriented, of genus 0 and star-shaped. The message says which.
    DecimationError
        If no edge can be collapsed validly although more than four triangles are left.

    Examples
    --------
    >>> from gamutcore.boundary import modified_convex_hull
    >>> boundary = modified_convex_hull(np.random.default_rng(0).normal(size=(50, 3)))
    >>> decimation = decimate(boundary.mesh, boundary.centre)
    >>> len(decimation.record.kept) == len(boundary.mesh.vertices) - 4
    True
    """
    chosen = cost_named(cost)
    origin = np.asarray(centre, np.float64)
    if not (mesh.triangles and np.isfinite(mesh.vertices).all() and np.isfinite(origin).all()):
        raise MeshError(
            "the mesh has no faces, or coordinates that are not finite numbers",
            remedy="Give finite numbers.",
        )
    step = mesh_grid_step(mesh.vertices)
    # a unit near the size of the mesh: products of nine coordinates must not vanish or overflow
    unit = step * 2.0**UNIT_STEPS
    on_grid = np.ascontiguousarray(nearest_grid_points(mesh.vertices, step) / unit, np.float32)
    positions = on_grid.astype(np.float64) - origin / unit
    faces = np.ascontiguousarray(mesh.faces, np.int32)
    opposite = opposite_corners(faces, len(positions))
    _check_boundary(mesh, faces, opposite, positions)
    phases = _schedule(chosen, len(positions))
    coarse = COARSE if chosen.trials else 0.0
    work = _Progress([(phase.collapses, phase.work(coarse)) for phase in phases])
    with _report_progress(work.fraction, progress):
        # the state has no name here, so that it can be freed before the last level
        results = _run_schedule(
            initial_state(
                chosen.parameters,
                positions,
                faces,
                opposite,
                GridPositions(on_grid, origin / unit, float(step / unit)),
            ),
            phases,
            work,
        )
    record, vertex, final = _join_records(results)
    if results[-1].left > 4:
        raise DecimationError(
            f"no edge could be collapsed validly with {2 * results[-1].left - 4} triangles left",
            remedy="Give a boundary whose faces are less degenerate, or another centre.",
        )
    for positions_in_units in (record.position, record.shift, final):
        # the unit is a power of two, so nothing is rounded
        np.multiply(positions_in_units, np.float32(unit), out=positions_in_units)
    volume_error = None
    if chosen.parameters.preserves_volume:
        deficit = results[-1].state.surface.deficit[DEFICIT_LARGEST]
        volume_error = float(deficit) / 6.0 * unit**3
    return Decimation(record, vertex, final, origin, step, volume_error)


def _check_boundary(
    mesh: TriangleMesh, faces: IndexArray, opposite: IndexArray, positions: FloatArray
) -> None:
    """Raise `MeshError` unless the mesh is a valid boundary."""
    vertices, triangles = len(mesh.vertices), mesh.triangles
    if (opposite < 0).any():
        face = int(np.flatnonzero(opposite < 0)[0]) // 3
        raise MeshError(
            f"the mesh is not closed and consistently oriented: face {face} has an edge without"
            " exactly one neighbour",
            where={"face": face},
            remedy="Give a closed mesh whose faces are all oriented outwards.",
        )
    if triangles != 2 * vertices - 4 or triangles < 4:
        raise MeshError(
            f"{triangles} faces over {vertices} vertices are not a surface of genus 0",
            remedy=f"Give {2 * vertices - 4} faces: one closed piece without handles or unused "
            "vertices.",
        )
    hidden = faces_not_seeing_centre(positions, faces)
    if hidden.size:
        raise MeshError(
            f"the mesh is not star-shaped about the centre: {hidden.size} faces do not see it from"
            f" inside, the first of them face {hidden[0]}",
            where={"face": int(hidden[0])},
            remedy="Give a centre that all faces see from inside.",
        )


COARSEST = 4
"""Number of vertices of the last level."""

COARSE = 1800.0
"""Relative time of a collapse in coarse levels, where errors are evaluated by samples. With
``volume`` a collapse takes 95 times as long at 50 vertices as in fine levels, and a fiftieth of
that at 10,000. Only progress depends on this number."""


class _Phase(NamedTuple):
    """Part of a schedule, from one level to another: one decimation, or several trials of it."""

    vertices: int
    until: int
    trials: Trials | None

    @property
    def collapses(self) -> int:
        """Number of collapses, in all trials."""
        return (self.vertices - self.until) * (self.trials.number if self.trials else 1)

    def work(self, coarse: float) -> float:
        """Work in collapses of a fine level; at n vertices a collapse has `coarse` ÷ n^¾ more."""
        more = 4 * coarse * (self.vertices**0.25 - self.until**0.25)
        return self.collapses * (1 + more / max(self.vertices - self.until, 1))


def _schedule(cost: Cost, size: int) -> list[_Phase]:
    """Return the phases of a decimation from `size` vertices to four."""
    trials = cost.trials if cost.trials and cost.trials.until < size else None
    begin = min(trials.vertices, size) if trials else size
    stops = {*cost.compacted, begin, COARSEST}
    phases: list[_Phase] = []
    left = size
    while not phases or left > COARSEST:
        if trials and left == begin:
            phases.append(_Phase(left, trials.until, trials))
        else:
            phases.append(_Phase(left, max((s for s in stops if s < left), default=left), None))
        left = phases[-1].until
    return phases


def _run_schedule(state: State, phases: list[_Phase], progress: _Progress) -> list[_PhaseResult]:
    """Decimate a full boundary, changing its state, and return the results of all phases.

    The last result has more than four vertices left if no edge can be collapsed validly.
    """
    results: list[_PhaseResult] = []
    for phase in phases:
        if results:
            state = compact_state(results[-1].state)
            # the quadrics and samples of a large boundary take much memory
            old = results[-1].state
            small = old._replace(quadrics=state.quadrics, deviation=state.deviation)
            results[-1] = results[-1]._replace(state=small)
        counter = progress.begin_part()
        if phase.trials is None:
            result = _run_phase(state, phase.until, counter, sweep=not results)
        else:
            result = _run_trials(state, phase.trials, counter)
        results.append(result)
        if result.left != phase.until:
            break
    return results


def _run_trials(state: State, trials: Trials, counter: LongArray) -> _PhaseResult:
    """Return the trial with the least deviation; one that ends too early counts as infinite."""
    results = []
    deviations = []
    for trial in range(trials.number):
        copy = copy_state(state)
        perturbed = perturbation(copy.surface.corner_facing.size, trial)
        results.append(_run_phase(copy, trials.until, counter, perturbation=perturbed))
        complete = results[-1].left == trials.until
        deviations.append(copy.deviation.error.sum() if complete else np.inf)
    return results[int(np.argmin(deviations))]


def perturbation(edges: int, trial: int) -> FloatArray:
    """Perturbation of each edge in a trial: pseudorandom, uniform in [0, 1); empty for trial 0.

    The hash of SplitMix64 of the edge and the trial.
    """
    if trial == 0:
        return EXACT_ERRORS
    bits = mixed_bits(np.arange(edges, dtype=np.uint64) + np.uint64(trial << 32) + GOLDEN)
    return (bits >> np.uint64(11)).astype(np.float64) * 2.0**-53


EXACT_ERRORS = np.empty(0)
"""Perturbation of a phase whose errors are not perturbed."""


class _PhaseResult(NamedTuple):
    """A state after its collapses, and their record in the numbers of the phase."""

    state: State
    record: Record

    @property
    def left(self) -> int:
        """Number of vertices left."""
        return self.state.size - len(self.record.kept)


def _run_phase(
    state: State,
    until: int,
    counter: LongArray,
    *,
    perturbation: FloatArray = EXACT_ERRORS,
    sweep: bool = False,
) -> _PhaseResult:
    """Decimate the surface of a state in place to `until` vertices, 4 or more.

    More are left only if no edge can be collapsed validly. `counter` counts up with each collapse.
    With `sweep`, the collapses down to `SWEPT_DOWN_TO` vertices are made in sweeps.
    """
    parameters, edges = state.parameters, state.surface.corner_facing.size
    record = empty_record(state.size, parameters.moved_vertices)
    work = empty_workspace(edges, state.size, counter, perturbation)
    swept = 0
    if sweep and parameters.kind == MEMORYLESS:
        swept = state.size - max(until, SWEPT_DOWN_TO, parameters.compared_vertices)
    # as plain Python, kernels divide by zero like compiled code does: to infinity, without a word
    with np.errstate(all="ignore"):
        while missing := collapse_edges(state, record, work, swept, state.size - until):
            record = extend_record(record, int(work.collapses[0]), int(missing))
    return _PhaseResult(state, trim_record(record, int(work.collapses[0])))


def _join_records(results: list[_PhaseResult]) -> tuple[Record, IndexArray, Float32Array]:
    """Join the records of consecutive phases in the numbers of the full boundary.

    The other results are the (3 F,) vertices at the boundary's corners and the (V, 3) positions on
    the grid, both after the last collapse. They are arrays of the first state, changed in place.
    """
    first = results[0].state
    vertex, positions = first.surface.vertex, first.grid.position
    parts: list[Record] = []
    moves = shifts = 0
    for number, (state, record) in enumerate(results):
        part = record
        if number > 0:
            part = _renumber_record(state, record)
            vertex.reshape(-1, 3)[state.faces] = state.vertices[state.surface.vertex.reshape(-1, 3)]
            positions[state.vertices] = state.grid.position
        parts.append(
            part._replace(moved_end=part.moved_end + moves, shifted_end=part.shifted_end + shifts)
        )
        moves, shifts = moves + len(part.moved), shifts + len(part.shifted)
    return Record(*map(np.concatenate, zip(*parts, strict=True))), vertex, positions


def _renumber_record(state: State, record: Record) -> Record:
    """Return the record of a phase in the numbers of the full boundary."""

    def corner(corners: IndexArray) -> IndexArray:
        return 3 * state.faces[corners // 3] + corners % 3

    return record._replace(
        kept=state.vertices[record.kept],
        dead=state.vertices[record.dead],
        sides=state.vertices[record.sides],
        corner=corner(record.corner),
        moved=corner(record.moved),
        shifted=state.vertices[record.shifted],
    )


class _Progress:
    """Progress of work that consists of parts, each given as its final count and amount of work."""

    def __init__(self, parts: Sequence[tuple[int, float]]) -> None:
        self._parts = iter(parts)
        self._total = sum(work for _, work in parts)
        # replaced as a whole, because another thread reads it
        self._present = (0.0, 0, 0.0, np.zeros(1, np.int64))

    def begin_part(self) -> LongArray:
        """Begin the next part, and return the counter for it."""
        before, _, work, _ = self._present
        counter = np.zeros(1, np.int64)
        self._present = (before + work, *next(self._parts), counter)
        return counter

    def fraction(self) -> float:
        """Return the fraction of the work that is done."""
        before, count, work, counter = self._present
        here = min(int(counter[0]) / count, 1.0) * work if count > 0 else 0.0
        return min((before + here) / self._total, 1.0) if self._total > 0.0 else 1.0


_INTERVAL = 0.1
"""Seconds between two reports."""


@contextlib.contextmanager
def _report_progress(
    fraction: Callable[[], float], progress: Callable[[float], None] | None
) -> Iterator[None]:
    """Report progress while the body of the context runs.

    `fraction` returns the fraction of the work that is done. `progress` is called with it in
    another thread. Leaving the context raises any exception of `progress`.
    """
    if progress is None:
        yield
        return
    ended = threading.Event()
    faults: list[BaseException] = []

    def report() -> None:
        try:
            while not ended.wait(_INTERVAL):
                progress(fraction())
        except BaseException as error:  # noqa: BLE001 - raised in the thread that it concerns
            faults.append(error)

    reporter = threading.Thread(target=report, name="progress", daemon=True)
    reporter.start()
    try:
        yield
    finally:
        ended.set()
        reporter.join()
    if faults:
        raise faults[0]
