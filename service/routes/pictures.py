"""Routes of pictures: a level of a gamut, seen by a fixed camera, as PNG."""

from fastapi import APIRouter, Request
from fastapi.responses import Response

from gamutcore.questions import MOST_DRAWN_TRIANGLES, PICTURE
from service.access.clients import client_of
from service.container import service_of
from service.http.conditional import check_if_match
from service.meshes.encoding import MeshResponse, PictureOptions
from service.meshes.requested_levels import level_request
from service.openapi.documentation import MESH_HEADERS, binary_content, problems
from service.queries.parameters import (
    documentation,
    query_values,
    values_of,
)
from service.routes.dependencies import GamutId, NamedGamuts
from service.routes.queries import QueryRoute, wait_for_kernels

__all__ = ["router"]

ROWS_PER_PIXEL = 1 / 100
"""Rows of queries that a pixel counts as, among the rows under way."""

router = APIRouter(prefix="/v1/gamuts", tags=["meshes"], route_class=QueryRoute)


@router.get(
    "/{gamut_id}/picture.png",
    operation_id=PICTURE.operation_id,
    summary=PICTURE.summary,
    description=PICTURE.description,
    response_class=Response,
    responses={
        200: {
            "description": "The picture.",
            "headers": {
                name: MESH_HEADERS[name]
                for name in MESH_HEADERS
                if not name.startswith("Gamut-Max")
            },
            "content": binary_content({"image/png": "A picture as PNG"}),
        },
        304: {"description": "The client has the current content (If-None-Match)."},
        **problems(
            "invalid-option",
            "triangle-count",
            "invalid-parameter",
            "precondition-failed",
            "gamut-not-found",
            "gamut-rebuilding",
            "queries-busy",
            "not-ready",
            "memory-busy",
            "memory-exceeded",
            "store-unavailable",
        ),
    },
    openapi_extra={"parameters": documentation(PICTURE.parameters)},
)
async def draw_gamut(request: Request, gamut_id: GamutId) -> Response:
    """Draw a level."""
    values = values_of(
        PICTURE.parameters, query_values(PICTURE.parameters, NamedGamuts.of(request).items), {}
    )
    level = level_request(values.pop("triangles"), values.pop("max_error"))
    options = PictureOptions(**values)
    service = service_of(request)
    await wait_for_kernels(service)
    rows = int(options.size**2 * ROWS_PER_PIXEL) + 1
    with service.queries.admission.held(client_of(request.scope), rows):
        picture = await service.meshes.picture(gamut_id, level, options, MOST_DRAWN_TRIANGLES)
    check_if_match(request.headers.getlist("if-match"), picture.etag)
    known = request.headers.getlist("if-none-match")
    return MeshResponse(picture, ",".join(known) or None)
