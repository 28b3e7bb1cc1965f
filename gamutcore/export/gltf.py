"""glTF 2.0 (Khronos Group; ISO/IEC 12113), as one binary file or as JSON with embedded buffers.

The structure is always the same, so it is written here, in a fifth of the time of trimesh's
exporter. A node has one mesh of one primitive, and its rotation shows lightness upwards. Vertex
colours are linear and unlit (COLOR_0 as 16-bit integers, KHR_materials_unlit). The provenance is in
``asset.extras``. Device values are one scalar attribute for each channel; the mesh's ``extras``
have the names. Clauses are those of the glTF 2.0 specification.
"""

from __future__ import annotations

import base64
import json
import struct
from typing import TYPE_CHECKING, Any

import numpy as np

from gamutcore.colours.spaces import CIELAB, ColourSpace, linear_srgb
from gamutcore.export.provenance import property_names
from gamutcore.version import __version__

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from gamutcore.geometry import TriangleMesh

__all__ = ["glb", "gltf"]

_UNSIGNED_SHORT, _UNSIGNED_INT, _FLOAT = 5123, 5125, 5126
"""Component types, clause 3.6.2.2."""

_TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
"""Element types by their number of components, clause 3.6.2.3."""

_MATERIAL = {
    "name": "appearance",
    "extensions": {"KHR_materials_unlit": {}},
    "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 1.0},
}


def glb(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as binary glTF: a header and two chunks (clause 4.4)."""
    asset, content = _asset(mesh, provenance, space)
    asset["buffers"] = [{"byteLength": len(content)}]
    text = _json(asset)
    text += b" " * (-len(text) % 4)  # chunks are padded to multiples of 4, JSON with spaces
    length = 12 + 8 + len(text) + 8 + len(content)
    return b"".join(
        (
            struct.pack("<4sII", b"glTF", 2, length),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(content), b"BIN\0"),
            content,
        )
    )


def gltf(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as JSON glTF with its buffer embedded as a data URI."""
    asset, content = _asset(mesh, provenance, space)
    address = "data:application/octet-stream;base64," + base64.b64encode(content).decode("ascii")
    asset["buffers"] = [{"uri": address, "byteLength": len(content)}]
    return _json(asset)


def _json(asset: dict[str, Any]) -> bytes:
    return json.dumps(asset, separators=(",", ":"), allow_nan=False).encode("ascii")


class _Buffer:
    """The binary content, and the accessors of its parts.

    All components have four bytes, or eight per vertex, so all are aligned (clause 3.6.2.4).
    """

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []
        self.size = 0

    def add(self, values: NDArray[Any], component: int, *, normalized: bool = False) -> int:
        """Append an array of one row or number per element; return the index of its accessor."""
        part = values.tobytes()
        most, least = values.max(axis=0).tolist(), values.min(axis=0).tolist()
        accessor: dict[str, Any] = {
            "componentType": component,
            "type": _TYPES[1 if values.ndim == 1 else values.shape[1]],
            "bufferView": len(self.views),
            "count": len(values),
            "max": [most] if values.ndim == 1 else most,
            "min": [least] if values.ndim == 1 else least,
        }
        if normalized:
            accessor["normalized"] = True
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": len(part)})
        self.accessors.append(accessor)
        self.parts.append(part)
        self.size += len(part)
        return len(self.accessors) - 1


def _asset(
    mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace
) -> tuple[dict[str, Any], bytes]:
    """JSON of an asset without its buffer, and the buffer's content."""
    buffer = _Buffer()
    indices = buffer.add(mesh.faces.astype("<u4", copy=False).reshape(-1), _UNSIGNED_INT)
    attributes = {"POSITION": buffer.add(mesh.vertices.astype("<f4", copy=False), _FLOAT)}
    colours = np.full((len(mesh.vertices), 4), 65535, "<u2")
    colours[:, :3] = np.rint(linear_srgb(space.appearance_lab(mesh.vertices)) * 65535.0)
    attributes["COLOR_0"] = buffer.add(colours, _UNSIGNED_SHORT, normalized=True)
    extras: dict[str, Any] = {}
    if mesh.device is not None:
        # the standard requires an underscore in front; its examples are in capitals
        names = [f"_{name.upper()}" for name in property_names(mesh.device.channels)]
        for name, values in zip(names, mesh.device.values.T.astype("<f4"), strict=True):
            attributes[name] = buffer.add(values, _FLOAT)
        # JSON cannot have lone surrogates
        channels = [name.encode("utf-8", "replace").decode() for name in mesh.device.channels]
        extras["device_channels"] = dict(zip(names, channels, strict=True))
    asset: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": f"gamutcore {__version__}"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "gamut", "mesh": 0, "rotation": list(space.rotation)}],
        # mode 4 is triangles, clause 3.7.2.1
        "meshes": [
            {
                "name": "gamut",
                "primitives": [
                    {"attributes": attributes, "indices": indices, "mode": 4, "material": 0}
                ],
            }
        ],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "materials": [_MATERIAL],
        "extensionsUsed": ["KHR_materials_unlit"],
    }
    if provenance:
        asset["asset"]["extras"] = dict(provenance)
    if extras:
        asset["meshes"][0]["extras"] = extras
    return asset, b"".join(buffer.parts)
