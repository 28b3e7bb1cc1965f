"""Level search: from a requested triangle count or error limit to a level of a gamut.

The error curve answers some limits. All others need comparisons of levels with the full boundary,
which take up to a second (several for more than a million triangles) and run in a thread. Only one
search runs at a time, so that other requests keep the other threads and cores. Results are kept
per gamut. Everything here belongs to the event loop's thread.
"""

from __future__ import annotations

import asyncio
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

from gamutcore.history import MINIMUM_TRIANGLES
from gamutcore.metric.level_search import Bounds, LevelSearch
from service.caching.byte_bounded_cache import ByteBoundedCache
from service.caching.single_flight import SingleFlight
from service.telemetry.server_timing import timed

if TYPE_CHECKING:
    from gamutcore.metric.level_search import BoundedLevel
    from service.meshes.library import Library, OpenGamut
    from service.storage.records import Record

__all__ = ["DEFAULT_TRIANGLES", "LevelRequest", "LevelSearches"]

DEFAULT_TRIANGLES = 1000
"""Triangle count if the request has neither a count nor a limit: 23 kB as GLB, and smooth."""

_CAPACITY = 16 * 1024 * 1024
"""Bytes for comparisons, enough for tens of thousands. They stay when the histories, which are a
hundred times as large, leave the memory."""

_LEVELS_CAPACITY = 16 * 1024 * 1024
"""Bytes for the levels of requested limits."""

_LEVEL_BYTES = 500
"""Approximate memory of one level: key, bounds, bookkeeping."""


class LevelRequest(NamedTuple):
    """The level that a client asks for; the default level if nothing is given.

    Attributes
    ----------
    triangles : int or None
        Largest triangle count.
    max_error : float or None
        Largest distance from the full boundary, in the space's unit.
    max_mismatch : float or None
        Largest mismatch.
    """

    triangles: int | None = None
    max_error: float | None = None
    max_mismatch: float | None = None

    @property
    def limits(self) -> Bounds | None:
        """The error limits; None if there are none."""
        if self.max_error is None and self.max_mismatch is None:
            return None
        return Bounds(
            inf if self.max_error is None else self.max_error,
            inf if self.max_mismatch is None else self.max_mismatch,
        )

    def count(self, largest: int) -> int:
        """Return the requested triangle count for a gamut with `largest` triangles."""
        return min(DEFAULT_TRIANGLES, largest) if self.triangles is None else self.triangles


class LevelSearches:
    """The levels of a library's gamuts that meet requests.

    Parameters
    ----------
    library : Library
        The open gamuts.

    Attributes
    ----------
    running : int
        Number of searches under way: one that runs, and those that wait for it.
    """

    def __init__(self, library: Library) -> None:
        self._library = library
        self._searches: ByteBoundedCache[str, LevelSearch] = ByteBoundedCache(_CAPACITY)
        self._levels: ByteBoundedCache[tuple[str, Bounds], BoundedLevel] = ByteBoundedCache(
            _LEVELS_CAPACITY
        )
        self._finding: SingleFlight[tuple[str, Bounds], BoundedLevel] = SingleFlight()
        self._turn = asyncio.Semaphore(1)
        self.running = 0

    @property
    def caches(self) -> dict[str, ByteBoundedCache[Any, Any]]:
        """The caches by name: comparisons by gamut, levels by limits."""
        return {"comparisons": self._searches, "limits": self._levels}

    def find_known(
        self, gamut_id: str, request: LevelRequest, opened: OpenGamut | None
    ) -> tuple[int, Bounds | None] | None:
        """Return the triangle count and the bounds of a level without a search.

        Parameters
        ----------
        gamut_id : str
            The gamut.
        request : LevelRequest
            The level.
        opened : OpenGamut or None
            The gamut if it is open.

        Returns
        -------
        tuple or None
            Bounds are given for limits only. None if the level is not known or does not exist.
        """
        limits = request.limits
        if limits is not None:
            level = self._known(gamut_id, limits)
            return None if level is None else (level.triangles, level.bounds)
        if opened is None:
            # An odd count may exceed the full boundary, which only the open gamut can tell.
            count = request.triangles
            return None if count is None or count % 2 else (count, None)
        largest = opened.gamut.history.triangles
        count = request.count(largest)
        # Closed meshes have even counts: an odd count names the level below it.
        return (count - count % 2, None) if MINIMUM_TRIANGLES <= count <= largest else None

    async def find(self, opened: OpenGamut, request: LevelRequest) -> tuple[int, Bounds | None]:
        """Return the triangle count of a level, and its bounds if the request has limits.

        Raises
        ------
        TriangleCountError
            The gamut has no such level.
        GamutDamagedError
            The history file is damaged.
        """
        name, limits, history = opened.record.id, request.limits, opened.gamut.history
        if limits is None:
            count = request.count(history.triangles)
            if not MINIMUM_TRIANGLES <= count <= history.triangles:
                history.level(count)  # raises the error with the gamut's range
            return count - count % 2, None
        search = self._searches.get(name)
        if search is None:
            search = LevelSearch(history.triangles, opened.gamut.description["levels"])
            # Nothing is kept of a gamut that was deleted meanwhile.
            if self._library.find_open(name) is opened:
                self._searches.put(name, search, search.nbytes)
        level = search.find_known(limits)
        if level is None:
            level = await self._finding.value(
                (name, limits), lambda: self._search(opened, search, limits)
            )
        return level.triangles, level.bounds

    def triangle_bound(self, record: Record, request: LevelRequest) -> int:
        """Return an upper bound of the triangle count that `find` returns, without a search.

        A requested count is returned as it is, whether or not there is such a level. For limits, a
        search never returns more than the smallest described level that meets them.
        """
        limits = request.limits
        largest: int = record.description["counts"]["triangles"]
        if limits is None:
            return request.count(largest)
        known = self._known(record.id, limits)
        if known is not None:
            return known.triangles
        if min(limits) <= 0.0:
            return largest  # only the full boundary has no error
        return min(
            (
                level["triangles"]
                for level in record.description["levels"]
                if level.get("distance_bound", inf) <= limits.distance
                and level.get("mismatch_bound", inf) <= limits.mismatch
            ),
            default=largest,
        )

    def discard(self, gamut_id: str) -> None:
        """Forget the levels of a deleted gamut."""
        self._searches.discard(gamut_id)
        self._levels.discard_where(lambda key: key[0] == gamut_id)

    def _known(self, gamut_id: str, limits: Bounds) -> BoundedLevel | None:
        level = self._levels.get((gamut_id, limits))
        if level is not None:
            return level
        search = self._searches.get(gamut_id)
        level = None if search is None else search.find_known(limits)
        if level is not None:
            # Finding it again would take half of the time of a repeated request.
            self._levels.put((gamut_id, limits), level, _LEVEL_BYTES)
        return level

    async def _search(self, opened: OpenGamut, search: LevelSearch, limits: Bounds) -> BoundedLevel:
        self.running += 1
        try:
            with timed("wait"):
                await self._turn.acquire()
            try:
                # The searches before this one may have found it.
                level = search.find_known(limits)
                if level is None:
                    level = await self._find_in_history(opened, search, limits)
            finally:
                self._turn.release()
        finally:
            self.running -= 1
        self._searches.resize(opened.record.id, search, search.nbytes)
        return level

    async def _find_in_history(
        self, opened: OpenGamut, search: LevelSearch, limits: Bounds
    ) -> BoundedLevel:
        history = opened.gamut.history
        await self._library.unpack(opened, history.triangles)
        with timed("choose"):
            return await self._library.in_thread(search.find, history, limits)
