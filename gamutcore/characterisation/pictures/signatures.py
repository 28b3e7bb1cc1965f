"""First bytes of the picture formats."""

from __future__ import annotations

__all__ = ["picture_format"]

_SIGNATURES = {
    "png": (b"\x89PNG\r\n\x1a\n",),
    "jpeg": (b"\xff\xd8\xff",),
    "tiff": (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    "exr": (b"v/1\x01",),
    "hdr": (b"#?RADIANCE\n", b"#?RGBE\n"),
    "jpeg-xl": (b"\xff\x0a", b"\0\0\0\x0cJXL \r\n\x87\n"),
    "jpeg-2000": (b"\0\0\0\x0cjP  \r\n\x87\n", b"\xff\x4f\xff\x51"),
    "gif": (b"GIF87a", b"GIF89a"),
    "dpx": (b"SDPX", b"XPDS"),
}

_BMP_HEADER_SIZES = frozenset({12, 40, 52, 56, 64, 108, 124})
"""Sizes of the header that follows the 14 bytes of BMP's file header."""


def picture_format(data: bytes) -> str | None:
    r"""Return the name of a picture's format.

    Returns
    -------
    str or None
        None for other data.

    Examples
    --------
    >>> picture_format(b"\xff\xd8\xff\xe0")
    'jpeg'
    """
    if data.startswith(b"RIFF") and data[8:12] == b"WEBP":
        return "webp"
    if data.startswith(b"BM") and int.from_bytes(data[14:18], "little") in _BMP_HEADER_SIZES:
        return "bmp"  # two letters alone may be the start of a text
    return next((name for name, starts in _SIGNATURES.items() if data.startswith(starts)), None)
