"""The volume within triangles that may cross, by rays from a centre.

The radial envelope of triangles is the outermost of their points in each direction. Rays through
the pixels of a cube around the centre sample it: each triangle is drawn on the sides of the cube,
and each pixel keeps the largest radius.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["COARSE", "FINE", "RadialVolume", "radial_volume"]

FINE = 256
"""Pixels along an edge of the cube for volumes. The volumes of real devices differ by 0.0005 % from
those with twice as many."""

COARSE = 64
"""Pixels for comparisons of centres, and for whether triangles surround a centre."""


class RadialVolume(NamedTuple):
    """The size of a radial envelope.

    Attributes
    ----------
    volume : float
        ∫ r³ ÷ 3 over all directions; directions without a triangle count as 0.
    uncovered : float
        Share of the rays that meet no triangle. The triangles surround the centre if it is 0.
    depth : float
        Smallest radius; 0 if a ray meets no triangle.
    """

    volume: float
    uncovered: float
    depth: float


@kernel
def radial_volume(
    points: FloatArray, faces: IndexArray, centre: FloatArray, pixels: int
) -> RadialVolume:
    """Return the volume of the radial envelope of triangles in any orientation.

    `pixels` is the number along an edge of the cube: `FINE` or `COARSE`.
    """
    radius = np.zeros((6, pixels, pixels))
    corners = np.empty((3, 3))
    for face in range(len(faces)):
        for place in range(3):
            for axis in range(3):
                corners[place, axis] = points[faces[face, place], axis] - centre[axis]
        for side in range(6):
            _draw(radius, side, corners)
    volume, uncovered, depth = 0.0, 0, np.inf
    for side in range(6):
        for row in range(pixels):
            u = (row + 0.5) * 2.0 / pixels - 1.0
            for column in range(pixels):
                v = (column + 0.5) * 2.0 / pixels - 1.0
                along = radius[side, row, column]
                volume += along**3
                uncovered += along == 0.0
                depth = min(depth, along * np.sqrt(1.0 + u * u + v * v))
    rays = 6.0 * pixels * pixels
    # for a direction (1, u, v) scaled by t, the volume is ∫ t³ ÷ 3 du dv
    return RadialVolume(volume / 3.0 * (2.0 / pixels) ** 2, uncovered / rays, depth)


@leaf_kernel
def _draw(radius: FloatArray, side: int, corners: FloatArray) -> None:
    """Raise the radii of the pixels of a side of the cube that a triangle covers.

    Radii are in units of (1, u, v). `corners` are relative to the centre, one per row.
    """
    axis, sign = side // 2, -1.0 if side % 2 == 0 else 1.0
    aw, bw, cw = sign * corners[0, axis], sign * corners[1, axis], sign * corners[2, axis]
    if aw <= 0.0 and bw <= 0.0 and cw <= 0.0:
        return
    second, third = (axis + 1) % 3, (axis + 2) % 3
    au, av = corners[0, second], corners[0, third]
    bu, bv = corners[1, second], corners[1, third]
    cu, cv = corners[2, second], corners[2, third]
    if (
        (au > aw and bu > bw and cu > cw)
        or (-au > aw and -bu > bw and -cu > cw)
        or (av > aw and bv > bw and cv > cw)
        or (-av > aw and -bv > bw and -cv > cw)
    ):
        return
    pixels = radius.shape[1]
    first_row, last_row, first_column, last_column = 0, pixels - 1, 0, pixels - 1
    if aw > 0.0 and bw > 0.0 and cw > 0.0:  # otherwise the triangle is seen under a wide angle
        first_row, last_row = _pixels(au / aw, bu / bw, cu / cw, pixels)
        first_column, last_column = _pixels(av / aw, bv / bw, cv / cw, pixels)
    # the planes through the centre and the edges; triangles that share an edge have exactly
    # opposite ones, so that no ray passes between them
    ab_w, ab_u, ab_v = au * bv - av * bu, av * bw - aw * bv, aw * bu - au * bw
    bc_w, bc_u, bc_v = bu * cv - bv * cu, bv * cw - bw * cv, bw * cu - bu * cw
    ca_w, ca_u, ca_v = cu * av - cv * au, cv * aw - cw * av, cw * au - cu * aw
    height = aw * bc_w + au * bc_u + av * bc_v
    if height == 0.0:
        return
    for row in range(first_row, last_row + 1):
        u = (row + 0.5) * 2.0 / pixels - 1.0
        for column in range(first_column, last_column + 1):
            v = (column + 0.5) * 2.0 / pixels - 1.0
            ab = ab_w + ab_u * u + ab_v * v
            bc = bc_w + bc_u * u + bc_v * v
            ca = ca_w + ca_u * u + ca_v * v
            along = ab + bc + ca
            if (
                (height > 0.0 and min(ab, bc, ca) >= 0.0)
                or (height < 0.0 and max(ab, bc, ca) <= 0.0)
            ) and height / along > radius[side, row, column]:
                radius[side, row, column] = height / along


@leaf_kernel
def _pixels(one: float, two: float, three: float, pixels: int) -> tuple[int, int]:
    """First and last pixel whose middle is between the least and the largest coordinate."""
    low, high = min(one, two, three), max(one, two, three)
    first = np.ceil((max(low, -1.0) + 1.0) / 2.0 * pixels - 0.5)
    last = np.floor((min(high, 1.0) + 1.0) / 2.0 * pixels - 0.5)
    return max(int(first), 0), min(int(last), pixels - 1)
