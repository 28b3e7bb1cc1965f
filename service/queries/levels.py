"""Levels that answer queries: found by count or error, and indexed before they answer.

A gamut keeps the indexes of its own levels up to a number of bytes. They count as memory of the
open gamut, so that the cache of open gamuts bounds the indexes of all. The memory of all levels of
a question, and of its answer, is charged at once.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, NamedTuple

from service.caching.single_flight import SingleFlight
from service.http.request_context import timed
from service.library import Cost

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from gamutcore.gamut import Gamut
    from gamutcore.levels import LevelRequest
    from service.library import Charge, Library, OpenGamut
    from service.meshes.requested_levels import RequestedLevels
    from service.storage.published import PublishedGamut

__all__ = ["QueryLevel", "QueryLevels"]


class QueryLevel(NamedTuple):
    """A level that is ready for queries: the gamut has it indexed.

    `max_error` is an upper bound of the distance from the full boundary, in units of the space. The
    gamut's `charge` keeps its memory charged as long as the level is in use.
    """

    gamut: Gamut
    triangles: int
    max_error: float
    charge: Charge

    @property
    def axes(self) -> tuple[str, str, str]:
        """Names of the coordinates."""
        return self.gamut.colour_space.axes


class QueryLevels:
    """The levels of a library that answer queries. Belongs to the event loop's thread."""

    def __init__(self, library: Library, requested: RequestedLevels) -> None:
        self._library = library
        self._requested = requested
        # Levels by the number of requests that make them, or wait for the one that does.
        self._made: Counter[tuple[str, LevelRequest]] = Counter()
        self._indexing: SingleFlight[tuple[str, int], QueryLevel] = SingleFlight()

    def find_ready(self, opened: OpenGamut, request: LevelRequest) -> QueryLevel | None:
        """Return a level without waiting; None if it is not in memory."""
        gamut = opened.gamut
        known = gamut.search.find_known(request)
        if known is None or not gamut.levels.has(known.triangles):
            return None
        max_error = gamut.search.find_error_bound(known.triangles)
        if max_error is None:
            return None
        return QueryLevel(gamut, known.triangles, max_error, opened.charge)

    async def levels(
        self,
        wanted: Sequence[tuple[PublishedGamut, LevelRequest]],
        answer_bytes: Callable[[int], int],
    ) -> tuple[list[QueryLevel], Charge]:
        """Return one level per gamut, indexed, and the charge of the memory for the answer.

        `answer_bytes` gives the memory of the answer by the number of triangles of all levels.
        Raise `TriangleCountError` if a gamut has no such level, `GamutDamagedError` if a history
        file is damaged, and `ProblemError` if there is no memory.
        """
        answer = answer_bytes(sum(self._largest_count(*each) for each in wanted))
        costs = [self._cost(*each) for each in wanted]

        def need() -> int:
            made = zip(wanted, costs, strict=True)
            return answer + sum(0 if self._is_made(*each) else cost for each, cost in made)

        charge = await self._library.memory.charge("work", need)
        levels = [await self._level(*each, charge) for each in wanted]
        charge.shrink(answer)
        return levels, charge

    def _largest_count(self, record: PublishedGamut, request: LevelRequest) -> int:
        full: int = record.description["counts"]["triangles"]
        return min(full, self._requested.largest_count(record, request))

    def _is_made(self, record: PublishedGamut, request: LevelRequest) -> bool:
        """Return whether a level is there, or others make it."""
        if (record.id, request) in self._made:
            return True
        opened = self._library.peek(record.id)
        return opened is not None and self.find_ready(opened, request) is not None

    def _cost(self, record: PublishedGamut, request: LevelRequest) -> int:
        """Return the peak memory of making a level."""
        full: int = record.description["counts"]["triangles"]
        triangles = self._largest_count(record, request)
        finding = self._requested.finding_cost(record, request)
        if all(level["triangles"] != triangles for level in record.description["levels"]):
            # its error bound needs a comparison with the full boundary
            compared = self._library.unpacking_cost(record, full) + Cost.SEARCH * full
            finding = max(finding, compared)
        return finding + Cost.INDEX * triangles

    async def _level(
        self, record: PublishedGamut, request: LevelRequest, charge: Charge
    ) -> QueryLevel:
        made = record.id, request
        self._made[made] += 1
        try:
            opened = await self._library.gamut(record.id, charge)
            ready = self.find_ready(opened, request)
            if ready is not None:
                return ready
            triangles, _ = await self._requested.find(opened, request)
            key = record.id, triangles
            level = await self._indexing.value(key, lambda: self._index(opened, triangles))
            self._library.settle(opened, charge)
            return level
        finally:
            self._made[made] -= 1
            self._made += Counter()  # drops those that are made

    async def _index(self, opened: OpenGamut, triangles: int) -> QueryLevel:
        search, history = opened.gamut.search, opened.gamut.history
        # The error bound may need a comparison with the full boundary.
        known = search.find_error_bound(triangles)
        await self._library.unpack(opened, history.triangles if known is None else triangles)
        with timed("index"):
            await self._library.in_thread(opened.gamut.levels.level, triangles)
            max_error = await self._library.in_thread(search.error_bound, history, triangles)
        return QueryLevel(opened.gamut, triangles, max_error, opened.charge)
