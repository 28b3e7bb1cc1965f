"""Requested levels: from a triangle count or an error limit to a level of a gamut.

`gamutcore.levels` finds the level. A search for a limit takes 0.02 to 0.5 s (seconds for more than
a million triangles) and runs in a thread. Only one search runs at a time, so that other requests
keep the other threads and cores. Everything here belongs to the event loop's thread.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, TypeVar

from gamutcore.history import MINIMUM_TRIANGLES
from gamutcore.levels import BoundedLevel, LevelRequest, LevelSearch
from service.caching.single_flight import SingleFlight
from service.http.request_context import timed
from service.library import Cost
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.levels import LevelError, Side
    from service.library import Library, OpenGamut
    from service.storage.published import PublishedGamut

__all__ = ["RequestedLevels", "level_request"]

T = TypeVar("T")


def level_request(
    triangles: int | None,
    max_error: float | None,
    max_mismatch: float | None = None,
    side: Side = "both",
    remedy: str = "Give either triangles or max_error.",
) -> LevelRequest:
    """Return the request of query parameters; refuse a count that is combined with a limit."""
    if triangles is not None and (max_error is not None or max_mismatch is not None):
        fault = "A triangle count is combined with an error limit."
        where = {"in": "query", "field": "triangles"}
        raise ProblemError(Problem("invalid-parameter", fault, where, remedy))
    return LevelRequest(triangles, max_error, max_mismatch, side)


class RequestedLevels:
    """The levels of a library's gamuts that meet requests.

    `running` counts the searches under way: one that runs, and those that wait for it.
    """

    def __init__(self, library: Library) -> None:
        self._library = library
        self._finding: SingleFlight[tuple[str, LevelRequest], BoundedLevel] = SingleFlight()
        self._curves: SingleFlight[tuple[str, Side], list[LevelError]] = SingleFlight()
        self._turn = asyncio.Semaphore(1)
        self.running = 0

    def find_known(self, gamut_id: str, request: LevelRequest) -> BoundedLevel | None:
        """Return a level without a search; None if it is not known or does not exist."""
        search = self._library.search(gamut_id)
        if search is not None:
            return search.find_known(request)
        # An odd count may exceed the full boundary, which only the gamut can tell.
        count = request.triangles
        return None if count is None or count % 2 else BoundedLevel(count)

    async def find(self, opened: OpenGamut, request: LevelRequest) -> BoundedLevel:
        """Return a level, as `LevelSearch.find` does.

        Raise `TriangleCountError` if the gamut has no such level, and `GamutDamagedError` if the
        history file is damaged. The caller has charged `finding_cost`.
        """
        search, history = opened.gamut.search, opened.gamut.history
        known = search.find_known(request)
        if known is not None or request.limits is None:
            return known or search.find(history, request)
        return await self._finding.value(
            (opened.record.id, request),
            lambda: self._in_turn(
                opened,
                # The searches before this one may have found it.
                lambda: search.find_known(request),
                lambda: search.find(history, request),
            ),
        )

    async def curve(self, opened: OpenGamut, side: Side) -> list[LevelError]:
        """Return the error curve of one side, `inside` or `outside`.

        Raise `GamutDamagedError` if the history file is damaged.
        """
        search, history = opened.gamut.search, opened.gamut.history
        curve = search.known_curve(side)
        if curve is None:
            request = LevelRequest(max_error=0.0, side=side)
            with await self._library.memory.charge(
                "work", lambda: self.finding_cost(opened.record, request)
            ) as charge:
                curve = await self._curves.value(
                    (opened.record.id, side),
                    lambda: self._in_turn(
                        opened,
                        lambda: search.known_curve(side),
                        lambda: search.curve(history, side),
                    ),
                )
                self._library.settle(opened, charge)
        return curve

    def largest_count(self, record: PublishedGamut, request: LevelRequest) -> int:
        """Return an upper bound of the triangle count that `find` returns, without a search.

        A requested count is returned unchanged, even if the level does not exist.
        """
        search = self._library.search(record.id) or LevelSearch(record.description["levels"])
        return search.largest_count(request)

    def finding_cost(self, record: PublishedGamut, request: LevelRequest) -> int:
        """Return the peak memory of opening a gamut, and of finding and unpacking a level."""
        full: int = record.description["counts"]["triangles"]
        if request.side != "both":
            return self._library.unpacking_cost(record, full) + Cost.SIDE * full
        if request.limits is None or self.find_known(record.id, request):
            triangles = max(MINIMUM_TRIANGLES, min(full, self.largest_count(record, request)))
            return self._library.unpacking_cost(record, triangles)
        return self._library.unpacking_cost(record, full) + Cost.SEARCH * full

    async def _in_turn(
        self, opened: OpenGamut, known: Callable[[], T | None], find: Callable[[], T]
    ) -> T:
        """Wait for the other searches, then return a known result, or find it in a thread."""
        self.running += 1
        try:
            with timed("wait"):
                await self._turn.acquire()
            try:
                result = known()
                if result is None:
                    await self._library.unpack(opened, opened.gamut.history.triangles)
                    with timed("choose"):
                        result = await self._library.in_thread(find)
            finally:
                self._turn.release()
        finally:
            self.running -= 1
        return result
