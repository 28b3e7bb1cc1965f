"""A gamut boundary description in an iccMAX profile (ICC.2:2019, 10.2.11).

The profile is abstract: from CIELAB to CIELAB, with an identity as its transform. A gamut has no
device model, so no other class of profile would be true of it. The tag gbd0, gbd1, gbd2 or gbd3
is that of the gamut's intent. All numbers are big-endian.
"""

from __future__ import annotations

import hashlib
import struct
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.meshes.gamut_surfaces import GAMUT_BOUNDARY_TAGS
from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.export.icc_cielab import check_icc_cielab
from gamutcore.version import __version__

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.geometry import TriangleMesh

__all__ = ["icc"]

HEADER = 128
VERSION = bytes((5, 0, 0, 0))
D50 = struct.pack(">3i", *(round(65536 * part) for part in (0.9642, 1.0, 0.8249)))
CREATED = struct.pack(">6H", 2019, 1, 1, 0, 0, 0)
"""The year of the standard: the same mesh always gives the same bytes."""

INTENTS = ("perceptual", "relative", "saturation", "absolute")
"""Rendering intents by their number (ICC.2:2019, 7.2.17)."""

COPYRIGHT = "The program that wrote this profile claims no copyright."


def icc(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as a gamut boundary description in an iccMAX profile, in CIELAB (D50) only.

    The provenance's ``intent`` chooses the tag, and its ``gamut`` is in the description. Device
    values are left out, because the data colour space of the profile is CIELAB.
    """
    check_icc_cielab(space, "icc")
    intent = provenance.get("intent", "relative")
    intent = intent if intent in INTENTS else "relative"
    description = f"Gamut boundary {provenance.get('gamut', '')[:12]} by gamutcore {__version__}"
    tags = {
        "desc": _text(description),
        "cprt": _text(COPYRIGHT),
        "wtpt": b"XYZ \0\0\0\0" + D50,
        "A2B0": _identity(),
        GAMUT_BOUNDARY_TAGS[intent]: _boundary(mesh),
    }
    offset = HEADER + 4 + 12 * len(tags)
    table, parts = [struct.pack(">I", len(tags))], []
    for signature, data in tags.items():
        table.append(struct.pack(">4sII", signature.encode(), offset, len(data)))
        padded = data + bytes(-len(data) % 4)
        parts.append(padded)
        offset += len(padded)
    content = b"".join((*table, *parts))
    # the digest is of a profile with zeros for flags, intent and digest (ICC.2:2019, 7.2.20)
    blank = _header(offset, 0, bytes(16)) + content
    digest = hashlib.md5(blank, usedforsecurity=False).digest()
    return _header(offset, INTENTS.index(intent), digest) + content


def _header(size: int, intent: int, digest: bytes) -> bytes:
    """Return the header of the profile (ICC.2:2019, 7.2)."""
    head = struct.pack(">I4s4s4s4s4s", size, bytes(4), VERSION, b"abst", b"Lab ", b"Lab ")
    head += CREATED + b"acsp" + bytes(24)  # platform, flags, manufacturer, model, attributes
    head += struct.pack(">I", intent) + D50 + bytes(4) + digest
    return head + bytes(HEADER - len(head))  # neither spectra nor materials


def _text(text: str) -> bytes:
    """Return an element of the type multiLocalizedUnicodeType with one record."""
    data = text.encode("utf-16-be")
    return struct.pack(">4s3I2s2s2I", b"mluc", 0, 1, 12, b"en", b"US", len(data), 28) + data


def _identity() -> bytes:
    """Return an element of the type multiProcessElementsType: one matrix, the identity."""
    matrix = struct.pack(">4sI2H12f", b"matf", 0, 3, 3, *np.eye(3).ravel(), 0.0, 0.0, 0.0)
    return struct.pack(">4sI2H3I", b"mpet", 0, 3, 3, 1, 24, len(matrix)) + matrix


def _boundary(mesh: TriangleMesh) -> bytes:
    """Return an element of the type gamutBoundaryDescType without device values."""
    clockwise = np.ascontiguousarray(mesh.faces[:, ::-1], ">u4")
    vertices = np.ascontiguousarray(mesh.vertices, ">f4")
    counts = struct.pack(">4sI2H2I", b"gbd ", 0, 3, 0, len(vertices), len(clockwise))
    return counts + clockwise.tobytes() + vertices.tobytes()
