"""Requests as a whole: HEAD for every GET, and the checks that come before any other.

FastAPI's ``max_body_size`` answers with plain text that no exception handler sees, so declared
lengths are checked here, and `service.http.spool` counts what arrives.
"""

from __future__ import annotations

import codecs
import re
from typing import TYPE_CHECKING

from python_multipart.multipart import parse_options_header
from starlette.routing import BaseRoute, Match

from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = ["ControlCharacters", "HeadAsGet", "check_head"]

_CONTROL = re.compile(r"[\x00-\x1f\x7f]")

_PARTIAL = frozenset({b"range", b"if-range"})
"""Header fields that ask for a part of the content."""

_TEXTS = frozenset({"utf-8", "ascii", "iso8859-1", "cp1252"})
"""Python's names of the accepted charsets. Many other codecs of Python are no charsets, or raise
errors of their own."""


def check_head(request: Request, most_bytes: int) -> None:
    """Refuse bodies that are declared too large, or in other charsets than the accepted ones."""
    for name, value in request.scope["headers"]:
        # The server refuses lengths that are not digits, so they need no answer here.
        if name == b"content-length" and value.isdigit() and int(value) > most_bytes:
            detail = f"The body is larger than {most_bytes} bytes."
            raise ProblemError(Problem("body-too-large", detail, {"limit": most_bytes}))
        if name == b"content-type" and b"charset" in value.lower():
            # Parsed as Starlette's form parser does.
            _, parameters = parse_options_header(value)
            charset = parameters.get(b"charset", b"utf-8").decode("latin-1")
            if not _is_text(charset):
                detail = f"The body has the charset {charset[:40]!r}."
                where = {"header": "Content-Type"}
                remedy = "Send the body in UTF-8."
                raise ProblemError(Problem("unsupported-media-type", detail, where, remedy))


def _is_text(charset: str) -> bool:
    try:
        return codecs.lookup(charset).name in _TEXTS
    except (LookupError, ValueError):
        return False


class HeadAsGet:
    """Answer HEAD as GET without the content (RFC 9110, section 9.3.2)."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass HEAD on as GET and drop the content of the answer."""
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self.app(scope, receive, send)
            return

        async def send_without_content(message: Message) -> None:
            # End the answer after the header fields. Generators of long content then see a
            # disconnect.
            if message["type"] == "http.response.start":
                await send(message)
                await send({"type": "http.response.body", "body": b""})

        # Ranges are defined for GET only (section 14.2).
        headers = [field for field in scope["headers"] if field[0] not in _PARTIAL]
        as_get = {**scope, "method": "GET", "headers": headers}
        try:
            await self.app(as_get, receive, send_without_content)
        finally:
            # The outer middleware needs the matched route.
            scope["route"] = as_get.get("route")


class ControlCharacters(BaseRoute):
    """Answers paths with control characters with ``not-found``, ahead of all other routes.

    Their patterns end in ``$``, which also matches before a final newline.
    """

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Match paths with control characters."""
        found = scope["type"] == "http" and _CONTROL.search(scope["path"])
        return (Match.FULL if found else Match.NONE), {}

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:  # noqa: ARG002
        """Raise the problem."""
        detail = "There is nothing at a path with control characters."
        raise ProblemError(Problem("not-found", detail))
