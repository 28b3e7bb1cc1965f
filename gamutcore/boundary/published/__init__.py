"""Methods of the literature beside the modified convex hull, each with its paper.

Two boundaries, by segment maxima and by uniform segments (USV), and the mismatch of two gamuts in
voxels. Published figures are compared with theirs.
"""

from gamutcore.boundary.published.segment_maxima import SEGMENT_COUNTS, SEGMENTS, segment_maxima
from gamutcore.boundary.published.usv import BASIS, SUBDIVISIONS, usv
from gamutcore.boundary.published.voxel_mismatch import VoxelMismatch, voxel_mismatch

__all__ = [
    "BASIS",
    "SEGMENTS",
    "SEGMENT_COUNTS",
    "SUBDIVISIONS",
    "VoxelMismatch",
    "segment_maxima",
    "usv",
    "voxel_mismatch",
]
