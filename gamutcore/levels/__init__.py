"""Levels: their errors, the smallest within limits, and those on one side; mismatch of gamuts."""

from gamutcore.levels.error_curve import LevelError, curve_counts, error_curve, round_up
from gamutcore.levels.overlay import Distances, RadialDifference, radial_difference
from gamutcore.levels.search import NO_ERROR, BoundedLevel, Bounds, LevelSearch, error_bounds
from gamutcore.levels.sides import SIDES, Side, SidedSearch, sided_level
from gamutcore.levels.volume_difference import (
    VoxelMismatch,
    intersection_volume,
    mismatch,
    voxel_mismatch,
)

__all__ = [
    "NO_ERROR",
    "SIDES",
    "BoundedLevel",
    "Bounds",
    "Distances",
    "LevelError",
    "LevelSearch",
    "RadialDifference",
    "Side",
    "SidedSearch",
    "VoxelMismatch",
    "curve_counts",
    "error_bounds",
    "error_curve",
    "intersection_volume",
    "mismatch",
    "radial_difference",
    "round_up",
    "sided_level",
    "voxel_mismatch",
]
