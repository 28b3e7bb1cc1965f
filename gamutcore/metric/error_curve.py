"""The error of a history's levels against its full boundary, cheap enough for every build.

All levels are star-shaped about the same centre, so each is a radius as a function of direction,
and the symmetric difference of two of them is an integral over the sphere. It is taken here as a
sum over the vertices of the full boundary: along each vertex's direction the level's radius is
found, and the vertex stands for a third of the volume of the cones over its faces. `mismatch` in
this package gives the exact value for a single pair of meshes, at several thousand times the cost
per level.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.corner_table import following, opposite_corners, preceding
from gamutcore.kernels import kernel

if TYPE_CHECKING:
    from collections.abc import Iterable

    from gamutcore.history import History

__all__ = ["LevelError", "error_curve", "round_counts"]

ON_EDGE = 1e-12
"""Part of a face that a direction may lie beyond its edge and still count as in it: vertices that a
level shares with the full boundary lie on edges up to rounding."""


@dataclass(frozen=True)
class LevelError:
    """How far a level is from the full boundary.

    Attributes
    ----------
    triangles : int
    volume : float
        Enclosed volume, exact (cubic units of the space).
    mismatch : float
        Volume of the symmetric difference ÷ volume of the full boundary, by quadrature over the
        full boundary's vertices.
    maximum_distance, mean_distance : float
        Distance between a vertex of the full boundary and the level along the radius from the
        centre: the largest, which bounds the distance of every such vertex from the level, and
        the mean weighted by volume (units of the space).
    """

    triangles: int
    volume: float
    mismatch: float
    maximum_distance: float
    mean_distance: float


def round_counts(maximum: int) -> list[int]:
    """Triangle counts in steps of 1, 2, 5 from 4 to the full boundary's, which ends the list.

    Parameters
    ----------
    maximum : int

    Returns
    -------
    list of int
    """
    counts = [4, 6, 8]
    decade = 10
    while decade < maximum:
        counts += [decade, 2 * decade, 5 * decade]
        decade *= 10
    return [count for count in counts if count < maximum] + [maximum]


def error_curve(history: History, counts: Iterable[int]) -> list[LevelError]:
    """Errors of several levels against the full boundary.

    Parameters
    ----------
    history : History
    counts : iterable of int
        Triangle counts that the history has.

    Returns
    -------
    list of LevelError
        By ascending triangle count.

    Raises
    ------
    TriangleCountError
        If there is no such level.
    """
    full = history.full()
    positions = full.vertices.astype(np.float64) - history.centre
    weights = _vertex_volumes(positions, full.faces)
    volume = float(weights.sum())
    ancestors = np.arange(history.vertices, dtype=np.int32)
    curve = []
    # from fine to coarse, so that each vertex's ancestor is found from the one in the level before
    for count in sorted(set(counts), reverse=True):
        level = history.level(count)
        vertices = level.vertices.astype(np.float64) - history.centre
        _follow(ancestors, history.splits.parent, len(vertices))
        opposite = opposite_corners(level.faces, len(vertices))
        difference, largest, mean = _radial_differences(
            positions, weights, ancestors, vertices, level.faces.ravel(), opposite
        )
        curve.append(
            LevelError(
                triangles=level.triangles,
                volume=float(level.determinants(history.centre).sum() / 6.0),
                mismatch=float(difference) / volume,
                maximum_distance=float(largest),
                mean_distance=float(mean) / volume,
            )
        )
    return curve[::-1]


@kernel
def _vertex_volumes(positions: FloatArray, faces: IndexArray) -> FloatArray:
    """A third of the volume of the cones over each vertex's faces."""
    volumes = np.zeros(len(positions), np.float64)
    for face in range(len(faces)):
        one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
        share = _determinant(positions, one, positions, two, positions, three) / 18.0
        volumes[one] += share
        volumes[two] += share
        volumes[three] += share
    return volumes


@kernel
def _determinant(
    first: FloatArray, one: int, second: FloatArray, two: int, third: FloatArray, three: int
) -> float:
    ax, ay, az = first[one, 0], first[one, 1], first[one, 2]
    bx, by, bz = second[two, 0], second[two, 1], second[two, 2]
    cx, cy, cz = third[three, 0], third[three, 1], third[three, 2]
    return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)


@kernel
def _follow(ancestors: IndexArray, parent: IndexArray, vertices: int) -> None:
    """Replace every slot by the one that it has been merged into at a level."""
    for index in range(len(ancestors)):
        slot = ancestors[index]
        while slot >= vertices:
            slot = parent[slot - 4]
        ancestors[index] = slot


@kernel
def _radial_differences(
    positions: FloatArray,
    weights: FloatArray,
    ancestors: IndexArray,
    vertices: FloatArray,
    corners: IndexArray,
    opposite: IndexArray,
) -> tuple[float, float, float]:
    """Sum of |1 − t³| by weight, largest |1 − t| r, and sum of |1 − t| r by weight.

    t is the level's radius ÷ the full boundary's radius r in the direction of a vertex of the
    latter.
    """
    corner_at = np.empty(len(vertices), np.int32)
    for corner in range(len(corners)):
        corner_at[corners[corner]] = corner
    difference, largest, total = 0.0, 0.0, 0.0
    for vertex in range(len(positions)):
        face = _face_in_direction(
            positions, vertex, vertices, corners, opposite, corner_at[ancestors[vertex]] // 3
        )
        one, two, three = corners[3 * face], corners[3 * face + 1], corners[3 * face + 2]
        along = (
            _determinant(positions, vertex, vertices, one, vertices, two)
            + _determinant(positions, vertex, vertices, two, vertices, three)
            + _determinant(positions, vertex, vertices, three, vertices, one)
        )
        ratio = _determinant(vertices, one, vertices, two, vertices, three) / along
        x, y, z = positions[vertex, 0], positions[vertex, 1], positions[vertex, 2]
        distance = abs(1.0 - ratio) * np.sqrt(x * x + y * y + z * z)
        difference += weights[vertex] * abs(1.0 - ratio * ratio * ratio)
        largest = max(largest, distance)
        total += weights[vertex] * distance
    return difference, largest, total


@kernel
def _face_in_direction(
    positions: FloatArray,
    vertex: int,
    vertices: FloatArray,
    corners: IndexArray,
    opposite: IndexArray,
    face: int,
) -> int:
    """Face of a star-shaped mesh that a vertex's direction passes, walking from a face near it.

    Each step crosses the edge that the direction lies furthest behind. Such a walk can go in
    circles in a triangulation that is not Delaunay's; after as many steps as would cross the mesh
    several times all faces are looked at instead.
    """
    for _ in range(100 + 8 * int(np.sqrt(len(corners)))):
        furthest, through, extent = 0.0, -1, 0.0
        for place in range(3):
            corner = 3 * face + place
            one, two = corners[following(corner)], corners[preceding(corner)]
            side = _determinant(positions, vertex, vertices, one, vertices, two)
            extent += abs(side)
            if side < furthest:
                furthest, through = side, corner
        if furthest >= -ON_EDGE * extent:
            return face
        face = opposite[through] // 3
    best, chosen = -np.inf, face
    for candidate in range(len(corners) // 3):
        least = np.inf
        for place in range(3):
            corner = 3 * candidate + place
            one, two = corners[following(corner)], corners[preceding(corner)]
            least = min(least, _determinant(positions, vertex, vertices, one, vertices, two))
        if least > best:
            best, chosen = least, candidate
    return chosen
