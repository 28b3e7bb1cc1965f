"""Pictures written by hand, so that the readers are not tested by the libraries they use."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest

_LETTERS = {1: "B", 3: "H", 4: "I", 7: "B"}


def png_chunk(name: bytes, content: bytes) -> bytes:
    """Return a chunk with its length and check sum."""
    return (
        struct.pack(">I", len(content))
        + name
        + content
        + struct.pack(">I", zlib.crc32(name + content))
    )


def packed_bits(values, depth):
    """Return the bytes of a row of values of 1 to 16 bits."""
    if depth == 16:
        return values.astype(">u2").tobytes()
    bits = np.unpackbits(values.astype(np.uint8)[:, np.newaxis], axis=1)[:, 8 - depth :]
    return np.packbits(bits).tobytes()


def png_file(pixels, depth, colour, *chunks):
    """Return a PNG file (W3C PNG, third edition) of rows without a filter."""
    height, width = pixels.shape[:2]
    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    rows = b"".join(b"\0" + packed_bits(row.reshape(-1), depth) for row in pixels)
    return (
        b"\x89PNG\r\n\x1a\n"
        + png_chunk(b"IHDR", header)
        + b"".join(chunks)
        + png_chunk(b"IDAT", zlib.compress(rows))
        + png_chunk(b"IEND", b"")
    )


def tiff_file(parts, tags, *, order="<", tiled=False, big=False):
    """Return a TIFF (or BigTIFF) file of strips or tiles and tags: tag to type and values."""
    body = bytearray(16)
    starts = []
    for part in parts:
        starts.append(len(body))
        body += part + bytes(-len(part) % 2)
    tags = {
        **tags,
        (324 if tiled else 273): (4, starts),
        (325 if tiled else 279): (4, [len(part) for part in parts]),
    }
    word, room = ("Q", 8) if big else ("I", 4)
    table = struct.pack(order + ("Q" if big else "H"), len(tags))
    for tag, (kind, values) in sorted(tags.items()):
        content = (
            values
            if isinstance(values, bytes)
            else struct.pack(f"{order}{len(values)}{_LETTERS[kind]}", *values)
        )
        place = content.ljust(room, b"\0")
        if len(content) > room:
            place = struct.pack(order + word, len(body))
            body += content + bytes(-len(content) % 2)
        table += struct.pack(order + "HH" + word, tag, kind, len(values)) + place
    mark = b"II" if order == "<" else b"MM"
    version = struct.pack(order + "HHH", 43, 8, 0) if big else struct.pack(order + "H", 42)
    header = mark + version + struct.pack(order + word, len(body))
    body[: len(header)] = header
    return bytes(body) + table + bytes(8)


def tiff_tags(width, height, bits, samples, photometric, **more):
    """Return the tags of a picture; `more` are further ones by number, as ``t259``."""
    tags = {
        256: (4, [width]),
        257: (4, [height]),
        258: (3, [bits] * samples),
        262: (3, [photometric]),
        277: (3, [samples]),
    }
    return tags | {int(name[1:]): (3, [value]) for name, value in more.items()}


@pytest.fixture(params=["whole", "a row at a time"])
def bands(request, monkeypatch):
    """Decode small pictures at once, and one row at a time."""
    if request.param != "whole":
        monkeypatch.setattr("gamutcore.characterisation.pictures.raster.BAND_BYTES", 1)
    return request.param


@pytest.fixture
def png():
    return png_file


@pytest.fixture
def chunk():
    return png_chunk


@pytest.fixture
def tiff():
    return tiff_file


@pytest.fixture
def tags():
    return tiff_tags


@pytest.fixture
def noise():
    """Return a function from a shape and a number of bits to fixed noise."""

    def made(*shape, bits=8, seed=0):
        kind = np.uint8 if bits <= 8 else np.uint16
        return np.random.default_rng(seed).integers(0, 2**bits, shape, dtype=np.int64).astype(kind)

    return made


@pytest.fixture
def pixel_counts():
    """Return a function from whole numbers, a row per pixel, to a dictionary of their counts."""

    def counted(pixels):
        rows, counts = np.unique(pixels.reshape(-1, pixels.shape[-1]), axis=0, return_counts=True)
        return {tuple(map(int, row)): int(n) for row, n in zip(rows, counts, strict=True)}

    return counted


@pytest.fixture
def counts_of():
    """Return a function from a picture and its full scale to the same dictionary."""

    def counted(picture, full):
        whole = np.round(picture.values * full).astype(np.int64)
        assert np.abs(picture.values * full - whole).max() < 1e-6
        return {tuple(map(int, row)): int(n) for row, n in zip(whole, picture.counts, strict=True)}

    return counted
