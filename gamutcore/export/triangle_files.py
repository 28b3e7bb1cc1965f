"""STL and OBJ, which have little beside the triangles; written by trimesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces import CIELAB, ColourSpace, srgb
from gamutcore.export.ply import comment_lines
from gamutcore.geometry import imported_trimesh

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.geometry import TriangleMesh

__all__ = ["obj", "stl"]


def stl(mesh: TriangleMesh, _provenance: Mapping[str, str], _space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as binary STL, which has neither colours nor provenance."""
    exported: bytes = imported_trimesh().exchange.stl.export_stl(mesh.to_trimesh())
    return exported


def obj(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as Wavefront OBJ, with sRGB and provenance in comments.

    The colours are lines ``#MRGB`` as ZBrush writes them, which Blender reads. Colours behind the
    positions would be extra coordinates to other readers, such as meshio.
    """
    export_obj = imported_trimesh().exchange.obj.export_obj
    colours = np.rint(srgb(space.appearance_lab(mesh.vertices)) * 255.0).astype(np.uint8)
    header = "\n# ".join(
        line.encode("ascii", "backslashreplace").decode() for line in comment_lines(provenance)
    )
    exported: str = export_obj(mesh.to_trimesh(), include_normals=False, digits=12, header=header)
    vertices, first_face, faces = exported.partition("\nf ")
    return f"{vertices}\n{_polypaint(colours)}{first_face[1:]}{faces}".encode()


def _polypaint(colours: np.ndarray) -> str:
    """Return lines of vertex colours: ``#MRGB`` and 64 times mask, red, green and blue in hex."""
    words = [f"ff{red:02x}{green:02x}{blue:02x}" for red, green, blue in colours.tolist()]
    return "".join(
        f"#MRGB {''.join(words[start : start + 64])}\n" for start in range(0, len(words), 64)
    )
