"""ICC profiles of RGB spaces, for pictures: a matrix and parametric curves, in version 4.

All numbers are big-endian. The source is ICC.1:2022, whose clauses are named below.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from gamutcore.colours import (
    ICC_D50,
    RGB_CURVES,
    adaptation_matrix,
    primary_matrix,
    reference_white,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from gamutcore.references import Reference

__all__ = ["rgb_profile"]

VERSION = bytes((4, 0x40, 0, 0))

CREATED = struct.pack(">6H", 2022, 5, 1, 0, 0, 0)
"""The month of the specification: the same space always has the same bytes."""

COPYRIGHT = "The program that wrote this profile claims no copyright."

_HEADER = 128


def rgb_profile(reference: Reference) -> bytes:
    """Return the profile of an RGB space that is relative to its white, without a peak luminance.

    Colours are adapted to D50 by Bradford, as the profile states (E.2).
    """
    adaptation = adaptation_matrix(reference_white(reference), ICC_D50, "Bradford")
    red, green, blue = (adaptation @ primary_matrix(reference)).T
    curve = reference.definition["curve"]
    curve_tag = _parametric(RGB_CURVES[curve] if isinstance(curve, str) else (float(curve),))
    tags = {
        b"desc": _text(reference.name),
        b"cprt": _text(COPYRIGHT),
        b"wtpt": b"XYZ " + bytes(4) + _numbers(ICC_D50),
        b"chad": b"sf32" + bytes(4) + _numbers(adaptation.ravel()),
        **{
            name: b"XYZ " + bytes(4) + _numbers(column)
            for name, column in ((b"rXYZ", red), (b"gXYZ", green), (b"bXYZ", blue))
        },
        **dict.fromkeys((b"rTRC", b"gTRC", b"bTRC"), curve_tag),
    }
    offset = _HEADER + 4 + 12 * len(tags)
    table, parts = [struct.pack(">I", len(tags))], []
    for signature, data in tags.items():
        table.append(struct.pack(">4sII", signature, offset, len(data)))
        parts.append(data + bytes(-len(data) % 4))
        offset += len(parts[-1])
    head = struct.pack(">I4s4s4s4s4s", offset, bytes(4), VERSION, b"mntr", b"RGB ", b"XYZ ")
    head += CREATED + b"acsp" + bytes(24)  # platform, flags, manufacturer, model, attributes
    head += struct.pack(">I", 0) + _numbers(ICC_D50)
    return b"".join((head, bytes(_HEADER - len(head)), *table, *parts))


def _numbers(values: Iterable[float]) -> bytes:
    """Return numbers of the type s15Fixed16Number (4.6)."""
    return b"".join(struct.pack(">i", round(65536 * value)) for value in values)


def _parametric(parameters: tuple[float, ...]) -> bytes:
    """Return a curve: an exponent, or g, a, b, c and d (10.18, functions 0 and 3)."""
    kind = 0 if len(parameters) == 1 else 3
    return b"para" + bytes(4) + struct.pack(">2H", kind, 0) + _numbers(parameters)


def _text(text: str) -> bytes:
    """Return an element of the type multiLocalizedUnicodeType with one record (10.15)."""
    data = text.encode("utf-16-be")
    return struct.pack(">4s3I2s2s2I", b"mluc", 0, 1, 12, b"en", b"US", len(data), 28) + data
