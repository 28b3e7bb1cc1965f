"""Routes of pictures: a level of a gamut, seen by a fixed camera, as PNG."""

from typing import Annotated

from fastapi import APIRouter, Request
from fastapi.responses import Response

from gamutcore.arguments import Array, Boolean, Choice, FiniteNumber, Number, WholeNumber
from gamutcore.export.rendering import (
    BACKGROUNDS,
    DEFAULT_SIZE,
    LARGEST_PICTURE,
    PICTURE_TRIANGLES,
    SMALLEST_PICTURE,
    VIEWS,
)
from service.access.clients import client_of
from service.container import service_of
from service.http.conditional import check_if_match
from service.meshes.encoding import MeshResponse, PictureOptions
from service.meshes.requested_levels import level_request
from service.openapi.documentation import MESH_HEADERS, binary_content, problems
from service.queries.parameters import (
    Parameter,
    query_values,
    values_of,
)
from service.routes.gamuts import GamutId
from service.routes.queries import QueryRoute, wait_for_kernels

__all__ = ["router"]

MOST_TRIANGLES = 100_000
"""Bounds the time of a picture to some seconds, whatever the shape of the triangles."""

ROWS_PER_PIXEL = 1 / 100
"""Rows of queries that a pixel counts as, among the rows under way."""

_VIEW = (
    Annotated[str, Choice(tuple(VIEWS))]
    | Annotated[tuple[FiniteNumber, FiniteNumber], Array("2 numbers", 2)]
)

PARAMETERS = (
    Parameter(
        "size",
        Annotated[int, WholeNumber(SMALLEST_PICTURE, LARGEST_PICTURE)],
        "Width and height in pixels.",
        default=DEFAULT_SIZE,
        example=400,
    ),
    Parameter(
        "view",
        _VIEW,
        "Name of a view, or the hue and the elevation in degrees from which the camera looks. The "
        "elevation is from -90 (from below) to 90 (from above).",
        default="standard",
        example="top",
    ),
    Parameter(
        "background",
        Annotated[str, Choice(BACKGROUNDS)],
        "What is behind the gamut.",
        default="white",
        example="transparent",
    ),
    Parameter(
        "axes", Annotated[bool, Boolean()], "Whether there are axes with labels.", default=True
    ),
    Parameter(
        "triangles",
        Annotated[int, WholeNumber(4, MOST_TRIANGLES)],
        f"Largest triangle count. Default: {PICTURE_TRIANGLES}, or the full boundary if it is "
        "smaller.",
        example=1000,
    ),
    Parameter(
        "max_error",
        Annotated[float, Number(0.0, 1e12)],
        "Largest distance between the level and the full boundary, in units of the space, instead "
        f"of a count. Levels of more than {MOST_TRIANGLES} triangles are not drawn.",
        example=0.5,
    ),
)

router = APIRouter(prefix="/v1/gamuts", tags=["meshes"], route_class=QueryRoute)


@router.get(
    "/{gamut_id}/picture.png",
    operation_id="drawGamut",
    summary="Draw the gamut",
    description="A picture of the gamut in its own colours, in parallel projection, with lightness "
    "upwards. The same request gives the same bytes.",
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
    openapi_extra={"parameters": [each.documentation() for each in PARAMETERS]},
)
async def draw_gamut(request: Request, gamut_id: GamutId) -> Response:
    """Draw a level."""
    values = values_of(PARAMETERS, query_values(PARAMETERS, request.query_params.multi_items()), {})
    level = level_request(values.pop("triangles"), values.pop("max_error"))
    options = PictureOptions(**values)
    service = service_of(request)
    await wait_for_kernels(service)
    rows = int(options.size**2 * ROWS_PER_PIXEL) + 1
    with service.queries.admission.held(client_of(request.scope), rows):
        picture = await service.meshes.picture(gamut_id, level, options, MOST_TRIANGLES)
    check_if_match(request.headers.getlist("if-match"), picture.etag)
    known = request.headers.getlist("if-none-match")
    return MeshResponse(picture, ",".join(known) or None)
