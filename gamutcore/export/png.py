"""PNG files (ISO/IEC 15948) of arrays, without a picture library."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

__all__ = ["png"]

KINDS = {3: 2, 4: 6}
"""Colour types by the number of channels (11.2.2): truecolour, and truecolour with alpha."""

SRGB = b"\0"
"""Content of the chunk sRGB: perceptual intent (11.3.2.5)."""


def png(pixels: NDArray[np.uint8], level: int = 9, texts: Mapping[str, str] | None = None) -> bytes:
    """Return an image as PNG.

    Parameters
    ----------
    pixels : (rows, columns, 3 or 4) uint8
        sRGB from the top, with alpha if there are four channels.
    level : int, optional
        Of the compression, 0 to 9.
    texts : mapping, optional
        Textual data by keywords of at most 79 Latin characters (11.3.3).

    Returns
    -------
    bytes
    """
    rows, columns, channels = pixels.shape
    lines = np.zeros((rows, channels * columns + 1), np.uint8)  # each with the filter type 0
    lines[:, 1:] = pixels.reshape(rows, -1)
    header = struct.pack(">2I5B", columns, rows, 8, KINDS[channels], 0, 0, 0)
    content = zlib.compress(lines.tobytes(), level)
    entries = [(b"iTXt", _text(keyword, text)) for keyword, text in (texts or {}).items()]
    chunks = ((b"IHDR", header), (b"sRGB", SRGB), *entries, (b"IDAT", content), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    )


def _text(keyword: str, text: str) -> bytes:
    """Return the content of a chunk iTXt without compression and language (11.3.3.4)."""
    return keyword.encode("latin-1") + bytes(5) + text.encode()
