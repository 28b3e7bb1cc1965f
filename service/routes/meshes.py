"""Routes of meshes: any level of a gamut in the requested format."""

from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Query, Request
from fastapi.responses import Response

from gamutcore.export import FORMATS
from gamutcore.levels import DEFAULT_TRIANGLES, LevelRequest
from service.container import service_of
from service.http.compression import preferred_coding
from service.http.conditional import check_if_match
from service.http.negotiation import preferred_media_type
from service.http.parameters import (
    DECIMAL_NUMBER,
    LARGEST_WHOLE,
    WHOLE_NUMBER,
    SideName,
    check_query,
)
from service.meshes.encoding import MEDIA_TYPES, SUFFIXES, MeshResponse
from service.meshes.requested_levels import level_request
from service.openapi.documentation import MESH_HEADERS, binary_content, problems
from service.problems.problem import Problem, ProblemError
from service.routes.gamuts import GamutId

__all__ = ["router"]

router = APIRouter(prefix="/v1/gamuts", tags=["meshes"], dependencies=[Depends(check_query)])

_PROBLEMS = (
    "gamut-not-found",
    "gamut-rebuilding",
    "precondition-failed",
    "triangle-count",
    "invalid-option",
    "invalid-parameter",
    "memory-busy",
    "memory-exceeded",
    "store-unavailable",
)

_RESPONSES: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "The mesh.",
        "headers": MESH_HEADERS,
        "content": binary_content(
            {
                format_.media_type: f"The bytes of a {name.upper()} file"
                for name, format_ in FORMATS.items()
            }
        ),
    },
    304: {"description": "The client has the current content (If-None-Match)."},
}

Triangles = Annotated[
    int | None,
    Query(
        description="Largest triangle count, from 4 to the gamut's largest count. Default without "
        f"an error limit: {DEFAULT_TRIANGLES}, or the full boundary if it is smaller.",
        json_schema_extra={"minimum": 4, "maximum": LARGEST_WHOLE},
        examples=[1000],
    ),
    WHOLE_NUMBER,
]

MaxError = Annotated[
    float | None,
    Query(
        description="Largest distance between the mesh and the full boundary, in both directions, "
        "in the space's unit (CIELAB: ΔE). The answer is the smallest level that is found to meet "
        "the limit, or the full boundary.",
        json_schema_extra={"minimum": 0},
        examples=[0.5],
    ),
    DECIMAL_NUMBER,
]

MaxMismatch = Annotated[
    float | None,
    Query(
        description="Largest mismatch: volume of the symmetric difference ÷ volume of the full "
        "boundary. With `max_error`, both limits are met.",
        json_schema_extra={"minimum": 0},
        examples=[0.001],
    ),
    DECIMAL_NUMBER,
]

FormatName = Annotated[
    str | None,
    Query(
        alias="format",
        description="Format of the mesh. Overrides the suffix and Accept.",
        json_schema_extra={"enum": [*FORMATS, None]},
        examples=["glb"],
    ),
]

_EITHER = "Give either triangles, or max_error, max_mismatch or both."
"""How a level is requested."""


@router.get(
    "/{gamut_id}/mesh",
    operation_id="downloadMesh",
    summary="Download a mesh",
    description="The surface of the gamut with at most the requested triangles or error, in the "
    "coordinates of its colour space. The format is that of `format=`, else the one that `Accept` "
    "prefers, else `model/gltf-binary`. GLB, glTF and PLY contain the device values of each "
    "vertex, if the data has device values. Argyll's `.gam`, ICC and CGE are for gamuts in CIELAB "
    "relative to D50, and CGE for channels R G B or C M Y; other gamuts get 422 "
    "`invalid-option`. CGE is made from the full boundary by default.",
    response_class=Response,
    responses={**_RESPONSES, **problems(*_PROBLEMS, "not-acceptable")},
)
async def download_mesh(
    request: Request,
    gamut_id: GamutId,
    triangles: Triangles = None,
    max_error: MaxError = None,
    max_mismatch: MaxMismatch = None,
    side: SideName = "both",
    format_name: FormatName = None,
) -> Response:
    """Download a mesh in the negotiated format."""
    if format_name is None:
        accept = ",".join(request.headers.getlist("accept"))
        media_type = preferred_media_type(accept, list(MEDIA_TYPES))
        if media_type is None:
            raise ProblemError(
                Problem(
                    "not-acceptable",
                    f"A mesh is not available as {accept[:200]}.",
                    {
                        "header": "Accept",
                        "available": [each.media_type for each in FORMATS.values()],
                    },
                )
            )
        format_name = MEDIA_TYPES[media_type]
    wanted = level_request(triangles, max_error, max_mismatch, side, _EITHER)
    return await _mesh(request, gamut_id, wanted, format_name)


@router.get(
    "/{gamut_id}/mesh.{suffix}",
    operation_id="downloadMeshFile",
    summary="Download a mesh as a file",
    description="As without the suffix. The suffix selects the format, and `Accept` is ignored.",
    response_class=Response,
    responses={**_RESPONSES, **problems(*_PROBLEMS, "not-found")},
)
async def download_mesh_file(
    request: Request,
    gamut_id: GamutId,
    suffix: Annotated[
        str,
        Path(
            description="The format's usual suffix.",
            json_schema_extra={"enum": list(SUFFIXES)},
            examples=["glb"],
        ),
    ],
    triangles: Triangles = None,
    max_error: MaxError = None,
    max_mismatch: MaxMismatch = None,
    side: SideName = "both",
    format_name: FormatName = None,
) -> Response:
    """Download a mesh in the format of the suffix."""
    if suffix not in SUFFIXES:
        known = ", ".join(f".{suffix}" for suffix in SUFFIXES)
        detail = f"There are no meshes with the suffix .{suffix[:40]}."
        raise ProblemError(
            Problem("not-found", detail, {"field": "suffix"}, f"Use one of {known}.")
        )
    wanted = level_request(triangles, max_error, max_mismatch, side, _EITHER)
    return await _mesh(request, gamut_id, wanted, format_name or SUFFIXES[suffix])


async def _mesh(
    request: Request, gamut_id: str, wanted: LevelRequest, format_name: str
) -> Response:
    if format_name not in FORMATS:
        raise ProblemError(
            Problem(
                "invalid-parameter",
                f"There is no format {format_name[:40]!r}.",
                {"in": "query", "field": "format"},
                f"Use one of {', '.join(FORMATS)}.",
            )
        )
    accepted = ",".join(request.headers.getlist("accept-encoding"))
    coding = preferred_coding(accepted.encode("latin-1"))
    if FORMATS[format_name].full:
        wanted = wanted.or_default(max_error=0.0)
    mesh = await service_of(request).meshes.mesh(gamut_id, wanted, format_name, coding)
    check_if_match(request.headers.getlist("if-match"), mesh.etag)
    known = request.headers.getlist("if-none-match")
    return MeshResponse(mesh, ",".join(known) or None)
