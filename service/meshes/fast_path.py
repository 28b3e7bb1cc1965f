"""Mesh fast path: answers plain requests for meshes ahead of FastAPI's routing.

Routing takes longer than reading a cached mesh. A request is plain if its path and query have the
usual form and `Meshes.find_ready` has its mesh. Everything else, errors included, goes on to the
route. Both answer with `EncodedMesh.response`, so clients cannot tell them apart. See
``docs/decisions/immutable-responses.md``.
"""

from __future__ import annotations

import functools
import re
from typing import TYPE_CHECKING

from gamutcore.export import FORMATS
from gamutcore.levels import SIDES, LevelRequest, Side
from service.http.compression import preferred_coding
from service.http.negotiation import preferred_media_type
from service.http.parameters import DECIMAL_PATTERN
from service.meshes.encoding import MEDIA_TYPES, SUFFIXES
from service.telemetry.request_observer import MatchedRoute

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Receive, Scope, Send

    from service.meshes.encoding import EncodedMesh
    from service.meshes.meshes import Meshes

__all__ = ["MeshFastPath"]

_ROUTE = MatchedRoute("/v1/gamuts/{gamut_id}/mesh")
_FILE_ROUTE = MatchedRoute("/v1/gamuts/{gamut_id}/mesh.{suffix}")

_PATH = re.compile(r"/v1/gamuts/([0-9a-f]{64})/mesh(?:\.([a-z]+))?\Z", re.ASCII)
_LIMIT = DECIMAL_PATTERN.encode()
_QUERY = re.compile(
    rb"(?:triangles=([0-9]{1,9})|(?:max_error=(%b))?(?:(?:^|&)max_mismatch=(%b))?)"
    rb"(?:(?:^|&)side=(both|inside|outside))?(?:(?:^|&)format=([a-z]+))?\Z" % (_LIMIT, _LIMIT)
)

_SIDES: dict[bytes | None, Side] = {None: "both", **{side.encode(): side for side in SIDES}}


class MeshFastPath:
    """ASGI middleware that answers plain requests for meshes, and passes on all others."""

    def __init__(self, app: ASGIApp, meshes: Meshes) -> None:
        self.app = app
        self.meshes = meshes

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer the request if it is plain; else pass it on."""
        mesh = if_none_match = None
        if scope["type"] == "http" and scope["method"] == "GET":
            mesh, if_none_match = self._find(scope)
        if mesh is None:
            await self.app(scope, receive, send)
            return
        status, headers, body = mesh.response(if_none_match)
        await send({"type": "http.response.start", "status": status, "headers": headers})
        await send({"type": "http.response.body", "body": body})

    def _find(self, scope: Scope) -> tuple[EncodedMesh | None, str | None]:
        """Return the mesh, if it is ready, and the value of If-None-Match."""
        path = _PATH.match(scope["path"])
        query = _QUERY.match(scope["query_string"])
        if path is None or query is None:
            return None, None
        fields = {b"accept": b"", b"accept-encoding": b"", b"if-none-match": b""}
        for name, value in scope["headers"]:
            if name == b"if-match":
                return None, None
            if name in fields:
                fields[name] = fields[name] + b"," + value if fields[name] else value
        gamut_id, suffix = path.groups()
        triangles, max_error, max_mismatch, side, format_field = query.groups()
        if suffix is not None and suffix not in SUFFIXES:
            return None, None
        if format_field is not None:
            name = format_field.decode()
        elif suffix is not None:
            name = SUFFIXES[suffix]
        else:
            name = _negotiated_format(fields[b"accept"])
        if name not in FORMATS:
            return None, None
        request = LevelRequest(
            None if triangles is None else int(triangles),
            None if max_error is None else float(max_error),
            None if max_mismatch is None else float(max_mismatch),
            _SIDES[side],
        )
        if FORMATS[name].full:
            request = request.or_default(max_error=0.0)
        known = fields[b"if-none-match"].decode("latin-1")
        scope["route"] = _ROUTE if suffix is None else _FILE_ROUTE
        coding = preferred_coding(fields[b"accept-encoding"])
        return self.meshes.find_ready(gamut_id, request, name, coding), known or None


@functools.lru_cache(maxsize=256)
def _negotiated_format(accept: bytes) -> str:
    """Return the format that a client prefers; empty if it accepts none."""
    media_type = preferred_media_type(accept.decode("latin-1"), list(MEDIA_TYPES))
    return "" if media_type is None else MEDIA_TYPES[media_type]
