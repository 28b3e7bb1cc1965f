"""What a local store removes by itself: blobs when it is full, and histories without a record.

Nothing is evicted unless the operator has set a size limit. Inputs of finished gamuts go first,
because only the repair of damaged gamuts and recipes need them. Quarantined blobs and then gamuts
follow. Inputs and gamuts go in the order of the last use of their gamut. Inputs of unfinished jobs,
jobs, and gamuts that are being published are never removed.

A store may have a million files. It is scanned for the first eviction, and the least recently used
gamuts are kept in memory. The store reports later gamuts (`Eviction.note`). So another scan is
needed only when the gamuts in memory are used up and the store has others.
"""

from __future__ import annotations

import contextlib
import heapq
import logging
import math
import threading
from collections import deque
from itertools import groupby
from typing import TYPE_CHECKING

from service.storage.blobs import BlobNotFoundError, stored_bytes
from service.storage.published import PublishedGamut, blob_key, id_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from service.storage.blobs import Blobs
    from service.storage.local import LocalBlobs
    from service.storage.uses import GamutUses

__all__ = ["Eviction", "remove_uncommitted"]

logger = logging.getLogger(__name__)

_MOST = 20_000
"""Number of gamuts per queue after a scan, about 4 MB."""

_SCANS = 2
"""Number of scans per call. Gamuts that a first scan finds may be in use later."""


class _Queue:
    """The least recently used gamuts by the time of their last use.

    A gamut that is not in the heap was used after the horizon. An infinite horizon means that the
    heap is complete.
    """

    def __init__(self) -> None:
        self.heap: list[tuple[float, str]] = []
        self.horizon = -math.inf

    def fill(self, uses: Iterable[tuple[float, str]]) -> None:
        """Replace the content by the oldest of some gamuts."""
        # A sorted list is a heap.
        self.heap = heapq.nsmallest(_MOST, uses)
        self.horizon = math.inf if len(self.heap) < _MOST else self.heap[-1][0]

    def add(self, used: float, gamut_id: str) -> None:
        """Add a gamut unless it was used after the horizon."""
        if used <= self.horizon:
            heapq.heappush(self.heap, (used, gamut_id))
            if len(self.heap) > 2 * _MOST:
                self.fill(self.heap)


class Eviction:
    """Makes room in a local store. `evict` removes a gamut and returns the freed bytes."""

    def __init__(self, blobs: LocalBlobs, uses: GamutUses, evict: Callable[[str], int]) -> None:
        self._blobs = blobs
        self._uses = uses
        self._evict = evict
        self._lock = threading.RLock()
        self._evicting = False
        self._inputs = _Queue()
        self._gamuts = _Queue()
        self._quarantined: deque[str] = deque()
        # Not added to the queues at once, because a scan holds the lock for seconds.
        self._noted: deque[str] = deque()
        self._outdated = True
        self._scans_left = 0

    def note(self, gamut_id: str) -> None:
        """Report that a gamut was published, or that its input was stored."""
        if len(self._noted) >= _MOST:
            self._outdated = True
        if not self._outdated:
            self._noted.append(gamut_id)

    def make_room(self, nbytes: int) -> bool:
        """Free at least `nbytes` bytes if possible; return whether any were freed.

        A store without a size limit frees none.
        """
        if not self._blobs.limit:
            return False
        with self._lock:
            if self._evicting:
                # Quarantine of a damaged candidate writes its reason, for which there is no space.
                return False
            self._evicting = True
            try:
                freed = self._free(nbytes)
            except BaseException:
                # A gamut that was taken from a queue may still be stored.
                self._outdated = True
                raise
            finally:
                self._evicting = False
        if freed:
            logger.info("%d bytes evicted", freed)
        return freed > 0

    def _free(self, nbytes: int) -> int:
        self._scans_left = _SCANS
        if self._outdated:
            self._scan()
        freed = 0
        while freed < nbytes:
            self._take_noted()
            if (gamut_id := self._oldest(self._inputs)) is not None:
                freed += self._drop(blob_key(gamut_id, "input"))
            elif (key := self._next_in_quarantine()) is not None:
                freed += self._drop(key)
            elif (gamut_id := self._oldest(self._gamuts)) is not None:
                freed += self._evict(gamut_id)
            else:
                break
        return freed

    def _oldest(self, queue: _Queue) -> str | None:
        """Take the least recently used gamut from a queue; None if none may go."""
        while True:
            if not queue.heap and queue.horizon < math.inf and self._scans_left:
                self._scan()
            if not queue.heap:
                return None
            used, gamut_id = heapq.heappop(queue.heap)
            # A gamut that is being published is noted afterwards.
            if not self._uses.is_being_published(gamut_id):
                with contextlib.suppress(BlobNotFoundError):
                    current = self._uses.last(gamut_id)
                    if current == used:
                        return gamut_id
                    queue.add(current, gamut_id)

    def _scan(self) -> None:
        self._scans_left -= 1
        self._outdated = False
        self._noted.clear()
        self._inputs.fill(self._dated_ids("inputs/", ".input"))
        self._gamuts.fill(self._dated_ids("published/", ".record"))

    def _dated_ids(self, prefix: str, suffix: str) -> Iterator[tuple[float, str]]:
        """Iterate over last use and id of the published gamuts that have such a blob."""
        for key in self._blobs.keys(prefix):
            if key.endswith(suffix):
                with contextlib.suppress(BlobNotFoundError):
                    yield self._uses.last(id_of(key)), id_of(key)

    def _take_noted(self) -> None:
        while self._noted:
            gamut_id = self._noted.popleft()
            # Without a record, the input belongs to a job that is not finished.
            with contextlib.suppress(BlobNotFoundError):
                used = self._uses.last(gamut_id)
                self._inputs.add(used, gamut_id)
                self._gamuts.add(used, gamut_id)

    def _next_in_quarantine(self) -> str | None:
        if not self._quarantined:
            dated_keys = []
            for key in self._blobs.keys("quarantine/"):
                with contextlib.suppress(BlobNotFoundError):
                    dated_keys.append((self._blobs.stat(key).st_mtime, key))
            self._quarantined.extend(key for _, key in sorted(dated_keys))
        return self._quarantined.popleft() if self._quarantined else None

    def _drop(self, key: str) -> int:
        nbytes = stored_bytes(self._blobs, key)
        return nbytes if self._blobs.delete(key) else 0


def remove_uncommitted(blobs: Blobs, uses: GamutUses, goes_on: Callable[[], bool]) -> int:
    """Remove histories whose publisher died before it created the record; return their number.

    The storage must belong to this process: in a shared one, other publishers are unknown.
    `goes_on` tells whether to continue.
    """
    removed = 0
    for gamut_id, keys in groupby(blobs.keys("published/"), id_of):
        if not goes_on():
            break
        histories = [key for key in keys if key.endswith(".gamut")]
        # The keys are read first: a gamut that is not being published now was committed before.
        if uses.is_being_published(gamut_id):
            continue
        record = blob_key(gamut_id, "record")
        if len(histories) == 1 and stored_bytes(blobs, record):
            # The usual case, without a read. A record that names another history is damaged, and
            # reading it will show that.
            continue
        try:
            committed = PublishedGamut.from_bytes(blobs.read(record).data).key
        except BlobNotFoundError:
            committed = ""
        except (ValueError, TypeError):
            continue  # for the quarantine
        removed += sum(blobs.delete(key) for key in histories if key != committed)
    return removed
