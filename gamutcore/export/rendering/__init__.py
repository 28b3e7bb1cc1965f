"""Pictures of a mesh in three dimensions, computed without graphics hardware.

`scene` places the mesh, axes and labels before a fixed camera, `raster` fills triangles with a
depth buffer, and `picture` makes the file.
"""

from gamutcore.export.rendering.picture import (
    BACKGROUNDS,
    DEFAULT_SIZE,
    LARGEST_PICTURE,
    PICTURE_TRIANGLES,
    SMALLEST_PICTURE,
    mesh_picture,
)
from gamutcore.export.rendering.scene import VIEWS

__all__ = [
    "BACKGROUNDS",
    "DEFAULT_SIZE",
    "LARGEST_PICTURE",
    "PICTURE_TRIANGLES",
    "SMALLEST_PICTURE",
    "VIEWS",
    "mesh_picture",
]
