"""Mesh files: any level as glTF, PLY, STL or OBJ; and pictures of sections as SVG.

Positions are the coordinates of the colour space in the space's own order (L*, a*, b*), so clients
can compute with them. Vertex colours, orientation for display and provenance are added in the
formats that have them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.errors import OptionError
from gamutcore.export.argyll import gam
from gamutcore.export.gltf import glb, gltf
from gamutcore.export.icc_boundary import icc
from gamutcore.export.ply import ply
from gamutcore.export.section_svg import (
    SectionAxes,
    leaf_axes,
    lightness_axes,
    plane_axes,
    rings_svg,
    section_svg,
)
from gamutcore.export.triangle_files import obj, stl
from gamutcore.mesh import TriangleMesh

__all__ = [
    "FORMATS",
    "MeshFormat",
    "SectionAxes",
    "leaf_axes",
    "lightness_axes",
    "mesh_file",
    "plane_axes",
    "rings_svg",
    "section_svg",
]


@dataclass(frozen=True)
class MeshFormat:
    """A file format for meshes.

    Attributes
    ----------
    name : str
        Value of the parameter ``format``.
    media_type : str
    suffix : str
        With the dot.
    encode : callable
        (mesh, provenance, space) → bytes.
    """

    name: str
    media_type: str
    suffix: str
    encode: Callable[[TriangleMesh, Mapping[str, str], ColourSpace], bytes]


FORMATS: dict[str, MeshFormat] = {
    mesh_format.name: mesh_format
    for mesh_format in (
        MeshFormat("glb", "model/gltf-binary", ".glb", glb),
        MeshFormat("gltf", "model/gltf+json", ".gltf", gltf),
        MeshFormat("ply", "application/ply", ".ply", ply),
        MeshFormat("stl", "model/stl", ".stl", stl),
        MeshFormat("obj", "model/obj", ".obj", obj),
        MeshFormat("gam", "application/x-argyll-gam", ".gam", gam),
        MeshFormat("icc", "application/vnd.iccprofile", ".icc", icc),
    )
}
"""All formats by name, the preferred one first."""


def mesh_file(
    mesh: TriangleMesh,
    format_name: str,
    provenance: Mapping[str, str] | None = None,
    space: ColourSpace = CIELAB,
) -> bytes:
    """Return a mesh as a file.

    Parameters
    ----------
    mesh : TriangleMesh
        In the coordinates of `space`.
    format_name : str
        A key of `FORMATS`.
    provenance : mapping of str to str, optional
        Origin of the mesh; kept in glTF, PLY and OBJ.
    space : ColourSpace, optional
        Determines the vertex colours and the upward direction.

    Returns
    -------
    bytes

    Raises
    ------
    OptionError
        There is no such format.
    """
    mesh_format = FORMATS.get(format_name)
    if mesh_format is None:
        raise OptionError(
            f"There is no mesh format {format_name!r}.",
            where={"field": "format"},
            remedy=f"Give one of {', '.join(FORMATS)}.",
        )
    return mesh_format.encode(mesh, provenance or {}, space)
