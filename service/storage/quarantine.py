"""Quarantine: damaged blobs are kept for inspection and never served."""

from __future__ import annotations

import logging
import secrets
import threading
import time
from typing import TYPE_CHECKING

from service.storage.blobs import BlobNotFoundError, StoreFullError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from service.storage.blobs import Blobs

__all__ = ["Quarantine"]

logger = logging.getLogger(__name__)


class Quarantine:
    """Damaged blobs of a storage as ``quarantine/<name>.<mark>``, with the reason beside them.

    `count` is the number of faults that this process recorded.
    """

    def __init__(self, blobs: Blobs) -> None:
        self.count = 0
        self._blobs = blobs
        self._lock = threading.Lock()

    def put(
        self, keys: Sequence[str], reason: str, is_still: Callable[[bytes], bool] | None = None
    ) -> bool:
        """Move blobs that belong together to the quarantine; return whether they were moved.

        The first key is the main one: the others are useless without it. `is_still` tells whether
        its current content is still the damaged one.
        """
        first = keys[0]
        mark = secrets.token_hex(4)
        with self._lock:
            if is_still is not None:
                try:
                    if not is_still(self._blobs.read(first).data):
                        return False
                except BlobNotFoundError:
                    return False
            if not self._blobs.move(first, _key(first, mark)):
                return False
            self.count += 1
        logger.error("%s moved to quarantine: %s", first, reason)
        for key in keys[1:]:
            self._blobs.move(key, _key(key, mark))
        when = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        note = f"{when} {reason}\n" + "".join(f"{key}\n" for key in keys)
        try:
            self._blobs.create(f"{_key(first, mark)}.reason", note.encode())
        except StoreFullError:
            logger.warning("no space for the reason of %s", first)
        return True

    def holds(self, key: str) -> bool:
        """Return whether a blob of this key is in the quarantine."""
        beginning = _key(key, "")
        found = next(iter(self._blobs.keys("quarantine/", beginning)), "")
        return found.startswith(beginning)


def _key(key: str, mark: str) -> str:
    return f"quarantine/{key.rpartition('/')[2]}.{mark}"
