"""Meshes that are a gamut boundary: PLY, glTF, 3MF, Argyll's .gam, ICC's gbd, STL and OBJ.

Each reader checks the sizes in a file against the length of the file, and against the limits of
`gamutcore.characterisation.gamut_mesh`, before it allocates memory.
"""

from gamutcore.characterisation.meshes.argyll import argyll_mesh, looks_like_argyll
from gamutcore.characterisation.meshes.gamut_boundary import (
    GAMUT_BOUNDARY_TAGS,
    described_boundary,
)
from gamutcore.characterisation.meshes.gltf import gltf_mesh, looks_like_glb, looks_like_gltf
from gamutcore.characterisation.meshes.ply import looks_like_ply, ply_mesh
from gamutcore.characterisation.meshes.recognition import binary_mesh, text_mesh

__all__ = [
    "GAMUT_BOUNDARY_TAGS",
    "argyll_mesh",
    "binary_mesh",
    "described_boundary",
    "gltf_mesh",
    "looks_like_argyll",
    "looks_like_glb",
    "looks_like_gltf",
    "looks_like_ply",
    "ply_mesh",
    "text_mesh",
]
