"""Routes of the interactive documentation: Swagger UI from files of the package.

Nothing is loaded from another origin, and the content security policy enforces that. The addresses
contain Swagger UI's version, so they are cached for ever. See ``docs/decisions/swagger-ui.md``.
"""

import asyncio
import base64
import hashlib
import re
from typing import Annotated

from fastapi import APIRouter, Path, Request
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import HTMLResponse, Response

from service.http.compression import compress_response
from service.http.conditional import conditional
from service.problems.problem import JsonResponse, Problem, ProblemError
from service.routes.html_pages import SECURITY_HEADERS
from service.routes.static_files import static_file

__all__ = ["MEDIA_TYPES", "VERSION", "router"]

router = APIRouter(include_in_schema=False)

VERSION = "5.35.0"
"""Version of the npm package. Its origin is noted beside the files."""

MEDIA_TYPES = {
    "swagger-ui.css": "text/css; charset=utf-8",
    "swagger-ui-bundle.js": "text/javascript; charset=utf-8",
    # The first line of the bundle refers to this file.
    "swagger-ui-bundle.js.LICENSE.txt": "text/plain; charset=utf-8",
}
"""Served files and their media types."""


@router.get("/docs")
async def documentation(request: Request) -> Response:
    """Show all operations, interactive."""
    root = request.scope.get("root_path", "").rstrip("/")
    swagger = get_swagger_ui_html(
        openapi_url=f"{root}/openapi.json",
        title="Gamut boundary service",
        swagger_js_url=f"{root}/docs/{VERSION}/swagger-ui-bundle.js",
        swagger_css_url=f"{root}/docs/{VERSION}/swagger-ui.css",
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
        "style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
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
    if version != VERSION or name not in MEDIA_TYPES:
        detail = "The documentation has no such file."
        raise ProblemError(Problem("not-found", detail, remedy="The documentation is at /docs."))
    path = f"swagger-ui/{name}"
    return await asyncio.to_thread(static_file, request.headers, path, MEDIA_TYPES[name])
