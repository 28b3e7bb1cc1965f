"""Which queries run, and when: admission by rows, and threads by deadline."""

from __future__ import annotations

import asyncio
import contextlib
import heapq
import itertools
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from service.http.bodies import Refused, SharedAmount
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["Admission", "DeadlineThreads"]

_SMALL_ROWS = 1000
"""Queries of at most so many rows need no share. They are answered within milliseconds."""

_FOR_SMALL = 1 / 20
"""The part of all rows that large queries leave to small ones."""


class Admission:
    """The rows under way, which clients share. Belongs to the event loop's thread.

    Rows are counted from the moment when a body has arrived to the end of the answer, which bounds
    the memory of all queries. Several queries have `most` rows at most, of which a `share` belongs
    to one client if others compete. A single query is always admitted.
    """

    def __init__(self, most: int, share: float) -> None:
        self._rows = SharedAmount(most, share)

    @property
    def rows(self) -> int:
        """Rows under way."""
        return self._rows.used

    @contextlib.contextmanager
    def held(self, client: str, estimate: int) -> Iterator[Callable[[int], None]]:
        """Count rows until the end of the context, which gets a function to correct the number.

        Raise the problem ``queries-busy`` if too many rows are under way.
        """
        if refused := self._refusal(client, estimate):
            detail, remedy = f"{self.rows} rows are being answered.", ""
            if refused is Refused.SHARE:
                detail = f"{detail} The client would have more than its share of them."
                remedy = "Wait for the answers to other queries, or try again after Retry-After."
            headers = {"Retry-After": "1"}
            raise ProblemError(Problem("queries-busy", detail, remedy=remedy, headers=headers))
        counted = estimate
        self._rows.take(client, counted)

        def correct(rows: int) -> None:
            nonlocal counted
            self._rows.take(client, rows - counted)
            counted = rows

        try:
            yield correct
        finally:
            self._rows.take(client, -counted)

    def _refusal(self, client: str, rows: int) -> Refused | None:
        most = self._rows.most
        if rows > _SMALL_ROWS:
            return self._rows.refusal(client, rows + int(_FOR_SMALL * most))
        return Refused.FULL if self.rows and self.rows + rows > most else None


P = ParamSpec("P")
T = TypeVar("T")

_PATIENCE = 50e-6
"""Seconds of patience per row, ten times as long as a row of the slowest operation takes."""


class DeadlineThreads:
    """A pool of threads for tasks, the earliest deadline first. Belongs to the event loop's thread.

    A task's deadline is its arrival plus a patience in proportion to its size. So small queries
    pass large ones, and no stream of small queries delays a large one for ever.
    """

    def __init__(self, threads: int) -> None:
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="queries")
        self._free = threads
        self._waiting: list[tuple[float, int, asyncio.Future[None]]] = []
        self._numbers = itertools.count()

    async def run(
        self, rows: int, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs
    ) -> T:
        """Return the result of a function, which runs in a thread when it is its turn.

        `rows` is the size of the task. The function is called in the context of the caller.
        """
        loop = asyncio.get_running_loop()
        if self._free:
            self._free -= 1
        else:
            turn = loop.create_future()
            entry = loop.time() + _PATIENCE * rows, next(self._numbers), turn
            heapq.heappush(self._waiting, entry)
            try:
                await turn
            except asyncio.CancelledError:
                if not turn.cancelled():
                    self._release()
                raise
        context = copy_context()
        work = self._pool.submit(lambda: context.run(function, *args, **kwargs))

        def release(_: object) -> None:
            with contextlib.suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(self._release)

        # Not when the caller is cancelled: the thread goes on until the function returns.
        work.add_done_callback(release)
        return await asyncio.wrap_future(work)

    def close(self) -> None:
        """End the threads."""
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _release(self) -> None:
        """Pass a thread to the next task that still waits."""
        while self._waiting:
            turn = heapq.heappop(self._waiting)[2]
            if not turn.done():
                turn.set_result(None)
                return
        self._free += 1
