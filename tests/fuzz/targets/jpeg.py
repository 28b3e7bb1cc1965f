"""JPEG pictures: gray, RGB and CMYK, baseline and progressive, with profiles and Exif."""

from __future__ import annotations

import io
import re

import fuzz
import numpy as np
from PIL import Image

_png, _icc = fuzz.target("png"), fuzz.target("icc")
check = _png.check_picture


def jpeg(mode: str, **how: object) -> bytes:
    """Return a picture of 40 × 24 pixels of fixed noise."""
    file = io.BytesIO()
    channels = {"L": 1, "RGB": 3, "CMYK": 4}[mode]
    noise = np.random.default_rng(3).integers(0, 256, (24, 40, channels), dtype=np.uint8)
    picture = Image.frombytes(mode, (40, 24), noise.tobytes())
    picture.save(file, "JPEG", **how)
    return file.getvalue()


_EXIF = (
    b"Exif\0\0II*\0\x08\0\0\0\1\0\x69\x87\4\0\1\0\0\0\x1a\0\0\0\0\0\0\0"
    b"\2\0\x01\xa0\3\0\1\0\0\0\xff\xff\0\0\x05\xa0\4\0\1\0\0\0\x38\0\0\0\0\0\0\0"
    b"\1\0\1\0\2\0\4\0\0\0R03\0\0\0\0\0"
)
SEEDS = [
    jpeg("L"),
    jpeg("RGB", icc_profile=_png.PROFILE),
    jpeg("RGB", progressive=True, exif=_EXIF),
    jpeg("RGB", subsampling=0, optimize=True),
    jpeg("CMYK", icc_profile=_icc.profile({"A2B0": _icc._lut8(4)}, space="CMYK")),
    jpeg("RGB", restart_marker_rows=1),
]
TOKENS = [
    *(bytes([255, marker]) for marker in (0xC0, 0xC1, 0xC2, 0xC3, 0xC4, 0xC9, 0xD8, 0xD9, 0xDA)),
    *(bytes([255, marker]) for marker in (0xDB, 0xDC, 0xDD, 0xE0, 0xE1, 0xE2, 0xEE, 0xFE, 0x00)),
    *(b"\xff\xff", b"\0\0", b"\0\1", b"\0\2", b"\1\0", b"\x11", b"\x22", b"\x44", b"\x10", b"\x3f"),
    *(b"Adobe", b"JFIF\0", b"Exif\0\0", b"ICC_PROFILE\0", b"II*\0", b"R03\0", b"acsp"),
]
WORD = re.compile(rb"[\s\S]{1,4}")
