"""The memory of everything that is made of gamuts: a ledger, and caches that give way to work.

The `Ledger` charges memory before it is allocated. A request takes one charge for everything that
it will need. A request that waits holds no gamut, and a request that holds a charge never waits for
another. So no two requests can wait for each other. Values that stay in a cache take their memory
over from the charge. When there is no room, caches first give up the least recently used values of
all. Then work waits, and is refused in the end.

Everything here belongs to the event loop's thread, unless stated otherwise. See
``docs/decisions/memory-budget.md``.
"""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import os
from collections import Counter, OrderedDict, deque
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar

from starlette.responses import Response

from service.http.request_context import timed
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Mapping
    from types import TracebackType

    from starlette.types import Receive, Scope, Send

    from service.settings import Settings

__all__ = [
    "FREE_BYTES",
    "PROCESS_BYTES",
    "ByteBoundedCache",
    "Charge",
    "ChargedResponse",
    "Cost",
    "Ledger",
    "keep_heap_small",
    "memory_budget",
]

Key = TypeVar("Key", bound="Hashable")
Value = TypeVar("Value")

_CLOCK = count()
"""Number of the next use of a value, of any cache."""

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
        | {"icc": 200, "cge": 200}
    )
    """Encoding, per triangle, with the content, of every mesh format."""
    CODING = 65
    """Compressing an encoded mesh, per triangle: 1.3 times the content of STL, which is largest."""
    PICTURE = 400
    """Drawing, per triangle."""
    PIXEL = 64
    """Drawing, per pixel."""
    PAGE = 160
    """Encoding a history of a page, per triangle of the largest full boundary: one follows the
    other."""
    PAGE_SHARE = 40
    """Writing a page, per triangle of all full boundaries: the histories, in Base64, and copies."""
    PAGE_BASE = 4 * _MEBIBYTE
    """The viewer in the page, and its compression."""
    COMPARISON = 40
    """Comparing gamuts, per triangle of both levels, also with colours lost; sections and their
    pictures take 20."""
    MODEL = 96 * _MEBIBYTE
    """Making the inverse of a device model: seven inks have tables of 65 MB."""
    PATCHES = 24
    """Fitting a device model, per square of the number of patches: its matrix and two copies."""
    LINK = 64 * _MEBIBYTE
    """Computing a link: the colours that threads map at once."""
    NODE = 250
    """Computing a link, per node of its table; with the file."""
    MAPPING = 192 * _MEBIBYTE
    """Mapping a picture in its process, beside its pixels: a full boundary with its index, and the
    tables of recipes."""
    MAPPED_PIXEL = 48
    """Mapping a picture, per pixel up to 8 million, with the answer: its colours are distinct."""
    FURTHER_PIXEL = 24
    """The same of further pixels. There are at most 16.8 million distinct colours of 8 bits."""
    SPATIAL_PIXEL = 100
    """What the spatial mapping adds per pixel."""
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


class ByteBoundedCache(Generic[Key, Value]):
    """Cache of the most recently used values, up to `capacity` bytes. A larger value is not kept.

    All caches share one clock of uses, so that the oldest value of several caches can be found.
    `hits`, `misses` and `evictions` count values that were found, added, and removed for lack of
    space.
    """

    def __init__(self, capacity: int) -> None:
        self.capacity = capacity
        self.nbytes = 0
        self.hits = self.misses = self.evictions = 0
        self._entries: OrderedDict[Key, tuple[Value, int, int]] = OrderedDict()

    def __len__(self) -> int:
        return len(self._entries)

    def __contains__(self, key: Key) -> bool:
        return key in self._entries

    def get(self, key: Key) -> Value | None:
        """Return a value and mark it as used; None if there is none."""
        entry = self._entries.get(key)
        if entry is None:
            return None
        self._entries[key] = (entry[0], entry[1], next(_CLOCK))
        self._entries.move_to_end(key)
        self.hits += 1
        return entry[0]

    def put(self, key: Key, value: Value, nbytes: int) -> None:
        """Add or replace a value of `nbytes` bytes, and evict the least recently used values."""
        self.misses += key not in self._entries
        self.discard(key)
        if nbytes > self.capacity:
            return
        self._entries[key] = (value, nbytes, next(_CLOCK))
        self.nbytes += nbytes
        while self.nbytes > self.capacity:
            self.evict()

    def discard(self, key: Key) -> None:
        """Remove a key, if it is there."""
        entry = self._entries.pop(key, None)
        if entry is not None:
            self.nbytes -= entry[1]

    def discard_where(self, condition: Callable[[Key], bool]) -> None:
        """Remove all keys that fulfil a condition."""
        for key in [key for key in self._entries if condition(key)]:
            self.discard(key)

    @property
    def oldest_use(self) -> int:
        """Number of the last use of the least recently used value; the cache is not empty."""
        return next(iter(self._entries.values()))[2]

    def evict(self) -> None:
        """Remove the least recently used value; the cache is not empty."""
        _, (_, freed, _) = self._entries.popitem(last=False)
        self.nbytes -= freed
        self.evictions += 1


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
