"""Blobs as objects of a bucket at S3, Google Cloud Storage or Azure, through obstore.

Object stores create and replace conditionally, so any number of processes may share a bucket. S3
and Azure have ``If-None-Match: *`` and ``If-Match``, Google has generations. Credentials and
endpoints come from the environment, as obstore reads them (``AWS_...``, ``GOOGLE_...``,
``AZURE_...``). Every request has a deadline and a bounded number of retries. Writes are retried
here and not by obstore, because a retry may meet the result of its own earlier attempt. See
``docs/operations.md``.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import logging
import os
import re
import secrets
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from datetime import timedelta
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, BinaryIO, TypeVar
from urllib.parse import urlsplit

import obstore
from obstore.exceptions import (
    AlreadyExistsError,
    BaseError,
    NotSupportedError,
    PermissionDeniedError,
    PreconditionError,
    UnauthenticatedError,
)
from obstore.store import AzureStore, GCSStore, S3Store

from service.storage.blobs import Blob, BlobNotFoundError, Content, StoreUnavailableError

if TYPE_CHECKING:
    from obstore.store import RetryConfig

__all__ = ["CloudBlobs"]

logger = logging.getLogger(__name__)

T = TypeVar("T")

_STORES: dict[str, type[S3Store | GCSStore | AzureStore]] = {
    "s3": S3Store,
    "gs": GCSStore,
    "az": AzureStore,
}

_CONNECT_SECONDS = 5
_REQUEST_SECONDS = 60
"""Deadline of a request: 160 MB, the largest input, at 3 MB/s."""

_SILENT_SECONDS = 4
"""Longest silence during a read or a small write. Stores answer within tenths of a second. Large
writes answer after the whole upload and have the full deadline."""

_SMALL_BYTES = 1 << 20
"""Size of small writes: records, jobs and names."""

_TRIAL_SECONDS = 5.0
"""Interval of trials while the bucket does not answer. All other calls fail at once."""

_READ_RETRIES = 3
_RETRY_SECONDS = 8
"""Time after the first attempt in which retries may start."""

_WRITE_PAUSES = (0.1, 0.5, 2.0)
"""Seconds before each retry of a write."""

_PAGE = 1000
"""Number of keys per listing request, the maximum of S3."""

_IN_MEMORY = 8 << 20
"""Size in bytes above which a downloaded blob goes to a scratch file."""

_SCRATCH_PREFIX = "gamut-scratch-"

_REFUSED = (AlreadyExistsError, PreconditionError)
"""Errors of a conditional write whose condition does not hold."""

_FINAL = (*_REFUSED, PermissionDeniedError, UnauthenticatedError, NotSupportedError)
"""Errors that a retry cannot fix."""


class CloudBlobs:
    """Blobs as objects of a bucket: ``s3://bucket/prefix``, or with ``gs://`` or ``az://``.

    The prefix is optional. Raise ValueError if the address is malformed or the environment lacks a
    setting.
    """

    remote = True

    def __init__(self, address: str) -> None:
        parts = urlsplit(address)
        if (
            parts.scheme not in _STORES
            or not parts.hostname
            or parts.netloc != parts.hostname
            or parts.query
            or parts.fragment
        ):
            # The message does not repeat the address, which may contain a password.
            message = (
                "The store's address must be s3://bucket/prefix, gs://bucket/prefix or "
                "az://container/prefix. Credentials and endpoints come from the environment"
            )
            raise ValueError(message)
        self.address = address
        kind = _STORES[parts.scheme]
        self._reading = _client(kind, address, _READ_RETRIES, silent=_SILENT_SECONDS)
        self._writing = _client(kind, address, 0, silent=_SILENT_SECONDS)
        self._uploading = _client(kind, address, 0, silent=_REQUEST_SECONDS)
        self._outage = _Outage()
        self._scratch: Path | None = None
        self._lock: IO[bytes] | None = None

    def open(self) -> None:
        """List the bucket to check that it can be read, and make a folder for scratch files.

        Raise `StoreUnavailableError` if the bucket cannot be listed.
        """
        next(self.keys(""), None)
        self._scratch, self._lock = _scratch_folder()

    def close(self) -> None:
        """Remove the scratch files."""
        if self._lock is not None and self._scratch is not None:
            shutil.rmtree(self._scratch, ignore_errors=True)
            self._lock.close()
            self._scratch = self._lock = None

    def read(self, key: str) -> Blob:
        """Return a blob; raises `BlobNotFoundError` if there is none."""
        with self._request("read", key):
            result = obstore.get(self._reading, key)
            return Blob(bytes(result.bytes()), _version(result.meta))

    def stream(self, key: str) -> BinaryIO:
        """Return a copy of a blob as a file; raises `BlobNotFoundError` if there is none."""
        with contextlib.ExitStack() as closing, self._request("read", key):
            result = obstore.get(self._reading, key)
            file = closing.enter_context(
                tempfile.SpooledTemporaryFile(_IN_MEMORY, dir=str(self.scratch("").parent))
            )
            for chunk in result.stream():
                file.write(chunk)
            if file.tell() != result.meta["size"]:
                message = f"{key} was truncated during the download"
                raise StoreUnavailableError(message)
            file.seek(0)
            closing.pop_all()
            return file  # type: ignore[return-value]

    def size(self, key: str) -> int:
        """Return the size of a blob in bytes; raises `BlobNotFoundError` if there is none."""
        with self._request("look at", key):
            return obstore.head(self._reading, key)["size"]

    def create(self, key: str, content: Content) -> str | None:
        """Store a new blob; see `Blobs.create`."""
        try:
            whole = b"".join(content) if isinstance(content, list) else content
            return self._put(key, whole, "create")
        finally:
            if isinstance(content, Path):
                content.unlink(missing_ok=True)

    def replace(self, key: str, data: bytes, version: str) -> str | None:
        """Replace the content if it has this version; see `Blobs.replace`."""
        return self._put(key, data, json.loads(version))

    def delete(self, key: str) -> bool:
        """Remove a blob. S3 does not report whether there was one; the result is then True."""
        try:
            with self._request("delete", key):
                _retry(lambda: obstore.delete(self._writing, key))
        except BlobNotFoundError:
            return False
        return True

    def move(self, key: str, to: str) -> bool:
        """Copy a blob to an unused key and delete it; return whether there was one."""
        try:
            with self._request("move", key):
                _retry(lambda: obstore.copy(self._writing, key, to, overwrite=True))
        except BlobNotFoundError:
            return False
        self.delete(key)
        return True

    def keys(self, prefix: str, after: str = "") -> Iterator[str]:
        """Iterate over the keys with a prefix, after the key `after`, in their order."""
        with self._request("list", prefix, missing_bucket=True):
            pages = obstore.list(
                self._reading, prefix or None, offset=after or None, chunk_size=_PAGE
            )
            for page in pages:
                yield from (entry["path"] for entry in page)

    def scratch(self, suffix: str) -> Path:
        """Return the name of a new file in the folder for scratch files."""
        if self._scratch is None:
            message = "the store is not open"
            raise StoreUnavailableError(message)
        return self._scratch / f"{secrets.token_hex(16)}{suffix}"

    @contextlib.contextmanager
    def _request(self, verb: str, key: str, *, missing_bucket: bool = False) -> Iterator[None]:
        """Turn obstore's exceptions into those of `service.storage.blobs`."""
        self._outage.check()
        failure: Exception | None = None
        try:
            yield
        except (FileNotFoundError, BaseError) as error:
            failure = error
        reason = _reason(failure) if failure else ""
        self._outage.record(answered="Connect" not in reason and "Timeout" not in reason)
        if isinstance(failure, FileNotFoundError) and not missing_bucket:
            raise BlobNotFoundError(key) from None
        if failure:
            message = f"the store did not {verb} {key or 'its keys'}: {reason}"
            logger.error("%s", message)
            # Without the cause, whose text may contain signed addresses.
            raise StoreUnavailableError(message) from None

    def _put(self, key: str, content: bytes | Path, mode: Any) -> str | None:  # noqa: ANN401
        """Put an object conditionally; return None if the condition does not hold."""
        with self._request("write", key, missing_bucket=True):
            size = content.stat().st_size if isinstance(content, Path) else len(content)
            client = self._writing if size <= _SMALL_BYTES else self._uploading
            attempts = 0

            def put() -> str:
                nonlocal attempts
                attempts += 1
                return _version(obstore.put(client, key, content, mode=mode, use_multipart=False))

            try:
                return _retry(put)
            except _REFUSED:
                return None if attempts == 1 else self._own(key, content)

    def _own(self, key: str, content: bytes | Path) -> str | None:
        """Return the version if an earlier attempt has written the object."""
        try:
            present = self.read(key)
        except BlobNotFoundError:
            return None
        data = content.read_bytes() if isinstance(content, Path) else content
        return present.version if present.data == data else None


def _client(
    kind: type[S3Store | GCSStore | AzureStore], address: str, retries: int, *, silent: float
) -> S3Store | GCSStore | AzureStore:
    retry: RetryConfig = {
        "max_retries": retries,
        "retry_timeout": timedelta(seconds=_RETRY_SECONDS),
        "backoff": {"init_backoff": timedelta(seconds=0.1), "max_backoff": timedelta(seconds=2)},
    }
    # Explicit options replace those that obstore reads from the environment.
    allowed = any(
        os.environ.get(f"{prefix}_ALLOW_HTTP", "").lower() in {"1", "true"}
        for prefix in ("AWS", "GOOGLE", "AZURE")
    )
    try:
        return kind.from_url(
            address,
            client_options={
                "connect_timeout": timedelta(seconds=_CONNECT_SECONDS),
                "timeout": timedelta(seconds=_REQUEST_SECONDS),
                "read_timeout": timedelta(seconds=silent),
                "allow_http": allowed,
            },
            retry_config=retry,
        )
    except BaseError as error:
        # For example a missing account. Addresses are removed, as above.
        first_line = re.sub(r"\S+://\S+", "...", str(error).partition("\n")[0])
        message = f"The store's settings in the environment are not valid: {first_line}"
        raise ValueError(message) from None


def _retry(request: Callable[[], T]) -> T:
    """Run an idempotent request with retries."""
    for pause in _WRITE_PAUSES:
        try:
            return request()
        except _FINAL:
            raise
        except BaseError as error:
            if "kind: Timeout" in str(error):
                # Another attempt would wait as long.
                raise
            time.sleep(pause)
    return request()


class _Outage:
    """Lets calls fail at once while the bucket does not answer, except for a trial now and then.

    Otherwise every call would hold a thread for seconds, until no thread is left for anything else.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._since: float | None = None
        self._next_trial = 0.0

    def check(self) -> None:
        """Raise `StoreUnavailableError` during an outage, unless it is time for a trial."""
        with self._lock:
            now = time.monotonic()
            if self._since is None:
                return
            if now < self._next_trial:
                message = f"the store has not answered for {now - self._since:.0f} s"
                raise StoreUnavailableError(message)
            self._next_trial = now + _TRIAL_SECONDS

    def record(self, *, answered: bool) -> None:
        """Record whether a call was answered."""
        with self._lock:
            now = time.monotonic()
            self._next_trial = now + _TRIAL_SECONDS
            if answered:
                self._since = None
            elif self._since is None:
                self._since = now


_REASONS = (
    re.compile(r"status code: (\d{3} [A-Za-z ]+)"),
    re.compile(r"<Code>(\w+)</Code>"),
    re.compile(r'message: "([A-Za-z ]{,80})"'),
    re.compile(r"kind: (Connect|Timeout|Interrupted|Decode|Request)\b"),
)
"""Parts of obstore's messages that cannot contain an address or a credential."""


def _reason(error: Exception) -> str:
    text = str(error)
    reasons = [match[1].strip() for pattern in _REASONS if (match := pattern.search(text))]
    return ", ".join([type(error).__name__, *reasons])


def _version(result: Any) -> str:  # noqa: ANN401 - a PutResult or an ObjectMeta
    """Return the identifiers of a version: S3 and Azure have an e-tag, Google also a version."""
    return json.dumps({name: result[name] for name in ("e_tag", "version") if result.get(name)})


def _scratch_folder() -> tuple[Path, IO[bytes]]:
    """Return a new, locked folder for scratch files; remove folders of ended processes."""
    parent = Path(tempfile.gettempdir())
    for folder in parent.glob(f"{_SCRATCH_PREFIX}*"):
        with contextlib.suppress(OSError), (folder / "lock").open("rb") as other:
            fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(folder, ignore_errors=True)
    folder = Path(tempfile.mkdtemp(prefix=_SCRATCH_PREFIX))
    lock = (folder / "lock").open("wb")
    fcntl.flock(lock, fcntl.LOCK_EX)
    return folder, lock
