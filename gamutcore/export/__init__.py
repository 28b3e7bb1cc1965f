"""Mesh files: any level in the formats of `FORMATS`.

Positions are the coordinates of the colour space in the space's own order (L*, a*, b*), so clients
can compute with them. Vertex colours, orientation for display and provenance are added in the
formats that have them.
"""

from gamutcore.export.formats import FORMATS, MeshFormat, format_of_suffix, mesh_file

__all__ = ["FORMATS", "MeshFormat", "format_of_suffix", "mesh_file"]
