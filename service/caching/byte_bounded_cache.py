"""A least-recently-used cache whose bound is a number of bytes, not a number of entries.

Used for opened histories and for encoded meshes, whose sizes differ by three orders of magnitude.
It is meant for the event loop's thread: no operation waits, and none is locked.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

__all__ = ["ByteBoundedCache"]

Key = TypeVar("Key", bound="Hashable")
Value = TypeVar("Value")


class ByteBoundedCache(Generic[Key, Value]):
    """Keeps the values used last, as many as fit into `capacity` bytes.

    Parameters
    ----------
    capacity : int
        Bytes that all values together may take. A value that is larger by itself is not kept.

    Attributes
    ----------
    nbytes : int
        Bytes that the values take.
    hits, misses, evictions : int
        Values that were found; that had to be made, and put here; that had to go for others.
    """

    def __init__(self, capacity: int) -> None:
        self.capacity = capacity
        self.nbytes = 0
        self.hits = self.misses = self.evictions = 0
        self._entries: OrderedDict[Key, tuple[Value, int]] = OrderedDict()

    def __len__(self) -> int:
        return len(self._entries)

    def get(self, key: Key) -> Value | None:
        """Return the value and make it the most recently used; None if it is not there."""
        entry = self._entries.get(key)
        if entry is None:
            return None
        self._entries.move_to_end(key)
        self.hits += 1
        return entry[0]

    def put(self, key: Key, value: Value, nbytes: int) -> None:
        """Keep a value of `nbytes` bytes; the least recently used leave until all fit."""
        self.misses += 1
        self.discard(key)
        self._keep(key, value, nbytes)

    def resize(self, key: Key, value: Value, nbytes: int) -> None:
        """Say that a value takes another number of bytes by now; nothing happens if it is gone."""
        if self.discard_value(key, value):
            self._keep(key, value, nbytes)

    def discard(self, key: Key) -> None:
        """Forget a key; nothing happens if it is not there."""
        entry = self._entries.pop(key, None)
        if entry is not None:
            self.nbytes -= entry[1]

    def discard_value(self, key: Key, value: Value) -> bool:
        """Forget a key if it is this very value that is kept under it; whether it was."""
        entry = self._entries.get(key)
        if entry is None or entry[0] is not value:
            return False
        self.discard(key)
        return True

    def discard_where(self, condition: Callable[[Key], bool]) -> None:
        """Forget every key that fulfils a condition."""
        for key in [key for key in self._entries if condition(key)]:
            self.discard(key)

    def _keep(self, key: Key, value: Value, nbytes: int) -> None:
        if nbytes > self.capacity:
            return
        self._entries[key] = (value, nbytes)
        self.nbytes += nbytes
        while self.nbytes > self.capacity:
            _, (_, freed) = self._entries.popitem(last=False)
            self.nbytes -= freed
            self.evictions += 1
