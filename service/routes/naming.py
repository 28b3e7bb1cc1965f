"""Gamuts with the names that clients see (`service.storage.display_names`)."""

from __future__ import annotations

import unicodedata
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, NamedTuple

from gamutcore.names import ranked
from service.routes.dependencies import read_only
from service.storage.display_names import display_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from service.storage.gamuts import GamutStore
    from service.storage.records import Record

__all__ = [
    "NamedRecord",
    "gamut_document",
    "gamut_summary",
    "named",
    "named_page",
    "ranked_page",
    "refuse_reference",
]

_READERS = 16
"""Number of simultaneous reads of names from a bucket."""

_MOST_EXAMINED = 1000
"""Number of gamuts that one page of a filtered list looks at."""


class NamedRecord(NamedTuple):
    """A gamut's record with its name."""

    record: Record
    name: str

    @property
    def id(self) -> str:
        """The gamut's id."""
        return self.record.id


def named(store: GamutStore, records: Sequence[Record]) -> list[NamedRecord]:
    """Return records with their names. Blocks on the store."""
    if store.blobs.remote and len(records) > 1:
        with ThreadPoolExecutor(min(_READERS, len(records))) as threads:
            stored = list(threads.map(lambda record: store.names.read(record.id), records))
    else:
        stored = [store.names.read(record.id) for record in records]
    return [
        NamedRecord(each, display_name(each, name))
        for each, name in zip(records, stored, strict=True)
    ]


def named_page(
    store: GamutStore, after: str, limit: int, part: str
) -> tuple[list[NamedRecord], str | None]:
    """Return gamuts whose names contain a text, without regard to case. Blocks on the store.

    Parameters
    ----------
    store : GamutStore
    after : str
        Id after which the page begins.
    limit : int
        Largest number of gamuts.
    part : str
        Empty for all gamuts.

    Returns
    -------
    found : list of NamedRecord
    last : str or None
        Id after which the next page begins; None if there is none.
    """
    wanted = _folded(part)
    found: list[NamedRecord] = []
    examined = 0
    while True:
        records = store.page(after, limit + 1)
        found += [each for each in named(store, records) if wanted in _folded(each.name)]
        if len(found) > limit:
            return found[:limit], found[limit - 1].id
        if len(records) <= limit:
            return found, None
        examined += len(records)
        after = records[-1].id
        if examined >= _MOST_EXAMINED:
            return found, after


def ranked_page(
    store: GamutStore, after: str, limit: int, name: str
) -> tuple[list[NamedRecord], str | None]:
    """Return the gamuts that a name may mean, the most likely first. Blocks on the store.

    Parameters
    ----------
    store, after, limit
        As for `named_page`.
    name : str
        Any spelling, or another name of a print condition (`gamutcore.names`).

    Returns
    -------
    found : list of NamedRecord
        The best of the next `_MOST_EXAMINED` gamuts.
    last : str or None
        Id after which the next page begins; None if no gamut is left.
    """
    records = store.page(after, _MOST_EXAMINED + 1)
    examined = named(store, records[:_MOST_EXAMINED])
    last = examined[-1].id if len(records) > _MOST_EXAMINED else None
    return ranked(name, ((each, (each.name,)) for each in examined))[:limit], last


def _folded(text: str) -> str:
    return unicodedata.normalize("NFC", text).casefold()


def refuse_reference(record: Record) -> None:
    """Raise the error of `read_only` if a gamut is a reference gamut."""
    provenance = record.description["provenance"]
    if provenance.get("format") == "reference":
        raise read_only(provenance["reference"])


def gamut_summary(gamut: NamedRecord) -> dict[str, Any]:
    """Return the entry of a gamut in lists."""
    record = gamut.record
    address = f"/v1/gamuts/{record.id}"
    return {
        "id": record.id,
        "name": gamut.name,
        "created": record.created,
        "channels": record.description["provenance"].get("channels", []),
        **{name: record.description[name] for name in ("options", "counts", "volume")},
        "links": {
            "self": address,
            "mesh": f"{address}/mesh",
            "levels": f"{address}/levels",
            "history": f"{address}/history",
        },
    }


def gamut_document(gamut: NamedRecord) -> dict[str, Any]:
    """Return the description of a gamut, as clients see it."""
    return {
        **gamut.record.description,
        **gamut_summary(gamut),
        "state": "ready",
        "history_bytes": gamut.record.nbytes,
    }
