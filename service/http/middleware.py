"""Small ASGI layers around the whole app: a limit for bodies, HEAD for every GET, plain paths.

FastAPI's own ``max_body_size`` answers a declared length over the limit with plain text that no
exception handler sees (0.165), so the limit is enforced here, where it becomes a problem document
for declared, chunked and multipart bodies alike.
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
"""Header fields that ask for a part."""


class BodyLimit:
    """Refuses bodies of more than `limit` bytes, before they are read where their length is known.

    Parameters
    ----------
    app : ASGI app
        Its exception handlers must know `ProblemError`.
    limit : int
        Bytes.
    """

    def __init__(self, app: ASGIApp, limit: int) -> None:
        self.app = app
        self.limit = limit

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on with a `receive` that counts."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        for name, value in scope["headers"]:
            # int() takes more than digits; the server refuses such lengths, so they need no answer.
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
    """Answers HEAD as GET without the body, RFC 9110 clause 9.3.2."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass HEAD on as GET and leave the content out of the answer."""
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self.app(scope, receive, send)
            return

        async def send_without_content(message: Message) -> None:
            # The answer is over with its header fields: whoever goes on to produce a long or an
            # endless content sees the client leave.
            if message["type"] == "http.response.start":
                await send(message)
                await send({"type": "http.response.body", "body": b""})

        # Ranges are defined for GET only (14.2): HEAD tells what the whole is like.
        headers = [field for field in scope["headers"] if field[0] not in _PARTIAL]
        as_get = {**scope, "method": "GET", "headers": headers}
        try:
            await self.app(as_get, receive, send_without_content)
        finally:
            # Who looks from outside sees which route it was.
            scope["route"] = as_get.get("route")


class PlainPaths:
    """Answers that there is nothing at paths with control characters.

    The router's patterns end in ``$``, which takes ``/v1/gamuts`` and a newline for the same.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on if its path is free of control characters."""
        if scope["type"] == "http" and _CONTROL.search(scope["path"]):
            detail = "There is nothing at a path with control characters."
            await problem_response(Problem("not-found", detail))(scope, receive, send)
            return
        await self.app(scope, receive, send)
