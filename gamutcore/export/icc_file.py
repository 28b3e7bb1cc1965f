"""ICC profiles as bytes: the header, the tags, and the elements that several profiles have.

All numbers are big-endian. Clauses are those of ICC.1:2001-04 (version 2.4), ICC.1:2010 (version
4.3) and ICC.2:2019 (version 5). The same content always gives the same bytes: the date is that of
the specification, and versions from 4 on have their digest as an id.
"""

from __future__ import annotations

import hashlib
import struct
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours import BLACK_NAMES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.arrays import FloatArray

__all__ = [
    "COPYRIGHT",
    "D50",
    "INTENTS",
    "curve_element",
    "data_space",
    "description_element",
    "fixed_element",
    "icc_file",
    "lut16_element",
    "lut_element",
    "parametric_element",
    "profile_id",
    "profile_of",
    "text_element",
    "xyz_element",
]

D50 = (0.9642, 1.0, 0.8249)
"""Illuminant of the header and white of the connection space (ICC.1:2010, 7.2.16)."""

INTENTS = ("perceptual", "relative", "saturation", "absolute")
"""Rendering intents by their number (ICC.1:2010, 7.2.15)."""

COPYRIGHT = "The program that wrote this profile claims no copyright."

_VERSIONS = {
    2: (bytes((2, 0x40, 0, 0)), (2001, 4, 1)),
    4: (bytes((4, 0x30, 0, 0)), (2010, 12, 1)),
    5: (bytes((5, 0, 0, 0)), (2019, 1, 1)),
}
"""The version in the header, and the date of its specification."""

_HEADER = 128
_ID = 84
"""Size of the header, and where it has the profile's id (ICC.1:2010, 7.2)."""


def icc_file(
    version: int, kind: str, spaces: tuple[str, str], tags: Mapping[str, bytes], intent: str
) -> bytes:
    """Return a profile of a class (`kind`), from a data colour space to a connection space."""
    number, date = _VERSIONS[version]
    head = struct.pack(">I4s4s4s4s4s", 0, bytes(4), number, *map(_signature, (kind, *spaces)))
    head += struct.pack(">6H", *date, 0, 0, 0) + b"acsp" + bytes(24)  # no platform, flags, model
    head += struct.pack(">I", INTENTS.index(intent)) + _fixed(D50)
    return profile_of(head.ljust(_HEADER, b"\0"), tags)


def profile_of(header: bytes, tags: Mapping[str, bytes]) -> bytes:
    """Return a profile with a header, in which the size and, from version 4 on, the id are set.

    Tags with equal elements share one place.
    """
    offset = _HEADER + 4 + 12 * len(tags)
    table, parts, places = [struct.pack(">I", len(tags))], [], dict[bytes, int]()
    for signature, data in tags.items():
        if data not in places:
            places[data] = offset
            parts.append(_padded(data))
            offset += len(parts[-1])
        table.append(struct.pack(">4sII", signature.encode("latin-1"), places[data], len(data)))
    whole = b"".join((struct.pack(">I", offset), header[4:], *table, *parts))
    digest = profile_id(whole) if header[8] >= 4 else bytes(16)
    return whole[:_ID] + digest + whole[_ID + 16 :]


def profile_id(data: bytes) -> bytes:
    """Return the digest of a profile without flags, intent and digest (ICC.1:2010, 7.2.18)."""
    blank = bytearray(data)
    blank[44:48], blank[64:68], blank[_ID : _ID + 16] = bytes(4), bytes(4), bytes(16)
    return hashlib.md5(blank, usedforsecurity=False).digest()


def data_space(channels: Sequence[str]) -> str:
    """Return the signature of a data colour space by the names of channels (ICC.1:2010, 7.2.8)."""
    names = [name.strip().lower() for name in channels]
    initials = "".join("K" if name in BLACK_NAMES else name[:1].upper() for name in names)
    return initials.ljust(4) if initials in {"RGB", "CMY", "CMYK"} else f"{len(names):X}CLR"


def _signature(text: str) -> bytes:
    return text.ljust(4).encode("ascii")


def _fixed(numbers: Sequence[float] | FloatArray) -> bytes:
    """Return numbers of the type s15Fixed16Number."""
    return np.round(65536.0 * np.asarray(numbers, np.float64)).astype(">i4").tobytes()


def xyz_element(xyz: Sequence[float] | FloatArray) -> bytes:
    """Return an element of the type XYZType."""
    return b"XYZ " + bytes(4) + _fixed(xyz)


def fixed_element(numbers: FloatArray) -> bytes:
    """Return an element of the type s15Fixed16ArrayType."""
    return b"sf32" + bytes(4) + _fixed(numbers.ravel())


def text_element(text: str) -> bytes:
    """Return an element of the type textType; characters outside ASCII become question marks."""
    return b"text" + bytes(4) + text.encode("ascii", "replace") + b"\0"


def description_element(text: str, version: int) -> bytes:
    """Return an element with a readable text.

    Its type is textDescriptionType in ASCII alone in version 2 (ICC.1:2001-04, 6.5.17), and
    multiLocalizedUnicodeType with one record later.
    """
    if version == 2:
        ascii_text = text.encode("ascii", "replace") + b"\0"
        head = b"desc" + bytes(4) + struct.pack(">I", len(ascii_text))
        return head + ascii_text + bytes(4 + 4 + 2 + 1 + 67)
    data = text.encode("utf-16-be")
    return struct.pack(">4s3I2s2s2I", b"mluc", 0, 1, 12, b"en", b"US", len(data), 28) + data


def curve_element(values: FloatArray) -> bytes:
    """Return an element of the type curveType, of values from 0 to 1."""
    return b"curv" + struct.pack(">2I", 0, len(values)) + _sixteen_bits(values)


def parametric_element(parameters: Sequence[float]) -> bytes:
    """Return an element of the type parametricCurveType: an exponent, or g, a, b, c and d.

    These are the functions 0 and 3 of ICC.1:2010, 10.16.
    """
    kind = 0 if len(parameters) == 1 else 3
    return b"para" + bytes(4) + struct.pack(">2H", kind, 0) + _fixed(parameters)


def lut16_element(
    nodes: FloatArray, before: FloatArray | None = None, after: FloatArray | None = None
) -> bytes:
    """Return an element of the type lut16Type (ICC.1:2001-04, 6.5.8), of values from 0 to 1.

    `nodes` (n, …, n, k) has an axis for each input, and the first varies least rapidly. The curves
    `before` and `after` the table have a row for each channel. They are identities unless given.
    """
    inputs, outputs = nodes.ndim - 1, nodes.shape[-1]
    before = np.tile((0.0, 1.0), (inputs, 1)) if before is None else before
    after = np.tile((0.0, 1.0), (outputs, 1)) if after is None else after
    head = struct.pack(">4sI4B", b"mft2", 0, inputs, outputs, len(nodes), 0)
    head += _fixed(np.eye(3)) + struct.pack(">2H", before.shape[1], after.shape[1])
    return head + b"".join(map(_sixteen_bits, (before, nodes, after)))


def lut_element(
    kind: str, nodes: FloatArray, before: FloatArray, after: FloatArray | None = None
) -> bytes:
    """Return an element of the type lutAToBType (``mAB``) or lutBToAType (``mBA``), as for lut16.

    Version 5 has these in place of lut16Type (ICC.1:2010, 10.10 and 10.11).
    """
    inputs, outputs = nodes.ndim - 1, nodes.shape[-1]
    after = np.tile((0.0, 1.0), (outputs, 1)) if after is None else after
    grid = bytes(nodes.shape[:-1]).ljust(16, b"\0") + bytes((2, 0, 0, 0)) + _sixteen_bits(nodes)
    first, last = (b"".join(map(_padded, map(curve_element, each))) for each in (before, after))
    clut, end = 32 + len(first), 32 + len(first) + len(_padded(grid))
    ends = (end, 0, 0, clut, 32) if kind == "mAB" else (32, 0, 0, clut, end)
    head = struct.pack(">4sI2BH5I", _signature(kind), 0, inputs, outputs, 0, *ends)
    return head + first + _padded(grid) + last


def _padded(data: bytes) -> bytes:
    return data + bytes(-len(data) % 4)


def _sixteen_bits(values: FloatArray) -> bytes:
    return np.round(65535.0 * values).astype(">u2").tobytes()
