"""Store check: tests on the store itself that it keeps the guarantees of `Blobs`.

Every test writes blobs under its own prefix and removes them. Properties that no test can show,
such as durability in a power cut, are listed as not proved.
"""

from __future__ import annotations

import contextlib
import hashlib
import secrets
import statistics
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, TextIO, TypeVar

from service.storage.blobs import BlobNotFoundError, StoreUnavailableError
from service.storage.local import StoreInUseError

if TYPE_CHECKING:
    from service.storage.blobs import Blobs

__all__ = ["NOT_PROVED", "Finding", "findings", "report"]

T = TypeVar("T")

_WRITERS = 16
_ROUNDS = 5
_LARGE = 9 << 20
"""Size in bytes, more than one part of a multipart upload."""

NOT_PROVED = (
    "acknowledged blobs survive a power cut or the loss of a disk or zone",
    "behaviour under throttling and network partitions",
    "wrong credentials are refused (moto's server does not refuse them)",
    "no lifecycle, retention or versioning policy removes or keeps blobs unexpectedly",
)
"""Properties that the check cannot show for any store."""


class _RefutedError(Exception):
    """A guarantee does not hold."""


@dataclass(frozen=True)
class Finding:
    """Result of one test; `detail` holds figures, or the observed fault."""

    promise: str
    proved: bool
    detail: str


def findings(blobs: Blobs, another: Blobs) -> Iterator[Finding]:
    """Test a store, guarantee by guarantee.

    `another` is the same store as another process sees it, or the same object if the store belongs
    to one process.
    """
    prefix = f"check/{secrets.token_hex(8)}/"
    trials: list[tuple[str, Callable[[Blobs, Blobs, str], str]]] = [
        (f"of {_WRITERS} simultaneous creators of a blob exactly one succeeds", _exclusive),
        (f"of {_WRITERS} simultaneous replacements of a version exactly one succeeds", _swap),
        ("an outdated or deleted version cannot be replaced", _outdated),
        ("a written blob is visible to others at once and complete", _read_after_write),
        ("a large blob is read back unchanged", _large),
        ("written blobs are listed for others at once and in order", _listed),
        ("a deleted blob is gone for others at once, and its name is free", _deleted),
        ("a blob can be moved", _moved),
    ]
    try:
        for promise, trial in trials:
            try:
                yield Finding(promise, True, trial(blobs, another, prefix))
            except _RefutedError as error:
                yield Finding(promise, False, str(error))
            except (BlobNotFoundError, StoreUnavailableError, OSError) as error:
                yield Finding(promise, False, f"{type(error).__name__}: {error}")
    finally:
        with contextlib.suppress(StoreUnavailableError, OSError):
            for key in list(blobs.keys(prefix)):
                blobs.delete(key)


def report(blobs: Blobs, another: Blobs, output: TextIO) -> int:
    """Open a store, test it, write the results, and return the exit status: 0 or 1."""
    with contextlib.ExitStack() as closing:
        try:
            for each in dict.fromkeys((blobs, another)):
                each.open()
                closing.callback(each.close)
        except (StoreInUseError, StoreUnavailableError, OSError) as error:
            output.write(f"FAILED  it can be opened: {error}\n")
            return 1
        output.write("proved  it can be opened and listed\n")
        refuted = 0
        for finding in findings(blobs, another):
            refuted += not finding.proved
            verdict = "proved" if finding.proved else "FAILED"
            output.write(f"{verdict}  {finding.promise} ({finding.detail})\n")
    output.writelines(f"not proved  {promise}\n" for promise in NOT_PROVED)
    output.write("The store is suitable.\n" if not refuted else "The store is not suitable.\n")
    return 1 if refuted else 0


def _exclusive(blobs: Blobs, another: Blobs, prefix: str) -> str:
    for turn in range(_ROUNDS):
        key = f"{prefix}exclusive-{turn}"
        versions = _run_simultaneously(partial(_create, key), blobs, another)
        winner = _only_winner(versions)
        _expect(blobs.read(key), (b"%d" % winner, versions[winner]))
    return f"{_ROUNDS} rounds"


def _swap(blobs: Blobs, another: Blobs, prefix: str) -> str:
    key = f"{prefix}swap"
    version = blobs.create(key, b"first")
    for _ in range(_ROUNDS):
        versions = _run_simultaneously(partial(_replace, key, version or ""), blobs, another)
        winner = _only_winner(versions)
        _expect(blobs.read(key), (b"%d for %b" % (winner, str(version).encode()), versions[winner]))
        version = versions[winner]
    return f"{_ROUNDS} rounds"


def _outdated(blobs: Blobs, another: Blobs, prefix: str) -> str:
    key = f"{prefix}outdated"
    old = blobs.create(key, b"first") or ""
    new = blobs.replace(key, b"second", old) or ""
    _expect(another.replace(key, b"third", old), None)
    blobs.delete(key)
    _expect(another.replace(key, b"fourth", new), None)
    return "both refused"


def _read_after_write(blobs: Blobs, another: Blobs, prefix: str) -> str:
    writing, reading = [], []
    for number in range(20):
        key, content = f"{prefix}read-{number}", secrets.token_bytes(5000)
        start = time.perf_counter()
        version = blobs.create(key, content)
        written = time.perf_counter()
        _expect(another.read(key), (content, version))
        writing.append(written - start)
        reading.append(time.perf_counter() - written)
    return (
        f"20 blobs of 5 kB, {statistics.median(writing) * 1000:.1f} ms to write one, "
        f"{statistics.median(reading) * 1000:.1f} ms to read it"
    )


def _large(blobs: Blobs, another: Blobs, prefix: str) -> str:
    key, content = f"{prefix}large", secrets.token_bytes(_LARGE)
    path = blobs.scratch(".check")
    path.write_bytes(content)
    start = time.perf_counter()
    blobs.create(key, path)
    seconds = time.perf_counter() - start
    _expect(another.size(key), _LARGE)
    with another.stream(key) as file:
        _expect(hashlib.sha256(file.read()).digest(), hashlib.sha256(content).digest())
        file.seek(_LARGE // 2)
        _expect(file.read(100), content[_LARGE // 2 :][:100])
    return f"{_LARGE / 1e6:.1f} MB, written at {_LARGE / 1e6 / seconds:.0f} MB/s"


def _listed(blobs: Blobs, another: Blobs, prefix: str) -> str:
    keys = [f"{prefix}list/{number:02}" for number in range(30)]
    for key in reversed(keys):
        blobs.create(key, b"x")
    _expect(list(another.keys(f"{prefix}list/")), keys)
    _expect(list(another.keys(f"{prefix}list/", keys[9])), keys[10:])
    return f"{len(keys)} blobs"


def _deleted(blobs: Blobs, another: Blobs, prefix: str) -> str:
    key = f"{prefix}deleted/one"
    blobs.create(key, b"first")
    blobs.delete(key)
    with contextlib.suppress(BlobNotFoundError):
        _expect(another.read(key), None)
    _expect(list(another.keys(f"{prefix}deleted/")), [])
    if another.create(key, b"second") is None:
        raise _RefutedError("its name was not free")
    return "one blob"


def _moved(blobs: Blobs, another: Blobs, prefix: str) -> str:
    blobs.create(f"{prefix}moved/from", b"content")
    _expect(blobs.move(f"{prefix}moved/from", f"{prefix}moved/to"), True)
    _expect(another.read(f"{prefix}moved/to").data, b"content")
    _expect(list(another.keys(f"{prefix}moved/")), [f"{prefix}moved/to"])
    return "one blob"


def _create(key: str, store: Blobs, number: int) -> str | None:
    return store.create(key, b"%d" % number)


def _replace(key: str, version: str, store: Blobs, number: int) -> str | None:
    return store.replace(key, b"%d for %b" % (number, version.encode()), version)


def _run_simultaneously(function: Callable[[Blobs, int], T], *stores: Blobs) -> list[T]:
    barrier = threading.Barrier(_WRITERS)

    def call(number: int) -> T:
        barrier.wait()
        return function(stores[number % len(stores)], number)

    with ThreadPoolExecutor(_WRITERS) as threads:
        return list(threads.map(call, range(_WRITERS)))


def _only_winner(versions: list[str | None]) -> int:
    winners = [number for number, version in enumerate(versions) if version is not None]
    if len(winners) != 1:
        raise _RefutedError(f"{len(winners)} succeeded")
    return winners[0]


def _expect(found: object, wanted: object) -> None:
    if found != wanted:
        raise _RefutedError(f"{_short(found)} instead of {_short(wanted)}")


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
