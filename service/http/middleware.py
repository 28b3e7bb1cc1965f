"""Small ASGI middleware: body limit, HEAD for every GET, and rejection of control characters.

FastAPI's ``max_body_size`` answers with plain text that no exception handler sees. `BodyLimit`
answers with a problem document for declared, chunked and multipart bodies.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from service.problems.problem import Problem, ProblemError, problem_response

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = ["BodyLimit", "HeadAsGet", "PlainPaths"]

_CONTROL = re.compile(r"[\x00-\x1f\x7f]")

_PARTIAL = frozenset({b"range", b"if-range"})
"""Header fields that ask for a part of the content."""


class BodyLimit:
    """Refuse bodies over `limit` bytes; declared lengths are refused before the body is read.

    Parameters
    ----------
    app : ASGI app
        Its exception handlers must handle `ProblemError`.
    limit : int
        Bytes.
    """

    def __init__(self, app: ASGIApp, limit: int) -> None:
        self.app = app
        self.limit = limit

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on with a `receive` that counts bytes."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        for name, value in scope["headers"]:
            # The server refuses lengths that are not digits, so they need no answer here.
            if name == b"content-length" and value.isdigit() and int(value) > self.limit:
                await problem_response(self._problem())(scope, receive, send)
                return
        read = 0

        async def counting_receive() -> Message:
            nonlocal read
            message = await receive()
            read += len(message.get("body", b""))
            if read > self.limit:
                raise ProblemError(self._problem())
            return message

        await self.app(scope, counting_receive, send)

    def _problem(self) -> Problem:
        detail = f"The body is larger than {self.limit} bytes."
        return Problem("body-too-large", detail, {"limit": self.limit})


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


class PlainPaths:
    """Answer paths with control characters with ``not-found``.

    The router's patterns end in ``$``, which also matches before a final newline.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on if its path has no control characters."""
        if scope["type"] == "http" and _CONTROL.search(scope["path"]):
            detail = "There is nothing at a path with control characters."
            await problem_response(Problem("not-found", detail))(scope, receive, send)
            return
        await self.app(scope, receive, send)
