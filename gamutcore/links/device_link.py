"""ICC device links: profiles of the class ``link``, in version 2, which every engine reads.

The table is in the tag A2B0, of the type lut16Type with identities for its matrix and curves. All
numbers are big-endian. The source is ICC.1:2001-04 (version 2.4), whose clauses are named below.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gamutcore.arrays import FloatArray

__all__ = ["device_link_file"]

VERSION = bytes((2, 0x40, 0, 0))
CREATED = struct.pack(">6H", 2001, 4, 1, 0, 0, 0)
"""The month of the specification: the same link always gives the same bytes."""

D50 = struct.pack(">3i", 63190, 65536, 54061)
"""The illuminant of the header, 0.9642, 1 and 0.8249 (6.1.9)."""

INTENTS = ("perceptual", "relative", "saturation", "absolute")
"""Rendering intents by their number (6.1.11)."""

COPYRIGHT = "The program that wrote this profile claims no copyright."

_HEADER = 128


def device_link_file(
    description: str, devices: Sequence[tuple[str, Sequence[str]]], intent: str, nodes: FloatArray
) -> bytes:
    """Return the profile of nodes (n, …, n, k), n up to 255, from device values to others, 0 to 1.

    `devices` has the names of the source and the destination, and those of their channels, up to
    15. Characters outside ASCII become question marks.
    """
    tags = {
        b"desc": _description(description),
        b"cprt": b"text" + bytes(4) + COPYRIGHT.encode("ascii") + b"\0",
        b"pseq": _sequence([name for name, _ in devices]),
        b"A2B0": _lut16(nodes),
    }
    offset = _HEADER + 4 + 12 * len(tags)
    table, parts = [struct.pack(">I", len(tags))], []
    for signature, data in tags.items():
        table.append(struct.pack(">4sII", signature, offset, len(data)))
        parts.append(data + bytes(-len(data) % 4))
        offset += len(parts[-1])
    spaces = [_signature(channels) for _, channels in devices]
    head = struct.pack(">I4s4s4s4s4s", offset, bytes(4), VERSION, b"link", *spaces)
    head += CREATED + b"acsp" + bytes(24)  # platform, flags, manufacturer, model, attributes
    head += struct.pack(">I", INTENTS.index(intent)) + D50
    return b"".join((head, bytes(_HEADER - len(head)), *table, *parts))


def _signature(channels: Sequence[str]) -> bytes:
    """Return the signature of a colour space (6.1.5)."""
    known = {("R", "G", "B"): b"RGB ", ("C", "M", "Y"): b"CMY ", ("C", "M", "Y", "K"): b"CMYK"}
    return known.get(tuple(channels), f"{len(channels):X}CLR".encode())


def _description(text: str) -> bytes:
    """Return an element of the type textDescriptionType in ASCII alone (6.5.17)."""
    data = text.encode("ascii", "replace") + b"\0"
    return b"desc" + bytes(4) + struct.pack(">I", len(data)) + data + bytes(4 + 4 + 2 + 1 + 67)


def _sequence(devices: Sequence[str]) -> bytes:
    """Return an element of the type profileSequenceDescType (6.5.12).

    A name stands for the model. Manufacturer, model, attributes and technology are unknown.
    """
    entries = [bytes(4 + 4 + 8 + 4) + _description("") + _description(name) for name in devices]
    return b"pseq" + bytes(4) + struct.pack(">I", len(entries)) + b"".join(entries)


def _lut16(nodes: FloatArray) -> bytes:
    """Return an element of the type lut16Type (6.5.8); the first channel varies least rapidly."""
    matrix = (65536 * np.eye(3)).astype(">i4").tobytes()
    inputs, outputs = nodes.ndim - 1, nodes.shape[-1]
    head = struct.pack(">4sI4B", b"mft2", 0, inputs, outputs, len(nodes), 0) + matrix
    identity = struct.pack(">2H", 0, 65535)
    table = np.round(nodes * 65535.0).astype(">u2")
    curves = inputs * identity, outputs * identity
    return b"".join((head, struct.pack(">2H", 2, 2), curves[0], table.tobytes(), curves[1]))
