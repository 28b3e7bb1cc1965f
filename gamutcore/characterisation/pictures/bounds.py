"""How much a picture may unpack to, by its bytes, and the errors of what breaks its format.

Strangers send files of few bytes that claim many pixels. All of this is told from headers, before a
decoder is started, and but for blank pictures of moderate size it is a matter of proportion.
"""

from __future__ import annotations

import math

from gamutcore.errors import MalformedFileError, PictureSizeError, Where
from gamutcore.limits import current_limits

__all__ = [
    "BAND_BYTES",
    "BYTES_PER_VALUE",
    "FREELY_DECODED",
    "FREELY_DISTINCT",
    "FREELY_EVALUATED",
    "FREELY_HELD",
    "FREELY_SORTED",
    "FREELY_UNPACKED",
    "MAX_DECODED_BYTES",
    "MAX_RATIO",
    "SORTED_RATIO",
    "checked_held",
    "checked_size",
    "malformed",
]

MAX_DECODED_BYTES = 2**29
"""Bytes of a picture's pixels at most, unpacked. A picture of 24 megapixels in CMYK or RGBA has
192 MB in 16 bits and 384 MB in 32-bit floats."""

FREELY_UNPACKED = 2**27
"""Bytes that any file may unpack to: a blank picture of 24 megapixels has 72 MB."""

FREELY_HELD = 96 * 2**20
"""Bytes of pixels that a decoder may hold for any file while their colours are sorted out. A worker
has 320 MiB in use before it begins, and is to stay below 512 MiB with files of few bytes."""

FREELY_DECODED = 164 * 2**20
"""Bytes that any file may need before the first row is there, with the pixels: a progressive JPEG
of 24 megapixels in 4:2:0 has 168 MB."""

MAX_RATIO = 100
"""Beyond what is free for any file, what a byte may unpack to at most.
Photographs have 3 to 40."""

FREELY_SORTED = 2**26
"""Bytes of the numbers of all pixels that are sorted for any file: one pixel of every 8-bit RGB."""

SORTED_RATIO = 20
"""How many more are sorted for each byte of the file: what has 16 bits and no two pixels alike
takes 6. Of other files distinct values are gathered while it is read."""

FREELY_DISTINCT = 2**21
"""Distinct values of any file that are gathered; more of them need a byte each. Photographs have 4
(JPEG) to 14 (PNG) bytes for one."""

FREELY_EVALUATED = 2**19
"""Distinct values of any file that are evaluated; each takes 240 bytes until the boundary is there.
More of them need `BYTES_PER_VALUE` in the file."""

BYTES_PER_VALUE = 2
"""Beyond `FREELY_EVALUATED`, how many bytes a file has for a value that is evaluated."""

BAND_BYTES = 2**22
"""Bytes of rows that are decoded at a time, where that can be chosen."""


def malformed(message: str, where: Where | None = None, remedy: str = "") -> MalformedFileError:
    """Return the error of a picture that breaks its format.

    Parameters
    ----------
    message : str
    where : dict, optional
    remedy : str, optional

    Returns
    -------
    MalformedFileError
    """
    return MalformedFileError(
        message, where=where, remedy=remedy or "Send the whole picture, or save it anew."
    )


def checked_size(
    width: int, height: int, pixel_bytes: float, packed: int, most_unpacked: float
) -> None:
    """Refuse a picture that is empty, too large, or larger than its bytes can hold.

    Parameters
    ----------
    width, height : int
        In pixels, as the file states them.
    pixel_bytes : float
        Bytes of a pixel, unpacked.
    packed : int
        Bytes that the pixels have in the file.
    most_unpacked : float
        Bytes that the compression can make of one byte at most.

    Raises
    ------
    MalformedFileError
        It has no pixels, or they cannot be in the file: it ends early, or is made to exhaust
        memory.
    PictureSizeError
        It has more pixels than `current_limits` allow, or `MAX_DECODED_BYTES` bytes, or is packed
        as no large photograph is.
    """
    if width <= 0 or height <= 0:
        raise malformed(f"The picture has {width} × {height} pixels.", {"field": "size"})
    size = width * height * pixel_bytes
    most = current_limits().pixels
    if width * height > most or size > MAX_DECODED_BYTES:
        raise PictureSizeError(
            f"The picture has {width} × {height} pixels, {size / 1e6:.0f} MB unpacked.",
            where={"field": "size"},
            remedy=f"At most {most / 1e6:g} million pixels and "
            f"{MAX_DECODED_BYTES / 1e6:.0f} MB are unpacked; send a smaller copy.",
        )
    if size > packed * most_unpacked + 65536:
        raise malformed(
            f"The picture claims {width} × {height} pixels, which its {packed} bytes of data "
            "cannot hold.",
            {"field": "size"},
        )
    if math.isfinite(most_unpacked) and size > max(FREELY_UNPACKED, packed * MAX_RATIO):
        raise PictureSizeError(
            f"The picture unpacks from {packed} bytes to {size / 1e6:.0f} MB.",
            where={"field": "size"},
            remedy=f"Beyond {FREELY_UNPACKED / 1e6:.0f} MB, at most {MAX_RATIO} bytes are unpacked "
            "of one; send a smaller copy.",
        )


def checked_held(held: float, decoded: float, packed: int, ratio: int = MAX_RATIO) -> None:
    """Refuse what has to be in memory at once to be decoded, and has few bytes in the file.

    Parameters
    ----------
    held : float
        Bytes of pixels that the decoder holds until they are used.
    decoded : float
        Bytes that it needs before, with the pixels.
    packed : int
        Bytes that they have in the file.
    ratio : int, optional
        Beyond `FREELY_HELD` and `FREELY_DECODED`, how many are needed for one at most.

    Raises
    ------
    PictureSizeError
        They are more.
    """
    for size, free in ((held, FREELY_HELD), (decoded, FREELY_DECODED)):
        if size > max(free, packed * ratio):
            raise PictureSizeError(
                f"Decoding {packed} bytes of the picture takes {size / 1e6:.0f} MB of memory.",
                where={"field": "size"},
                remedy=f"Beyond {free / 1e6:.0f} MB, at most {ratio} bytes are taken for one; send "
                "a smaller copy, a JPEG that is not progressive, or a TIFF of more strips.",
            )
