"""Boundaries: closed surfaces around a device's colours, valid and star-shaped from the start."""

from gamutcore.boundary.given_mesh import given_boundary
from gamutcore.boundary.methods import BOUNDARIES, wrapped
from gamutcore.boundary.modified_convex_hull import Boundary, modified_convex_hull
from gamutcore.boundary.segment_maxima import segment_maxima
from gamutcore.boundary.sources import vertex_device_values
from gamutcore.boundary.usv import usv

__all__ = [
    "BOUNDARIES",
    "Boundary",
    "given_boundary",
    "modified_convex_hull",
    "segment_maxima",
    "usv",
    "vertex_device_values",
    "wrapped",
]
