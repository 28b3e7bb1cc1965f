"""Encoded meshes: made once, kept in memory, and answered in front of the app when asked again.

A level of a gamut in a format is immutable content. `MeshCache` keeps it under what it is, and
remembers which request (path, query, ``Accept``) led to it; `MeshFront` answers such a request
before FastAPI sees it, with the same response that the route gives, because both are made by
`EncodedMesh.response`. See ``docs/decisions/immutable-responses.md``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from starlette.responses import Response

from gamutcore.export import FORMATS, encoded_mesh
from service.cache import ByteBoundedCache
from service.conditional import IMMUTABLE, entity_tag, matches

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Receive, Scope, Send

    from gamutcore.gamut import Gamut

__all__ = [
    "EncodedMesh",
    "MeshCache",
    "MeshFront",
    "MeshKey",
    "RequestKey",
    "encoded_level",
    "mesh_response",
    "request_key",
]

_LONGEST_REQUEST = 1024
"""Bytes of path, query and Accept that are remembered; longer ones are answered by the route."""

_ENTRY_BYTES = 512
"""Rough cost of an entry in the caches besides its content."""


class MeshKey(NamedTuple):
    """What an encoded mesh is: a level of a gamut in a format."""

    gamut_id: str
    triangles: int
    format_name: str


class RequestKey(NamedTuple):
    """What of a request decides about the mesh that answers it."""

    path: str
    query: bytes
    accept: bytes | None


@dataclass(frozen=True)
class EncodedMesh:
    """A mesh as it is sent.

    Attributes
    ----------
    body : bytes
        The file.
    etag : str
        Strong entity tag: the digest of the body.
    headers : list of pairs of bytes
        The header fields of a 200 response.
    """

    body: bytes
    etag: str
    headers: list[tuple[bytes, bytes]] = field(repr=False)

    @classmethod
    def of(cls, body: bytes, media_type: str, triangles: int, vertices: int) -> EncodedMesh:
        """Return the encoded mesh of a file with its counts."""
        etag = entity_tag(body)
        fields = {
            "content-type": media_type,
            "content-length": str(len(body)),
            "gamut-triangles": str(triangles),
            "gamut-vertices": str(vertices),
            "etag": etag,
            "cache-control": IMMUTABLE,
            "vary": "Accept",
        }
        return cls(body, etag, [(name.encode(), value.encode()) for name, value in fields.items()])

    def response(self, if_none_match: str | None) -> tuple[int, list[tuple[bytes, bytes]], bytes]:
        """Return status, header fields and content: 304 if the client has it already."""
        if if_none_match is not None and matches(if_none_match, self.etag):
            kept = [item for item in self.headers if not item[0].startswith(b"content-")]
            return 304, kept, b""
        return 200, self.headers, self.body


def encoded_level(gamut: Gamut, key: MeshKey, provenance: dict[str, str]) -> EncodedMesh:
    """Return the level of a gamut that a key names, encoded.

    Raises
    ------
    TriangleCountError
        The gamut has no such level.
    """
    mesh = gamut.history.level(key.triangles)
    body = encoded_mesh(mesh, key.format_name, provenance)
    media_type = FORMATS[key.format_name].media_type
    return EncodedMesh.of(body, media_type, len(mesh.faces), len(mesh.vertices))


class MeshCache:
    """Encoded meshes in memory, bounded in bytes.

    Parameters
    ----------
    capacity : int
        Bytes; a sixteenth more is spent on remembering requests.
    """

    def __init__(self, capacity: int) -> None:
        self._meshes: ByteBoundedCache[MeshKey, EncodedMesh] = ByteBoundedCache(capacity)
        self._requests: ByteBoundedCache[RequestKey, MeshKey] = ByteBoundedCache(capacity // 16)

    def get(self, key: MeshKey) -> EncodedMesh | None:
        """Return a mesh; None if it is not there."""
        return self._meshes.get(key)

    def answer(self, request: RequestKey) -> EncodedMesh | None:
        """Return the mesh that a request was answered with before, if it is still there."""
        key = self._requests.get(request)
        return None if key is None else self._meshes.get(key)

    def put(self, key: MeshKey, mesh: EncodedMesh) -> None:
        """Keep a mesh."""
        self._meshes.put(key, mesh, len(mesh.body) + _ENTRY_BYTES)

    def remember(self, request: RequestKey, key: MeshKey) -> None:
        """Note which mesh answers a request."""
        size = len(request.path) + len(request.query) + len(request.accept or b"")
        if size <= _LONGEST_REQUEST:
            self._requests.put(request, key, size + _ENTRY_BYTES)

    def discard_gamut(self, gamut_id: str) -> None:
        """Forget all meshes of a gamut."""
        self._meshes.discard_where(lambda key: key.gamut_id == gamut_id)


class MeshFront:
    """ASGI layer that answers a mesh request that was answered before."""

    def __init__(self, app: ASGIApp, meshes: MeshCache) -> None:
        self.app = app
        self.meshes = meshes

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer from memory if the mesh is there; else pass the request on."""
        if scope["type"] != "http" or scope["method"] != "GET":
            await self.app(scope, receive, send)
            return
        request = request_key(scope)
        mesh = None if request is None else self.meshes.answer(request)
        if mesh is None:
            await self.app(scope, receive, send)
            return
        known = [value for name, value in scope["headers"] if name == b"if-none-match"]
        status, headers, body = mesh.response(b",".join(known).decode("latin-1") if known else None)
        await send({"type": "http.response.start", "status": status, "headers": headers})
        await send({"type": "http.response.body", "body": body})


def request_key(scope: Scope) -> RequestKey | None:
    """Return what decides about a request's answer; None where ``Accept`` is repeated."""
    accept: bytes | None = None
    for name, value in scope["headers"]:
        if name == b"accept":
            if accept is not None:
                return None
            accept = value
    return RequestKey(scope["path"], scope["query_string"], accept)


def mesh_response(mesh: EncodedMesh, if_none_match: str | None) -> Response:
    """Return the response of the route for a mesh."""
    status, headers, body = mesh.response(if_none_match)
    response = Response(body, status)
    response.raw_headers = headers
    return response
