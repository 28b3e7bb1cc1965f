"""Routes of pages with scripts: the viewer and Swagger UI, and their files in the package.

The viewer shows, compares and builds gamuts. Its files are built from ``web/viewer`` into
``gamutcore/export/viewer`` (``make viewer``). Nothing is loaded from another origin, and the
content security policies enforce that. The addresses of files contain a digest or a version, so
they are cached for ever. See ``docs/decisions/viewer.md`` and the README of
``service/static/swagger-ui``.
"""

import asyncio
import base64
import functools
import gzip
import hashlib
import json
import math
import re
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from pathlib import Path as FilePath
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import HTMLResponse, Response

from gamutcore.export.viewer_page import EXAMPLE_FILES, VIEWER_FILES
from service.http.representations import (
    IDENTITY,
    IMMUTABLE,
    OCTET_STREAM,
    compress,
    compress_response,
    conditional,
    entity_tag,
    matches,
    preferred_coding,
    preferred_media_type,
)
from service.problems.problem import JsonResponse, Problem, ProblemError
from service.routes.names import NamedRecord, gamut_document
from service.routes.pages import SECURITY_HEADERS, definitions, status

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
    # Ours: darker colours.
    "contrast.css": "text/css; charset=utf-8",
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

EXAMPLE_MEDIA_TYPES = {
    ".gamut": OCTET_STREAM,
    ".jpg": "image/jpeg",
    ".json": "application/json",
    ".ti3": "text/plain; charset=utf-8",
    ".webp": "image/webp",
    "": "text/plain; charset=utf-8",
}
"""Media types of the built-in examples by suffix."""

_EXAMPLES = {path.name.removesuffix(".gz"): path for path in EXAMPLE_FILES.iterdir()}
"""Files of the examples by the names under which they are served."""

_SWAGGER_FILES = FilePath(str(files("service"))) / "static" / "swagger-ui"

_NOWHERE_ELSE = "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"

_VIEWER_POLICY = (
    "default-src 'none'; script-src 'self'; worker-src 'self'; style-src 'self'; "
    # The empty icon is a data: image, and rings are fetched with the API key.
    f"connect-src 'self'; img-src 'self' data: blob:; {_NOWHERE_ELSE}"
)

_STILL_PLACE = "<!-- the still picture -->\n"
"""The place in the page's file where the service puts what is shown without the script."""

_STILL_PICTURE = "size=640&background=transparent"
"""Parameters of the picture: the height of the view on most screens, and any colour behind it."""


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
    text = bytes(swagger.body).decode().replace("<html>", '<html lang="en">')
    # The version is that of the other files. Ours changes without it, so its address has a digest.
    digest = hashlib.sha256((_SWAGGER_FILES / "contrast.css").read_bytes()).hexdigest()[:16]
    contrast = f"{root}/docs/{SWAGGER_VERSION}/contrast.css?{digest}"
    own = f'<link rel="stylesheet" href="{contrast}">'
    text = text.replace("</head>", f"{own}\n    </head>")
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
    answer = HTMLResponse(text, headers=headers)
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


@router.get("/view/{digest}/examples/{name}")
async def example_file(
    request: Request, digest: Annotated[str, Path()], name: Annotated[str, Path()]
) -> Response:
    """Return a file of the built-in examples."""
    if digest != version() or name not in _EXAMPLES:
        detail = "The viewer has no such example."
        raise ProblemError(Problem("not-found", detail, remedy="The viewer is at /view."))
    media_type = EXAMPLE_MEDIA_TYPES[FilePath(name).suffix]
    return await asyncio.to_thread(_file_response, request, _EXAMPLES[name], media_type)


def prefers_page(request: Request) -> bool:
    """Return whether a client prefers a page to JSON, as browsers do."""
    accept = ",".join(request.headers.getlist("accept"))
    return preferred_media_type(accept, ("application/json", "text/html")) == "text/html"


def viewer_page(request: Request, gamut: NamedRecord | None = None) -> Response:
    """Return the page of the viewer. Its script takes the gamut from the address.

    Until the script has drawn, and without it, the page shows a picture of the gamut and its facts.
    """
    root = request.scope.get("root_path", "").rstrip("/")
    if gamut is None:
        document, title = _example(), "Gamut viewer"
        picture = shared = f"view/{version()}/examples/still.webp"
    else:
        document, title = gamut_document(gamut), f"{gamut.name} – gamut"
        shared = f"v1/gamuts/{gamut.id}/picture.png"
        picture = f"{shared}?{_STILL_PICTURE}"
    facts = _facts(document)
    head = _head(title, facts, f"{request.base_url}{shared}")
    still = _still(document, facts, f"{root}/{picture}")
    before, middle, after = _page(root)
    text = f"{before}{head}{middle}{still}{after}"
    headers = {
        **SECURITY_HEADERS,
        "Cache-Control": "no-cache",
        "Content-Security-Policy": _VIEWER_POLICY,
        "Vary": "Accept",
    }
    return conditional(HTMLResponse(text, headers=headers), request.headers)


@functools.cache
def version() -> str:
    """Return a digest of the viewer's files and examples."""
    paths = [*(VIEWER_FILES / name for name in MEDIA_TYPES), *sorted(_EXAMPLES.values())]
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()[:16]


@functools.cache
def _example() -> dict[str, Any]:
    """Return the description of the gamut that the page without a gamut begins with."""
    document: dict[str, Any] = json.loads(gzip.decompress(_EXAMPLES["press.json"].read_bytes()))
    return document


@functools.lru_cache(maxsize=8)
def _page(root: str) -> tuple[str, str, str]:
    """Return the page before the title, between title and still picture, and after it."""
    text = (VIEWER_FILES / "index.html").read_text("utf-8")
    root = escape(root)
    text = text.replace("{root}", root).replace("{files}", f"{root}/view/{version()}")
    before, rest = text.split("<title>Gamut viewer</title>\n")
    middle, after = rest.split(_STILL_PLACE)
    return before, middle, after


def _head(title: str, facts: Mapping[str, str], picture: str) -> str:
    """Return the title and what chats show of a link (The Open Graph protocol, ogp.me)."""
    properties = {
        "og:title": title,
        "og:description": " · ".join(f"{name}: {text}" for name, text in facts.items()),
        "og:image": picture,
        "og:type": "website",
    }
    lines = [
        f'<meta property="{name}" content="{escape(text)}">\n' for name, text in properties.items()
    ]
    return f"<title>{escape(title)}</title>\n{''.join(lines)}"


def _still(document: Mapping[str, Any], facts: Mapping[str, str], picture: str) -> str:
    """Return the figure that the script removes once it has drawn."""
    name = escape(document["name"])
    listed = definitions((term, escape(text)) for term, text in facts.items())
    return (
        f'    <figure id="static" data-gamut="{document["id"]}">\n'
        f'<img src="{escape(picture)}" alt="The gamut {name} as a solid in its own colours">\n'
        f"<figcaption><h2>{name}</h2>\n{listed}\n"
        "<noscript><p>This is a still picture. Allow scripts to turn the solid.</p></noscript>\n"
        '<p id="static-note" hidden>This is a still picture, because this browser has no WebGL 2, '
        "which draws the solid.</p></figcaption>\n</figure>\n"
    )


def _facts(document: Mapping[str, Any]) -> dict[str, str]:
    """Return what the still picture says about a gamut, as plain text."""
    options, provenance = document["options"], document["provenance"]
    space = options["space"]
    facts = {"Space": space}
    intent = provenance.get("intent")
    if intent is not None:
        facts["Intent"] = intent
    unit = "cubic ΔE*ab" if space == "CIELAB" else f"cubic units of {space}"
    facts["Volume"] = f"{_number(document['volume'], 6)} {unit}"
    volumes = document.get("volumes") or {}
    own = volumes.get(intent) or volumes.get("own")
    if own is not None:
        facts["Volume"] += f", {_number(own['times_srgb'], 3)} × sRGB"
    for name, axes in (("white_lab", "L*a*b*"), ("white", "XYZ")):
        white = provenance.get(name)
        if white is not None and "White" not in facts:
            facts["White"] = f"{axes} {' '.join(_number(value, 4) for value in white)}"
    facts["Full boundary"] = f"{document['counts']['triangles']:,} triangles"
    return facts


def _number(value: float, digits: int) -> str:
    """Return a number with so many significant digits at most, as people write it."""
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value)))) if value else 0
    text = f"{value:,.{decimals}f}"
    return (text.rstrip("0").rstrip(".") if "." in text else text).replace("-", "−")


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
    """Return a file in a coding with its entity tag. The cache holds 6 MB in total."""
    content = path.read_bytes()
    if path.suffix == ".gz":
        content = gzip.decompress(content)
    if coding != IDENTITY:
        content = compress(content, coding)
    return content, entity_tag(content)
