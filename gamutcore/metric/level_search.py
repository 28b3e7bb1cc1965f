"""Search for the smallest level of a history whose error is within limits.

The error curve of a description covers about twenty levels, few of them fine, with bounds up to
38 % too large. Where the curve cannot decide, a level is compared with the full boundary, and the
result is remembered. The order of the comparisons depends only on the triangle counts and on which
levels are within the limits. Tighter limits therefore never give fewer triangles, and earlier
requests never change an answer. See ``docs/decisions/error-curve.md``.
"""

from __future__ import annotations

from math import inf, isqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.history import MINIMUM_TRIANGLES
from gamutcore.metric.distance_bound import halving_limit
from gamutcore.metric.error_curve import round_up, surface_in_preorder
from gamutcore.metric.radial_overlay import compare_surfaces, enclosed_volume

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from gamutcore.history import History

__all__ = ["NO_ERROR", "BoundedLevel", "Bounds", "FullBoundary", "LevelSearch"]

EVEN_UP_TO = 32
"""All levels up to this triangle count are tried, from the coarsest."""

DENSE = 2.0**0.25
"""Ratio of the following counts, which are tried beside those of the curve. The largest distance of
a coarse level is often half as much again as that of a coarser level, so larger ratios would miss
levels with half of the triangles."""

DENSE_UP_TO = 4000
"""Largest of these counts. Distances of finer levels hardly rise with the count, and finer levels
take longer to compare."""

CURVE_EXCESS = 2.0
"""A level is rejected without a comparison if its bound in the curve exceeds a limit this many
times. Distances in the curve are up to 38 % too large; counts between those of the curve use the
next finer count."""

RESOLUTION = 128
"""The search ends when at most triangle count ÷ this number can still be saved."""

CROSSINGS = 10
"""A comparison of F with n triangles takes about as long as F + 10 √(F n) triangles at 57 ns each
(measured), because edges cross faces."""

WORK = 9_000_000
"""Work that the second part of a search may take for any gamut, in triangles."""

WORK_PER_TRIANGLE = 20
"""Additional work per triangle of the full boundary. Both take 0.7 s of one core for 175,000
triangles, and 4 s for 2.5 million. Among the finest levels, up to 2 % and 30 % of the triangles
could still be saved then. Work is counted, not timed, so that answers do not depend on the
machine."""

HALVINGS = 100_000.0
"""Halvings of a comparison in addition to a quarter of the faces. Levels of ellipsoids 60 times as
wide as high take up to 53,000 (0.1 s); 600 times as wide, up to 130,000 (0.6 s)."""

ENTRY_BYTES = 300
"""Approximate memory per remembered level."""


class Bounds(NamedTuple):
    """Upper bounds of the error of a level, or limits for it.

    Attributes
    ----------
    distance : float
        Distance of any point of either surface from the other (units of the space).
    mismatch : float
        Volume of the symmetric difference ÷ volume of the full boundary.
    """

    distance: float = inf
    mismatch: float = inf

    def within(self, limits: Bounds, times: float = 1.0) -> bool:
        """Whether both bounds are at most the limits multiplied by `times`."""
        return self.distance <= times * limits.distance and self.mismatch <= times * limits.mismatch

    def smaller(self, other: Bounds) -> Bounds:
        """Return the smaller bound of each kind."""
        return Bounds(min(self.distance, other.distance), min(self.mismatch, other.mismatch))


NO_ERROR = Bounds(0.0, 0.0)
"""Bounds of the full boundary."""

UNKNOWN = Bounds()
"""Bounds of a level that nothing is known of."""


class BoundedLevel(NamedTuple):
    """A level and the bounds of its error.

    Attributes
    ----------
    triangles : int
    bounds : Bounds
        Bounds of this level only; a finer level may have larger errors.
    """

    triangles: int
    bounds: Bounds


class FullBoundary:
    """The full boundary of a history, prepared for comparisons with levels.

    Parameters
    ----------
    history : History
        All of it is unpacked. The surface takes 36 bytes per triangle; comparisons with fine levels
        take more.
    """

    def __init__(self, history: History) -> None:
        self._history = history
        self._surface, self._near = surface_in_preorder(history.full(), history)
        self._order = np.arange(len(self._near), dtype=np.int32)
        self._volume = enclosed_volume(self._surface)

    def bounds(self, triangles: int) -> Bounds:
        """Compare a level with the full boundary.

        Parameters
        ----------
        triangles : int
            Triangle count of a level.

        Returns
        -------
        Bounds
            Rounded up as in a description. The mismatch is otherwise exact. The distance is mostly
            within 3 %; for flat bodies it can be half as much again
            (`gamutcore.metric.distance_bound`).
        """
        level, _ = surface_in_preorder(self._history.level(triangles), self._history)
        halvings = halving_limit(self._surface, HALVINGS)
        found, _ = compare_surfaces(
            self._surface, level, self._order, self._near, halvings=halvings
        )
        furthest = max(found.from_reference.maximum, found.to_reference.maximum)
        return Bounds(round_up(furthest), round_up(found.difference / self._volume))


class LevelSearch:
    """Search for levels within limits, by the error curve and by remembered comparisons.

    One thread may search while another calls `find_known`.

    Parameters
    ----------
    triangles : int
        Triangle count of the full boundary.
    levels : iterable of mapping
        Errors from a description (`LevelError.to_mapping`). Levels without bounds, and counts that
        the history does not have, are ignored.
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
        self._curve = {count: _own_bounds(level) for count, level in curve.items()}
        # for each count to try, the bounds of that count or of the next finer count in the curve
        self._tried: dict[int, Bounds] = {}
        finer = NO_ERROR
        for count in sorted(_dense_counts(triangles) | curve.keys(), reverse=True):
            if count in curve:
                # mismatch of this level only: its bound holds for finer levels as well
                own = self._curve[count]
                finer = own._replace(mismatch=curve[count].get("mismatch", own.mismatch))
            self._tried[count] = finer
        self._tried = dict(sorted(self._tried.items()))
        self._compared: dict[int, Bounds] = {}

    @property
    def nbytes(self) -> int:
        """Approximate memory in bytes."""
        return ENTRY_BYTES * (len(self._tried) + len(self._compared))

    def find_known(self, limits: Bounds) -> BoundedLevel | None:
        """Return the result of `find` if it needs no further comparison, else None."""
        level = self._search(limits)
        return level if isinstance(level, BoundedLevel) else None

    def find(self, history: History, limits: Bounds) -> BoundedLevel:
        """Return the smallest level whose error is found to be within limits.

        Parameters
        ----------
        history : History
            The history of the triangle count and error curve given before.
        limits : Bounds
            Upper limits of the bounds of the level.

        Returns
        -------
        BoundedLevel
            The full boundary if no other level is within the limits, as for limits of zero. Tighter
            limits never give fewer triangles.

        Raises
        ------
        HistoryFileError
            If the file of the history is damaged.
        """
        level = self._search(limits)
        full = None
        while not isinstance(level, BoundedLevel):
            full = FullBoundary(history) if full is None else full
            self._compared[level] = full.bounds(level)
            level = self._search(limits)
        return level

    def _search(self, limits: Bounds) -> BoundedLevel | int:
        """Return the result, or the triangle count of the next level to compare.

        The first part tries a fixed sequence of counts. A count within some limits is within
        looser limits too, so tighter limits never end at a smaller count. The second part bisects
        the gap below that count; `_middle` makes the counts a fixed tree. Two limits share their
        path in the tree until the looser limit turns to fewer triangles. Work is charged for every
        count on the path, whether it was compared before or not; otherwise a tighter limit could
        end earlier than a looser one.
        """
        chosen = BoundedLevel(self._full, NO_ERROR)
        if min(limits) <= 0.0:
            return chosen
        lower, work = MINIMUM_TRIANGLES - 2, 0
        for count, expected in self._tried.items():
            bounds = self._deciding_bounds(count, expected, limits)
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

    def _deciding_bounds(self, count: int, expected: Bounds, limits: Bounds) -> Bounds | None:
        """Return bounds that decide about a level; None if the level must be compared."""
        promised = self._curve.get(count, UNKNOWN)
        if promised.within(limits):
            return promised
        if not expected.within(limits, CURVE_EXCESS):
            return expected
        compared = self._compared.get(count)
        return None if compared is None else compared.smaller(promised)


def _own_bounds(level: Mapping[str, Any]) -> Bounds:
    """Return the bounds of a described level; the distance is that of this level only."""
    own = (level[side]["maximum"] for side in ("from_full", "to_full") if side in level)
    return Bounds(max(own, default=level["distance_bound"]), level["mismatch_bound"])


def _dense_counts(full: int) -> set[int]:
    """Return the counts that are tried for any curve."""
    counts = set(range(MINIMUM_TRIANGLES, min(EVEN_UP_TO + 1, full), 2))
    count = EVEN_UP_TO * DENSE
    while count < min(full, DENSE_UP_TO + 1):
        counts.add(int(count) // 2 * 2)
        count *= DENSE
    return counts


def _middle(lower: int, upper: int) -> int:
    """Return an even count near the geometric mean of two; the upper one if they are close."""
    if upper - lower <= max(2, upper // RESOLUTION):
        return upper
    return max(lower + 2, isqrt(lower * upper) // 2 * 2)
