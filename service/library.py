"""The library: open gamuts, and the memory of everything that is made of them.

The `Ledger` charges memory before it is allocated. A request takes one charge for everything that
it will need. A request that waits holds no gamut, and a request that holds a charge never waits for
another. So no two requests can wait for each other. Values that stay in a cache take their memory
over from the charge. When there is no room, caches first give up the least recently used values of
all. Then work waits, and is refused in the end.

`Library` opens gamuts, once for simultaneous requests. Opening blocks on the store, and unpacking a
level takes up to tens of milliseconds, so both run in a few threads. Everything here belongs to the
event loop's thread, unless stated otherwise. See ``docs/decisions/memory-budget.md``.
"""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import os
from collections import Counter, deque
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ParamSpec, Self, TypeVar
from weakref import WeakValueDictionary

from starlette.responses import Response

from gamutcore.colours.spaces import ColourSpace
from gamutcore.errors import HistoryFileError
from gamutcore.export.provenance import mesh_provenance
from gamutcore.gamut import Gamut
from gamutcore.questions import INDEX_BYTES
from service.caching.byte_bounded_cache import ByteBoundedCache
from service.caching.single_flight import SingleFlight
from service.http.request_context import timed
from service.problems.problem import Problem, ProblemError
from service.storage.names import display_name

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from types import TracebackType

    from starlette.types import Receive, Scope, Send

    from gamutcore.levels import LevelSearch
    from service.settings import Settings
    from service.storage.gamuts import GamutStore
    from service.storage.published import PublishedGamut

__all__ = [
    "PROCESS_BYTES",
    "Charge",
    "ChargedResponse",
    "Cost",
    "Ledger",
    "Library",
    "OpenGamut",
    "keep_heap_small",
    "memory_budget",
]

P = ParamSpec("P")
T = TypeVar("T")

_MEBIBYTE = 1024 * 1024

PROCESS_BYTES = 224 * _MEBIBYTE
"""Memory of a process without gamuts: interpreter, libraries and kernels. Resident after start and
80 builds: 220 MB."""

LEAST_BUDGET = 448 * _MEBIBYTE
"""Smallest default of the budget: the process, and two full boundaries of a press in comparison."""

SHARE = 0.6
"""Default share of the memory of the container or computer. The rest is for other processes, bodies
and the page cache."""

PATIENCE = 30.0
"""Seconds for which work waits for memory: half of the time after which most proxies give up."""

MOST_WAITING = 256
"""Requests that wait for memory. They hold no gamut, only what the client has sent."""

SMALL = 1 / 64
"""Share of the budget up to which work passes waiting work that needs more."""

FREE_BYTES = 64 * 1024
"""Work up to this size is not charged, so that single colours and cached answers never wait."""

_TRIM_BYTES = 32 * _MEBIBYTE
"""Released bytes after which the heap's free pages go back to the system."""

_TRIM_SECONDS = 1.0
"""Delay after such a release, so that a burst of releases is followed by one trim."""

_SEARCH_BYTES = 32 * _MEBIBYTE
"""Bytes for searches with what they have found, enough for a thousand gamuts. They stay when the
histories, which are a hundred times as large, leave the memory."""

_THREADS = 2
"""Number of histories that are opened or unpacked, and large meshes that are encoded, at the same
time."""


class Cost:
    """Peak memory of each step in bytes.

    The figures are the growth of VmHWM during the step, rounded up: full boundary of FOGRA39L
    (145,728 triangles, four channels), kernels loaded. ``tests/faults/memory_attacks.py`` tests
    that the sums hold.
    """

    FILE_BYTE = 3
    """Opening, per byte of the file: the file, a copy while the digest is checked, the streams."""
    UNPACK = 190
    """Unpacking, per triangle; 120 of them stay."""
    SEARCH = 75
    """Search for a limit, per triangle of the full boundary."""
    SIDE = 300
    """Search or level on one side, per triangle of the full boundary."""
    INDEX = 410
    """Index of a level and its comparison with the full boundary, per triangle of the level; 280 of
    them stay. The index alone peaks at 350."""
    FORMAT: Mapping[str, int] = MappingProxyType(
        {"glb": 140, "gltf": 280, "ply": 170, "stl": 390, "obj": 350, "3mf": 690, "gam": 430}
    )
    """Encoding, per triangle, with the content."""
    OTHER_FORMAT = 200
    """The same for ICC (134) and CGE."""
    CODING = 65
    """Compressing an encoded mesh, per triangle: 1.3 times the content of STL, which is largest."""
    PICTURE = 400
    """Drawing, per triangle."""
    PIXEL = 64
    """Drawing, per pixel."""
    PAGE = 200
    """Writing a page with the history, per triangle of the full boundary; 12 are the page."""
    PAGE_BASE = 4 * _MEBIBYTE
    """The viewer in the page, and its compression."""
    COMPARISON = 40
    """Comparing gamuts, per triangle of both levels; sections and their pictures take 20."""
    CELL = 850
    """Answer to a view, per cell or row: leaves as JSON."""
    ROW: Mapping[str, int] = MappingProxyType(
        {"application/json": 1500, "application/x-npy": 350, "text/csv": 700}
    )
    """Answer to a query, per row that is answered at once, by media type: nearest, which has the
    most columns. JSON of a table has labels, lines and colours beside."""


def memory_budget(settings: Settings, root: Path = Path("/")) -> int:
    """Return the largest memory of the API process in bytes: the setting, or a default.

    The default is 60 % of the smallest cgroup limit (v2 and v1) or of the computer's memory, less
    the build workers' limits, at least `LEAST_BUDGET`. `root` has ``proc`` and ``sys``.
    """
    if settings.memory_bytes:
        return settings.memory_bytes
    workers = 0 if settings.broker else settings.build_workers * settings.build_memory_bytes
    return max(LEAST_BUDGET, int(SHARE * _available_memory(root)) - workers)


def _available_memory(root: Path) -> int:
    """Return the smallest limit of this process's cgroups, or the memory of the computer."""
    limits = [
        int(line.split()[1]) * 1024
        for line in _lines(root / "proc/meminfo")
        if line.startswith("MemTotal:")
    ]
    for line in _lines(root / "proc/self/cgroup"):
        _, controllers, path = line.split(":", 2)
        if controllers and "memory" not in controllers.split(","):
            continue
        mount = "sys/fs/cgroup/memory" if controllers else "sys/fs/cgroup"
        name = "memory.limit_in_bytes" if controllers else "memory.max"
        # A parent may have the limit. Inside a container, the path may not exist below the mount.
        folder = root / mount / path.lstrip("/")
        for each in (folder, *folder.parents[: len(Path(path).parts)]):
            limits += [int(text) for text in _lines(each / name) if text.isdigit()]
    return min(limits, default=0)


def _lines(path: Path) -> list[str]:
    try:
        return path.read_text("ascii", "replace").splitlines()
    except OSError:
        return []


class Charge:
    """Charged memory. It is released once: by `release`, or when nobody refers to it any more."""

    def __init__(self, ledger: Ledger, kind: str, nbytes: int) -> None:
        self._ledger = ledger
        self.kind = kind
        self.nbytes = nbytes

    def shrink(self, nbytes: int) -> None:
        """Release all but some bytes."""
        released, self.nbytes = max(0, self.nbytes - nbytes), min(nbytes, self.nbytes)
        if released:
            self._ledger.give_back(self.kind, released)

    def release(self) -> None:
        """Release all bytes."""
        self.shrink(0)

    def move(self, other: Charge, nbytes: int) -> None:
        """Give another charge up to `nbytes` bytes of this one."""
        moved = max(0, min(self.nbytes, nbytes))
        self.nbytes -= moved
        other.nbytes += moved
        self._ledger.charged[self.kind] -= moved
        self._ledger.charged[other.kind] += moved

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.release()

    def __del__(self) -> None:
        if self.nbytes:
            self._ledger.forget(self.kind, self.nbytes)


class ChargedResponse(Response):
    """A complete response, whose memory stays charged until it is sent."""

    def __init__(self, response: Response, charge: Charge) -> None:
        super().__init__(response.body, response.status_code)
        self.raw_headers = response.raw_headers
        charge.shrink(len(response.body))
        self.charge = charge

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the response."""
        with self.charge:
            await super().__call__(scope, receive, send)


@dataclass
class _Waiter:
    """Work that waits for memory."""

    kind: str
    need: Callable[[], int]
    share: float
    granted: asyncio.Future[Charge]


class Ledger:
    """Memory that is charged before it is allocated, up to a budget in bytes.

    Work waits for `patience` seconds, for `most_waiting` requests at most. `charged` holds bytes by
    kind, and `refused` counts refused requests.
    """

    def __init__(
        self, budget: int, *, patience: float = PATIENCE, most_waiting: int = MOST_WAITING
    ) -> None:
        self.budget = budget
        self.charged: Counter[str] = Counter()
        self.refused = 0
        self._patience = patience
        self._most_waiting = most_waiting
        self._caches: list[ByteBoundedCache[Any, Any]] = []
        self._waiters: deque[_Waiter] = deque()
        # Appended to by any thread, and in the midst of anything: whoever drops the last reference.
        self._forgotten: deque[tuple[str, int]] = deque()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._admitting = False
        self._freed = 0
        self._trim: asyncio.TimerHandle | None = None

    @property
    def total(self) -> int:
        """Charged bytes of all kinds."""
        return self.charged.total()

    @property
    def waiting(self) -> int:
        """Number of waiting requests."""
        return len(self._waiters)

    def add(self, cache: ByteBoundedCache[Any, Any]) -> None:
        """Let a cache give way to work. Its values hold the charges of their memory."""
        self._caches.append(cache)

    async def charge(self, kind: str, need: Callable[[], int], share: float = 1.0) -> Charge:
        """Charge memory, waiting if needed; refuse with ``memory-exceeded`` or ``memory-busy``.

        `need` returns the bytes, and is called again during the wait, because others may do a part
        of the work. Work that waits for other charges while it holds this one has a `share` of the
        budget below 1.
        """
        self._loop = asyncio.get_running_loop()
        nbytes = self._checked(need(), share)
        if nbytes <= FREE_BYTES:
            return Charge(self, kind, 0)
        may_pass = not self._waiters or nbytes <= SMALL * self.budget
        if may_pass and self._has_room(kind, nbytes, share):
            return self._grant(kind, nbytes)
        if len(self._waiters) >= self._most_waiting:
            raise self._refusal()
        try:
            with timed("memory"):
                async with asyncio.timeout(self._patience):
                    while True:
                        charge = await self._wait(kind, need, share)
                        # Another may have lost meanwhile what the work counted on.
                        if need() <= charge.nbytes:
                            return charge
                        charge.release()
        except TimeoutError:
            raise self._refusal() from None

    async def _wait(self, kind: str, need: Callable[[], int], share: float) -> Charge:
        loop = asyncio.get_running_loop()
        waiter = _Waiter(kind, need, share, loop.create_future())
        self._waiters.append(waiter)
        self._admit_soon()
        try:
            return await waiter.granted
        finally:
            # Whatever was granted to work that goes away at the same time is released with it.
            with contextlib.suppress(ValueError):
                self._waiters.remove(waiter)
            self._admit_soon()

    def raise_to(self, charge: Charge, nbytes: int, source: Charge | None = None) -> bool:
        """Raise a charge that stays to `nbytes`, out of the charge of the work that made the value.

        If `source` is too small, the caches make room. False: there is not enough.
        """
        if source is not None:
            source.move(charge, nbytes - charge.nbytes)
        more = nbytes - charge.nbytes
        if more > 0 and not self._make_room(more):
            return False
        self.charged[charge.kind] += max(0, more)
        charge.nbytes = max(nbytes, charge.nbytes)
        return True

    def give_back(self, kind: str, nbytes: int) -> None:
        """Release memory; called by its charge."""
        self._count_freed(kind, nbytes)
        self._admit_soon()

    def forget(self, kind: str, nbytes: int) -> None:
        """Release memory whose charge nobody refers to any more. Any thread may call it."""
        self._forgotten.append((kind, nbytes))
        if self._loop is not None:
            with contextlib.suppress(RuntimeError):  # the loop is closed
                self._loop.call_soon_threadsafe(self._admit_soon)

    def _grant(self, kind: str, nbytes: int) -> Charge:
        self.charged[kind] += nbytes
        return Charge(self, kind, nbytes)

    def _has_room(self, kind: str, nbytes: int, share: float) -> bool:
        of_kind = self.charged[kind] + nbytes
        return (share >= 1.0 or of_kind <= share * self.budget) and self._make_room(nbytes)

    def _make_room(self, nbytes: int) -> bool:
        """Return whether some bytes can be charged, after the caches gave way if needed."""
        self._collect()
        while self.total + nbytes > self.budget:
            filled = [cache for cache in self._caches if len(cache)]
            if not filled:
                return False
            min(filled, key=lambda cache: cache.oldest_use).evict()
            self._collect()
        return True

    def _collect(self) -> None:
        while self._forgotten:
            self._count_freed(*self._forgotten.popleft())

    def _count_freed(self, kind: str, nbytes: int) -> None:
        self.charged[kind] -= nbytes
        self._freed += nbytes
        if self._freed >= _TRIM_BYTES and self._trim is None and self._loop is not None:
            with contextlib.suppress(RuntimeError):  # the loop is closed
                self._trim = self._loop.call_later(_TRIM_SECONDS, self._trim_heap)

    def _trim_heap(self) -> None:
        self._trim, self._freed = None, 0
        if self._loop is not None:
            self._loop.run_in_executor(None, _return_free_pages)

    def _admit_soon(self) -> None:
        """Look at the waiting work once for all releases of this turn of the event loop."""
        changed = self._waiters or self._forgotten
        if changed and not self._admitting and self._loop is not None:
            self._admitting = True
            self._loop.call_soon(self._admit)

    def _admit(self) -> None:
        """Let the work that has waited longest go on, and small work that has room."""
        self._admitting = False
        self._collect()
        passing = False
        for waiter in list(self._waiters):
            if waiter.granted.done():
                continue
            try:
                nbytes = self._checked(waiter.need(), waiter.share)
            except Exception as error:  # noqa: BLE001 - belongs to the work that waits
                waiter.granted.set_exception(error)
                continue
            if passing and nbytes > SMALL * self.budget:
                continue
            if self._has_room(waiter.kind, nbytes, waiter.share):
                self._waiters.remove(waiter)
                waiter.granted.set_result(self._grant(waiter.kind, nbytes))
            else:
                passing = True

    def _checked(self, nbytes: int, share: float) -> int:
        most = int(share * self.budget)
        if nbytes <= most:
            return nbytes
        self.refused += 1
        detail = f"The request needs {nbytes} bytes of memory; the service has {most}."
        raise ProblemError(Problem("memory-exceeded", detail))

    def _refusal(self) -> ProblemError:
        self.refused += 1
        detail = (
            f"{self.total} of {self.budget} bytes are in use, and {self.waiting} requests wait."
        )
        return ProblemError(Problem("memory-busy", detail, headers={"Retry-After": "5"}))


def keep_heap_small() -> None:
    """Let glibc give large arrays back to the system as soon as they are free (mallopt(3)).

    Otherwise glibc raises the size from which it does so up to 32 MB, and has an arena per thread.
    Bodies in pieces of up to 256 kB would then fragment the heap.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if os.name == "posix" else None
    if mallopt is not None:
        for parameter, value in ((_M_MMAP_THRESHOLD, _LARGE_BYTES), (_M_ARENA_MAX, 2)):
            mallopt(parameter, value)


_M_MMAP_THRESHOLD, _M_ARENA_MAX = -3, -8  # malloc.h

_LARGE_BYTES = 128 * 1024
"""Size from which memory is not taken from the heap: glibc's own, which it would raise."""


def _return_free_pages() -> None:
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if os.name == "posix" else None
    if trim is not None:
        trim(0)


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


class Library:
    """Opens gamuts of a store and keeps the most recently used, up to `capacity` bytes.

    `memory` accounts for everything that is made of gamuts. `index_bytes` is the memory for the
    indexed levels of one gamut. `searches` has the searches for levels, also of closed gamuts.
    """

    def __init__(
        self, store: GamutStore, memory: Ledger, capacity: int, index_bytes: int = INDEX_BYTES
    ) -> None:
        self.memory = memory
        self.searches: ByteBoundedCache[str, LevelSearch] = ByteBoundedCache(_SEARCH_BYTES)
        self._index_bytes = index_bytes
        self._store = store
        self._open: ByteBoundedCache[str, OpenGamut] = ByteBoundedCache(capacity)
        memory.add(self._open)
        # Also those in use that have left the cache: opening them again would double their memory.
        self._used: WeakValueDictionary[str, OpenGamut] = WeakValueDictionary()
        self._opening: SingleFlight[str, OpenGamut] = SingleFlight()
        self._threads = ThreadPoolExecutor(_THREADS, thread_name_prefix="library")

    @property
    def cache(self) -> ByteBoundedCache[str, OpenGamut]:
        """The open gamuts."""
        return self._open

    def find_open(self, gamut_id: str) -> OpenGamut | None:
        """Return a gamut if it is open; else None."""
        found = self._open.get(gamut_id)
        if found is None:
            found = self._used.get(gamut_id)
            if found is not None:
                self._return_to_cache(found)
        if found is not None:
            self._store.mark_used(gamut_id)
        return found

    def peek(self, gamut_id: str) -> OpenGamut | None:
        """Return a gamut if it is open, without counting a use."""
        return self._used.get(gamut_id)

    def search(self, gamut_id: str) -> LevelSearch | None:
        """Return the search for levels of a gamut that is or was open; else None."""
        search = self.searches.get(gamut_id)
        if search is None and gamut_id in self._used:
            search = self._used[gamut_id].gamut.search
        return search

    async def gamut(self, gamut_id: str, charge: Charge | None = None) -> OpenGamut:
        """Return a gamut, after opening it if needed.

        A given `charge` includes `unpacking_cost`; otherwise the memory for opening is charged.
        Raise `GamutNotStoredError` if the gamut is missing or damaged.
        """
        found = self.find_open(gamut_id)
        if found is not None:
            return found
        return await self._opening.value(gamut_id, lambda: self._open_and_keep(gamut_id, charge))

    def unpacking_cost(self, record: PublishedGamut, triangles: int) -> int:
        """Return the peak memory of opening a gamut and unpacking an existing level."""
        opened = self._used.get(record.id)
        if opened is not None and opened.gamut.history.is_unpacked(triangles):
            return 0
        # Groups of splits double in size, and a level needs all of its last group.
        full: int = record.description["counts"]["triangles"]
        unpacked = min(full, 2 * triangles)
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
                self._forget(opened)
                if not isinstance(error, HistoryFileError):
                    raise
                reason = str(error)
                raise await self.in_thread(self._store.set_aside, record, reason) from error

    def settle(self, opened: OpenGamut, charge: Charge) -> None:
        """Give a gamut the memory that it has grown by, out of the charge of the work on it."""
        nbytes = opened.gamut.nbytes
        opened.charge.shrink(nbytes)
        if not self.memory.raise_to(opened.charge, nbytes, charge):
            self._open.discard_value(opened.record.id, opened)
        elif not self._open.resize(opened.record.id, opened, nbytes):
            self._return_to_cache(opened)
        search = opened.gamut.search
        held = self.searches.resize(opened.record.id, search, search.nbytes)
        # Nothing is kept of a gamut that was deleted meanwhile.
        if not held and self.peek(opened.record.id) is opened:
            self.searches.put(opened.record.id, search, search.nbytes)

    async def record(self, gamut_id: str) -> PublishedGamut:
        """Return a gamut's record; raises `GamutNotStoredError` if there is none."""
        with timed("store"):
            return await asyncio.to_thread(self._store.record, gamut_id)

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
        opened = self._open.get(gamut_id) or self._used.get(gamut_id)
        if opened is None:
            self._opening.forget(gamut_id)
            return
        stored = await self.in_thread(self._store.names.read, gamut_id)
        if self._used.get(gamut_id) is opened:
            self._open.discard(gamut_id)
            renamed = replace(opened, name=display_name(opened.record, stored))
            self._keep(renamed)

    def discard(self, gamut_id: str) -> None:
        """Forget a deleted gamut."""
        self._open.discard(gamut_id)
        self.searches.discard(gamut_id)
        self._used.pop(gamut_id, None)
        self._opening.forget(gamut_id)

    def close(self) -> None:
        """End the threads."""
        self._threads.shutdown(wait=False, cancel_futures=True)

    def _keep(self, opened: OpenGamut) -> None:
        self._used[opened.record.id] = opened
        self._open.put(opened.record.id, opened, opened.gamut.nbytes)

    def _return_to_cache(self, opened: OpenGamut) -> None:
        """Put a gamut back that had to give way while it was in use, if nobody waits for room."""
        if self._used.get(opened.record.id) is opened and not self.memory.waiting:
            self._open.put(opened.record.id, opened, opened.gamut.nbytes)

    def _forget(self, opened: OpenGamut) -> None:
        self._open.discard_value(opened.record.id, opened)
        if self._used.get(opened.record.id) is opened:
            del self._used[opened.record.id]

    async def _open_and_keep(self, gamut_id: str, charge: Charge | None) -> OpenGamut:
        if charge is None:
            record = await self.record(gamut_id)
            cost = Cost.FILE_BYTE * record.nbytes
            with await self.memory.charge("work", lambda: cost) as own:
                return await self._open_and_keep(gamut_id, own)
        with timed("open"):
            search = self.searches.get(gamut_id)
            opened = await self.in_thread(self._open_from_store, gamut_id, search)
        self.settle(opened, charge)
        # A gamut that was deleted while it was opened is returned but not kept.
        if self._opening.is_current(gamut_id):
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
