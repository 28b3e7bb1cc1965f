"""Built gamuts as files on a local disk: published whole or not at all, verified when read.

A gamut is two files, ``published/<aa>/<id>.gamut`` (the history file, byte for byte what clients
download) and ``published/<aa>/<id>.record`` (its SHA-256 and its description). The record is
created last and exclusively, so a gamut exists exactly when its record does. Every read compares
the content with the record's digest, and the record with its own; what is damaged is moved to
``quarantine/`` and counts as never built. See ``docs/decisions/store.md``.

All methods block on the disk: the event loop calls them in threads.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import logging
import os
import secrets
from dataclasses import asdict, dataclass
from typing import IO, TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

__all__ = ["GamutNotStoredError", "GamutStore", "Record", "StoreInUseError"]

logger = logging.getLogger(__name__)

_CHUNK = 1 << 20


class GamutNotStoredError(LookupError):
    """There is no (undamaged) gamut of this id."""


class StoreInUseError(RuntimeError):
    """Another process has the data directory open."""


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
    """

    id: str
    sha256: str
    nbytes: int
    created: str
    description: dict[str, Any]

    def to_bytes(self) -> bytes:
        """Return the record's file: a line with the digest of the next, and a line of JSON."""
        line = json.dumps(asdict(self), separators=(",", ":")).encode()
        return hashlib.sha256(line).hexdigest().encode() + b"\n" + line + b"\n"

    @classmethod
    def from_bytes(cls, data: bytes) -> Record:
        """Return the record in a file's bytes; ValueError if anything about it is wrong."""
        digest, _, rest = data.partition(b"\n")
        line, end, tail = rest.partition(b"\n")
        if end != b"\n" or tail or hashlib.sha256(line).hexdigest().encode() != digest:
            message = "the record does not match its digest"
            raise ValueError(message)
        return cls(**json.loads(line))


class GamutStore:
    """The gamuts of one data directory.

    Parameters
    ----------
    directory : Path
        Created if it is not there. `open` locks it for this process.
    """

    def __init__(self, directory: Path) -> None:
        self.directory = directory.absolute()
        self.published = self.directory / "published"
        self.temporary = self.directory / "temporary"
        self.quarantine = self.directory / "quarantine"
        self._lock: IO[bytes] | None = None

    def open(self) -> None:
        """Lock the directory and remove what an earlier process left unfinished.

        Raises
        ------
        StoreInUseError
            Another process has the directory open.
        OSError
            The directory cannot be written.
        """
        for folder in (self.published, self.temporary, self.quarantine):
            folder.mkdir(parents=True, exist_ok=True)
        lock = (self.directory / "lock").open("ab")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            lock.close()
            message = (
                f"the data directory {self.directory} is in use by another process; "
                "stop it, or choose another directory with GAMUT_DATA"
            )
            raise StoreInUseError(message) from error
        self._lock = lock
        for leftover in self.temporary.iterdir():
            if leftover.is_dir() and not leftover.is_symlink():
                # None of this program's; what it is not sure of it does not remove.
                logger.warning("%s is not the service's and stays", leftover)
            else:
                leftover.unlink()

    def close(self) -> None:
        """Give the directory up for another process."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def temporary_path(self, suffix: str) -> Path:
        """Return a new name in the temporary folder, on the file system of the published files."""
        return self.temporary / f"{secrets.token_hex(16)}{suffix}"

    def write_temporary(self, suffix: str, data: bytes) -> Path:
        """Return a new file in the temporary folder that holds `data`."""
        path = self.temporary_path(suffix)
        try:
            path.write_bytes(data)
        except OSError:
            path.unlink(missing_ok=True)
            raise
        return path

    def publish(self, record: Record, content: Path) -> None:
        """Make a gamut visible: content first, then, as the commit, its record.

        A gamut of this id that is there already stays as it is. `content` is consumed.

        Parameters
        ----------
        record : Record
            Its digest must be that of `content`.
        content : Path
            A file in the temporary folder.
        """
        content_path, record_path = self._paths(record.id)
        new_record = self.temporary_path(".record")
        try:
            if record_path.exists():
                return
            content_path.parent.mkdir(exist_ok=True)
            _sync(self.published)
            _sync(content)
            content.replace(content_path)
            new_record.write_bytes(record.to_bytes())
            _sync(new_record)
            # The content's name has to be on the disk before the record that vouches for it.
            _sync(content_path.parent)
            with contextlib.suppress(FileExistsError):
                os.link(new_record, record_path)
            _sync(content_path.parent)
        finally:
            new_record.unlink(missing_ok=True)
            content.unlink(missing_ok=True)

    def record(self, gamut_id: str) -> Record:
        """Return the record of a gamut whose history file is there, in its full size.

        Raises
        ------
        GamutNotStoredError
            There is none, or it was damaged (and is now in quarantine).
        """
        content_path, record_path = self._paths(gamut_id)
        try:
            data = record_path.read_bytes()
        except FileNotFoundError:
            raise GamutNotStoredError(gamut_id) from None
        try:
            record = Record.from_bytes(data)
        except (ValueError, TypeError) as error:
            self.set_aside(gamut_id, f"damaged record: {error}")
            raise GamutNotStoredError(gamut_id) from error
        if record.id != gamut_id:
            self.set_aside(gamut_id, f"the record of {record.id} under another gamut's name")
            raise GamutNotStoredError(gamut_id)
        try:
            size = content_path.stat().st_size
        except FileNotFoundError:
            self.set_aside(gamut_id, "a record without its history file")
            raise GamutNotStoredError(gamut_id) from None
        if size != record.nbytes:
            self.set_aside(gamut_id, f"a history file of {size} instead of {record.nbytes} bytes")
            raise GamutNotStoredError(gamut_id)
        return record

    def content(self, gamut_id: str) -> tuple[Record, bytes]:
        """Return a gamut's record and its history file, compared with the record's digest.

        Raises
        ------
        GamutNotStoredError
            There is none, or it was damaged (and is now in quarantine).
        """
        record, file = self.verified_file(gamut_id)
        with file:
            return record, file.read()

    def verified_file(self, gamut_id: str) -> tuple[Record, IO[bytes]]:
        """Return a gamut's record and its open history file, compared with the record's digest.

        The file stays readable through this handle even if the gamut is deleted meanwhile.

        Raises
        ------
        GamutNotStoredError
            There is none, or it was damaged (and is now in quarantine).
        """
        record = self.record(gamut_id)
        try:
            file = self._paths(gamut_id)[0].open("rb")
        except FileNotFoundError:
            # Deleted since the look at its record.
            raise GamutNotStoredError(gamut_id) from None
        with contextlib.ExitStack() as closing:
            closing.enter_context(file)
            if hashlib.file_digest(file, "sha256").hexdigest() != record.sha256:
                self.set_aside(gamut_id, "the history file does not match its digest")
                raise GamutNotStoredError(gamut_id)
            file.seek(0)
            closing.pop_all()
        return record, file

    def delete(self, gamut_id: str) -> bool:
        """Remove a gamut; whether there was one."""
        content_path, record_path = self._paths(gamut_id)
        try:
            record_path.unlink()
        except FileNotFoundError:
            return False
        content_path.unlink(missing_ok=True)
        _sync(content_path.parent)
        return True

    def page(self, after: str, limit: int) -> list[Record]:
        """Return up to `limit` records in the order of their ids, from the first after `after`."""
        records: list[Record] = []
        for gamut_id in self._ids(after):
            if len(records) == limit:
                break
            with contextlib.suppress(GamutNotStoredError):
                records.append(self.record(gamut_id))
        return records

    def set_aside(self, gamut_id: str, reason: str) -> None:
        """Move a damaged gamut to the quarantine, where it can be looked at but is not served."""
        logger.error("gamut %s moved to quarantine: %s", gamut_id, reason)
        mark = secrets.token_hex(4)
        for path in reversed(self._paths(gamut_id)):
            with contextlib.suppress(FileNotFoundError):
                path.replace(self.quarantine / f"{path.name}.{mark}")

    def _paths(self, gamut_id: str) -> tuple[Path, Path]:
        folder = self.published / gamut_id[:2]
        return folder / f"{gamut_id}.gamut", folder / f"{gamut_id}.record"

    def _ids(self, after: str) -> Iterator[str]:
        for folder in sorted(self.published.iterdir()):
            if folder.name >= after[:2]:
                ids = sorted(path.stem for path in folder.glob("*.record"))
                yield from (gamut_id for gamut_id in ids if gamut_id > after)


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
