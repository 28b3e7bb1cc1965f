"""Admission: places, turns and memory for all work of the API process.

Every request that computes takes a place of its class and the bytes that it needs, both at once.
Answers that are in memory already are not admitted. Whoever waits stands in the line of its class,
and clients take turns. Of one client, the request with the earliest deadline goes first: its
arrival and a patience in proportion to its effort. So little effort passes much.

Bytes are a budget. They are those of the work in progress, and those of the gamuts and answers that
anybody still uses. Before anyone waits for bytes, the caches give up what was used least recently.
Small work has places and a reserve of bytes of its own. Of the other classes, the one that has
waited longer for bytes gets them first.

A request that waits holds neither place nor work's bytes. So no two requests wait for each other.

Everything here belongs to the event loop's thread, unless stated otherwise. See
``docs/decisions/admission.md``.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import math
import os
from collections import Counter, OrderedDict, deque
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Protocol, Self

from starlette.responses import Response

from service.http.representations import send_content
from service.http.request_context import timed
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Callable

    from starlette.types import Receive, Scope, Send

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
"""Seconds after which waiting work is refused, before the proxy in ``deploy/`` gives up. Clients
take turns, so a client reaches them by much work of its own."""

_BEFORE_ALL = -2
"""Turn of a client that goes before clients without a turn, which have -1."""

_SENT_PART = 1 / 4
"""Part of the budget of views and heavy work after which a client's answers that are not sent yet
delay its other work."""

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
    """Memory of a value. It counts as long as anybody refers to this object.

    `client` is the one that an answer is sent to; empty for other values.
    """

    def __init__(self, admission: Admission, kind: str, nbytes: int, client: str) -> None:
        self._admission = admission
        self.kind, self.client = kind, client
        self.nbytes = 0
        self.resize(nbytes)

    def resize(self, nbytes: int) -> None:
        """Count that many bytes."""
        self._admission.count_held(self.kind, self.client, nbytes - self.nbytes)
        self.nbytes = nbytes

    def __del__(self) -> None:
        self._admission.forget(self.kind, self.client, self.nbytes)


@dataclass(eq=False)
class Place:
    """A place of a class, and bytes, until the end of a context. `Admission.place` gives it."""

    admission: Admission
    work: Work
    client: str
    nbytes: int
    is_taken: bool = True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.leave()

    def leave(self) -> None:
        """Release the place and the bytes. May be called again."""
        if self.is_taken:
            self.is_taken = False
            self.admission.release(self)

    async def exchange(self, nbytes: int) -> None:
        """Take other bytes, before all other requests of the class. Raise as `place` does."""
        await self.admission.exchange(self, nbytes)


@dataclass(order=True)
class _Waiter:
    """A request that waits. The least one of a client goes first."""

    deadline: float
    number: int
    work: Work = field(compare=False)
    client: str = field(compare=False)
    need: Callable[[], int] = field(compare=False)
    granted: asyncio.Future[Place] = field(compare=False)


class Admission:
    """The one door of the service. See the module's description.

    `budget` is in bytes, beside those of the `process` itself. A client has at most `most_waiting`
    requests waiting. `running` counts places and `granted` bytes by class; `held` counts bytes of
    values by kind, `sent` those of answers by client, `refused` the requests that were refused, and
    `freed` the bytes that were released since it was last set to 0.
    """

    def __init__(
        self, budget: int, *, most_waiting: int, process: int = 0, patience: float = _PATIENCE
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
        self.sent: Counter[str] = Counter()
        self.refused = self.freed = 0
        self._most_waiting = most_waiting
        self._process = process
        self._patience = patience
        self._caches: list[_Cache] = []
        self._lines: dict[Work, list[_Waiter]] = {work: [] for work in Work}
        # Numbers of the last turns of clients.
        self._turns = {work: OrderedDict[str, int]() for work in Work}
        self._waiting: Counter[str] = Counter()
        self._claim: _Waiter | None = None  # has waited longest for bytes, of views and heavy work
        self._numbers = itertools.count()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._is_scheduled = False
        # Appended to by any thread, and in the midst of anything: whoever drops the last reference.
        self._forgotten: deque[tuple[str, str, int]] = deque()

    @property
    def most(self) -> int:
        """Bytes that views and heavy work have."""
        return self.budget - self.reserve

    @property
    def total(self) -> int:
        """Bytes in use."""
        self._collect()
        return self.granted.total() + self.held.total()

    @property
    def waiting(self) -> dict[Work, int]:
        """Numbers of waiting requests by class."""
        return {work: len(line) for work, line in self._lines.items()}

    def add(self, cache: _Cache) -> None:
        """Let a cache give way to work. Its values have holdings."""
        self._caches.append(cache)

    def hold(self, kind: str, nbytes: int, client: str = "") -> Holding:
        """Count bytes as long as the returned object lives; see `Holding`."""
        return Holding(self, kind, nbytes, client)

    def hold_response(self, response: Response, client: str) -> Response:
        """Return a complete response whose content counts until it is sent."""
        nbytes = len(response.body)
        return response if nbytes <= FREE_BYTES else _HeldResponse(response, self, client)

    async def place(
        self,
        work: Work,
        client: str,
        need: Callable[[], int],
        effort: float = 0.0,
        *,
        goes_on: bool = False,
    ) -> Place:
        """Return a place with bytes, after waiting for them if needed. It is a context.

        `need` returns the bytes, and is called again at the end of the wait, because others may
        have done a part of the work. `effort` is in bytes as well: work that takes as long as
        preparing so many. A request that `goes_on` had a place before: it is the first of its
        client, and never one too many. Small work that needs more than the reserve counts as
        `VIEW`.

        Raise `ProblemError`: ``queries-busy`` if the client has too many requests waiting, and
        ``memory-exceeded`` if the work is larger than the budget.
        """
        nbytes = need()
        work = self._class_of(work, nbytes)
        may_start = (not self._lines[work] or _passes(work, nbytes)) and self._is_free(work, client)
        if may_start and self._reads(work, client, nbytes) and self._has_room(work, nbytes):
            return self._grant(work, client, nbytes)
        if not goes_on and self._waiting[client] >= self._most_waiting:
            detail = f"The client has {self._most_waiting} requests waiting."
            raise self._refusal("queries-busy", detail, 2)
        self._loop = asyncio.get_running_loop()
        deadline = self._loop.time() + _PATIENCE_PER_BYTE * effort
        if goes_on:
            deadline = -math.inf
        while True:
            granted: asyncio.Future[Place] = self._loop.create_future()
            waiter = _Waiter(deadline, next(self._numbers), work, client, need, granted)
            place = await self._wait(waiter)
            is_enough = False
            try:
                # Another may have lost meanwhile what the work counted on.
                is_enough = need() <= max(place.nbytes, FREE_BYTES)
            finally:
                if not is_enough:
                    place.leave()
            if is_enough:
                return place
            work = place.work

    async def exchange(self, place: Place, nbytes: int) -> None:
        """Exchange a place for one with other bytes; called by the place."""
        place.is_taken = False
        self._take_back(place)
        self._turns[place.work][place.client] = _BEFORE_ALL  # nobody is served meanwhile
        try:
            other = await self.place(place.work, place.client, lambda: nbytes, goes_on=True)
        except BaseException:
            self._count_turn(place.work, place.client)
            self._serve()
            raise
        place.work, place.nbytes, place.is_taken = other.work, other.nbytes, True

    def release(self, place: Place) -> None:
        """Release what a place holds; called by the place."""
        self._take_back(place)
        self.shrink_caches()
        self._serve()

    def _take_back(self, place: Place) -> None:
        self.granted[place.work] -= place.nbytes
        self.freed += place.nbytes
        self._count_running(place.work, place.client, -1)

    def shrink_caches(self) -> None:
        """Let the caches give up what is beyond the budget, after values were added or grew."""
        self._collect()
        self._evict(self.granted[Work.VIEW] + self.granted[Work.HEAVY], self.most)

    def count_held(self, kind: str, client: str, nbytes: int) -> None:
        """Count bytes of a value; called by its holding."""
        self._count(kind, client, nbytes)
        if nbytes < 0:
            self._serve()

    def forget(self, kind: str, client: str, nbytes: int) -> None:
        """Release the memory of a value that nobody refers to any more. Any thread may call it."""
        self._forgotten.append((kind, client, nbytes))
        if self._waiting and self._loop is not None and not self._is_scheduled:
            self._is_scheduled = True
            with contextlib.suppress(RuntimeError):  # the loop is closed
                self._loop.call_soon_threadsafe(self._serve)

    # --- waiting ----------------------------------------------------------------------------------

    async def _wait(self, waiter: _Waiter) -> Place:
        self._lines[waiter.work].append(waiter)
        self._waiting[waiter.client] += 1
        granted = waiter.granted
        try:
            self._serve()
            with timed("wait"):
                async with asyncio.timeout(self._patience):
                    return await granted
        except BaseException as error:
            if granted.done() and not granted.cancelled() and granted.exception() is None:
                granted.result().leave()
            if isinstance(error, TimeoutError):
                detail = f"The request waited for {self._patience:g} s."
                raise self._refusal("memory-busy", detail, 5) from None
            raise
        finally:
            self._remove(waiter)
            self._waiting[waiter.client] -= 1
            if not self._waiting[waiter.client]:
                del self._waiting[waiter.client]
            self._serve()

    def _remove(self, waiter: _Waiter) -> None:
        """Remove a request from its line, if it is there."""
        if waiter in self._lines[waiter.work]:
            self._lines[waiter.work].remove(waiter)
        if self._claim is waiter:
            self._claim = None

    def _heads(self, work: Work) -> list[_Waiter]:
        """Return the next request of each client, the client that has waited longest first."""
        heads: dict[str, _Waiter] = {}
        for waiter in sorted(self._lines[work]):
            heads.setdefault(waiter.client, waiter)
        turns = self._turns[work]
        return sorted(heads.values(), key=lambda waiter: turns.get(waiter.client, -1))

    def _serve(self) -> None:
        """Give places and bytes to whoever can have them now."""
        self._is_scheduled = False
        if not self._waiting:
            return
        self._collect()
        first = None if self._claim is None else self._claim.work
        for work in sorted(Work, key=lambda work: work is not first):
            while self._serve_one(work):
                pass

    def _serve_one(self, work: Work) -> bool:
        """Take one request out of a line; return whether there was one that can go on."""
        is_blocked = False
        for waiter in self._heads(work):
            client, granted = waiter.client, waiter.granted
            if granted.done():
                self._remove(waiter)
                return True
            if not self._is_free(work, client):
                continue
            try:
                nbytes = waiter.need()
                rightful = self._class_of(work, nbytes)
            except Exception as error:  # noqa: BLE001 - belongs to the work that waits
                granted.set_exception(error)
                self._remove(waiter)
                return True
            if rightful is not work:
                self._remove(waiter)
                waiter.work = rightful
                self._lines[rightful].append(waiter)
                return True
            reads = self._reads(work, client, nbytes)
            if self._claim is waiter and not reads:
                self._claim = None
            if not reads or (is_blocked and not _passes(work, nbytes)):
                continue
            if self._has_room(work, nbytes):
                self._remove(waiter)
                granted.set_result(self._grant(work, client, nbytes))
                return True
            is_blocked = True
            if self._claim is None and work is not Work.SMALL:
                self._claim = waiter
        return False

    # --- places and bytes -------------------------------------------------------------------------

    def _class_of(self, work: Work, nbytes: int) -> Work:
        """Return the class by the bytes that are needed; raise if they are more than there are."""
        if work is Work.SMALL and nbytes > self.reserve:
            work = Work.VIEW
        if work is not Work.SMALL and nbytes > max(self.most, FREE_BYTES):
            self.refused += 1
            detail = f"The request needs {nbytes} bytes of memory; the service has {self.most}."
            setting = self._process + math.ceil(nbytes / (1 - _RESERVE))
            remedy = (
                "Ask for fewer triangles, pixels or rows, or ask the operator to set "
                f"GAMUT_MEMORY_BYTES to {setting} or more."
            )
            raise ProblemError(Problem("memory-exceeded", detail, remedy=remedy))
        return work

    def _is_free(self, work: Work, client: str) -> bool:
        """Return whether there is a place for a client."""
        first = 0 if self._running_of[work, client] else self.first_places[work]
        return self.running[work] < self.places[work] + first

    def _reads(self, work: Work, client: str, nbytes: int) -> bool:
        """Return whether a client that wants more bytes has read most of its answers."""
        is_large = nbytes > FREE_BYTES and work is not Work.SMALL
        return not is_large or self.sent[client] <= _SENT_PART * self.most

    def _count_running(self, work: Work, client: str, number: int) -> None:
        self.running[work] += number
        self._running_of[work, client] += number
        if not self._running_of[work, client]:
            del self._running_of[work, client]

    def _count_turn(self, work: Work, client: str) -> None:
        turns = self._turns[work]
        turns[client] = next(self._numbers)
        turns.move_to_end(client)
        if len(turns) > _REMEMBERED_CLIENTS:
            turns.popitem(last=False)

    def _grant(self, work: Work, client: str, nbytes: int) -> Place:
        self._count_turn(work, client)
        nbytes = 0 if nbytes <= FREE_BYTES else nbytes
        self._count_running(work, client, 1)
        self.granted[work] += nbytes
        return Place(self, work, client, nbytes)

    def _has_room(self, work: Work, nbytes: int) -> bool:
        """Return whether bytes fit into the budget, after the caches gave way if needed."""
        if nbytes <= FREE_BYTES:
            return True
        others, most = self.granted[Work.VIEW] + self.granted[Work.HEAVY] + nbytes, self.most
        if work is Work.SMALL:
            if self.granted[Work.SMALL] + nbytes > self.reserve:
                return False
            others, most = others + self.granted[Work.SMALL], self.budget
        elif self._claim is not None and self._claim.work is not work:
            return False
        self._collect()
        # Nothing is given up in vain.
        if others + self.held.total() - most > sum(cache.nbytes for cache in self._caches):
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
            kind, client, nbytes = self._forgotten.popleft()
            self._count(kind, client, -nbytes)

    def _count(self, kind: str, client: str, nbytes: int) -> None:
        self.held[kind] += nbytes
        self.freed -= min(0, nbytes)
        if client:
            self.sent[client] += nbytes
            if not self.sent[client]:
                del self.sent[client]

    def _refusal(self, code: str, detail: str, seconds: int) -> ProblemError:
        self.refused += 1
        return ProblemError(Problem(code, detail, headers={"Retry-After": str(seconds)}))


def _passes(work: Work, nbytes: int) -> bool:
    """Return whether a request may pass those that wait for bytes, because it needs none.

    Not in the line of heavy work, whose one place the others would lose for seconds.
    """
    return nbytes <= FREE_BYTES and work is not Work.HEAVY


class _HeldResponse(Response):
    """A complete response whose content counts until it is sent."""

    def __init__(self, response: Response, admission: Admission, client: str) -> None:
        super().__init__(response.body, response.status_code)
        self.raw_headers = response.raw_headers
        self._holding = admission.hold("answers", len(response.body), client)

    async def __call__(self, _scope: Scope, _receive: Receive, send: Send) -> None:
        """Send the content."""
        try:
            await send_content(send, self.status_code, self.raw_headers, bytes(self.body))
        finally:
            self._holding.resize(0)
