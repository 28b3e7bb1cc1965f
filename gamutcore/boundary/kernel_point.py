"""The point that all faces of a surface see from inside: where the surface is star-shaped about.

The points that a face sees from inside are a half-space; those that all do are a convex body, the
kernel of the surface. Its point furthest from all of the faces' planes is a linear programme in
four unknowns (the centre of the largest ball in it, Chebyshev's centre).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.mesh import TriangleMesh

__all__ = ["KernelPoint", "kernel_point"]

STARTED_WITH = 500
"""Faces that the first programme has; which of them decide is found out step by step."""

TAKEN_IN = 200
"""Most violated faces that each further programme has in addition."""

MOST_PROGRAMMES = 60
"""Each takes in the most violated faces, so a few are enough: 3 to 8 for real gamuts."""

GAP = 1e-3
"""Part of the best margin by which the one that is found may be less. Thousands of faces are nearly
as far from the middle of a ball, and the last digits would take as many programmes."""

TOLERANCE = 1e-9
"""The same where the margin is near nothing, as a part of the surface's extent."""


class KernelPoint(NamedTuple):
    """A point well inside the kernel, or proof that there is none.

    Attributes
    ----------
    point : (3,) float
    margin : float
        Its distance from the nearest plane of a face, as good as the largest that there is. If no
        point is seen by all faces from inside, it is negative or 0: the planes would have to be
        moved outwards by this at least.
    decisive : (k,) int64
        Faces that decide: those that the point is nearest to.
    """

    point: FloatArray
    margin: float
    decisive: LongArray


def kernel_point(mesh: TriangleMesh) -> KernelPoint:
    """Return the point that is furthest inside of all planes of a surface's faces, to `GAP`.

    Parameters
    ----------
    mesh : TriangleMesh
        Closed and oriented outwards. Faces without area have no say.

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
    # a fixed choice: the same file must give the same centre
    active = np.random.default_rng(0).permutation(len(given))[:STARTED_WITH]
    found, most = np.zeros(3), -np.inf
    for _ in range(MOST_PROGRAMMES):
        # a programme with fewer faces has a larger margin: it bounds what all of them allow
        point, bound = _deepest(normals[active], offsets[active])
        room = offsets - normals @ point
        if bound <= 0.0:
            decisive = active[np.flatnonzero(room[active] <= bound + 1e-6)]
            return KernelPoint(point * extent + middle, bound * extent, given[decisive])
        if room.min() > most:
            found, most = point, float(room.min())
        if most >= bound - max(TOLERANCE, GAP * bound):
            break
        worst = np.argpartition(room, min(TAKEN_IN, len(room) - 1))[:TAKEN_IN]
        active = np.union1d(active, worst)
    room = offsets - normals @ found
    decisive = np.flatnonzero(room <= most + 1e-6)
    return KernelPoint(found * extent + middle, most * extent, given[decisive])


def _deepest(normals: FloatArray, offsets: FloatArray) -> tuple[FloatArray, float]:
    """Return the point and the margin m that is largest with normals · point + m ≤ offsets."""
    rows = np.column_stack([normals, np.ones(len(normals))])
    from scipy.optimize import linprog  # noqa: PLC0415  # a fifth of a second

    solved = linprog(
        [0, 0, 0, -1], A_ub=rows, b_ub=offsets, bounds=[(-1, 1)] * 3 + [(-4, 4)], method="highs"
    )
    if solved.x is None:  # numerically hopeless; the middle is then as good as any
        return np.zeros(3), float((offsets).min())
    return np.asarray(solved.x[:3]), float(solved.x[3])
