"""Blobs as files of one directory, which belongs to one process on one host at a time.

A new blob is written to a file in ``temporary/``, synced, linked under its name, which fails if
there is one, and the directory is synced: only then is it acknowledged. A replacement is renamed
over the old content in the same way. Whatever a crash or a power cut leaves in ``temporary/`` is
swept when the directory is opened again. Every byte of a new blob is reserved before it is
written, against the limit and against the free space of the disk. See ``docs/decisions/store.md``.
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
import threading
import time
from pathlib import Path
from typing import IO, TYPE_CHECKING

from service.storage.blobs import UNVERSIONED, Blob, BlobNotFoundError, Content, StoreFullError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import BinaryIO

__all__ = ["LocalBlobs", "StoreInUseError"]

logger = logging.getLogger(__name__)

_KEY = re.compile(r"[a-z0-9][a-z0-9._-]*(/[a-z0-9][a-z0-9._-]*)+")

_LOCKS = 64
"""Locks that the keys share: two keys seldom wait for each other."""

_SMALL = 64 * 1024
"""Bytes of the largest blob that may use the reserve: records and jobs have less."""

_FULL = frozenset({errno.ENOSPC, errno.EDQUOT})


class StoreInUseError(RuntimeError):
    """Another process has the directory open."""


class LocalBlobs:
    """Blobs as files of a directory.

    Parameters
    ----------
    directory : Path
        Created if it is not there. `open` locks it for this process.
    limit : int
        Bytes that all blobs together may have; 0 for no limit.
    reserve : int
        Bytes of the file system that new blobs leave free. What is small, a replacement, or a file
        of this directory already may use them: so what was admitted, by storing its input, can be
        finished and its state be written even when the disk is as good as full.

    Attributes
    ----------
    make_room : callable, optional
        Called with a number of bytes that are missing; frees some and returns True, or returns
        False if nothing may go.
    """

    remote = False

    def __init__(self, directory: Path, limit: int = 0, reserve: int = 0) -> None:
        self.directory = directory.absolute()
        self.limit = limit
        self.make_room: Callable[[int], bool] | None = None
        self._reserve_bytes = reserve
        self._temporary = self.directory / "temporary"
        self._lock: IO[bytes] | None = None
        self._key_locks = [threading.Lock() for _ in range(_LOCKS)]
        self._accounts = threading.Lock()
        self._used = 0
        self._reserved = 0
        self._reserved_on_disk = 0
        self._durable: set[Path] = set()
        self._counting: threading.Thread | None = None
        self._opened = threading.Event()

    @property
    def used(self) -> int:
        """Bytes of all blobs. Without a limit it is known some time after the opening only."""
        return self._used

    def open(self) -> None:
        """Lock the directory, remove what an earlier process left unfinished, count the bytes.

        Raises
        ------
        StoreInUseError
            Another process has the directory open.
        OSError
            The directory cannot be written.
        """
        self._temporary.mkdir(parents=True, exist_ok=True)
        lock = (self.directory / "lock").open("ab")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            lock.close()
            message = (
                f"the store {self.directory} is in use by another process; "
                "stop it, or choose another directory with GAMUT_STORE"
            )
            raise StoreInUseError(message) from error
        self._lock = lock
        for leftover in self._temporary.iterdir():
            if leftover.is_dir() and not leftover.is_symlink():
                # None of this program's; what it is not sure of it does not remove.
                logger.warning("%s is not the service's and stays", leftover)
            else:
                leftover.unlink()
        self._used = 0
        self._opened.set()
        if self.limit:
            # An exact count has to be there before the first new blob.
            self._count(time.time() + 1)
        else:
            since = time.time()
            self._counting = threading.Thread(
                target=self._count, args=(since,), name="store count", daemon=True
            )
            self._counting.start()

    def close(self) -> None:
        """Give the directory up for another process."""
        self._opened.clear()
        if self._counting is not None:
            self._counting.join()
            self._counting = None
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def read(self, key: str) -> Blob:
        """Return a blob; `BlobNotFoundError` if there is none."""
        try:
            data = self.path(key).read_bytes()
        except FileNotFoundError:
            raise BlobNotFoundError(key) from None
        return Blob(data, _version(data))

    def stream(self, key: str) -> BinaryIO:
        """Return a blob as a file; `BlobNotFoundError` if there is none."""
        try:
            return self.path(key).open("rb")
        except FileNotFoundError:
            raise BlobNotFoundError(key) from None

    def size(self, key: str) -> int:
        """Return a blob's size in bytes; `BlobNotFoundError` if there is none."""
        return self.stat(key).st_size

    def stat(self, key: str) -> os.stat_result:
        """Return what the file system knows of a blob; `BlobNotFoundError` if there is none."""
        try:
            return self.path(key).stat()
        except FileNotFoundError:
            raise BlobNotFoundError(key) from None

    def create(self, key: str, content: Content) -> str | None:
        """Store a new blob and return its version; None if there is one of this key.

        Raises
        ------
        StoreFullError
            There is no room for it.
        """
        path = self.path(key)
        source = content if isinstance(content, Path) else None
        try:
            while True:
                if path.exists():
                    # Somebody else's may not have reached the disk yet, but its existence is
                    # about to be relied on.
                    _sync(path.parent)
                    return None
                nbytes = _nbytes(content)
                self._reserve(nbytes, on_disk=source is not None)
                try:
                    return self._linked(path, content, nbytes)
                except OSError as error:
                    # Other programs, quotas and inodes are not in these accounts.
                    if error.errno not in _FULL:
                        raise
                    if self.make_room is None or not self.make_room(nbytes):
                        raise StoreFullError from error
                finally:
                    self._release(nbytes, on_disk=source is not None)
        finally:
            if source:
                source.unlink(missing_ok=True)

    def replace(self, key: str, data: bytes, version: str) -> str | None:
        """Store another content if the present one has this version; None if it has not."""
        path = self.path(key)
        with self._locked(key):
            try:
                present = path.read_bytes()
            except FileNotFoundError:
                return None
            if _version(present) != version:
                return None
            new = self._written(data)
            try:
                new.replace(path)
            except OSError:
                new.unlink(missing_ok=True)
                raise
            self._add(len(data) - len(present))
            _sync(path.parent)
        return _version(data)

    def delete(self, key: str) -> bool:
        """Remove a blob; whether there was one."""
        path = self.path(key)
        with self._locked(key):
            try:
                nbytes = path.stat().st_size
                path.unlink()
            except FileNotFoundError:
                return False
            self._add(-nbytes)
        _sync(path.parent)
        return True

    def move(self, key: str, to: str) -> bool:
        """Give a blob another, unused key; whether there was one."""
        path, target = self.path(key), self.path(to)
        self._make_folder(target.parent)
        with self._locked(key):
            try:
                path.rename(target)
            except FileNotFoundError:
                return False
        _sync(target.parent)
        _sync(path.parent)
        return True

    def keys(self, prefix: str, after: str = "") -> Iterator[str]:
        """Iterate over the keys that begin with `prefix` and follow `after`, in their order."""
        yield from self._keys(self.directory / prefix, prefix, after)

    def scratch(self, suffix: str) -> Path:
        """Return the name of a new file in ``temporary/``."""
        return self._temporary / f"{secrets.token_hex(16)}{suffix}"

    def path(self, key: str) -> Path:
        """Return where a blob is, or would be."""
        if not _KEY.fullmatch(key) or key.startswith("temporary/"):
            message = f"{key!r} is no key"
            raise ValueError(message)
        return self.directory / key

    def touch(self, key: str, when: float) -> None:
        """Set a blob's time of modification, if there is one."""
        with contextlib.suppress(FileNotFoundError):
            os.utime(self.path(key), (when, when))

    def _linked(self, path: Path, content: Content, nbytes: int) -> str | None:
        if isinstance(content, Path):
            source = content
            _sync(source)
        else:
            source = self._written(*([content] if isinstance(content, bytes) else content))
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
                # Not acknowledged, so it must not be there.
                path.unlink(missing_ok=True)
                self._add(-nbytes)
                raise
        finally:
            if source is not content:
                source.unlink(missing_ok=True)
        return version

    def _written(self, *pieces: bytes) -> Path:
        """Return a new, synced file in ``temporary/``; none is left if the disk is full."""
        path = self.scratch(".new")
        try:
            with path.open("xb", buffering=0) as file:
                for piece in pieces:
                    view = memoryview(piece)
                    while view:
                        view = view[file.write(view) :]
                os.fsync(file.fileno())
        except OSError:
            path.unlink(missing_ok=True)
            raise
        return path

    def _make_folder(self, folder: Path) -> None:
        """Make a folder whose name is on the disk as well, up to the store's directory."""
        if folder in self._durable and folder.is_dir():
            return
        folder.mkdir(parents=True, exist_ok=True)
        for parent in folder.parents:
            _sync(parent)
            if parent == self.directory:
                break
        self._durable.add(folder)

    def _reserve(self, nbytes: int, *, on_disk: bool) -> None:
        """Take bytes out of what the limit and the disk leave; `StoreFullError` if they lack."""
        while True:
            with self._accounts:
                missing = self._missing(nbytes, on_disk=on_disk)
                if missing <= 0:
                    self._reserved += nbytes
                    self._reserved_on_disk += 0 if on_disk else nbytes
                    return
            if self.limit and nbytes > self.limit:
                message = f"{nbytes} bytes are more than the whole store may hold"
                raise StoreFullError(message)
            if self.make_room is None or not self.make_room(missing):
                raise StoreFullError

    def _missing(self, nbytes: int, *, on_disk: bool) -> int:
        over = self._used + self._reserved + nbytes - self.limit if self.limit else 0
        if on_disk or nbytes <= _SMALL:
            return over
        disk = os.statvfs(self.directory)
        needed = self._reserve_bytes + self._reserved_on_disk + nbytes
        return max(over, needed - disk.f_bavail * disk.f_frsize)

    def _release(self, nbytes: int, *, on_disk: bool) -> None:
        with self._accounts:
            self._reserved -= nbytes
            self._reserved_on_disk -= 0 if on_disk else nbytes

    def _add(self, nbytes: int) -> None:
        with self._accounts:
            self._used += nbytes

    def _count(self, until: float) -> None:
        """Add up the blobs that have been there since before `until`; later ones add themselves."""
        total = 0
        for key in self._keys(self.directory, "", ""):
            if not self._opened.is_set():
                return
            with contextlib.suppress(BlobNotFoundError):
                status = self.stat(key)
                total += status.st_size if status.st_ctime < until else 0
        self._add(total)

    def _keys(self, folder: Path, prefix: str, after: str) -> Iterator[str]:
        try:
            with os.scandir(folder) as entries:
                # A folder's name is sorted with the stroke that follows it in the keys.
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
                    yield from self._keys(folder / name, key, after)
            elif key > after and _KEY.fullmatch(key):
                yield key

    def _locked(self, key: str) -> threading.Lock:
        return self._key_locks[hash(key) % _LOCKS]


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
