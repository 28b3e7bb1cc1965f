"""Eviction: which blobs are removed when a local store is full.

Inputs of finished gamuts go first, because only the repair of damaged gamuts needs them. If the
operator has set a size limit, quarantined blobs and then the least recently used gamuts follow.
Inputs of unfinished jobs, jobs, and gamuts that are being published are never removed.
"""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from service.storage.blobs import BlobNotFoundError
from service.storage.local import LocalBlobs
from service.storage.records import id_of, input_key, record_key

__all__ = ["Eviction"]

logger = logging.getLogger(__name__)

_LOOKS = 2
"""Number of scans of the store per call. Candidates of the first scan may be in use later."""

_PAUSE = 1.0
"""Seconds for which a store without candidates is not scanned again."""


@dataclass(frozen=True)
class _Candidate:
    key: str
    used: float
    evict: Callable[[str], int]


class Evictable(Protocol):
    """The gamuts of a store, as far as eviction needs them."""

    def flush_uses(self) -> None:
        """Write the times of last use to the files."""

    def is_being_published(self, gamut_id: str) -> bool:
        """Return whether a thread of this process is publishing the gamut."""

    def evict(self, gamut_id: str) -> int:
        """Remove a gamut and return the number of bytes freed."""


class Eviction:
    """Makes room in a local store.

    Parameters
    ----------
    store : Evictable
        The gamuts.
    blobs : LocalBlobs
        Their storage.
    """

    def __init__(self, store: Evictable, blobs: LocalBlobs) -> None:
        self._store = store
        self._blobs = blobs
        self._lock = threading.RLock()
        self._evicting = False
        self._candidates: deque[_Candidate] = deque()
        self._nothing_until = 0.0

    def make_room(self, nbytes: int) -> bool:
        """Free at least `nbytes` bytes if possible; return whether any were freed."""
        with self._lock:
            if self._evicting:
                # Quarantine of a damaged candidate writes its reason, for which there is no space.
                return False
            self._evicting = True
            try:
                freed = self._free(nbytes)
            finally:
                self._evicting = False
        if freed:
            logger.info("%d bytes evicted", freed)
        return freed > 0

    def _free(self, nbytes: int) -> int:
        self._store.flush_uses()
        freed = looks = 0
        while freed < nbytes:
            if not self._candidates:
                looks += 1
                if looks > _LOOKS or not self._look():
                    break
            candidate = self._candidates.popleft()
            with contextlib.suppress(BlobNotFoundError):
                used = self._blobs.stat(candidate.key).st_mtime
                if used > candidate.used:
                    # Used since the scan: it goes to the end of the queue.
                    self._candidates.append(_Candidate(candidate.key, used, candidate.evict))
                    continue
                freed += candidate.evict(candidate.key)
        return freed

    def _look(self) -> bool:
        """Scan the store for candidates; return whether there are any."""
        if time.monotonic() < self._nothing_until:
            return False
        found = self._candidates_under(
            "inputs/", self._drop_input, lambda key: self._has_record(id_of(key))
        )
        if self._blobs.limit:
            found += self._candidates_under("quarantine/", self._drop, lambda _: True)
            found += self._candidates_under(
                "published/", self._evict, lambda key: key.endswith(".record")
            )
        self._candidates.extend(found)
        if not found:
            self._nothing_until = time.monotonic() + _PAUSE
        return bool(found)

    def _candidates_under(
        self, prefix: str, evict: Callable[[str], int], may_go: Callable[[str], bool]
    ) -> list[_Candidate]:
        found = []
        for key in self._blobs.keys(prefix):
            if may_go(key) and not self._store.is_being_published(id_of(key)):
                with contextlib.suppress(BlobNotFoundError):
                    found.append(_Candidate(key, self._blobs.stat(key).st_mtime, evict))
        return sorted(found, key=lambda candidate: candidate.used)

    def _has_record(self, gamut_id: str) -> bool:
        return self._blobs.path(record_key(gamut_id)).exists()

    def _drop_input(self, key: str) -> int:
        # The input may belong to a job again, if its gamut was deleted or damaged meanwhile.
        return self._drop(input_key(id_of(key))) if self._has_record(id_of(key)) else 0

    def _drop(self, key: str) -> int:
        nbytes = self._blobs.size(key)
        return nbytes if self._blobs.delete(key) else 0

    def _evict(self, key: str) -> int:
        return self._store.evict(id_of(key))
