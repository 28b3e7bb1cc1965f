"""Levels that answer queries: found by count or error, and indexed before they answer.

A gamut keeps the indexes of its own levels up to a number of bytes. They count as memory of the
open gamut, so that the cache of open gamuts bounds the indexes of all.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from service.caching.single_flight import SingleFlight
from service.telemetry.server_timing import timed

if TYPE_CHECKING:
    from gamutcore.gamut import Gamut
    from service.meshes.library import Library, OpenGamut
    from service.meshes.requested_levels import LevelRequest, RequestedLevels

__all__ = ["QueryLevel", "QueryLevels"]


class QueryLevel(NamedTuple):
    """A level that is ready for queries.

    Attributes
    ----------
    gamut : Gamut
        Has the level indexed.
    triangles : int
    max_error : float
        Upper bound of the distance from the full boundary, in units of the space.
    """

    gamut: Gamut
    triangles: int
    max_error: float

    @property
    def axes(self) -> tuple[str, str, str]:
        """Names of the coordinates."""
        return self.gamut.colour_space.axes


class QueryLevels:
    """The levels that answer queries. Belongs to the event loop's thread.

    Parameters
    ----------
    library : Library
        The open gamuts.
    requested : RequestedLevels
        Finds levels for limits.
    capacity : int
        Bytes of memory for the indexes of one gamut.
    """

    def __init__(self, library: Library, requested: RequestedLevels, capacity: int) -> None:
        self._library = library
        self._requested = requested
        self._capacity = capacity
        self._indexing: SingleFlight[tuple[str, int], QueryLevel] = SingleFlight()

    def find_ready(self, opened: OpenGamut, request: LevelRequest) -> QueryLevel | None:
        """Return a level without waiting; None if it is not in memory."""
        known = self._requested.find_known(opened.record.id, request, opened)
        if known is None:
            return None
        levels = opened.gamut.levels
        max_error = levels.find_error_bound(known[0])
        if max_error is None or levels.find_kept(known[0]) is None:
            return None
        return QueryLevel(opened.gamut, known[0], max_error)

    async def level(self, opened: OpenGamut, request: LevelRequest) -> QueryLevel:
        """Return a level, and index it if needed.

        Raises
        ------
        TriangleCountError
            The gamut has no such level.
        GamutDamagedError
            The history file is damaged.
        """
        ready = self.find_ready(opened, request)
        if ready is not None:
            return ready
        triangles, _ = await self._requested.find(opened, request)
        key = opened.record.id, triangles
        return await self._indexing.value(key, lambda: self._index(opened, triangles))

    async def _index(self, opened: OpenGamut, triangles: int) -> QueryLevel:
        levels = opened.gamut.levels
        levels.capacity = self._capacity
        # The error bound may need a comparison with the full boundary.
        known = levels.find_error_bound(triangles)
        full = opened.gamut.history.triangles
        await self._library.unpack(opened, full if known is None else triangles)
        with timed("index"):
            await self._library.in_thread(levels.indexed, triangles)
            max_error = await self._library.in_thread(levels.error_bound, triangles)
        self._library.cache.resize(opened.record.id, opened, opened.gamut.nbytes)
        return QueryLevel(opened.gamut, triangles, max_error)
