"""Routes of the viewer: a page on which gamuts are seen, compared and built, and its files.

The files are built from ``web/viewer`` into ``gamutcore/export/viewer`` (``make viewer``). The page
has no inline script or style, and the content security policy allows nothing else than these files.
Their addresses contain a digest, so they are cached for ever. See ``docs/decisions/viewer.md``.
"""

import asyncio
import functools
import hashlib
from html import escape
from typing import Annotated

from fastapi import APIRouter, Path, Request
from fastapi.responses import HTMLResponse, Response

from gamutcore.export.viewer_page import VIEWER_FILES
from service.http.conditional import conditional
from service.http.negotiation import preferred_media_type
from service.problems.problem import Problem, ProblemError
from service.routes.html_pages import SECURITY_HEADERS
from service.routes.static_files import static_file

__all__ = ["MEDIA_TYPES", "prefers_page", "router", "version", "viewer_page"]

router = APIRouter(include_in_schema=False)

MEDIA_TYPES = {
    "viewer.css": "text/css; charset=utf-8",
    "viewer.js": "text/javascript; charset=utf-8",
    "worker.js": "text/javascript; charset=utf-8",
    "LICENSE": "text/plain; charset=utf-8",
}
"""Served files and their media types."""


_POLICY = (
    "default-src 'none'; script-src 'self'; worker-src 'self'; style-src 'self'; "
    # The empty icon is a data: image, and rings are fetched with the API key.
    "connect-src 'self'; img-src 'self' data: blob:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


@router.get("/view")
async def view(request: Request) -> Response:
    """Show the viewer without a gamut."""
    return viewer_page(request)


@router.get("/view/{digest}/{name}")
async def viewer_file(
    request: Request, digest: Annotated[str, Path()], name: Annotated[str, Path()]
) -> Response:
    """Return a file of the viewer."""
    if digest != version() or name not in MEDIA_TYPES:
        detail = "The viewer has no such file."
        raise ProblemError(Problem("not-found", detail, remedy="The viewer is at /view."))
    return await asyncio.to_thread(
        static_file, request.headers, name, MEDIA_TYPES[name], VIEWER_FILES
    )


def prefers_page(request: Request) -> bool:
    """Return whether a client prefers a page to JSON, as browsers do."""
    accept = ",".join(request.headers.getlist("accept"))
    return preferred_media_type(accept, ("application/json", "text/html")) == "text/html"


def viewer_page(request: Request) -> Response:
    """Return the page of the viewer. Its script takes the gamut from the address."""
    root = request.scope.get("root_path", "").rstrip("/")
    headers = {
        **SECURITY_HEADERS,
        "Cache-Control": "no-cache",
        "Content-Security-Policy": _POLICY,
        "Vary": "Accept",
    }
    return conditional(HTMLResponse(_page(root), headers=headers), request.headers)


@functools.cache
def version() -> str:
    """Return a digest of the viewer's files."""
    content = b"".join((VIEWER_FILES / name).read_bytes() for name in MEDIA_TYPES)
    return hashlib.sha256(content).hexdigest()[:16]


@functools.lru_cache(maxsize=8)
def _page(root: str) -> str:
    text = (VIEWER_FILES / "index.html").read_text("utf-8")
    root = escape(root)
    return text.replace("{root}", root).replace("{files}", f"{root}/view/{version()}")
