"""Colour metadata of picture files: code points, chromaticities, gamma, Exif, names of spaces.

OpenImageIO reports most metadata as attributes. PNG's chunks sRGB, gAMA and cHRM, and the
primaries of Radiance HDR, are read here, because OpenImageIO does not report them.
"""

from __future__ import annotations

import io
import re
import struct
import warnings
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from gamutcore.characterisation.pictures.encoding import (
    ADOBE_RGB,
    SRGB,
    Encoding,
    chromaticity_encoding,
    code_point_encoding,
    named_encoding,
)
from gamutcore.errors import MalformedProfileError, UnsupportedPictureError

__all__ = [
    "MAX_PROFILE_BYTES",
    "bmp_profile",
    "declared_encoding",
    "embedded_profile",
    "exif_colour_space",
    "is_narrow_range",
    "refuse_film_densities",
    "text_attribute",
]

MAX_PROFILE_BYTES = 2**25
"""Maximum size of an embedded profile. The largest press profiles have about 10 MB."""

_RADIANCE_PRIMARIES = re.compile(rb"^PRIMARIES=((?:[ \t]*[-+\d.eE]+){8})[ \t]*$", re.MULTILINE)
_DPX_SPACES = {"Linear": "lin_rec709_scene", "ITU-R 709-4": "g24_rec709_display"}
_EXIF_UNCALIBRATED = 0xFFFF
_BMP_V5_SIZE = 124
_DPX_LOGARITHMIC = {"Logarithmic", "Printing density", "ADX"}


def declared_encoding(
    spec: Any,  # noqa: ANN401 (an ImageSpec)
    data: bytes,
    file_format: str,
    *,
    has_profile: bool = False,
) -> tuple[Encoding | None, list[str]]:
    """Return the encoding that a picture declares, or None, and warnings.

    Only code points take precedence over an ICC profile (W3C PNG, third edition, 4.3).
    """
    said: list[str] = []
    code_points = spec.getattribute("CICP")
    if code_points is not None:
        primaries, transfer, matrix, _ = (int(number) for number in code_points)
        encoding = None if matrix else code_point_encoding(primaries, transfer)
        if encoding is not None:
            return encoding, said
        said.append(f"The code points {primaries}, {transfer}, {matrix} are not supported.")
    if has_profile:
        return None, said
    if file_format == "png":
        encoding, more = _png_encoding(data)
    elif file_format == "exr":
        encoding, more = _exr_encoding(spec)
    elif file_format == "hdr":
        encoding, more = _hdr_encoding(data)
    elif file_format == "dpx":
        name = _DPX_SPACES.get(text_attribute(spec, "dpx:Transfer"), "")
        encoding, more = named_encoding(name), []
    else:
        encoding, more = _exif_encoding(spec, data), []
    return encoding, said + more


def text_attribute(spec: Any, name: str) -> str:  # noqa: ANN401 (an ImageSpec)
    """Return a text from a picture's header; empty if it is missing or not UTF-8."""
    try:
        text: str = spec.get_string_attribute(name)
    except UnicodeDecodeError:
        return ""
    return text


def is_narrow_range(spec: Any, file_format: str) -> bool:  # noqa: ANN401 (an ImageSpec)
    """Return whether code points state that integers use the narrow range, 16 to 235 of 8 bits."""
    code_points = spec.getattribute("CICP")
    if file_format != "png" or code_points is None or code_points[3]:
        return False
    primaries, transfer, matrix, _ = (int(number) for number in code_points)
    return not matrix and code_point_encoding(primaries, transfer) is not None


def refuse_film_densities(spec: Any) -> None:  # noqa: ANN401 (an ImageSpec)
    """Refuse DPX with logarithmic film densities, which are not light."""
    transfer = text_attribute(spec, "dpx:Transfer")
    if transfer in _DPX_LOGARITHMIC:
        raise UnsupportedPictureError(
            f"The DPX picture has values of the kind {transfer}.",
            where={"field": "transfer"},
            remedy="Convert it to linear light or to a display encoding.",
        )


def _png_encoding(data: bytes) -> tuple[Encoding | None, list[str]]:
    """Return the encoding of the chunks sRGB, gAMA and cHRM (W3C PNG, third edition, 11.3.2)."""
    chunks = dict(_png_chunks(data))
    if b"sRGB" in chunks:
        return SRGB, []
    gamma = chromaticities = None
    if len(chunks.get(b"gAMA", b"")) == 4:
        stated = int.from_bytes(chunks[b"gAMA"], "big")
        gamma = 100_000 / stated if stated else 0.0
    if len(chunks.get(b"cHRM", b"")) == 32:
        chromaticities = tuple(value / 100_000 for value in struct.unpack(">8I", chunks[b"cHRM"]))
    if gamma is None and chromaticities is None:
        return None, []
    if chromaticities is not None:  # white first; `chromaticity_encoding` has white last
        chromaticities = (*chromaticities[2:], *chromaticities[:2])
    encoding = chromaticity_encoding(chromaticities, gamma=gamma)
    if encoding is None:
        return None, ["The chunks gAMA and cHRM state impossible values and are not used."]
    return encoding, []


def _png_chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield the chunks before the pixels."""
    place = 8
    while place + 8 <= len(data):
        size, name = struct.unpack_from(">I4s", data, place)
        if name == b"IDAT":
            return
        yield name, data[place + 8 : place + 8 + size]
        place += size + 12


def _exr_encoding(spec: Any) -> tuple[Encoding | None, list[str]]:  # noqa: ANN401
    name = text_attribute(spec, "oiio:ColorSpace")
    if name:
        encoding = named_encoding(name)
        if encoding is not None:
            return encoding, []
        return None, [f"The colour space {name[:60]} is not supported and was not used."]
    stated = spec.getattribute("chromaticities")
    if stated is None:
        return None, []
    encoding = chromaticity_encoding(tuple(float(value) for value in stated), linear=True)
    if encoding is None:
        return None, ["The attribute chromaticities states impossible values and is not used."]
    return encoding, []


def _hdr_encoding(data: bytes) -> tuple[Encoding | None, list[str]]:
    found = _RADIANCE_PRIMARIES.search(data[:4096])
    if found is None:
        return None, []
    try:
        numbers = tuple(float(word) for word in found[1].split())
    except ValueError:
        numbers = ()
    encoding = chromaticity_encoding(numbers, linear=True) if len(numbers) == 8 else None
    if encoding is None:
        return None, ["The line PRIMARIES states impossible values and is not used."]
    return encoding, []


def _exif_encoding(spec: Any, data: bytes) -> Encoding | None:  # noqa: ANN401 (an ImageSpec)
    """Return sRGB, or the optional colour space of DCF 2.0, Adobe RGB, from Exif."""
    space = spec.get_int_attribute("Exif:ColorSpace")
    if space == 1 and spec.nchannels >= 3:
        return SRGB
    if space == _EXIF_UNCALIBRATED and spec.nchannels >= 3:
        from PIL import ExifTags, Image  # noqa: PLC0415  # 3 MB, and rarely needed

        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                exif = Image.open(io.BytesIO(data)).getexif()
                index = exif.get_ifd(ExifTags.IFD.Interop).get(1, "")
        except (OSError, SyntaxError, ValueError, TypeError, LookupError, struct.error):
            return None
        if str(index).startswith("R03"):
            return ADOBE_RGB
    return None


def exif_colour_space(exif: Any) -> int:  # noqa: ANN401 (a PIL.Image.Exif)
    """Return the number of Exif's tag ColorSpace; 0 without one."""
    from PIL import ExifTags  # noqa: PLC0415

    space = exif.get_ifd(ExifTags.IFD.Exif).get(ExifTags.Base.ColorSpace)
    return space if isinstance(space, int) else 0


def bmp_profile(data: bytes) -> bytes:
    """Return the embedded profile of a BMP file with a BITMAPV5HEADER; empty without one."""
    # offsets in the file: bV5Size 14, bV5CSType 70, bV5ProfileData 126, bV5ProfileSize 130
    if len(data) < 138 or data[14] != _BMP_V5_SIZE or data[70:74] not in {b"DEBM", b"KNIL"}:
        return b""
    start, size = struct.unpack_from("<II", data, 126)
    profile = data[14 + start : 14 + start + size]
    if data[70:74] == b"KNIL" or not 0 < size == len(profile) <= MAX_PROFILE_BYTES:
        raise _damaged_profile()
    return profile


def _damaged_profile() -> MalformedProfileError:
    return MalformedProfileError(
        "The embedded profile is damaged, incomplete, too large or in another file.",
        where={"field": "profile"},
        remedy="Embed the profile again, or save the picture without a profile.",
    )


def embedded_profile(spec: Any, data: bytes, file_format: str) -> bytes:  # noqa: ANN401
    """Return the embedded ICC profile of a picture; empty without one.

    A damaged profile of a PNG or JPEG file is an error: OpenImageIO ignores it, and the colours
    would be taken for sRGB. OpenImageIO also ignores the RGB profile of a gray PNG file, which is
    read here.
    """
    profile = spec.getattribute("ICCProfile")
    if profile is not None:
        return np.asarray(profile, np.uint8).tobytes()
    damaged = False
    if file_format == "png":
        content = dict(_png_chunks(data)).get(b"iCCP")
        if content is None:
            return b""
        unpacker = zlib.decompressobj()
        try:
            found = unpacker.decompress(content[content.index(b"\0") + 2 :], MAX_PROFILE_BYTES)
        except (zlib.error, ValueError):
            found = b""
        if unpacker.eof:
            return found
        damaged = True
    elif file_format == "jpeg":
        damaged = b"ICC_PROFILE\0" in data[: data.find(b"\xff\xda")]
    if damaged:
        raise _damaged_profile()
    return b""
