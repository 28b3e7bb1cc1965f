"""``gamut store``: check that a storage keeps its guarantees, and list or prune its gamuts.

A check runs tests on the store itself. Every test writes blobs under its own prefix and removes
them. Properties that no test can show, such as durability in a power cut, are listed as not proved.

The version of the algorithm is part of every id, so no new request gives the id of an outdated
gamut. Only clients that kept the address still use it. Listing changes nothing, and works beside a
running service. Removal from a directory needs exclusive access. In a bucket, replicas notice it
within a minute.
"""

from __future__ import annotations

import contextlib
import hashlib
import secrets
import statistics
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from typing import NamedTuple, TextIO

from gamutcore.version import ALGORITHM_VERSION
from service.storage.blobs import BlobNotFoundError, Blobs, StoreUnavailableError
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs, StoreInUseError
from service.storage.names import display_name
from service.storage.published import PublishedGamut, blob_key

__all__ = ["NOT_PROVED", "Finding", "findings", "list_gamuts", "prune", "report"]

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

_DAY = 86_400.0
_ROW = "{:64}  {:>7}  {:>11}  {:20}  {}\n"


class _RefutedError(Exception):
    """A guarantee does not hold."""


class Finding(NamedTuple):
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
    tests: dict[str, Callable[[Blobs, Blobs, str], str]] = {
        f"of {_WRITERS} simultaneous creators of a blob exactly one succeeds": _exclusive,
        f"of {_WRITERS} simultaneous replacements of a version exactly one succeeds": _swap,
        "an outdated or deleted version cannot be replaced": _outdated,
        "a written blob is visible to others at once and complete": _read_after_write,
        "a large blob is read back unchanged": _large,
        "written blobs are listed for others at once and in order": _listed,
        "a deleted blob is gone for others at once, and its name is free": _deleted,
        "a blob can be moved": _moved,
    }
    try:
        for promise, test in tests.items():
            try:
                yield Finding(promise, True, test(blobs, another, prefix))
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
        suitable = True
        for promise, proved, detail in findings(blobs, another):
            suitable = suitable and proved
            output.write(f"{'proved' if proved else 'FAILED'}  {promise} ({detail})\n")
    output.writelines(f"not proved  {promise}\n" for promise in NOT_PROVED)
    output.write(f"The store is {'' if suitable else 'not '}suitable.\n")
    return 0 if suitable else 1


def _exclusive(blobs: Blobs, another: Blobs, prefix: str) -> str:
    for turn in range(_ROUNDS):
        key = f"{prefix}exclusive-{turn}"
        winner = _race(key, None, blobs, another)
        _expect(blobs.read(key), winner)
    return f"{_ROUNDS} rounds"


def _swap(blobs: Blobs, another: Blobs, prefix: str) -> str:
    key = f"{prefix}swap"
    version = blobs.create(key, b"first")
    for _ in range(_ROUNDS):
        winner = _race(key, version, blobs, another)
        _expect(blobs.read(key), winner)
        version = winner[1]
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


def _race(key: str, version: str | None, *stores: Blobs) -> tuple[bytes, str]:
    """Replace a version, or create the blob, simultaneously; return the only successful write."""
    barrier = threading.Barrier(_WRITERS)

    def write(number: int) -> tuple[bytes, str | None]:
        # Equal data could have equal versions.
        store, data = stores[number % len(stores)], secrets.token_bytes(8)
        barrier.wait()
        if version is None:
            return data, store.create(key, data)
        return data, store.replace(key, data, version)

    with ThreadPoolExecutor(_WRITERS) as threads:
        written = list(threads.map(write, range(_WRITERS)))
    winners = [(data, new) for data, new in written if new is not None]
    if len(winners) != 1:
        raise _RefutedError(f"{len(winners)} succeeded")
    return winners[0]


def _expect(found: object, wanted: object) -> None:
    if found != wanted:
        raise _RefutedError(f"{_short(found)} instead of {_short(wanted)}")


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def list_gamuts(store: GamutStore, output: TextIO, *, outdated: bool) -> None:
    """Write all gamuts, or only the outdated gamuts, as a table."""
    output.write(_ROW.format("id", "version", "bytes", "last use", "name"))
    gamuts = _stored_gamuts(store)
    _write_rows(output, (each for each in gamuts if each.outdated or not outdated), "")


def prune(store: GamutStore, output: TextIO, *, older_than: float, confirmed: bool) -> None:
    """Remove outdated gamuts with their inputs and names, and write the list.

    Gamuts used within `older_than` days stay; 0 removes all. Unless `confirmed`, the gamuts are
    only listed.
    """
    before = time.time() - older_than * _DAY
    removed = (
        each
        for each in _stored_gamuts(store)
        if each.outdated and (not older_than or each.used <= before)
        if not confirmed or store.delete(each.id)
    )
    done = "removed" if confirmed else "would be removed; confirm with --yes"
    _write_rows(output, removed, f" {done}")


class _StoredGamut(NamedTuple):
    """A gamut as maintenance sees it.

    `version` of the algorithm is 0 if the record does not tell. `nbytes` counts history and input.
    `used` is the last use in seconds of the Unix epoch; for a bucket it is the publication.
    """

    id: str
    name: str
    version: int
    nbytes: int
    used: float

    @property
    def outdated(self) -> bool:
        return self.version < ALGORITHM_VERSION


def _stored_gamuts(store: GamutStore) -> Iterator[_StoredGamut]:
    """Iterate over the gamuts with an intact record, in the order of their ids.

    Damaged records are left for the service, which moves them to the quarantine.
    """
    blobs = store.blobs
    for gamut_id in store.ids():
        with contextlib.suppress(BlobNotFoundError, ValueError, TypeError):
            record = PublishedGamut.from_bytes(blobs.read(blob_key(gamut_id, "record")).data)
            algorithm = record.description.get("provenance", {}).get("algorithm", {})
            yield _StoredGamut(
                record.id,
                display_name(record, store.names.read(record.id)),
                int(algorithm.get("version", 0)),
                record.nbytes + store.input_bytes(record.id),
                blobs.stat(blob_key(record.id, "record")).st_mtime
                if isinstance(blobs, LocalBlobs)
                else datetime.fromisoformat(record.created).timestamp(),
            )


def _write_rows(output: TextIO, gamuts: Iterable[_StoredGamut], done: str) -> None:
    """Write a row for each gamut, and their number and bytes; `done` ends the last line."""
    count = total = 0
    for each in gamuts:
        used = datetime.fromtimestamp(each.used, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
        output.write(_ROW.format(each.id, each.version, each.nbytes, used, each.name))
        count, total = count + 1, total + each.nbytes
    output.write(f"{count} gamuts, {total} bytes{done}\n")
