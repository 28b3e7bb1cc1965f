"""Route of the names of gamuts, and gamuts with the names that clients see."""

import asyncio
import unicodedata
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

from fastapi import APIRouter, Depends, Request
from fastapi.responses import Response

from gamutcore.names import ranked
from service.access.middleware import check_owner
from service.container import service_of
from service.openapi.documentation import EXAMPLE_ID, NAME_BODY, json_response, problems
from service.openapi.models import GamutName
from service.problems.problem import JsonResponse
from service.routes.dependencies import GamutId, GamutRoute, check_gamut_query, read_only
from service.routes.submission import submitted_name
from service.storage.gamut_names import display_name
from service.storage.gamut_store import GamutStore
from service.storage.published import PublishedGamut

__all__ = [
    "NamedRecord",
    "find_named",
    "gamut_document",
    "gamut_summary",
    "named",
    "named_page",
    "ranked_page",
    "refuse_reference",
    "router",
]

_READERS = 16
"""Number of simultaneous reads of names from a bucket."""

_MOST_EXAMINED = 1000
"""Number of gamuts that one page of a filtered list looks at."""

router = APIRouter(
    prefix="/v1/gamuts",
    tags=["gamuts"],
    route_class=GamutRoute,
    dependencies=[Depends(check_gamut_query)],
)


@router.put(
    "/{gamut_id}/name",
    operation_id="nameGamut",
    summary="Name a gamut",
    description="Replaces the name of the gamut. The last writer's name counts, on all replicas. "
    "The name is no part of the id, the history or any mesh. Until a name is given, it is the "
    "data's descriptor, the description of the profile, or the name of the file.",
    responses={
        200: json_response(
            "The name was stored.", GamutName, {"id": EXAMPLE_ID, "name": "Coated offset"}
        ),
        **problems(
            "malformed-body",
            "request-timeout",
            "body-too-large",
            "unsupported-media-type",
            "invalid-body",
            "invalid-name",
            "gamut-not-found",
            "gamut-rebuilding",
            "reference-read-only",
            "built-by-another",
            "invalid-parameter",
            "store-unavailable",
            "storage-full",
        ),
    },
    openapi_extra={"requestBody": NAME_BODY},
)
async def name_gamut(request: Request, gamut_id: GamutId) -> Response:
    """Name a gamut."""
    service = service_of(request)
    name = await submitted_name(request, service.bodies)
    refuse_reference(await service.library.record(gamut_id))
    await check_owner(request, service.store, gamut_id)
    await asyncio.to_thread(service.store.names.give, gamut_id, name)
    await service.library.rename(gamut_id)
    return JsonResponse(GamutName(id=gamut_id, name=name), headers={"Cache-Control": "no-store"})


class NamedRecord(NamedTuple):
    """A gamut's record with its name."""

    record: PublishedGamut
    name: str

    @property
    def id(self) -> str:
        """The gamut's id."""
        return self.record.id


def named(store: GamutStore, records: Sequence[PublishedGamut]) -> list[NamedRecord]:
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
    """Return up to `limit` gamuts after an id whose names contain a text, without regard to case.

    Also return the id after which the next page begins; None if there is none. An empty text
    stands for all gamuts. Blocks on the store.
    """
    wanted = _folded(part)
    matches: list[NamedRecord] = []
    examined = 0
    while True:
        records = store.page(after, limit + 1)
        matches += [each for each in named(store, records) if wanted in _folded(each.name)]
        if len(matches) > limit:
            return matches[:limit], matches[limit - 1].id
        if len(records) <= limit:
            return matches, None
        examined += len(records)
        after = records[-1].id
        if examined >= _MOST_EXAMINED:
            return matches, after


def ranked_page(
    store: GamutStore, after: str, limit: int, name: str
) -> tuple[list[NamedRecord], str | None]:
    """Return the gamuts that a name may mean, the most likely first; otherwise as `named_page`.

    They are the best of the next `_MOST_EXAMINED` gamuts. The name may have any spelling, or be
    another name of a print condition (`gamutcore.names`).
    """
    records = store.page(after, _MOST_EXAMINED + 1)
    examined = named(store, records[:_MOST_EXAMINED])
    last = examined[-1].id if len(records) > _MOST_EXAMINED else None
    return ranked(name, ((each, (each.name,)) for each in examined))[:limit], last


def find_named(store: GamutStore, names: Sequence[str]) -> dict[str, list[NamedRecord]]:
    """Return the gamuts whose names contain each text, or only those that are called so.

    All gamuts are read. Blocks on the store.
    """
    matches: dict[str, list[NamedRecord]] = {name: [] for name in names}
    wanted = {name: _folded(name) for name in names}
    after = ""
    while records := store.page(after, _MOST_EXAMINED):
        for each in named(store, records):
            folded = _folded(each.name)
            for name, part in wanted.items():
                if part in folded:
                    matches[name].append(each)
        after = records[-1].id
    for name, part in wanted.items():
        equal = [each for each in matches[name] if _folded(each.name) == part]
        matches[name] = equal or matches[name]
    return matches


def _folded(text: str) -> str:
    return unicodedata.normalize("NFC", text).casefold()


def refuse_reference(record: PublishedGamut) -> None:
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
