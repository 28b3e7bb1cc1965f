"""Cross-origin requests (Fetch standard, CORS): pages of listed origins may use the API.

Answers to listed origins differ from answers to others. Therefore every answer has ``Vary:
Origin``, even if the request has no origin; otherwise a cache could mix them up. API keys are
header fields that scripts set themselves, so credentials of the browser are never allowed. See
``docs/decisions/cors.md``.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from starlette.datastructures import MutableHeaders
from starlette.middleware.cors import CORSMiddleware
from starlette.responses import Response

if TYPE_CHECKING:
    from collections.abc import Sequence

    from starlette.datastructures import Headers
    from starlette.types import ASGIApp, Message, Send

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

_METHODS = ("GET", "HEAD", "POST", "PUT", "DELETE")

_PREFLIGHT_SECONDS = 7200
"""Lifetime of a preflight answer in the browser. Chromium's maximum."""

_ORIGIN = re.compile(r"(?:\*|null|[a-z][a-z0-9+.-]*://[a-z0-9.\-\[\]:]+)\Z")


def origins(text: str) -> tuple[str, ...]:
    """Return the origins in a setting, separated by commas or spaces.

    Raise ValueError unless each is scheme, host and optional port, in lower case, without a path.
    """
    values = tuple(text.replace(",", " ").split())
    for origin in values:
        if not _ORIGIN.match(origin):
            message = (
                f"{origin} is not an origin. Give scheme, host and optional port, such as "
                "https://example.org, or *."
            )
            raise ValueError(message)
    return values


class Cors(CORSMiddleware):
    """Starlette's CORS middleware for shared caches; `allowed` are origins or ``*``.

    With ``*``, all answers get the same fields, so one cached answer serves all pages. Answers to
    origins that are not allowed get none.
    """

    def __init__(self, app: ASGIApp, allowed: Sequence[str]) -> None:
        super().__init__(
            app,
            allow_origins=allowed,
            allow_methods=_METHODS,
            allow_headers=ALLOWED_FIELDS,
            expose_headers=EXPOSED_FIELDS,
            max_age=_PREFLIGHT_SECONDS,
        )

    def preflight_response(self, request_headers: Headers) -> Response:
        """Answer without content. Without a permission, the browser refuses the request."""
        headers = self._permission(request_headers["origin"])
        if "Access-Control-Allow-Origin" in headers:
            del headers["Access-Control-Expose-Headers"]
            headers = {**self.preflight_headers, **headers}
        headers["Cache-Control"] = "no-store"
        return Response(status_code=204, headers=headers)

    async def send(self, message: Message, send: Send, request_headers: Headers) -> None:
        """Add the permission to the start of an answer."""
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in self._permission(request_headers.get("origin", "")).items():
                headers.append(name, value)
        await send(message)

    def _permission(self, origin: str) -> dict[str, str]:
        vary = {} if self.allow_all_origins else {"Vary": "Origin"}
        if not self.is_allowed_origin(origin):
            return vary
        granted = "*" if self.allow_all_origins else origin
        return {
            **vary,
            **self.simple_headers,
            "Access-Control-Allow-Origin": granted,
            "Timing-Allow-Origin": granted,
        }
