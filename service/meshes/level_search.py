"""Levels that keep limits to their error: found once, remembered for each gamut.

What the error curve cannot tell is found by comparing levels with the full boundary, which takes
up to a second (several, of more than a million triangles) and is work for a thread. One such search
is under way at a time, however many are asked for, so that the other threads and cores are there
for other requests; what it finds helps the searches after it. Everything here belongs to the event
loop's thread.
"""

from __future__ import annotations

import asyncio
from math import inf
from typing import TYPE_CHECKING, Any

from gamutcore.metric.level_search import LevelSearch
from service.caching.byte_bounded_cache import ByteBoundedCache
from service.caching.single_flight import SingleFlight
from service.telemetry.server_timing import timed

if TYPE_CHECKING:
    from gamutcore.metric.level_search import BoundedLevel, Bounds
    from service.meshes.library import Library, OpenGamut
    from service.storage.records import Record

__all__ = ["Choices"]

_CAPACITY = 16 * 1024 * 1024
"""Bytes for comparisons that were made: tens of thousands. They outlive the gamuts' histories in
memory, which are a hundred times as large."""

_LEVELS_CAPACITY = 16 * 1024 * 1024
"""Bytes for the levels of limits that were asked for."""

_LEVEL_BYTES = 500
"""Rough cost of one of these: key, bounds, bookkeeping."""


class Choices:
    """Which levels of a library's gamuts keep limits.

    Parameters
    ----------
    library : Library
        Where the gamuts are.
    """

    def __init__(self, library: Library) -> None:
        self._library = library
        self._kept: ByteBoundedCache[str, LevelSearch] = ByteBoundedCache(_CAPACITY)
        self._levels: ByteBoundedCache[tuple[str, Bounds], BoundedLevel] = ByteBoundedCache(
            _LEVELS_CAPACITY
        )
        self._finding: SingleFlight[tuple[str, Bounds], BoundedLevel] = SingleFlight()
        self._turn = asyncio.Semaphore(1)
        self._searches = 0

    @property
    def caches(self) -> dict[str, ByteBoundedCache[Any, Any]]:
        """What is remembered, by name: of gamuts what was compared, of limits their levels."""
        return {"comparisons": self._kept, "limits": self._levels}

    @property
    def searches(self) -> int:
        """How many searches are under way: one, and those that wait for their turn."""
        return self._searches

    def known(self, gamut_id: str, limits: Bounds) -> BoundedLevel | None:
        """Return the level that `found` returns, if that is known already."""
        level = self._levels.get((gamut_id, limits))
        if level is not None:
            return level
        choice = self._kept.get(gamut_id)
        level = None if choice is None else choice.find_known(limits)
        if level is not None:
            # the way to it takes as long as half of a repeated request
            self._levels.put((gamut_id, limits), level, _LEVEL_BYTES)
        return level

    def at_most(self, record: Record, limits: Bounds) -> int:
        """Return how many triangles the level that `found` returns has at most, without a search.

        Those of the level itself if it is known, else of the smallest one whose described bounds
        keep the limits: what a search finds is never larger.
        """
        level = self.known(record.id, limits)
        return _promised_triangles(record, limits) if level is None else level.triangles

    async def found(self, opened: OpenGamut, limits: Bounds) -> BoundedLevel:
        """Return the smallest level of a gamut that is found to keep limits, and its bounds.

        Raises
        ------
        GamutDamagedError
            If what the file holds turns out to be damaged.
        """
        name = opened.record.id
        choice = self._kept.get(name)
        if choice is None:
            choice = LevelSearch(opened.gamut.history.triangles, opened.gamut.description["levels"])
            # of a gamut that was deleted meanwhile nothing is kept
            if self._library.opened(name) is opened:
                self._kept.put(name, choice, choice.nbytes)
        known = choice.find_known(limits)
        if known is not None:
            return known
        return await self._finding.value((name, limits), lambda: self._find(opened, choice, limits))

    def discard(self, gamut_id: str) -> None:
        """Forget what is known of a gamut that was deleted."""
        self._kept.discard(gamut_id)
        self._levels.discard_where(lambda key: key[0] == gamut_id)

    async def _find(self, opened: OpenGamut, choice: LevelSearch, limits: Bounds) -> BoundedLevel:
        self._searches += 1
        try:
            return await self._find_in_turn(opened, choice, limits)
        finally:
            self._searches -= 1

    async def _find_in_turn(
        self, opened: OpenGamut, choice: LevelSearch, limits: Bounds
    ) -> BoundedLevel:
        with timed("wait"):
            await self._turn.acquire()
        try:
            # by those before it, perhaps
            level = choice.find_known(limits)
            if level is None:
                history = opened.gamut.history
                await self._library.unpack(opened, history.triangles)
                with timed("choose"):
                    level = await self._library.in_thread(choice.find, history, limits)
        finally:
            self._turn.release()
        self._kept.resize(opened.record.id, choice, choice.nbytes)
        return level


def _promised_triangles(record: Record, limits: Bounds) -> int:
    largest: int = record.description["counts"]["triangles"]
    if min(limits) <= 0.0:
        return largest  # as in the search: only the full boundary is without any error
    keeping = (
        level["triangles"]
        for level in record.description["levels"]
        if level.get("distance_bound", inf) <= limits.distance
        and level.get("mismatch_bound", inf) <= limits.mismatch
    )
    return min(keeping, default=largest)
