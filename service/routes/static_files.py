"""Answers with files of the package, whose addresses change with their content."""

from __future__ import annotations

import functools
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from fastapi.responses import Response

from service.http.compression import IDENTITY, compress, preferred_coding
from service.http.conditional import IMMUTABLE, entity_tag, matches

if TYPE_CHECKING:
    from starlette.datastructures import Headers

__all__ = ["static_file"]

_FOLDER = Path(str(files("service"))) / "static"


def static_file(request: Headers, name: str, media_type: str, folder: Path = _FOLDER) -> Response:
    """Return a file, cached for ever. Compresses the file, so this may take a while.

    Parameters
    ----------
    request : Headers
        Header fields of the request.
    name : str
        Path of an existing file below `folder`.
    media_type : str
    folder : Path, optional
        By default ``service/static``.
    """
    accepted = ",".join(request.getlist("accept-encoding"))
    coding = preferred_coding(accepted.encode("latin-1"))
    content, etag = _content(folder / name, coding)
    headers = {"ETag": etag, "Cache-Control": IMMUTABLE, "Vary": "Accept-Encoding"}
    known = request.getlist("if-none-match")
    if known and matches(",".join(known), etag):
        return Response(status_code=304, headers=headers)
    headers["X-Content-Type-Options"] = "nosniff"
    if coding != IDENTITY:
        headers["Content-Encoding"] = coding
    return Response(content, media_type=media_type, headers=headers)


@functools.cache
def _content(path: Path, coding: str) -> tuple[bytes, str]:
    """Return a file in a coding with its entity tag. The cache holds 5 MB in total."""
    content = path.read_bytes()
    if coding != IDENTITY:
        content = compress(content, coding)
    return content, entity_tag(content)
