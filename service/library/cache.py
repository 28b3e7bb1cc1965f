"""A cache that is bounded in bytes, and gives way to work; see `service.admission`."""

from __future__ import annotations

from collections import OrderedDict
from itertools import count
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

__all__ = ["ByteBoundedCache"]

Key = TypeVar("Key", bound="Hashable")
Value = TypeVar("Value")

_CLOCK = count()
"""Number of the next use of a value, of any cache."""


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
