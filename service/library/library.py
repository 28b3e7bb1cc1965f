"""The library: open gamuts, and the levels, indexes and encoded answers that are made of them.

`Library` opens a gamut, finds the level of a request, indexes or encodes it, and keeps what it made
in caches that are bounded in bytes. Simultaneous requests for the same work share it. The memory
for a whole request is charged first, see `service.library.memory`.

Opening blocks on the store, unpacking takes up to tens of milliseconds, and a search for a limit
0.02 to 0.5 s (seconds for more than a million triangles). All this runs in a few threads, and one
search at a time, so that other requests keep the other threads and cores. Small levels that are
unpacked are encoded on the event loop in about a millisecond. Everything here belongs to the event
loop's thread.
"""

from __future__ import annotations

import asyncio
import contextlib
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple, ParamSpec, TypeVar
from weakref import WeakValueDictionary

import numpy as np

from gamutcore.building import device_model
from gamutcore.colours.spaces import ColourSpace
from gamutcore.errors import DeviceModelError, HistoryFileError, TriangleCountError
from gamutcore.export.provenance import mesh_provenance
from gamutcore.export.rendering import PICTURE_TRIANGLES
from gamutcore.gamut import Gamut
from gamutcore.history import MINIMUM_TRIANGLES
from gamutcore.levels import BoundedLevel, LevelRequest, LevelSearch
from gamutcore.limits import Limits
from gamutcore.questions import INDEX_BYTES, black_rule
from service.concurrency import SingleFlight, Threads
from service.http.representations import IDENTITY
from service.http.request_context import timed
from service.library.encoding import (
    INLINE_TRIANGLES,
    EncodedKey,
    EncodedLevel,
    PictureOptions,
    encode_level,
    encoding_cost,
)
from service.library.memory import ByteBoundedCache, Charge, Cost
from service.storage.blobs import BlobNotFoundError, StoreFullError, StoreUnavailableError
from service.storage.names import display_name

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Sequence

    from gamutcore.levels import LevelError, Side
    from service.library.memory import Ledger
    from service.storage.gamuts import GamutStore
    from service.storage.published import PublishedGamut

__all__ = ["Library", "OpenGamut", "QueryLevel"]

P = ParamSpec("P")
T = TypeVar("T")

_SEARCH_BYTES = 32 * 1024 * 1024
"""Bytes for searches with what they have found, enough for a thousand gamuts. They stay when the
histories, which are a hundred times as large, leave the memory."""

_ENTRY_BYTES = 1024
"""Approximate memory of an encoded level besides the content: key, header fields, bookkeeping."""

_THREADS = 2
"""Number of histories that are opened or unpacked, and large levels that are encoded, at the same
time."""


@dataclass(frozen=True)
class OpenGamut:
    """A gamut in memory, with its record, history and charge.

    A newer gamut with another record may have the same id. `provenance` is for mesh files, `space`
    is the space of the coordinates, and `name` is for the names of files.
    """

    record: PublishedGamut
    gamut: Gamut
    provenance: dict[str, str]
    space: ColourSpace
    name: str
    charge: Charge = field(repr=False)


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


class Library:
    """The gamuts of a store, and what is made of them.

    `memory` accounts for everything. The caches have open gamuts with the indexes of their levels
    (up to `gamut_bytes`, of which `index_bytes` are for the indexes of one gamut), encoded levels
    (up to `mesh_bytes`), and the searches for levels, also of closed gamuts. `searching` counts
    the searches under way: one that runs, and those that wait for it.
    """

    def __init__(
        self,
        store: GamutStore,
        memory: Ledger,
        gamut_bytes: int,
        mesh_bytes: int,
        index_bytes: int = INDEX_BYTES,
    ) -> None:
        self.memory = memory
        self.searching = 0
        self._store = store
        self._index_bytes = index_bytes
        self._open: ByteBoundedCache[str, OpenGamut] = ByteBoundedCache(gamut_bytes)
        self._encoded: ByteBoundedCache[EncodedKey, EncodedLevel] = ByteBoundedCache(mesh_bytes)
        self._searches: ByteBoundedCache[str, LevelSearch] = ByteBoundedCache(_SEARCH_BYTES)
        memory.add(self._open)
        memory.add(self._encoded)
        # Also those in use that have left the cache: opening them again would double their memory.
        self._used: WeakValueDictionary[str, OpenGamut] = WeakValueDictionary()
        self._flights: SingleFlight[tuple[Hashable, ...], Any] = SingleFlight()
        self._threads = Threads(_THREADS, "library")
        self._turn = asyncio.Semaphore(1)

    @property
    def caches(self) -> dict[str, ByteBoundedCache[Any, Any]]:
        """The caches by the names that metrics have for them."""
        return {"gamuts": self._open, "meshes": self._encoded, "tables": self._searches}

    async def in_thread(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Return the result of a function that is too slow for the event loop."""
        return await self._threads.run(0.0, function, *args, **kwargs)

    async def rename(self, gamut_id: str) -> None:
        """Read the name of a gamut again, and give its files the new name from now on."""
        opened = self._open.get(gamut_id) or self._used.get(gamut_id)
        if opened is None:
            self._flights.forget((gamut_id, "open"))
        else:
            stored = await self.in_thread(self._store.names.read, gamut_id)
            if self._used.get(gamut_id) is opened:
                self._open.discard(gamut_id)
                self._keep(replace(opened, name=display_name(opened.record, stored)))
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
        """Return a gamut's record; raises `GamutNotStoredError` if there is none."""
        with timed("store"):
            return await asyncio.to_thread(self._store.record, gamut_id)

    def find_open(self, gamut_id: str) -> OpenGamut | None:
        """Return a gamut if it is open; else None."""
        found = self._open.get(gamut_id)
        if found is None:
            found = self._used.get(gamut_id)
            if found is not None and not self.memory.waiting:
                # It had to give way while it was in use.
                self._keep(found)
        if found is not None:
            self._store.mark_used(gamut_id)
        return found

    async def gamut(self, gamut_id: str, charge: Charge | None = None) -> OpenGamut:
        """Return a gamut, after opening it if needed.

        A given `charge` includes `unpacking_cost`; otherwise the memory for opening is charged.
        Raise `GamutNotStoredError` if the gamut is missing or damaged.
        """
        found: OpenGamut | None = self.find_open(gamut_id)
        if found is None:
            found = await self._flights.value(
                (gamut_id, "open"), lambda: self._open_and_keep(gamut_id, charge)
            )
        return found

    async def load_device_model(self, gamut_id: str) -> OpenGamut:
        """Return a gamut with its device model and the inverse, from the store or from the input.

        The object stays the one in use while the caller keeps it.

        Raise `DeviceModelError` if the gamut is of colours only, or its input is gone, and
        `GamutNotStoredError` if the gamut is missing.
        """
        opened = await self.gamut(gamut_id)
        if opened.gamut.has_inverse:
            return opened
        if not opened.gamut.is_of_device:
            raise opened.gamut.no_device_model()
        patches = opened.gamut.description["provenance"].get("patches", {}).get("used", 0)
        cost = Cost.MODEL + Cost.PATCHES * patches**2

        async def load() -> None:
            with await self.memory.charge("work", lambda: cost) as charge:
                with timed("model"):
                    await self.in_thread(self._prepare_recipes, opened)
                self.settle(opened, charge)

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

    def unpacking_cost(self, record: PublishedGamut, triangles: int) -> int:
        """Return the peak memory of opening a gamut and unpacking an existing level."""
        opened = self._used.get(record.id)
        if opened is not None and opened.gamut.history.is_unpacked(triangles):
            return 0
        # Groups of splits double in size, and a level needs all of its last group.
        unpacked = min(_full_count(record), 2 * triangles)
        return Cost.UNPACK * unpacked + (0 if opened else Cost.FILE_BYTE * record.nbytes)

    async def unpack(self, opened: OpenGamut, triangles: int) -> None:
        """Unpack an existing level of an open gamut, so that it can be read.

        The caller has charged `unpacking_cost`, and calls `settle` in the end. Raise
        `GamutDamagedError` if the history file is damaged.
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

    def settle(self, opened: OpenGamut, charge: Charge) -> None:
        """Give a gamut the memory that it has grown by, out of the charge of the work on it."""
        gamut_id, nbytes, search = opened.record.id, opened.gamut.nbytes, opened.gamut.search
        opened.charge.shrink(nbytes)
        has_room = self.memory.raise_to(opened.charge, nbytes, charge)
        # Nothing is kept of a gamut that was deleted or renamed meanwhile.
        if self._used.get(gamut_id) is not opened:
            return
        if not has_room:
            self._open.discard(gamut_id)
        elif gamut_id in self._open or not self.memory.waiting:
            self._keep(opened)
        self._searches.put(gamut_id, search, search.nbytes)

    def _keep(self, opened: OpenGamut) -> None:
        self._used[opened.record.id] = opened
        self._open.put(opened.record.id, opened, opened.gamut.nbytes)

    async def _open_and_keep(self, gamut_id: str, charge: Charge | None) -> OpenGamut:
        if charge is None:
            record = await self.record(gamut_id)
            cost = Cost.FILE_BYTE * record.nbytes
            with await self.memory.charge("work", lambda: cost) as own:
                return await self._open_and_keep(gamut_id, own)
        with timed("open"):
            search = self._searches.get(gamut_id)
            opened = await self.in_thread(self._open_from_store, gamut_id, search)
        self.settle(opened, charge)
        # A gamut that was deleted while it was opened is returned but not kept.
        if self._flights.is_current((gamut_id, "open")):
            self._keep(opened)
        return opened

    def _open_from_store(self, gamut_id: str, search: LevelSearch | None) -> OpenGamut:
        record, content = self._store.content(gamut_id)
        try:
            gamut = Gamut.from_bytes(content, search=search, index_bytes=self._index_bytes)
        except HistoryFileError as error:
            raise self._store.set_aside(record, str(error)) from error
        provenance = mesh_provenance(gamut.description)
        name = display_name(record, self._store.names.read(gamut_id))
        charge = Charge(self.memory, "gamuts", 0)
        return OpenGamut(record, gamut, provenance, gamut.colour_space, name, charge)

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

    def finding_cost(self, record: PublishedGamut, request: LevelRequest) -> int:
        """Return the peak memory of opening a gamut, and of finding and unpacking a level."""
        full = _full_count(record)
        if request.side != "both":
            return self.unpacking_cost(record, full) + Cost.SIDE * full
        if request.limits is None or self.find_known(record.id, request):
            triangles = max(MINIMUM_TRIANGLES, min(full, self.largest_count(record, request)))
            return self.unpacking_cost(record, triangles)
        return self.unpacking_cost(record, full) + Cost.SEARCH * full

    async def find(self, opened: OpenGamut, request: LevelRequest) -> BoundedLevel:
        """Return a level, as `LevelSearch.find` does.

        Raise `TriangleCountError` if the gamut has no such level, and `GamutDamagedError` if the
        history file is damaged. The caller has charged `finding_cost`.
        """
        search, history = opened.gamut.search, opened.gamut.history
        known = search.find_known(request)
        if known is not None or request.limits is None:
            return known or search.find(history, request)
        return await self._search(
            opened,
            request,
            lambda: search.find_known(request),
            lambda: search.find(history, request),
        )

    async def curve(self, opened: OpenGamut, side: Side) -> list[LevelError]:
        """Return the error curve of one side, `inside` or `outside`.

        Raise `GamutDamagedError` if the history file is damaged.
        """
        search, history = opened.gamut.search, opened.gamut.history
        known = search.known_curve(side)
        if known is not None:
            return known
        request = LevelRequest(max_error=0.0, side=side)
        with await self.memory.charge(
            "work", lambda: self.finding_cost(opened.record, request)
        ) as charge:
            curve = await self._search(
                opened,
                side,
                lambda: search.known_curve(side),
                lambda: search.curve(history, side),
            )
            self.settle(opened, charge)
        return curve

    def _search_of(self, gamut_id: str) -> LevelSearch | None:
        """Return the search for levels of a gamut that is or was open; else None."""
        search = self._searches.get(gamut_id)
        if search is None and gamut_id in self._used:
            search = self._used[gamut_id].gamut.search
        return search

    async def _search(
        self,
        opened: OpenGamut,
        wanted: LevelRequest | Side,
        find_known: Callable[[], T | None],
        find: Callable[[], T],
    ) -> T:
        """Find a result in a thread, after the other searches."""

        async def find_in_turn() -> T:
            self.searching += 1
            try:
                with timed("wait"):
                    await self._turn.acquire()
                try:
                    result = find_known()  # the searches before this one may have found it
                    if result is None:
                        await self.unpack(opened, opened.gamut.history.triangles)
                        with timed("choose"):
                            result = await self.in_thread(find)
                finally:
                    self._turn.release()
            finally:
                self.searching -= 1
            return result

        key = opened.record.id, "search", wanted
        found: T = await self._flights.value(key, find_in_turn)
        return found

    # --- indexed levels ---------------------------------------------------------------------------

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
        counts = [min(_full_count(each[0]), self.largest_count(*each)) for each in wanted]
        answer = answer_bytes(sum(counts))
        costs = [
            self._indexing_cost(*each, count) for each, count in zip(wanted, counts, strict=True)
        ]

        def need() -> int:
            made = zip(wanted, costs, strict=True)
            return answer + sum(0 if self._is_indexed(*each) else cost for each, cost in made)

        charge = await self.memory.charge("work", need)
        levels = [await self._indexed(*each, charge) for each in wanted]
        charge.shrink(answer)
        return levels, charge

    def _indexing_cost(self, record: PublishedGamut, request: LevelRequest, triangles: int) -> int:
        """Return the peak memory of making an indexed level of at most so many triangles."""
        finding = self.finding_cost(record, request)
        if all(level["triangles"] != triangles for level in record.description["levels"]):
            # its error bound needs a comparison with the full boundary
            full = _full_count(record)
            finding = max(finding, self.unpacking_cost(record, full) + Cost.SEARCH * full)
        return finding + Cost.INDEX * triangles

    def _is_indexed(self, record: PublishedGamut, request: LevelRequest) -> bool:
        """Return whether a level is there, or others make it."""
        if (record.id, "index", request) in self._flights:
            return True
        opened = self._used.get(record.id)
        return opened is not None and _find_indexed(opened, request) is not None

    async def _indexed(
        self, record: PublishedGamut, request: LevelRequest, charge: Charge
    ) -> QueryLevel:
        opened = self.find_open(record.id)
        ready = None if opened is None else _find_indexed(opened, request)
        if ready is not None:
            return ready
        made: QueryLevel = await self._flights.value(
            (record.id, "index", request), lambda: self._index(record, request, charge)
        )
        return made

    async def _index(
        self, record: PublishedGamut, request: LevelRequest, charge: Charge
    ) -> QueryLevel:
        opened = await self.gamut(record.id, charge)
        triangles, _ = await self.find(opened, request)
        search, history = opened.gamut.search, opened.gamut.history
        # The error bound may need a comparison with the full boundary.
        known = search.find_error_bound(triangles)
        await self.unpack(opened, history.triangles if known is None else triangles)
        with timed("index"):
            await self.in_thread(opened.gamut.levels.level, triangles)
            max_error = await self.in_thread(search.error_bound, history, triangles)
        self.settle(opened, charge)
        return QueryLevel(opened.gamut, triangles, max_error, opened.charge)

    # --- encoded levels ---------------------------------------------------------------------------

    def find_mesh(
        self, gamut_id: str, request: LevelRequest, format_name: str, coding: str = IDENTITY
    ) -> EncodedLevel | None:
        """Return a mesh that is cached or takes at most about a millisecond to encode; else None.

        The level must exist, and be found and unpacked already. `coding` is one of `CODINGS`, or
        `IDENTITY`.
        """
        opened = self.find_open(gamut_id)
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
        return mesh if request.limits is None else mesh.with_bounds(level.bounds)

    async def mesh(
        self, gamut_id: str, request: LevelRequest, format_name: str, coding: str = IDENTITY
    ) -> EncodedLevel:
        """Return a mesh; parameters as for `find_mesh`.

        Raise `GamutNotStoredError` if the gamut is missing or damaged, and `TriangleCountError` if
        it has no such level.
        """
        ready = self.find_mesh(gamut_id, request, format_name, coding)
        if ready is not None:
            return ready
        record = await self.record(gamut_id)
        full = _full_count(record)

        def need() -> int:
            if self.find_mesh(gamut_id, request, format_name, coding) is not None:
                return 0
            triangles = min(full, self.largest_count(record, request))
            side = 0 if request.side == "both" else Cost.SIDE * full
            encoding = encoding_cost(format_name, triangles)
            return self.finding_cost(record, request) + encoding + side

        with await self.memory.charge("work", need) as charge:
            opened = await self.gamut(gamut_id, charge)
            triangles, bounds = await self.find(opened, request)
            key = EncodedKey(gamut_id, triangles, format_name, coding, request.side)
            mesh = await self._encode(opened, key, charge)
        return mesh if request.limits is None else mesh.with_bounds(bounds)

    async def picture(
        self, gamut_id: str, request: LevelRequest, options: PictureOptions, most: int
    ) -> EncodedLevel:
        """Return a picture of a level of at most `most` triangles; raises as `mesh` does."""
        record = await self.record(gamut_id)
        request = request.or_default(min(PICTURE_TRIANGLES, _full_count(record)))

        def need() -> int:
            triangles = min(most, self.largest_count(record, request))
            if self._encoded.get(EncodedKey(gamut_id, triangles, options)) is not None:
                return 0
            return self.finding_cost(record, request) + encoding_cost(options, triangles)

        with await self.memory.charge("work", need) as charge:
            opened = await self.gamut(gamut_id, charge)
            count, _ = await self.find(opened, request)
            if count > most:
                raise TriangleCountError(
                    f"This error limit needs {count} triangles. A picture has at most {most}.",
                    where={"field": "max_error"},
                    remedy=f"Give a larger limit, or up to {most} triangles.",
                )
            return await self._encode(opened, EncodedKey(gamut_id, count, options), charge)

    async def _encode(self, opened: OpenGamut, key: EncodedKey, charge: Charge) -> EncodedLevel:
        """Return an encoded level from the cache, or make and keep it."""

        async def encode() -> EncodedLevel:
            plain = self._encoded.get(key.plain)
            if plain is not None and key == key.plain:
                return plain  # `find_mesh` has encoded it since the last look
            # a level on one side is compared with the full boundary
            needed = key.triangles if key.side == "both" else opened.gamut.history.triangles
            await self.unpack(opened, needed)
            made = await self.in_thread(encode_level, opened, key, plain)
            return self._keep_encoded(made, opened, charge)[key]

        encoded = self._encoded.get(key)
        if encoded is None:
            encoded = await self._flights.value(key, encode)
        self.settle(opened, charge)
        return encoded

    def _keep_encoded(
        self,
        made: dict[EncodedKey, EncodedLevel],
        opened: OpenGamut,
        charge: Charge | None = None,
    ) -> dict[EncodedKey, EncodedLevel]:
        """Charge encoded levels; keep them unless the gamut was deleted or renamed meanwhile."""
        kept = {}
        for key, level in made.items():
            nbytes = len(level.body) + _ENTRY_BYTES
            own = Charge(self.memory, "meshes", 0)
            has_room = self.memory.raise_to(own, nbytes, charge)
            kept[key] = replace(level, charge=own)
            if has_room and self._used.get(key.gamut_id) is opened:
                self._encoded.put(key, kept[key], nbytes)
        return kept


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
    return QueryLevel(gamut, known.triangles, max_error, opened.charge)
