"""The structure of picture files: chunks, segments, fields and lines of headers.

OpenImageIO and Pillow decode the pixels. What they do not report, or report wrongly, is read here:
PNG's chunks, the segments of JPEG, the boxes of JPEG XL, the fields of TIFF that tell inks from
alpha, the lines of Radiance HDR, and the embedded profile.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from gamutcore.errors import MalformedProfileError

__all__ = [
    "JPEG_SCAN",
    "TIFF_EXTRA_SAMPLES",
    "TIFF_INK_NAMES",
    "TIFF_INK_SET",
    "bmp_profile",
    "embedded_profile",
    "has_gain_map",
    "holds_several_jpegs",
    "jpeg_segments",
    "png_chunks",
    "radiance_lines",
    "tiff_fields",
]

MAX_PROFILE_BYTES = 2**25
"""Maximum size of an embedded profile. The largest press profiles have about 10 MB."""

_BMP_V5_SIZE = 124

_BETWEEN_MARKERS = re.compile(rb"\xff+([^\x00\xff])", re.DOTALL)
_RESTART_OR_TEM = frozenset({0x01, *range(0xD0, 0xD8)})
_START, _END, JPEG_SCAN, _APP1, _APP2 = 0xD8, 0xD9, 0xDA, 0xE1, 0xE2
"""Codes of JPEG markers (ITU-T T.81, table B.1). The first and the restarts have no segment."""

_PROFILE_SEGMENT = b"ICC_PROFILE\0"
"""Start of a segment APP2 with a part of the profile (ICC.1:2022, B.4)."""

_MULTI_PICTURE = b"MPF\0"
"""Start of the segment APP2 that lists several pictures (CIPA DC-007)."""

_XMP = (b"http://ns.adobe.com/xap/1.0/\0", b"http://ns.adobe.com/xmp/extension/\0")
_GAIN_MAP_SEGMENT = b"urn:iso:std:iso:ts:21496:-1\0"
_GAIN_MAP_NAMES = (
    b"http://ns.adobe.com/hdr-gain-map/1.0/",  # Adobe's specification, and Android's Ultra HDR
    b"http://ns.apple.com/HDRGainMap/1.0/",
    b"urn:com:apple:photo:2020:aux:hdrgainmap",
)
"""Signs of gain maps: a segment APP2 of ISO 21496-1, and names in XMP."""

TIFF_INK_SET, TIFF_INK_NAMES, TIFF_EXTRA_SAMPLES = 332, 333, 338
"""Tags of TIFF 6.0, sections 16 and 18."""

_TIFF_SIZES = {1: (1, "B"), 2: (1, "s"), 3: (2, "H"), 4: (4, "I")}
_LONGEST_FIELD = 4096


def png_chunks(data: bytes, *, after_pixels: bool = False) -> dict[bytes, bytes]:
    """Return the chunks before the pixels, or those after them, by their names.

    The first of several chunks of a name counts, as in libpng.
    """
    chunks: dict[bytes, bytes] = {}
    place, seen = 8, False
    while place + 8 <= len(data):
        size, name = struct.unpack_from(">I4s", data, place)
        if name == b"IDAT":
            if not after_pixels:
                break
            seen = True
        elif seen or not after_pixels:
            chunks.setdefault(name, data[place + 8 : place + 8 + size])
        place += size + 12
    return chunks


def jpeg_segments(data: bytes, place: int = 0) -> Iterator[tuple[int, int, int]]:
    """Yield the code of each marker of one JPEG, and start and end of its segment's content.

    Markers are found as decoders find them. What a segment holds, such as a thumbnail, is skipped.
    The marker of the end is the last, and has no content.
    """
    while marker := _BETWEEN_MARKERS.search(data, place):
        code, place = marker[1][0], marker.end()
        if code == _END:
            yield code, place, place
            return
        if code in _RESTART_OR_TEM or code == _START:
            continue
        end = place + int.from_bytes(data[place : place + 2], "big")
        yield code, place + 2, end
        place = end


def _jpeg_headers(data: bytes) -> Iterator[bytes]:
    """Yield the segments APP1 and APP2 of all pictures in a JPEG file; thumbnails are no pictures.

    Further pictures, such as gain maps, follow the end of the first (CIPA DC-007).
    """
    place = 0
    while place >= 0:
        end = len(data)
        for code, first, last in jpeg_segments(data, place):
            if code in {_APP1, _APP2}:
                yield data[first:last]
            elif code == _END:
                end = last
        place = data.find(b"\xff\xd8\xff", end)


def holds_several_jpegs(data: bytes) -> bool:
    """Return whether a JPEG file states that it holds several pictures."""
    return any(content.startswith(_MULTI_PICTURE) for content in _jpeg_headers(data))


def has_gain_map(data: bytes, file_format: str) -> bool:
    """Return whether a JPEG or JPEG XL file has a gain map, which makes a picture brighter."""
    if file_format == "jpeg-xl":
        return b"jhgm" in _jpeg_xl_boxes(data)
    if file_format != "jpeg":
        return False
    return any(
        content.startswith(_GAIN_MAP_SEGMENT)
        or (content.startswith(_XMP) and any(name in content for name in _GAIN_MAP_NAMES))
        for content in _jpeg_headers(data)
    )


def _jpeg_xl_boxes(data: bytes) -> set[bytes]:
    """Return the types of the boxes of a JPEG XL container (ISO/IEC 18181-2)."""
    kinds: set[bytes] = set()
    place = 0
    while data.startswith(b"\0\0\0\x0cJXL ") and place + 8 <= len(data):
        size, kind = struct.unpack_from(">I4s", data, place)
        if size == 1:
            size = int.from_bytes(data[place + 8 : place + 16], "big")
        kinds.add(kind)
        if size < 8:  # 0: up to the end of the file
            break
        place += size
    return kinds


def tiff_fields(data: bytes) -> dict[int, tuple[int, ...] | bytes]:
    """Return short fields of a TIFF's first directory by tag; texts are bytes (TIFF 6.0, 2)."""
    order = "<" if data[:2] == b"II" else ">"
    fields: dict[int, tuple[int, ...] | bytes] = {}
    try:
        if struct.unpack_from(order + "H", data, 2)[0] == 43:  # BigTIFF
            word, room, place, number = "Q", 8, struct.unpack_from(order + "Q", data, 8)[0], "Q"
        else:
            word, room, place, number = "I", 4, struct.unpack_from(order + "I", data, 4)[0], "H"
        entries = struct.unpack_from(order + number, data, place)[0]
        place += struct.calcsize(order + number)
        for _ in range(min(entries, 2**16)):
            tag, kind, count = struct.unpack_from(order + "HH" + word, data, place)
            content = place + 4 + room
            place = content + room
            size, letter = _TIFF_SIZES.get(kind, (0, ""))
            if not 0 < size * count <= _LONGEST_FIELD:
                continue
            if size * count > room:
                content = struct.unpack_from(order + word, data, content)[0]
            values = struct.unpack_from(f"{order}{count}{letter}", data, content)
            fields[tag] = values[0] if kind == 2 else values
    except (struct.error, OverflowError):
        pass  # the decoder refuses a damaged file
    return fields


def radiance_lines(data: bytes) -> list[tuple[str, str]]:
    """Return the variables of a Radiance header with their texts, in the order of the file."""
    header = re.split(rb"\r?\n\r?\n", data[:65536], maxsplit=1)[0].decode("latin-1")
    pairs = [line.partition("=") for line in header.splitlines()]
    return [(name.strip().upper(), text.strip()) for name, sign, text in pairs if sign]


def _damaged_profile(cause: str = "") -> MalformedProfileError:
    return MalformedProfileError(
        cause or "The embedded profile is damaged, incomplete, too large or in another file.",
        where={"field": "profile"},
        remedy="Embed the profile again, or save the picture without a profile.",
    )


def embedded_profile(spec: Any, data: bytes, file_format: str) -> bytes:  # noqa: ANN401
    """Return the embedded ICC profile of a picture; empty without one.

    A damaged profile of a PNG or JPEG file is an error: OpenImageIO ignores it, and the colours
    would be taken for sRGB. OpenImageIO also ignores the RGB profile of a gray PNG file, and
    a profile that a JPEG file has twice.
    """
    if file_format == "jpeg":
        return _jpeg_profile(data)
    profile = spec.getattribute("ICCProfile")
    if profile is not None:
        return np.asarray(profile, np.uint8).tobytes()
    if file_format == "png":
        return _png_profile(data)
    return b""


def _png_profile(data: bytes) -> bytes:
    content = png_chunks(data).get(b"iCCP")
    if content is None:
        return b""
    unpacker = zlib.decompressobj()
    try:
        profile = unpacker.decompress(content[content.index(b"\0") + 2 :], MAX_PROFILE_BYTES)
    except (zlib.error, ValueError):
        raise _damaged_profile() from None
    if not unpacker.eof:
        raise _damaged_profile()
    return profile


def _jpeg_profile(data: bytes) -> bytes:
    """Return the profile in the segments APP2 before the pixels (ICC.1:2022, B.4).

    Its parts may stand in any order, and equal copies count once.
    """
    copies: dict[int, dict[int, bytes]] = {}
    for code, first, last in jpeg_segments(data):
        if code == JPEG_SCAN:
            break
        content = data[first:last]
        if code != _APP2 or not content.startswith(_PROFILE_SEGMENT):
            continue
        if len(content) < len(_PROFILE_SEGMENT) + 2:
            raise _damaged_profile()
        number, count = content[len(_PROFILE_SEGMENT) : len(_PROFILE_SEGMENT) + 2]
        part = content[len(_PROFILE_SEGMENT) + 2 :]
        if copies.setdefault(count, {}).setdefault(number, part) != part:
            raise _damaged_profile("The picture has several embedded profiles that differ.")
    profiles = set()
    for count, parts in copies.items():
        if sorted(parts) != list(range(1, count + 1)):
            numbers = ", ".join(map(str, sorted(parts)))
            raise _damaged_profile(
                f"The embedded profile is incomplete: it has the parts {numbers} of {count}."
            )
        profiles.add(b"".join(parts[number] for number in sorted(parts)))
    if len(profiles) > 1:
        raise _damaged_profile("The picture has several embedded profiles that differ.")
    return profiles.pop() if profiles else b""


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
