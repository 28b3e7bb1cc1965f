"""Boundaries: closed, valid surfaces around the colours of a device, star-shaped about a centre."""

from gamutcore.boundary.device_surface import device_surface_boundary
from gamutcore.boundary.mesh_boundary import mesh_boundary
from gamutcore.boundary.methods import BOUNDARIES, compute_boundary
from gamutcore.boundary.modified_convex_hull import Boundary, modified_convex_hull
from gamutcore.boundary.segment_maxima import segment_maxima
from gamutcore.boundary.sources import vertex_device_values
from gamutcore.boundary.usv import usv
from gamutcore.boundary.wrapping import wrap_colours

__all__ = [
    "BOUNDARIES",
    "Boundary",
    "compute_boundary",
    "device_surface_boundary",
    "mesh_boundary",
    "modified_convex_hull",
    "segment_maxima",
    "usv",
    "vertex_device_values",
    "wrap_colours",
]
