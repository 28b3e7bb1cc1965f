"""TIFF pictures: strips and tiles, every compression, predictor, colour model and type."""

from __future__ import annotations

import io
import re
import struct
import zlib

import fuzz
import numpy as np
from PIL import Image

_png, _icc = fuzz.target("png"), fuzz.target("icc")
check = _png.check_picture

_LETTERS = {1: "B", 3: "H", 4: "I", 7: "B"}


def tiff(
    parts: list[bytes],
    tags: dict[int, tuple[int, list[int] | bytes]],
    *,
    order: str = "<",
    tiled: bool = False,
) -> bytes:
    """Return a file of strips or tiles and tags, written by hand (TIFF 6.0, section 2)."""
    body = bytearray(b"\0" * 8)
    starts = []
    for part in parts:
        starts.append(len(body))
        body += part + bytes(len(part) % 2)
    tags = {
        **tags,
        (324 if tiled else 273): (4, starts),
        (325 if tiled else 279): (4, [len(part) for part in parts]),
    }
    table = struct.pack(order + "H", len(tags))
    for tag, (kind, values) in sorted(tags.items()):
        content = (
            values
            if isinstance(values, bytes)
            else struct.pack(f"{order}{len(values)}{_LETTERS[kind]}", *values)
        )
        if len(content) > 4:
            place = struct.pack(order + "I", len(body))
            body += content + bytes(len(content) % 2)
        else:
            place = content.ljust(4, b"\0")
        table += struct.pack(order + "HHI", tag, kind, len(values)) + place
    body[:8] = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "I", len(body))
    return bytes(body) + table + bytes(4)


def tags_of(
    width: int, height: int, bits: int, samples: int, photometric: int, **more: int
) -> dict[int, tuple[int, list[int] | bytes]]:
    """Return the tags of a picture; `more` are tags by number, as ``t259``."""
    tags: dict[int, tuple[int, list[int] | bytes]] = {
        256: (4, [width]),
        257: (4, [height]),
        258: (3, [bits] * samples),
        262: (3, [photometric]),
        277: (3, [samples]),
    }
    return tags | {int(name[1:]): (3, [value]) for name, value in more.items()}


def by_pillow(mode: str, **how: object) -> bytes:
    """Return a small picture of fixed noise that Pillow wrote."""
    file = io.BytesIO()
    channels = {"L": 1, "RGB": 3, "RGBA": 4, "CMYK": 4, "P": 1}[mode]
    noise = np.random.default_rng(1).integers(0, 256, (9, 11, channels), dtype=np.uint8)
    if mode == "P":
        picture = Image.fromarray(np.repeat(noise, 3, axis=2)).quantize(16)
    else:
        picture = Image.fromarray(noise[:, :, 0] if channels == 1 else noise, mode=None)
        picture = picture if picture.mode == mode else picture.convert(mode)
    picture.save(file, "TIFF", **how)
    return file.getvalue()


_PRESS = _icc.profile({"A2B0": _icc._lut8(4)}, space="CMYK")


def _noise(count: int) -> bytes:
    return np.random.default_rng(2).integers(0, 256, count, dtype=np.uint8).tobytes()


_RGB = tags_of(16, 6, 8, 3, 2)
SEEDS = [
    by_pillow("RGB", compression="tiff_lzw", icc_profile=_png.PROFILE),
    by_pillow("RGBA", compression="tiff_adobe_deflate"),
    by_pillow("RGB", compression="packbits"),
    by_pillow("RGB", compression="jpeg"),
    by_pillow("P"),
    by_pillow("CMYK", compression="tiff_lzw", icc_profile=_PRESS),
    tiff([_noise(18 * 8)] * 2, _RGB | {278: (3, [3])}),
    tiff([_noise(96)] * 3, _RGB | {284: (3, [2])}, order=">"),
    tiff([_noise(768 * 2)], tags_of(16, 6, 16, 3, 8, t322=16, t323=16), tiled=True),
    tiff([zlib.compress(_noise(576))], tags_of(16, 6, 16, 3, 9, t259=8, t317=2)),
    tiff([zlib.compress(bytes(1152))], tags_of(16, 6, 32, 3, 2, t259=8, t317=3, t339=3)),
    tiff([_noise(512)], tags_of(16, 8, 16, 2, 1, t338=1), order=">"),
    tiff([_noise(15 * 6)], tags_of(10, 6, 12, 1, 0)),
    tiff([_noise(40)], tags_of(10, 5, 4, 1, 3) | {320: (3, list(range(48)))}),
]
TOKENS = [
    *(struct.pack("<H", tag) for tag in (256, 257, 258, 259, 262, 273, 277, 278, 279, 284, 317)),
    *(struct.pack("<H", tag) for tag in (320, 322, 323, 324, 325, 330, 338, 339, 347, 34675)),
    *(struct.pack("<H", number) for number in (0, 1, 2, 3, 5, 6, 7, 8, 9, 12, 16, 32, 32773)),
    *(struct.pack("<I", number) for number in (0, 1, 8, 65535, 2**31 - 1, 2**32 - 1, 100_000)),
    *(struct.pack(">H", tag) for tag in (256, 257, 258, 259, 277, 278)),
    *(b"II*\0", b"MM\0*", b"II+\0\x08\0\0\0", b"\xff\xd8", b"\xff\xd9", b"\0\0\xc0\x7f", b"x\x9c"),
]
WORD = re.compile(rb"[\s\S]{1,4}")
