"""The open gamuts: read and verified once, then kept in memory.

Opening blocks on the store, and unpacking a level takes up to tens of milliseconds, so both run in
a few threads. Simultaneous requests for a gamut share one opening. The memory is bounded in bytes.
Everything here belongs to the event loop's thread, unless stated otherwise.
"""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from gamutcore.colours.spaces import ColourSpace
from gamutcore.errors import HistoryFileError
from gamutcore.export.provenance import mesh_provenance
from gamutcore.gamut import Gamut
from service.caching.byte_bounded_cache import ByteBoundedCache
from service.caching.single_flight import SingleFlight
from service.storage.display_names import display_name
from service.telemetry.server_timing import timed

if TYPE_CHECKING:
    from collections.abc import Callable

    from service.storage.gamuts import GamutStore
    from service.storage.records import Record

__all__ = ["Library", "OpenGamut"]

P = ParamSpec("P")
T = TypeVar("T")

_THREADS = 2
"""Number of histories that are opened or unpacked, and large meshes that are encoded, at the same
time. It also bounds their memory."""


@dataclass(frozen=True)
class OpenGamut:
    """A gamut in memory.

    Attributes
    ----------
    record : Record
        The record that the gamut was read with. A newer gamut may have the same id.
    gamut : Gamut
        The gamut with its history.
    provenance : dict of str
        Provenance for mesh files.
    space : ColourSpace
        Space of the coordinates.
    name : str
        Name of the gamut, for the names of its files.
    """

    record: Record
    gamut: Gamut
    provenance: dict[str, str]
    space: ColourSpace
    name: str


class Library:
    """Opens gamuts of a store and keeps the most recently used.

    Parameters
    ----------
    store : GamutStore
        The gamuts.
    capacity : int
        Bytes of memory for open gamuts.
    """

    def __init__(self, store: GamutStore, capacity: int) -> None:
        self._store = store
        self._open: ByteBoundedCache[str, OpenGamut] = ByteBoundedCache(capacity)
        self._opening: SingleFlight[str, OpenGamut] = SingleFlight()
        self._threads = ThreadPoolExecutor(_THREADS, thread_name_prefix="library")

    @property
    def cache(self) -> ByteBoundedCache[str, OpenGamut]:
        """The open gamuts."""
        return self._open

    def find_open(self, gamut_id: str) -> OpenGamut | None:
        """Return a gamut if it is open; else None."""
        found = self._open.get(gamut_id)
        if found is not None:
            self._store.mark_used(gamut_id)
        return found

    async def gamut(self, gamut_id: str) -> OpenGamut:
        """Return a gamut; open it if needed.

        Raises
        ------
        GamutNotStoredError
            There is no such gamut, or it is damaged.
        """
        found = self.find_open(gamut_id)
        if found is not None:
            return found
        return await self._opening.value(gamut_id, lambda: self._open_and_keep(gamut_id))

    async def unpack(self, opened: OpenGamut, triangles: int) -> None:
        """Unpack a level of an open gamut, so that it can be read.

        Parameters
        ----------
        opened : OpenGamut
        triangles : int
            An existing level.

        Raises
        ------
        GamutDamagedError
            The history file is damaged.
        """
        record, history = opened.record, opened.gamut.history
        if history.is_unpacked(triangles):
            return
        with timed("open"):
            try:
                await self.in_thread(history.unpack, triangles)
            except Exception as error:
                # Drop the unusable object. A gamut that was built since then can be opened again.
                self._open.discard_value(record.id, opened)
                if not isinstance(error, HistoryFileError):
                    raise
                reason = str(error)
                raise await self.in_thread(self._store.set_aside, record, reason) from error
        self._open.resize(record.id, opened, opened.gamut.nbytes)

    async def record(self, gamut_id: str) -> Record:
        """Return a gamut's record; raises `GamutNotStoredError` if there is none."""
        with timed("store"):
            return await asyncio.to_thread(self._store.record, gamut_id)

    async def with_level(
        self,
        opened: OpenGamut,
        triangles: int,
        function: Callable[P, T],
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> T:
        """Unpack a level, then return the result of a function that needs it, from a thread."""
        await self.unpack(opened, triangles)
        return await self.in_thread(function, *args, **kwargs)

    async def in_thread(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Return the result of a function that is too slow for the event loop."""
        loop = asyncio.get_running_loop()
        # With the context, so that times measured in the thread belong to the request.
        context = copy_context()
        return await loop.run_in_executor(
            self._threads, lambda: context.run(function, *args, **kwargs)
        )

    async def rename(self, gamut_id: str) -> None:
        """Read the name of an open gamut again."""
        opened = self._open.get(gamut_id)
        if opened is None:
            self._opening.forget(gamut_id)
            return
        stored = await self.in_thread(self._store.names.read, gamut_id)
        if self._open.discard_value(gamut_id, opened):
            renamed = replace(opened, name=display_name(opened.record, stored))
            self._open.put(gamut_id, renamed, opened.gamut.nbytes)

    def discard(self, gamut_id: str) -> None:
        """Forget a deleted gamut."""
        self._open.discard(gamut_id)
        self._opening.forget(gamut_id)

    def close(self) -> None:
        """End the threads."""
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def _open_and_keep(self, gamut_id: str) -> OpenGamut:
        with timed("open"):
            opened = await self.in_thread(self._open_from_store, gamut_id)
        # A gamut that was deleted while it was opened is returned but not kept.
        if self._opening.is_current(gamut_id):
            self._open.put(gamut_id, opened, opened.gamut.nbytes)
        return opened

    def _open_from_store(self, gamut_id: str) -> OpenGamut:
        record, content = self._store.content(gamut_id)
        try:
            gamut = Gamut.from_bytes(content)
        except HistoryFileError as error:
            raise self._store.set_aside(record, str(error)) from error
        provenance = mesh_provenance(gamut.description)
        name = display_name(record, self._store.names.read(gamut_id))
        return OpenGamut(record, gamut, provenance, gamut.colour_space, name)
