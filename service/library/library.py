"""The library: open gamuts, and the levels, indexes and encoded answers that are made of them.

`Library` opens a gamut, finds the level of a request, indexes or encodes it, and keeps what it made
in caches that are bounded in bytes. Simultaneous requests for the same work share it. Whoever asks
holds a place with the bytes that `need` returns; see `service.admission`.

Opening blocks on the store, unpacking takes up to tens of milliseconds, and a search for a limit
0.02 to 0.5 s (seconds for more than a million triangles). All this runs in threads. Small levels
that are unpacked are encoded on the event loop in about a millisecond. Everything here belongs to
the event loop's thread.
"""

from __future__ import annotations

import asyncio
import contextlib
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, ParamSpec, TypeVar
from weakref import WeakValueDictionary

import numpy as np

from gamutcore.building import device_model
from gamutcore.errors import DeviceModelError, HistoryFileError, TriangleCountError
from gamutcore.export.provenance import mesh_provenance
from gamutcore.export.rendering import PICTURE_TRIANGLES
from gamutcore.gamut import Gamut
from gamutcore.history import MINIMUM_TRIANGLES
from gamutcore.levels import BoundedLevel, LevelRequest, LevelSearch
from gamutcore.limits import Limits
from gamutcore.questions import black_rule
from service.admission import Admission, Holding, Work, needed_bytes
from service.concurrency import SingleFlight, Threads
from service.http.representations import IDENTITY
from service.http.request_context import timed
from service.library.cache import ByteBoundedCache
from service.library.encoding import (
    INLINE_TRIANGLES,
    EncodedKey,
    EncodedLevel,
    PictureOptions,
    encode_level,
)
from service.library.open_gamut import OpenGamut
from service.storage.blobs import BlobNotFoundError, StoreFullError, StoreUnavailableError
from service.storage.gamut_names import display_name
from service.storage.gamut_store import GamutNotStoredError

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Sequence

    from gamutcore.levels import LevelError, Side
    from service.storage.gamut_store import GamutStore
    from service.storage.published import PublishedGamut

__all__ = ["Library", "QueryLevel"]

P = ParamSpec("P")
T = TypeVar("T")

_SEARCH_BYTES = 32 * 1024 * 1024
"""Bytes for searches with what they have found, enough for a thousand gamuts. They stay when the
histories, which are a hundred times as large, leave the memory."""

_ENTRY_BYTES = 1024
"""Approximate memory of an encoded level besides the content: key, header fields, bookkeeping."""

_OPENED = 1 / 16
"""Opening a gamut, as a part of unpacking all of it: the file, and a copy while the digest is
checked."""

_SIDED = 0.75
"""Finding or making a level on one side, per triangle of the full boundary, in indexes."""

_ENCODED = 2.0
"""Encoding a level in the largest format (3MF, 690 bytes a triangle) and compressing it, in indexes
of the level."""

_DRAWN_PIXELS = 4 / 3
"""Memory of a drawn pixel, in pixels that are mapped."""

_FITTED = 1 / 2
"""Fitting a device model, per square of the number of patches, in pixels: a matrix, two copies."""


class QueryLevel(NamedTuple):
    """A level that is ready for queries: the gamut has it indexed.

    `max_error` is an upper bound of the distance from the full boundary, in units of the space. The
    gamut's `holding` counts its memory as long as the level is in use.
    """

    gamut: Gamut
    triangles: int
    max_error: float
    holding: Holding | None = None

    @property
    def axes(self) -> tuple[str, str, str]:
        """Names of the coordinates."""
        return self.gamut.colour_space.axes


class Library:
    """The gamuts of a store, and what is made of them.

    The caches have open gamuts with the indexes of their levels (up to `gamut_bytes`, of which
    `index_bytes` are for the indexes of one gamut), encoded levels (up to `mesh_bytes`), and the
    searches for levels, also of closed gamuts.
    """

    def __init__(
        self,
        store: GamutStore,
        admission: Admission,
        gamut_bytes: int,
        mesh_bytes: int,
    ) -> None:
        self.admission = admission
        self._store = store
        self._open: ByteBoundedCache[str, OpenGamut] = ByteBoundedCache(gamut_bytes)
        self._encoded: ByteBoundedCache[EncodedKey, EncodedLevel] = ByteBoundedCache(mesh_bytes)
        self._searches: ByteBoundedCache[str, LevelSearch] = ByteBoundedCache(_SEARCH_BYTES)
        admission.add(self._open)
        admission.add(self._encoded)
        # Also those in use that have left the cache: opening them again would double their memory.
        self._used: WeakValueDictionary[str, OpenGamut] = WeakValueDictionary()
        self._flights: SingleFlight[tuple[Hashable, ...], Any] = SingleFlight()
        # one for every place, so that whoever holds a place has a thread
        places = (*admission.places.values(), *admission.first_places.values())
        self._threads = Threads(sum(places), "work")

    @property
    def caches(self) -> dict[str, ByteBoundedCache[Any, Any]]:
        """The caches by the names that metrics have for them."""
        return {"gamuts": self._open, "meshes": self._encoded, "tables": self._searches}

    async def in_thread(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Return the result of a function that is too slow for the event loop."""
        return await self._threads.run(function, *args, **kwargs)

    async def rename(self, gamut_id: str) -> None:
        """Read the name of a gamut again, and give its files the new name from now on."""
        opened = self._open.get(gamut_id) or self._used.get(gamut_id)
        if opened is None:
            self._flights.forget((gamut_id, "open"))
        else:
            stored = await self.in_thread(self._store.names.read, gamut_id)
            if self._used.get(gamut_id) is opened:
                self._open.discard(gamut_id)
                self._put_open(replace(opened, name=display_name(opened.record, stored)))
        self._encoded.discard_where(lambda key: key.gamut_id == gamut_id)

    def discard(self, gamut_id: str) -> None:
        """Forget a deleted gamut, and everything that was made of it."""
        self._open.discard(gamut_id)
        self._searches.discard(gamut_id)
        self._encoded.discard_where(lambda key: key.gamut_id == gamut_id)
        self._used.pop(gamut_id, None)
        self._flights.forget((gamut_id, "open"))

    def close(self) -> None:
        """End the threads."""
        self._threads.close()

    # --- open gamuts ------------------------------------------------------------------------------

    async def record(self, gamut_id: str) -> PublishedGamut:
        """Return a gamut's record.

        Raise `GamutNotStoredError` if there is none; what was made of the gamut is forgotten.
        """
        with timed("store"):
            try:
                return await asyncio.to_thread(self._store.record, gamut_id)
            except GamutNotStoredError:
                self.discard(gamut_id)
                raise

    def is_current(self, gamut_id: str) -> bool:
        """Whether a gamut is stored, and the store need not be asked for it."""
        return self._store.is_current(gamut_id)

    def find_open(self, gamut_id: str) -> OpenGamut | None:
        """Return a gamut if it is open, and the store need not be asked for it; else None."""
        return self._find_open(gamut_id) if self._store.is_current(gamut_id) else None

    def _find_open(self, gamut_id: str) -> OpenGamut | None:
        """Return a gamut if it is open; else None. The caller has its record."""
        opened = self._open.get(gamut_id)
        if opened is None:
            opened = self._used.get(gamut_id)
            if opened is not None:
                # It had to give way while it was in use.
                self._put_open(opened)
        if opened is not None:
            self._store.uses.mark(gamut_id)
        return opened

    async def gamut(self, gamut_id: str, client: str) -> OpenGamut:
        """Return a gamut, after opening it in a place of its own if needed.

        Raise `GamutNotStoredError` if the gamut is missing or damaged.
        """
        opened = self.find_open(gamut_id)
        if opened is not None:
            return opened
        full = _full_count(await self.record(gamut_id))
        opened = self._find_open(gamut_id)
        if opened is not None:
            return opened

        def need() -> int:
            return 0 if gamut_id in self._used else needed_bytes(unpacked=_OPENED * full)

        with await self.admission.place(Work.SMALL, client, need):
            return await self.open(gamut_id)

    async def open(self, gamut_id: str) -> OpenGamut:
        """Return a gamut, after opening it if needed. The caller holds the bytes; see `need`.

        Raise `GamutNotStoredError` if the gamut is missing or damaged.
        """
        opened: OpenGamut | None = self._find_open(gamut_id)
        if opened is None:
            opened = await self._flights.value(
                (gamut_id, "open"), lambda: self._open_and_keep(gamut_id)
            )
        return opened

    def model_need(self, record: PublishedGamut) -> int:
        """Return the bytes for `load_device_model`."""
        opened = self._used.get(record.id)
        if opened is not None and opened.gamut.has_inverse:
            return 0
        patches = record.description["provenance"].get("patches", {}).get("used", 0)
        return needed_bytes(models=1, pixels=_FITTED * patches**2)

    async def load_device_model(self, gamut_id: str) -> OpenGamut:
        """Return a gamut with its device model and the inverse, from the store or from the input.

        The object stays the one in use while the caller keeps it. The caller holds the bytes; see
        `model_need`.

        Raise `DeviceModelError` if the gamut is of colours only, or its input is gone, and
        `GamutNotStoredError` if the gamut is missing.
        """
        opened = await self.open(gamut_id)
        if opened.gamut.has_inverse:
            return opened
        if not opened.gamut.is_of_device:
            raise opened.gamut.no_device_model()

        async def load() -> None:
            with timed("model"):
                await self.in_thread(self._prepare_recipes, opened)
            self.keep(opened)

        await self._flights.value((gamut_id, "model"), load)
        return opened

    def _prepare_recipes(self, opened: OpenGamut) -> None:
        gamut, gamut_id = opened.gamut, opened.record.id
        if not gamut.has_device_model:
            content = self._store.device_model(gamut_id)
            if content is None:
                content = self._make_device_model(gamut)
                with contextlib.suppress(OSError, StoreFullError, StoreUnavailableError):
                    self._store.keep_device_model(gamut_id, content)
            gamut.use_device_model(content)
        # The first colours make further tables; one of these is out of every gamut.
        gamut.inverse_model.recipes(np.array([(50.0, 0.0, 0.0), (50.0, 300.0, 0.0)]), black_rule())

    def _make_device_model(self, gamut: Gamut) -> bytes:
        """Return the device model of the kept input of a gamut."""
        try:
            path = self._store.input_path(gamut.id)
        except BlobNotFoundError:
            remedy = "Post the same data with the same options again."
            if not self._store.keep_inputs:
                remedy = "Ask the operator to keep inputs (GAMUT_KEEP_INPUTS); then post it again."
            raise DeviceModelError(
                "The data of the gamut is not stored any more, and its device model was not made.",
                where={"field": "gamut"},
                remedy=remedy,
            ) from None
        try:
            content = path.read_bytes()
        finally:
            path.unlink(missing_ok=True)
        made = device_model(content, gamut.options, Limits())
        if made is None:
            raise gamut.no_device_model()
        return made[0].to_bytes()

    def unpacked(self, record: PublishedGamut, triangles: float) -> float:
        """Return the triangles to unpack for an existing level of a gamut, after opening it."""
        opened = self._used.get(record.id)
        full = _full_count(record)
        if opened is None:
            return min(full, 2 * triangles) + _OPENED * full
        # Groups of splits double in size, and a level needs all of its last group.
        return 0 if opened.gamut.history.is_unpacked(int(triangles)) else min(full, 2 * triangles)

    async def unpack(self, opened: OpenGamut, triangles: int) -> None:
        """Unpack an existing level of an open gamut, so that it can be read.

        The caller calls `keep` in the end. Raise `GamutDamagedError` if the history file is
        damaged.
        """
        record, history = opened.record, opened.gamut.history
        if history.is_unpacked(triangles):
            return
        with timed("open"):
            try:
                await self.in_thread(history.unpack, triangles)
            except Exception as error:
                # Drop the unusable object. A gamut that was built since then can be opened again.
                if self._used.get(record.id) is opened:
                    self._open.discard(record.id)
                    del self._used[record.id]
                if not isinstance(error, HistoryFileError):
                    raise
                reason = str(error)
                raise await self.in_thread(self._store.set_aside, record, reason) from error

    def keep(self, opened: OpenGamut) -> None:
        """Keep a gamut after work on it, and count the memory that it has by now."""
        gamut_id, search = opened.record.id, opened.gamut.search
        opened.holding.resize(opened.gamut.nbytes)
        # Nothing is kept of a gamut that was deleted or renamed meanwhile.
        if self._used.get(gamut_id) is opened:
            self._put_open(opened)
            self._searches.put(gamut_id, search, search.nbytes)

    def _put_open(self, opened: OpenGamut) -> None:
        self._used[opened.record.id] = opened
        self._open.put(opened.record.id, opened, opened.gamut.nbytes)

    async def _open_and_keep(self, gamut_id: str) -> OpenGamut:
        with timed("open"):
            search = self._searches.get(gamut_id)
            holding = self.admission.hold("gamuts", 0)
            opened = await self.in_thread(self._open_from_store, gamut_id, search, holding)
        opened.holding.resize(opened.gamut.nbytes)
        # A gamut that was deleted while it was opened is returned but not kept.
        if self._flights.is_current((gamut_id, "open")):
            self._put_open(opened)
        return opened

    def _open_from_store(
        self, gamut_id: str, search: LevelSearch | None, holding: Holding
    ) -> OpenGamut:
        record, content = self._store.content(gamut_id)
        try:
            gamut = Gamut.from_bytes(content, search=search)
        except HistoryFileError as error:
            raise self._store.set_aside(record, str(error)) from error
        provenance = mesh_provenance(gamut.description)
        name = display_name(record, self._store.names.read(gamut_id))
        return OpenGamut(record, gamut, provenance, gamut.colour_space, name, holding)

    # --- levels -----------------------------------------------------------------------------------

    def find_known(self, gamut_id: str, request: LevelRequest) -> BoundedLevel | None:
        """Return a level without a search; None if it is not known or does not exist."""
        search = self._search_of(gamut_id)
        if search is not None:
            return search.find_known(request)
        # An odd count may exceed the full boundary, which only the gamut can tell.
        count = request.triangles
        return None if count is None or count % 2 else BoundedLevel(count)

    def largest_count(self, record: PublishedGamut, request: LevelRequest) -> int:
        """Return an upper bound of the triangle count that `find` returns, without a search.

        A requested count is returned unchanged, even if the level does not exist.
        """
        search = self._search_of(record.id) or LevelSearch(record.description["levels"])
        return search.largest_count(request)

    def _find_need(self, record: PublishedGamut, request: LevelRequest) -> int:
        """Return the bytes for opening a gamut, and for finding and unpacking a level."""
        full = _full_count(record)
        if request.side != "both":
            return needed_bytes(unpacked=self.unpacked(record, full), prepared=_SIDED * full)
        if request.limits is None or self.find_known(record.id, request):
            triangles = max(MINIMUM_TRIANGLES, min(full, self.largest_count(record, request)))
            return needed_bytes(unpacked=self.unpacked(record, triangles))
        # A search is a part of unpacking.
        return needed_bytes(unpacked=max(self.unpacked(record, full), full / 3))

    async def find(self, opened: OpenGamut, request: LevelRequest) -> BoundedLevel:
        """Return a level, as `LevelSearch.find` does.

        Raise `TriangleCountError` if the gamut has no such level, and `GamutDamagedError` if the
        history file is damaged.
        """
        search, history = opened.gamut.search, opened.gamut.history
        known = search.find_known(request)
        if known is not None or request.limits is None:
            return known or search.find(history, request)
        return await self._search(opened, request, lambda: search.find(history, request))

    async def curve(self, gamut_id: str, side: Side, client: str) -> list[LevelError]:
        """Return the error curve of one side, `inside` or `outside`.

        Raise `GamutDamagedError` if the history file is damaged.
        """
        record = await self.record(gamut_id)
        request = LevelRequest(max_error=0.0, side=side)

        def need() -> int:
            search = self._search_of(gamut_id)
            is_known = search is not None and search.known_curve(side) is not None
            return 0 if is_known else self._find_need(record, request)

        with await self.admission.place(Work.VIEW, client, need, need()):
            opened = await self.open(gamut_id)
            search, history = opened.gamut.search, opened.gamut.history
            known = search.known_curve(side)
            if known is None:
                known = await self._search(opened, side, lambda: search.curve(history, side))
                self.keep(opened)
            return known

    def _search_of(self, gamut_id: str) -> LevelSearch | None:
        """Return the search for levels of a gamut that is or was open; else None."""
        search = self._searches.get(gamut_id)
        if search is None and gamut_id in self._used:
            search = self._used[gamut_id].gamut.search
        return search

    async def _search(
        self, opened: OpenGamut, wanted: LevelRequest | Side, find: Callable[[], T]
    ) -> T:
        """Find a result in a thread, once for all that want it."""

        async def unpack_and_find() -> T:
            await self.unpack(opened, opened.gamut.history.triangles)
            with timed("choose"):
                return await self.in_thread(find)

        key = opened.record.id, "search", wanted
        result: T = await self._flights.value(key, unpack_and_find)
        return result

    # --- indexed levels ---------------------------------------------------------------------------

    def need(self, wanted: Sequence[tuple[PublishedGamut, LevelRequest]]) -> int:
        """Return the bytes for `levels`."""
        return sum(0 if self._is_indexed(*each) else self._index_need(*each) for each in wanted)

    def largest_counts(self, wanted: Sequence[tuple[PublishedGamut, LevelRequest]]) -> int:
        """Return an upper bound of the triangles of `levels`."""
        return sum(min(_full_count(each[0]), self.largest_count(*each)) for each in wanted)

    async def levels(
        self, wanted: Sequence[tuple[PublishedGamut, LevelRequest]]
    ) -> list[QueryLevel]:
        """Return one level per gamut, indexed. The caller holds the bytes; see `need`.

        Raise `TriangleCountError` if a gamut has no such level, and `GamutDamagedError` if a
        history file is damaged.
        """
        return [await self._indexed(*each) for each in wanted]

    def _index_need(self, record: PublishedGamut, request: LevelRequest) -> int:
        full = _full_count(record)
        triangles = min(full, self.largest_count(record, request))
        finding = self._find_need(record, request)
        if all(level["triangles"] != triangles for level in record.description["levels"]):
            # its error bound needs a comparison with the full boundary
            finding = max(finding, needed_bytes(unpacked=self.unpacked(record, full)))
        return finding + needed_bytes(prepared=triangles)

    def _is_indexed(self, record: PublishedGamut, request: LevelRequest) -> bool:
        """Return whether a level is there, or others make it."""
        if (record.id, "index", request) in self._flights:
            return True
        opened = self._used.get(record.id)
        return opened is not None and _find_indexed(opened, request) is not None

    async def _indexed(self, record: PublishedGamut, request: LevelRequest) -> QueryLevel:
        opened = self._find_open(record.id)
        ready = None if opened is None else _find_indexed(opened, request)
        if ready is not None:
            return ready
        made: QueryLevel = await self._flights.value(
            (record.id, "index", request), lambda: self._index(record, request)
        )
        return made

    async def _index(self, record: PublishedGamut, request: LevelRequest) -> QueryLevel:
        opened = await self.open(record.id)
        triangles, _ = await self.find(opened, request)
        search, history = opened.gamut.search, opened.gamut.history
        # The error bound may need a comparison with the full boundary.
        known = search.find_error_bound(triangles)
        await self.unpack(opened, history.triangles if known is None else triangles)
        with timed("index"):
            await self.in_thread(opened.gamut.levels.level, triangles)
            max_error = await self.in_thread(search.error_bound, history, triangles)
        self.keep(opened)
        return QueryLevel(opened.gamut, triangles, max_error, opened.holding)

    # --- encoded levels ---------------------------------------------------------------------------

    def _find_mesh(
        self, gamut_id: str, request: LevelRequest, format_name: str, coding: str = IDENTITY
    ) -> EncodedLevel | None:
        """Return a mesh that is cached or takes at most about a millisecond to encode; else None.

        The level must exist, and be found and unpacked already. `coding` is one of `CODINGS`, or
        `IDENTITY`. The caller has the gamut's record.
        """
        opened = self._find_open(gamut_id)
        level = self.find_known(gamut_id, request)
        if level is None:
            return None
        triangles = level.triangles
        key = EncodedKey(gamut_id, triangles, format_name, coding, request.side)
        mesh = self._encoded.get(key)
        if mesh is None:
            small = request.side == "both" and triangles <= INLINE_TRIANGLES.get(format_name, 0)
            if opened is None or not small or not opened.gamut.history.is_unpacked(triangles):
                return None
            made = encode_level(opened, key, self._encoded.get(key.plain))
            mesh = self._keep_encoded(made, opened)[key]
            self.admission.shrink_caches()
        return mesh if request.limits is None else mesh.with_bounds(level.bounds)

    async def mesh(
        self,
        gamut_id: str,
        request: LevelRequest,
        format_name: str,
        coding: str = IDENTITY,
        client: str = "",
    ) -> EncodedLevel:
        """Return a mesh for a client. `coding` is one of `CODINGS`, or `IDENTITY`.

        Raise `GamutNotStoredError` if the gamut is missing or damaged, and `TriangleCountError` if
        it has no such level.
        """
        record = None if self._store.is_current(gamut_id) else await self.record(gamut_id)
        ready = self._find_mesh(gamut_id, request, format_name, coding)
        if ready is not None:
            return ready
        record = record or await self.record(gamut_id)
        full = _full_count(record)

        def need() -> int:
            level = self.find_known(gamut_id, request)
            if level is not None:  # others may have made the mesh meanwhile
                key = EncodedKey(gamut_id, level.triangles, format_name, coding, request.side)
                if self._encoded.get(key) is not None:
                    return 0
            triangles = _ENCODED * min(full, self.largest_count(record, request))
            triangles += 0 if request.side == "both" else _SIDED * full
            return self._find_need(record, request) + needed_bytes(prepared=triangles)

        with await self.admission.place(Work.VIEW, client, need, need()):
            opened = await self.open(gamut_id)
            triangles, bounds = await self.find(opened, request)
            key = EncodedKey(gamut_id, triangles, format_name, coding, request.side)
            mesh = await self._encode(opened, key)
        return mesh if request.limits is None else mesh.with_bounds(bounds)

    async def picture(
        self, gamut_id: str, request: LevelRequest, options: PictureOptions, most: int, client: str
    ) -> EncodedLevel:
        """Return a picture of a level of at most `most` triangles; raises as `mesh` does."""
        record = await self.record(gamut_id)
        request = request.or_default(min(PICTURE_TRIANGLES, _full_count(record)))

        def need() -> int:
            triangles = min(most, self.largest_count(record, request))
            if self._encoded.get(EncodedKey(gamut_id, triangles, options)) is not None:
                return 0
            drawing = needed_bytes(prepared=triangles, pixels=_DRAWN_PIXELS * options.size**2)
            return self._find_need(record, request) + drawing

        with await self.admission.place(Work.VIEW, client, need, need()):
            opened = await self.open(gamut_id)
            count, _ = await self.find(opened, request)
            if count > most:
                raise TriangleCountError(
                    f"This error limit needs {count} triangles. A picture has at most {most}.",
                    where={"field": "max_error"},
                    remedy=f"Give a larger limit, or up to {most} triangles.",
                )
            return await self._encode(opened, EncodedKey(gamut_id, count, options))

    async def _encode(self, opened: OpenGamut, key: EncodedKey) -> EncodedLevel:
        """Return an encoded level from the cache, or make and keep it."""

        async def encode() -> EncodedLevel:
            plain = self._encoded.get(key.plain)
            if plain is not None and key == key.plain:
                return plain  # `_find_mesh` has encoded it since the last look
            # a level on one side is compared with the full boundary
            needed = key.triangles if key.side == "both" else opened.gamut.history.triangles
            await self.unpack(opened, needed)
            made = await self.in_thread(encode_level, opened, key, plain)
            return self._keep_encoded(made, opened)[key]

        encoded = self._encoded.get(key)
        if encoded is None:
            encoded = await self._flights.value(key, encode)
        self.keep(opened)
        return encoded

    def _keep_encoded(
        self, made: dict[EncodedKey, EncodedLevel], opened: OpenGamut
    ) -> dict[EncodedKey, EncodedLevel]:
        """Count encoded levels; keep them unless the gamut was deleted or renamed meanwhile."""
        levels = {}
        for key, level in made.items():
            nbytes = len(level.body) + _ENTRY_BYTES
            levels[key] = replace(level, holding=self.admission.hold("meshes", nbytes))
            if self._used.get(key.gamut_id) is opened:
                self._encoded.put(key, levels[key], nbytes)
        return levels


def _full_count(record: PublishedGamut) -> int:
    """Return the triangle count of the full boundary."""
    full: int = record.description["counts"]["triangles"]
    return full


def _find_indexed(opened: OpenGamut, request: LevelRequest) -> QueryLevel | None:
    """Return a level for queries if it is in memory; else None."""
    gamut = opened.gamut
    known = gamut.search.find_known(request)
    if known is None or not gamut.levels.has(known.triangles):
        return None
    max_error = gamut.search.find_error_bound(known.triangles)
    if max_error is None:
        return None
    return QueryLevel(gamut, known.triangles, max_error, opened.holding)
