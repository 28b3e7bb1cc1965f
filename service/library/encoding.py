"""Encoded levels: a level of a gamut as the bytes and header fields of a response.

A level as a mesh in one format and one content coding, or as a picture with some options, is
immutable. `EncodedKey` names it, and `encode_level` makes it. The module holds no state.
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
    send_content,
)
from service.http.request_context import timed

if TYPE_CHECKING:
    from starlette.types import Receive, Scope, Send

    from service.admission import Holding
    from service.library.open_gamut import OpenGamut

__all__ = [
    "INLINE_TRIANGLES",
    "MEDIA_TYPES",
    "SUFFIXES",
    "EncodedKey",
    "EncodedLevel",
    "EncodedResponse",
    "PictureOptions",
    "encode_level",
]

MEDIA_TYPES = {
    **{mesh_format.media_type: name for name, mesh_format in FORMATS.items()},
    OCTET_STREAM: next(iter(FORMATS)),
}
"""Format names by the media types that a client may accept, the preferred one first. A client that
accepts bytes of any type gets the preferred format, which the answer names."""

SUFFIXES = {mesh_format.suffix.removeprefix("."): name for name, mesh_format in FORMATS.items()}
"""Format names by file name suffix, without the dot."""


INLINE_TRIANGLES = {"glb": 4000, "gltf": 1000, "ply": 4000, "stl": 4000}
"""Largest levels that are read and encoded in about a millisecond, which the event loop can
spare. Formats that are not listed are always encoded in a thread."""


class PictureOptions(NamedTuple):
    """Options of a picture of a level; see `gamutcore.export.rendering.mesh_picture`."""

    size: int
    view: str | tuple[float, float]
    background: str
    axes: bool


class EncodedKey(NamedTuple):
    """Identity of an encoded level: gamut, level, form, content coding and side.

    The form is the name of a mesh's format, or the options of a picture.
    """

    gamut_id: str
    triangles: int
    form: str | PictureOptions
    coding: str = IDENTITY
    side: Side = "both"

    @property
    def plain(self) -> EncodedKey:
        """The same without a content coding."""
        return self._replace(coding=IDENTITY)


@dataclass(frozen=True)
class EncodedLevel:
    """The representation of a mesh in a response: body, strong entity tag and header fields.

    The entity tag is the digest of the body, and the header fields are for a 200 response.
    `holding` counts the body's memory while the body is kept or being sent.
    """

    body: bytes = field(repr=False)
    etag: str
    headers: list[tuple[bytes, bytes]] = field(repr=False)
    holding: Holding | None = field(default=None, repr=False, compare=False)

    @classmethod
    def of(
        cls,
        body: bytes,
        media_type: str,
        file_name: tuple[str, str],
        triangles: int,
        vertices: int,
    ) -> EncodedLevel:
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

    def with_bounds(self, bounds: Bounds) -> EncodedLevel:
        """Return the mesh with other error bounds. Content and entity tag stay the same."""
        own = {
            b"gamut-max-error": b"%g" % bounds.distance,
            b"gamut-max-mismatch": b"%g" % bounds.mismatch,
        }
        headers = [item for item in self.headers if item[0] not in own]
        return replace(self, headers=[*headers, *own.items()])

    def in_coding(self, coding: str) -> EncodedLevel:
        """Return the mesh in a content coding, with a different entity tag."""
        body = compress(self.body, coding)
        etag = entity_tag(body)
        own = {b"content-length": str(len(body)).encode(), b"etag": etag.encode()}
        headers = [(name, own.get(name, value)) for name, value in self.headers]
        return EncodedLevel(body, etag, [*headers, (b"content-encoding", coding.encode())])

    def response(self, if_none_match: str | None) -> tuple[int, list[tuple[bytes, bytes]], bytes]:
        """Return status, header fields and content: 304 if the client has the mesh already."""
        if if_none_match is not None and matches(if_none_match, self.etag):
            headers = [item for item in self.headers if not item[0].startswith(b"content-")]
            return 304, headers, b""
        return 200, self.headers, self.body


class EncodedResponse(Response):
    """The answer with a mesh, whose memory counts until it is sent."""

    def __init__(self, mesh: EncodedLevel, if_none_match: str | None) -> None:
        status, headers, body = mesh.response(if_none_match)
        super().__init__(body, status)
        self.raw_headers = headers
        self.mesh = mesh

    async def __call__(self, _scope: Scope, _receive: Receive, send: Send) -> None:
        """Send the mesh."""
        await send_content(send, self.status_code, self.raw_headers, bytes(self.body))


def encode_level(
    opened: OpenGamut, key: EncodedKey, plain: EncodedLevel | None = None
) -> dict[EncodedKey, EncodedLevel]:
    """Encode an unpacked level, and compress it if the key has a content coding.

    `plain` is the level without a content coding, if it is known. The result holds the level under
    `key`, and every one that was made on the way.
    """
    made: dict[EncodedKey, EncodedLevel] = {}
    if plain is None:
        if isinstance(key.form, PictureOptions):
            plain = _picture(opened, key.triangles, key.form)
        else:
            plain = _mesh(opened, key.triangles, key.form, key.side)
        made[key.plain] = plain
    if key.coding != IDENTITY:
        with timed("compress"):
            made[key] = plain.in_coding(key.coding)
    return made


def _mesh(opened: OpenGamut, count: int, format_name: str, side: Side) -> EncodedLevel:
    with timed("encode"):
        level = opened.gamut.level(count, side=side)
        body = mesh_file(level, format_name, opened.provenance, opened.space)
        mesh_format, triangles = FORMATS[format_name], len(level.faces)
        suffix = f"-{triangles}{'' if side == 'both' else f'-{side}'}{mesh_format.suffix}"
        name, vertices = (opened.name, suffix), len(level.vertices)
        mesh = EncodedLevel.of(body, mesh_format.media_type, name, triangles, vertices)
        bounds = opened.gamut.search.bounds(triangles) if side == "both" else Bounds()
        return mesh if inf in bounds else mesh.with_bounds(bounds)


def _picture(opened: OpenGamut, count: int, options: PictureOptions) -> EncodedLevel:
    with timed("draw"):
        level = opened.gamut.history.level(count)
        texts = {PNG_KEYWORD: str(opened.gamut.conditions)}
        body = mesh_picture(level, opened.space, **options._asdict(), texts=texts)
    name = (opened.name, ".png")
    return EncodedLevel.of(body, "image/png", name, level.triangles, len(level.vertices))
