"""Small pictures in OpenEXR, Radiance HDR, JPEG XL, JPEG 2000, WebP and DPX."""

from __future__ import annotations

import re
import struct
import tempfile
from pathlib import Path

import fuzz
import numpy as np
import OpenImageIO as oiio  # noqa: N813

_png = fuzz.target("png")
check = _png.check_picture


def _written(extension: str, sample_type: str, channels: int = 3, **attributes: object) -> bytes:
    pixels = np.random.default_rng(4).random((64, 64, channels)).astype(np.float32)
    spec = oiio.ImageSpec(64, 64, channels, sample_type)
    for name, value in attributes.items():
        spec.attribute(name, value)
    with tempfile.NamedTemporaryFile(suffix=extension) as file:
        output = oiio.ImageOutput.create(file.name)
        assert output.open(file.name, spec)
        assert output.write_image(pixels)
        assert output.close()
        return Path(file.name).read_bytes()


SEEDS = [
    *(
        _written(".exr", "half", compression=name)
        for name in ("none", "zip", "piz", "pxr24", "b44")
    ),
    _written(".exr", "float", 4, compression="dwaa", tile_width=16, tile_height=16),
    _written(".hdr", "float"),
    _written(".jxl", "uint8"),
    _written(".jxl", "uint16", 4),
    _written(".jp2", "uint8"),
    _written(".j2k", "uint16"),
    _written(".webp", "uint8", 4),
    _written(".dpx", "uint16"),
    _written(".dpx", "uint8", 4),
]
TOKENS = [
    *(struct.pack("<I", number) for number in (0, 1, 31, 255, 65535, 2**31 - 1, 2**32 - 1)),
    *(struct.pack(">I", number) for number in (1, 31, 65535, 100_000)),
    *(b"\xff\x4f", b"\xff\x51", b"\xff\x90", b"\xff\xd9", b"VP8 ", b"VP8L", b"VP8X", b"ALPH"),
    *(b"jp2h", b"ihdr", b"colr", b"jp2c", b"dataWindow", b"box2i", b"channels", b"chlist"),
    *(b"tiles", b"compression", b"FORMAT=32-bit_rle_rgbe", b"-Y 64 +X 64", b"PRIMARIES="),
]
WORD = re.compile(rb"[\s\S]{1,4}")
