"""Metrics: common volume, mismatch and distances of two gamuts."""

from gamutcore.metric.mismatch import intersection_volume, mismatch
from gamutcore.metric.radial_overlay import Distances, RadialDifference, radial_difference
from gamutcore.metric.voxel_mismatch import VoxelMismatch, voxel_mismatch

__all__ = [
    "Distances",
    "RadialDifference",
    "VoxelMismatch",
    "intersection_volume",
    "mismatch",
    "radial_difference",
    "voxel_mismatch",
]
