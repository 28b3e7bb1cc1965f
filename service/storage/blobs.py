"""The storage interface: named blobs, created exclusively, replaced by compare-and-swap.

`service.storage.local.LocalBlobs` uses a directory, `service.storage.cloud.CloudBlobs` a bucket.
Both guarantee:

- After `create` or `replace` has returned, the content is durable and visible to all callers.
- Of simultaneous `create` calls for one key, exactly one returns a version. The same holds for
  simultaneous `replace` calls with one version.
- A reader sees a whole blob or none.

Neither detects bit errors of disks and networks. Content that must be verified carries a digest
(`seal`).

All methods block and are thread-safe. The event loop calls them in threads.
"""

from __future__ import annotations

import errno
import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple, Protocol, TypeAlias

__all__ = [
    "SCRATCH_FOLDER",
    "UNVERSIONED",
    "Blob",
    "BlobDamagedError",
    "BlobNotFoundError",
    "Blobs",
    "Content",
    "StoreFullError",
    "StoreUnavailableError",
    "seal",
    "stored_bytes",
    "unseal",
]


SCRATCH_FOLDER = "picture-"
"""Start of the names of folders beside scratch files, which are for work in progress as well."""


class BlobNotFoundError(LookupError):
    """There is no blob under this key."""


class BlobDamagedError(ValueError):
    """The bytes of a blob do not match their digest."""


class StoreFullError(OSError):
    """There is no space for a new blob, and nothing can be evicted.

    The error number is ``ENOSPC``, so it is handled like a full disk.
    """

    def __init__(self, message: str = "the store is full") -> None:
        super().__init__(errno.ENOSPC, message)


class StoreUnavailableError(Exception):
    """The storage cannot be reached or refuses to work; it may recover.

    The message contains no address and no credentials, so clients may see it.
    """


class Blob(NamedTuple):
    """A blob that was read, and the version of its content under this key.

    Equal content may have an equal version, as with the e-tags of S3.
    """

    data: bytes
    version: str


UNVERSIONED = ""
"""Version of a new blob made of pieces or a file. Such blobs are large and never replaced, so a
local store does not hash them."""

Content: TypeAlias = bytes | list[bytes] | Path
"""Content of a new blob: bytes, pieces of a large input, or a file of another process."""


class Blobs(Protocol):
    """Storage of named blobs.

    Keys are relative paths of lower-case letters, digits, ``.``, ``-`` and ``_``, separated by
    ``/``. Every method may raise `StoreUnavailableError`, and a local one `OSError`.
    """

    @property
    def remote(self) -> bool:
        """Whether calls cross a network, so that callers should save calls."""

    def open(self) -> None:
        """Lock and sweep the directory, or check that the bucket can be reached."""

    def close(self) -> None:
        """Close the storage."""

    def read(self, key: str) -> Blob:
        """Return a blob; raises `BlobNotFoundError` if there is none."""

    def stream(self, key: str) -> BinaryIO:
        """Return a blob as a seekable file, which survives a later delete.

        Raise `BlobNotFoundError` if there is none.
        """

    def size(self, key: str) -> int:
        """Return the size of a blob in bytes; raises `BlobNotFoundError` if there is none."""

    def create(self, key: str, content: Content) -> str | None:
        """Store a new blob and return its version; if the key exists, return None.

        Pieces are concatenated; a file must come from `scratch`, and is always consumed. The
        version may be `UNVERSIONED` unless the content is bytes.
        """

    def replace(self, key: str, data: bytes, version: str) -> str | None:
        """Replace the content if it has this version (compare-and-swap); return the new version.

        The result is None if the blob has another version or is gone.
        """

    def delete(self, key: str) -> bool:
        """Remove a blob; return whether there was one, as far as the storage reports it."""

    def move(self, key: str, to: str) -> bool:
        """Rename a blob to an unused key; return whether there was one. Not atomic in a bucket."""

    def keys(self, prefix: str, after: str = "") -> Iterator[str]:
        """Iterate over the keys with a prefix, after the key `after`, in their order.

        The prefix ends with ``/``, or is empty.
        """

    def scratch(self, suffix: str) -> Path:
        """Return the name of a new local file for work in progress.

        A local store places the file on its own file system, so that `create` need not copy it.
        """


def stored_bytes(blobs: Blobs, key: str) -> int:
    """Return the size of a blob; 0 if there is none."""
    try:
        return blobs.size(key)
    except BlobNotFoundError:
        return 0


def seal(payload: bytes) -> bytes:
    """Return a payload with its SHA-256 in front, which `unseal` verifies.

    The parts are 64 hexadecimal digits, a line feed, the payload and a line feed.
    """
    return b"%b\n%b\n" % (hashlib.sha256(payload).hexdigest().encode(), payload)


def unseal(data: bytes) -> bytes:
    """Return the payload of sealed bytes; raise `BlobDamagedError` for other bytes."""
    if seal(data[65:-1]) != data:
        message = "the content does not match its digest"
        raise BlobDamagedError(message)
    return data[65:-1]
