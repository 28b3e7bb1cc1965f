"""Boundaries: closed surfaces around a device's colours, valid and star-shaped from the start."""

from gamutcore.boundary.modified_convex_hull import Boundary, modified_convex_hull

__all__ = ["Boundary", "modified_convex_hull"]
