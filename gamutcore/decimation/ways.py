"""The way down: from stage to stage, and from among several ways the one with the best levels.

The coarse end of a decimation is chaotic: whatever changes a rounding leads to other levels, whose
mismatch scatters by some per cent. So several ways are gone from a level that is small enough, with
errors that are disturbed a little, and the one whose levels deviate least is the history.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.decimation.record import empty_record
from gamutcore.decimation.stages import NOTHING_KNOWN, UNDISTURBED, carried_out, compacted, copied

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.decimation.plan import Fork, Plan
    from gamutcore.decimation.record import Record
    from gamutcore.decimation.stages import Passage, Stage

__all__ = ["way_down"]

DISTURBANCE = 0.1
"""By what part of themselves errors are disturbed at most. From 0.03 to 0.3 what is found among as
many ways is the same within the scatter (docs/decisions/ways.md)."""

COARSEST = 4
"""Vertices of the last level."""


def way_down(stage: Stage, plan: Plan, record: Record, done: LongArray) -> list[Passage]:
    """Decimate a surface to four faces, in the stages of a plan.

    Parameters
    ----------
    stage : Stage
        The full boundary; changed.
    plan : Plan
        Of the cost.
    record : Record
        Empty, with room for all collapses: lent to the first stage.
    done : (1,) int64
        Written: how many collapses have been made.

    Returns
    -------
    list of Passage
        Of the last one more than four vertices are left if no edge could be collapsed validly.
    """
    size = len(stage.delivered)
    forks = {min(fork.vertices, size): fork for fork in plan.forks if fork.compared[-1] < size}
    stops = {*(count for count in plan.compacted if count < size), *forks}
    passages: list[Passage] = []
    left = size
    while not passages or left > COARSEST:
        fork = forks.get(left)
        if fork is None:
            until = max((stop for stop in stops if stop < left), default=COARSEST)
            room = empty_record(len(stage.delivered)) if passages else record
            passages.append(carried_out(stage, until, room, done, sweeping=not passages))
        else:
            until = fork.compared[-1]
            passages += _best_way(stage, plan, fork)
            done[0] = size - passages[-1].left
        left = passages[-1].left
        if left != until:
            break
        if left > COARSEST:
            stage = compacted(passages[-1].stage, plan)
    return passages


def _best_way(stage: Stage, plan: Plan, fork: Fork) -> list[Passage]:
    """Go several ways and return the one whose levels deviate least, by the mean of logarithms."""
    # all ways begin with the same errors, which differ by how they are disturbed only
    known = np.full(len(stage.surface.corner_facing), np.nan)
    best = _way(stage, plan, fork, UNDISTURBED, known)
    for number in range(1, fork.ways):
        other = _way(stage, plan, fork, (number, DISTURBANCE), known)
        if other[0] < best[0]:
            best = other
    return best[1]


def _way(
    stage: Stage, plan: Plan, fork: Fork, way: tuple[int, float], known: FloatArray
) -> tuple[float, list[Passage]]:
    """Go one way; with how much its levels deviate, infinitely if it does not reach the last."""
    passages: list[Passage] = []
    deviations = []
    at, done = copied(stage), np.zeros(1, np.int64)
    for until in (count for count in fork.compared if count < len(stage.delivered)):
        if passages:
            at, known = compacted(at, plan), NOTHING_KNOWN
        record = empty_record(len(at.delivered))
        passages.append(carried_out(at, until, record, done, way=way, known=known))
        if passages[-1].left != until:
            return np.inf, passages
        deviations.append(plan.deviation(at.state))
    # a product as long as it does not vanish: a level without any deviation beats all others
    return float(np.prod(deviations)), passages
