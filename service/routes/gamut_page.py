"""Route of the page of a gamut: one HTML file for browsers, which works without the service."""

from fastapi import APIRouter, Depends, Request
from fastapi.responses import Response

from gamutcore.export.viewer_page import MEDIA_TYPE
from service.container import service_of
from service.http.compression import compress_response
from service.http.conditional import conditional
from service.http.file_names import content_disposition
from service.library import ChargedResponse, Cost
from service.openapi.documentation import header, problems
from service.routes.dependencies import GamutId, GamutRoute, check_gamut_query
from service.routes.naming import named

__all__ = ["router"]

router = APIRouter(
    prefix="/v1/gamuts",
    tags=["gamuts"],
    route_class=GamutRoute,
    dependencies=[Depends(check_gamut_query)],
)


@router.get(
    "/{gamut_id}/viewer.html",
    operation_id="downloadPage",
    summary="Download a page that shows the gamut",
    description="One HTML file with the viewer and the history. It opens from disk in any current "
    "browser, without a network, and shows every level. The file has the name of the gamut.",
    response_class=Response,
    responses={
        200: {
            "description": "The page.",
            "content": {
                MEDIA_TYPE: {
                    "schema": {"type": "string"},
                    "examples": {"page": {"summary": "A page", "value": "<!doctype html>..."}},
                }
            },
            "headers": {
                "Content-Disposition": header(
                    "File name: the name of the gamut.",
                    'attachment; filename="FOGRA39L.html"',
                )
            },
        },
        304: {"description": "The client has the current content (If-None-Match)."},
        **problems(
            "gamut-not-found",
            "gamut-rebuilding",
            "precondition-failed",
            "invalid-parameter",
            "memory-busy",
            "memory-exceeded",
            "store-unavailable",
        ),
    },
)
async def download_page(request: Request, gamut_id: GamutId) -> Response:
    """Download a page that shows the gamut."""
    service = service_of(request)
    record = await service.library.record(gamut_id)
    full = record.description["counts"]["triangles"]
    page_bytes = Cost.PAGE * full + Cost.PAGE_BASE
    charge = await service.library.memory.charge(
        "work", lambda: service.library.unpacking_cost(record, full) + page_bytes
    )
    opened = await service.library.gamut(gamut_id, charge)
    await service.library.unpack(opened, full)
    service.library.settle(opened, charge)
    accepted = request.headers.getlist("accept-encoding")

    def answer() -> Response:
        [gamut] = named(service.store, [opened.record])
        # The name may change, so the answer is not immutable. A browser never shows it as a page of
        # the service.
        headers = {
            "Cache-Control": "no-cache",
            "Content-Disposition": content_disposition("attachment", gamut.name, ".html"),
            "X-Content-Type-Options": "nosniff",
        }
        page = Response(opened.gamut.to_html(gamut.name), 200, headers, MEDIA_TYPE)
        return compress_response(page, accepted)

    page = await service.library.in_thread(answer)
    return ChargedResponse(conditional(page, request.headers), charge)
