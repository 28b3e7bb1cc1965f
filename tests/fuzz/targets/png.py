"""PNG pictures of every colour type, with profiles and with the chunks that stand in for them.

Most changes break a length, a check sum or the packing, behind which nothing would be reached, so
every file is checked as it is, and with these made right.
"""

from __future__ import annotations

import re
import struct
import zlib
from pathlib import Path

import numpy as np

from gamutcore.characterisation import Picture, characterisation
from gamutcore.colours import surface_colours
from gamutcore.errors import GamutError

ROOT = Path(__file__).parents[3]
PROFILE = (ROOT / "tests" / "data" / "DisplayP3-v4.icc").read_bytes()
SIGNATURE = b"\x89PNG\r\n\x1a\n"


def chunk(name: bytes, content: bytes) -> bytes:
    """Return a chunk with its length and check sum."""
    return (
        struct.pack(">I", len(content))
        + name
        + content
        + struct.pack(">I", zlib.crc32(name + content))
    )


def png(colour: int, depth: int, *chunks: bytes, interlaced: int = 0) -> bytes:
    """Return a picture of 13 × 7 pixels with unfiltered rows of fixed noise."""
    samples = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
    chance, data = np.random.default_rng(depth), b""
    # First column and row, and their steps, of each pass (clause 8.2, Adam7).
    adam7 = [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2)]
    for left, top, right, down in [*adam7, (0, 1, 1, 2)] if interlaced else [(0, 0, 1, 1)]:
        for _ in range(top, 7, down):
            size = (len(range(left, 13, right)) * samples * depth + 7) // 8
            data += b"\0" + chance.integers(0, 256, size, dtype=np.uint8).tobytes()
    header = struct.pack(">IIBBBBB", 13, 7, depth, colour, 0, 0, interlaced)
    packed = zlib.compress(data)
    return (
        SIGNATURE
        + chunk(b"IHDR", header)
        + b"".join(chunks)
        + chunk(b"IDAT", packed[:20])
        + chunk(b"IDAT", packed[20:])
        + chunk(b"IEND", b"")
    )


_PALETTE = chunk(b"PLTE", bytes(range(48)) * 16)
SEEDS = [
    png(0, 1), png(0, 4), png(0, 8, chunk(b"tRNS", b"\0\5")), png(0, 16),
    png(2, 8, chunk(b"iCCP", b"Display P3\0\0" + zlib.compress(PROFILE))),
    png(2, 8, chunk(b"cICP", bytes([9, 16, 0, 1])), chunk(b"tRNS", bytes(6))),
    png(2, 16, chunk(b"cICP", bytes([12, 18, 0, 0])), interlaced=1),
    png(2, 8, chunk(b"gAMA", struct.pack(">I", 45455)), chunk(b"cHRM", struct.pack(
        ">8I", 31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000))),
    png(3, 8, _PALETTE, chunk(b"tRNS", bytes([0, 128, 255]))),
    png(3, 4, chunk(b"PLTE", bytes(range(48))), interlaced=1),
    png(4, 8, chunk(b"sRGB", b"\0")), png(4, 16), png(6, 8, chunk(b"acTL", bytes(8))), png(6, 16),
]  # fmt: skip
TOKENS = [
    *(b"IHDR", b"PLTE", b"IDAT", b"IEND", b"tRNS", b"iCCP", b"cICP", b"gAMA", b"cHRM", b"sRGB"),
    *(b"\0\0\0\0", b"\0\0\0\1", b"\x7f\xff\xff\xff", b"\xff\xff\xff\xff", b"\0\0\1\0", b"acsp"),
    *(b"\0", b"\1", b"\2", b"\3", b"\4", b"\6", b"\x08", b"\x10", b"\xff", b"\0\1\0\0", b"x\x9c"),
    chunk(b"IEND", b""), chunk(b"tRNS", bytes(600)), _PALETTE,
]  # fmt: skip
WORD = re.compile(rb"[\s\S]{1,4}")


def check(data: bytes) -> None:
    """Raise if a file is neither refused with an error of gamutcore nor finite."""
    check_picture(data)
    check_picture(mended(data))


def check_picture(data: bytes) -> None:
    """Raise for one file as it is."""
    try:
        found = characterisation(data)
        if not isinstance(found, Picture):
            return  # the signature was changed, and what is left is text
        assert len(found) == len(found.counts) > 0
        assert (found.counts > 0).all()
        for popularity in (None, 0.05):
            points = surface_colours(found, popularity=popularity).points
            assert np.isfinite(points).all()
            assert len(points) > 0
    except GamutError as error:
        _told(error)
    except MemoryError:
        pass  # the service reports it as build-out-of-memory


def _told(error: GamutError) -> None:
    assert error.message
    assert error.code != "gamut-error"


def mended(data: bytes) -> bytes:
    """Return a file with the lengths and sums of its chunks made right, its data packed anew."""
    found = list(re.finditer(rb"IHDR|PLTE|IDAT|IEND|tRNS|iCCP|cICP|gAMA|cHRM|sRGB|acTL", data))
    chunks, packed = b"", b""
    ends = [match.start() - 8 for match in found[1:]] + [len(data) - 4]
    for match, end in zip(found, ends, strict=False):
        content = data[match.end() : max(end, match.end())]
        if match[0] == b"IDAT":
            packed += content
        elif match[0] != b"IEND":
            chunks += chunk(match[0], content)
    unpacker, rows = zlib.decompressobj(), b""
    try:
        for place in range(len(packed)):  # as far as it goes
            rows += unpacker.decompress(packed[place : place + 1])
    except zlib.error:
        pass
    return SIGNATURE + chunks + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
