"""The same work, wanted by several requests at the same time, done once.

The work is a task of its own, so that it goes on for the others when the request that began it is
given up. A key can be forgotten while its work is under way: whoever waits gets the result, and
whoever asks later begins anew.
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
    """Work under way, by key."""

    def __init__(self) -> None:
        self._tasks: dict[Key, asyncio.Task[Value]] = {}

    async def value(self, key: Key, work: Callable[[], Coroutine[Any, Any, Value]]) -> Value:
        """Return what `work` returns, or raise what it raises, from one run for all who ask."""
        task = self._tasks.get(key)
        if task is None:
            task = self._tasks[key] = asyncio.create_task(work())
            task.add_done_callback(lambda done: self._ended(key, done))
        return await asyncio.shield(task)

    def forget(self, key: Key) -> None:
        """Let whoever asks from now on begin anew."""
        self._tasks.pop(key, None)

    def is_current(self, key: Key) -> bool:
        """Whether the calling task is the work of this key, and was not forgotten."""
        return self._tasks.get(key) is asyncio.current_task()

    def _ended(self, key: Key, task: asyncio.Task[Value]) -> None:
        if self._tasks.get(key) is task:
            del self._tasks[key]
        if not task.cancelled():
            # Nobody may be left who waits; an error is then nobody's.
            task.exception()
