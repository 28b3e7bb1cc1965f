"""Routes of meshes: any level of a gamut in the requested format."""

import re
from functools import lru_cache
from typing import Annotated, Any, NamedTuple
from urllib.parse import parse_qsl

from fastapi import APIRouter, Depends, Path, Query, Request
from fastapi.responses import Response
from pydantic import BaseModel, Field, ValidationError
from starlette.routing import BaseRoute, Match
from starlette.types import Receive, Scope, Send

from gamutcore.export import FORMATS
from gamutcore.levels import DEFAULT_TRIANGLES, LevelRequest
from service.access.rate_limits import client_of
from service.container import service_of
from service.http.representations import (
    check_if_match,
    preferred_coding,
    preferred_media_type,
    send_content,
)
from service.http.requests import (
    DECIMAL_NUMBER,
    ID_PATTERN,
    LARGEST_WHOLE,
    WHOLE_NUMBER,
    SideName,
)
from service.library import MEDIA_TYPES, SUFFIXES, EncodedResponse, Library
from service.openapi.documentation import MESH_HEADERS, binary_content, problems
from service.problems.problem import Problem, ProblemError
from service.routes.dependencies import (
    GamutId,
    GamutRoute,
    check_gamut_query,
    is_reference_id,
    level_request,
)
from service.telemetry.request_observer import MatchedRoute

__all__ = ["MeshQuery", "MeshRequest", "PlainMeshRoute", "mesh_request", "router"]

router = APIRouter(
    prefix="/v1/gamuts",
    tags=["meshes"],
    route_class=GamutRoute,
    dependencies=[Depends(check_gamut_query)],
)

_PROBLEMS = (
    "gamut-not-found",
    "gamut-rebuilding",
    "precondition-failed",
    "triangle-count",
    "invalid-option",
    "invalid-parameter",
    "queries-busy",
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

_ROUTE = MatchedRoute("/v1/gamuts/{gamut_id}/mesh")
_FILE_ROUTE = MatchedRoute("/v1/gamuts/{gamut_id}/mesh.{suffix}")

_OF_BODIES = {b"content-length", b"content-type"}
"""Header fields that `check_request` judges."""

_PATH = re.compile(rf"/v1/gamuts/({ID_PATTERN})/mesh(?:\.([a-z]+))?\Z", re.ASCII)


class MeshQuery(BaseModel):
    """The query of a request for a mesh."""

    triangles: Annotated[
        int | None,
        Field(
            description="Largest triangle count, from 4 to the gamut's largest count. Default "
            f"without an error limit: {DEFAULT_TRIANGLES}, or the full boundary if it is smaller.",
            json_schema_extra={"minimum": 4, "maximum": LARGEST_WHOLE},
            examples=[1000],
        ),
        WHOLE_NUMBER,
    ] = None
    max_error: Annotated[
        float | None,
        Field(
            description="Largest distance between the mesh and the full boundary, in both "
            "directions, in the space's unit (CIELAB: ΔE). The answer is the smallest level that "
            "is found to meet the limit, or the full boundary.",
            json_schema_extra={"minimum": 0},
            examples=[0.5],
        ),
        DECIMAL_NUMBER,
    ] = None
    max_mismatch: Annotated[
        float | None,
        Field(
            description="Largest mismatch: volume of the symmetric difference ÷ volume of the full "
            "boundary. With `max_error`, both limits are met.",
            json_schema_extra={"minimum": 0},
            examples=[0.001],
        ),
        DECIMAL_NUMBER,
    ] = None
    side: SideName = "both"
    format: Annotated[
        str | None,
        Field(
            description="Format of the mesh. Overrides the suffix and Accept.",
            json_schema_extra={"enum": [*FORMATS, None]},
            examples=["glb"],
        ),
    ] = None


class MeshRequest(NamedTuple):
    """The mesh that a request asks for: level, format and content coding."""

    level: LevelRequest
    format_name: str
    coding: str


def mesh_request(
    query: MeshQuery, suffix: str | None, accept: str, accept_encoding: str
) -> MeshRequest:
    """Return what a request asks for; raise the problem if there is no such mesh."""
    if suffix is None:
        name = _negotiated_format(accept) if query.format is None else query.format
    elif suffix in SUFFIXES:
        name = SUFFIXES[suffix] if query.format is None else query.format
    else:
        known = ", ".join(f".{suffix}" for suffix in SUFFIXES)
        detail = f"There are no meshes with the suffix .{suffix[:40]}."
        remedy = f"Use one of {known}."
        raise ProblemError(Problem("not-found", detail, {"field": "suffix"}, remedy))
    level = level_request(
        query.triangles,
        query.max_error,
        query.max_mismatch,
        query.side,
        "Give either triangles, or max_error, max_mismatch or both.",
    )
    if name not in FORMATS:
        detail, where = f"There is no format {name[:40]!r}.", {"in": "query", "field": "format"}
        remedy = f"Use one of {', '.join(FORMATS)}."
        raise ProblemError(Problem("invalid-parameter", detail, where, remedy))
    if FORMATS[name].full:
        level = level.or_default(max_error=0.0)
    return MeshRequest(level, name, preferred_coding(accept_encoding.encode("latin-1")))


def _negotiated_format(accept: str) -> str:
    media_type = preferred_media_type(accept, list(MEDIA_TYPES))
    if media_type is None:
        available = [each.media_type for each in FORMATS.values()]
        where = {"header": "Accept", "available": available}
        detail = f"A mesh is not available as {accept[:200]}."
        raise ProblemError(Problem("not-acceptable", detail, where))
    return MEDIA_TYPES[media_type]


async def _requested(request: Request, query: Annotated[MeshQuery, Query()]) -> MeshRequest:
    return mesh_request(query, None, _list(request, "accept"), _list(request, "accept-encoding"))


async def _requested_file(
    request: Request,
    query: Annotated[MeshQuery, Query()],
    suffix: Annotated[
        str,
        Path(
            description="The format's usual suffix.",
            json_schema_extra={"enum": list(SUFFIXES)},
            examples=["glb"],
        ),
    ],
) -> MeshRequest:
    return mesh_request(query, suffix, "", _list(request, "accept-encoding"))


def _list(request: Request, name: str) -> str:
    return ",".join(request.headers.getlist(name))


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
    request: Request, gamut_id: GamutId, wanted: Annotated[MeshRequest, Depends(_requested)]
) -> Response:
    """Download a mesh in the negotiated format."""
    client = client_of(request.scope)
    mesh = await service_of(request).library.mesh(gamut_id, *wanted, client)
    check_if_match(request.headers.getlist("if-match"), mesh.etag)
    known = request.headers.getlist("if-none-match")
    return EncodedResponse(mesh, ",".join(known) or None)


@router.get(
    "/{gamut_id}/mesh.{suffix}",
    operation_id="downloadMeshFile",
    summary="Download a mesh as a file",
    description="As without the suffix. The suffix selects the format, and `Accept` is ignored.",
    response_class=Response,
    responses={**_RESPONSES, **problems(*_PROBLEMS, "not-found")},
)
async def download_mesh_file(
    request: Request, gamut_id: GamutId, wanted: Annotated[MeshRequest, Depends(_requested_file)]
) -> Response:
    """Download a mesh in the format of the suffix."""
    return await download_mesh(request, gamut_id, wanted)


class PlainMeshRoute(BaseRoute):
    """Answers plain requests for meshes of stored gamuts, ahead of FastAPI's slower routing.

    Everything else goes on to the routes above: slugs, parameters that are refused, conditions,
    gamuts about which the store has to be asked, and reference gamuts that may have to be built.
    Both ways lead to `Library.mesh`, so clients cannot tell them apart. See
    ``docs/decisions/immutable-responses.md``.
    """

    def __init__(self, library: Library) -> None:
        self._library = library

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Match a plain request."""
        if scope["type"] != "http" or scope["method"] != "GET":
            return Match.NONE, {}
        path = _PATH.match(scope["path"])
        if path is None or not self._library.is_current(path[1]):
            return Match.NONE, {}
        if is_reference_id(path[1]) and self._library.find_open(path[1]) is None:
            return Match.NONE, {}
        fields = {b"accept": b"", b"accept-encoding": b"", b"if-none-match": b""}
        for name, value in scope["headers"]:
            if name == b"if-match" or name in _OF_BODIES:
                return Match.NONE, {}
            if name in fields:
                fields[name] = fields[name] + b"," + value if fields[name] else value
        gamut_id, suffix = path.groups()
        wanted = _plain_request(
            scope["query_string"], suffix, fields[b"accept"], fields[b"accept-encoding"]
        )
        if wanted is None:
            return Match.NONE, {}
        known = fields[b"if-none-match"].decode("latin-1")
        route = _ROUTE if suffix is None else _FILE_ROUTE
        return Match.FULL, {"route": route, "mesh": (gamut_id, wanted), "known": known or None}

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:  # noqa: ARG002
        """Send the mesh."""
        gamut_id, (level, format_name, coding) = scope["mesh"]
        mesh = await self._library.mesh(gamut_id, level, format_name, coding, client_of(scope))
        await send_content(send, *mesh.response(scope["known"]))


@lru_cache(maxsize=256)
def _plain_request(
    query: bytes, suffix: str | None, accept: bytes, accept_encoding: bytes
) -> MeshRequest | None:
    """Return what a request asks for; None if the route has to judge it."""
    items = parse_qsl(query.decode("latin-1"), keep_blank_values=True)
    values = dict(items)
    if len(values) < len(items) or not values.keys() <= MeshQuery.model_fields.keys():
        return None
    try:
        mesh_query = MeshQuery.model_validate(values)
        return mesh_request(
            mesh_query, suffix, accept.decode("latin-1"), accept_encoding.decode("latin-1")
        )
    except (ValidationError, ProblemError):
        return None
