"""PLY (Turk, Stanford 1994), binary little-endian: x y z, red green blue, vertex_indices.

The colours are 8-bit sRGB, as PLY readers expect. The provenance is in comments. Device values are
one float property per channel after the colours, with the name of the channel in a comment.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces import CIELAB, ColourSpace, srgb
from gamutcore.export.device_properties import property_names
from gamutcore.geometry import imported_trimesh
from gamutcore.version import __version__

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.geometry import TriangleMesh

__all__ = ["comment_lines", "ply"]


def ply(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as binary PLY."""
    export_ply = imported_trimesh().exchange.ply.export_ply
    colours = np.rint(srgb(space.appearance_lab(mesh.vertices)) * 255.0).astype(np.uint8)
    coloured = mesh.to_trimesh()
    for channel, name in enumerate(("red", "green", "blue")):
        coloured.vertex_attributes[name] = colours[:, channel]
    facts = dict(provenance)
    if mesh.device is not None:
        for channel, name in enumerate(property_names(mesh.device.channels)):
            values = mesh.device.values[:, channel].astype(np.float32)
            coloured.vertex_attributes[name] = values
            facts[name] = mesh.device.channels[channel]
    exported: bytes = export_ply(coloured, encoding="binary", vertex_normal=False)
    head, comment, rest = exported.partition(b"comment https://github.com/mikedh/trimesh\n")
    if not comment:  # insert after the line that names the encoding
        head, end, rest = exported.partition(b"1.0\n")
        head += end
    lines = "".join(f"comment {line}\n" for line in comment_lines(facts))
    lines = lines.replace("end_header", "end-header")  # trimesh ends the header at this word
    return head + lines.encode("ascii", "backslashreplace") + rest


def comment_lines(provenance: Mapping[str, str]) -> list[str]:
    """Return provenance as lines of text, one per entry, without line breaks."""
    entries = {"generator": f"gamutcore {__version__}", **provenance}
    return [" ".join(f"{name}: {value}".split()) for name, value in entries.items()]
