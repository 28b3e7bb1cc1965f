"""Boundaries: closed, valid surfaces around the colours of a device, star-shaped about a centre."""

from gamutcore.boundary.device_surface import device_surface_boundary
from gamutcore.boundary.mesh_boundary import mesh_boundary, mesh_vertices
from gamutcore.boundary.methods import BOUNDARIES, compute_boundary, vertex_device_values
from gamutcore.boundary.modified_convex_hull import GAMMA, Boundary, modified_convex_hull
from gamutcore.boundary.radial_envelope import radial_map
from gamutcore.boundary.spherical_segments import (
    BASIS,
    SEGMENT_COUNTS,
    SUBDIVISIONS,
    segment_maxima,
    usv,
)
from gamutcore.boundary.wrapping import Wrapping, raise_wrapping, wrap_colours

__all__ = [
    "BASIS",
    "BOUNDARIES",
    "GAMMA",
    "SEGMENT_COUNTS",
    "SUBDIVISIONS",
    "Boundary",
    "Wrapping",
    "compute_boundary",
    "device_surface_boundary",
    "mesh_boundary",
    "mesh_vertices",
    "modified_convex_hull",
    "radial_map",
    "raise_wrapping",
    "segment_maxima",
    "usv",
    "vertex_device_values",
    "wrap_colours",
]
