"""Published gamuts: the layout of their blobs, their records, and those that are kept in memory."""

from __future__ import annotations

import json
import threading
import time
from collections import OrderedDict
from dataclasses import asdict, dataclass
from typing import Any

from service.storage.blobs import seal, unseal

__all__ = ["PublishedCache", "PublishedGamut", "blob_key", "id_of"]

_FOLDERS = {
    "record": "published",
    "gamut": "published",
    "input": "inputs",
    "model": "models",
    "name": "names",
    "owner": "owners",
}
"""Folder of each kind of blob. The kind is the end of the key."""


def blob_key(gamut_id: str, kind: str) -> str:
    """Return the key ``<folder>/<aa>/<id>.<kind>`` of a gamut's blob."""
    return f"{_FOLDERS[kind.rpartition('.')[2]]}/{gamut_id[:2]}/{gamut_id}.{kind}"


def id_of(key: str) -> str:
    """Return the gamut's id in a key."""
    return key.rpartition("/")[2].partition(".")[0]


@dataclass(frozen=True)
class PublishedGamut:
    """A published gamut without its history: the content of its file ``.record`` in the store.

    `sha256` and `nbytes` are of the history file, `created` is the time of publication (RFC 3339,
    UTC), and `description` is by `gamutcore`. `copy` is the random part of the history file's name;
    empty for gamuts of old versions.
    """

    id: str
    sha256: str
    nbytes: int
    created: str
    description: dict[str, Any]
    copy: str = ""

    def to_bytes(self) -> bytes:
        """Return the file: sealed JSON."""
        return seal(json.dumps(asdict(self), separators=(",", ":")).encode())

    @classmethod
    def from_bytes(cls, data: bytes) -> PublishedGamut:
        """Return the gamut of a file; raises ValueError or TypeError if it is damaged."""
        return cls(**json.loads(unseal(data)))

    @property
    def key(self) -> str:
        """Key of the history file."""
        return blob_key(self.id, f"{self.copy}.gamut" if self.copy else "gamut")


class PublishedCache:
    """Recently read gamuts, `capacity` at most.

    A published gamut never changes, but other replicas may delete it. So it is assumed to exist
    for some `seconds` only; 0 disables the cache.
    """

    def __init__(self, capacity: int, seconds: float) -> None:
        self._capacity = capacity
        self._seconds = seconds
        self._lock = threading.Lock()
        self._kept: OrderedDict[str, tuple[PublishedGamut, float]] = OrderedDict()

    def get(self, gamut_id: str, *, stale: bool = False) -> PublishedGamut | None:
        """Return a gamut that is assumed to exist, or that existed when it was read last."""
        gamut, until = self._kept.get(gamut_id, (None, 0.0))
        return gamut if stale or until > time.monotonic() else None

    def put(self, gamut: PublishedGamut) -> None:
        """Keep a gamut that was just read or published."""
        if self._seconds:
            with self._lock:
                self._kept[gamut.id] = (gamut, time.monotonic() + self._seconds)
                self._kept.move_to_end(gamut.id)
                while len(self._kept) > self._capacity:
                    self._kept.popitem(last=False)

    def discard(self, gamut_id: str) -> None:
        """Forget a gamut that is gone or in doubt."""
        with self._lock:
            self._kept.pop(gamut_id, None)
