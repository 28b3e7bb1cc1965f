"""Metrics: what two gamuts have in common and how far they are apart."""

from gamutcore.metric.mismatch import intersection_volume, mismatch
from gamutcore.metric.voxel_mismatch import VoxelMismatch, voxel_mismatch

__all__ = ["VoxelMismatch", "intersection_volume", "mismatch", "voxel_mismatch"]
