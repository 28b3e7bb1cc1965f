"""Content codings (RFC 9110, section 8.4): negotiation and compression.

The service offers zstd (RFC 8878) and gzip (RFC 1952). Compressed content is a representation of
its own: it has its own entity tag, and the response varies by ``Accept-Encoding``. Measurements are
in ``docs/decisions/compression.md``.
"""

from __future__ import annotations

import gzip
import sys
from functools import lru_cache
from typing import TYPE_CHECKING

from service.http.negotiation import qualities

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

if TYPE_CHECKING:
    from starlette.responses import Response

__all__ = ["CODINGS", "IDENTITY", "SMALLEST", "compress", "compress_response", "preferred_coding"]

IDENTITY = ""
"""No content coding."""

CODINGS = ("zstd", "gzip")
"""Codings in the service's order of preference. zstd is as small as gzip in a fifth of the time."""

SMALLEST = 1024
"""Bytes below which content is not compressed, because it fits into one packet anyway."""

_GZIP_LEVEL = 1
"""Twice as fast as level 6. Meshes grow by 2 %."""

_ZSTD_LEVEL = 3
"""The usual level. Its window of 2 MB is within the limit of RFC 9659."""


@lru_cache(maxsize=256)
def preferred_coding(accept_encoding: bytes) -> str:
    """Return the coding that a client prefers.

    Parameters
    ----------
    accept_encoding : bytes
        The value of ``Accept-Encoding``; empty if the field is missing.

    Returns
    -------
    str
        One of `CODINGS`, or `IDENTITY`.

    Examples
    --------
    >>> preferred_coding(b"gzip, br")
    'gzip'
    """
    asked = qualities(accept_encoding.decode("latin-1"))
    # Identity is acceptable unless it is excluded, but ranks below every coding that is named.
    best, most = IDENTITY, asked.get("identity", 0.0)
    for coding in CODINGS:
        quality = asked.get(coding, asked.get("*", 0.0))
        if quality > 0.0 and (quality > most or (best == IDENTITY and quality == most)):
            best, most = coding, quality
    return best


def compress(content: bytes, coding: str) -> bytes:
    """Return content in a coding. The same content always gives the same bytes.

    Parameters
    ----------
    content : bytes
    coding : str
        One of `CODINGS`.
    """
    if coding == "zstd":
        return zstd.compress(content, level=_ZSTD_LEVEL)
    return gzip.compress(content, compresslevel=_GZIP_LEVEL, mtime=0)


def compress_response(response: Response, accept_encoding: list[str]) -> Response:
    """Compress a response in the coding that the client prefers, and return the response.

    Parameters
    ----------
    response : Response
        Complete, without an entity tag. Changed in place.
    accept_encoding : list of str
        The values of ``Accept-Encoding``.
    """
    response.headers.add_vary_header("Accept-Encoding")
    content = bytes(response.body)
    coding = preferred_coding(",".join(accept_encoding).encode("latin-1"))
    if coding != IDENTITY and len(content) >= SMALLEST:
        response.body = compress(content, coding)
        response.headers["Content-Encoding"] = coding
        response.headers["Content-Length"] = str(len(response.body))
    return response
