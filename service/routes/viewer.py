"""Routes of pages with scripts: the viewer and Swagger UI, and their files in the package.

The viewer shows, compares and builds gamuts. Its files are built from ``web/viewer`` into
``gamutcore/export/viewer`` (``make viewer``). Nothing is loaded from another origin, and the
content security policies enforce that. The addresses of files contain a digest or a version, so
they are cached for ever. See ``docs/decisions/viewer.md`` and ``docs/decisions/swagger-ui.md``.
"""

import asyncio
import base64
import functools
import hashlib
import re
from html import escape
from importlib.resources import files
from pathlib import Path as FilePath
from typing import Annotated

from fastapi import APIRouter, Path, Request
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import HTMLResponse, Response

from gamutcore.export.viewer_page import VIEWER_FILES
from service.http.representations import (
    IDENTITY,
    IMMUTABLE,
    compress,
    compress_response,
    conditional,
    entity_tag,
    matches,
    preferred_coding,
    preferred_media_type,
)
from service.problems.problem import JsonResponse, Problem, ProblemError
from service.routes.pages import SECURITY_HEADERS, status

__all__ = [
    "MEDIA_TYPES",
    "SWAGGER_MEDIA_TYPES",
    "SWAGGER_VERSION",
    "prefers_page",
    "router",
    "version",
    "viewer_page",
]

router = APIRouter(include_in_schema=False)

SWAGGER_VERSION = "5.35.0"
"""Version of the npm package. Its origin is noted beside the files."""

SWAGGER_MEDIA_TYPES = {
    "swagger-ui.css": "text/css; charset=utf-8",
    "swagger-ui-bundle.js": "text/javascript; charset=utf-8",
    # The first line of the bundle refers to this file.
    "swagger-ui-bundle.js.LICENSE.txt": "text/plain; charset=utf-8",
}
"""Files of Swagger UI and their media types."""

MEDIA_TYPES = {
    "viewer.css": "text/css; charset=utf-8",
    "viewer.js": "text/javascript; charset=utf-8",
    "worker.js": "text/javascript; charset=utf-8",
    "LICENSE": "text/plain; charset=utf-8",
}
"""Files of the viewer and their media types."""

_SWAGGER_FILES = FilePath(str(files("service"))) / "static" / "swagger-ui"

_NOWHERE_ELSE = "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"

_VIEWER_POLICY = (
    "default-src 'none'; script-src 'self'; worker-src 'self'; style-src 'self'; "
    # The empty icon is a data: image, and rings are fetched with the API key.
    f"connect-src 'self'; img-src 'self' data: blob:; {_NOWHERE_ELSE}"
)


@router.get("/docs")
async def documentation(request: Request) -> Response:
    """Show all operations, interactive."""
    root = request.scope.get("root_path", "").rstrip("/")
    swagger = get_swagger_ui_html(
        openapi_url=f"{root}/openapi.json",
        title="Gamut boundary service",
        swagger_js_url=f"{root}/docs/{SWAGGER_VERSION}/swagger-ui-bundle.js",
        swagger_css_url=f"{root}/docs/{SWAGGER_VERSION}/swagger-ui.css",
        swagger_favicon_url="data:,",
        # By default, a foreign server would validate the document.
        swagger_ui_parameters={"validatorUrl": None},
    )
    text = bytes(swagger.body).decode()
    scripts = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    digests = " ".join(
        f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'"
        for script in scripts
    )
    policy = (
        f"default-src 'none'; script-src 'self' {digests}; connect-src 'self'; "
        # Swagger UI sets inline styles and uses data: images.
        f"style-src 'self' 'unsafe-inline'; img-src 'self' data:; {_NOWHERE_ELSE}"
    )
    headers = {**SECURITY_HEADERS, "Cache-Control": "no-cache", "Content-Security-Policy": policy}
    answer = HTMLResponse(text.replace("<html>", '<html lang="en">'), headers=headers)
    return conditional(answer, request.headers)


@router.get("/openapi.json")
async def openapi(request: Request) -> Response:
    """Return the OpenAPI document."""
    document = request.app.openapi()
    root = request.scope.get("root_path", "").rstrip("/")
    if root:
        document = {**document, "servers": [{"url": root}]}
    answer: Response = JsonResponse(document, headers={"Cache-Control": "no-cache"})
    answer = compress_response(answer, request.headers.getlist("accept-encoding"))
    return conditional(answer, request.headers)


@router.get("/docs/{version}/{name}")
async def documentation_file(
    request: Request, version: Annotated[str, Path()], name: Annotated[str, Path()]
) -> Response:
    """Return a file of Swagger UI."""
    if version != SWAGGER_VERSION or name not in SWAGGER_MEDIA_TYPES:
        detail = "The documentation has no such file."
        raise ProblemError(Problem("not-found", detail, remedy="The documentation is at /docs."))
    path, media_type = _SWAGGER_FILES / name, SWAGGER_MEDIA_TYPES[name]
    return await asyncio.to_thread(_file_response, request, path, media_type)


@router.get("/")
async def root(request: Request) -> Response:
    """Show the viewer in a browser, and the state of the service to others."""
    return viewer_page(request) if prefers_page(request) else await status(request)


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
    return await asyncio.to_thread(_file_response, request, VIEWER_FILES / name, MEDIA_TYPES[name])


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
        "Content-Security-Policy": _VIEWER_POLICY,
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


def _file_response(request: Request, path: FilePath, media_type: str) -> Response:
    """Return a file that is cached for ever. Compresses it, so this may take a while."""
    accepted = ",".join(request.headers.getlist("accept-encoding"))
    coding = preferred_coding(accepted.encode("latin-1"))
    content, etag = _content(path, coding)
    headers = {"ETag": etag, "Cache-Control": IMMUTABLE, "Vary": "Accept-Encoding"}
    known = request.headers.getlist("if-none-match")
    if known and matches(",".join(known), etag):
        return Response(status_code=304, headers=headers)
    headers["X-Content-Type-Options"] = "nosniff"
    if coding != IDENTITY:
        headers["Content-Encoding"] = coding
    return Response(content, media_type=media_type, headers=headers)


@functools.cache
def _content(path: FilePath, coding: str) -> tuple[bytes, str]:
    """Return a file in a coding with its entity tag. The cache holds 5 MB in total."""
    content = path.read_bytes()
    if coding != IDENTITY:
        content = compress(content, coding)
    return content, entity_tag(content)
