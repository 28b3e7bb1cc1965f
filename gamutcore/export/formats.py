"""The file formats that meshes are written in: the one list for all interfaces and documents."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.errors import OptionError
from gamutcore.export.colour_management import cge, gam, icc, icc_with_boundary
from gamutcore.export.gltf import glb, gltf
from gamutcore.export.triangle_files import obj, ply, stl, threemf
from gamutcore.geometry import TriangleMesh

__all__ = ["FORMATS", "MeshFormat", "format_of_suffix", "mesh_file"]


@dataclass(frozen=True)
class MeshFormat:
    """A file format for meshes.

    Attributes
    ----------
    name : str
        Value of the parameter ``format``.
    media_type : str
    encode : callable
        (mesh, provenance, space) → bytes. Raises `OptionError` for meshes that the format cannot
        hold.
    content : str
        What a file has, for documents.
    readers : str
        Programs that read it, for documents.
    full : bool
        Whether files are made from the full boundary, unless a count or a limit is asked for.
    """

    name: str
    media_type: str
    encode: Callable[[TriangleMesh, Mapping[str, str], ColourSpace], bytes]
    content: str
    readers: str
    full: bool = False

    @property
    def suffix(self) -> str:
        """The suffix of files, with the dot."""
        return f".{self.name}"


_IN_CIELAB = "gamuts in CIELAB: "

FORMATS: dict[str, MeshFormat] = {
    mesh_format.name: mesh_format
    for mesh_format in (
        MeshFormat(
            "glb",
            "model/gltf-binary",
            glb,
            "triangles, colours, device values, provenance; lightness upwards",
            "browsers (three.js, model-viewer), Blender, Windows 3D Viewer, trimesh",
        ),
        MeshFormat(
            "gltf",
            "model/gltf+json",
            gltf,
            "as GLB, in one JSON document",
            "as GLB",
        ),
        MeshFormat(
            "ply",
            "application/ply",
            ply,
            "triangles, colours, device values, provenance",
            "MeshLab, Blender, CloudCompare, trimesh, Open3D, meshio",
        ),
        MeshFormat(
            "stl",
            "model/stl",
            stl,
            "triangles only",
            "CAD programs and slicers for 3-D printers",
        ),
        MeshFormat(
            "obj",
            "model/obj",
            obj,
            "triangles, colours as `#MRGB`, provenance",
            "Blender, ZBrush, nearly all 3-D programs",
        ),
        MeshFormat(
            "3mf",
            "model/3mf",
            threemf,
            "triangles, colours, provenance; lightness upwards, the white 100 mm high",
            "slicers for 3-D printers, Windows 3D Viewer, Blender, lib3mf",
        ),
        MeshFormat(
            "gam",
            "application/x-argyll-gam",
            gam,
            _IN_CIELAB + "triangles, centre, white, black, cusps",
            "Argyll CMS: viewgam, colprof, collink, tiffgamut",
        ),
        MeshFormat(
            "icc",
            "application/vnd.iccprofile",
            icc,
            _IN_CIELAB + "triangles as a gamut boundary description in an abstract profile",
            "iccMAX software: iccDEV",
        ),
        MeshFormat(
            "cge",
            "application/x-idms-cge",
            cge,
            _IN_CIELAB + r"R, G, B, X, Y, Z, L\*, a\*, b\* of 602 points of the device's cube",
            "CIELab Gamut Tools and other software for IDMS",
            full=True,
        ),
    )
}
"""All formats by name, the preferred one first."""


def mesh_file(
    mesh: TriangleMesh,
    format_name: str,
    provenance: Mapping[str, str] | None = None,
    space: ColourSpace = CIELAB,
    into: bytes | None = None,
) -> bytes:
    """Return a mesh as a file.

    Parameters
    ----------
    mesh : TriangleMesh
        In the coordinates of `space`.
    format_name : str
        A key of `FORMATS`.
    provenance : mapping of str to str, optional
        Origin of the mesh, for the formats that have a place for it.
    space : ColourSpace, optional
        Determines the vertex colours and the upward direction.
    into : bytes, optional
        ICC profile of version 5 that the mesh becomes the gamut boundary of, for ``icc``.

    Returns
    -------
    bytes

    Raises
    ------
    OptionError
        There is no such format, or it cannot hold the mesh, or the profile has another version or
        other channels.
    MalformedProfileError, UnsupportedProfileError
        The profile is damaged, or is not of a device.
    """
    mesh_format = FORMATS.get(format_name)
    if mesh_format is None:
        raise OptionError(
            f"There is no mesh format {format_name!r}.",
            where={"field": "format"},
            remedy=f"Give one of {', '.join(FORMATS)}.",
        )
    if into is None:
        return mesh_format.encode(mesh, provenance or {}, space)
    if format_name != "icc":
        raise OptionError(
            f"into does not apply: the format {format_name} is no profile.",
            where={"field": "into"},
            remedy="Give the format icc, or leave it out.",
        )
    return icc_with_boundary(mesh, provenance or {}, space, into)


def format_of_suffix(suffix: str) -> MeshFormat:
    """Return the format that files with a suffix have.

    Parameters
    ----------
    suffix : str
        With the dot, in any case.

    Raises
    ------
    OptionError
        There is no such format.
    """
    known = {each.suffix: each for each in FORMATS.values()}
    if suffix.lower() not in known:
        raise OptionError(
            f"There is no mesh format with the suffix {suffix!r}.",
            where={"field": "path"},
            remedy=f"Give a name that ends in one of {', '.join(known)}.",
        )
    return known[suffix.lower()]
