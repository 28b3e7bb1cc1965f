"""``gamut store``: list or prune the gamuts of a storage.

The version of the algorithm is part of every id, so no new request gives the id of an outdated
gamut. Only clients that kept the address still use it. Listing changes nothing, and works beside a
running service. Removal from a directory needs exclusive access. In a bucket, replicas notice it
within a minute.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from typing import NamedTuple, TextIO

from gamutcore.version import ALGORITHM_VERSION
from service.storage.blobs import BlobNotFoundError
from service.storage.gamut_names import display_name
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs
from service.storage.published import PublishedGamut, blob_key

__all__ = ["list_gamuts", "prune"]

_DAY = 86_400.0
_ROW = "{:64}  {:>7}  {:>11}  {:20}  {}\n"


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
