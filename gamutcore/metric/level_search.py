"""The smallest level that keeps limits to its error, found among all levels of a history.

The error curve of a description knows some twenty levels, few of them fine ones, and its bounds are
up to 38 % too large. Where it cannot tell, a level is compared with the full boundary itself, and
what was found is remembered. Which levels are looked at follows from the triangle counts and from
what keeps the limits, so asking for less error never gives fewer triangles, and what was asked
before changes no answer. See ``docs/decisions/error-curve.md``.
"""

from __future__ import annotations

from math import inf, isqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.history import MINIMUM_TRIANGLES
from gamutcore.metric.distance_bound import halvings_for
from gamutcore.metric.error_curve import arranged, round_up
from gamutcore.metric.radial_overlay import overlaid, volume_within

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from gamutcore.history import History

__all__ = ["NO_ERROR", "BoundedLevel", "Bounds", "FullBoundary", "LevelSearch"]

EVEN_UP_TO = 32
"""Up to here all levels are tried, beginning with the coarsest."""

DENSE = 2.0**0.25
"""Ratio of the counts that are tried then, besides those of the curve. The largest distance of a
coarse level is often a half more than that of a coarser one: what is tried at large steps misses
levels with half of the triangles."""

DENSE_UP_TO = 4000
"""Up to here. Distances of finer levels hardly rise with the count, and take longer to compare."""

CURVE_EXCESS = 2.0
"""Where the curve has more of a level than so many times a limit, it is taken not to keep it. Its
largest distances are up to 38 % too large, and its mismatches within 3 %; but the next finer level
that it has is looked at for those that it does not have."""

RESOLUTION = 128
"""The search ends when this part of the triangles is all that could still be saved."""

CROSSINGS = 10
"""Work of comparing F triangles with n is about that of F + 10 √(F n) triangles, measured: each
edge crosses so many faces. 57 ns each."""

WORK = 9_000_000
"""Work that a search between two levels of the curve may take whatever the gamut, and..."""

WORK_PER_TRIANGLE = 20
"""... for each triangle of the full boundary: together 0.7 s of one core for 175,000 triangles, 4 s
for 2.5 million. Of levels nearly as fine as these, up to 2 and 30 % of the triangles could still be
saved when the search ends. Work is counted, not timed, so that the same question has the same
answer everywhere."""

HALVINGS = 100_000.0
"""Pieces that a comparison may halve besides those of `halvings_for`: levels of ellipsoids 60 times
as wide as high take up to 53,000, a tenth of a second; 600 times as wide up to 130,000, 0.6 s."""

ENTRY_BYTES = 300
"""Memory that a level's remembered bounds take."""


class Bounds(NamedTuple):
    """How far at most a level is from the full boundary; or how far it may be.

    Attributes
    ----------
    distance : float
        Of any point of either surface from the other (units of the space).
    mismatch : float
        Volume of the symmetric difference ÷ volume of the full boundary.
    """

    distance: float = inf
    mismatch: float = inf

    def within(self, limits: Bounds, times: float = 1.0) -> bool:
        """Whether both are at most so many times the limits."""
        return self.distance <= times * limits.distance and self.mismatch <= times * limits.mismatch

    def smaller(self, other: Bounds) -> Bounds:
        """Return what holds if both hold."""
        return Bounds(min(self.distance, other.distance), min(self.mismatch, other.mismatch))


NO_ERROR = Bounds(0.0, 0.0)
"""What the full boundary promises."""

UNKNOWN = Bounds()
"""What nothing promises."""


class BoundedLevel(NamedTuple):
    """A level, and what it promises.

    Attributes
    ----------
    triangles : int
    bounds : Bounds
        Of this level alone: a finer one may be further away.
    """

    triangles: int
    bounds: Bounds


class FullBoundary:
    """The full boundary of a history, laid out to compare levels with.

    Parameters
    ----------
    history : History
        All of it is unpacked. 36 bytes are taken for each triangle, and more
        by comparisons with fine levels.
    """

    def __init__(self, history: History) -> None:
        self._history = history
        self._surface, self._near = arranged(history.full(), history)
        self._order = np.arange(len(self._near), dtype=np.int32)
        self._volume = volume_within(self._surface)

    def bounds(self, triangles: int) -> Bounds:
        """Compare a level with it.

        Parameters
        ----------
        triangles : int
            Of a level that the history has.

        Returns
        -------
        Bounds
            Rounded up as in a description. The mismatch is exact but for that; the distance is
            mostly within 3 %, of flat bodies now and then half as much again
            (`gamutcore.metric.distance_bound`).
        """
        level, _ = arranged(self._history.level(triangles), self._history)
        halvings = halvings_for(self._surface, HALVINGS)
        found, _ = overlaid(self._surface, level, self._order, self._near, halvings=halvings)
        furthest = max(found.from_reference.maximum, found.to_reference.maximum)
        return Bounds(round_up(furthest), round_up(found.difference / self._volume))


class LevelSearch:
    """Which level of a history keeps limits, by its curve and by comparisons that are remembered.

    One thread may find levels while another asks what is known.

    Parameters
    ----------
    triangles : int
        Of the full boundary.
    levels : iterable of mapping
        Described errors (`LevelError.to_mapping`). Those without bounds, and counts that the
        history does not have, are passed over.
    """

    def __init__(self, triangles: int, levels: Iterable[Mapping[str, Any]]) -> None:
        self._full = triangles
        curve = {
            int(level["triangles"]): level
            for level in levels
            if "distance_bound" in level
            and "mismatch_bound" in level
            and level["triangles"] in range(MINIMUM_TRIANGLES, triangles, 2)
        }
        self._curve = {count: _own(level) for count, level in curve.items()}
        # of each count that is tried, what the curve has of it, or of the next finer one there
        self._tried: dict[int, Bounds] = {}
        finer = NO_ERROR
        for count in sorted(_dense_counts(triangles) | curve.keys(), reverse=True):
            if count in curve:
                # that of this level: the bound of the mismatch is that of finer ones as well
                own = self._curve[count]
                finer = own._replace(mismatch=curve[count].get("mismatch", own.mismatch))
            self._tried[count] = finer
        self._tried = dict(sorted(self._tried.items()))
        self._compared: dict[int, Bounds] = {}

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes, roughly."""
        return ENTRY_BYTES * (len(self._tried) + len(self._compared))

    def find_known(self, limits: Bounds) -> BoundedLevel | None:
        """Return the level that `find` returns, if no comparison is needed for that any more."""
        level = self._reached(limits)
        return level if isinstance(level, BoundedLevel) else None

    def find(self, history: History, limits: Bounds) -> BoundedLevel:
        """Return the smallest level that is found to keep limits.

        Parameters
        ----------
        history : History
            The one that this is the choice of.
        limits : Bounds
            What the level's bounds are at most.

        Returns
        -------
        BoundedLevel
            The full boundary if there is no other, as for limits of zero. For smaller limits it
            never has fewer triangles.

        Raises
        ------
        HistoryFileError
            If what a file holds turns out to be damaged.
        """
        level = self._reached(limits)
        full = None
        while not isinstance(level, BoundedLevel):
            full = FullBoundary(history) if full is None else full
            self._compared[level] = full.bounds(level)
            level = self._reached(limits)
        return level

    def _reached(self, limits: Bounds) -> BoundedLevel | int:
        """Return the level that is found, or the next that has to be compared for that.

        The counts that are tried one after the other are always the same, and those that keep
        limits keep larger ones: for smaller limits the first of them has no fewer triangles.
        Between it and the one before, each count is the middle between the largest that failed and
        the smallest that kept the limits, as `_middle` has it. Which counts are on the way to
        another one does not depend on the limits either, so larger limits lead to the same count,
        or turn to smaller ones somewhere. For that to hold, a way must not end earlier because more
        comparisons were needed on it: all counts that it passes are work.
        """
        chosen = BoundedLevel(self._full, NO_ERROR)
        if min(limits) <= 0.0:
            return chosen
        lower, work = MINIMUM_TRIANGLES - 2, 0
        for count, expected in self._tried.items():
            bounds = self._telling(count, expected, limits)
            if bounds is None:
                return count
            if bounds.within(limits):
                chosen = BoundedLevel(count, bounds)
                break
            lower = count
        while (count := _middle(lower, chosen.triangles)) < chosen.triangles:
            work += self._full + CROSSINGS * isqrt(self._full * count)
            if work > WORK + WORK_PER_TRIANGLE * self._full:
                break
            bounds = self._compared.get(count)
            if bounds is None:
                return count
            if bounds.within(limits):
                chosen = BoundedLevel(count, bounds)
            else:
                lower = count
        return chosen

    def _telling(self, count: int, expected: Bounds, limits: Bounds) -> Bounds | None:
        """Return bounds by which a level keeps limits or does not; None if it must be compared."""
        promised = self._curve.get(count, UNKNOWN)
        if promised.within(limits):
            return promised
        if not expected.within(limits, CURVE_EXCESS):
            return expected
        compared = self._compared.get(count)
        return None if compared is None else compared.smaller(promised)


def _own(level: Mapping[str, Any]) -> Bounds:
    """Return the bounds of a described level; its distance is its own, not that of finer ones."""
    own = (level[side]["maximum"] for side in ("from_full", "to_full") if side in level)
    return Bounds(max(own, default=level["distance_bound"]), level["mismatch_bound"])


def _dense_counts(full: int) -> set[int]:
    """Return the counts that are tried whatever the curve has."""
    counts = set(range(MINIMUM_TRIANGLES, min(EVEN_UP_TO + 1, full), 2))
    count = EVEN_UP_TO * DENSE
    while count < min(full, DENSE_UP_TO + 1):
        counts.add(int(count) // 2 * 2)
        count *= DENSE
    return counts


def _middle(lower: int, upper: int) -> int:
    """Return the even count in the geometric middle of two; the upper one if they are close."""
    if upper - lower <= max(2, upper // RESOLUTION):
        return upper
    return max(lower + 2, isqrt(lower * upper) // 2 * 2)
