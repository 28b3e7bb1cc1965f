"""Request observer: request ids, ``Server-Timing``, metrics and access log.

The ASGI middleware is outside everything else. So it also sees the answers of other middleware, and
the answers to defects. Queries are logged only if they
consist of known parameters, because others may contain credentials.
"""

from __future__ import annotations

import logging
import os
import re
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import quote

from service.access.middleware import client_key
from service.http.request_context import REQUEST_ID, RequestContext, current_request

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from service.telemetry.metrics import RequestMetrics

__all__ = ["KNOWN_PARAMETERS", "UNMATCHED", "MatchedRoute", "RequestObserver"]

logger = logging.getLogger("service.access")

UNMATCHED = "unmatched"
"""Route of requests that match no route."""

_DISCONNECTED = 499
"""Status for a request without an answer, as in nginx: the client is gone."""

KNOWN_PARAMETERS = (
    "triangles",
    "max_error",
    "max_mismatch",
    "side",
    "format",
    "limit",
    "lost",
    "after",
    "name",
    "match",
    "options",
    *("a", "b", "with", "reference", "sectors", "hues", "hue", "lightness", "plane"),
    *("space", "distance", "tolerance", "edge_width", "position", "metric", "kind"),
    *("noise", "instrument", "gamuts", "names", "pass", "delta_e", "recipes"),
    *("method", "focus", "source", "destination", "columns", "table_scale"),
    *("to", "depth", "table", "iterations", "result"),
    *("size", "view", "background", "axes", "black", "black_point_compensation"),
    *("decode", "preserve"),
)
"""Query parameters that are logged."""

_KNOWN_QUERY = re.compile(
    rf"(?:(?:{'|'.join(KNOWN_PARAMETERS)})=[0-9A-Za-z.,+-]{{0,200}}(?:&|\Z))*\Z"
)

_PLAIN_PATH = re.compile(r"[A-Za-z0-9/._-]*\Z")

_FIELD = REQUEST_ID.lower().encode()

_SANE_ID = re.compile(rb"[A-Za-z0-9._~+/=:@-]{1,128}\Z")
"""Accepted ids of clients. They appear in logs and in header fields of other programs."""

_LONGEST_PATH = 500
"""Number of characters of a path that are logged."""


class MatchedRoute(NamedTuple):
    """Value of ``scope["route"]`` when middleware answers instead of a route."""

    path: str


class RequestObserver:
    """ASGI middleware that identifies, counts, times and logs requests.

    The answer gets ``X-Request-Id`` and ``Server-Timing`` (W3C). The reported times end where the
    answer starts. The app sets ``scope["route"]`` to the matched route, as Starlette's router does.
    """

    def __init__(self, app: ASGIApp, metrics: RequestMetrics, *, access_log: bool) -> None:
        self.app = app
        self.metrics = metrics
        self.access_log = access_log

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on and record the outcome."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        request = RequestContext(_identifier(scope).decode("ascii"))
        token = current_request.set(request)
        try:
            await self._observe(scope, receive, send, request)
        finally:
            current_request.reset(token)

    async def _observe(
        self, scope: Scope, receive: Receive, send: Send, request: RequestContext
    ) -> None:
        metrics = self.metrics
        metrics.in_progress.inc()
        started = perf_counter()
        status, began, nbytes = 0, 0.0, 0

        async def observing_send(message: Message) -> None:
            nonlocal status, began, nbytes
            if message["type"] == "http.response.start":
                status, began = message["status"], perf_counter()
                times = f"total;dur={1e3 * (began - started):.2f}"
                for name, seconds in request.seconds.items():
                    times += f", {name};dur={1e3 * seconds:.2f}"
                # A new list, because answers with the same content may share the old one.
                message["headers"] = [
                    *message["headers"],
                    (b"server-timing", times.encode("ascii")),
                    (_FIELD, request.id.encode("ascii")),
                ]
            elif "body" in message:
                nbytes += len(message["body"])
            await send(message)

        try:
            await self.app(scope, receive, observing_send)
        except Exception:
            status = status or 500
            raise
        finally:
            metrics.in_progress.dec()
            status = status or _DISCONNECTED
            seconds = (began or perf_counter()) - started
            metrics.count_answer(scope["method"], _route(scope), status, seconds, nbytes)
            if self.access_log:
                _log(scope, status, nbytes, seconds)


def _identifier(scope: Scope) -> bytes:
    """Return the client's own id if it is well formed, else a new one."""
    identifiers = [value for name, value in scope["headers"] if name == _FIELD]
    if len(identifiers) == 1 and _SANE_ID.match(identifiers[0]):
        only: bytes = identifiers[0]
        return only
    return os.urandom(16).hex().encode()


def _route(scope: Scope) -> str:
    route = scope.get("route")
    path: str = UNMATCHED if route is None else getattr(route, "path", UNMATCHED)
    return path


def _log(scope: Scope, status: int, nbytes: int, seconds: float) -> None:
    method = scope["method"]
    path = scope["path"][:_LONGEST_PATH]
    if not _PLAIN_PATH.match(path):
        path = quote(path, safe="/:@!$&'()*+,;=~")
    query = scope["query_string"].decode("latin-1")
    if not _KNOWN_QUERY.match(query):
        query = "***"
    address = f"{path}?{query}" if query else path
    client = scope.get("client")
    host = client[0] if client else None
    key = client_key(scope)
    milliseconds = round(1000 * seconds, 3)
    logger.info(
        "%s %s %d, %d bytes, %s ms, %s",
        method,
        address,
        status,
        nbytes,
        milliseconds,
        f"{host} key {key.name}" if key else host,
        extra={
            "method": method,
            "path": path,
            "query": query,
            "route": _route(scope),
            "status": status,
            "bytes": nbytes,
            "milliseconds": milliseconds,
            "client": host,
            "key": key.name if key else None,
        },
    )
