"""Encoded meshes: a level of a gamut as the bytes and header fields of a response.

A level in one format and one content coding is immutable. `MeshKey` names it, and `encode_mesh`
makes it. The module holds no state; `service.meshes.meshes` caches its results.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf
from typing import TYPE_CHECKING, NamedTuple

from starlette.responses import Response

from gamutcore.export import FORMATS, mesh_file
from gamutcore.export.rendering import mesh_picture
from gamutcore.levels import Bounds, Side
from gamutcore.questions import PNG_KEYWORD
from service.http.representations import (
    IDENTITY,
    IMMUTABLE,
    OCTET_STREAM,
    compress,
    content_disposition,
    entity_tag,
    matches,
)
from service.http.request_context import timed

if TYPE_CHECKING:
    from service.library import Charge, OpenGamut

__all__ = [
    "MEDIA_TYPES",
    "SUFFIXES",
    "EncodedMesh",
    "MeshKey",
    "MeshResponse",
    "PictureOptions",
    "encode_mesh",
    "encode_picture",
    "file_stem",
]

MEDIA_TYPES = {
    **{mesh_format.media_type: name for name, mesh_format in FORMATS.items()},
    OCTET_STREAM: next(iter(FORMATS)),
}
"""Format names by the media types that a client may accept, the preferred one first. A client that
accepts bytes of any type gets the preferred format, which the answer names."""

SUFFIXES = {mesh_format.suffix.removeprefix("."): name for name, mesh_format in FORMATS.items()}
"""Format names by file name suffix, without the dot."""


class MeshKey(NamedTuple):
    """Identity of an encoded mesh: gamut, level, format, content coding and side."""

    gamut_id: str
    triangles: int
    format_name: str
    coding: str = IDENTITY
    side: Side = "both"


@dataclass(frozen=True)
class EncodedMesh:
    """The representation of a mesh in a response: body, strong entity tag and header fields.

    The entity tag is the digest of the body, and the header fields are for a 200 response. `charge`
    covers the body's memory while the body is kept or being sent.
    """

    body: bytes = field(repr=False)
    etag: str
    headers: list[tuple[bytes, bytes]] = field(repr=False)
    charge: Charge | None = field(default=None, repr=False, compare=False)

    @classmethod
    def of(
        cls,
        body: bytes,
        media_type: str,
        file_name: tuple[str, str],
        triangles: int,
        vertices: int,
    ) -> EncodedMesh:
        """Return the encoded mesh of a file with its counts.

        `file_name` is the gamut's name, and the part of the file's name that follows it.
        """
        etag = entity_tag(body)
        fields = {
            "content-type": media_type,
            "content-length": str(len(body)),
            # A viewer may show the mesh in place. The name is for those who save it (RFC 6266).
            "content-disposition": content_disposition("inline", *file_name),
            "gamut-triangles": str(triangles),
            "gamut-vertices": str(vertices),
            "etag": etag,
            "cache-control": IMMUTABLE,
            "vary": "Accept, Accept-Encoding",
        }
        return cls(body, etag, [(name.encode(), value.encode()) for name, value in fields.items()])

    def with_bounds(self, bounds: Bounds) -> EncodedMesh:
        """Return the mesh with other error bounds. Content and entity tag stay the same."""
        own = {
            b"gamut-max-error": b"%g" % bounds.distance,
            b"gamut-max-mismatch": b"%g" % bounds.mismatch,
        }
        headers = [item for item in self.headers if item[0] not in own]
        return replace(self, headers=[*headers, *own.items()])

    def in_coding(self, coding: str) -> EncodedMesh:
        """Return the mesh in a content coding, with a different entity tag."""
        body = compress(self.body, coding)
        etag = entity_tag(body)
        own = {b"content-length": str(len(body)).encode(), b"etag": etag.encode()}
        headers = [(name, own.get(name, value)) for name, value in self.headers]
        return EncodedMesh(body, etag, [*headers, (b"content-encoding", coding.encode())])

    def response(self, if_none_match: str | None) -> tuple[int, list[tuple[bytes, bytes]], bytes]:
        """Return status, header fields and content: 304 if the client has the mesh already."""
        if if_none_match is not None and matches(if_none_match, self.etag):
            kept = [item for item in self.headers if not item[0].startswith(b"content-")]
            return 304, kept, b""
        return 200, self.headers, self.body


class MeshResponse(Response):
    """The answer with a mesh, whose memory stays charged until it is sent."""

    def __init__(self, mesh: EncodedMesh, if_none_match: str | None) -> None:
        status, headers, body = mesh.response(if_none_match)
        super().__init__(body, status)
        self.raw_headers = headers
        self.mesh = mesh


def file_stem(gamut_id: str) -> str:
    """Return the beginning of the names of a gamut's files, in ASCII."""
    return gamut_id[:12]


def encode_mesh(
    opened: OpenGamut, key: MeshKey, plain: EncodedMesh | None = None
) -> dict[MeshKey, EncodedMesh]:
    """Encode an unpacked level, and compress it if the key has a content coding.

    `plain` is the mesh without a content coding, if it is known. The result holds the mesh under
    `key`, and every mesh that was made on the way.
    """
    made: dict[MeshKey, EncodedMesh] = {}
    if plain is None:
        with timed("encode"):
            plain = _encode_level(opened, key)
        made[key._replace(coding=IDENTITY)] = plain
    if key.coding != IDENTITY:
        with timed("compress"):
            made[key] = plain.in_coding(key.coding)
    return made


class PictureOptions(NamedTuple):
    """Options of a picture of a level; see `gamutcore.export.rendering.mesh_picture`."""

    size: int
    view: str | tuple[float, float]
    background: str
    axes: bool

    def key(self, gamut_id: str, triangles: int) -> MeshKey:
        """Return the identity of the picture of a level."""
        return MeshKey(gamut_id, triangles, f"picture {self}")


def encode_picture(opened: OpenGamut, key: MeshKey, options: PictureOptions) -> EncodedMesh:
    """Draw a level, which must be unpacked."""
    with timed("draw"):
        level = opened.gamut.history.level(key.triangles)
        texts = {PNG_KEYWORD: str(opened.gamut.conditions)}
        body = mesh_picture(level, opened.space, **options._asdict(), texts=texts)
    name = (opened.name, ".png")
    return EncodedMesh.of(body, "image/png", name, level.triangles, len(level.vertices))


def _encode_level(opened: OpenGamut, key: MeshKey) -> EncodedMesh:
    level = opened.gamut.level(key.triangles, side=key.side)
    body = mesh_file(level, key.format_name, opened.provenance, opened.space)
    mesh_format, triangles = FORMATS[key.format_name], len(level.faces)
    side = "" if key.side == "both" else f"-{key.side}"
    name = (opened.name, f"-{triangles}{side}{mesh_format.suffix}")
    mesh = EncodedMesh.of(body, mesh_format.media_type, name, triangles, len(level.vertices))
    bounds = opened.gamut.search.bounds(triangles) if key.side == "both" else Bounds()
    return mesh if inf in bounds else mesh.with_bounds(bounds)
