"""The gamuts that are open: read and verified once, then kept in memory.

Opening blocks on the disk, and unpacking the levels that are asked for takes up to tens of
milliseconds, so both happen in a few threads, and requests that want the same gamut at the same
time wait for the same opening. What is kept is bounded in bytes. Everything here belongs to the
event loop's thread, except what says otherwise.
"""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from gamutcore.colours.spaces import ColourSpace
from gamutcore.errors import HistoryFileError
from gamutcore.gamut import Gamut
from service.caching.byte_bounded_cache import ByteBoundedCache
from service.caching.single_flight import SingleFlight
from service.telemetry.server_timing import timed

if TYPE_CHECKING:
    from collections.abc import Callable

    from service.storage.gamuts import GamutStore
    from service.storage.records import Record

__all__ = ["Library", "OpenGamut", "mesh_provenance"]

P = ParamSpec("P")
T = TypeVar("T")

_THREADS = 2
"""Histories opened or unpacked, or large meshes encoded, at the same time; it bounds their memory
as well."""


@dataclass(frozen=True)
class OpenGamut:
    """A gamut in memory.

    Attributes
    ----------
    record : Record
        What its bytes were read by: another may have the id by now.
    gamut : Gamut
        With its history.
    provenance : dict of str
        What every mesh of it carries.
    space : ColourSpace
        What its coordinates are in.
    """

    record: Record
    gamut: Gamut
    provenance: dict[str, str]
    space: ColourSpace


class Library:
    """Opens gamuts of a store and keeps those used last.

    Parameters
    ----------
    store : GamutStore
        Where the gamuts are.
    capacity : int
        Bytes of memory for opened gamuts.
    """

    def __init__(self, store: GamutStore, capacity: int) -> None:
        self._store = store
        self._open: ByteBoundedCache[str, OpenGamut] = ByteBoundedCache(capacity)
        self._opening: SingleFlight[str, OpenGamut] = SingleFlight()
        self._threads = ThreadPoolExecutor(_THREADS, thread_name_prefix="library")

    @property
    def cache(self) -> ByteBoundedCache[str, OpenGamut]:
        """The gamuts that are kept."""
        return self._open

    def opened(self, gamut_id: str) -> OpenGamut | None:
        """Return a gamut that is open already; None if it is not."""
        found = self._open.get(gamut_id)
        if found is not None:
            self._store.mark_used(gamut_id)
        return found

    async def gamut(self, gamut_id: str) -> OpenGamut:
        """Return a gamut, opened if need be.

        Raises
        ------
        GamutNotStoredError
            There is none of this id, or it is damaged.
        """
        found = self.opened(gamut_id)
        if found is not None:
            return found
        return await self._opening.value(gamut_id, lambda: self._open_and_keep(gamut_id))

    async def unpack(self, opened: OpenGamut, triangles: int) -> None:
        """Have a level of an open gamut ready to be read.

        Parameters
        ----------
        opened : OpenGamut
        triangles : int
            Of a level that the gamut has.

        Raises
        ------
        GamutDamagedError
            If what the file holds of it turns out to be damaged.
        """
        record, history = opened.record, opened.gamut.history
        if history.is_unpacked(triangles):
            return
        with timed("open"):
            try:
                await self.in_thread(history.unpack, triangles)
            except Exception as error:
                # It cannot be unpacked any further. One that was built since then can.
                self._open.discard_value(record.id, opened)
                if not isinstance(error, HistoryFileError):
                    raise
                reason = str(error)
                raise await self.in_thread(self._store.set_aside, record, reason) from error
        self._open.resize(record.id, opened, opened.gamut.nbytes)

    async def record(self, gamut_id: str) -> Record:
        """Return a gamut's record; `GamutNotStoredError` if there is none."""
        with timed("store"):
            return await asyncio.to_thread(self._store.record, gamut_id)

    async def in_thread(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Return what a function returns that is too slow for the event loop."""
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._threads, lambda: function(*args, **kwargs))

    def discard(self, gamut_id: str) -> None:
        """Forget a gamut that was deleted."""
        self._open.discard(gamut_id)
        self._opening.forget(gamut_id)

    def close(self) -> None:
        """Let the threads end."""
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def _open_and_keep(self, gamut_id: str) -> OpenGamut:
        with timed("open"):
            opened = await self.in_thread(self._opened_from_store, gamut_id)
        # What was deleted while it was being opened is answered with, but not kept.
        if self._opening.is_current(gamut_id):
            self._open.put(gamut_id, opened, opened.gamut.nbytes)
        return opened

    def _opened_from_store(self, gamut_id: str) -> OpenGamut:
        record, content = self._store.content(gamut_id)
        try:
            gamut = Gamut.from_bytes(content)
        except HistoryFileError as error:
            raise self._store.set_aside(record, str(error)) from error
        provenance = mesh_provenance(gamut.id, gamut.description)
        return OpenGamut(record, gamut, provenance, gamut.colour_space)


def mesh_provenance(gamut_id: str, description: dict[str, Any]) -> dict[str, str]:
    """Return the plain facts of a description: what a mesh file says about its origin.

    Numbers are written as in the description, so they are read back without a loss; the centre is
    the one that was found, not the option that asked for it.
    """
    provenance = description.get("provenance", {})
    facts = {"gamut": gamut_id}
    for name, triple in (("centre", description.get("centre")), ("white", provenance.get("white"))):
        if triple:
            facts[name] = " ".join(map(repr, triple))
    for name, part_name, member in (
        ("input_sha256", "input", "sha256"),
        ("algorithm_version", "algorithm", "version"),
    ):
        part = provenance.get(part_name, {})
        if member in part:
            facts[name] = str(part[member])
    options = description.get("options", {})
    white = options.get("reference_white")
    if isinstance(white, list):
        facts["reference_white"] = " ".join(map(repr, white))
    if white is not None or "scale" in options:
        # of the space, also where the provenance tells of another one on the way to it
        facts["adaptation"] = str(options.get("adaptation", "Bradford"))
    for part in ("options", "provenance"):
        for name, value in description.get(part, {}).items():
            if isinstance(value, str | int | float):
                facts.setdefault(name, str(value))
    return facts
