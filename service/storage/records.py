"""The record of a published gamut, and the keys that gamuts are stored under."""

from __future__ import annotations

import json
import threading
import time
from collections import OrderedDict
from dataclasses import asdict, dataclass
from typing import Any

from service.storage.blobs import seal, unseal

__all__ = ["Record", "RecordCache", "history_key", "id_of", "input_key", "record_key"]


@dataclass(frozen=True)
class Record:
    """What is known about a published gamut without opening its history.

    Attributes
    ----------
    id : str
        The gamut's id, 64 hexadecimal digits.
    sha256 : str
        Digest of the history file, hexadecimal.
    nbytes : int
        Size of the history file.
    created : str
        When it was published, RFC 3339, UTC.
    description : dict
        The description that `gamutcore` gave it.
    copy : str
        Which history file of the id it is: `GamutStore.publish` chooses it. Empty in records of
        before there could be several.
    """

    id: str
    sha256: str
    nbytes: int
    created: str
    description: dict[str, Any]
    copy: str = ""

    def to_bytes(self) -> bytes:
        """Return the record as it is stored: seal JSON."""
        return seal(json.dumps(asdict(self), separators=(",", ":")).encode())

    @classmethod
    def from_bytes(cls, data: bytes) -> Record:
        """Return a stored record; ValueError or TypeError if anything about it is wrong."""
        return cls(**json.loads(unseal(data)))

    @property
    def key(self) -> str:
        """The key of the history file."""
        return history_key(self.id, self.copy)


class RecordCache:
    """The records read last, each for a while: it never changes, but may be deleted elsewhere.

    Parameters
    ----------
    capacity : int
        Records that are kept, the last used.
    seconds : float
        For how long one is believed to be there still. 0: nothing is kept.
    """

    def __init__(self, capacity: int, seconds: float) -> None:
        self._capacity = capacity
        self._seconds = seconds
        self._lock = threading.Lock()
        self._records: OrderedDict[str, tuple[Record, float]] = OrderedDict()

    def get(self, gamut_id: str) -> Record | None:
        """Return a record that is believed to be there; None if there is none."""
        record, until = self._records.get(gamut_id, (None, 0.0))
        return record if until > time.monotonic() else None

    def put(self, record: Record) -> None:
        """Keep a record that has just been read or created."""
        if self._seconds:
            with self._lock:
                self._records[record.id] = (record, time.monotonic() + self._seconds)
                self._records.move_to_end(record.id)
                while len(self._records) > self._capacity:
                    self._records.popitem(last=False)

    def discard(self, gamut_id: str) -> None:
        """Forget a record, because it is gone or in doubt."""
        with self._lock:
            self._records.pop(gamut_id, None)


def record_key(gamut_id: str) -> str:
    """Return the key of a gamut's record."""
    return f"published/{gamut_id[:2]}/{gamut_id}.record"


def history_key(gamut_id: str, copy: str) -> str:
    """Return the key of one copy of a gamut's history file."""
    name = f"{gamut_id}.{copy}.gamut" if copy else f"{gamut_id}.gamut"
    return f"published/{gamut_id[:2]}/{name}"


def input_key(gamut_id: str) -> str:
    """Return the key of the input that a gamut is built from."""
    return f"inputs/{gamut_id[:2]}/{gamut_id}.input"


def id_of(key: str) -> str:
    """Return the id of the gamut that a key of the above belongs to."""
    return key.rpartition("/")[2].partition(".")[0]
