"""Meshes: any level of a gamut, in the format that is asked for."""

from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Request
from fastapi.responses import Response

from gamutcore.export import FORMATS
from gamutcore.history import MINIMUM_TRIANGLES
from service.documentation import MESH_HEADERS, problems
from service.library import OpenGamut
from service.meshes import EncodedMesh, MeshKey, encoded_level, mesh_response, request_key
from service.negotiation import preferred_media_type
from service.problems import Problem, ProblemError
from service.routes.gamuts import GamutId
from service.state import Service, service_of

__all__ = ["DEFAULT_TRIANGLES", "router"]

DEFAULT_TRIANGLES = 1000
"""Triangles of a mesh when none are asked for: 26 kB as GLB, and looks smooth on a screen."""

_INLINE_TRIANGLES = 4000
"""Levels up to this are read and encoded within a millisecond, which the event loop can spare."""

router = APIRouter(prefix="/v1/gamuts", tags=["meshes"])

_NAMES = {format_.media_type: name for name, format_ in FORMATS.items()}
_SUFFIXES = {format_.suffix.removeprefix("."): name for name, format_ in FORMATS.items()}

_PROBLEMS = ("gamut-not-found", "triangle-count", "invalid-parameter")

_RESPONSES: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "The mesh.",
        "headers": MESH_HEADERS,
        "content": {
            format_.media_type: {
                "schema": {"type": "string", "format": "binary"},
                "examples": {name: {"summary": f"The bytes of a {name.upper()} file"}},
            }
            for name, format_ in FORMATS.items()
        },
    },
    304: {"description": "The client has this content already (If-None-Match)."},
}

Triangles = Annotated[
    int | None,
    Query(
        description="The most triangles that the mesh may have, from 4 up to the gamut's largest "
        f"count. Without it: {DEFAULT_TRIANGLES}, or all if there are fewer.",
        json_schema_extra={"minimum": 4},
        examples=[1000],
    ),
]

FormatName = Annotated[
    str | None,
    Query(
        alias="format",
        description="Format of the mesh; goes before the suffix and before Accept.",
        json_schema_extra={"enum": [*FORMATS, None]},
        examples=["glb"],
    ),
]


@router.get(
    "/{gamut_id}/mesh",
    operation_id="downloadMesh",
    summary="Download a mesh",
    description="The gamut's surface with at most as many triangles as are asked for, in the "
    "coordinates of its colour space. The format is that of `format=`, else the one that `Accept` "
    "likes best, else `model/gltf-binary`.",
    response_class=Response,
    responses={**_RESPONSES, **problems(*_PROBLEMS, "not-acceptable")},
)
async def download_mesh(
    request: Request,
    gamut_id: GamutId,
    triangles: Triangles = None,
    format_name: FormatName = None,
) -> Response:
    """Download a mesh in the format that is negotiated."""
    if format_name is None:
        accept = ",".join(request.headers.getlist("accept"))
        media_type = preferred_media_type(accept, list(_NAMES))
        if media_type is None:
            raise ProblemError(
                Problem(
                    "not-acceptable",
                    f"A mesh is not available as {accept[:200]}.",
                    {"header": "Accept", "available": list(_NAMES)},
                )
            )
        format_name = _NAMES[media_type]
    return await _mesh(request, gamut_id, triangles, format_name)


@router.get(
    "/{gamut_id}/mesh.{suffix}",
    operation_id="downloadMeshFile",
    summary="Download a mesh as a file",
    description="The same as without the suffix, which names the format; `Accept` has no say.",
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
            json_schema_extra={"enum": list(_SUFFIXES)},
            examples=["glb"],
        ),
    ],
    triangles: Triangles = None,
    format_name: FormatName = None,
) -> Response:
    """Download a mesh in the format that the suffix names."""
    if suffix not in _SUFFIXES:
        known = ", ".join(f".{suffix}" for suffix in _SUFFIXES)
        detail = f"There are no meshes with the suffix .{suffix[:40]}."
        raise ProblemError(
            Problem("not-found", detail, {"field": "suffix"}, f"Use one of {known}.")
        )
    return await _mesh(request, gamut_id, triangles, format_name or _SUFFIXES[suffix])


async def _mesh(
    request: Request, gamut_id: str, triangles: int | None, format_name: str
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
    service = service_of(request)
    opened = service.library.opened(gamut_id) or await service.library.gamut(gamut_id)
    history = opened.gamut.history
    count = min(DEFAULT_TRIANGLES, history.triangles) if triangles is None else triangles
    if not MINIMUM_TRIANGLES <= count <= history.triangles:
        history.level(count)  # raises, and knows best what to say
    # Closed meshes have an even count: an odd one names the same level as the even one below it.
    key = MeshKey(gamut_id, count - count % 2, format_name)
    mesh = service.meshes.get(key) or await _encoded(service, opened, key)
    # A gamut that was deleted meanwhile leaves nothing behind in memory.
    if service.library.opened(gamut_id) is opened:
        service.meshes.put(key, mesh)
        asked = request_key(request.scope)
        if asked is not None:
            service.meshes.remember(asked, key)
    known = request.headers.getlist("if-none-match")
    return mesh_response(mesh, ",".join(known) if known else None)


async def _encoded(service: Service, opened: OpenGamut, key: MeshKey) -> EncodedMesh:
    if key.triangles <= _INLINE_TRIANGLES:
        return encoded_level(opened.gamut, key, opened.provenance)
    return await service.library.in_thread(encoded_level, opened.gamut, key, opened.provenance)
