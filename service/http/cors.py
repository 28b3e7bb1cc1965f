"""Cross-origin requests (Fetch standard, CORS): pages of listed origins may use the API.

Answers to listed origins differ from answers to others. Therefore every answer has ``Vary:
Origin``, even if the request has no origin; otherwise a cache could mix them up. Starlette's
middleware adds it only to requests with an origin. API keys are header fields that scripts set
themselves, so credentials of the browser are never allowed. See ``docs/decisions/cors.md``.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = ["ALLOWED_FIELDS", "EXPOSED_FIELDS", "Cors", "origins"]

EXPOSED_FIELDS = (
    "Accept-Ranges",
    "Content-Disposition",
    "Content-Encoding",
    "Content-Location",
    "Content-Range",
    "ETag",
    "Gamut-Edge-Width",
    "Gamut-Conditions",
    "Gamut-Failures",
    "Gamut-Max-Error",
    "Gamut-Max-Mismatch",
    "Gamut-Reading",
    "Gamut-Tolerance",
    "Gamut-Triangles",
    "Gamut-Vertices",
    "Gamut-Warning",
    "Link",
    "Location",
    "Preference-Applied",
    "RateLimit",
    "RateLimit-Policy",
    "Retry-After",
    "Server-Timing",
    "WWW-Authenticate",
    "X-Request-Id",
)
"""Header fields of answers that scripts may read, besides the safelisted ones."""

ALLOWED_FIELDS = (
    "Accept",
    "Authorization",
    "Content-Type",
    "If-Match",
    "If-None-Match",
    "If-Range",
    "Last-Event-ID",
    "Prefer",
    "Range",
    "traceparent",
    "tracestate",
    "X-Api-Key",
    "X-Request-Id",
)
"""Header fields of requests that scripts may set."""

_METHODS = "GET, HEAD, POST, PUT, DELETE"

_PREFLIGHT_SECONDS = "7200"
"""Lifetime of a preflight answer in the browser. Chromium's maximum."""

_ORIGIN = re.compile(r"(?:\*|null|[a-z][a-z0-9+.-]*://[a-z0-9.\-\[\]:]+)\Z")


def origins(text: str) -> tuple[str, ...]:
    """Return the origins in a setting, separated by commas or spaces.

    Raises
    ------
    ValueError
        An entry is not an origin: scheme, host and optional port, in lower case, without a path.
    """
    found = tuple(text.replace(",", " ").split())
    for origin in found:
        if not _ORIGIN.match(origin):
            message = (
                f"{origin} is not an origin. Give scheme, host and optional port, such as "
                "https://example.org, or *."
            )
            raise ValueError(message)
    return found


class Cors:
    """ASGI middleware that answers preflights and lets listed origins read answers.

    Parameters
    ----------
    app : ASGI app
    allowed : sequence of str
        Origins; ``*`` for all.
    """

    def __init__(self, app: ASGIApp, allowed: Sequence[str]) -> None:
        self.app = app
        self._all = "*" in allowed
        self._allowed = {origin.encode("latin-1") for origin in allowed}
        self._vary = [] if self._all else [(b"vary", b"Origin")]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a preflight; pass every other request on."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        fields = dict(scope["headers"])
        origin = fields.get(b"origin")
        added = [*self._vary, *self._permission(origin)]
        if (
            scope["method"] == "OPTIONS"
            and origin is not None
            and b"access-control-request-method" in fields
        ):
            await _send_preflight(send, added)
            return

        async def send_with_permission(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message["headers"], *added]
            await send(message)

        await self.app(scope, receive, send_with_permission if added else send)

    def _permission(self, origin: bytes | None) -> list[tuple[bytes, bytes]]:
        if self._all:
            # The same for all requests, so that caches can keep one answer.
            granted = b"*"
        elif origin is not None and origin in self._allowed:
            granted = origin
        else:
            return []
        return [
            (b"access-control-allow-origin", granted),
            (b"access-control-expose-headers", ", ".join(EXPOSED_FIELDS).encode()),
            (b"timing-allow-origin", granted),
        ]


async def _send_preflight(send: Send, permission: list[tuple[bytes, bytes]]) -> None:
    """Answer a preflight. Without a permission, the browser refuses the request."""
    headers = [item for item in permission if item[0] != b"access-control-expose-headers"]
    if any(name == b"access-control-allow-origin" for name, _ in headers):
        headers += [
            (b"access-control-allow-methods", _METHODS.encode()),
            (b"access-control-allow-headers", ", ".join(ALLOWED_FIELDS).encode()),
            (b"access-control-max-age", _PREFLIGHT_SECONDS.encode()),
        ]
    headers.append((b"cache-control", b"no-store"))
    await send({"type": "http.response.start", "status": 204, "headers": headers})
    await send({"type": "http.response.body", "body": b""})
