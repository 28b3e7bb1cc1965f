"""Meshes that are a gamut boundary: PLY, glTF, 3MF, Argyll's .gam, ICC's gbd, STL and OBJ.

Each reader checks the sizes in a file against the length of the file, and against the limits of
`meshes.mesh`, before it allocates memory.
"""

from gamutcore.characterisation.meshes.mesh import (
    GAMUT_BOUNDARY_TAGS,
    GamutMesh,
    embedded_boundary,
)

__all__ = ["GAMUT_BOUNDARY_TAGS", "GamutMesh", "embedded_boundary"]
