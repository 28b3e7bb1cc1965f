"""Uses of gamuts: when each was used last, and which are being published by this process."""

from __future__ import annotations

import contextlib
import threading
import time
from collections import Counter
from typing import TYPE_CHECKING

from service.storage.local import LocalBlobs
from service.storage.published import blob_key

if TYPE_CHECKING:
    from collections.abc import Iterator

    from service.storage.blobs import Blobs

__all__ = ["GamutUses"]

_FLUSH_SECONDS = 600.0
"""Interval of writing the times of last use."""


class GamutUses:
    """Uses of the gamuts of a storage. The least recently used gamuts are evicted first.

    A bucket keeps no times of last use, and evicts nothing.
    """

    def __init__(self, blobs: Blobs) -> None:
        self._blobs = blobs
        self._lock = threading.Lock()
        self._publishing: Counter[str] = Counter()
        self._unwritten: dict[str, float] = {}
        self._flushed = time.monotonic()

    def mark(self, gamut_id: str) -> None:
        """Record the use of a gamut."""
        if not self._blobs.remote:
            with self._lock:
                self._unwritten[gamut_id] = time.time()

    def last(self, gamut_id: str) -> float:
        """Return the time of a gamut's last use; raises `BlobNotFoundError` if there is none."""
        assert isinstance(self._blobs, LocalBlobs)  # noqa: S101
        # Memory first, because a flush writes the time before it forgets it.
        unwritten = self._unwritten.get(gamut_id)
        written = self._blobs.stat(blob_key(gamut_id, "record")).st_mtime
        return written if unwritten is None else unwritten

    def discard(self, gamut_id: str) -> None:
        """Forget the last use of a deleted gamut."""
        with self._lock:
            self._unwritten.pop(gamut_id, None)

    def flush_if_due(self) -> None:
        """Write the times of last use if the last flush is long ago."""
        if time.monotonic() > self._flushed + _FLUSH_SECONDS:
            self.flush()

    def flush(self) -> None:
        """Write the times of last use as modification times of the records."""
        if isinstance(self._blobs, LocalBlobs):
            self._flushed = time.monotonic()
            for gamut_id, when in list(self._unwritten.items()):
                self._blobs.touch(blob_key(gamut_id, "record"), when)
                with self._lock:
                    if self._unwritten.get(gamut_id) == when:
                        del self._unwritten[gamut_id]

    @contextlib.contextmanager
    def publishing(self, gamut_id: str) -> Iterator[None]:
        """Mark a gamut as being published inside the context."""
        with self._lock:
            self._publishing[gamut_id] += 1
        try:
            yield
        finally:
            with self._lock:
                self._publishing -= Counter([gamut_id])

    def is_being_published(self, gamut_id: str) -> bool:
        """Return whether a thread of this process is publishing the gamut."""
        return gamut_id in self._publishing
