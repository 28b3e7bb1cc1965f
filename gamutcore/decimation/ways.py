"""The way down: from stage to stage, and from among several ways the one with the best levels.

The coarse end of a decimation is chaotic: whatever changes a rounding leads to other levels, whose
mismatch scatters by some per cent. So several ways are gone from a level that is small enough, with
errors that are disturbed a little, and the one whose levels deviate least is the history.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.decimation.record import empty_record
from gamutcore.decimation.stages import NOTHING_KNOWN, UNDISTURBED, carried_out, compacted, copied
from gamutcore.decimation.watching import Course

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.decimation.plan import Fork, Plan
    from gamutcore.decimation.record import Record
    from gamutcore.decimation.stages import Passage, Stage

__all__ = ["Leg", "course_of", "legs", "way_down"]

DISTURBANCE = 0.1
"""By what part of themselves errors are disturbed at most. From 0.03 to 0.3 what is found among as
many ways is the same within the scatter (docs/decisions/ways.md)."""

COARSEST = 4
"""Vertices of the last level."""

COARSE = 1800.0
"""How much longer a collapse takes in coarse levels, where errors are those of samples: of `volume`
95 times as long with 50 vertices, a fiftieth of that with 10,000. Only progress depends on it."""


class Leg(NamedTuple):
    """A part of the way down.

    Attributes
    ----------
    vertices : int
        Where it begins.
    until : int
        Where it ends.
    fork : Fork or None
        If there are several ways.
    """

    vertices: int
    until: int
    fork: Fork | None

    @property
    def collapses(self) -> int:
        """How many there are, on all ways."""
        return (self.vertices - self.until) * (self.fork.ways if self.fork else 1)

    def work(self, coarse: float) -> float:
        """Return about how much there is to do, in collapses of a fine level.

        Parameters
        ----------
        coarse : float
            How much more coarse levels take: n^¾ times that of a level of n vertices.
        """
        more = 4 * coarse * (self.vertices**0.25 - self.until**0.25)
        return self.collapses * (1 + more / max(self.vertices - self.until, 1))


def legs(plan: Plan, size: int) -> list[Leg]:
    """Return the parts of the way down from so many vertices to four.

    Parameters
    ----------
    plan : Plan
        Of the cost.
    size : int
    """
    forks = {min(fork.vertices, size): fork for fork in plan.forks if fork.compared[-1] < size}
    stops = {*(count for count in plan.compacted if count < size), *forks}
    found: list[Leg] = []
    left = size
    while not found or left > COARSEST:
        fork = forks.get(left)
        if fork is None:
            until = max((stop for stop in stops if stop < left), default=COARSEST)
        else:
            until = fork.compared[-1]
        found.append(Leg(left, until, fork))
        left = until
    return found


def course_of(plan: Plan, size: int) -> Course:
    """Return what tells how far a way down is.

    Parameters
    ----------
    plan, size
        As for `legs`.
    """
    coarse = COARSE if plan.forks else 0.0
    return Course([(leg.collapses, leg.work(coarse)) for leg in legs(plan, size)])


def way_down(stage: Stage, plan: Plan, record: Record, course: Course) -> list[Passage]:
    """Decimate a surface to four faces, in the stages of a plan.

    Parameters
    ----------
    stage : Stage
        The full boundary; changed.
    plan : Plan
        Of the cost.
    record : Record
        Empty, with room for all collapses: lent to the first stage.
    course : Course
        `course_of` the plan: told how many collapses have been made.

    Returns
    -------
    list of Passage
        Of the last one more than four vertices are left if no edge could be collapsed validly.
    """
    passages: list[Passage] = []
    for leg in legs(plan, len(stage.delivered)):
        if passages:
            stage = compacted(passages[-1].stage, plan)
            # what is left of the cost is in the new stage; of a large boundary it is a lot
            passages[-1] = passages[-1]._replace(stage=passages[-1].stage._replace(state=None))
        done = course.next_part()
        if leg.fork is None:
            room = empty_record(len(stage.delivered)) if passages else record
            passages.append(carried_out(stage, leg.until, room, done, sweeping=not passages))
        else:
            passages += _best_way(stage, plan, leg.fork, done)
        if passages[-1].left != leg.until:
            break
    return passages


def _best_way(stage: Stage, plan: Plan, fork: Fork, done: LongArray) -> list[Passage]:
    """Go several ways and return the one whose levels deviate least, by the mean of logarithms."""
    # all ways begin with the same errors, which differ by how they are disturbed only
    known = np.full(len(stage.surface.corner_facing), np.nan)
    best = _way(stage, plan, fork, UNDISTURBED, known, done)
    for number in range(1, fork.ways):
        other = _way(stage, plan, fork, (number, DISTURBANCE), known, done)
        if other[0] < best[0]:
            best = other
    return best[1]


def _way(
    stage: Stage,
    plan: Plan,
    fork: Fork,
    way: tuple[int, float],
    known: FloatArray,
    done: LongArray,
) -> tuple[float, list[Passage]]:
    """Go one way; with how much its levels deviate, infinitely if it does not reach the last."""
    passages: list[Passage] = []
    deviations = []
    at = copied(stage)
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
