"""The data of TIFF pictures: strips or tiles, unpacked and put together.

LZW and PackBits are unpacked by libtiff through Pillow, JPEG by libjpeg-turbo, deflate by zlib;
each is given the bytes of one strip or tile, and asked for exactly what that must hold.
"""

from __future__ import annotations

import io
import math
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL.TiffImagePlugin import TiffImageFile

from gamutcore.characterisation.pictures.bounds import (
    BAND_BYTES,
    checked_held,
    checked_size,
    malformed,
)
from gamutcore.characterisation.pictures.inflate import Inflated
from gamutcore.characterisation.pictures.jpeg import MOST_UNPACKED, jpeg_frame, jpeg_rows
from gamutcore.characterisation.pictures.tiff_tags import Directory
from gamutcore.errors import UnsupportedPictureError

__all__ = ["DecodedSamples", "Layout", "decoded_samples", "refused"]

_NONE, _LZW, _JPEG, _DEFLATE, _PACKBITS, _OLD_DEFLATE = 1, 5, 7, 8, 32773, 32946

_RATIOS = {
    # Bytes that one byte makes at most. LZW: strings of a table of 4096 grow by one with every code
    # of 9 to 12 bits; PackBits: two bytes make 128.
    _NONE: 1.0,
    _LZW: 1500.0,
    _JPEG: float(MOST_UNPACKED),
    _DEFLATE: 1032.0,
    _OLD_DEFLATE: 1032.0,
    _PACKBITS: 64.0,
}

_STRIP_RATIO = 20
"""Bytes that are held at most for one of a strip that libtiff unpacks, where they are many. Writers
make strips of some kilobytes; one of a hundred megabytes has to be worth it."""

_MAX_PARTS = 2**16
"""Strips or tiles at most: 24 million pixels are 94 thousand tiles of the smallest size that TIFF
allows, 16 × 16, and 6 thousand of those that are in use."""

_REVERSED = np.packbits(np.unpackbits(np.arange(256, dtype=np.uint8)[:, None], axis=1)[:, ::-1])
"""Every byte with its bits in reverse order."""


@dataclass(frozen=True)
class Layout:
    """How the data of a picture is laid out.

    Parameters
    ----------
    width, height, samples : int
    bits : int
        Of a sample.
    floats : bool
    planar : bool
        Whether every channel has strips or tiles of its own.
    compression, predictor : int
        As in the tags 259 and 317.
    reversed_bits : bool
        Whether the first pixel is in the lowest bits of a byte.
    photometric : int
        As in the tag 262.
    """

    width: int
    height: int
    samples: int
    bits: int
    floats: bool
    planar: bool
    compression: int
    predictor: int
    reversed_bits: bool
    photometric: int

    @property
    def together(self) -> int:
        """How many samples of a pixel are in one strip or tile."""
        return 1 if self.planar else self.samples


def refused(message: str, tag: int, remedy: str) -> UnsupportedPictureError:
    """Return the error of a picture of a kind that is not read.

    Parameters
    ----------
    message : str
    tag : int
        The tag at fault.
    remedy : str

    Returns
    -------
    UnsupportedPictureError
    """
    return UnsupportedPictureError(message, where={"tag": str(tag)}, remedy=remedy)


@dataclass(frozen=True, eq=False)
class DecodedSamples:
    """All samples of a picture, decoded as they are asked for.

    Parameters
    ----------
    blocks : iterator of (int, (rows, columns, samples) array)
        Parts of the picture, with their first rows: uint8, uint16 or float, whole numbers of 32
        bits by their upper 16.
    dtype : dtype
    packed : int
        Bytes that they have in the file.
    """

    blocks: Iterator[tuple[int, npt.NDArray[Any]]]
    dtype: np.dtype[Any]
    packed: int


def decoded_samples(data: bytes, tags: Directory, layout: Layout) -> DecodedSamples:
    """Return all samples of a picture.

    Parameters
    ----------
    data : bytes
        The file.
    tags : Directory
    layout : Layout

    Returns
    -------
    DecodedSamples

    Raises
    ------
    MalformedFileError, PictureSizeError, UnsupportedPictureError
        As `tiff_raster`; what is broken in the data itself, when it is decoded.
    """
    _check_packing(layout)
    parts = _Parts(data, tags, layout)
    depth = np.uint8 if layout.bits <= 8 else np.uint16
    kind = {16: np.float16, 32: np.float32, 64: np.float64}[layout.bits] if layout.floats else depth
    return DecodedSamples(_blocks(parts, layout, np.dtype(kind)), np.dtype(kind), sum(parts.sizes))


def _blocks(
    parts: _Parts, layout: Layout, kind: np.dtype[Any]
) -> Iterator[tuple[int, npt.NDArray[Any]]]:
    """Yield the samples of strips or tiles, some rows at a time, without what pads them."""
    apart = parts.across * parts.down
    for place in range(apart):
        down, across = divmod(place, parts.across)
        top, left = down * parts.height, across * parts.width
        rows = min(parts.height, layout.height - top)
        columns = min(parts.width, layout.width - left)
        height = parts.height if parts.tiled else rows
        planes = layout.samples if layout.planar else 1
        groups = [_rows_of(place + apart * plane, height, parts) for plane in range(planes)]
        for begun in range(0, rows, parts.step):
            found = [next(group)[: rows - begun, :columns] for group in groups]
            block = found[0] if planes == 1 else np.concatenate(found, axis=2)
            yield top + begun, block.astype(kind, copy=False)


def _check_packing(layout: Layout) -> None:
    if layout.compression not in _RATIOS:
        raise refused(
            f"The picture's compression is {layout.compression}.",
            259,
            "None, LZW, deflate (ZIP), PackBits and JPEG are read.",
        )
    accepted = {1, 3} if layout.floats else {1, 2}
    if layout.bits not in {8, 16, 32, 64}:
        accepted = {1}
    packed = layout.compression in {_LZW, _DEFLATE, _OLD_DEFLATE}
    if packed and layout.predictor not in accepted:
        raise refused(f"The picture's predictor is {layout.predictor}.", 317, "None, or 2 or 3.")
    if layout.compression == _JPEG and (layout.bits != 8 or layout.floats):
        raise refused("JPEG within TIFF has 8 bits.", 258, "8 bits, or another compression.")


class _Parts:
    """The strips or tiles of a picture, checked against the file."""

    def __init__(self, data: bytes, tags: Directory, layout: Layout) -> None:
        self.data, self.layout = data, layout
        self.tables = tags.content(347)
        self.order = tags.order
        self.tiled = 322 in tags.entries
        offsets, counts = (324, 325) if self.tiled else (273, 279)
        planes = layout.samples if layout.planar else 1
        pixel_bytes = layout.samples * layout.bits / 8
        # Before anything is counted, so that no number below can be absurd.
        checked_size(layout.width, layout.height, max(pixel_bytes, 1), len(data), math.inf)
        if self.tiled:
            self.width, self.height = tags.whole(322, 0), tags.whole(323, 0)
            if not (0 < self.width <= 2**16 and 0 < self.height <= 2**16):
                raise malformed(f"Tiles have {self.width} × {self.height} pixels.", {"tag": "322"})
        else:
            self.width = layout.width
            self.height = max(1, min(tags.whole(278, layout.height), layout.height))
        self.across = -(-layout.width // self.width)
        self.down = -(-layout.height // self.height)
        number = self.across * self.down * planes
        if number > _MAX_PARTS:
            raise refused(
                f"The picture is in {number} strips or tiles.", offsets, f"At most {_MAX_PARTS}."
            )
        stated = tags.entries.get(offsets, (0, 0, 0))[1]
        if stated < number:
            raise malformed(
                f"{number} strips or tiles are needed, and {stated} are there.",
                {"tag": str(offsets)},
            )
        self.starts = [int(value) for value in tags.numbers(offsets)[:number]]
        self.sizes = [int(value) for value in tags.numbers(counts)[:number]]
        self.row_bytes = (self.width * layout.together * layout.bits + 7) // 8
        self.step = max(1, BAND_BYTES // (self.row_bytes * planes))
        if not self.sizes and layout.compression == _NONE and number == 1:
            self.sizes = [self.row_bytes * layout.height]
        self._check(number, counts)
        whole = self.across * self.width * self.down * self.height
        checked_size(1, whole, pixel_bytes, sum(self.sizes), _RATIOS[layout.compression])
        if layout.compression in {_LZW, _PACKBITS}:  # which libtiff unpacks whole strips of
            held = planes * self.row_bytes * self.height
            # Pillow has a strip's bytes twice while it is unpacked.
            decoded = held + self.row_bytes * self.height
            checked_held(held, decoded, planes * max(self.sizes), _STRIP_RATIO)

    def _check(self, number: int, counts: int) -> None:
        if len(self.sizes) != number:
            raise malformed("The sizes of strips or tiles are missing.", {"tag": str(counts)})
        for index, (start, size) in enumerate(zip(self.starts, self.sizes, strict=True)):
            if start < 8 or size <= 0 or start + size > len(self.data):
                raise malformed(
                    f"The strip or tile {index} of {size} bytes at byte {start} is not within the "
                    f"file's {len(self.data)} bytes.",
                    {"strip": index},
                )
        if sum(self.sizes) > len(self.data):
            raise malformed("Strips or tiles overlap.", {"tag": str(counts)})

    def content(self, number: int) -> memoryview:
        """Return the bytes of a part."""
        start = self.starts[number]
        return memoryview(self.data)[start : start + self.sizes[number]]


def _rows_of(number: int, height: int, parts: _Parts) -> Iterator[npt.NDArray[Any]]:
    """Yield the samples of a strip or tile as (rows, width, together), some rows at a time."""
    layout = parts.layout
    if layout.compression == _JPEG:
        yield from _jpeg_samples(bytes(parts.content(number)), number, height, parts)
        return
    try:
        read = _reader(parts.content(number), parts.row_bytes, height, layout.compression)
        for begun in range(0, height, parts.step):
            rows = min(parts.step, height - begun)
            unpacked = read(rows * parts.row_bytes)
            if len(unpacked) < rows * parts.row_bytes:
                held = begun * parts.row_bytes + len(unpacked)
                raise malformed(
                    f"The strip or tile {number} holds {held} bytes in place of "
                    f"{height * parts.row_bytes}.",
                    {"strip": number},
                )
            yield _samples_of(unpacked, rows, parts)
    except (zlib.error, OSError, SyntaxError, ValueError, TypeError, LookupError) as error:
        raise malformed(
            f"The strip or tile {number} cannot be unpacked.", {"strip": number}
        ) from error


def _samples_of(
    unpacked: bytes | memoryview | npt.NDArray[np.uint8], height: int, parts: _Parts
) -> npt.NDArray[Any]:
    """Return the samples of rows as (height, width, together)."""
    layout, wanted = parts.layout, height * parts.row_bytes
    rows = np.frombuffer(unpacked, np.uint8, wanted).reshape(height, parts.row_bytes)
    shape = (height, parts.width, layout.together)
    predictor = layout.predictor if layout.compression in {_LZW, _DEFLATE, _OLD_DEFLATE} else 1
    if layout.bits not in {8, 16, 32, 64}:
        return _packed_bits(rows, shape, layout)
    size = layout.bits // 8
    if predictor == 3:
        # Differences of bytes, the first bytes of all samples first (Adobe, technical note 3).
        summed = rows.reshape(height, -1, layout.together).cumsum(axis=1, dtype=np.uint8)
        planes = summed.reshape(height, size, -1).transpose(0, 2, 1)
        return np.ascontiguousarray(planes).view(f">f{size}").reshape(shape).astype(f"f{size}")
    letter = "f" if layout.floats else "u"
    samples = rows.view(f"{parts.order}{letter}{size}").reshape(shape)
    if predictor == 2:
        samples = samples.cumsum(axis=1, dtype=samples.dtype.newbyteorder("="))
    if layout.bits == 32 and not layout.floats:
        return (samples >> 16).astype(np.uint16)
    return samples


def _reader(
    content: memoryview, row_bytes: int, rows: int, compression: int
) -> Callable[[int], bytes | memoryview | npt.NDArray[np.uint8]]:
    """Return what gives the next bytes of a strip or tile, so many at most, unpacked."""
    if compression in {_DEFLATE, _OLD_DEFLATE}:
        return Inflated([content]).read
    place = 0
    unpacked: Any = (
        None if compression == _NONE else _by_libtiff(content, row_bytes, rows, compression)
    )

    def read(size: int) -> bytes | memoryview | npt.NDArray[np.uint8]:
        nonlocal place
        start, place = place, place + size
        if unpacked is None:
            return content[start:place]
        # Of a picture with that many bytes in a row: arrays of all of it would double the memory.
        rows_above = start // row_bytes
        box = (0, rows_above, row_bytes, rows_above + size // row_bytes)
        return np.asarray(unpacked.crop(box)).reshape(-1)

    return read


def _by_libtiff(content: memoryview, row_bytes: int, rows: int, compression: int) -> Any:  # noqa: ANN401
    """Return bytes that were packed, as a gray picture with that one strip."""
    tags = [
        (256, 4, row_bytes), (257, 4, rows), (258, 3, 8), (259, 3, compression), (262, 3, 1),
        (273, 4, 8), (277, 3, 1), (278, 4, rows), (279, 4, len(content)),
    ]  # fmt: skip
    padded = bytes(content) + bytes(len(content) % 2)
    directory = b"".join(
        struct.pack("<HHI" + ("HH" if kind == 3 else "I"), tag, kind, 1, value, *[0] * (kind == 3))
        for tag, kind, value in tags
    )
    header = struct.pack("<2sHI", b"II", 42, 8 + len(padded))
    table = struct.pack("<H", len(tags)) + directory + bytes(4)
    picture: Any = TiffImageFile(io.BytesIO(header + padded + table))
    picture.load()
    return picture


def _packed_bits(
    rows: npt.NDArray[np.uint8], shape: tuple[int, int, int], layout: Layout
) -> npt.NDArray[Any]:
    """Return samples that do not fill bytes: each row begins in a byte of its own."""
    if layout.reversed_bits:
        rows = _REVERSED[rows]
    values = shape[1] * shape[2]
    samples = np.empty((shape[0], values), np.uint8 if layout.bits <= 8 else np.uint16)
    step = max(1, 2**20 // values)
    for start in range(0, shape[0], step):
        bits = np.unpackbits(rows[start : start + step], axis=1, count=values * layout.bits)
        padded = np.zeros((bits.size // layout.bits, 16), np.uint8)
        padded[:, 16 - layout.bits :] = bits.reshape(-1, layout.bits)
        whole = np.packbits(padded, axis=1).view(">u2")
        samples[start : start + step] = whole.reshape(-1, values)
    return samples.reshape(shape)


def _jpeg_samples(
    content: bytes, number: int, height: int, parts: _Parts
) -> Iterator[npt.NDArray[Any]]:
    layout, where = parts.layout, {"strip": number}
    if not content.startswith(b"\xff\xd8"):
        raise malformed(f"The strip or tile {number} is no JPEG stream.", {**where})
    frame = jpeg_frame(content)
    size = (frame.height, frame.width, len(frame.components))
    if size[0] < height or size[1] < parts.width or size[2] != layout.together:
        raise malformed(f"The strip or tile {number} is of another size.", {**where})
    if size[0] * size[1] > (height + 16) * (parts.width + 16):
        raise malformed(f"The strip or tile {number} is larger than it should be.", {**where})
    planes = layout.samples if layout.planar else 1
    checked_held(planes * frame.held, planes * frame.decoded, planes * len(content))
    tables = parts.tables[2:-2] if parts.tables[:2] == b"\xff\xd8" else b""
    for top, pixels in jpeg_rows(frame, int(layout.photometric == 6), parts.step, tables):
        if top < height:
            # Pillow turns all CMYK over, as Adobe's JPEG files need it; TIFF has it the other way.
            turned = 255 - pixels if layout.together == 4 else pixels
            yield turned[: height - top]
