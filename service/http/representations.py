"""Representations (RFC 9110): negotiation, content codings, conditions, ranges and file names.

The service offers zstd (RFC 8878) and gzip (RFC 1952). Compressed content is a representation of
its own: it has its own entity tag, and the response varies by ``Accept-Encoding``. Measurements are
in ``docs/decisions/compression.md``. Everything under a gamut's id is immutable, and its entity tag
is the digest of the content. Malformed elements of lists are ignored, as RFC 9110 recommends.
"""

from __future__ import annotations

import gzip
import hashlib
import re
import sys
import unicodedata
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING
from urllib.parse import quote

from starlette.responses import Response

from gamutcore.characterisation.recognition import FORMATS
from service.problems.kinds import KINDS
from service.problems.problem import Problem, ProblemError

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

if TYPE_CHECKING:
    from collections.abc import Sequence

    from starlette.datastructures import Headers
    from starlette.types import Send

__all__ = [
    "CODINGS",
    "IDENTITY",
    "IMMUTABLE",
    "OCTET_STREAM",
    "SMALLEST",
    "Preference",
    "byte_range",
    "check_if_match",
    "compress",
    "compress_response",
    "conditional",
    "content_disposition",
    "entity_tag",
    "matches",
    "preference",
    "preferred_coding",
    "preferred_media_type",
    "send_content",
]

_PIECE = 256 * 1024
"""Bytes of content that are sent at once."""

OCTET_STREAM = "application/octet-stream"
"""Media type of bytes whose format is not named (RFC 2046, section 4.5.1)."""

_QUALITY = re.compile(r"(?:0(?:\.\d{0,3})?|1(?:\.0{0,3})?)\Z", re.ASCII)
"""The qvalue of RFC 9110, section 12.4.2."""

_ELEMENT = re.compile(r'(?:"(?:[^"\\]|\\(?:.|\Z))*(?:"|\Z)|[^",])+', re.DOTALL)
"""A list element. Commas in a quoted string (section 5.6.4) do not end it. An unclosed string
extends to the end, which keeps matching linear."""

_SECONDS = re.compile(r"\d{1,4000}\Z", re.ASCII)
"""Python converts up to 4300 digits."""

IDENTITY = ""
"""No content coding."""

CODINGS = ("zstd", "gzip")
"""Codings in the service's order of preference. zstd is as small as gzip in a fifth of the time."""

SMALLEST = 1024
"""Bytes below which content is not compressed, because it fits into one packet anyway."""

_GZIP_LEVEL = 1
"""Twice as fast as level 6. Meshes grow by 2 %."""

_ZSTD_LEVEL = 3
"""The usual level. Its window of 2 MB is within the limit of RFC 9659."""

IMMUTABLE = "public, max-age=31536000, immutable"
"""Cache-Control of immutable content (RFC 8246). One year is the usual maximum."""

_RANGE = re.compile(r"bytes=\s*(\d{0,18})-(\d{0,18})\s*\Z", re.ASCII | re.IGNORECASE)
"""One range of bytes, RFC 9110 section 14.1.2."""

_FORBIDDEN = re.compile(r'[\x00-\x1f\x7f\\/:*?"<>|%;]+')
"""Characters that some file systems or clients do not accept in a name."""

_LONGEST = 180
"""Bytes of a name in UTF-8; file systems accept 255."""

_INPUT_SUFFIXES = tuple(suffix for each in FORMATS for suffix in each.extensions)
"""A gamut may have the name of the file that was posted. Other files do not get its suffix."""


def preferred_media_type(accept: str | None, offered: Sequence[str]) -> str | None:
    """Return the media type of `offered` that a client prefers; None if it accepts none of them.

    The order of `offered` decides ties, and its first type is that of requests without ``Accept``.

    >>> preferred_media_type("text/*;q=0.5, image/png", ["text/html", "image/png"])
    'image/png'
    """
    if accept is None or not accept.strip():
        return offered[0]
    ranges = {name: quality for name, quality in _qualities(accept).items() if "/" in name}
    best, best_quality = None, 0.0
    for media_type in offered:
        kind = media_type.partition("/")[0]
        # The most specific matching range decides (section 12.5.1).
        for pattern in (media_type, f"{kind}/*", "*/*"):
            if pattern in ranges:
                if ranges[pattern] > best_quality:
                    best, best_quality = media_type, ranges[pattern]
                break
    return best


def _qualities(field: str) -> dict[str, float]:
    """Return the names of a list in lower case with their quality values (section 12.4.2)."""
    qualities: dict[str, float] = {}
    for element in _ELEMENT.findall(field):
        name, *parameters = (part.strip().lower() for part in element.split(";"))
        quality = 1.0
        for parameter in parameters:
            key, _, value = parameter.partition("=")
            if key.strip() == "q" and _QUALITY.match(value.strip()):
                quality = float(value)
        if name:
            qualities[name] = max(quality, qualities.get(name, 0.0))
    return qualities


@dataclass(frozen=True)
class Preference:
    """How long a client wants to wait for a build (RFC 7240): seconds, or a job at once."""

    respond_async: bool = False
    wait: int | None = None

    def seconds(self, default: float, longest: float) -> float:
        """Return the seconds to wait: the requested time up to `longest`, else `default`."""
        if self.wait is not None:
            return min(self.wait, longest)
        return 0.0 if self.respond_async else default

    def applied_field(self, *, answered_async: bool, longest: float) -> str:
        """Return the value of ``Preference-Applied``; empty if no preference was applied."""
        applied = []
        if self.respond_async and answered_async:
            applied.append("respond-async")
        if self.wait is not None and self.wait <= longest:
            applied.append(f"wait={self.wait}")
        return ", ".join(applied)


def preference(prefer: Sequence[str]) -> Preference:
    """Return the preferences of a request. The first occurrence of a name counts."""
    preferences: dict[str, str] = {}
    for element in _ELEMENT.findall(",".join(prefer)):
        name, _, value = element.partition(";")[0].partition("=")
        preferences.setdefault(name.strip().lower(), value.strip().strip('"'))
    wait = preferences.get("wait", "")
    return Preference("respond-async" in preferences, int(wait) if _SECONDS.match(wait) else None)


@lru_cache(maxsize=256)
def preferred_coding(accept_encoding: bytes) -> str:
    """Return the one of `CODINGS`, or `IDENTITY`, that a client prefers.

    >>> preferred_coding(b"gzip, br")
    'gzip'
    """
    qualities = _qualities(accept_encoding.decode("latin-1"))
    # Identity is acceptable unless it is excluded, but ranks below every coding that is named.
    best, most = IDENTITY, qualities.get("identity", 0.0)
    for coding in CODINGS:
        quality = qualities.get(coding, qualities.get("*", 0.0))
        if quality > 0.0 and (quality > most or (best == IDENTITY and quality == most)):
            best, most = coding, quality
    return best


def compress(content: bytes, coding: str) -> bytes:
    """Return content in one of `CODINGS`. The same content always gives the same bytes."""
    if coding == "zstd":
        return zstd.compress(content, level=_ZSTD_LEVEL)
    return gzip.compress(content, compresslevel=_GZIP_LEVEL, mtime=0)


def compress_response(response: Response, accept_encoding: list[str]) -> Response:
    """Compress a response, which has no entity tag yet, as the client prefers, and return it."""
    response.headers.add_vary_header("Accept-Encoding")
    content = bytes(response.body)
    coding = preferred_coding(",".join(accept_encoding).encode("latin-1"))
    if coding != IDENTITY and len(content) >= SMALLEST:
        response.body = compress(content, coding)
        response.headers["Content-Encoding"] = coding
        response.headers["Content-Length"] = str(len(response.body))
    return response


def entity_tag(content: bytes) -> str:
    """Return the strong entity tag of content: its SHA-256 in quotes."""
    return f'"{hashlib.sha256(content).hexdigest()}"'


def matches(if_none_match: str, etag: str) -> bool:
    """Return whether ``If-None-Match`` names a tag, by weak comparison (section 13.1.2).

    >>> matches('"a", W/"b"', '"b"')
    True
    """
    if if_none_match.strip() == "*":
        return True
    return any(tag.strip().removeprefix("W/") == etag for tag in if_none_match.split(","))


def check_if_match(fields: Sequence[str], *etags: str) -> None:
    """Raise ``precondition-failed`` unless ``If-Match`` names one of the tags (section 13.1.1).

    Without `fields`, the values of ``If-Match``, the check passes.
    """
    named = [tag.strip() for field in fields for tag in field.split(",")]
    if fields and named != ["*"] and not any(tag in etags for tag in named):
        code = "precondition-failed"
        raise ProblemError(Problem(code, KINDS[code].detail, {"header": "If-Match"}))


def conditional(answer: Response, request_headers: Headers) -> Response:
    """Return a complete response with its entity tag, or 304 if the client has it already.

    ``If-Match`` among the header fields of the request may raise ``precondition-failed``.
    """
    etag = answer.headers["ETag"] = entity_tag(bytes(answer.body))
    check_if_match(request_headers.getlist("if-match"), etag)
    known = request_headers.getlist("if-none-match")
    if known and matches(",".join(known), etag):
        names = ("ETag", "Cache-Control", "Vary")
        headers = {name: answer.headers[name] for name in names if name in answer.headers}
        return Response(status_code=304, headers=headers)
    return answer


def byte_range(
    range_field: str, if_range: str | None, etag: str, size: int
) -> tuple[int, int] | None:
    """Return the start and the end of the requested part of a file of `size` bytes.

    None is the whole content: no range, several ranges, a malformed range, or a range of other
    content, which section 14.2 allows a server to ignore. Raise ``range-not-satisfiable`` if the
    range starts after the end.
    """
    match = _RANGE.match(range_field)
    if match is None or (if_range is not None and if_range.strip() != etag):
        return None
    first, last = match.groups()
    if first:
        start, end = int(first), min(int(last) + 1, size) if last else size
        if last and int(last) < start:
            return None
    elif last:
        start, end = max(size - int(last), 0), size
    else:
        return None
    if start >= size or start == end:
        raise ProblemError(
            Problem(
                "range-not-satisfiable",
                f"The file has {size} bytes.",
                {"header": "Range"},
                headers={"Content-Range": f"bytes */{size}"},
            )
        )
    return start, end


def content_disposition(kind: str, name: str, rest: str) -> str:
    r"""Return ``Content-Disposition`` (RFC 6266, RFC 8187) for a gamut with any name.

    `kind` is ``inline`` or ``attachment``. The suffix of a format that is read is left out of
    `name`, and `rest` follows it in ASCII, with the suffix of the file.

    >>> content_disposition("inline", "Coated 300 %", "-1000.glb")
    'inline; filename="Coated 300 _-1000.glb"'
    >>> content_disposition("attachment", "Blätter", ".gamut")
    'attachment; filename="Blatter.gamut"; filename*=UTF-8\'\'Bl%C3%A4tter.gamut'
    >>> content_disposition("inline", "ball.npy", "-996.glb")
    'inline; filename="ball-996.glb"'
    """
    whole = _cleaned(_without_suffix(name))
    plain = unicodedata.normalize("NFKD", whole).encode("ascii", "ignore").decode()
    value = f'{kind}; filename="{_cleaned(plain)}{rest}"'
    if plain == whole:
        return value
    return f"{value}; filename*=UTF-8''{quote(whole + rest, safe='')}"


def _without_suffix(name: str) -> str:
    """Return the name of a file without the suffix of a format that is read."""
    stem, dot, suffix = name.rpartition(".")
    return stem if stem and f"{dot}{suffix}".lower() in _INPUT_SUFFIXES else name


def _cleaned(name: str) -> str:
    """Return a name that file systems accept."""
    accepted = _FORBIDDEN.sub("_", name).strip().lstrip(".")
    short = accepted.encode("utf-8", "replace")[:_LONGEST].decode("utf-8", "ignore").strip()
    return short or "gamut"


async def send_content(
    send: Send, status: int, headers: list[tuple[bytes, bytes]], body: bytes
) -> None:
    """Send an answer in pieces, between which the server waits for a slow client.

    It would take all at once, and keep what the client does not read. So the caller returns when
    most of the content is sent.
    """
    await send({"type": "http.response.start", "status": status, "headers": headers})
    last = max(0, len(body) - 1) // _PIECE * _PIECE
    for start in range(0, last, _PIECE):
        piece = body[start : start + _PIECE]
        await send({"type": "http.response.body", "body": piece, "more_body": True})
    await send({"type": "http.response.body", "body": body[last:]})
