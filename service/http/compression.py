"""Content codings (RFC 9110, 8.4): which one a client likes best, and content in it.

zstd (RFC 8878) and gzip (RFC 1952), in this order. Compressed content is another representation: it
has its own entity tag, and whatever may be compressed varies by ``Accept-Encoding``. What was
measured, and what is not compressed, is in ``docs/decisions/compression.md``.
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

__all__ = ["CODINGS", "IDENTITY", "SMALLEST", "compress_response", "compressed", "preferred_coding"]

IDENTITY = ""
"""Stands for content as it is."""

CODINGS = ("zstd", "gzip")
"""What there is, the service's own preference first: as small as gzip in a fifth of the time."""

SMALLEST = 1024
"""Bytes below which content is not compressed: it fits into one packet either way."""

_GZIP_LEVEL = 1
"""Half as slow as level 6 or better, for meshes that become 0.02 of their size larger."""

_ZSTD_LEVEL = 3
"""The format's usual one; its window of 2 MB is within what RFC 9659 lets clients rely on."""


@lru_cache(maxsize=256)
def preferred_coding(accept_encoding: bytes) -> str:
    """Return the coding that a client likes best.

    Parameters
    ----------
    accept_encoding : bytes
        The value of ``Accept-Encoding``; empty if there is none.

    Returns
    -------
    str
        One of `CODINGS`, or `IDENTITY`.
    """
    asked = qualities(accept_encoding.decode("latin-1"))
    # A client that does not mention it can read it, but would rather have what it mentions.
    best, most = IDENTITY, asked.get("identity", 0.0)
    for coding in CODINGS:
        quality = asked.get(coding, asked.get("*", 0.0))
        if quality > 0.0 and (quality > most or (best == IDENTITY and quality == most)):
            best, most = coding, quality
    return best


def compressed(content: bytes, coding: str) -> bytes:
    """Return content in a coding, the same bytes for the same content.

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
    """Let a response be in the coding that its client likes best; the same response, changed.

    Parameters
    ----------
    response : Response
        Complete, without an entity tag.
    accept_encoding : list of str
        The values of ``Accept-Encoding``.
    """
    response.headers.add_vary_header("Accept-Encoding")
    content = bytes(response.body)
    coding = preferred_coding(",".join(accept_encoding).encode("latin-1"))
    if coding != IDENTITY and len(content) >= SMALLEST:
        response.body = compressed(content, coding)
        response.headers["Content-Encoding"] = coding
        response.headers["Content-Length"] = str(len(response.body))
    return response
