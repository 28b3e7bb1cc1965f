"""Boundaries: closed, valid surfaces around the colours of a device, star-shaped about a centre."""

from gamutcore.boundary.device_surface import device_surface_boundary
from gamutcore.boundary.mesh_boundary import mesh_boundary, mesh_vertices
from gamutcore.boundary.methods import BOUNDARIES, compute_boundary, vertex_device_values
from gamutcore.boundary.modified_convex_hull import GAMMA, Boundary, modified_convex_hull
from gamutcore.boundary.published import (
    BASIS,
    SEGMENT_COUNTS,
    SUBDIVISIONS,
    VoxelMismatch,
    segment_maxima,
    usv,
    voxel_mismatch,
)
from gamutcore.boundary.radial_envelope import radial_map
from gamutcore.boundary.wrapping import Wrapping, raise_wrapping, wrap_colours

__all__ = [
    "BASIS",
    "BOUNDARIES",
    "GAMMA",
    "SEGMENT_COUNTS",
    "SUBDIVISIONS",
    "Boundary",
    "VoxelMismatch",
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
    "voxel_mismatch",
    "wrap_colours",
]
