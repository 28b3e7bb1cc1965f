"""Where damaged blobs go: they can be looked at by people, and are not served."""

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
    """Damaged blobs of a storage: ``quarantine/<name>.<mark>``, the reason beside them.

    Parameters
    ----------
    blobs : Blobs
        The storage.

    Attributes
    ----------
    count : int
        How often something was put here by this process.
    """

    def __init__(self, blobs: Blobs) -> None:
        self.count = 0
        self._blobs = blobs
        self._lock = threading.Lock()

    def put(
        self, keys: Sequence[str], reason: str, is_still: Callable[[bytes], bool] | None = None
    ) -> bool:
        """Move blobs here that belong together.

        Parameters
        ----------
        keys : sequence of str
            The first is the one without which the others mean nothing.
        reason : str
            What is wrong with them.
        is_still : callable, optional
            Whether the first, with the content that it has now, is what was found damaged, and has
            not been replaced by a sound one meanwhile.

        Returns
        -------
        bool
            Whether they were moved.
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
            logger.warning("no room for the reason's file of %s", first)
        return True

    def holds(self, key: str) -> bool:
        """Whether a blob that had this key was ever put here, and is here still."""
        beginning = _key(key, "")
        found = next(iter(self._blobs.keys("quarantine/", beginning)), "")
        return found.startswith(beginning)


def _key(key: str, mark: str) -> str:
    return f"quarantine/{key.rpartition('/')[2]}.{mark}"
