"""Single flight: simultaneous requests for the same work share one execution.

The work runs in a separate task, so it survives the cancellation of the request that started it.
After `forget`, current waiters still get the result, and later requests start anew.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Hashable

__all__ = ["SingleFlight"]

Key = TypeVar("Key", bound="Hashable")
Value = TypeVar("Value")


class SingleFlight(Generic[Key, Value]):
    """Running work by key."""

    def __init__(self) -> None:
        self._tasks: dict[Key, asyncio.Task[Value]] = {}

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
