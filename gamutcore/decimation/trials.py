"""The schedule of a decimation: its stages, and several trials of the coarse levels.

The coarse end of a decimation is chaotic. Any change of a rounding leads to other levels, whose
mismatch scatters by some per cent. From a small level on, several trials with perturbed errors are
therefore made (multi-start search), and the trial with the least deviation is kept.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.decimation.progress import Progress
from gamutcore.decimation.stage import Stage, compact_stage, copy_stage
from gamutcore.decimation.stages import EXACT_ERRORS, StageResult, run_stage

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.decimation.costs import Cost, Trials

__all__ = ["Segment", "perturbation", "progress_of", "run_schedule", "schedule"]

COARSEST = 4
"""Number of vertices of the last level."""

COARSE = 1800.0
"""Relative time of a collapse in coarse levels, where errors are evaluated by samples. With
``volume`` a collapse takes 95 times as long at 50 vertices as in fine levels, and a fiftieth of
that at 10,000. Only progress depends on this number."""

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
"""2⁶⁴ ÷ the golden ratio, the increment of SplitMix64."""


class Segment(NamedTuple):
    """Part of a schedule: one stage, or all trials of a stage, from one level to another."""

    vertices: int
    until: int
    trials: Trials | None

    @property
    def collapses(self) -> int:
        """Number of collapses, in all trials."""
        return (self.vertices - self.until) * (self.trials.number if self.trials else 1)

    def work(self, coarse: float) -> float:
        """Approximate work, in collapses of a fine level.

        A collapse at n vertices has `coarse` ÷ n^¾ additional work.
        """
        more = 4 * coarse * (self.vertices**0.25 - self.until**0.25)
        return self.collapses * (1 + more / max(self.vertices - self.until, 1))


def schedule(cost: Cost, size: int) -> list[Segment]:
    """Return the segments of a decimation from `size` vertices to four."""
    trials = cost.trials if cost.trials and cost.trials.until < size else None
    begin = min(trials.vertices, size) if trials else size
    stops = {*cost.compacted, begin, COARSEST}
    found: list[Segment] = []
    left = size
    while not found or left > COARSEST:
        if trials and left == begin:
            found.append(Segment(left, trials.until, trials))
        else:
            found.append(Segment(left, max((s for s in stops if s < left), default=left), None))
        left = found[-1].until
    return found


def progress_of(cost: Cost, size: int) -> Progress:
    """Return the progress of a decimation that has not begun."""
    coarse = COARSE if cost.trials else 0.0
    return Progress([(segment.collapses, segment.work(coarse)) for segment in schedule(cost, size)])


def run_schedule(stage: Stage, cost: Cost, progress: Progress) -> list[StageResult]:
    """Decimate a full boundary to four faces, and return the results of all stages.

    The stage is changed. The last result has more than four vertices left if no edge can be
    collapsed validly.
    """
    results: list[StageResult] = []
    for segment in schedule(cost, stage.size):
        if results:
            stage = compact_stage(results[-1].stage)
            # the state of a large boundary takes much memory, and the new stage has its own
            old = results[-1].stage
            small = old._replace(quadrics=stage.quadrics, deviation=stage.deviation)
            results[-1] = results[-1]._replace(stage=small)
        counter = progress.begin_part()
        if segment.trials is None:
            result = run_stage(stage, segment.until, counter, sweep=not results)
        else:
            result = _run_trials(stage, segment.trials, counter)
        results.append(result)
        if result.left != segment.until:
            break
    return results


def perturbation(edges: int, trial: int) -> FloatArray:
    """Perturbation of each edge in a trial: pseudorandom, uniform in [0, 1); empty for trial 0.

    SplitMix64 of the edge and the trial (Steele, Lea & Flood, "Fast Splittable Pseudorandom Number
    Generators", 2014).
    """
    if trial == 0:
        return EXACT_ERRORS
    bits = np.arange(edges, dtype=np.uint64) + np.full(1, trial << 32, np.uint64) + GOLDEN
    bits = (bits ^ (bits >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    bits ^= bits >> np.uint64(31)
    return (bits >> np.uint64(11)).astype(np.float64) * 2.0**-53


def _run_trials(stage: Stage, trials: Trials, counter: LongArray) -> StageResult:
    """Return the trial with the least deviation; one that ends too early counts as infinite."""
    results = []
    deviations = []
    for trial in range(trials.number):
        copy = copy_stage(stage)
        perturbed = perturbation(copy.surface.corner_facing.size, trial)
        results.append(run_stage(copy, trials.until, counter, perturbation=perturbed))
        complete = results[-1].left == trials.until
        deviations.append(copy.deviation.error.sum() if complete else np.inf)
    return results[int(np.argmin(deviations))]
