"""ICC profiles: matrix and curves, gray, lookup tables of every type, process elements, targets."""

import functools
import struct
import zlib
from pathlib import Path

import numpy as np

from targets.checks import Target

ROOT = Path(__file__).parents[3]
SHARED = ROOT.parent / "shared" / "data"


def profile(tags, *, space="RGB ", pcs="Lab ", version=4):
    """Return a profile of some tags."""
    offset, table, body = 132 + 12 * len(tags), b"", b""
    for name, data in tags.items():
        table += struct.pack(">4sII", name.encode("latin-1"), offset + len(body), len(data))
        body += data + bytes(-len(data) % 4)
    header = bytearray(128)
    header[:4] = struct.pack(">I", offset + len(body))
    header[8], header[36:40] = version, b"acsp"
    header[12:24] = ("prtr" + space + pcs).encode("latin-1")
    return bytes(header) + struct.pack(">I", len(tags)) + table + body


def _xyz(*values):
    return b"XYZ " + bytes(4) + struct.pack(">3i", *[round(v * 65536) for v in values])


def _grid(channels):
    corners = np.array(np.meshgrid(*[[0, 1]] * channels, indexing="ij")).reshape(channels, -1).T
    light = 1 - corners.mean(axis=1)
    lab = np.stack([light, 0.5 + (corners[:, 0] - 0.5) * light, 0.5 + light / 4], axis=1)
    return [int(v) for v in (lab * 65280).reshape(-1)]


def _lut16(channels):
    head = struct.pack(">4sIBBBB", b"mft2", 0, channels, 3, 2, 0) + bytes(36) + b"\0\2\0\2"
    values = _grid(channels)
    table = struct.pack(f">{len(values)}H", *values)
    return head + b"\0\0\xff\xff" * channels + table + b"\0\0\xff\xff" * 3


def lut8(channels):
    head = struct.pack(">4sIBBBB", b"mft1", 0, channels, 3, 2, 0) + bytes(36)
    identity = bytes(range(256))
    return head + identity * channels + bytes(v >> 8 for v in _grid(channels)) + identity * 3


def _lut_a_to_b(channels):
    curve = b"para" + bytes(4) + struct.pack(">HHi", 0, 0, 65536)
    values = _grid(channels)
    clut = bytes([2] * channels + [0] * (16 - channels) + [2, 0, 0, 0])
    clut += struct.pack(f">{len(values)}H", *values)
    matrix = struct.pack(">12i", *[65536, 0, 0, 0, 65536, 0, 0, 0, 65536, 0, 0, 0])
    parts = [curve * 3, matrix, curve * 3, clut, (b"curv" + bytes(8)) * channels]
    parts = [part + bytes(-len(part) % 4) for part in parts]
    places = [32 + sum(map(len, parts[:i])) for i in range(5)]
    return struct.pack(">4sIBBH5I", b"mAB ", 0, channels, 3, 0, *places) + b"".join(parts)


def _elements(channels):
    def segment(*numbers):
        return struct.pack(">4sIHH4f", b"parf", 0, 0, 0, *numbers)

    line = segment(1, 1, 0, 0)
    samples = struct.pack(">4sII2f", b"samf", 0, 2, 0.4, 1.0)
    curve = struct.pack(">4sIHH2f", b"curf", 0, 3, 0, 0.0, 1.0) + line + samples + line
    places = struct.pack(">II", 12 + 8 * channels, len(curve)) * channels
    curves = struct.pack(">4sIHH", b"cvst", 0, channels, channels) + places + curve
    values = np.array(_grid(channels), dtype=">f4").tobytes()
    clut = struct.pack(">4sIHH", b"clut", 0, channels, 3) + bytes([2] * channels)
    clut += bytes(16 - channels) + values
    numbers = [1 / 653, 0, 0, 0, 1 / 326, 0, 0, 0, 1 / 326, 0, -100, -100]
    matrix = struct.pack(">4sIHH12f", b"matf", 0, 3, 3, *numbers)
    parts = [part + bytes(-len(part) % 4) for part in (curves, clut, matrix)]
    head = struct.pack(">4sIHHI", b"mpet", 0, channels, 3, len(parts))
    start, table = len(head) + 8 * len(parts), b""
    for part in parts:
        table += struct.pack(">II", start, len(part))
        start += len(part)
    return head + table + b"".join(parts)


_TARGET = b"""CTI3
BEGIN_DATA_FORMAT
SAMPLE_ID CMYK_C CMYK_M CMYK_Y CMYK_K LAB_L LAB_A LAB_B
END_DATA_FORMAT
BEGIN_DATA
1 0 0 0 0 95 0 -2
2 100 0 0 0 55 -37 -50
3 0 100 0 0 48 74 -3
4 0 0 100 0 89 -5 93
5 0 0 0 100 16 0 0
6 100 100 0 0 24 22 -46
7 40 100 100 0 40 60 40
END_DATA
"""
_WHITE = {"wtpt": _xyz(0.85, 0.88, 0.73)}
_ICC = [
    *[(ROOT / "tests" / "data" / f"{n}.icc").read_bytes() for n in ("sRGB-v4", "sGrey-v4")],
    (ROOT / "tests" / "data" / "sRGB-v2-magic.icc").read_bytes(),
    profile({"A2B0": _lut16(4), "A2B1": _lut16(4), **_WHITE}, space="CMYK", version=2),
    profile({"A2B0": lut8(3), **_WHITE}),
    profile({"A2B0": _lut_a_to_b(4), "targ": b"text" + bytes(4) + _TARGET}, space="CMYK"),
    profile({"A2B1": _lut16(7), **_WHITE}, space="7CLR"),
    profile({"D2B0": _elements(3), "D2B1": _elements(3), "A2B1": lut8(3)}),
    profile({"D2B1": _elements(4), "D2B3": _elements(4)}, space="CMYK"),
    profile({"A2B1": _elements(5), **_WHITE}, space="nc\0\5", version=5),
    profile({"CIED": b"zut8" + bytes(4) + zlib.compress(_TARGET)}, space="CMYK"),
]
_ICC_TOKENS = [
    *b"mft1 mft2 mpet cvst matf clut curf parf samf curv para text zut8 ZXML XYZ  sf32".split(),
    *b"A2B0 A2B1 D2B1 D2B3 rXYZ rTRC kTRC wtpt chad clrt targ CIED DevD desc".split(),
    *b"scnr mntr prtr link nmcl GRAY CMYK 7CLR FCLR acsp".split(),
    *(b"mAB ", b"RGB ", b"XYZ ", b"Lab ", b"spac", b"calc", b"bACS", b"nc\0\x0f", b"nc\0\0"),
    *(b"\0\0\0\0", b"\xff\xff\xff\xff", b"\x7f\xff\xff\xff", b"\x80\0\0\0", b"\0\0\0\1"),
    *(b"\x7f\x80\0\0", b"\x7f\xc0\0\0", b"\x3f\x80\0\0", b"\xff", b"\0", b"\2", b"\x0f", b"\x10"),
]


@functools.cache
def _real(*, large):
    """Return real profiles, where they are there; large tables are slow to copy."""
    names = ["press/ISOcoated_v2_300_bas.icc", "display/Acer_XB271HU.icc"]
    display = sorted((SHARED / "display").glob("[CM]*.icc"))
    paths = [SHARED / name for name in names] if large else display
    return [path.read_bytes() for path in paths if path.is_file()]


def mutated(chance):
    """Return a profile with a few changes, most of them where the structure stands."""
    large = chance.random() < 0.025
    data = bytearray(chance.choice(_real(large=large) + _ICC))
    for _ in range(min(int(chance.paretovariate(0.8)), 12)):
        kind = chance.randrange(8)
        count = int.from_bytes(data[128:132], "big")
        # The header, the tag table, the beginnings of tags, or anywhere.
        place = chance.randrange(max(len(data), 1))
        if kind < 3 and len(data) > 144 and 0 < count < 100:
            entry = 132 + 12 * chance.randrange(count)
            start = int.from_bytes(data[entry + 4 : entry + 8], "big")
            place = chance.choice([entry + 4 * chance.randrange(3), start + chance.randrange(64)])
        elif kind == 3:
            place = chance.choice([0, 8, 12, 16, 20, 68, 128])
        place = min(place, len(data))
        if chance.random() < 0.5:
            token = chance.choice(_ICC_TOKENS)
            data[place : place + len(token)] = token
        elif chance.random() < 0.6 and place < len(data):
            data[place] = chance.choice([0, 1, 2, 127, 128, 255, chance.randrange(256)])
        elif chance.random() < 0.5:
            length = chance.randrange(1, 64)
            data[place : place + length] = data[
                (at := chance.randrange(len(data) + 1)) : at + length
            ]
        elif chance.random() < 0.3:
            del data[place:]
    return bytes(data)


TARGETS = {"icc": Target(_ICC, _ICC_TOKENS, mutated=mutated)}
