"""Mesh files: any level in the formats of `FORMATS`; and pictures of sections as SVG.

Positions are the coordinates of the colour space in the space's own order (L*, a*, b*), so clients
can compute with them. Vertex colours, orientation for display and provenance are added in the
formats that have them.
"""

from gamutcore.export.charts import (
    SectionAxes,
    leaf_axes,
    lightness_axes,
    plane_axes,
    rings_svg,
    section_svg,
)
from gamutcore.export.formats import FORMATS, MeshFormat, format_of_suffix, mesh_file

__all__ = [
    "FORMATS",
    "MeshFormat",
    "SectionAxes",
    "format_of_suffix",
    "leaf_axes",
    "lightness_axes",
    "mesh_file",
    "plane_axes",
    "rings_svg",
    "section_svg",
]
