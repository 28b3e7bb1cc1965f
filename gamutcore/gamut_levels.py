"""The levels for queries: found by count or error, indexed once, and cached.

A level is chosen by its triangle count, or as the smallest within an error limit. Indexes and
device values of levels stay in a cache that is bounded in bytes.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, Any

from gamutcore.arguments import finite_number
from gamutcore.errors import OptionError
from gamutcore.levels import NO_ERROR, SIDES, Bounds, LevelSearch, Side, SidedSearch, error_bounds
from gamutcore.queries import LevelIndex, build_index

if TYPE_CHECKING:
    from gamutcore.geometry import DeviceValues
    from gamutcore.history import History

__all__ = ["CAPACITY", "GamutLevels", "IndexedLevel"]

CAPACITY = 128 * 1024 * 1024
"""Default size of a gamut's cache in bytes. The full boundary of 133,000 triangles needs about 30
MB, and 1,000 triangles need 0.2 MB."""


@dataclass(frozen=True)
class IndexedLevel:
    """A level that is ready for queries.

    Attributes
    ----------
    index : LevelIndex
    device : DeviceValues or None
        Device values of its vertices; None if the gamut was built from bare colours.
    max_error : float or None
        Upper bound of the distance between the level and the full boundary, in both directions, in
        units of the space. None if not known.
    """

    index: LevelIndex
    device: DeviceValues | None
    max_error: float | None

    @property
    def triangles(self) -> int:
        """Triangle count of the level."""
        return len(self.index.faces)

    @property
    def nbytes(self) -> int:
        """Memory in bytes."""
        return self.index.nbytes + (0 if self.device is None else self.device.values.nbytes)


class GamutLevels:
    """The levels of one gamut, from its history and description; threads may share it.

    Attributes
    ----------
    capacity : int
        Size of the cache in bytes. A larger level is indexed again for each query.
    nbytes : int
        Bytes of the cached levels.
    searches : dict
        Searches for levels within limits by side, with their computed tables.
    """

    def __init__(self, history: History, description: dict[str, Any]) -> None:
        self.capacity = CAPACITY
        self.nbytes = 0
        self._history = history
        self._description = description
        self.searches: dict[Side, LevelSearch | SidedSearch] = {}
        self._kept: OrderedDict[int, IndexedLevel] = OrderedDict()
        self._bounds: dict[int, float] = {}
        self._lock = threading.Lock()

    def find(
        self,
        triangles: int | None = None,
        max_error: float | None = None,
        max_mismatch: float | None = None,
        side: Side = "both",
    ) -> tuple[int, Bounds | None]:
        """Return the triangle count of a level, by its largest count or limits, and error bounds.

        The limits are those of `Gamut.mesh`. The bounds are None for a count outside the error
        curve. A count without a level raises TriangleCountError; a count with a limit, or a limit
        that is not a number of at least 0, raises OptionError.
        """
        if side not in SIDES:
            raise OptionError.refusal("side", side, f"one of {', '.join(SIDES)}")
        limits = Bounds(_limit("max_error", max_error), _limit("max_mismatch", max_mismatch))
        if triangles is not None:
            if limits != Bounds():
                raise OptionError.not_applicable(
                    "triangles", triangles, "a limit of the error is given", "Give one of them."
                )
            count = self._history.level_triangles(triangles)
            return count, self._known_bounds(count) if side == "both" else None
        found = self._search(side).find(self._history, limits)
        if side == "both":
            self._bounds[found.triangles] = found.bounds.distance
        return found.triangles, found.bounds

    def indexed(self, triangles: int | None = None, max_error: float | None = None) -> IndexedLevel:
        """Return a level that is ready for queries, by a count or a limit as for `find`."""
        count, bounds = self.find(triangles, max_error)
        with self._lock:
            level = self._kept.get(count)
            if level is not None:
                if level.max_error is None and bounds is not None:
                    level = self._kept[count] = replace(level, max_error=bounds.distance)
                self._kept.move_to_end(count)
                return level
        mesh = self._history.level(count)
        level = IndexedLevel(
            build_index(mesh.vertices, mesh.faces, self._history.centre),
            self._history.device_values(count),
            None if bounds is None else bounds.distance,
        )
        self._keep(count, level)
        return level

    def find_kept(self, triangles: int) -> IndexedLevel | None:
        """Return the level of an existing count if cached; else None."""
        with self._lock:
            return self._kept.get(triangles)

    def error_bound(self, triangles: int) -> float:
        """Return an upper bound of the distance between an existing level and the full boundary.

        It is in units of the space. The first call for a level outside the error curve compares the
        level with the full boundary, which takes up to 0.1 s.
        """
        known = self.find_error_bound(triangles)
        if known is None:
            known = error_bounds(self._history, [triangles])[0].bounds.distance
            self._bounds[triangles] = known
        return known

    def find_error_bound(self, triangles: int) -> float | None:
        """Return the result of `error_bound` if it needs no comparison; else None."""
        if triangles in self._bounds:
            return self._bounds[triangles]
        bounds = self._known_bounds(triangles)
        if bounds is not None:
            self._bounds[triangles] = bounds.distance
        return self._bounds.get(triangles)

    def _keep(self, count: int, level: IndexedLevel) -> None:
        with self._lock:
            if level.nbytes > self.capacity or count in self._kept:
                return
            self._kept[count] = level
            self.nbytes += level.nbytes
            while self.nbytes > self.capacity:
                _, evicted = self._kept.popitem(last=False)
                self.nbytes -= evicted.nbytes

    def _search(self, side: Side) -> LevelSearch | SidedSearch:
        if side not in self.searches:
            full = self._history.triangles
            self.searches[side] = (
                LevelSearch(self._description["levels"])
                if side == "both"
                else SidedSearch(full, side)
            )
        return self.searches[side]

    def _known_bounds(self, count: int) -> Bounds | None:
        if count == self._history.triangles:
            return NO_ERROR
        for row in self._description["levels"]:
            if row["triangles"] == count:
                return Bounds(row["distance_bound"], row["mismatch_bound"])
        return None


def _limit(name: str, value: object) -> float:
    if value is None:
        return inf
    number = finite_number(value)
    if number is None or number < 0.0:
        raise OptionError.refusal(name, value, "a number of at least 0")
    return number
