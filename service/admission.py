"""Admission: places, turns and memory for all work of the API process.

Every request that computes takes a place of its class and the bytes that it needs, both at once.
Answers that are in memory already are not admitted. Whoever waits stands in the line of its class,
and clients take turns. Of one client, the request with the earliest deadline goes first: its
arrival and a patience in proportion to its effort. So little effort passes much.

Bytes are a budget. They are those of the work in progress, and those of the open gamuts and answers
that anybody still uses. Before anyone waits for bytes, the caches give up what was used least
recently. Small work has places and a reserve of bytes of its own. Of the other classes, the one
that has waited longer for bytes gets them first.

A request that holds a place never waits for another place, and a request that waits for bytes holds
none. So no two requests wait for each other.

Everything here belongs to the event loop's thread, unless stated otherwise. See
``docs/decisions/admission.md``.
"""

from __future__ import annotations

import asyncio
import contextlib
import heapq
import itertools
import math
import os
from collections import Counter, OrderedDict, deque
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Protocol

from starlette.responses import Response

from service.http.request_context import timed
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

__all__ = [
    "FREE_BYTES",
    "MODEL_BYTES",
    "ROW_BYTES",
    "Admission",
    "Holding",
    "Place",
    "Work",
    "needed_bytes",
]

FREE_BYTES = 64 * 1024
"""Work up to this size needs no bytes of the budget."""

UNPACKED_BYTES = 270
"""Unpacking the history of a gamut and searching it for a level, per triangle: 190 + 75, of which
120 stay. Growth of VmHWM for FOGRA39L (145,728 triangles, four channels), as the next one."""

PREPARED_BYTES = 430
"""Indexing a level, per triangle: 350, and 410 with its comparison with the full boundary, of which
280 stay. Other work on a level is counted in multiples of this."""

ROW_BYTES = 350
"""A row of an answer as numbers: `nearest`, which has the most columns."""

PIXEL_BYTES = 50
"""A pixel of a picture that is mapped: 48 up to 8 million distinct colours."""

MODEL_BYTES = 96 * 2**20
"""The inverse of a device model: seven inks have tables of 65 MB."""

_RESERVE = 1 / 8
"""Part of the budget that only small work takes."""

_PATIENCE_PER_BYTE = 1e-7
"""Seconds of patience for a byte of effort, ten times as long as it takes to prepare a level."""

_PATIENCE = 300.0
"""Seconds after which waiting work is refused. Only a fault in the service reaches them."""

_TRIM_BYTES = 32 * 2**20
"""Released bytes after which free pages go back to the system."""

_TRIM_SECONDS = 1.0
"""Delay after such a release, so that a burst of releases is followed by one trim."""

_REMEMBERED_CLIENTS = 4096
"""Clients whose last turn is remembered."""


class Work(Enum):
    """Classes of work.

    `SMALL` takes milliseconds: single colours, and tables up to 1,000 rows. `HEAVY` takes seconds
    of all cores: mapped pictures, links. `VIEW` is everything between.
    """

    SMALL = "small"
    VIEW = "view"
    HEAVY = "heavy"


def needed_bytes(
    *,
    unpacked: float = 0,
    prepared: float = 0,
    rows: float = 0,
    pixels: float = 0,
    models: float = 0,
) -> int:
    """Return the peak memory of a request in bytes.

    `unpacked` counts triangles of histories that are unpacked and searched, `prepared` triangles of
    levels that are indexed, `rows` rows of answers, `pixels` pixels, and `models` device models.
    """
    return int(
        UNPACKED_BYTES * unpacked
        + PREPARED_BYTES * prepared
        + ROW_BYTES * rows
        + PIXEL_BYTES * pixels
        + MODEL_BYTES * models
    )


class _Cache(Protocol):
    """A cache that gives up values; see `service.library.ByteBoundedCache`."""

    nbytes: int

    def __len__(self) -> int: ...

    @property
    def oldest_use(self) -> int:
        """Number of the last use of the least recently used value."""

    def evict(self) -> None:
        """Remove that value."""


class Holding:
    """Memory of a value. It counts as long as anybody refers to this object."""

    def __init__(self, admission: Admission, kind: str, nbytes: int) -> None:
        self._admission = admission
        self.kind = kind
        self.nbytes = 0
        self.resize(nbytes)

    def resize(self, nbytes: int) -> None:
        """Count that many bytes."""
        self._admission.held[self.kind] += nbytes - self.nbytes
        self.nbytes = nbytes

    def __del__(self) -> None:
        self._admission.forget(self.kind, self.nbytes)


class Place:
    """A place of a class, and bytes. `Admission.place` gives it."""

    def __init__(self, admission: Admission, work: Work, client: str, nbytes: int) -> None:
        self._admission = admission
        self.work = work
        self.client = client
        self.nbytes = nbytes
        self.is_taken = True

    def shrink(self, nbytes: int) -> None:
        """Release all but some bytes."""
        self._admission.release(self, nbytes, keeps_place=self.is_taken)

    def give_back(self, nbytes: int) -> None:
        """Release the place, and all but some bytes, which the answer needs while it is sent."""
        self._admission.release(self, nbytes, keeps_place=False)

    def leave(self) -> None:
        """Release the place and all bytes. May be called again."""
        self._admission.release(self, 0, keeps_place=False)

    async def grow(self, nbytes: int) -> None:
        """Take more bytes for the same place, before other work. The place must hold none."""
        await self._admission.grow(self, nbytes)

    @contextlib.asynccontextmanager
    async def turn(self) -> AsyncIterator[None]:
        """Take a place for a piece of the answer whose bytes this one holds."""
        # First of its client, whose other requests may wait for the bytes of this answer.
        turn = await self._admission.enter(
            self.work, self.client, _nothing, -math.inf, is_limited=False
        )
        try:
            yield
        finally:
            turn.leave()


@dataclass(eq=False)
class _Waiter:
    """A request that waits. `place` is the place that it holds already; None if it needs one."""

    work: Work
    client: str
    need: Callable[[], int]
    deadline: float
    number: int
    granted: asyncio.Future[Place]
    place: Place | None = None


@dataclass
class _Line:
    """The requests of a class that wait."""

    clients: dict[str, list[tuple[float, int, _Waiter]]] = field(default_factory=dict)
    turns: OrderedDict[str, int] = field(default_factory=OrderedDict)
    """Numbers of the last turns of clients."""

    def __len__(self) -> int:
        return sum(map(len, self.clients.values()))

    def add(self, waiter: _Waiter) -> None:
        """Add a request."""
        entry = (waiter.deadline, waiter.number, waiter)
        heapq.heappush(self.clients.setdefault(waiter.client, []), entry)

    def heads(self) -> list[_Waiter]:
        """Return the next request of each client, the client that has waited longest first."""
        clients = sorted(self.clients, key=lambda client: self.turns.get(client, -1))
        return [self.clients[client][0][2] for client in clients]

    def remove(self, waiter: _Waiter) -> bool:
        """Remove a request; return whether it was there."""
        requests = self.clients.get(waiter.client, [])
        entry = (waiter.deadline, waiter.number, waiter)
        if entry not in requests:
            return False
        requests.remove(entry)
        heapq.heapify(requests)
        if not requests:
            del self.clients[waiter.client]
        return True

    def count_turn(self, client: str, number: int) -> None:
        """Remember that a client had its turn."""
        self.turns[client] = number
        self.turns.move_to_end(client)
        if len(self.turns) > _REMEMBERED_CLIENTS:
            self.turns.popitem(last=False)


class Admission:
    """The one door of the service. See the module's description.

    `budget` is in bytes, beside those of the `process` itself. A client has at most `most_waiting`
    requests waiting. `trim` gives free memory back to the system. `running` counts places and
    `granted` bytes by class; `held` counts bytes of values by kind, and `refused` the requests that
    were refused.
    """

    def __init__(
        self,
        budget: int,
        *,
        most_waiting: int,
        process: int = 0,
        patience: float = _PATIENCE,
        trim: Callable[[], None] | None = None,
    ) -> None:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 2
        self.places = {Work.SMALL: 4 * cores, Work.VIEW: cores, Work.HEAVY: 1}
        # For clients that have none: their first view does not wait for comparisons of others.
        self.first_places = {Work.SMALL: 0, Work.VIEW: cores, Work.HEAVY: 0}
        self.budget = budget
        self.reserve = int(_RESERVE * budget)
        self.running: Counter[Work] = Counter()
        self._running_of: Counter[tuple[Work, str]] = Counter()
        self.granted: Counter[Work] = Counter()
        self.held: Counter[str] = Counter()
        self.refused = 0
        self._most_waiting = most_waiting
        self._process = process
        self._patience = patience
        self._trim = trim
        self._caches: list[_Cache] = []
        self._lines = {work: _Line() for work in Work}
        self._growing: deque[_Waiter] = deque()
        self._waiting: Counter[str] = Counter()
        self._claim: Work | None = None
        self._numbers = itertools.count()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._is_scheduled = False
        self._freed = 0
        self._trimming: asyncio.TimerHandle | None = None
        # Appended to by any thread, and in the midst of anything: whoever drops the last reference.
        self._forgotten: deque[tuple[str, int]] = deque()

    @property
    def total(self) -> int:
        """Bytes in use."""
        self._collect()
        return self.granted.total() + self.held.total()

    @property
    def waiting(self) -> dict[Work, int]:
        """Numbers of waiting requests by class."""
        counts = {work: len(line) for work, line in self._lines.items()}
        counts[Work.HEAVY] += len(self._growing)
        return counts

    def add(self, cache: _Cache) -> None:
        """Let a cache give way to work. Its values have holdings."""
        self._caches.append(cache)

    def hold(self, kind: str, nbytes: int) -> Holding:
        """Count bytes as long as the returned object lives."""
        return Holding(self, kind, nbytes)

    def hold_response(self, response: Response) -> Response:
        """Return a complete response whose content counts until it is sent."""
        nbytes = len(response.body)
        return response if nbytes <= FREE_BYTES else _HeldResponse(response, self)

    @contextlib.asynccontextmanager
    async def place(
        self, work: Work, client: str, need: Callable[[], int], effort: float = 0.0
    ) -> AsyncIterator[Place]:
        """Take a place and bytes until the end of the context; see `enter`."""
        place = await self.enter(work, client, need, effort)
        try:
            yield place
        finally:
            place.leave()

    async def enter(
        self,
        work: Work,
        client: str,
        need: Callable[[], int],
        effort: float = 0.0,
        *,
        is_limited: bool = True,
    ) -> Place:
        """Take a place and bytes, after waiting for them if needed.

        `need` returns the bytes, and is called again at the end of the wait, because others may
        have done a part of the work. `effort` is in bytes as well: work that takes as long as
        preparing so many. Small work that needs more than the reserve counts as `VIEW`.
        Raise `ProblemError`: ``queries-busy`` if the client has too many requests waiting, and
        ``memory-exceeded`` if the work is larger than the budget.
        """
        work, nbytes = self._class_of(work, need())
        line = self._lines[work]
        may_pass = nbytes <= FREE_BYTES or not line.clients
        if self._is_free(work, client) and may_pass and self._has_room(work, nbytes):
            line.count_turn(client, next(self._numbers))
            return self._grant(work, client, nbytes)
        if is_limited and self._waiting[client] >= self._most_waiting:
            raise self._too_many()
        self._loop = asyncio.get_running_loop()
        deadline = self._loop.time() + _PATIENCE_PER_BYTE * effort
        while True:
            waiter = _Waiter(work, client, need, deadline, next(self._numbers), self._new_future())
            self._lines[work].add(waiter)
            place = await self._wait(waiter)
            # Another may have lost meanwhile what the work counted on.
            if need() <= max(place.nbytes, FREE_BYTES):
                return place
            work = place.work
            place.leave()

    async def grow(self, place: Place, nbytes: int) -> None:
        """Take bytes for a place that has none; called by the place."""
        assert place.is_taken  # noqa: S101 - otherwise others could wait for it
        assert not place.nbytes  # noqa: S101
        self._class_of(place.work, nbytes)
        if not self._growing and self._has_room(place.work, nbytes):
            self.granted[place.work] += nbytes
            place.nbytes = nbytes
            return
        self._loop = asyncio.get_running_loop()
        number, granted = next(self._numbers), self._new_future()
        waiter = _Waiter(place.work, place.client, lambda: nbytes, 0.0, number, granted, place)
        self._growing.append(waiter)
        await self._wait(waiter)

    def release(self, place: Place, nbytes: int, *, keeps_place: bool) -> None:
        """Release what a place holds; called by the place."""
        freed = max(0, place.nbytes - nbytes)
        place.nbytes -= freed
        self.granted[place.work] -= freed
        self._count_freed(freed)
        if place.is_taken and not keeps_place:
            place.is_taken = False
            self._count_running(place.work, place.client, -1)
        self.shrink_caches()
        if self._waiting:
            self._serve()

    def shrink_caches(self) -> None:
        """Let the caches give up what is beyond the budget, after values were added or grew."""
        self._collect()
        granted = self.granted[Work.VIEW] + self.granted[Work.HEAVY]
        self._evict(granted, self.budget - self.reserve)

    def forget(self, kind: str, nbytes: int) -> None:
        """Release the memory of a value that nobody refers to any more. Any thread may call it."""
        self._forgotten.append((kind, nbytes))
        if self._waiting and self._loop is not None and not self._is_scheduled:
            self._is_scheduled = True
            with contextlib.suppress(RuntimeError):  # the loop is closed
                self._loop.call_soon_threadsafe(self._serve)

    # --- waiting ----------------------------------------------------------------------------------

    def _new_future(self) -> asyncio.Future[Place]:
        return asyncio.get_running_loop().create_future()

    async def _wait(self, waiter: _Waiter) -> Place:
        self._waiting[waiter.client] += 1
        try:
            self._serve()
            with timed("wait"):
                async with asyncio.timeout(self._patience):
                    return await waiter.granted
        except BaseException as error:
            granted = waiter.granted
            if granted.done() and not granted.cancelled() and granted.exception() is None:
                granted.result().leave()
            if isinstance(error, TimeoutError):
                raise self._too_slow() from None
            raise
        finally:
            self._remove(waiter)
            self._waiting[waiter.client] -= 1
            if not self._waiting[waiter.client]:
                del self._waiting[waiter.client]
            if self._waiting:
                self._serve()

    def _remove(self, waiter: _Waiter) -> None:
        if waiter.place is None:
            self._lines[waiter.work].remove(waiter)
        else:
            with contextlib.suppress(ValueError):
                self._growing.remove(waiter)

    def _serve(self) -> None:
        """Give places and bytes to whoever can have them now."""
        self._is_scheduled = False
        for work in sorted(Work, key=lambda each: each is not self._claim):
            if work is Work.HEAVY and self._growing:
                self._serve_growing()
            while self._serve_one(work):
                pass
            if self._claim is work and not (
                self._lines[work].clients or (work is Work.HEAVY and self._growing)
            ):
                self._claim = None

    def _serve_growing(self) -> None:
        waiter = self._growing[0]
        nbytes, place = waiter.need(), waiter.place
        assert place is not None  # noqa: S101 - whoever grows has one
        if waiter.granted.done():
            self._growing.popleft()
        elif self._has_room(waiter.work, nbytes):
            self._growing.popleft()
            self._claim = None
            self.granted[waiter.work] += nbytes
            place.nbytes = nbytes
            waiter.granted.set_result(place)
        elif self._claim is None:
            self._claim = waiter.work

    def _serve_one(self, work: Work) -> bool:
        """Take one request out of a line; return whether there was one that can go on."""
        line = self._lines[work]
        is_blocked = False
        for waiter in line.heads():
            if waiter.granted.done():
                return line.remove(waiter)
            if not self._is_free(work, waiter.client):
                continue
            try:
                rightful, nbytes = self._class_of(work, waiter.need())
            except Exception as error:  # noqa: BLE001 - belongs to the work that waits
                waiter.granted.set_exception(error)
                return line.remove(waiter)
            if rightful is not work:
                line.remove(waiter)
                waiter.work = rightful
                self._lines[rightful].add(waiter)
                return True
            # Behind a request that waits for bytes, only those that need none go on.
            if is_blocked and nbytes > FREE_BYTES:
                continue
            if self._has_room(work, nbytes):
                if not is_blocked and self._claim is work:
                    self._claim = None
                line.count_turn(waiter.client, next(self._numbers))
                waiter.granted.set_result(self._grant(work, waiter.client, nbytes))
                return line.remove(waiter)
            is_blocked = True
            if self._claim is None and work is not Work.SMALL:
                self._claim = work
        return False

    # --- places and bytes -------------------------------------------------------------------------

    def _class_of(self, work: Work, nbytes: int) -> tuple[Work, int]:
        """Return the class by the bytes that are needed; raise if they are more than there are."""
        if work is Work.SMALL and nbytes > self.reserve:
            work = Work.VIEW
        most = self.budget - self.reserve
        if work is not Work.SMALL and nbytes > most:
            self.refused += 1
            detail = f"The request needs {nbytes} bytes of memory; the service has {most}."
            setting = self._process + math.ceil(nbytes / (1 - _RESERVE))
            remedy = (
                "Ask for fewer triangles, pixels or rows, or ask the operator to set "
                f"GAMUT_MEMORY_BYTES to {setting} or more."
            )
            raise ProblemError(Problem("memory-exceeded", detail, remedy=remedy))
        return work, nbytes

    def _is_free(self, work: Work, client: str) -> bool:
        """Return whether there is a place for a client."""
        first = 0 if self._running_of[work, client] else self.first_places[work]
        return self.running[work] < self.places[work] + first

    def _count_running(self, work: Work, client: str, number: int) -> None:
        self.running[work] += number
        self._running_of[work, client] += number
        if not self._running_of[work, client]:
            del self._running_of[work, client]

    def _grant(self, work: Work, client: str, nbytes: int) -> Place:
        nbytes = 0 if nbytes <= FREE_BYTES else nbytes
        self._count_running(work, client, 1)
        self.granted[work] += nbytes
        return Place(self, work, client, nbytes)

    def _has_room(self, work: Work, nbytes: int) -> bool:
        """Return whether bytes fit into the budget, after the caches gave way if needed."""
        if nbytes <= FREE_BYTES:
            return True
        others = self.granted[Work.VIEW] + self.granted[Work.HEAVY] + nbytes
        most = self.budget - self.reserve
        if work is Work.SMALL:
            if self.granted[Work.SMALL] + nbytes > self.reserve:
                return False
            others, most = others + self.granted[Work.SMALL], self.budget
        elif self._claim not in {None, work}:
            return False
        self._collect()
        excess = others + self.held.total() - most
        # Nothing is given up in vain.
        if excess > sum(cache.nbytes for cache in self._caches):
            return False
        return self._evict(others, most)

    def _evict(self, granted: int, most: int) -> bool:
        """Let the caches give way until the bytes fit; return whether they do."""
        while granted + self.held.total() > most:
            filled = [cache for cache in self._caches if len(cache)]
            if not filled:
                return False
            min(filled, key=lambda cache: cache.oldest_use).evict()
            self._collect()
        return True

    def _collect(self) -> None:
        while self._forgotten:
            kind, nbytes = self._forgotten.popleft()
            self.held[kind] -= nbytes
            self._count_freed(nbytes)

    def _count_freed(self, nbytes: int) -> None:
        self._freed += nbytes
        if self._trim is None or self._freed < _TRIM_BYTES or self._trimming is not None:
            return
        with contextlib.suppress(RuntimeError):  # no loop runs
            loop = asyncio.get_running_loop()
            self._trimming = loop.call_later(_TRIM_SECONDS, self._trim_now, self._trim)

    def _trim_now(self, trim: Callable[[], None]) -> None:
        self._freed, self._trimming = 0, None
        trim()

    def _too_many(self) -> ProblemError:
        self.refused += 1
        detail = f"The client has {self._most_waiting} requests waiting."
        return ProblemError(Problem("queries-busy", detail, headers={"Retry-After": "2"}))

    def _too_slow(self) -> ProblemError:
        self.refused += 1
        detail = f"The request waited for {self._patience:g} s."
        return ProblemError(Problem("memory-busy", detail, headers={"Retry-After": "5"}))


class _HeldResponse(Response):
    """A complete response whose content counts as long as it is in use."""

    def __init__(self, response: Response, admission: Admission) -> None:
        super().__init__(response.body, response.status_code)
        self.raw_headers = response.raw_headers
        self.holding = admission.hold("answers", len(response.body))


def _nothing() -> int:
    return 0
