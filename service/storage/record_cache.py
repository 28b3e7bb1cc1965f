"""Records that were read a moment ago, so that describing a gamut in a bucket asks nobody twice."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict

from service.storage.records import Record

__all__ = ["RecordCache"]


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
