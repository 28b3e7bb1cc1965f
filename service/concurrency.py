"""Work that simultaneous requests share, and work in threads.

Everything here belongs to the event loop's thread.
"""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from functools import partial
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
    """A pool of threads for work that has been admitted."""

    def __init__(self, threads: int, name: str) -> None:
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix=name)

    async def run(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Return the result of a function that is too slow for the event loop.

        The function is called in the context of the caller, so that times measured in the thread
        belong to the request.
        """
        work = partial(copy_context().run, function, *args, **kwargs)
        return await asyncio.get_running_loop().run_in_executor(self._pool, work)

    def close(self) -> None:
        """End the threads."""
        self._pool.shutdown(wait=False, cancel_futures=True)
