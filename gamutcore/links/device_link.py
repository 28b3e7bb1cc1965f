"""ICC device links: profiles of the class ``link``, in version 2, which every engine reads.

The table is in the tag A2B0, of the type lut16Type with identities for its matrix and curves.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from gamutcore.export.icc_file import (
    COPYRIGHT,
    data_space,
    description_element,
    icc_file,
    lut16_element,
    text_element,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gamutcore.arrays import FloatArray

__all__ = ["device_link_file"]


def device_link_file(
    description: str, devices: Sequence[tuple[str, Sequence[str]]], intent: str, nodes: FloatArray
) -> bytes:
    """Return the profile of nodes (n, …, n, k), n up to 255, from device values to others, 0 to 1.

    `devices` has the names of the source and the destination, and those of their channels, up to
    15. Characters outside ASCII become question marks.
    """
    tags = {
        "desc": description_element(description, 2),
        "cprt": text_element(COPYRIGHT),
        "pseq": _sequence([name for name, _ in devices]),
        "A2B0": lut16_element(nodes),
    }
    source, destination = (data_space(channels) for _, channels in devices)
    return icc_file(2, "link", (source, destination), tags, intent)


def _sequence(devices: Sequence[str]) -> bytes:
    """Return an element of the type profileSequenceDescType (ICC.1:2001-04, 6.5.12).

    A name stands for the model. Manufacturer, model, attributes and technology are unknown.
    """
    unknown = bytes(4 + 4 + 8 + 4) + description_element("", 2)
    entries = [unknown + description_element(name, 2) for name in devices]
    return b"pseq" + bytes(4) + struct.pack(">I", len(entries)) + b"".join(entries)
