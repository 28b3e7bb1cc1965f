"""Gamuts in a store: published whole or not at all, verified when read.

A gamut is two blobs: its history file, byte for byte what clients download, and its record (the
history's SHA-256 and the description). Every attempt to publish stores the history under a name of
its own, ``published/<aa>/<id>.<copy>.gamut``, and then creates ``published/<aa>/<id>.record``
exclusively, which names that copy. So a gamut exists exactly when its record does, and no two
publishers, nor a publisher and a deleter, can touch each other's bytes, on however many machines.
Every read compares the history with the record's digest, and the record with its own; what is
damaged is moved to ``quarantine/`` and counts as never built. The input of a build is kept as
``inputs/<aa>/<id>.input``, so that the gamut can be built again. See ``docs/decisions/store.md``.

All methods block: the event loop calls them in threads.
"""

from __future__ import annotations

import contextlib
import hashlib
import secrets
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import islice, takewhile
from pathlib import Path
from typing import Any, BinaryIO

from service.storage.blobs import BlobDamagedError, BlobNotFoundError, Blobs, StoreUnavailableError
from service.storage.eviction import Eviction
from service.storage.inputs import Inputs
from service.storage.local import LocalBlobs
from service.storage.quarantine import Quarantine
from service.storage.records import Record, RecordCache, id_of, record_key
from service.storage.sweep import remove_uncommitted

__all__ = ["GamutDamagedError", "GamutNotStoredError", "GamutStore"]

_CHUNK = 1 << 20

_CACHED_RECORDS = 10_000
"""Records of a remote store that are remembered; one has a few kilobytes."""

_RECORD_SECONDS = 30.0
"""How long a record of a remote store is believed to be there still. It never changes, but another
replica may delete it."""

_READERS = 16
"""Records of a remote store that are read at the same time for a page of the list."""

_FLUSH_SECONDS = 600.0
"""How often the times of last use are written down: what a crash forgets of them."""

_ATTEMPTS = 3
"""How often a record is created or read while others delete and set aside at the same time."""


class GamutNotStoredError(LookupError):
    """There is no (undamaged) gamut of this id, the first argument."""


class GamutDamagedError(GamutNotStoredError):
    """There was a gamut of this id, but damaged; it is in quarantine now.

    Attributes
    ----------
    input_kept : bool
        Whether it can be built again from the input that is kept.
    """

    def __init__(self, gamut_id: str, *, input_kept: bool) -> None:
        super().__init__(gamut_id)
        self.input_kept = input_kept


class GamutStore:
    """The gamuts, and the inputs that they are built from, in some storage.

    Parameters
    ----------
    blobs : Blobs
        The storage.
    keep_inputs : bool
        Whether an input stays when its gamut is published.

    Attributes
    ----------
    hits, misses : int
        Records that were asked for and were there, or were not.
    evictions : int
        Gamuts that had to go for others.
    on_evicted : callable, optional
        Called with the id of a gamut that has been evicted, in some thread.
    """

    def __init__(self, blobs: Blobs, *, keep_inputs: bool = True) -> None:
        self.blobs = blobs
        self.keep_inputs = keep_inputs
        self.hits = self.misses = self.evictions = 0
        self._damaged_jobs = 0
        self.on_evicted: Callable[[str], None] | None = None
        self._quarantine = Quarantine(blobs)
        self._inputs = Inputs(blobs, self._quarantine)
        self._lock = threading.Lock()
        self._publishing: dict[str, int] = {}
        # Local records are read in microseconds, and cannot be deleted by others.
        self._cached = RecordCache(_CACHED_RECORDS, _RECORD_SECONDS if blobs.remote else 0)
        self._used: dict[str, float] = {}
        self._flushed = time.monotonic()
        self._sweeping: threading.Thread | None = None
        self._opened = threading.Event()
        if isinstance(blobs, LocalBlobs):
            blobs.make_room = Eviction(self, blobs).make_room

    @property
    def corruptions(self) -> int:
        """Gamuts, inputs and documents of jobs that were found damaged."""
        return self._quarantine.count + self._damaged_jobs

    @property
    def nbytes(self) -> int | None:
        """Bytes of everything that is stored; None where only the bucket's owner can tell."""
        return self.blobs.used if isinstance(self.blobs, LocalBlobs) else None

    def open(self) -> None:
        """Open the storage (see `Blobs.open`), and remove what no record speaks of from it."""
        self.blobs.open()
        self._opened.set()
        if isinstance(self.blobs, LocalBlobs):
            # In the background, because a million names take seconds to look through.
            self._sweeping = threading.Thread(
                target=remove_uncommitted,
                args=(self.blobs, self.is_being_published, self._opened.is_set),
                name="store sweep",
                daemon=True,
            )
            self._sweeping.start()

    def close(self) -> None:
        """Give the storage up."""
        self._opened.clear()
        if self._sweeping is not None:
            self._sweeping.join()
            self._sweeping = None
            self.flush_uses()
        self.blobs.close()

    def scratch(self, suffix: str) -> Path:
        """Return the name of a new local file for work in progress."""
        return self.blobs.scratch(suffix)

    def publish(self, record: Record, content: Path) -> Record:
        """Make a gamut visible: content first, then, as the commit, its record.

        Parameters
        ----------
        record : Record
            Its digest must be that of `content`.
        content : Path
            A scratch file; it is consumed.

        Returns
        -------
        Record
            The record that is there now: a gamut of this id that was there before stays as it is.
        """
        with self._published_here(record.id):
            try:
                record = self._read_record(record.id)
            except GamutNotStoredError:
                record = replace(record, copy=secrets.token_hex(8))
                # Where this returns None, a request that seemed to have failed was carried out
                # after all: nobody else has this name.
                self.blobs.create(record.key, content)
                record = self._committed(record)
            finally:
                content.unlink(missing_ok=True)
            if not self.keep_inputs:
                self.drop_input(record.id)
        self._cached.put(record)
        return record

    def record(self, gamut_id: str) -> Record:
        """Return the record of a gamut.

        In local storage its history file is there, in its full size.

        Raises
        ------
        GamutNotStoredError
            There is none, or it was damaged (`GamutDamagedError`).
        """
        try:
            record = self._cached.get(gamut_id) or self._read_record(gamut_id)
        except GamutNotStoredError:
            with self._lock:
                self.misses += 1
            raise
        with self._lock:
            self.hits += 1
        self.mark_used(gamut_id)
        if time.monotonic() > self._flushed + _FLUSH_SECONDS:
            self.flush_uses()
        return record

    def stored(self, gamut_id: str) -> bool:
        """Whether there is an undamaged gamut of this id; nobody has asked for it by that."""
        return self._listed(gamut_id) is not None

    def content(self, gamut_id: str) -> tuple[Record, bytes]:
        """Return a gamut's record and its history file, compared with the record's digest.

        Raises
        ------
        GamutNotStoredError
            There is none, or it was damaged (`GamutDamagedError`).
        """
        record, file = self.verified_file(gamut_id)
        with file:
            return record, file.read()

    def verified_file(self, gamut_id: str) -> tuple[Record, BinaryIO]:
        """Return a gamut's record and its open history file, compared with the record's digest.

        The file stays readable through this handle even if the gamut is deleted meanwhile.

        Raises
        ------
        GamutNotStoredError
            There is none, or it was damaged (`GamutDamagedError`).
        """
        record = self.record(gamut_id)
        with contextlib.suppress(BlobNotFoundError, BlobDamagedError):
            return record, self._verified(record)
        # Deleted or replaced since the look at its record, or damaged on the way from there to
        # here: only what is wrong at the second look as well is damaged.
        self._cached.discard(gamut_id)
        record = self._read_record(gamut_id)
        try:
            return record, self._verified(record)
        except (BlobNotFoundError, BlobDamagedError) as error:
            reason = "a record without its history file"
            if isinstance(error, BlobDamagedError):
                reason = "the history file does not match its digest"
            raise self.set_aside(record, reason) from error

    def delete(self, gamut_id: str) -> bool:
        """Remove a gamut and its input; whether there was one."""
        try:
            record = self._read_record(gamut_id)
        except GamutNotStoredError:
            self._cached.discard(gamut_id)
            return False
        deleted = self.blobs.delete(record_key(gamut_id))
        self._cached.discard(gamut_id)
        self._used.pop(gamut_id, None)
        self.blobs.delete(record.key)
        self.drop_input(gamut_id)
        return deleted

    def evict(self, gamut_id: str) -> int:
        """Remove a gamut for the sake of others; return the bytes that this has freed."""
        before = self._nbytes_of(gamut_id)
        if self.is_being_published(gamut_id) or not self.delete(gamut_id):
            return 0
        with self._lock:
            self.evictions += 1
        if self.on_evicted is not None:
            self.on_evicted(gamut_id)
        return before

    def page(self, after: str, limit: int) -> list[Record]:
        """Return up to `limit` records in the order of their ids, from the first after `after`."""
        records: list[Record] = []
        ids = self.ids(after)
        while batch := list(islice(ids, limit - len(records))):
            if self.blobs.remote:
                # One after the other, a page would take seconds.
                with ThreadPoolExecutor(min(_READERS, len(batch))) as threads:
                    found = list(threads.map(self._listed, batch))
            else:
                found = [self._listed(gamut_id) for gamut_id in batch]
            # Some may have been deleted since they were listed, or be damaged.
            records += [record for record in found if record is not None]
        return records

    def ids(self, after: str = "") -> Iterator[str]:
        """Iterate over the ids of the gamuts that follow `after`, in their order."""
        for key in self.blobs.keys("published/", record_key(after) if after else ""):
            if key.endswith(".record"):
                yield id_of(key)

    def set_aside(self, record: Record, reason: str) -> GamutDamagedError:
        """Move a gamut to the quarantine, where it can be looked at but is not served.

        Parameters
        ----------
        record : Record
            What it was read by. If another gamut has the id by now, that one stays.
        reason : str
            What is wrong with it.

        Returns
        -------
        GamutDamagedError
            To be raised.
        """
        return self._damaged(record.id, reason, record)

    def keep_input(
        self,
        gamut_id: str,
        data: bytes,
        options: dict[str, Any] | None = None,
        sha256: str | None = None,
    ) -> None:
        """Store the input of a gamut durably, with its options and the SHA-256 of the data."""
        self._inputs.keep(gamut_id, data, options or {}, sha256 or hashlib.sha256(data).hexdigest())

    def input_path(self, gamut_id: str) -> Path:
        """Return a new scratch file with the verified input of a gamut; the caller removes it.

        Raises
        ------
        BlobNotFoundError
            None is kept, or it was damaged and is in quarantine.
        """
        return self._inputs.path(gamut_id)

    def input_options(self, gamut_id: str) -> dict[str, Any]:
        """Return the options that were kept with an input; `BlobNotFoundError` as for its path."""
        return self._inputs.options(gamut_id)

    def count_damaged_job(self, gamut_id: str) -> None:  # noqa: ARG002 - what a JobBook tells
        """Count a document of a job that was damaged and was replaced or removed."""
        with self._lock:
            self._damaged_jobs += 1

    def options_of_damaged_job(self, gamut_id: str) -> dict[str, Any] | None:
        """Return what the gamut of a damaged job is to be built with; None if it is not."""
        try:
            return None if self.stored(gamut_id) else self.input_options(gamut_id)
        except BlobNotFoundError:
            return None

    def to_be_rebuilt(self, gamut_id: str) -> bool:
        """Whether a gamut that is not there was set aside as damaged, and its input is kept."""
        return self.input_kept(gamut_id) and self._quarantine.holds(record_key(gamut_id))

    def input_kept(self, gamut_id: str) -> bool:
        """Whether the input of a gamut is kept."""
        return self._inputs.kept(gamut_id)

    def drop_input(self, gamut_id: str) -> bool:
        """Remove the input of a gamut; whether there was one."""
        return self._inputs.drop(gamut_id)

    def is_being_published(self, gamut_id: str) -> bool:
        """Whether a thread of this process is just publishing this gamut."""
        return gamut_id in self._publishing

    def mark_used(self, gamut_id: str) -> None:
        """Note that a gamut was asked for: the least recently used are evicted first."""
        if not self.blobs.remote:
            self._used[gamut_id] = time.time()

    def flush_uses(self) -> None:
        """Write down when gamuts were used last: as the modification times of their records."""
        if isinstance(self.blobs, LocalBlobs):
            uses, self._used = self._used, {}
            self._flushed = time.monotonic()
            for gamut_id, when in list(uses.items()):
                self.blobs.touch(record_key(gamut_id), when)

    @contextlib.contextmanager
    def _published_here(self, gamut_id: str) -> Iterator[None]:
        with self._lock:
            self._publishing[gamut_id] = self._publishing.get(gamut_id, 0) + 1
        try:
            yield
        finally:
            with self._lock:
                self._publishing[gamut_id] -= 1
                if not self._publishing[gamut_id]:
                    del self._publishing[gamut_id]

    def _committed(self, record: Record) -> Record:
        """Create a record whose history is stored, and return the one that is there now."""
        try:
            for _ in range(_ATTEMPTS):
                if self.blobs.create(record_key(record.id), record.to_bytes()) is not None:
                    return record
                with contextlib.suppress(GamutNotStoredError):
                    # Somebody else's, or this one: the request may have been sent twice.
                    return self._winner(record)
        except BaseException:
            # A remote record may have been created all the same, a local one has not.
            if not self.blobs.remote:
                self.blobs.delete(record.key)
            raise
        message = "the gamut is being published and deleted at the same time"
        raise StoreUnavailableError(message)

    def _winner(self, record: Record) -> Record:
        present = self._read_record(record.id)
        if present.copy != record.copy:
            self.blobs.delete(record.key)
        return present

    def _listed(self, gamut_id: str) -> Record | None:
        try:
            return self._cached.get(gamut_id) or self._read_record(gamut_id)
        except GamutNotStoredError:
            return None

    def _read_record(self, gamut_id: str) -> Record:
        """Return the record that is in the storage; a damaged one goes to the quarantine."""
        key = record_key(gamut_id)
        for _ in range(_ATTEMPTS):
            try:
                data = self.blobs.read(key).data
            except BlobNotFoundError:
                raise GamutNotStoredError(gamut_id) from None
            record = None
            try:
                record = Record.from_bytes(data)
                flaw = self._flaw(record, gamut_id)
            except (ValueError, TypeError) as error:
                flaw = f"damaged record: {error}"
            if record is not None and not flaw:
                self._cached.put(record)
                return record
        raise self._damaged(gamut_id, flaw, record, data)

    def _flaw(self, record: Record, gamut_id: str) -> str:
        """Return what is wrong with a record that matches its digest; nothing, if empty."""
        if record.id != gamut_id:
            return f"the record of {record.id} under another gamut's name"
        if not self.blobs.remote:
            # Cheap here, and lost bytes are mostly the end of a file.
            try:
                size = self.blobs.size(record.key)
            except BlobNotFoundError:
                return "a record without its history file"
            if size != record.nbytes:
                return f"a history file of {size} instead of {record.nbytes} bytes"
        return ""

    def _verified(self, record: Record) -> BinaryIO:
        """Return a history file that matches the record's digest, at its beginning."""
        file = self.blobs.stream(record.key)
        with contextlib.ExitStack() as closing:
            closing.enter_context(file)
            digest = hashlib.sha256()
            while chunk := file.read(_CHUNK):
                digest.update(chunk)
            if digest.hexdigest() != record.sha256:
                raise BlobDamagedError(record.key)
            file.seek(0)
            closing.pop_all()
        return file

    def _damaged(
        self, gamut_id: str, reason: str, record: Record | None, data: bytes | None = None
    ) -> GamutDamagedError:
        """Move a gamut to the quarantine, unless another has taken its place meanwhile."""
        self._cached.discard(gamut_id)
        histories = []
        if record is not None and record.id == gamut_id:
            histories = [record.key]
        elif not self.blobs.remote and not self.is_being_published(gamut_id):
            # Which of them the record meant is not known; elsewhere one may be in the making.
            histories = [key for key in self._keys_of(gamut_id) if key.endswith(".gamut")]
        # The record first: without it the rest is no gamut.
        self._quarantine.put(
            [record_key(gamut_id), *histories], reason, lambda now: _is_still(now, record, data)
        )
        return GamutDamagedError(gamut_id, input_kept=self.input_kept(gamut_id))

    def _keys_of(self, gamut_id: str) -> list[str]:
        """Return the keys of all that is published of one gamut, without its input."""
        folder = record_key(gamut_id).rpartition("/")[0] + "/"
        keys = self.blobs.keys(folder, folder + gamut_id)
        return list(takewhile(lambda key: id_of(key) == gamut_id, keys))

    def _nbytes_of(self, gamut_id: str) -> int:
        total = self._inputs.nbytes(gamut_id)
        for key in self._keys_of(gamut_id):
            with contextlib.suppress(BlobNotFoundError):
                total += self.blobs.size(key)
        return total


def _is_still(now: bytes, record: Record | None, data: bytes | None) -> bool:
    """Whether a record's bytes are those, or else the record that, which was found wanting."""
    if data is not None:
        return now == data
    try:
        return Record.from_bytes(now) == record
    except (ValueError, TypeError):
        return True
