"""The route of links: a mapping between the devices of two gamuts, as a file for other programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request
from fastapi.responses import Response

from gamutcore.links import PARAMETERS, link, table_size
from service.access.rate_limits import client_of
from service.container import service_of
from service.http.representations import IMMUTABLE, conditional, content_disposition
from service.library import ChargedResponse, Cost
from service.openapi.documentation import binary_content, header, problems
from service.queries.answers import condition_headers
from service.queries.parameters import documentation, query_values, values_of
from service.routes.dependencies import GamutRoute, NamedGamuts, checked_gamut
from service.routes.queries import levels_of, wait_for_kernels
from service.routes.views import NOT_MODIFIED, named_gamut, only

if TYPE_CHECKING:
    from service.library import QueryLevel

__all__ = ["router"]

MOST_NODES = 65**3
"""Largest number of nodes of a table: of presses it takes about ten seconds of two cores."""

MEDIA_TYPES = {"cube": "text/plain; charset=us-ascii", "icc": "application/vnd.iccprofile"}
"""Media types by format. There is none for ``.cube`` files."""

SUFFIXES = {"cube": ".cube", "icc": ".icc"}

_SIDES = ("source", "destination")

router = APIRouter(prefix="/v1/links", tags=["gamuts"], route_class=GamutRoute)


@router.get(
    "",
    operation_id="downloadLink",
    summary="Download a mapping between two devices",
    description="A table from the device values of `source` to those of `destination`, with gamut "
    "mapping in the space of the destination's gamut, which other programs apply to pictures. The "
    "title or the description of the file states its error against the exact mapping. Build both "
    "gamuts with `space=CAM16-UCS` where blue must not become purple.",
    response_class=Response,
    responses={
        200: {
            "description": "The link.",
            "content": {
                "text/plain": {
                    "schema": {"type": "string"},
                    "examples": {"cube": {"summary": "A .cube file", "value": "LUT_3D_SIZE 33"}},
                },
                **binary_content({"application/vnd.iccprofile": "An ICC device link"}),
            },
            "headers": {
                "Cache-Control": header("The content is immutable.", IMMUTABLE),
                "ETag": header("Strong entity tag: the SHA-256 of the content.", '"4f1d9c07"'),
                "Content-Disposition": header(
                    "File name.", 'attachment; filename="rec2020-to-display-p3.cube"'
                ),
                "Gamut-Link-Error": header(
                    "ΔE00 between the table and the exact mapping, at random inputs and on edges.",
                    "mean 0.019, 95 % 0.070, 99 % 0.210, worst 6.20 dE00",
                ),
            },
        },
        304: NOT_MODIFIED,
        **problems(
            "invalid-parameter",
            "invalid-option",
            "no-device-model",
            "precondition-failed",
            "gamut-not-found",
            "gamut-rebuilding",
            "queries-busy",
            "memory-busy",
            "memory-exceeded",
            "not-ready",
            "store-unavailable",
        ),
    },
    openapi_extra={"parameters": [*map(named_gamut, _SIDES), *documentation(PARAMETERS)]},
)
async def download_link(request: Request) -> Response:
    """Download a mapping between two devices."""
    service, items = service_of(request), NamedGamuts.of(request).items
    names = [only(items, side) for side in _SIDES]
    ids = [
        await checked_gamut(request, name, "query", side)
        for name, side in zip(names, _SIDES, strict=True)
    ]
    others = [item for item in items if item[0] not in _SIDES]
    values = values_of(PARAMETERS, query_values(PARAMETERS, others), {})
    await wait_for_kernels(service)
    # both stay in use until the levels keep them
    prepared = [await service.library.load_device_model(each) for each in ids]
    channels = len(prepared[0].gamut.channels)
    size = values.pop("size")
    values["size"] = table_size(size, channels, MOST_NODES)
    nodes = values["size"] ** channels
    with service.queries.admission.held(client_of(request.scope), nodes):
        work = Cost.LINK + Cost.NODE * nodes
        levels, charge = await levels_of(service, ids, {"max_error": 0.0}, lambda _: work)
        del prepared
        chosen = values.pop("format")
        data, headers, found = await service.links.run(0.0, _file, levels, values, chosen)
    name = "-to-".join(each[:12] for each in names)
    headers |= {
        "Cache-Control": IMMUTABLE,
        "Content-Disposition": content_disposition("attachment", name, SUFFIXES[found]),
        "X-Content-Type-Options": "nosniff",
    }
    answer = Response(data, 200, headers, MEDIA_TYPES[found])
    return ChargedResponse(conditional(answer, request.headers), charge)


def _file(
    levels: list[QueryLevel], values: dict[str, object], chosen: str | None
) -> tuple[bytes, dict[str, str], str]:
    """Return the file, header fields and the format."""
    source, destination = (level.gamut for level in levels)
    found = link(source, destination, **values)  # type: ignore[arg-type]  # checked
    headers = {
        "Gamut-Link-Error": str(found.errors),
        **condition_headers(levels, found.warnings),
    }
    return found.to_bytes(chosen), headers, chosen or found.format
