"""The point of a surface's star-kernel that is deepest inside of all faces.

A face sees the points of a half-space from inside. The points that all faces see form a convex
body. Geometry calls it the kernel of a star-shaped body. Here it is the star-kernel, because a
kernel is a compiled function in this project. The deepest point is the centre of the largest ball
in the body (Chebyshev centre), a linear programme in four unknowns.

The dual simplex method solves it: four planes determine a point, and the plane that is violated
most replaces one of the four (Dantzig, "Linear Programming and Extensions", 1963).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.kernels import kernel

__all__ = ["Planes", "StarKernelPoint", "face_planes", "star_kernel_point"]

MAX_EXCHANGES = 2000
"""Largest number of exchanged planes. Real gamuts need 10 to 100."""

GAP = 1e-4
"""Relative difference to the largest margin at which the search ends. Thousands of faces are almost
equally far from the middle of a ball."""

TOLERANCE = 1e-9
"""The same for margins near zero, relative to the extent of the surface."""

FAR_PLANES = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / np.sqrt(3)
"""Normals of a regular tetrahedron around the surface, where the search starts."""

FAR = 4.0
"""Distance of these planes from the middle, in extents of the surface."""


class Planes(NamedTuple):
    """Planes of faces: the inside of face i has ``normals[i] @ point <= offsets[i]``.

    Attributes
    ----------
    normals : (n, 3) float64
        Unit vectors. Zero for a face without area.
    offsets : (n,) float64
        Infinite for a face without area.
    areas : (n,) float64
    """

    normals: FloatArray
    offsets: FloatArray
    areas: FloatArray


class StarKernelPoint(NamedTuple):
    """A point well inside the star-kernel, or the proof that the star-kernel is empty.

    Attributes
    ----------
    point : (3,) float
    margin : float
        Distance of the point from the nearest plane of a face, within `GAP` of the largest possible
        distance. It is negative or 0 if no point sees all faces from inside: the planes would have
        to move outwards by at least this distance.
    decisive : (k,) int64
        At most four faces that determine the margin.
    """

    point: FloatArray
    margin: float
    decisive: LongArray


@kernel
def face_planes(points: FloatArray, faces: IndexArray) -> Planes:
    """Return the planes of faces that are counter-clockwise from outside."""
    count = len(faces)
    normals, offsets, areas = np.zeros((count, 3)), np.empty(count), np.empty(count)
    for face in range(count):
        one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
        x, y, z = points[one, 0], points[one, 1], points[one, 2]
        ux, uy, uz = points[two, 0] - x, points[two, 1] - y, points[two, 2] - z
        vx, vy, vz = points[three, 0] - x, points[three, 1] - y, points[three, 2] - z
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        areas[face], offsets[face] = length / 2.0, np.inf
        if length > 0.0:
            normals[face, 0], normals[face, 1] = nx / length, ny / length
            normals[face, 2] = nz / length
            offsets[face] = (nx * x + ny * y + nz * z) / length
    return Planes(normals, offsets, areas)


@kernel
def _nearest_plane(planes: Planes, point: FloatArray) -> tuple[int, float]:
    """The plane with the least room between itself and a point, and this room."""
    nearest, least = 0, np.inf
    normals, offsets = planes.normals, planes.offsets
    for face in range(len(offsets)):
        room = offsets[face] - (
            normals[face, 0] * point[0] + normals[face, 1] * point[1] + normals[face, 2] * point[2]
        )
        if room < least:
            nearest, least = face, room
    return nearest, least


def star_kernel_point(planes: Planes, extent: float) -> StarKernelPoint:
    """Return the point farthest inside of the planes of a closed surface around the origin.

    Faces without area are ignored. Tolerances are relative to `extent`, the largest extent of the
    surface.
    """
    rows = np.column_stack([FAR_PLANES, np.ones(4)])
    limits = np.full(4, FAR * extent)
    chosen, weights = np.full(4, -1), np.full(4, 0.25)
    found, most, margin = np.zeros(3), -np.inf, np.inf
    for _ in range(MAX_EXCHANGES):
        # the point that is equally far from the four planes has an upper bound of the margin
        *coordinates, margin = np.linalg.solve(rows, limits)
        point = np.array(coordinates)
        entering, room = _nearest_plane(planes, point)
        if room > most:
            found, most = point, room
        if most >= margin - max(TOLERANCE * extent, GAP * margin):
            break
        row = np.append(planes.normals[entering], 1.0)
        shares = np.linalg.solve(rows.T, row)
        ratios = np.where(shares > TOLERANCE, weights / np.maximum(shares, TOLERANCE), np.inf)
        leaving = int(ratios.argmin())
        step = ratios[leaving]
        weights = np.maximum(weights - step * shares, 0.0)
        rows[leaving], limits[leaving] = row, planes.offsets[entering]
        chosen[leaving], weights[leaving] = entering, step
    return StarKernelPoint(found, float(min(most, margin)), chosen[chosen >= 0])
