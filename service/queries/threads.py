"""Threads for queries: the task with the earliest deadline runs first.

A task's deadline is its arrival plus a patience in proportion to its size. So small queries pass
large ones, and no stream of small queries delays a large one for ever.
"""

from __future__ import annotations

import asyncio
import contextlib
import heapq
import itertools
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["DeadlineThreads"]

P = ParamSpec("P")
T = TypeVar("T")

_PATIENCE = 50e-6
"""Seconds of patience per row, ten times as long as a row of the slowest operation takes."""


class DeadlineThreads:
    """A pool of threads. Belongs to the event loop's thread.

    Parameters
    ----------
    threads : int
        Number of tasks that run at the same time.
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

        Parameters
        ----------
        rows : int
            Size of the task.
        function : callable
            Called with the other arguments, in the context of the caller.
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
