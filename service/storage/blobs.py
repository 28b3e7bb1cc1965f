"""What all storage can do: blobs with names, created exclusively, replaced by compare-and-swap.

`service.storage.local.LocalBlobs` keeps them in a directory, `service.storage.cloud.CloudBlobs` in
a bucket. Both promise the same:

- what `create` and `replace` have returned from is durable and seen by every later call of
  everybody;
- of any number of simultaneous `create` calls for one key exactly one returns a version, and of any
  number of `replace` calls with one version as well;
- a reader sees a blob whole or not at all.

Neither promises that bytes are still the ones that were written: disks and networks flip them.
Whoever keeps a blob says so in it, by `seal`, or beside it.

All methods block: the event loop calls them in threads, which they are safe for.
"""

from __future__ import annotations

import errno
import hashlib
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path
    from typing import BinaryIO

__all__ = [
    "UNVERSIONED",
    "Blob",
    "BlobDamagedError",
    "BlobNotFoundError",
    "Blobs",
    "Content",
    "StoreFullError",
    "StoreUnavailableError",
    "seal",
    "unseal",
]


class BlobNotFoundError(LookupError):
    """There is no blob under this key."""


class BlobDamagedError(ValueError):
    """The bytes of a blob are not those that were seal."""


class StoreFullError(OSError):
    """There is no room for a new blob, and nothing that may be evicted for it.

    Its error number is ``ENOSPC``, so that it is handled like a full disk.
    """

    def __init__(self, message: str = "the store is full") -> None:
        super().__init__(errno.ENOSPC, message)


class StoreUnavailableError(Exception):
    """The storage cannot be reached or refuses to work; it may again in a while.

    The message holds no address and no credentials: it may be shown to a client.
    """


class Blob(NamedTuple):
    """A blob as it was read.

    Attributes
    ----------
    data : bytes
        Its content.
    version : str
        Stands for this content under this key: another content has another version. What was
        written back to an earlier content may have its version again, as with the e-tags of S3.
    """

    data: bytes
    version: str


UNVERSIONED = ""
"""Version of a new blob of pieces or of a file. Such blobs are large and never replaced, so a local
store does not hash them."""

Content: TypeAlias = "bytes | list[bytes] | Path"
"""What a new blob is made of: large inputs come in pieces, results of other processes as files."""


class Blobs(Protocol):
    """Storage of named blobs.

    Keys are relative paths of lower-case letters, digits, ``.``, ``-`` and ``_``, parted by ``/``.
    Every method may raise `StoreUnavailableError`, and a local one `OSError`.

    Attributes
    ----------
    remote : bool
        Whether a call crosses a network, so that callers save calls.
    """

    @property
    def remote(self) -> bool:
        """Whether a call crosses a network, so that callers save calls."""

    def open(self) -> None:
        """Lock the directory and sweep it, or prove that the bucket can be reached."""

    def close(self) -> None:
        """Give the storage up."""

    def read(self, key: str) -> Blob:
        """Return a blob; `BlobNotFoundError` if there is none."""

    def stream(self, key: str) -> BinaryIO:
        """Return a blob as a seekable file, which a later delete leaves alone.

        Raises
        ------
        BlobNotFoundError
            There is none.
        """

    def size(self, key: str) -> int:
        """Return a blob's size in bytes; `BlobNotFoundError` if there is none."""

    def create(self, key: str, content: Content) -> str | None:
        """Store a new blob.

        Parameters
        ----------
        key : str
            Its name.
        content : bytes, list of bytes, or Path
            Its content; pieces follow each other; a file is one of `scratch`, and consumed
            whatever happens.

        Returns
        -------
        str or None
            The new blob's version, which may be `UNVERSIONED` unless the content is bytes. None
            if there is a blob of this key, which stays as it is.

        Raises
        ------
        StoreFullError
            There is no room for it.
        """

    def replace(self, key: str, data: bytes, version: str) -> str | None:
        """Store another content if the present one has this version (compare-and-swap).

        Returns
        -------
        str or None
            The new version. None if the blob has another version by now, or is gone.
        """

    def delete(self, key: str) -> bool:
        """Remove a blob; whether there was one, as far as that can be told."""

    def move(self, key: str, to: str) -> bool:
        """Give a blob another, unused key; whether there was one. Not atomic in a bucket."""

    def keys(self, prefix: str, after: str = "") -> Iterator[str]:
        """Iterate over the keys that begin with `prefix` and follow `after`, in their order.

        Parameters
        ----------
        prefix : str
            Ends with ``/``, or is empty.
        after : str
            The last key that is not wanted.
        """

    def scratch(self, suffix: str) -> Path:
        """Return the name of a new local file for work in progress.

        For a local store it is on the same file system, so that `create` need not copy it.
        """


def seal(payload: bytes) -> bytes:
    """Return a payload with its SHA-256 before it: what `unseal` can verify.

    Returns
    -------
    bytes
        64 hexadecimal digits, a line feed, the payload, a line feed.
    """
    return b"%b\n%b\n" % (hashlib.sha256(payload).hexdigest().encode(), payload)


def unseal(data: bytes) -> bytes:
    """Return the payload of seal bytes.

    Raises
    ------
    BlobDamagedError
        Anything about them is not as `seal` made it.
    """
    digest, payload = data[:65], data[65:-1]
    expected = hashlib.sha256(payload).hexdigest().encode() + b"\n"
    if len(data) < 66 or digest != expected or data[-1:] != b"\n":
        message = "the content does not match its digest"
        raise BlobDamagedError(message)
    return payload
