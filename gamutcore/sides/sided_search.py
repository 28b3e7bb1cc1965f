"""Errors of levels on one side, and the smallest of them within limits.

The levels have fixed triangle counts. Each is computed when a limit first needs it, from coarse to
fine, and the answer is the first that keeps the limit. A looser limit therefore never has more
triangles. No answer promises what a smaller answer promises as well. Both hold in whatever order
limits are asked for.
"""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import TYPE_CHECKING

from gamutcore.errors import TriangleCountError
from gamutcore.metric.error_curve import LevelError, round_up
from gamutcore.metric.level_search import NO_ERROR, BoundedLevel, Bounds
from gamutcore.metric.radial_overlay import Distances, compare_surfaces, enclosed_volume
from gamutcore.sides.sided_level import SidedLevels

if TYPE_CHECKING:
    from gamutcore.history import History
    from gamutcore.sides.sided_level import Side

__all__ = ["SidedSearch", "sided_counts"]

EVEN_UP_TO = 16
"""All levels up to this triangle count are in the curve."""

DENSE, DENSE_UP_TO = 2.0**0.5, 2048
"""Ratio and largest of the following counts; 15 to 150 ms each for 130,000 triangles."""

SPARSE, SPARSE_UP_TO = 2.0, 8192
"""Ratio and largest of the last counts. The finest takes half a second."""

ROW_BYTES = 1000
"""Approximate memory per level of the curve."""


def sided_counts(full: int) -> list[int]:
    """Return the triangle counts of the error curve of one side, even and ascending.

    The curve does not contain the full boundary, whose count is `full`.
    """
    counts = list(range(4, min(EVEN_UP_TO, full), 2))
    count = float(EVEN_UP_TO)
    while count < min(full, SPARSE_UP_TO + 1):
        counts.append(round(count) // 2 * 2)
        count *= DENSE if count < DENSE_UP_TO - 1 else SPARSE
    return counts


class SidedSearch:
    """Error curve of the levels on one side, computed as far as it is needed.

    Several threads may use it at the same time.

    Parameters
    ----------
    triangles : int
        Triangle count of the full boundary.
    side : {'inside', 'outside'}
    """

    def __init__(self, triangles: int, side: Side) -> None:
        self._full = triangles
        self._side = side
        self._counts = sided_counts(triangles)
        self._next = 0
        self._errors: list[LevelError] = []
        self._curve: list[LevelError] | None = None
        self._lock = threading.Lock()

    @property
    def nbytes(self) -> int:
        """Approximate memory in bytes of the whole curve."""
        return ROW_BYTES * (1 + len(self._counts))

    @property
    def known_curve(self) -> list[LevelError] | None:
        """The result of `curve` if it was computed, else None."""
        return self._curve

    def find_known(self, limits: Bounds) -> BoundedLevel | None:
        """Return the result of `find` if it needs no further level, else None."""
        whole = self._next == len(self._counts)
        if min(limits) > 0.0:
            for error in self._errors:
                bounds = _bounds(error)
                if bounds.within(limits):
                    return BoundedLevel(error.triangles, bounds)
            if not whole:
                return None
        return BoundedLevel(self._full, NO_ERROR)

    def find(self, history: History, limits: Bounds) -> BoundedLevel:
        """Return the smallest level of the curve that keeps limits.

        Parameters
        ----------
        history : History
            The history of the triangle count given before.
        limits : Bounds
            Upper limits of the bounds of the level.

        Returns
        -------
        BoundedLevel
            The full boundary if no level is within the limits, as for limits of zero.

        Raises
        ------
        HistoryFileError
            If the file of the history is damaged.
        """
        with self._lock:
            level = self.find_known(limits)
            if level is not None:
                return level
            levels = SidedLevels(history, self._side)
            while level is None:
                self._compare_next(levels)
                level = self.find_known(limits)
            return level

    def curve(self, history: History) -> list[LevelError]:
        """Return the errors of all levels of the curve and of the full boundary.

        Parameters
        ----------
        history : History
            As for `find`.

        Returns
        -------
        list of LevelError
            By ascending triangle count. Bounds hold for a level and all finer levels of the curve.
        """
        with self._lock:
            if self._curve is None:
                levels = SidedLevels(history, self._side)
                while self._next < len(self._counts):
                    self._compare_next(levels)
                self._curve = self._whole_curve(enclosed_volume(levels.full))
            return self._curve

    def _compare_next(self, levels: SidedLevels) -> None:
        """Compute the error of the next level."""
        error = _level_error(levels, self._counts[self._next])
        # Levels of bodies that are too thin for float32 may be missing or repeated.
        known = self._errors[-1].triangles if self._errors else 0
        if error is not None and error.triangles > known:
            self._errors.append(error)
        self._next += 1

    def _whole_curve(self, volume: float) -> list[LevelError]:
        """Return the errors with bounds for all finer levels, and the full boundary."""
        none = Distances(0.0, 0.0)
        curve = [LevelError(self._full, volume, 0.0, 0.0, 0.0, none, none)]
        for error in reversed(self._errors):
            finer = curve[-1]
            curve.append(
                replace(
                    error,
                    mismatch_bound=max(error.mismatch_bound, finer.mismatch_bound),
                    distance_bound=max(error.distance_bound, finer.distance_bound),
                )
            )
        return curve[::-1]


def _level_error(levels: SidedLevels, triangles: int) -> LevelError | None:
    """Return the error of a level, with bounds for this level only; None if there is no level."""
    try:
        level = levels.level(triangles)
    except TriangleCountError:
        return None
    found, _ = compare_surfaces(levels.full, levels.surface(level), levels.order, levels.near)
    mismatch = found.mismatch
    return LevelError(
        triangles=level.triangles,
        volume=found.other_volume,
        mismatch=mismatch,
        mismatch_bound=mismatch,
        distance_bound=max(found.from_reference.maximum, found.to_reference.maximum),
        from_full=found.from_reference,
        to_full=found.to_reference,
    )


def _bounds(error: LevelError) -> Bounds:
    return Bounds(round_up(error.distance_bound), round_up(error.mismatch_bound))
