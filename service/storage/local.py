"""Blobs as files of a directory, which belongs to one process at a time.

A new blob is written to ``temporary/``, synced and linked under its name, which fails if the name
exists. Then its directory is synced, and only then the blob is acknowledged. A replacement is
renamed over the old file in the same way. Leftovers of a crash in ``temporary/`` are removed at the
next opening. Space is reserved before writing, against the limit and the free disk space. See
``docs/decisions/store.md``.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import logging
import os
import re
import secrets
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, BinaryIO

from service.storage.blobs import (
    SCRATCH_FOLDER,
    UNVERSIONED,
    Blob,
    BlobNotFoundError,
    Content,
    StoreFullError,
)

__all__ = ["LocalBlobs", "StoreInUseError"]

logger = logging.getLogger(__name__)

_KEY = re.compile(r"[a-z0-9][a-z0-9._-]*(/[a-z0-9][a-z0-9._-]*)+")

_LOCKS = 64
"""Number of locks that the keys share."""

_SMALL = 64 * 1024
"""Largest blob in bytes that may use the reserve. Records and jobs are smaller."""

_FULL = frozenset({errno.ENOSPC, errno.EDQUOT})


class StoreInUseError(RuntimeError):
    """Another process has the directory open."""


class LocalBlobs:
    """Blobs as files of a directory, with at most `limit` bytes in all (0 for no limit).

    Only small blobs, replacements and scratch files may use the last `reserve` bytes of the file
    system, so an admitted build can finish. `make_room` receives the number of missing bytes and
    returns whether it freed any.
    """

    remote = False

    def __init__(self, directory: Path, limit: int = 0, reserve: int = 0) -> None:
        self.directory = directory.absolute()
        self.limit = limit
        self.make_room: Callable[[int], bool] | None = None
        # Total size of all blobs. Without a limit it is known only some time after the opening.
        self.used = 0
        self._reserve = reserve
        self._temporary = self.directory / "temporary"
        self._lock: IO[bytes] | None = None
        self._key_locks = [threading.Lock() for _ in range(_LOCKS)]
        self._accounts = threading.Lock()
        self._reserved = 0
        self._reserved_on_disk = 0
        self._durable: set[Path] = set()
        self._counting: threading.Thread | None = None
        self._opened = threading.Event()

    def open(self) -> None:
        """Lock the directory, remove leftovers of an earlier process, and count the bytes.

        Raise `StoreInUseError` if another process has the directory open, and OSError if the
        directory is not writable.
        """
        self._temporary.mkdir(parents=True, exist_ok=True)
        lock = (self.directory / "lock").open("ab")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            lock.close()
            message = (
                f"The store {self.directory} is in use by another process. "
                "Stop it, or choose another directory with GAMUT_STORE."
            )
            raise StoreInUseError(message) from error
        self._lock = lock
        for leftover in self._temporary.iterdir():
            if leftover.name.startswith(SCRATCH_FOLDER):
                shutil.rmtree(leftover, ignore_errors=True)
            elif leftover.is_dir() and not leftover.is_symlink():
                # Not made by this program, so it is not removed.
                logger.warning("%s was not made by the service and is kept", leftover)
            else:
                leftover.unlink()
        self.used = 0
        self._opened.set()
        if self.limit:
            # The limit needs an exact count before the first new blob.
            self._count(time.time() + 1)
        else:
            self._counting = threading.Thread(
                target=self._count, args=(time.time(),), name="store count", daemon=True
            )
            self._counting.start()

    def close(self) -> None:
        """Unlock the directory."""
        self._opened.clear()
        if self._counting is not None:
            self._counting.join()
            self._counting = None
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def read(self, key: str) -> Blob:
        """Return a blob; raises `BlobNotFoundError` if there is none."""
        with _missing_blob(key):
            data = self.path(key).read_bytes()
        return Blob(data, _version(data))

    def stream(self, key: str) -> BinaryIO:
        """Return a blob as a file; raises `BlobNotFoundError` if there is none."""
        with _missing_blob(key):
            return self.path(key).open("rb")

    def size(self, key: str) -> int:
        """Return the size of a blob in bytes; raises `BlobNotFoundError` if there is none."""
        return self.stat(key).st_size

    def stat(self, key: str) -> os.stat_result:
        """Return the file status of a blob; raises `BlobNotFoundError` if there is none."""
        with _missing_blob(key):
            return self.path(key).stat()

    def create(self, key: str, content: Content) -> str | None:
        """Store a new blob; see `Blobs.create`."""
        path = self.path(key)
        on_disk = isinstance(content, Path)
        try:
            while True:
                if path.exists():
                    # Another writer's blob may not be on the disk yet, but the caller relies on it.
                    _sync(path.parent)
                    return None
                nbytes = _nbytes(content)
                with self._reserve_space(nbytes, on_disk=on_disk):
                    try:
                        return self._link(path, content, nbytes)
                    except OSError as error:
                        # The accounts do not include other programs, quotas and inodes.
                        if error.errno not in _FULL:
                            raise
                        if self.make_room is None or not self.make_room(nbytes):
                            raise StoreFullError from error
        finally:
            if isinstance(content, Path):
                content.unlink(missing_ok=True)

    def replace(self, key: str, data: bytes, version: str) -> str | None:
        """Replace the content if it has this version; see `Blobs.replace`."""
        path = self.path(key)
        with self._lock_of(key):
            try:
                present = path.read_bytes()
            except FileNotFoundError:
                return None
            if _version(present) != version:
                return None
            new = self._write(data)
            try:
                new.replace(path)
            except OSError:
                new.unlink(missing_ok=True)
                raise
            self._add(len(data) - len(present))
            _sync(path.parent)
        return _version(data)

    def delete(self, key: str) -> bool:
        """Remove a blob; return whether there was one."""
        path = self.path(key)
        with self._lock_of(key):
            try:
                nbytes = path.stat().st_size
                path.unlink()
            except FileNotFoundError:
                return False
            self._add(-nbytes)
        _sync(path.parent)
        return True

    def move(self, key: str, to: str) -> bool:
        """Rename a blob to an unused key; return whether there was one."""
        path, target = self.path(key), self.path(to)
        self._make_folder(target.parent)
        with self._lock_of(key):
            try:
                path.rename(target)
            except FileNotFoundError:
                return False
        _sync(target.parent)
        _sync(path.parent)
        return True

    def keys(self, prefix: str, after: str = "") -> Iterator[str]:
        """Iterate over the keys with a prefix, after the key `after`, in their order."""
        try:
            with os.scandir(self.directory / prefix) as entries:
                # Folder names sort with the slash that follows them in keys.
                names = sorted(
                    f"{entry.name}/" if entry.is_dir(follow_symlinks=False) else entry.name
                    for entry in entries
                )
        except FileNotFoundError:
            return
        for name in names:
            key = prefix + name
            if name.endswith("/"):
                if key != "temporary/" and (key > after or after.startswith(key)):
                    yield from self.keys(key, after)
            elif key > after and _KEY.fullmatch(key):
                yield key

    def scratch(self, suffix: str) -> Path:
        """Return the name of a new file in ``temporary/``."""
        return self._temporary / f"{secrets.token_hex(16)}{suffix}"

    def path(self, key: str) -> Path:
        """Return the path of a blob, whether or not it exists."""
        if not _KEY.fullmatch(key) or key.startswith("temporary/"):
            message = f"{key!r} is not a valid key"
            raise ValueError(message)
        return self.directory / key

    def touch(self, key: str, when: float) -> None:
        """Set the modification time of a blob, if there is one."""
        with contextlib.suppress(FileNotFoundError):
            os.utime(self.path(key), (when, when))

    def _link(self, path: Path, content: Content, nbytes: int) -> str | None:
        if isinstance(content, Path):
            source = content
            _sync(source)
        else:
            source = self._write(*([content] if isinstance(content, bytes) else content))
        version = _version(content) if isinstance(content, bytes) else UNVERSIONED
        try:
            self._make_folder(path.parent)
            try:
                os.link(source, path)
            except FileExistsError:
                _sync(path.parent)
                return None
            self._add(nbytes)
            try:
                _sync(path.parent)
            except OSError:
                # The blob is not acknowledged, so it must not exist.
                path.unlink(missing_ok=True)
                self._add(-nbytes)
                raise
        finally:
            if source is not content:
                source.unlink(missing_ok=True)
        return version

    def _write(self, *pieces: bytes) -> Path:
        """Return a new, synced file in ``temporary/``; leave none if the disk is full."""
        path = self.scratch(".new")
        try:
            with path.open("xb") as file:
                file.writelines(pieces)
                file.flush()
                os.fsync(file.fileno())
        except OSError:
            path.unlink(missing_ok=True)
            raise
        return path

    def _make_folder(self, folder: Path) -> None:
        """Make a folder durably, including its parents up to the store's directory."""
        if folder in self._durable and folder.is_dir():
            return
        folder.mkdir(parents=True, exist_ok=True)
        for parent in folder.parents:
            _sync(parent)
            if parent == self.directory:
                break
        self._durable.add(folder)

    @contextlib.contextmanager
    def _reserve_space(self, nbytes: int, *, on_disk: bool) -> Iterator[None]:
        """Reserve space against the limit and the disk meanwhile; raises `StoreFullError`."""
        new_on_disk = 0 if on_disk else nbytes
        while True:
            with self._accounts:
                missing = self._missing(nbytes, on_disk=on_disk)
                if missing <= 0:
                    self._reserved += nbytes
                    self._reserved_on_disk += new_on_disk
                    break
            if self.limit and nbytes > self.limit:
                message = f"{nbytes} bytes exceed the size limit of the store"
                raise StoreFullError(message)
            if self.make_room is None or not self.make_room(missing):
                raise StoreFullError
        try:
            yield
        finally:
            with self._accounts:
                self._reserved -= nbytes
                self._reserved_on_disk -= new_on_disk

    def _missing(self, nbytes: int, *, on_disk: bool) -> int:
        over = self.used + self._reserved + nbytes - self.limit if self.limit else 0
        if on_disk or nbytes <= _SMALL:
            return over
        disk = os.statvfs(self.directory)
        needed = self._reserve + self._reserved_on_disk + nbytes
        return max(over, needed - disk.f_bavail * disk.f_frsize)

    def _add(self, nbytes: int) -> None:
        with self._accounts:
            self.used += nbytes

    def _count(self, until: float) -> None:
        """Count the blobs that existed before `until`. Later blobs count themselves."""
        total = 0
        for key in self.keys(""):
            if not self._opened.is_set():
                return
            with contextlib.suppress(BlobNotFoundError):
                status = self.stat(key)
                total += status.st_size if status.st_ctime < until else 0
        self._add(total)

    def _lock_of(self, key: str) -> threading.Lock:
        return self._key_locks[hash(key) % _LOCKS]


@contextlib.contextmanager
def _missing_blob(key: str) -> Iterator[None]:
    """Turn the error of a missing file into that of a missing blob."""
    try:
        yield
    except FileNotFoundError:
        raise BlobNotFoundError(key) from None


def _version(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _nbytes(content: Content) -> int:
    if isinstance(content, Path):
        return content.stat().st_size
    return len(content) if isinstance(content, bytes) else sum(map(len, content))


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
