"""The route of links: a mapping between the devices of two gamuts, as a file for other programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Depends, Request
from fastapi.responses import Response

from gamutcore.links import PARAMETERS, link, table_size
from service.access.rate_limits import client_of
from service.admission import MODEL_BYTES, Work, needed_bytes
from service.container import service_of
from service.http.representations import IMMUTABLE, conditional, content_disposition
from service.http.requests import GAMUT_ID
from service.openapi.documentation import binary_content, header, problems
from service.questions.answers import condition_headers
from service.questions.parameter_models import Parameters, parameter_model, query_of
from service.routes.dependencies import GamutRoute, NamedGamuts, check_gamut_query
from service.routes.questions import wait_for_kernels, wanted_levels
from service.routes.views import NOT_MODIFIED, named_gamut

if TYPE_CHECKING:
    from service.library import QueryLevel

__all__ = ["router"]

MOST_NODES = 65**3
"""Largest number of nodes of a table: of presses it takes about ten seconds of two cores."""

_LINK_MODELS = 2 / 3
"""Computing a link: the colours that threads map at once, 64 MB, in device models."""

_NODE_PIXELS = 5
"""Computing a link, per node of its table, with the file: 250 bytes, in pixels that are mapped."""

_NODE_EFFORT = 10_000
"""Effort of a node: as long as preparing so many bytes."""

MEDIA_TYPES = {"cube": "text/plain; charset=us-ascii", "icc": "application/vnd.iccprofile"}
"""Media types by format. There is none for ``.cube`` files."""

SUFFIXES = {"cube": ".cube", "icc": ".icc"}

_query = query_of(parameter_model("link_query", PARAMETERS))

router = APIRouter(
    prefix="/v1/links",
    tags=["gamuts"],
    route_class=GamutRoute,
    dependencies=[Depends(check_gamut_query)],
)


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
)
async def download_link(
    request: Request,
    source: Annotated[str, named_gamut("of the source"), GAMUT_ID],
    destination: Annotated[str, named_gamut("of the destination"), GAMUT_ID],
    parameters: Annotated[Parameters, Depends(_query)],
) -> Response:
    """Download a mapping between two devices."""
    service, names = service_of(request), [source, destination]
    ids = [await NamedGamuts.of(request).id_of(name) for name in names]
    values = dict(parameters)
    await wait_for_kernels(service)
    library, client = service.library, client_of(request.scope)
    gamuts = [(await library.gamut(each, client)).gamut for each in ids]
    for gamut in gamuts:
        if not gamut.is_of_device:
            raise gamut.no_device_model()
    channels = len(gamuts[0].channels)
    del gamuts, gamut  # they may go while the link waits for memory
    values["size"] = table_size(values["size"], channels, MOST_NODES)
    nodes = values["size"] ** channels
    wanted = await wanted_levels(service, ids, {"max_error": 0.0}, client)
    work = needed_bytes(models=_LINK_MODELS, pixels=_NODE_PIXELS * nodes)

    def need() -> int:
        models = {record.id: library.model_need(record) for record, _ in wanted}.values()
        tables = sum(min(each, MODEL_BYTES) for each in models)
        # models are fitted one by one, before the levels are made
        fit = max(each - MODEL_BYTES for each in models)
        return tables + max(fit, work + library.need(wanted))

    chosen = values.pop("format")
    with await service.admission.place(Work.HEAVY, client, need, _NODE_EFFORT * nodes):
        # both stay in use until the levels keep them
        prepared = [await library.load_device_model(each) for each in ids]
        levels = await library.levels(wanted)
        del prepared
        data, headers, file_format = await library.in_thread(_file, levels, values, chosen)
        levels.clear()
    name = "-to-".join(each[:12] for each in names)
    headers |= {
        "Cache-Control": IMMUTABLE,
        "Content-Disposition": content_disposition("attachment", name, SUFFIXES[file_format]),
        "X-Content-Type-Options": "nosniff",
    }
    answer = Response(data, 200, headers, MEDIA_TYPES[file_format])
    return service.admission.hold_response(conditional(answer, request.headers), client)


def _file(
    levels: list[QueryLevel], values: dict[str, object], chosen: str | None
) -> tuple[bytes, dict[str, str], str]:
    """Return the file, header fields and the format."""
    source, destination = (level.gamut for level in levels)
    device_link = link(source, destination, **values)  # type: ignore[arg-type]  # checked
    headers = {
        "Gamut-Link-Error": str(device_link.errors),
        **condition_headers(levels, device_link.warnings),
    }
    return device_link.to_bytes(chosen), headers, chosen or device_link.format
