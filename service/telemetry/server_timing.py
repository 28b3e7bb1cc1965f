"""``Server-Timing`` (W3C): the time that each part of a request took.

Code measures a part with ``with timed("encode")``. Times of the same name add up. Work in a
separate task counts for the request that started it.
"""

from __future__ import annotations

import time
from contextvars import ContextVar
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = ["FIELD", "ServerTiming", "timed"]

FIELD = b"server-timing"

_current: ContextVar[dict[str, float] | None] = ContextVar("server_timing", default=None)


class timed:  # noqa: N801 - a context manager, read like a function
    """Context manager that adds its duration to the answer of the current request.

    The name is a token of RFC 9110.
    """

    __slots__ = ("_name", "_start")

    def __init__(self, name: str) -> None:
        self._name = name

    def __enter__(self) -> Self:
        self._start = time.perf_counter()
        return self

    def __exit__(self, *_error: object) -> None:
        seconds = _current.get()
        if seconds is not None:
            elapsed = time.perf_counter() - self._start
            seconds[self._name] = seconds.get(self._name, 0.0) + elapsed


class ServerTiming:
    """ASGI middleware that adds the times of a request to its answer."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on. The reported total ends where the answer starts."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        start = time.perf_counter()
        seconds: dict[str, float] = {}
        token = _current.set(seconds)

        async def send_with_times(message: Message) -> None:
            if message["type"] == "http.response.start":
                total = time.perf_counter() - start
                text = f"total;dur={1e3 * total:.2f}"
                for name, value in seconds.items():
                    text += f", {name};dur={1e3 * value:.2f}"
                message["headers"] = [*message["headers"], (FIELD, text.encode("ascii"))]
            await send(message)

        try:
            await self.app(scope, receive, send_with_times)
        finally:
            _current.reset(token)
