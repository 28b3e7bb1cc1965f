"""Memoryless quadrics under exact preservation of volume: the position of a new vertex.

Memoryless: the planes are those of the present faces around the edge, weighted by area, without an
accumulated history (Lindstrom & Turk, "Fast and Memory Efficient Polygonal Simplification", 1998;
Hoppe, "New Quadric Metric for Simplifying Meshes with Appearance Attributes", 1999). Volume: the
new vertex minimises that quadric among the positions that preserve the enclosed volume. These
positions form a plane.

Let N be the area vector of a face (twice the area). Each vertex v has A = Σ N Nᵀ ÷ (2 |N|) and
G = Σ N over its own faces. All their planes contain v, so their quadric is (x − v)ᵀA (x − v), and
an edge is evaluated from its two ends alone. Let y be the position relative to the midpoint of the
edge and e half the edge from its second end to its first. The error is the square root of
[(y − e)ᵀA₁(y − e) + (y + e)ᵀA₂(y + e)] · tr(A₁ + A₂). The trace is the area, so the error is of the
order of a volume, as mismatch is. The volume is preserved where g·y = (G₁ − G₂)·e, where g is the
area vector of the link of the edge.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, FloatArray, IndexArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.costs.symmetric import adjugate
from gamutcore.decimation.star import DEFICIT_LARGEST, DEFICIT_NOW, Surface, squared_length
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

__all__ = [
    "EDGE_SIZE",
    "FLATNESS",
    "REGULARISATION",
    "SUM_SIZE",
    "Quadrics",
    "account_for_volume",
    "area_vectors",
    "constrained_error",
    "constrained_optimum",
    "renew_quadrics",
    "shift_to_preserve_volume",
]

THREE = np.uint64(3)

REGULARISATION = 1e-5
"""Weight of the midpoint in the solve, as a fraction of the quadric's trace.

On nearly flat sides rounding decides whether the quadric is invertible. A small pull towards the
midpoint makes the solution continuous.
"""

FLATNESS = 1e-10
"""Weight of the squared edge length in the error, as a fraction of the quadric's trace.

On exactly flat sides every collapse is free. Without this term one vertex would absorb all its
neighbours in turn, and its faces would become slivers. Elsewhere the term is negligible.
"""

SUM_SIZE = 9
"""Numbers per vertex: a00, a01, a02, a11, a12, a22 of A, then G."""

SQUARE, LINEAR, CONSTANT = 0, 6, 9
"""Indices into `Quadrics.edge`: A₁ + A₂ (6 numbers), (A₁ − A₂) e (3), the error at the midpoint."""

GRADIENT, TARGET, MIDPOINT = 10, 13, 14
"""Indices into `Quadrics.edge`: g (3 numbers), right-hand side of g·y, the midpoint (3)."""

EDGE_SIZE = 17
"""Length of `Quadrics.edge`."""


class Quadrics(NamedTuple):
    """Quadrics of all vertices, either accumulated or memoryless.

    Attributes
    ----------
    sums : (V, 9) or (V, 10) float64
        Memoryless: A and G of a vertex. Accumulated: its quadric relative to the vertex.
    fresh : (V,) uint8
        1 where memoryless `sums` belong to the vertex's present faces.
    area_vector : (F, 4) float64
        Memoryless: N and 1 ÷ (2 |N|) of every face.
    edge : (17,) float64
        Scratch for the current edge.
    """

    sums: FloatArray
    fresh: ByteArray
    area_vector: FloatArray
    edge: FloatArray


@leaf_kernel
def _write_area_vector(
    area_vector: FloatArray, face: int, position: FloatArray, one: int, two: int, three: int
) -> None:
    ux = position[two, 0] - position[one, 0]
    uy = position[two, 1] - position[one, 1]
    uz = position[two, 2] - position[one, 2]
    vx = position[three, 0] - position[one, 0]
    vy = position[three, 1] - position[one, 1]
    vz = position[three, 2] - position[one, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    area_vector[face, 0], area_vector[face, 1], area_vector[face, 2] = nx, ny, nz
    area_vector[face, 3] = 0.5 / np.sqrt(nx * nx + ny * ny + nz * nz)


@kernel
def area_vectors(positions: FloatArray, faces: IndexArray) -> FloatArray:
    """Return N and 1 ÷ (2 |N|) of every face.

    Parameters
    ----------
    positions : (V, 3) float64
    faces : (F, 3) int32

    Returns
    -------
    (F, 4) float64
    """
    vectors = np.empty((len(faces), 4))
    for face in range(len(faces)):
        one, two, three = int(faces[face, 0]), int(faces[face, 1]), int(faces[face, 2])
        _write_area_vector(vectors, face, positions, one, two, three)
    return vectors


@leaf_kernel
def _renew_sums(quadrics: Quadrics, surface: Surface, centre: int) -> None:
    """Sum the contributions of the faces around a vertex."""
    area_vector, sums = quadrics.area_vector, quadrics.sums
    a00, a01, a02, a11, a12, a22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    g0, g1, g2 = 0.0, 0.0, 0.0
    first = int(surface.corner_at[centre])
    at = first
    while True:
        # an unsigned index needs no test for negative values
        corner = np.uint64(at)
        face = corner // THREE
        nx, ny, nz = area_vector[face, 0], area_vector[face, 1], area_vector[face, 2]
        weight = area_vector[face, 3]
        wx, wy, wz = weight * nx, weight * ny, weight * nz
        a00 += wx * nx
        a01 += wx * ny
        a02 += wx * nz
        a11 += wy * ny
        a12 += wy * nz
        a22 += wz * nz
        g0 += nx
        g1 += ny
        g2 += nz
        at = int(surface.swung[corner])
        if at == first:
            break
    sums[centre, 0], sums[centre, 1], sums[centre, 2] = a00, a01, a02
    sums[centre, 3], sums[centre, 4], sums[centre, 5] = a11, a12, a22
    sums[centre, 6], sums[centre, 7], sums[centre, 8] = g0, g1, g2
    quadrics.fresh[centre] = 1


@inlined_kernel
def _combine_ends(quadrics: Quadrics, surface: Surface, corner: int) -> None:
    """Combine the sums of an edge's ends into the quadric and the constraint of the edge."""
    position, sums, edge = surface.position, quadrics.sums, quadrics.edge
    one = int(surface.vertex[following(corner)])
    two = int(surface.vertex[preceding(corner)])
    left, right = surface.vertex[corner], surface.vertex[surface.opposite[corner]]
    if not quadrics.fresh[one]:
        _renew_sums(quadrics, surface, one)
    if not quadrics.fresh[two]:
        _renew_sums(quadrics, surface, two)
    ex = 0.5 * (position[one, 0] - position[two, 0])
    ey = 0.5 * (position[one, 1] - position[two, 1])
    ez = 0.5 * (position[one, 2] - position[two, 2])
    edge[MIDPOINT] = position[two, 0] + ex
    edge[MIDPOINT + 1] = position[two, 1] + ey
    edge[MIDPOINT + 2] = position[two, 2] + ez
    for index in range(6):
        edge[SQUARE + index] = sums[one, index] + sums[two, index]
    a00, a01, a02 = (
        sums[one, 0] - sums[two, 0],
        sums[one, 1] - sums[two, 1],
        sums[one, 2] - sums[two, 2],
    )
    a11, a12, a22 = (
        sums[one, 3] - sums[two, 3],
        sums[one, 4] - sums[two, 4],
        sums[one, 5] - sums[two, 5],
    )
    edge[LINEAR] = a00 * ex + a01 * ey + a02 * ez
    edge[LINEAR + 1] = a01 * ex + a11 * ey + a12 * ez
    edge[LINEAR + 2] = a02 * ex + a12 * ey + a22 * ez
    edge[CONSTANT] = (
        edge[SQUARE] * ex * ex
        + edge[SQUARE + 3] * ey * ey
        + edge[SQUARE + 5] * ez * ez
        + 2.0
        * (edge[SQUARE + 1] * ex * ey + edge[SQUARE + 2] * ex * ez + edge[SQUARE + 4] * ey * ez)
    )
    # The two faces at the edge are in the sums of both ends, so once too often in the link's area
    # vector. Their common area vector is 2 e × (right − left).
    rx = position[right, 0] - position[left, 0]
    ry = position[right, 1] - position[left, 1]
    rz = position[right, 2] - position[left, 2]
    edge[GRADIENT] = sums[one, 6] + sums[two, 6] - 2.0 * (ey * rz - ez * ry)
    edge[GRADIENT + 1] = sums[one, 7] + sums[two, 7] - 2.0 * (ez * rx - ex * rz)
    edge[GRADIENT + 2] = sums[one, 8] + sums[two, 8] - 2.0 * (ex * ry - ey * rx)
    edge[TARGET] = surface.deficit[DEFICIT_NOW] + (
        (sums[one, 6] - sums[two, 6]) * ex
        + (sums[one, 7] - sums[two, 7]) * ey
        + (sums[one, 8] - sums[two, 8]) * ez
    )


@inlined_kernel
def _error(
    quadrics: Quadrics, surface: Surface, corner: int, x: float, y: float, z: float
) -> float:
    """Error at a position relative to the midpoint. Rounding must not make it negative."""
    edge = quadrics.edge
    quadratic = (
        edge[SQUARE] * x * x
        + edge[SQUARE + 3] * y * y
        + edge[SQUARE + 5] * z * z
        + 2.0 * (edge[SQUARE + 1] * x * y + edge[SQUARE + 2] * x * z + edge[SQUARE + 4] * y * z)
    )
    linear = edge[LINEAR] * x + edge[LINEAR + 1] * y + edge[LINEAR + 2] * z
    area = edge[SQUARE] + edge[SQUARE + 3] + edge[SQUARE + 5]
    penalty = FLATNESS * area * squared_length(surface, corner)
    return np.sqrt((max(quadratic - 2.0 * linear + edge[CONSTANT], 0.0) + penalty) * area)


@inlined_kernel
def constrained_optimum(
    quadrics: Quadrics, surface: Surface, corner: int, point: FloatArray
) -> float:
    """Write the position of least error that preserves the volume; return the error.

    Parameters
    ----------
    quadrics : Quadrics
    surface : Surface
    corner : int
        One of the two corners that face the edge.
    point : (3,) float64
        Receives the position, relative to the centre.

    Returns
    -------
    float
        Of the order of the volume by which the surface changes.
    """
    _combine_ends(quadrics, surface, corner)
    edge = quadrics.edge
    pull = REGULARISATION * (edge[SQUARE] + edge[SQUARE + 3] + edge[SQUARE + 5])
    # the determinant cancels at the end
    i00, i01, i02, i11, i12, i22, determinant = adjugate(
        edge[SQUARE] + pull,
        edge[SQUARE + 1],
        edge[SQUARE + 2],
        edge[SQUARE + 3] + pull,
        edge[SQUARE + 4],
        edge[SQUARE + 5] + pull,
    )
    bx, by, bz = edge[LINEAR], edge[LINEAR + 1], edge[LINEAR + 2]
    gx, gy, gz = edge[GRADIENT], edge[GRADIENT + 1], edge[GRADIENT + 2]
    # A⁻¹ b is the unconstrained minimum. Along A⁻¹ g the volume changes at the least error.
    ux = i00 * bx + i01 * by + i02 * bz
    uy = i01 * bx + i11 * by + i12 * bz
    uz = i02 * bx + i12 * by + i22 * bz
    vx = i00 * gx + i01 * gy + i02 * gz
    vy = i01 * gx + i11 * gy + i12 * gz
    vz = i02 * gx + i12 * gy + i22 * gz
    along = gx * vx + gy * vy + gz * vz
    x, y, z = 0.0, 0.0, 0.0
    if determinant > 0.0 and along > 0.0:
        step = (edge[TARGET] * determinant - (gx * ux + gy * uy + gz * uz)) / along
        x = (ux + step * vx) / determinant
        y = (uy + step * vy) / determinant
        z = (uz + step * vz) / determinant
    point[0], point[1], point[2] = (
        edge[MIDPOINT] + x,
        edge[MIDPOINT + 1] + y,
        edge[MIDPOINT + 2] + z,
    )
    return _error(quadrics, surface, corner, x, y, z)


@leaf_kernel
def constrained_error(
    quadrics: Quadrics, surface: Surface, corner: int, point: FloatArray
) -> float:
    """Error of replacing an edge by a vertex at a position, as in `constrained_optimum`."""
    _combine_ends(quadrics, surface, corner)
    edge = quadrics.edge
    x, y, z = (
        point[0] - edge[MIDPOINT],
        point[1] - edge[MIDPOINT + 1],
        point[2] - edge[MIDPOINT + 2],
    )
    return _error(quadrics, surface, corner, x, y, z)


@leaf_kernel
def shift_to_preserve_volume(quadrics: Quadrics, point: FloatArray) -> None:
    """Shift a position along the area vector of the link until the volume is preserved.

    Parameters
    ----------
    quadrics : Quadrics
        As `constrained_optimum` left it for the edge.
    point : (3,) float64
        Relative to the centre; shifted.
    """
    edge = quadrics.edge
    x, y, z = (
        point[0] - edge[MIDPOINT],
        point[1] - edge[MIDPOINT + 1],
        point[2] - edge[MIDPOINT + 2],
    )
    gx, gy, gz = edge[GRADIENT], edge[GRADIENT + 1], edge[GRADIENT + 2]
    square = gx * gx + gy * gy + gz * gz
    if square > 0.0:
        step = (edge[TARGET] - (gx * x + gy * y + gz * z)) / square
        point[0] += step * gx
        point[1] += step * gy
        point[2] += step * gz


@leaf_kernel
def account_for_volume(
    quadrics: Quadrics, surface: Surface, corner: int, point: FloatArray
) -> None:
    """Add to the deficit the volume that a collapse to a rounded position gains or loses.

    Parameters
    ----------
    quadrics : Quadrics
    surface : Surface
        Before the collapse. Its `deficit` is updated.
    corner : int
        One of the two corners that face the edge.
    point : (3,) float64
        The rounded position, relative to the centre.
    """
    _combine_ends(quadrics, surface, corner)
    edge, deficit = quadrics.edge, surface.deficit
    x, y, z = (
        point[0] - edge[MIDPOINT],
        point[1] - edge[MIDPOINT + 1],
        point[2] - edge[MIDPOINT + 2],
    )
    deficit[DEFICIT_NOW] = edge[TARGET] - (
        edge[GRADIENT] * x + edge[GRADIENT + 1] * y + edge[GRADIENT + 2] * z
    )
    deficit[DEFICIT_LARGEST] = max(deficit[DEFICIT_LARGEST], abs(deficit[DEFICIT_NOW]))


@leaf_kernel
def renew_quadrics(quadrics: Quadrics, surface: Surface, centre: int) -> None:
    """Renew the area vectors around a vertex after a collapse to it or a move of it."""
    vertex = surface.vertex
    quadrics.fresh[centre] = 0
    first = int(surface.corner_at[centre])
    at = first
    while True:
        one, two = int(vertex[following(at)]), int(vertex[preceding(at)])
        _write_area_vector(quadrics.area_vector, at // 3, surface.position, centre, one, two)
        quadrics.fresh[one] = 0
        at = int(surface.swung[np.uint64(at)])
        if at == first:
            break
