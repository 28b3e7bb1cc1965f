"""The gamut store: gamuts are published atomically and verified when read.

A gamut is two blobs: its history file, byte for byte as clients download it, and its record with
the description and the file's SHA-256. Every publication stores the history under a unique name
``published/<aa>/<id>.<copy>.gamut``. Then it exclusively creates ``published/<aa>/<id>.record``,
which names the copy. So a gamut exists exactly when its record exists, and concurrent publishers
and deleters on any machines never share bytes.

Reads compare the history with the record's digest, and the record with its own. Damaged blobs are
moved to ``quarantine/<name>.<mark>``, with the reason beside them, and count as never built.

The input of a build is durable before a client learns that its job was accepted, so the job
survives the process. It stays as ``inputs/<aa>/<id>.input``, so that a damaged gamut can be
rebuilt. It has three parts: the SHA-256 of the next line, a line of JSON with the options and the
SHA-256 of the data, and the data as posted. See ``docs/decisions/store.md``.

The device model of a gamut is made from its input when it is first asked for, and kept, sealed, as
``models/<aa>/<id>.model``.

All methods block; the event loop calls them in threads.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import logging
import secrets
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import islice, takewhile
from pathlib import Path
from typing import Any, BinaryIO

from service.storage.blobs import (
    BlobDamagedError,
    BlobNotFoundError,
    Blobs,
    StoreFullError,
    StoreUnavailableError,
    seal,
    stored_bytes,
    unseal,
)
from service.storage.eviction import Eviction, remove_uncommitted
from service.storage.gamut_names import Names, Owners
from service.storage.local import LocalBlobs
from service.storage.published import PublishedCache, PublishedGamut, blob_key, id_of
from service.storage.uses import GamutUses

__all__ = ["GamutDamagedError", "GamutNotStoredError", "GamutStore"]

# Log fields are a promise, so the name is not that of this module.
logger = logging.getLogger("service.storage.quarantine")

_CHUNK = 1 << 20

_HEAD_LIMIT = 1 << 20
"""Largest line of options in bytes. A few hundred are usual."""

_CACHED_RECORDS = 10_000
"""Number of records of a remote store in memory; each has a few kilobytes."""

_RECORD_SECONDS = 60.0
"""Seconds for which a remote gamut is assumed to exist. Another replica may delete it."""

_READERS = 16
"""Number of simultaneous reads of remote records for a page."""

_ATTEMPTS = 3
"""Number of attempts to create or read a record or an input during concurrent deletes."""


class GamutNotStoredError(LookupError):
    """There is no intact gamut with this id, the first argument."""


class GamutDamagedError(GamutNotStoredError):
    """The gamut was damaged and is now in quarantine.

    `input_kept` tells whether it can be rebuilt from its stored input.
    """

    def __init__(self, gamut_id: str, *, input_kept: bool) -> None:
        super().__init__(gamut_id)
        self.input_kept = input_kept


class GamutStore:
    """The gamuts and their inputs in a storage.

    With `keep_inputs`, inputs stay after the publication. `hits` and `misses` count requested
    records, `corruptions` damaged gamuts, inputs and job documents, and `evictions` gamuts removed
    for lack of space; `on_evicted` receives their ids, in some thread.
    """

    def __init__(self, blobs: Blobs, *, keep_inputs: bool = True) -> None:
        self.blobs = blobs
        self.names = Names(blobs)
        self.owners = Owners(blobs)
        self.uses = GamutUses(blobs)
        self.keep_inputs = keep_inputs
        self.hits = self.misses = self.corruptions = self.evictions = 0
        self.on_evicted: Callable[[str], None] | None = None
        self._lock = threading.Lock()
        self._quarantine_lock = threading.Lock()
        # Local records are read in microseconds, so only remote ones are cached.
        self._cached = PublishedCache(_CACHED_RECORDS, _RECORD_SECONDS if blobs.remote else 0)
        self._sweeping: threading.Thread | None = None
        self._opened = threading.Event()
        self._eviction: Eviction | None = None
        if isinstance(blobs, LocalBlobs):
            self._eviction = Eviction(blobs, self.uses, self.evict)
            blobs.make_room = self._eviction.make_room

    @property
    def nbytes(self) -> int | None:
        """Stored bytes; None for a bucket."""
        return self.blobs.used if isinstance(self.blobs, LocalBlobs) else None

    def open(self) -> None:
        """Open the storage (see `Blobs.open`) and remove histories without a record."""
        self.blobs.open()
        self._opened.set()
        if isinstance(self.blobs, LocalBlobs):
            # In the background, because scanning a million names takes seconds.
            self._sweeping = threading.Thread(
                target=remove_uncommitted,
                args=(self.blobs, self.uses, self._opened.is_set),
                name="store sweep",
                daemon=True,
            )
            self._sweeping.start()

    def close(self) -> None:
        """Close the storage."""
        self._opened.clear()
        if self._sweeping is not None:
            self._sweeping.join()
            self._sweeping = None
            self.uses.flush()
        self.blobs.close()

    def scratch(self, suffix: str) -> Path:
        """Return the name of a new local file for work in progress."""
        return self.blobs.scratch(suffix)

    def publish(self, record: PublishedGamut, content: Path) -> PublishedGamut:
        """Publish a gamut: store the content first, then commit with the record.

        `record` has the digest of `content`, a scratch file, which is consumed. The result is the
        current record: an existing gamut of this id is not changed.
        """
        with self._mark_publishing(record.id):
            try:
                record = self._read_record(record.id)
            except GamutNotStoredError:
                record = replace(record, copy=secrets.token_hex(8))
                # None means that an earlier attempt succeeded although it seemed to fail: the name
                # is unique.
                self.blobs.create(record.key, content)
                record = self._commit(record)
            finally:
                content.unlink(missing_ok=True)
            if not self.keep_inputs:
                self.drop_input(record.id)
            self.uses.mark(record.id)
        self._cached.put(record)
        return record

    def record(self, gamut_id: str) -> PublishedGamut:
        """Return the record of a gamut; raise `GamutNotStoredError` if there is no intact one.

        In local storage, the history file exists with its full size. While a bucket does not
        answer, the record that was read last is returned.
        """
        try:
            record = self._cached.get(gamut_id) or self._read_record(gamut_id)
        except GamutNotStoredError:
            with self._lock:
                self.misses += 1
            raise
        except StoreUnavailableError:
            if (known := self._cached.get(gamut_id, stale=True)) is None:
                raise
            record = known
            self._cached.put(record)
        with self._lock:
            self.hits += 1
        self.uses.mark(gamut_id)
        self.uses.flush_if_due()
        return record

    def is_current(self, gamut_id: str) -> bool:
        """Return whether what is in memory of a gamut may be used without asking for its record.

        A directory belongs to one process. In a bucket, another replica may have deleted the gamut
        since it was asked for.
        """
        return not self.blobs.remote or self._cached.get(gamut_id) is not None

    def is_stored(self, gamut_id: str) -> bool:
        """Return whether there is an intact gamut. This does not count as a use."""
        return self._find_record(gamut_id) is not None

    def content(self, gamut_id: str) -> tuple[PublishedGamut, bytes]:
        """Return a gamut's record and its verified history file; raises as `record` does."""
        record, file = self.verified_file(gamut_id)
        with file:
            return record, file.read()

    def verified_file(self, gamut_id: str) -> tuple[PublishedGamut, BinaryIO]:
        """Return a gamut's record and its open, verified history file; raises as `record` does.

        The handle stays readable if the gamut is deleted meanwhile.
        """
        record = self.record(gamut_id)
        with contextlib.suppress(BlobNotFoundError, BlobDamagedError):
            return record, self._open_verified(record)
        # Deleted, replaced or damaged in transit since the record was read. Only a fault at the
        # second read counts as damage.
        self._cached.discard(gamut_id)
        record = self._read_record(gamut_id)
        try:
            return record, self._open_verified(record)
        except BlobNotFoundError as error:
            raise self.set_aside(record, "a record without its history file") from error
        except BlobDamagedError as error:
            raise self.set_aside(record, "the history file does not match its digest") from error

    def delete(self, gamut_id: str) -> bool:
        """Remove a gamut and its input; return whether there was one."""
        try:
            record = self._read_record(gamut_id)
        except GamutNotStoredError:
            self._cached.discard(gamut_id)
            return False
        deleted = self.blobs.delete(blob_key(gamut_id, "record"))
        self._cached.discard(gamut_id)
        self.uses.discard(gamut_id)
        self.blobs.delete(record.key)
        self.drop_input(gamut_id)
        self.blobs.delete(blob_key(gamut_id, "model"))
        self.names.drop(gamut_id)
        self.owners.drop(gamut_id)
        return deleted

    def evict(self, gamut_id: str) -> int:
        """Remove a gamut for lack of space; return the number of freed bytes."""
        others = [blob_key(gamut_id, kind) for kind in ("input", "model")]
        keys = [*others, *self._keys_of(gamut_id)]
        nbytes = sum(stored_bytes(self.blobs, key) for key in keys)
        if self.uses.is_being_published(gamut_id) or not self.delete(gamut_id):
            return 0
        with self._lock:
            self.evictions += 1
        if self.on_evicted is not None:
            self.on_evicted(gamut_id)
        return nbytes

    def page(self, after: str, limit: int) -> list[PublishedGamut]:
        """Return up to `limit` records after the id `after`, in the order of their ids."""
        records: list[PublishedGamut] = []
        ids = self.ids(after)
        while batch := list(islice(ids, limit - len(records))):
            if self.blobs.remote:
                # Sequential reads would take seconds per page.
                with ThreadPoolExecutor(min(_READERS, len(batch))) as threads:
                    stored = list(threads.map(self._find_record, batch))
            else:
                stored = [self._find_record(gamut_id) for gamut_id in batch]
            # Some may be deleted or damaged since the listing.
            records += [record for record in stored if record is not None]
        return records

    def ids(self, after: str = "") -> Iterator[str]:
        """Iterate over the ids of the gamuts after `after`, in their order."""
        for key in self.blobs.keys("published/", blob_key(after, "record") if after else ""):
            if key.endswith(".record"):
                yield id_of(key)

    def set_aside(self, record: PublishedGamut, reason: str) -> GamutDamagedError:
        """Move a gamut to the quarantine, and return the error to raise.

        `record` is the record that the gamut was read with. A newer gamut with the same id is not
        moved.
        """

        def is_still(now: bytes) -> bool:
            try:
                return PublishedGamut.from_bytes(now) == record
            except (ValueError, TypeError):
                return True

        return self._quarantine_gamut(record.id, reason, record, is_still)

    def keep_input(
        self,
        gamut_id: str,
        data: bytes,
        options: dict[str, Any] | None = None,
        sha256: str | None = None,
    ) -> None:
        """Store the input of a gamut durably; an existing intact input is used instead.

        `sha256` is the hexadecimal digest of the data, if known.
        """
        head = {"options": options or {}, "sha256": sha256 or hashlib.sha256(data).hexdigest()}
        line = json.dumps(head, separators=(",", ":")).encode() + b"\n"
        pieces = [hashlib.sha256(line).hexdigest().encode() + b"\n", line, data]
        for _ in range(_ATTEMPTS):
            if self.blobs.create(blob_key(gamut_id, "input"), pieces) is not None:
                break
            with contextlib.suppress(BlobNotFoundError):
                self.input_options(gamut_id)
                break
        else:
            message = "the input is being stored and dropped at the same time"
            raise StoreUnavailableError(message)
        self._note(gamut_id)

    def copy_submission(self, gamut_id: str, to: str) -> None:
        """Give another gamut the input, names and owner that were sent for a gamut."""
        path = self.input_path(gamut_id)
        try:
            self.keep_input(to, path.read_bytes(), self.input_options(gamut_id))
        finally:
            path.unlink(missing_ok=True)
        name, owner = self.names.read(gamut_id), self.owners.read(gamut_id)
        if name.file:
            self.names.keep_file(to, name.file)
        if name.given and not self.names.read(to).given:
            self.names.give(to, name.given)
        if owner:
            self.owners.claim(to, owner)

    def drop_submission(self, gamut_id: str) -> None:
        """Remove the input, names and owner that were sent for a gamut."""
        self.drop_input(gamut_id)
        self.names.drop(gamut_id)
        self.owners.drop(gamut_id)

    def input_path(self, gamut_id: str) -> Path:
        """Return a new scratch file with the verified input of a gamut; the caller removes it.

        Raise `BlobNotFoundError` if no input is stored, or if it was damaged and is in quarantine.
        """
        path = self.blobs.scratch(".input")
        try:
            with path.open("xb") as target:
                self._read_input(gamut_id, target)
        except BaseException:
            path.unlink(missing_ok=True)
            raise
        return path

    def input_options(self, gamut_id: str) -> dict[str, Any]:
        """Return the options of a verified input; raises `BlobNotFoundError` as `input_path`."""
        return self._read_input(gamut_id, None)

    def device_model(self, gamut_id: str) -> bytes | None:
        """Return the device model of a gamut; None if there is none, or a damaged one."""
        key = blob_key(gamut_id, "model")
        try:
            return unseal(self.blobs.read(key).data)
        except BlobNotFoundError:
            return None
        except BlobDamagedError:
            self.blobs.delete(key)
            with self._lock:
                self.corruptions += 1
            return None

    def keep_device_model(self, gamut_id: str, data: bytes) -> None:
        """Store the device model of a gamut, unless there is one or the gamut is gone."""
        key = blob_key(gamut_id, "model")
        self.blobs.create(key, seal(data))
        if not self.is_stored(gamut_id):
            self.blobs.delete(key)

    def count_damaged_job(self, gamut_id: str) -> None:  # noqa: ARG002 - the interface of JobBook
        """Count a damaged job document that was replaced or removed."""
        with self._lock:
            self.corruptions += 1

    def options_of_damaged_job(self, gamut_id: str) -> dict[str, Any] | None:
        """Return the options for rebuilding a damaged job's gamut; None if impossible."""
        try:
            return None if self.is_stored(gamut_id) else self.input_options(gamut_id)
        except BlobNotFoundError:
            return None

    def to_be_rebuilt(self, gamut_id: str) -> bool:
        """Return whether a missing gamut is in quarantine and its input is stored."""
        if not self.input_kept(gamut_id):
            return False
        beginning = _quarantine_key(blob_key(gamut_id, "record"), "")
        return next(self.blobs.keys("quarantine/", beginning), "").startswith(beginning)

    def input_kept(self, gamut_id: str) -> bool:
        """Return whether the input of a gamut is stored."""
        return self.input_bytes(gamut_id) > 0

    def input_bytes(self, gamut_id: str) -> int:
        """Return the size of the stored input of a gamut; 0 if there is none."""
        return stored_bytes(self.blobs, blob_key(gamut_id, "input"))

    def drop_input(self, gamut_id: str) -> bool:
        """Remove the input of a gamut; return whether there was one."""
        return self.blobs.delete(blob_key(gamut_id, "input"))

    def _note(self, gamut_id: str) -> None:
        if self._eviction is not None:
            self._eviction.note(gamut_id)

    @contextlib.contextmanager
    def _mark_publishing(self, gamut_id: str) -> Iterator[None]:
        try:
            with self.uses.publishing(gamut_id):
                yield
        finally:
            self._note(gamut_id)

    def _commit(self, record: PublishedGamut) -> PublishedGamut:
        """Create the record of a stored history, and return the current record."""
        try:
            for _ in range(_ATTEMPTS):
                if self.blobs.create(blob_key(record.id, "record"), record.to_bytes()) is not None:
                    return record
                with contextlib.suppress(GamutNotStoredError):
                    # Another publisher's record, or this one: the request may have been sent twice.
                    present = self._read_record(record.id)
                    if present.copy != record.copy:
                        self.blobs.delete(record.key)
                    return present
        except BaseException:
            # A remote record may exist in spite of the error, a local one does not.
            if not self.blobs.remote:
                self.blobs.delete(record.key)
            raise
        message = "The gamut is being published and deleted at the same time."
        raise StoreUnavailableError(message)

    def _find_record(self, gamut_id: str) -> PublishedGamut | None:
        try:
            return self._cached.get(gamut_id) or self._read_record(gamut_id)
        except GamutNotStoredError:
            return None

    def _read_record(self, gamut_id: str) -> PublishedGamut:
        """Return the stored record; move a damaged one to the quarantine."""
        key = blob_key(gamut_id, "record")
        for _ in range(_ATTEMPTS):
            try:
                data = self.blobs.read(key).data
            except BlobNotFoundError:
                raise GamutNotStoredError(gamut_id) from None
            record = None
            try:
                record = PublishedGamut.from_bytes(data)
                flaw = self._flaw(record, gamut_id)
            except (ValueError, TypeError) as error:
                flaw = f"damaged record: {error}"
            if record is not None and not flaw:
                self._cached.put(record)
                return record
        raise self._quarantine_gamut(gamut_id, flaw, record, lambda now: now == data)

    def _flaw(self, record: PublishedGamut, gamut_id: str) -> str:
        """Return the fault of a record that matches its digest; empty if there is none."""
        if record.id != gamut_id:
            return f"the record of {record.id} under another gamut's name"
        if not self.blobs.remote:
            # A cheap check of local files, which mostly lose bytes at the end.
            try:
                size = self.blobs.size(record.key)
            except BlobNotFoundError:
                return "a record without its history file"
            if size != record.nbytes:
                return f"a history file of {size} instead of {record.nbytes} bytes"
        return ""

    def _open_verified(self, record: PublishedGamut) -> BinaryIO:
        """Return a history file that matches the record's digest, at its start."""
        with contextlib.ExitStack() as closing:
            file = closing.enter_context(self.blobs.stream(record.key))
            digest = hashlib.sha256()
            while chunk := file.read(_CHUNK):
                digest.update(chunk)
            if digest.hexdigest() != record.sha256:
                raise BlobDamagedError(record.key)
            file.seek(0)
            closing.pop_all()
            return file

    def _read_input(self, gamut_id: str, target: BinaryIO | None) -> dict[str, Any]:
        """Return the options and copy the data; move a damaged input to the quarantine."""
        key = blob_key(gamut_id, "input")
        for last in (False, True):
            with self.blobs.stream(key) as source:
                try:
                    return _copy_verified(source, target)
                except BlobDamagedError as error:
                    # It may have been damaged in transit only, so it is read twice.
                    if last:
                        self._quarantine([key], f"damaged input: {error}")
            if target is not None:
                target.seek(0)
                target.truncate()
        raise BlobNotFoundError(key)

    def _quarantine_gamut(
        self,
        gamut_id: str,
        reason: str,
        record: PublishedGamut | None,
        is_still: Callable[[bytes], bool],
    ) -> GamutDamagedError:
        """Move a gamut to the quarantine, unless a newer one has replaced it (`is_still`)."""
        self._cached.discard(gamut_id)
        histories = []
        if record is not None and record.id == gamut_id:
            histories = [record.key]
        elif not self.blobs.remote and not self.uses.is_being_published(gamut_id):
            # The record does not tell which copy it named. In a bucket, another process may be
            # publishing one.
            histories = [key for key in self._keys_of(gamut_id) if key.endswith(".gamut")]
        # The record first, because without it the rest is not a gamut.
        self._quarantine([blob_key(gamut_id, "record"), *histories], reason, is_still)
        return GamutDamagedError(gamut_id, input_kept=self.input_kept(gamut_id))

    def _quarantine(
        self, keys: Sequence[str], reason: str, is_still: Callable[[bytes], bool] | None = None
    ) -> None:
        """Move blobs that belong together to the quarantine.

        The first key is the main one: the others are useless without it. `is_still` tells whether
        its current content is still the damaged one.
        """
        first, mark = keys[0], secrets.token_hex(4)
        with self._quarantine_lock:
            if is_still is not None:
                try:
                    if not is_still(self.blobs.read(first).data):
                        return
                except BlobNotFoundError:
                    return
            if not self.blobs.move(first, _quarantine_key(first, mark)):
                return
        with self._lock:
            self.corruptions += 1
        logger.error("%s moved to quarantine: %s", first, reason)
        for key in keys[1:]:
            self.blobs.move(key, _quarantine_key(key, mark))
        when = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        note = f"{when} {reason}\n" + "".join(f"{key}\n" for key in keys)
        try:
            self.blobs.create(f"{_quarantine_key(first, mark)}.reason", note.encode())
        except StoreFullError:
            logger.warning("no space for the reason of %s", first)

    def _keys_of(self, gamut_id: str) -> list[str]:
        """Return the published keys of one gamut, without its input."""
        folder = blob_key(gamut_id, "record").rpartition("/")[0] + "/"
        keys = self.blobs.keys(folder, folder + gamut_id)
        return list(takewhile(lambda key: id_of(key) == gamut_id, keys))


def _quarantine_key(key: str, mark: str) -> str:
    return f"quarantine/{key.rpartition('/')[2]}.{mark}"


def _copy_verified(source: BinaryIO, target: BinaryIO | None) -> dict[str, Any]:
    """Return the options of an input, and copy its data to `target` if there is one.

    Raise `BlobDamagedError` if the content does not match its digests.
    """
    expected = source.read(65)
    line = source.readline(_HEAD_LIMIT)
    digest = hashlib.sha256(line)
    head: dict[str, Any] = {}
    if digest.hexdigest().encode() + b"\n" == expected:
        head = json.loads(line)
    if "sha256" in head:
        expected, digest = head["sha256"].encode() + b"\n", hashlib.sha256()
    # Otherwise the first line is the digest of everything after it, as earlier versions wrote it.
    while chunk := source.read(_CHUNK):
        digest.update(chunk)
        if target is not None:
            target.write(chunk)
    if digest.hexdigest().encode() + b"\n" != expected:
        message = "the content does not match its digest"
        raise BlobDamagedError(message)
    options: dict[str, Any] = head["options"] if "sha256" in head else json.loads(line)
    return options
