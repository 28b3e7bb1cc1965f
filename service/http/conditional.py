"""Conditional and range requests (RFC 9110, sections 13 and 14) for immutable content.

Everything under a gamut's id is immutable, and its entity tag is the digest of the content.
"""

from __future__ import annotations

import hashlib
import re
from typing import TYPE_CHECKING

from starlette.responses import Response

from service.problems.kinds import KINDS
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from starlette.datastructures import Headers

__all__ = ["IMMUTABLE", "byte_range", "check_if_match", "conditional", "entity_tag", "matches"]

IMMUTABLE = "public, max-age=31536000, immutable"
"""Cache-Control of immutable content (RFC 8246). One year is the usual maximum."""

_RANGE = re.compile(r"bytes=\s*(\d{0,18})-(\d{0,18})\s*\Z", re.ASCII | re.IGNORECASE)
"""One range of bytes, RFC 9110 section 14.1.2."""


def entity_tag(content: bytes) -> str:
    """Return the strong entity tag of content: its SHA-256 in quotes."""
    return f'"{hashlib.sha256(content).hexdigest()}"'


def matches(if_none_match: str, etag: str) -> bool:
    """Return whether ``If-None-Match`` names a tag, by weak comparison (section 13.1.2).

    Examples
    --------
    >>> matches('"a", W/"b"', '"b"')
    True
    """
    if if_none_match.strip() == "*":
        return True
    return any(tag.strip().removeprefix("W/") == etag for tag in if_none_match.split(","))


def check_if_match(fields: Sequence[str], *etags: str) -> None:
    """Raise ``precondition-failed`` unless ``If-Match`` names one of the tags (section 13.1.1).

    Parameters
    ----------
    fields : sequence of str
        The values of ``If-Match``. Without a value, the check passes.
    etags : str
        Strong entity tags of the content. None for content without a tag.
    """
    named = [tag.strip() for field in fields for tag in field.split(",")]
    if fields and named != ["*"] and not any(tag in etags for tag in named):
        code = "precondition-failed"
        raise ProblemError(Problem(code, KINDS[code].detail, {"header": "If-Match"}))


def conditional(answer: Response, asked: Headers) -> Response:
    """Return a complete response with its entity tag, or 304 if the client has it already.

    Parameters
    ----------
    answer : Response
        Receives the tag.
    asked : Headers
        Header fields of the request. ``If-Match`` may raise ``precondition-failed``.
    """
    etag = answer.headers["ETag"] = entity_tag(bytes(answer.body))
    check_if_match(asked.getlist("if-match"), etag)
    known = asked.getlist("if-none-match")
    if known and matches(",".join(known), etag):
        names = ("ETag", "Cache-Control", "Vary")
        kept = {name: answer.headers[name] for name in names if name in answer.headers}
        return Response(status_code=304, headers=kept)
    return answer


def byte_range(
    range_field: str, if_range: str | None, etag: str, size: int
) -> tuple[int, int] | None:
    """Return the start and the end of the requested part of a file.

    Parameters
    ----------
    range_field : str
        The value of ``Range``; empty if the field is missing.
    if_range : str or None
        The value of ``If-Range``.
    etag : str
        Entity tag of the content.
    size : int
        Length of the content in bytes.

    Returns
    -------
    tuple of int or None
        None for the whole content: no range, several ranges, a malformed range, or a range of other
        content. RFC 9110 section 14.2 allows a server to ignore these.

    Raises
    ------
    ProblemError
        ``range-not-satisfiable``: the range starts after the end.
    """
    found = _RANGE.match(range_field)
    if found is None or (if_range is not None and if_range.strip() != etag):
        return None
    first, last = found.groups()
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
