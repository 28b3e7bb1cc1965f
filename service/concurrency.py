"""Work that simultaneous requests share, and work in threads.

Everything here belongs to the event loop's thread.
"""

from __future__ import annotations

import asyncio
import contextlib
import heapq
import itertools
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import TYPE_CHECKING, Any, Generic, ParamSpec, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Hashable

__all__ = ["SingleFlight", "Threads"]

Key = TypeVar("Key", bound="Hashable")
Value = TypeVar("Value")
P = ParamSpec("P")
T = TypeVar("T")


class SingleFlight(Generic[Key, Value]):
    """Running work by key: simultaneous requests for the same work share one execution.

    The work runs in a separate task, so it survives the cancellation of the request that started
    it. After `forget`, current waiters still get the result, and later requests start anew.
    """

    def __init__(self) -> None:
        self._tasks: dict[Key, asyncio.Task[Value]] = {}

    def __contains__(self, key: Key) -> bool:
        return key in self._tasks

    async def value(self, key: Key, work: Callable[[], Coroutine[Any, Any, Value]]) -> Value:
        """Return or raise the outcome of `work`, from one execution for all waiters."""
        task = self._tasks.get(key)
        if task is None:
            task = self._tasks[key] = asyncio.create_task(work())
            task.add_done_callback(lambda done: self._remove(key, done))
        return await asyncio.shield(task)

    def forget(self, key: Key) -> None:
        """Let later requests start anew."""
        self._tasks.pop(key, None)

    def is_current(self, key: Key) -> bool:
        """Return whether the calling task is the work of this key and was not forgotten."""
        return self._tasks.get(key) is asyncio.current_task()

    def _remove(self, key: Key, task: asyncio.Task[Value]) -> None:
        if self._tasks.get(key) is task:
            del self._tasks[key]
        if not task.cancelled():
            # Retrieves the exception, so that asyncio does not report it if nobody waits.
            task.exception()


class Threads:
    """A pool of threads for tasks, the earliest deadline first.

    A task's deadline is its arrival plus a patience. A patience in proportion to the task's size
    lets small tasks pass large ones, and no stream of small tasks delays a large one for ever.
    """

    def __init__(self, threads: int, name: str) -> None:
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix=name)
        self._free = threads
        self._waiting: list[tuple[float, int, asyncio.Future[None]]] = []
        self._numbers = itertools.count()

    async def run(
        self, patience: float, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs
    ) -> T:
        """Return the result of a function, which runs in a thread when it is its turn.

        `patience` is in seconds. The function is called in the context of the caller, so that
        times measured in the thread belong to the request.
        """
        loop = asyncio.get_running_loop()
        if self._free:
            self._free -= 1
        else:
            turn = loop.create_future()
            heapq.heappush(self._waiting, (loop.time() + patience, next(self._numbers), turn))
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
