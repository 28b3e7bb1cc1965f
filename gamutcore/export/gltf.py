"""glTF 2.0 (Khronos Group; ISO/IEC 12113), as one binary file or as JSON with embedded buffers.

trimesh writes the structure; what it has no words for is put into the tree before it is serialised:
a node rotation that shows lightness upwards, vertex colours that are linear and need no light
(COLOR_0 as 16-bit integers, KHR_materials_unlit), and the provenance in ``asset.extras``. Device
values are application-specific attributes, a scalar for each channel, whose names the mesh's
``extras`` translate.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gamutcore.colours.appearance import linear_srgb
from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.export.device_properties import property_names
from gamutcore.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from gamutcore.mesh import TriangleMesh

__all__ = ["glb", "gltf"]


def glb(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as binary glTF.

    Parameters
    ----------
    mesh : TriangleMesh
        In the coordinates of `space`.
    provenance : mapping of str to str
    space : ColourSpace, optional

    Returns
    -------
    bytes
    """
    from trimesh.exchange.gltf import export_glb  # noqa: PLC0415  # heavy, for exchange alone

    exported: bytes = export_glb(
        _scene(mesh, space),
        include_normals=False,
        tree_postprocessor=_finish(mesh, provenance, space),
    )
    return exported


def gltf(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as JSON glTF with its buffers embedded as data URIs; parameters as `glb`."""
    from trimesh.exchange.gltf import export_gltf  # noqa: PLC0415  # heavy, for exchange alone

    files: dict[str, bytes] = export_gltf(
        _scene(mesh, space),
        include_normals=False,
        merge_buffers=True,
        embed_buffers=True,
        tree_postprocessor=_finish(mesh, provenance, space),
    )
    return files["model.gltf"]


def _scene(mesh: TriangleMesh, space: ColourSpace) -> Any:  # noqa: ANN401  # trimesh has no type stubs
    import trimesh  # noqa: PLC0415

    colours = np.full((len(mesh.vertices), 4), 65535, np.uint16)
    colours[:, :3] = np.rint(linear_srgb(space.appearance_lab(mesh.vertices)) * 65535.0)
    coloured = mesh.to_trimesh()
    coloured.vertex_attributes["COLOR"] = colours
    if mesh.device is not None:
        for index, name in enumerate(_attribute_names(mesh)):
            values = mesh.device.values[:, index].astype(np.float32)
            coloured.vertex_attributes[name] = values
    return trimesh.Scene({"gamut": coloured})


def _attribute_names(mesh: TriangleMesh) -> list[str]:
    # The standard wants an underscore in front, and by its own example capitals.
    channels = () if mesh.device is None else mesh.device.channels
    return [f"_{name.upper()}" for name in property_names(channels)]


def _finish(
    mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace
) -> Callable[[dict[str, Any]], None]:
    """Return what completes trimesh's tree."""

    def complete(tree: dict[str, Any]) -> None:
        tree["asset"]["generator"] = f"gamutcore {__version__}"
        if provenance:
            tree["asset"]["extras"] = dict(provenance)
        (primitive,) = tree["meshes"][0]["primitives"]
        attributes = primitive["attributes"]
        colour = attributes.pop("_COLOR")
        attributes["COLOR_0"] = colour
        if mesh.device is not None:
            # JSON has no place for halves of surrogate pairs
            channels = [name.encode("utf-8", "replace").decode() for name in mesh.device.channels]
            names = dict(zip(_attribute_names(mesh), channels, strict=True))
            tree["meshes"][0].setdefault("extras", {})["device_channels"] = names
        tree["accessors"][colour]["normalized"] = True
        tree["materials"] = [
            {
                "name": "appearance",
                "extensions": {"KHR_materials_unlit": {}},
                "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 1.0},
            }
        ]
        primitive["material"] = 0
        tree["extensionsUsed"] = ["KHR_materials_unlit"]
        for node in tree["nodes"]:
            if "mesh" in node:
                node.pop("matrix", None)
                node["rotation"] = list(space.rotation)

    return complete
