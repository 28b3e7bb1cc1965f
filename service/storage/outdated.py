"""List the gamuts of a store, and remove those that an earlier version of the algorithm built.

The version is part of every id, so no new request gives the id of an outdated gamut. Only clients
that kept the address still use it. Listing changes nothing, and works beside a running service.
Removal from a directory needs exclusive access. In a bucket, replicas notice it within half a
minute.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TextIO

from gamutcore.version import ALGORITHM_VERSION
from service.storage.blobs import BlobNotFoundError
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs
from service.storage.names import display_name
from service.storage.published import PublishedGamut, published_key

__all__ = ["StoredGamut", "list_gamuts", "prune", "stored_gamuts"]

_DAY = 86_400.0
_ROW = "{:64}  {:>7}  {:>11}  {:20}  {}\n"


@dataclass(frozen=True)
class StoredGamut:
    """A gamut as maintenance sees it.

    Attributes
    ----------
    version
        Version of the algorithm; 0 if the record does not tell.
    nbytes
        History and input.
    used
        Last use, in seconds of the Unix epoch. A bucket has the publication instead.
    """

    id: str
    name: str
    version: int
    nbytes: int
    used: float

    @property
    def outdated(self) -> bool:
        """Whether an earlier version than the installed one built the gamut."""
        return self.version < ALGORITHM_VERSION


def stored_gamuts(store: GamutStore) -> Iterator[StoredGamut]:
    """Iterate over the gamuts with an intact record, in the order of their ids.

    Damaged records are left for the service, which moves them to the quarantine.
    """
    for gamut_id in store.ids():
        with contextlib.suppress(BlobNotFoundError, ValueError, TypeError):
            record = PublishedGamut.from_bytes(store.blobs.read(published_key(gamut_id)).data)
            yield _stored(store, record)


def list_gamuts(store: GamutStore, output: TextIO, *, outdated: bool) -> None:
    """Write all gamuts, or only the outdated gamuts, as a table."""
    output.write(_ROW.format("id", "version", "bytes", "last use", "name"))
    count = total = 0
    for gamut in stored_gamuts(store):
        if gamut.outdated or not outdated:
            output.write(_row(gamut))
            count, total = count + 1, total + gamut.nbytes
    output.write(f"{count} gamuts, {total} bytes\n")


def prune(store: GamutStore, output: TextIO, *, older_than: float, confirmed: bool) -> None:
    """Remove outdated gamuts with their inputs and names, and write the list.

    Gamuts used within `older_than` days stay; 0 removes all. Unless `confirmed`, the gamuts are
    only listed.
    """
    before = time.time() - older_than * _DAY
    count = total = 0
    for gamut in stored_gamuts(store):
        if not gamut.outdated or (older_than and gamut.used > before):
            continue
        if not confirmed or store.delete(gamut.id):
            output.write(_row(gamut))
            count, total = count + 1, total + gamut.nbytes
    done = "removed" if confirmed else "would be removed; confirm with --yes"
    output.write(f"{count} gamuts, {total} bytes {done}\n")


def _stored(store: GamutStore, record: PublishedGamut) -> StoredGamut:
    provenance = record.description.get("provenance", {})
    blobs = store.blobs
    if isinstance(blobs, LocalBlobs):
        used = blobs.stat(published_key(record.id)).st_mtime
    else:
        used = datetime.fromisoformat(record.created).timestamp()
    return StoredGamut(
        record.id,
        display_name(record, store.names.read(record.id)),
        int(provenance.get("algorithm", {}).get("version", 0)),
        record.nbytes + store.input_bytes(record.id),
        used,
    )


def _row(gamut: StoredGamut) -> str:
    used = datetime.fromtimestamp(gamut.used, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return _ROW.format(gamut.id, gamut.version, gamut.nbytes, used, gamut.name)
