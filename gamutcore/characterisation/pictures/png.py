"""PNG pictures: chunks read here, pixels unpacked by Pillow's decoder.

Portable Network Graphics, third edition (W3C 2025). Of the chunks that say what colours mean, the
highest in its precedence is taken: cICP, iCCP, sRGB, then cHRM and gAMA (clause 4.3). Pillow
reduces RGB of 16 bits to 8; its decoder is asked twice, for the first and the second bytes. Some
rows are unpacked at a time, so that a picture never has to fit into memory.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from gamutcore.characterisation.pictures.bounds import (
    BAND_BYTES,
    MAX_RATIO,
    checked_size,
    malformed,
)
from gamutcore.characterisation.pictures.encoding import (
    SRGB,
    Encoding,
    code_point_encoding,
    gamma_encoding,
)
from gamutcore.characterisation.pictures.inflate import Inflated
from gamutcore.characterisation.pictures.raster import MAX_PROFILE_BYTES, Raster
from gamutcore.errors import PictureSizeError, Where

__all__ = ["PNG_SIGNATURE", "png_raster"]

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"

_SAMPLES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Samples of a pixel by colour type (11.2.1): gray, RGB, indexed, gray and alpha, RGBA."""

_DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}

_MOST_DEFLATED = 1032
"""Bytes that deflate makes of one at most: a match of 258 takes two bits."""

_FREE_PROFILE = 2**22
"""Bytes that any embedded profile may unpack to."""

_USED = (b"PLTE", b"tRNS", b"iCCP", b"cICP", b"sRGB", b"gAMA", b"cHRM")


@dataclass(eq=False)
class _Chunks:
    header: tuple[int, int, int, int, int]
    single: dict[bytes, bytes] = field(default_factory=dict)
    data: list[memoryview] = field(default_factory=list)
    animated: bool = False


def png_raster(data: bytes) -> Raster:
    """Return the pixels of a PNG file.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    Raster

    Raises
    ------
    MalformedFileError
        A chunk is broken, missing or ends early; ``where`` has the chunk, and its first byte.
    PictureSizeError
        It has more pixels than are decoded.
    """
    chunks = _chunks(data)
    width, height, depth, colour, _ = chunks.header
    samples = _SAMPLES[colour]
    packed = sum(len(part) for part in chunks.data)
    held = max(depth, 8)  # bits that a sample takes in memory
    checked_size(width, height, samples * held / 8, packed, _MOST_DEFLATED * held / depth)
    profile, encoding, said = _meaning(chunks)
    if chunks.animated:
        said.append("The picture is animated; its still picture is used.")
    raster = Raster(
        "png",
        "gray" if colour in {0, 4} else "RGB",
        width,
        height,
        _parts(chunks),
        np.dtype(np.uint16 if depth == 16 else np.uint8),
        packed,
        full=255 if colour == 3 else 2**depth - 1,
        bits=depth,
        profile=profile,
        encoding=encoding,
        said=said,
    )
    if colour == 3:
        _take_palette(raster, chunks.single)
        raster.notes["indexed"] = True
    elif colour in {4, 6}:
        raster.colours, raster.alpha = _all_but_last, _last
        raster.alpha_full = float(raster.full)
    elif b"tRNS" in chunks.single:
        raster.alpha = _keyed_out(chunks.single[b"tRNS"])
    if b"cICP" in chunks.single and not chunks.single[b"cICP"][3] and not profile and not said:
        _widen_range(raster, depth)
    return raster


def _all_but_last(samples: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return samples[:, :, :-1]


def _last(samples: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return samples[:, :, -1]


def _chunks(data: bytes) -> _Chunks:
    view, place = memoryview(data), len(PNG_SIGNATURE)
    name, content, place = _chunk(view, place)
    if name != b"IHDR":
        raise malformed("The first chunk is not IHDR.", _where(name, len(PNG_SIGNATURE)))
    chunks = _Chunks(_header(bytes(content)))
    while name != b"IEND":
        if place >= len(data):
            raise malformed("The file ends early.", {"chunk": "IEND"})
        start = place
        name, content, place = _chunk(view, place)
        if name == b"IDAT":
            chunks.data.append(content)
        elif name in _USED:
            chunks.single.setdefault(name, bytes(content))
        elif name == b"acTL":
            chunks.animated = True
        elif name == b"IHDR":
            raise malformed("There are two headers.", _where(name, start))
        elif name != b"IEND" and not name[0] & 32:
            raise malformed("An essential chunk is of an unknown kind.", _where(name, start))
    if not chunks.data:
        raise malformed("The picture has no data.", {"chunk": "IDAT"})
    _check_lengths(chunks)
    return chunks


def _chunk(view: memoryview, place: int) -> tuple[bytes, memoryview, int]:
    """Return a chunk's name and content, and where the next one is."""
    if place + 12 > len(view):
        raise malformed("The file ends within a chunk.", {"byte": place})
    length, name = struct.unpack_from(">I4s", view, place)
    end = place + 8 + length
    if end + 4 > len(view):
        raise malformed("The file ends within a chunk.", _where(name, place))
    if name in {b"IHDR", b"IDAT", b"IEND", *_USED}:
        stated = int.from_bytes(view[end : end + 4], "big")
        if zlib.crc32(view[place + 4 : end]) != stated:
            raise malformed("The check sum of a chunk is wrong.", _where(name, place))
    return name, view[place + 8 : end], end + 4


def _where(name: bytes, place: int) -> Where:
    return {"chunk": name.decode("latin-1"), "byte": place}


def _header(content: bytes) -> tuple[int, int, int, int, int]:
    where = _where(b"IHDR", len(PNG_SIGNATURE))
    if len(content) != 13:
        raise malformed(f"The header has {len(content)} bytes in place of 13.", where)
    width, height, depth, colour, packing, filtering, interlaced = struct.unpack(
        ">IIBBBBB", content
    )
    if depth not in _DEPTHS.get(colour, ()):
        raise malformed(f"Colour type {colour} with {depth} bits does not exist.", where)
    if packing or filtering or interlaced > 1:
        raise malformed(
            f"Compression {packing}, filter {filtering}, interlace {interlaced} do not exist.",
            where,
        )
    return width, height, depth, colour, interlaced


def _check_lengths(chunks: _Chunks) -> None:
    _, _, _, colour, _ = chunks.header
    wanted = {b"cICP": 4, b"sRGB": 1, b"gAMA": 4, b"cHRM": 32}
    if colour in {0, 2}:
        wanted[b"tRNS"] = 2 * _SAMPLES[colour]
    for name, length in wanted.items():
        if name in chunks.single and len(chunks.single[name]) != length:
            raise malformed(
                f"The chunk has {len(chunks.single[name])} bytes in place of {length}.",
                {"chunk": name.decode()},
            )
    palette = chunks.single.get(b"PLTE", b"")
    if len(palette) % 3 or len(palette) > 768 or (colour == 3 and not palette):
        raise malformed(f"The palette has {len(palette)} bytes.", {"chunk": "PLTE"})


_PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2),
           (0, 1, 1, 2))  # fmt: skip
"""First column and row of each pass of an interlaced picture, and their steps (clause 8.2)."""

_DECODED = {
    # Bytes of a pixel, which filters go by: Pillow's mode, and the orders of bytes that it decodes.
    # Those of six and eight are decoded twice: the first bytes of every sample, and the second.
    1: ("L", ("L",)),
    2: ("LA", ("LA",)),
    3: ("RGB", ("RGB",)),
    4: ("RGBA", ("RGBA",)),
    6: ("RGB", ("RGB;16B", "RGB;16L")),
    8: ("RGBA", ("RGBA;16B", "RGBA;16L")),
}


def _parts(chunks: _Chunks) -> Iterator[tuple[int, npt.NDArray[Any]]]:
    """Yield the samples of some rows at a time; of an interlaced picture those of each pass."""
    width, height, depth, colour, interlaced = chunks.header
    samples = _SAMPLES[colour]
    stream = Inflated(chunks.data)
    for left, top, right, down in _PASSES if interlaced else ((0, 0, 1, 1),):
        columns, rows = -(-(width - left) // right), -(-(height - top) // down)
        if columns <= 0 or rows <= 0:
            continue
        row_bytes = (columns * samples * depth + 7) // 8
        step = max(1, BAND_BYTES // row_bytes)
        above = bytes(row_bytes)
        for start in range(0, rows, step):
            count = min(step, rows - start)
            lines = _lines(stream, count, above, max(1, samples * depth // 8))
            above = lines[-1].tobytes()
            yield top + start * down, _samples_of(lines, columns, samples, depth)


def _lines(stream: Inflated, count: int, above: bytes, pixel_bytes: int) -> npt.NDArray[np.uint8]:
    """Return the bytes of the next rows, without their filters."""
    wanted = count * (len(above) + 1)
    broken = malformed("The picture's data is broken or ends early.", {"chunk": "IDAT"})
    try:
        filtered = stream.read(wanted)
        lines = _unfiltered(above, filtered, pixel_bytes) if len(filtered) == wanted else None
    except (zlib.error, ValueError, OSError, SyntaxError, EOFError) as error:
        raise broken from error
    if lines is None:
        raise broken
    return lines


def _unfiltered(above: bytes, filtered: bytes, pixel_bytes: int) -> npt.NDArray[np.uint8]:
    """Return the bytes of rows as (rows, row_bytes), from those of the row above and filtered ones.

    Pillow takes the row above for the first one, without a filter, of a picture that is not packed.
    """
    row_bytes = len(above)
    mode, orders = _DECODED[pixel_bytes]
    stored = zlib.compress(b"".join([b"\0", above, filtered]), 0)
    size = (row_bytes // pixel_bytes, len(filtered) // (row_bytes + 1) + 1)
    decoded = [
        np.asarray(Image.frombytes(mode, size, stored, "zip", order, 0)).reshape(size[1], -1)[1:]
        for order in orders
    ]
    return decoded[0] if len(decoded) == 1 else np.stack(decoded, axis=-1).reshape(-1, row_bytes)


def _samples_of(
    lines: npt.NDArray[np.uint8], columns: int, samples: int, depth: int
) -> npt.NDArray[Any]:
    """Return the bytes of rows as (rows, columns, samples)."""
    if depth == 16:
        numbers: npt.NDArray[Any] = np.ascontiguousarray(lines).view(">u2").astype(np.uint16)
    elif depth == 8:
        numbers = lines
    else:
        shifts = np.arange(8 - depth, -1, -depth, dtype=np.uint8)
        numbers = (lines[:, :, np.newaxis] >> shifts) & np.uint8(2**depth - 1)
        numbers = numbers.reshape(len(lines), -1)[:, : columns * samples]
    return numbers.reshape(len(lines), columns, samples)


def _take_palette(raster: Raster, single: dict[bytes, bytes]) -> None:
    raster.palette = np.frombuffer(single[b"PLTE"], np.uint8).reshape(-1, 3)
    stated = np.frombuffer(single.get(b"tRNS", b""), np.uint8)[: len(raster.palette)]
    alpha = np.full(len(raster.palette), 255, np.uint8)
    alpha[: len(stated)] = stated
    raster.palette_alpha = alpha


def _keyed_out(stated: bytes) -> Callable[[npt.NDArray[Any]], npt.NDArray[np.bool_]]:
    key = np.frombuffer(stated, ">u2")

    def opaque(samples: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
        found: npt.NDArray[np.bool_] = (samples != key.astype(np.uint16)).any(axis=2)
        return found

    return opaque


def _widen_range(raster: Raster, depth: int) -> None:
    """Turn narrow-range values, 16 to 235 of 8 bits (ITU-T H.273, 8.3), into full-range ones."""
    unit = 2 ** (depth - 8) if depth >= 8 else 1
    table = (np.arange(raster.full + 1, dtype=np.float64) / unit - 16) / 219 * 65535
    wide = np.clip(np.round(table), 0, 65535).astype(np.uint16)
    if raster.palette is None:
        narrow = raster.colours
        raster.colours = lambda samples: wide[narrow(samples)]
        raster.dtype = wide.dtype
    else:
        raster.palette = wide[raster.palette]
    raster.full = 2**16 - 1


def _meaning(chunks: _Chunks) -> tuple[bytes, Encoding | None, list[str]]:
    single, said = chunks.single, list[str]()
    if b"cICP" in single:
        primaries, transfer, matrix, _ = single[b"cICP"]
        encoding = code_point_encoding(primaries, transfer) if not matrix else None
        if encoding is not None:
            return b"", encoding, said
        said.append(
            f"The code points {primaries}, {transfer}, {matrix} (cICP) are not evaluated, and were "
            "passed over."
        )
    if b"iCCP" in single:
        return _profile(single[b"iCCP"]), None, said
    if b"sRGB" in single:
        return b"", SRGB, said
    gamma, chromaticities = None, None
    if b"gAMA" in single:
        stated = int.from_bytes(single[b"gAMA"], "big")
        gamma = 100_000 / stated if stated else 0.0
    if b"cHRM" in single:
        numbers = [value / 100_000 for value in struct.unpack(">8I", single[b"cHRM"])]
        chromaticities = tuple(zip(numbers[::2], numbers[1::2], strict=True))
    if gamma is None and chromaticities is None:
        return b"", None, said
    encoding = gamma_encoding(gamma, chromaticities)
    if encoding is None:
        said.append("The gamma or primaries (gAMA, cHRM) are those of no display: passed over.")
    return b"", encoding, said


def _profile(content: bytes) -> bytes:
    name, ended, rest = content.partition(b"\0")
    where: Where = {"chunk": "iCCP"}
    if not ended or len(name) > 79 or rest[:1] != b"\0":
        raise malformed("The embedded profile has no name, or another compression.", where)
    try:
        unpacker = zlib.decompressobj()
        profile = unpacker.decompress(rest[1:], MAX_PROFILE_BYTES + 1)
    except zlib.error as error:
        raise malformed("The embedded profile cannot be unpacked.", where) from error
    if not unpacker.eof and len(profile) <= MAX_PROFILE_BYTES:
        raise malformed("The embedded profile ends early.", where)
    if max(_FREE_PROFILE, len(rest) * MAX_RATIO) < len(profile) <= MAX_PROFILE_BYTES:
        raise PictureSizeError(
            f"The embedded profile unpacks from {len(rest)} bytes to {len(profile)}.",
            where=where,
            remedy=f"Beyond {_FREE_PROFILE} bytes, at most {MAX_RATIO} are unpacked of one; press "
            "profiles have about two.",
        )
    return profile
