"""JPEG pictures: segments read here, pixels decoded by libjpeg-turbo through Pillow.

ITU-T T.81 and T.872 (JFIF, Adobe's marker and ICC profiles). Only what decoding needs is handed on,
with a marker of Adobe's that states the colour transform, so that nothing is guessed.
"""

from __future__ import annotations

import io
import re
import struct
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL.JpegImagePlugin import JpegImageFile

from gamutcore.characterisation.pictures.bounds import (
    BAND_BYTES,
    checked_held,
    checked_size,
    malformed,
)
from gamutcore.characterisation.pictures.encoding import ADOBE_RGB, SRGB, Encoding
from gamutcore.characterisation.pictures.raster import MAX_PROFILE_BYTES, Raster
from gamutcore.characterisation.pictures.tiff_tags import tiff_directory
from gamutcore.errors import MalformedFileError, UnsupportedPictureError

__all__ = ["JPEG_SIGNATURE", "MOST_UNPACKED", "Frame", "jpeg_frame", "jpeg_raster", "jpeg_rows"]

JPEG_SIGNATURE = b"\xff\xd8\xff"

MOST_UNPACKED = 512 * 3
"""Bytes that a byte makes at most: a code of one bit at least stands for a block of 8 × 8 pixels in
the first scan of a component, and of three components two can have a sixteenth of the size."""

_MAX_SCANS = 100
"""Scans at most; progressive pictures have about ten, and each goes over all pixels."""

_MAX_SCANNED = 1_200_000_000
"""Pixels of all scans together at most: ten scans of the largest picture."""

_PROGRESSIVE = 0xC2
_FRAMES = {0xC0, 0xC1, _PROGRESSIVE}
"""Start of frame of what is decoded: baseline, extended and progressive, with Huffman codes."""

_NEXT_MARKER = re.compile(rb"\xff+[^\x00\xff\xd0-\xd7]")
_MODELS = {1: "gray", 3: "RGB", 4: "CMYK"}


@dataclass(eq=False)
class Frame:
    """What a JPEG stream says of itself.

    Parameters
    ----------
    width, height : int
    components : tuple of int
        Their identifiers.
    kept : list of bytes
        What decoding needs, in order; the frame's header is `header` of it.
    adobe : int or None
        The colour transform that Adobe's marker states.
    jfif : bool
    profile : dict
        Parts of the embedded profile by number.
    parts : int
        How many there should be.
    exif : bytes
        A TIFF file of metadata.
    coefficients : float
        Numbers that stand for a pixel, of all components together: 3, or 1.5 with 4:2:0.
    at_once : bool
        Whether all of them are needed before the first row can be decoded.
    """

    width: int = 0
    height: int = 0
    components: tuple[int, ...] = ()
    kept: list[bytes] = field(default_factory=list)
    adobe: int | None = None
    jfif: bool = False
    profile: dict[int, bytes] = field(default_factory=dict)
    parts: int = 0
    exif: bytes = b""
    coefficients: float = 0.0
    at_once: bool = False

    @property
    def held(self) -> int:
        """Bytes of the decoded pixels, which Pillow has in one or four bytes each."""
        return self.width * self.height * (1 if len(self.components) == 1 else 4)

    @property
    def decoded(self) -> float:
        """Bytes that decoding takes: the pixels, and coefficients of two bytes that come first."""
        return self.held + self.width * self.height * 2 * self.coefficients * self.at_once

    @property
    def transform(self) -> int:
        """The transform from the stored components: 0 none, 1 YCbCr, 2 YCCK."""
        if self.adobe is not None:
            return self.adobe
        if len(self.components) == 3:
            return 0 if self.components == (82, 71, 66) and not self.jfif else 1
        return 0


def jpeg_raster(data: bytes) -> Raster:
    """Return the pixels of a JPEG file.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    Raster

    Raises
    ------
    MalformedFileError
        A segment is broken, missing or ends early; ``where`` has its first byte.
    PictureSizeError
        It has more pixels than are decoded.
    UnsupportedPictureError
        It is lossless, arithmetically coded, or of other than 8 bits.
    """
    frame = jpeg_frame(data)
    checked_held(frame.held, frame.decoded, len(data))
    said = []
    if len(frame.components) == 4 and frame.adobe is None:
        said.append("CMYK without Adobe's marker: full ink is taken to be 0, as Adobe writes it.")
    profile = b""
    if frame.profile:
        if sorted(frame.profile) != list(range(1, frame.parts + 1)):
            raise malformed(
                f"Of {frame.parts} parts of the embedded profile, {len(frame.profile)} are there.",
                {"segment": "APP2"},
            )
        profile = b"".join(frame.profile[part] for part in sorted(frame.profile))
    return Raster(
        "jpeg",
        _MODELS[len(frame.components)],
        frame.width,
        frame.height,
        jpeg_rows(frame, frame.transform, max(1, BAND_BYTES // frame.width)),
        np.dtype(np.uint8),
        len(data),
        full=255,
        bits=8,
        profile=profile,
        encoding=_exif_encoding(frame.exif) if len(frame.components) == 3 else None,
        said=said,
    )


def jpeg_frame(data: bytes) -> Frame:
    """Return what a JPEG stream says of itself, checked.

    Parameters
    ----------
    data : bytes
        From its first marker, SOI.

    Returns
    -------
    Frame

    Raises
    ------
    MalformedFileError, PictureSizeError, UnsupportedPictureError
        As `jpeg_raster`.
    """
    frame, place, scans = Frame(), 2, 0
    while True:
        found = _NEXT_MARKER.search(data, place)
        if found is None:
            if not scans:
                raise malformed("The file ends before the picture's data.", {"byte": place})
            # Without an end marker: what is missing is found in decoding.
            frame.kept.append(data[place:])
            return frame
        if scans:
            frame.kept.append(data[place : found.start()])
        start, marker = found.end() - 2, data[found.end() - 1]
        place = found.end()
        if marker == 0xD9:
            if not scans:
                raise malformed("The file ends before the picture's data.", {"byte": start})
            frame.kept.append(b"\xff\xd9")
            return frame
        if marker in {0xD8, 0x01}:
            continue
        length = int.from_bytes(data[place : place + 2], "big")
        if length < 2 or place + length > len(data):
            raise malformed("The file ends within a segment.", {"byte": start})
        content = data[place + 2 : place + length]
        _read_segment(frame, marker, content, start, len(data))
        if marker < 0xE0 or (marker > 0xEF and marker != 0xFE):
            frame.kept.append(data[start : place + length])
        place += length
        if marker == 0xDA:
            scans += 1
            if not frame.components:
                raise malformed("The picture's data comes before its header.", {"byte": start})
            frame.at_once |= content[:1] != bytes([len(frame.components)])
            if scans > _MAX_SCANS or scans * frame.width * frame.height > _MAX_SCANNED:
                raise malformed(f"The picture has {scans} scans or more.", {"byte": start})


def _read_segment(frame: Frame, marker: int, content: bytes, start: int, size: int) -> None:
    if 0xC0 <= marker <= 0xCF and marker not in {0xC4, 0xC8, 0xCC}:
        _read_frame_header(frame, marker, content, start, size)
    elif marker == 0xE0 and content.startswith(b"JFIF\0"):
        frame.jfif = True
    elif marker == 0xE1 and content.startswith(b"Exif\0\0") and not frame.exif:
        frame.exif = content[6:]
    elif marker == 0xE2 and content.startswith(b"ICC_PROFILE\0") and len(content) >= 14:
        # A count and a number in each (ICC.1:2022, annex B.4).
        number, parts = content[12], content[13]
        if number in frame.profile or (frame.parts and parts != frame.parts):
            raise malformed("Parts of the embedded profile contradict each other.", {"byte": start})
        frame.parts, frame.profile[number] = parts, content[14:]
        if sum(map(len, frame.profile.values())) > MAX_PROFILE_BYTES:
            raise malformed("The embedded profile is too large.", {"byte": start})
    elif marker == 0xEE and content.startswith(b"Adobe") and len(content) >= 12:
        frame.adobe = content[11]


def _read_frame_header(frame: Frame, marker: int, content: bytes, start: int, size: int) -> None:
    where = {"byte": start}
    if marker not in _FRAMES:
        raise UnsupportedPictureError(
            f"The picture is compressed by process {marker - 0xC0} of JPEG.",
            where={**where},
            remedy="Baseline, extended and progressive JPEG with Huffman codes are read.",
        )
    if frame.components:
        raise malformed("The picture has two headers.", {**where})
    if len(content) < 6 or len(content) != 6 + 3 * content[5]:
        raise malformed("The picture's header has a wrong length.", {**where})
    depth, height, width, count = struct.unpack_from(">BHHB", content)
    if depth != 8 or count not in _MODELS:
        raise UnsupportedPictureError(
            f"The picture has {count} components of {depth} bits.",
            where={**where},
            remedy="JPEG of 1, 3 or 4 components of 8 bits is read.",
        )
    checked_size(width, height, count, size, MOST_UNPACKED)
    frame.width, frame.height = width, height
    frame.components = tuple(content[6::3])
    factors = [(max(1, byte >> 4), max(1, byte & 15)) for byte in content[7::3]]
    most = max(across for across, _ in factors) * max(down for _, down in factors)
    frame.coefficients = sum(across * down for across, down in factors) / most
    frame.at_once = marker == _PROGRESSIVE


def jpeg_rows(
    frame: Frame, transform: int, step: int, tables: bytes = b""
) -> Iterator[tuple[int, npt.NDArray[np.uint8]]]:
    """Yield the decoded pixels of a stream, some rows at a time, with the first row's number.

    Parameters
    ----------
    frame : Frame
    transform : int
        From the stored components: 0 none, 1 YCbCr to RGB, 2 YCCK to CMYK.
    step : int
        Rows at a time.
    tables : bytes, optional
        Segments that the stream leaves out, as TIFF files have them.

    Yields
    ------
    int, (step, width, k) uint8
        Gray, RGB, or CMYK with full ink at 255 where it is stored as 0; the last ones may have
        fewer rows.

    Raises
    ------
    MalformedFileError
        The data is broken or ends early.
    """
    adobe = b"\xff\xee\0\x0eAdobe\0\x64\0\0\0\0" + bytes([min(transform, 2)])
    stream = io.BytesIO(b"".join([b"\xff\xd8", adobe, tables, *frame.kept]))
    frame.kept = []
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            decoded: Any = JpegImageFile(stream)
            decoded.load()
    except (OSError, SyntaxError, ValueError, TypeError, LookupError, struct.error) as error:
        raise malformed("The picture's data is broken or ends early.", {"field": "data"}) from error
    for top in range(0, frame.height, step):
        rows = min(step, frame.height - top)
        band = np.asarray(decoded.crop((0, top, frame.width, top + rows)))
        yield top, band.reshape(rows, frame.width, -1)


def _exif_encoding(exif: bytes) -> Encoding | None:
    """Return what Exif says: sRGB, or the optional colour space of DCF, Adobe RGB."""
    if not exif:
        return None
    try:
        first, _ = tiff_directory(exif, 0)
        sub = first.numbers(34665)  # Exif IFD
        camera, _ = tiff_directory(exif, int(sub[0])) if sub else (first, 0)
        space = camera.numbers(40961)  # ColorSpace (Exif 3.0, 4.6.6.2)
        if space and space[0] == 1:
            return SRGB
        linked = camera.numbers(40965)  # Interoperability IFD
        if linked:
            interoperability, _ = tiff_directory(exif, int(linked[0]))
            if interoperability.content(1)[:3] == b"R03":  # DCF 2.0, optional file
                return ADOBE_RGB
    except MalformedFileError:
        pass  # Metadata that is broken says nothing, as if it were not there.
    return None
