"""Deletions in a shared bucket, announced to all replicas.

A replica answers from memory without asking the bucket, so it must hear of deletions elsewhere.
Each deletion leaves an empty blob ``deleted/<id>.<milliseconds>``, and every replica lists these
blobs periodically. The clocks of all hosts must agree within an hour.
"""

from __future__ import annotations

import time

from service.storage.blobs import Blobs
from service.storage.published import id_of

__all__ = ["Deletions"]

_PREFIX = "deleted/"

_ECHO_SECONDS = 60.0
"""Time for which a deletion is repeated. It is announced before the blobs are removed, so a replica
that hears of it may read the gamut once more."""

_KEPT_SECONDS = 3600.0
"""Age of an announcement that is removed by any replica."""


class Deletions:
    """The announced deletions of a bucket."""

    def __init__(self, blobs: Blobs) -> None:
        self._blobs = blobs
        self._seen: dict[str, float] = {}

    def announce(self, gamut_id: str) -> None:
        """Announce that a gamut is about to be removed."""
        self._blobs.create(f"{_PREFIX}{gamut_id}.{int(1000 * time.time())}", b"")

    def recent(self) -> set[str]:
        """Return the ids of gamuts whose deletion became known within the last minute."""
        now, kept = time.monotonic(), {}
        for key in list(self._blobs.keys(_PREFIX)):
            milliseconds = int(key.rpartition(".")[2])
            if time.time() - milliseconds / 1000 > _KEPT_SECONDS:
                self._blobs.delete(key)
            kept[key] = self._seen.get(key, now)
        self._seen = kept
        return {id_of(key) for key, since in kept.items() if now - since <= _ECHO_SECONDS}
