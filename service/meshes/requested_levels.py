"""Requested levels: from a triangle count or an error limit to a level of a gamut.

A limit needs a search, which takes 0.02 to 0.5 s (seconds for more than a million triangles) and
runs in a thread. Only one search runs at a time, so that other requests keep the other threads and
cores. Levels that were found are kept, and so are curves of one side. Everything here belongs to
the event loop's thread.
"""

from __future__ import annotations

import asyncio
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from gamutcore.history import MINIMUM_TRIANGLES
from gamutcore.levels import Bounds, LevelSearch, Side, SidedSearch
from service.caching.byte_bounded_cache import ByteBoundedCache
from service.caching.single_flight import SingleFlight
from service.library import Cost
from service.telemetry.server_timing import timed

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.export import MeshFormat
    from gamutcore.levels import BoundedLevel, LevelError
    from service.library import Library, OpenGamut
    from service.storage.records import Record

__all__ = ["DEFAULT_TRIANGLES", "LevelRequest", "RequestedLevels"]

DEFAULT_TRIANGLES = 1000
"""Triangle count if the request has neither a count nor a limit: 23 kB as GLB, and smooth."""

_CAPACITY = 16 * 1024 * 1024
"""Bytes for tables, enough for several hundred gamuts. They stay when the histories, which are a
hundred times as large, leave the memory."""

_LEVELS_CAPACITY = 16 * 1024 * 1024
"""Bytes for the levels of requested limits."""

_LEVEL_BYTES = 500
"""Approximate memory of one level: key, bounds, bookkeeping."""

_Key = tuple[str, Side]
"""Gamut and side."""

T = TypeVar("T")


class LevelRequest(NamedTuple):
    """The level that a client asks for; the default level if nothing is given.

    `triangles` is the largest triangle count, `max_error` the largest distance from the full
    boundary in the space's unit, and `max_mismatch` the largest mismatch. `side` is the side of the
    full boundary that the mesh is on.
    """

    triangles: int | None = None
    max_error: float | None = None
    max_mismatch: float | None = None
    side: Side = "both"

    def for_format(self, mesh_format: MeshFormat) -> LevelRequest:
        """Return the request with the default of its format: some start from the full boundary."""
        if mesh_format.full and self.triangles is None and self.limits is None:
            return self._replace(max_error=0.0)
        return self

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


class RequestedLevels:
    """The levels of a library's gamuts that meet requests.

    `running` counts the searches under way: one that runs, and those that wait for it.
    """

    def __init__(self, library: Library) -> None:
        self._library = library
        self._searches: ByteBoundedCache[_Key, LevelSearch | SidedSearch] = ByteBoundedCache(
            _CAPACITY
        )
        self._levels: ByteBoundedCache[tuple[_Key, Bounds], BoundedLevel] = ByteBoundedCache(
            _LEVELS_CAPACITY
        )
        self._finding: SingleFlight[tuple[_Key, Bounds], BoundedLevel] = SingleFlight()
        self._curves: SingleFlight[_Key, list[LevelError]] = SingleFlight()
        self._turn = asyncio.Semaphore(1)
        self.running = 0

    @property
    def caches(self) -> dict[str, ByteBoundedCache[Any, Any]]:
        """The caches by name: tables by gamut and side, levels by limits."""
        return {"tables": self._searches, "limits": self._levels}

    def find_known(
        self, gamut_id: str, request: LevelRequest, opened: OpenGamut | None
    ) -> tuple[int, Bounds | None] | None:
        """Return the triangle count and the bounds of a level without a search.

        Bounds are given for limits only. The result is None if the level is not known or does not
        exist.
        """
        limits = request.limits
        if limits is not None:
            level = self._known((gamut_id, request.side), limits)
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

        Raise `TriangleCountError` if the gamut has no such level, and `GamutDamagedError` if the
        history file is damaged. The caller has charged `finding_cost`.
        """
        gamut_id, limits, history = opened.record.id, request.limits, opened.gamut.history
        if limits is None:
            return history.level_triangles(request.count(history.triangles)), None
        key = gamut_id, request.side
        search = self._search_of(opened, request.side)
        level = search.find_known(limits)
        if level is None:
            level = await self._finding.value(
                (key, limits), lambda: self._search(opened, key, search, limits)
            )
        return level.triangles, level.bounds

    async def curve(self, opened: OpenGamut, side: Side) -> list[LevelError]:
        """Return the error curve of one side, `inside` or `outside`.

        Raise `GamutDamagedError` if the history file is damaged.
        """
        search = self._search_of(opened, side)
        assert isinstance(search, SidedSearch)  # noqa: S101 - `both` has its curve in the record
        curve = search.known_curve
        if curve is None:
            request = LevelRequest(max_error=0.0, side=side)
            with await self._library.memory.charge(
                "work", lambda: self.finding_cost(opened.record, request)
            ) as charge:
                curve = await self._curves.value(
                    (opened.record.id, side), lambda: self._compute_curve(opened, search)
                )
                self._library.settle(opened, charge)
        return curve

    def triangle_bound(self, record: Record, request: LevelRequest) -> int:
        """Return an upper bound of the triangle count that `find` returns, without a search.

        A requested count is returned unchanged, even if the level does not exist.
        """
        limits = request.limits
        largest: int = record.description["counts"]["triangles"]
        if limits is None:
            return request.count(largest)
        known = self._known((record.id, request.side), limits)
        if known is not None:
            return known.triangles
        if request.side != "both":
            return largest
        return LevelSearch(record.description["levels"]).find_bound(limits).triangles

    def finding_cost(self, record: Record, request: LevelRequest) -> int:
        """Return the peak memory of opening a gamut, and of finding and unpacking a level."""
        full: int = record.description["counts"]["triangles"]
        if request.side != "both":
            return self._library.unpacking_cost(record, full) + Cost.SIDE * full
        if request.limits is None or self._known((record.id, "both"), request.limits):
            triangles = max(MINIMUM_TRIANGLES, min(full, self.triangle_bound(record, request)))
            return self._library.unpacking_cost(record, triangles)
        return self._library.unpacking_cost(record, full) + Cost.SEARCH * full

    def discard(self, gamut_id: str) -> None:
        """Forget the levels of a deleted gamut."""
        self._searches.discard_where(lambda key: key[0] == gamut_id)
        self._levels.discard_where(lambda key: key[0][0] == gamut_id)

    def _search_of(self, opened: OpenGamut, side: Side) -> LevelSearch | SidedSearch:
        """Return the search of a gamut and side, a new one if there is none."""
        gamut_id, full = opened.record.id, opened.gamut.history.triangles
        search = self._searches.get((gamut_id, side))
        if search is None:
            if side == "both":
                search = LevelSearch(opened.gamut.description["levels"])
            else:
                search = SidedSearch(full, side)
            # Nothing is kept of a gamut that was deleted meanwhile.
            if self._library.find_open(gamut_id) is opened:
                self._searches.put((gamut_id, side), search, search.nbytes)
        # The gamut's own methods need no second search.
        opened.gamut.levels.searches[side] = search
        return search

    def _known(self, key: _Key, limits: Bounds) -> BoundedLevel | None:
        level = self._levels.get((key, limits))
        if level is not None:
            return level
        search = self._searches.get(key)
        level = None if search is None else search.find_known(limits)
        if level is not None:
            # Finding it again would take half of the time of a repeated request.
            self._levels.put((key, limits), level, _LEVEL_BYTES)
        return level

    async def _search(
        self, opened: OpenGamut, key: _Key, search: LevelSearch | SidedSearch, limits: Bounds
    ) -> BoundedLevel:
        level = await self._in_turn(
            opened,
            # The searches before this one may have found it.
            lambda: self._known(key, limits),
            lambda: search.find(opened.gamut.history, limits),
        )
        self._searches.resize(key, search, search.nbytes)
        # Nothing is kept of a gamut that was deleted meanwhile.
        if self._library.find_open(key[0]) is opened:
            self._levels.put((key, limits), level, _LEVEL_BYTES)
        return level

    async def _compute_curve(self, opened: OpenGamut, search: SidedSearch) -> list[LevelError]:
        return await self._in_turn(
            opened, lambda: search.known_curve, lambda: search.curve(opened.gamut.history)
        )

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
