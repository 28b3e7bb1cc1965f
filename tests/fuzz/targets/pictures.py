"""Pictures: PNG, TIFF, JPEG, and the formats of film and web."""

import io
import re
import struct
import tempfile
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from PIL import Image

from targets.checks import ANY_BYTES, Target, check_picture
from targets.profiles import lut8, profile

ROOT = Path(__file__).parents[3]
PROFILE = (ROOT / "tests" / "data" / "DisplayP3-v4.icc").read_bytes()
REPORTS = ROOT / "tests" / "data" / "reports"
SIGNATURE = b"\x89PNG\r\n\x1a\n"


def chunk(name, content):
    """Return a chunk with its length and check sum."""
    return (
        struct.pack(">I", len(content))
        + name
        + content
        + struct.pack(">I", zlib.crc32(name + content))
    )


def png(colour, depth, *chunks, interlaced=0):
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
_PNG = [
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
_PNG_TOKENS = [
    *(b"IHDR", b"PLTE", b"IDAT", b"IEND", b"tRNS", b"iCCP", b"cICP", b"gAMA", b"cHRM", b"sRGB"),
    *(b"\0\0\0\0", b"\0\0\0\1", b"\x7f\xff\xff\xff", b"\xff\xff\xff\xff", b"\0\0\1\0", b"acsp"),
    *(b"\0", b"\1", b"\2", b"\3", b"\4", b"\6", b"\x08", b"\x10", b"\xff", b"\0\1\0\0", b"x\x9c"),
    chunk(b"IEND", b""), chunk(b"tRNS", bytes(600)), _PALETTE,
]  # fmt: skip


def check_png(data):
    """Raise for the file as it is, or with its lengths, sums and packing made right.

    Most changes break one of these, and nothing behind it would be reached.
    """
    check_picture(data)
    check_picture(mended(data))


def mended(data):
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


_LETTERS = {1: "B", 3: "H", 4: "I", 7: "B"}


def tiff(parts, tags, *, order="<", tiled=False):
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


def tags_of(width, height, bits, samples, photometric, **more):
    """Return the tags of a picture; `more` are tags by number, as ``t259``."""
    tags = {
        256: (4, [width]),
        257: (4, [height]),
        258: (3, [bits] * samples),
        262: (3, [photometric]),
        277: (3, [samples]),
    }
    return tags | {int(name[1:]): (3, [value]) for name, value in more.items()}


def by_pillow(kind, mode, size=(11, 9), **how):
    """Return a small picture of fixed noise that Pillow wrote."""
    file = io.BytesIO()
    raw = "RGB" if mode == "P" else mode
    noise = np.random.default_rng(1).integers(0, 256, size[0] * size[1] * len(raw), dtype=np.uint8)
    picture = Image.frombytes(raw, size, noise.tobytes())
    (picture.quantize(16) if mode == "P" else picture).save(file, kind, **how)
    return file.getvalue()


_PRESS = profile({"A2B0": lut8(4)}, space="CMYK")


def _noise(count):
    return np.random.default_rng(2).integers(0, 256, count, dtype=np.uint8).tobytes()


_RGB = tags_of(16, 6, 8, 3, 2)
_TIFF = [
    by_pillow("TIFF", "RGB", compression="tiff_lzw", icc_profile=PROFILE),
    by_pillow("TIFF", "RGBA", compression="tiff_adobe_deflate"),
    by_pillow("TIFF", "RGB", compression="packbits"),
    by_pillow("TIFF", "RGB", compression="jpeg"),
    by_pillow("TIFF", "P"),
    by_pillow("TIFF", "CMYK", compression="tiff_lzw", icc_profile=_PRESS),
    tiff([_noise(18 * 8)] * 2, _RGB | {278: (3, [3])}),
    tiff([_noise(96)] * 3, _RGB | {284: (3, [2])}, order=">"),
    tiff([_noise(768 * 2)], tags_of(16, 6, 16, 3, 8, t322=16, t323=16), tiled=True),
    tiff([zlib.compress(_noise(576))], tags_of(16, 6, 16, 3, 9, t259=8, t317=2)),
    tiff([zlib.compress(bytes(1152))], tags_of(16, 6, 32, 3, 2, t259=8, t317=3, t339=3)),
    tiff([_noise(512)], tags_of(16, 8, 16, 2, 1, t338=1), order=">"),
    tiff([_noise(15 * 6)], tags_of(10, 6, 12, 1, 0)),
    tiff([_noise(40)], tags_of(10, 5, 4, 1, 3) | {320: (3, list(range(48)))}),
    *(path.read_bytes() for path in sorted(REPORTS.glob("*.tif"))),
]
_TIFF_TOKENS = [
    *(struct.pack("<H", tag) for tag in (256, 257, 258, 259, 262, 273, 277, 278, 279, 284, 317)),
    *(
        struct.pack("<H", tag)
        for tag in (320, 322, 323, 324, 325, 330, 332, 333, 334, 338, 339, 347, 34675)
    ),
    *(struct.pack("<H", number) for number in (0, 1, 2, 3, 5, 6, 7, 8, 9, 12, 16, 32, 32773)),
    *(struct.pack("<I", number) for number in (0, 1, 8, 65535, 2**31 - 1, 2**32 - 1, 100_000)),
    *(struct.pack(">H", tag) for tag in (256, 257, 258, 259, 277, 278)),
    *(b"II*\0", b"MM\0*", b"II+\0\x08\0\0\0", b"\xff\xd8", b"\xff\xd9", b"\0\0\xc0\x7f", b"x\x9c"),
]


def jpeg(mode, **how):
    return by_pillow("JPEG", mode, (40, 24), **how)


_EXIF = (
    b"Exif\0\0II*\0\x08\0\0\0\1\0\x69\x87\4\0\1\0\0\0\x1a\0\0\0\0\0\0\0"
    b"\2\0\x01\xa0\3\0\1\0\0\0\xff\xff\0\0\x05\xa0\4\0\1\0\0\0\x38\0\0\0\0\0\0\0"
    b"\1\0\1\0\2\0\4\0\0\0R03\0\0\0\0\0"
)
_JPEG = [
    jpeg("L"),
    jpeg("RGB", icc_profile=PROFILE),
    jpeg("RGB", progressive=True, exif=_EXIF),
    jpeg("RGB", subsampling=0, optimize=True),
    jpeg("CMYK", icc_profile=_PRESS),
    jpeg("RGB", restart_marker_rows=1),
    *(path.read_bytes() for path in sorted(REPORTS.glob("*.jpg"))),
]
_JPEG_TOKENS = [
    *(bytes([255, marker]) for marker in (0xC0, 0xC1, 0xC2, 0xC3, 0xC4, 0xC9, 0xD8, 0xD9, 0xDA)),
    *(bytes([255, marker]) for marker in (0xDB, 0xDC, 0xDD, 0xE0, 0xE1, 0xE2, 0xEE, 0xFE, 0x00)),
    *(b"\xff\xff", b"\0\0", b"\0\1", b"\0\2", b"\1\0", b"\x11", b"\x22", b"\x44", b"\x10", b"\x3f"),
    *(b"Adobe", b"JFIF\0", b"Exif\0\0", b"ICC_PROFILE\0", b"MPF\0", b"II*\0", b"R03\0", b"acsp"),
]


def _written(extension, sample_type, channels=3, **attributes):
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


_FILM = [
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
    by_pillow("WEBP", "RGBA", (64, 64)),
    by_pillow("WEBP", "RGB", (64, 64), lossless=True, icc_profile=PROFILE),
    by_pillow("GIF", "P", (64, 64), transparency=3),
    (REPORTS / "exr-two-layers-ao-and-combined.exr").read_bytes(),
    (REPORTS / "hdr-xyze.hdr").read_bytes(),
    by_pillow("BMP", "RGB", (64, 64)),
    by_pillow("BMP", "P", (64, 64)),
    _written(".dpx", "uint16"),
    _written(".dpx", "uint8", 4),
]
_FILM_TOKENS = [
    *(struct.pack("<I", number) for number in (0, 1, 31, 255, 65535, 2**31 - 1, 2**32 - 1)),
    *(struct.pack(">I", number) for number in (1, 31, 65535, 100_000)),
    *(b"\xff\x4f", b"\xff\x51", b"\xff\x90", b"\xff\xd9", b"VP8 ", b"VP8L", b"VP8X", b"ALPH"),
    *(b"ANIM", b"ANMF", b"ICCP", b"GIF89a", b"\x21\xf9\4", b"\x2c", b"\x3b", b"BM", b"\x28\0\0\0"),
    *(b"jp2h", b"ihdr", b"colr", b"jp2c", b"dataWindow", b"box2i", b"channels", b"chlist"),
    *(b".R", b".X", b"Combined", b"FORMAT=32-bit_rle_xyze", b"EXPOSURE=", b"chromaticities"),
    *(b"tiles", b"compression", b"FORMAT=32-bit_rle_rgbe", b"-Y 64 +X 64", b"PRIMARIES="),
]


TARGETS = {
    "png": Target(_PNG, _PNG_TOKENS, check_png, ANY_BYTES),
    "tiff": Target(_TIFF, _TIFF_TOKENS, check_picture, ANY_BYTES),
    "jpeg": Target(_JPEG, _JPEG_TOKENS, check_picture, ANY_BYTES),
    "film": Target(_FILM, _FILM_TOKENS, check_picture, ANY_BYTES),
}
