"""Meshes that are a gamut boundary: PLY, glTF, 3MF, Argyll's .gam, ICC's gbd, STL and OBJ.

`binary_mesh` and `text_mesh` recognise a format by its content. Each reader checks the sizes in a
file against the length of the file, and against the limits of `meshes.mesh`, before it allocates
memory.
"""

from __future__ import annotations

from gamutcore.characterisation.meshes.gamut_surfaces import (
    GAMUT_BOUNDARY_TAGS,
    argyll_mesh,
    described_boundary,
    looks_like_argyll,
)
from gamutcore.characterisation.meshes.gltf import gltf_mesh, looks_like_glb, looks_like_gltf
from gamutcore.characterisation.meshes.mesh import GamutMesh
from gamutcore.characterisation.meshes.ply import looks_like_ply, ply_mesh
from gamutcore.characterisation.meshes.triangle_files import (
    looks_like_obj,
    looks_like_stl,
    looks_like_threemf,
    obj_mesh,
    stl_mesh,
    threemf_mesh,
)

__all__ = [
    "GAMUT_BOUNDARY_TAGS",
    "GamutMesh",
    "binary_mesh",
    "described_boundary",
    "text_mesh",
]


_BINARY = (
    (looks_like_ply, ply_mesh),
    (looks_like_glb, gltf_mesh),
    (looks_like_threemf, threemf_mesh),
    (looks_like_stl, stl_mesh),
)


def binary_mesh(data: bytes) -> GamutMesh | None:
    """Return the mesh in a binary file; None if the format is not PLY, GLB, 3MF or STL."""
    return next((read(data) for is_format, read in _BINARY if is_format(data)), None)


def text_mesh(text: str) -> GamutMesh | None:
    """Return the mesh in a decoded text; None if the format is not glTF, Argyll's or OBJ."""
    if looks_like_gltf(text):
        return gltf_mesh(text.encode())
    if looks_like_argyll(text):
        return argyll_mesh(text)
    data = text.encode("utf-8", "replace")
    return obj_mesh(data) if looks_like_obj(data) else None
