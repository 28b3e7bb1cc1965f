"""What log lines and ``Server-Timing`` know of the current request.

`RequestObserver` sets the context. Work in a separate task or thread belongs to the request that
started it. The module does not import the web framework, because worker processes log too.
"""

from __future__ import annotations

import time
from contextvars import ContextVar
from typing import Self

__all__ = [
    "REQUEST_ID",
    "RequestContext",
    "current_request",
    "current_request_id",
    "timed",
]

REQUEST_ID = "X-Request-Id"
"""Header field of requests and answers."""


class RequestContext:
    """One request: its id, and the seconds of each part of its work."""

    __slots__ = ("id", "seconds")

    def __init__(self, identifier: str) -> None:
        self.id = identifier
        self.seconds: dict[str, float] = {}


current_request: ContextVar[RequestContext | None] = ContextVar("request", default=None)


def current_request_id() -> str:
    """Return the id of the current request; empty outside of requests."""
    request = current_request.get()
    return "" if request is None else request.id


class timed:  # noqa: N801 - a context manager, read like a function
    """Context manager that adds its duration to ``Server-Timing`` of the current request.

    The name is a token of RFC 9110. Times of the same name add up.
    """

    __slots__ = ("_name", "_start")

    def __init__(self, name: str) -> None:
        self._name = name

    def __enter__(self) -> Self:
        self._start = time.perf_counter()
        return self

    def __exit__(self, *_error: object) -> None:
        request = current_request.get()
        if request is not None:
            elapsed = time.perf_counter() - self._start
            request.seconds[self._name] = request.seconds.get(self._name, 0.0) + elapsed
