"""Request ids: the client's own id if it is well formed, else a new one.

The id is in ``X-Request-Id`` of every answer, and in a context variable for the log.
"""

from __future__ import annotations

import os
import re
from contextvars import ContextVar
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = ["HEADER", "RequestIds", "current_request_id"]

HEADER = "X-Request-Id"
"""Header field of requests and answers."""

_FIELD = HEADER.lower().encode()

_SANE = re.compile(rb"[A-Za-z0-9._~+/=:@-]{1,128}\Z")
"""Accepted ids of clients. They appear in logs and in header fields of other programs."""

_current: ContextVar[str] = ContextVar("request_id", default="")


def current_request_id() -> str:
    """Return the id of the current request; empty outside of requests."""
    return _current.get()


class RequestIds:
    """ASGI middleware that assigns an id to every request.

    Parameters
    ----------
    app : ASGI app
        Runs with `current_request_id` set.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on and add its id to the answer."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        identifier = _identifier(scope)
        token = _current.set(identifier.decode("ascii"))

        async def send_with_id(message: Message) -> None:
            if message["type"] == "http.response.start":
                # A new list, because answers with the same content may share the old one.
                message["headers"] = [*message["headers"], (_FIELD, identifier)]
            await send(message)

        try:
            await self.app(scope, receive, send_with_id)
        finally:
            _current.reset(token)


def _identifier(scope: Scope) -> bytes:
    given = [value for name, value in scope["headers"] if name == _FIELD]
    if len(given) == 1 and _SANE.match(given[0]):
        identifier: bytes = given[0]
        return identifier
    return os.urandom(16).hex().encode()
