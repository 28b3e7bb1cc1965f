"""Published gamuts, their cache, the keys of a gamut's blobs, and sealed payloads."""

from __future__ import annotations

import hashlib
import json
import threading
import time
from collections import OrderedDict
from dataclasses import asdict, dataclass
from typing import Any

from service.storage.blobs import BlobDamagedError

__all__ = [
    "PublishedCache",
    "PublishedGamut",
    "history_key",
    "id_of",
    "input_key",
    "published_key",
    "seal",
    "unseal",
]


@dataclass(frozen=True)
class PublishedGamut:
    """A published gamut without its history: the content of its file ``.record`` in the store.

    Attributes
    ----------
    sha256, nbytes
        Hexadecimal digest and size of the history file.
    created
        Time of publication, RFC 3339, UTC.
    description
        Description by `gamutcore`.
    copy
        Random part of the history file's name; empty for gamuts of old versions.
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
        return history_key(self.id, self.copy)


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

    def get(self, gamut_id: str) -> PublishedGamut | None:
        """Return a gamut that is assumed to exist; None if there is none."""
        gamut, until = self._kept.get(gamut_id, (None, 0.0))
        return gamut if until > time.monotonic() else None

    def find_stale(self, gamut_id: str) -> PublishedGamut | None:
        """Return a gamut that existed when it was read last; None if there is none."""
        return self._kept.get(gamut_id, (None, 0.0))[0]

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


def published_key(gamut_id: str) -> str:
    """Return the key of a gamut's description."""
    return f"published/{gamut_id[:2]}/{gamut_id}.record"


def history_key(gamut_id: str, copy: str) -> str:
    """Return the key of one copy of a gamut's history file."""
    name = f"{gamut_id}.{copy}.gamut" if copy else f"{gamut_id}.gamut"
    return f"published/{gamut_id[:2]}/{name}"


def input_key(gamut_id: str) -> str:
    """Return the key of a gamut's input."""
    return f"inputs/{gamut_id[:2]}/{gamut_id}.input"


def id_of(key: str) -> str:
    """Return the gamut's id in a key."""
    return key.rpartition("/")[2].partition(".")[0]


def seal(payload: bytes) -> bytes:
    """Return a payload with its SHA-256 in front, which `unseal` verifies.

    The parts are 64 hexadecimal digits, a line feed, the payload and a line feed.
    """
    return b"%b\n%b\n" % (hashlib.sha256(payload).hexdigest().encode(), payload)


def unseal(data: bytes) -> bytes:
    """Return the payload of sealed bytes; raise `BlobDamagedError` for other bytes."""
    digest, payload = data[:65], data[65:-1]
    expected = hashlib.sha256(payload).hexdigest().encode() + b"\n"
    if len(data) < 66 or digest != expected or data[-1:] != b"\n":
        message = "the content does not match its digest"
        raise BlobDamagedError(message)
    return payload
