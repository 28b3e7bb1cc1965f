"""STL and OBJ, which have little beside the triangles; written by trimesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.colours.spaces.srgb import srgb
from gamutcore.export.ply import comment_lines

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.mesh import TriangleMesh

__all__ = ["obj", "stl"]


def stl(mesh: TriangleMesh, _provenance: Mapping[str, str], _space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as binary STL, which has neither colours nor provenance.

    Parameters
    ----------
    mesh : TriangleMesh

    Returns
    -------
    bytes
    """
    from trimesh.exchange.stl import export_stl  # noqa: PLC0415  # slow; only these formats need it

    exported: bytes = export_stl(mesh.to_trimesh())
    return exported


def obj(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as Wavefront OBJ, with sRGB after each vertex and provenance in comments.

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
    from trimesh.exchange.obj import export_obj  # noqa: PLC0415  # slow; only these formats need it
    from trimesh.visual import ColorVisuals  # noqa: PLC0415

    coloured = mesh.to_trimesh()
    colours = np.rint(srgb(space.appearance_lab(mesh.vertices)) * 255.0).astype(np.uint8)
    coloured.visual = ColorVisuals(coloured, vertex_colors=colours)
    header = "\n# ".join(
        line.encode("ascii", "backslashreplace").decode() for line in comment_lines(provenance)
    )
    exported: str = export_obj(coloured, include_normals=False, digits=12, header=header)
    return exported.encode()
