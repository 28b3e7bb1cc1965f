"""The point of a surface's kernel that is farthest inside of all faces.

A face sees the points of a half-space from inside. The points that all faces see form a convex
body, the kernel of the surface. Its point farthest from the planes of all faces is the centre of
the largest ball in the body (Chebyshev centre), a linear programme in four unknowns.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.mesh import TriangleMesh

__all__ = ["KernelPoint", "kernel_point"]

FIRST_FACES = 500
"""Number of faces in the first programme; the decisive ones are added step by step."""

ADDED_FACES = 200
"""Number of most violated faces that each further programme adds."""

MAX_PROGRAMMES = 60
"""Largest number of programmes. Real gamuts need 3 to 8."""

GAP = 1e-3
"""Relative difference to the largest margin at which the search ends. Thousands of faces are almost
equally far from the middle of a ball, and the last digits would take as many programmes."""

TOLERANCE = 1e-9
"""The same for margins near zero, relative to the extent of the surface."""


class KernelPoint(NamedTuple):
    """A point well inside the kernel, or the proof that the kernel is empty.

    Attributes
    ----------
    point : (3,) float
    margin : float
        Distance of the point from the nearest plane of a face, within `GAP` of the largest possible
        distance. It is negative or 0 if no point sees all faces from inside: the planes would have
        to move outwards by at least this distance.
    decisive : (k,) int64
        The faces nearest to the point, which determine it.
    """

    point: FloatArray
    margin: float
    decisive: LongArray


def kernel_point(mesh: TriangleMesh) -> KernelPoint:
    """Return the point that is farthest inside of the planes of all faces.

    Parameters
    ----------
    mesh : TriangleMesh
        Closed and oriented outwards. Faces without area are ignored.

    Returns
    -------
    KernelPoint
    """
    lowest, highest = mesh.bounds
    middle, extent = (lowest + highest) / 2, float((highest - lowest).max())
    first, second, third = (corner / extent for corner in mesh.corners(middle))
    normals = np.cross(second - first, third - first)
    lengths = np.linalg.norm(normals, axis=1)
    given = np.flatnonzero(lengths > 0)
    normals = normals[given] / lengths[given, np.newaxis]
    offsets = np.einsum("ij,ij->i", normals, first[given])
    # a fixed seed: the same file must give the same centre
    active = np.random.default_rng(0).permutation(len(given))[:FIRST_FACES]
    found, most = np.zeros(3), -np.inf
    for _ in range(MAX_PROGRAMMES):
        # a programme with fewer faces gives an upper bound of the margin
        point, bound = _deepest(normals[active], offsets[active])
        room = offsets - normals @ point
        if bound <= 0.0:
            decisive = active[np.flatnonzero(room[active] <= bound + 1e-6)]
            return KernelPoint(point * extent + middle, bound * extent, given[decisive])
        if room.min() > most:
            found, most = point, float(room.min())
        if most >= bound - max(TOLERANCE, GAP * bound):
            break
        worst = np.argpartition(room, min(ADDED_FACES, len(room) - 1))[:ADDED_FACES]
        active = np.union1d(active, worst)
    room = offsets - normals @ found
    decisive = np.flatnonzero(room <= most + 1e-6)
    return KernelPoint(found * extent + middle, most * extent, given[decisive])


def _deepest(normals: FloatArray, offsets: FloatArray) -> tuple[FloatArray, float]:
    """Return the point and the largest margin m with normals · point + m ≤ offsets."""
    rows = np.column_stack([normals, np.ones(len(normals))])
    from scipy.optimize import linprog  # noqa: PLC0415  # 0.2 s, for meshes only

    solved = linprog(
        [0, 0, 0, -1], A_ub=rows, b_ub=offsets, bounds=[(-1, 1)] * 3 + [(-4, 4)], method="highs"
    )
    if solved.x is None:  # no numerical solution: take the middle
        return np.zeros(3), float((offsets).min())
    return np.asarray(solved.x[:3]), float(solved.x[3])
