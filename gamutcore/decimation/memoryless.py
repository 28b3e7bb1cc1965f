"""Memoryless quadrics under exact preservation of volume: where the vertex of a collapse should go.

Memoryless: the planes are those of the faces around the edge as it is now, weighted by their
area, not an accumulated history (Lindstrom & Turk, "Fast and Memory Efficient Polygonal
Simplification", 1998; Hoppe, "New Quadric Metric for Simplifying Meshes with Appearance
Attributes", 1999). Volume: the new vertex is the minimum of that quadric among the positions that
leave the enclosed volume as it is, which are a plane.

With N the (doubled) area vector of a face, each vertex v has A = Σ N Nᵀ ÷ (2 |N|) and G = Σ N
over its own faces. All of their planes pass through it, so their quadric is (x − v)ᵀA (x − v), and
an edge is evaluated from its two ends alone. With y the position relative to the edge's midpoint
and e half the edge from its second end to its first, the error is the square root of
[(y − e)ᵀA₁(y − e) + (y + e)ᵀA₂(y + e)] · tr(A₁ + A₂): tr A is the area, so it is of the order of a
volume, as mismatch is. The volume is preserved where g·y = (G₁ − G₂)·e, g being the area vector of
the edge's link.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, FloatArray, IndexArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.star import Surface
from gamutcore.decimation.symmetric import adjugate
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

__all__ = [
    "Memoryless",
    "account_for_volume",
    "constrained_optimum",
    "error_of_place",
    "keep_volume",
    "memoryless",
    "memoryless_on",
    "renew_planes",
]

THREE = np.uint64(3)

REGULARISATION = 1e-5
"""Weight of the midpoint in the solve, as a part of the quadric's trace; decides on flat sides."""


FLATNESS = 1e-10
"""Weight of the squared edge length in the error, as a part of the quadric's trace: on exactly flat
sides it makes shorter edges come first, elsewhere it weighs nothing (as in `quadric`)."""


class Memoryless(NamedTuple):
    """What the faces around each vertex add up to, made anew where it is needed and has changed.

    Attributes
    ----------
    sums : (V, 9) float64
        a00, a01, a02, a11, a12, a22 of A, then G.
    fresh : (V,) uint8
        1 where `sums` are those of the vertex's present faces.
    area_vector : (F, 4) float64
        N and 1 ÷ (2 |N|) of every face.
    edge : (17,) float64
        Scratch for the edge at hand: A₁ + A₂ (six numbers), (A₁ − A₂) e, the error at the midpoint,
        g, its right-hand side, the midpoint.
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
def _area_vectors(positions: FloatArray, faces: IndexArray) -> FloatArray:
    vectors = np.empty((len(faces), 4))
    for face in range(len(faces)):
        one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
        _write_area_vector(vectors, face, positions, one, two, three)
    return vectors


def memoryless(positions: FloatArray, faces: IndexArray) -> Memoryless:
    """Return the area vectors of a full boundary, and room for the sums.

    Parameters
    ----------
    positions : (V, 3) float64
    faces : (F, 3) int32

    Returns
    -------
    Memoryless
    """
    count = len(positions)
    return Memoryless(
        np.empty((count, 9)),
        np.zeros(count, np.uint8),
        _area_vectors(positions, faces),
        np.zeros(17),
    )


def memoryless_on(planes: Memoryless, vertices: IndexArray, faces: IndexArray) -> Memoryless:
    """Return the same for a surface that has only some of the vertices and faces.

    Parameters
    ----------
    planes : Memoryless
    vertices : (v,) int32
        Their numbers there.
    faces : (f,) int32
        The same of the faces.

    Returns
    -------
    Memoryless
    """
    return Memoryless(
        planes.sums[vertices], planes.fresh[vertices], planes.area_vector[faces], planes.edge.copy()
    )


@leaf_kernel
def _sum_up(planes: Memoryless, surface: Surface, centre: int) -> None:
    """Add up what the faces around a vertex contribute."""
    area_vector, sums = planes.area_vector, planes.sums
    a00, a01, a02, a11, a12, a22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    g0, g1, g2 = 0.0, 0.0, 0.0
    first = surface.corner_at[centre]
    at = first
    while True:
        # a number without a sign needs no test for a negative one, in a loop that waits for each
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
        at = surface.swung[corner]
        if at == first:
            break
    sums[centre, 0], sums[centre, 1], sums[centre, 2] = a00, a01, a02
    sums[centre, 3], sums[centre, 4], sums[centre, 5] = a11, a12, a22
    sums[centre, 6], sums[centre, 7], sums[centre, 8] = g0, g1, g2
    planes.fresh[centre] = 1


@inlined_kernel
def _gather(planes: Memoryless, surface: Surface, corner: int) -> None:
    """Combine the sums of an edge's ends into the quadric and the constraint of the edge."""
    position, sums, edge = surface.position, planes.sums, planes.edge
    one, two = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    left, right = surface.vertex[corner], surface.vertex[surface.opposite[corner]]
    for end in (one, two):
        if not planes.fresh[end]:
            _sum_up(planes, surface, end)
    ex = 0.5 * (position[one, 0] - position[two, 0])
    ey = 0.5 * (position[one, 1] - position[two, 1])
    ez = 0.5 * (position[one, 2] - position[two, 2])
    edge[14] = position[two, 0] + ex
    edge[15] = position[two, 1] + ey
    edge[16] = position[two, 2] + ez
    for index in range(6):
        edge[index] = sums[one, index] + sums[two, index]
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
    edge[6] = a00 * ex + a01 * ey + a02 * ez
    edge[7] = a01 * ex + a11 * ey + a12 * ez
    edge[8] = a02 * ex + a12 * ey + a22 * ez
    edge[9] = (
        edge[0] * ex * ex
        + edge[3] * ey * ey
        + edge[5] * ez * ez
        + 2.0 * (edge[1] * ex * ey + edge[2] * ex * ez + edge[4] * ey * ez)
    )
    # the two faces at the edge are in both ends' sums, and once too often in the link's area;
    # together they have the area vector 2 e × (right − left)
    rx = position[right, 0] - position[left, 0]
    ry = position[right, 1] - position[left, 1]
    rz = position[right, 2] - position[left, 2]
    edge[10] = sums[one, 6] + sums[two, 6] - 2.0 * (ey * rz - ez * ry)
    edge[11] = sums[one, 7] + sums[two, 7] - 2.0 * (ez * rx - ex * rz)
    edge[12] = sums[one, 8] + sums[two, 8] - 2.0 * (ex * ry - ey * rx)
    edge[13] = surface.deficit[0] + (
        (sums[one, 6] - sums[two, 6]) * ex
        + (sums[one, 7] - sums[two, 7]) * ey
        + (sums[one, 8] - sums[two, 8]) * ez
    )


@inlined_kernel
def _value(
    planes: Memoryless, surface: Surface, corner: int, x: float, y: float, z: float
) -> float:
    """Error at a position relative to the midpoint; rounding must not make it negative."""
    edge, position = planes.edge, surface.position
    quadratic = (
        edge[0] * x * x
        + edge[3] * y * y
        + edge[5] * z * z
        + 2.0 * (edge[1] * x * y + edge[2] * x * z + edge[4] * y * z)
    )
    linear = edge[6] * x + edge[7] * y + edge[8] * z
    one, two = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    ex = position[one, 0] - position[two, 0]
    ey = position[one, 1] - position[two, 1]
    ez = position[one, 2] - position[two, 2]
    area = edge[0] + edge[3] + edge[5]
    short = FLATNESS * area * (ex * ex + ey * ey + ez * ez)
    return np.sqrt((max(quadratic - 2.0 * linear + edge[9], 0.0) + short) * area)


@inlined_kernel
def constrained_optimum(
    planes: Memoryless, surface: Surface, corner: int, place: FloatArray
) -> float:
    """Write the position with the least error that preserves the volume, and return the error.

    Parameters
    ----------
    planes : Memoryless
    surface : Surface
    corner : int
        One of the two corners that face the edge.
    place : (3,) float64
        Receives the position, relative to the centre.

    Returns
    -------
    float
        Of the order of the volume by which the surface changes.
    """
    _gather(planes, surface, corner)
    edge = planes.edge
    pull = REGULARISATION * (edge[0] + edge[3] + edge[5])
    # the determinant cancels in the end
    i00, i01, i02, i11, i12, i22, determinant = adjugate(
        edge[0] + pull, edge[1], edge[2], edge[3] + pull, edge[4], edge[5] + pull
    )
    bx, by, bz = edge[6], edge[7], edge[8]
    gx, gy, gz = edge[10], edge[11], edge[12]
    # A⁻¹ b, the free minimum, and A⁻¹ g, the way along which the volume changes most cheaply
    ux = i00 * bx + i01 * by + i02 * bz
    uy = i01 * bx + i11 * by + i12 * bz
    uz = i02 * bx + i12 * by + i22 * bz
    vx = i00 * gx + i01 * gy + i02 * gz
    vy = i01 * gx + i11 * gy + i12 * gz
    vz = i02 * gx + i12 * gy + i22 * gz
    along = gx * vx + gy * vy + gz * vz
    x, y, z = 0.0, 0.0, 0.0
    if determinant > 0.0 and along > 0.0:
        step = (edge[13] * determinant - (gx * ux + gy * uy + gz * uz)) / along
        x = (ux + step * vx) / determinant
        y = (uy + step * vy) / determinant
        z = (uz + step * vz) / determinant
    place[0], place[1], place[2] = edge[14] + x, edge[15] + y, edge[16] + z
    return _value(planes, surface, corner, x, y, z)


@leaf_kernel
def error_of_place(planes: Memoryless, surface: Surface, corner: int, place: FloatArray) -> float:
    """Error of replacing an edge by a vertex at a place; as `constrained_optimum` returns it."""
    _gather(planes, surface, corner)
    x, y, z = place[0] - planes.edge[14], place[1] - planes.edge[15], place[2] - planes.edge[16]
    return _value(planes, surface, corner, x, y, z)


@leaf_kernel
def keep_volume(planes: Memoryless, place: FloatArray) -> None:
    """Shift a place along the area vector of its edge's link to where the volume is preserved.

    Parameters
    ----------
    planes : Memoryless
        As `constrained_optimum` left it for the edge.
    place : (3,) float64
        Relative to the centre; shifted.
    """
    edge = planes.edge
    x, y, z = place[0] - edge[14], place[1] - edge[15], place[2] - edge[16]
    gx, gy, gz = edge[10], edge[11], edge[12]
    square = gx * gx + gy * gy + gz * gz
    if square > 0.0:
        step = (edge[13] - (gx * x + gy * y + gz * z)) / square
        place[0] += step * gx
        place[1] += step * gy
        place[2] += step * gz


@leaf_kernel
def account_for_volume(
    planes: Memoryless, surface: Surface, corner: int, place: FloatArray
) -> None:
    """Note what rounding the position of a collapse that is about to happen changes in volume.

    Parameters
    ----------
    planes : Memoryless
    surface : Surface
        Its `deficit` is brought up to date.
    corner : int
        One of the two corners that face the edge.
    place : (3,) float64
        The rounded position, relative to the centre.
    """
    _gather(planes, surface, corner)
    edge = planes.edge
    x, y, z = place[0] - edge[14], place[1] - edge[15], place[2] - edge[16]
    surface.deficit[0] = edge[13] - (edge[10] * x + edge[11] * y + edge[12] * z)
    surface.deficit[1] = max(surface.deficit[1], abs(surface.deficit[0]))


@leaf_kernel
def renew_planes(planes: Memoryless, surface: Surface, centre: int) -> None:
    """Renew the area vectors of the faces around a vertex that has moved or new neighbours."""
    vertex = surface.vertex
    planes.fresh[centre] = 0
    first = surface.corner_at[centre]
    at = first
    while True:
        one, two = vertex[following(at)], vertex[preceding(at)]
        _write_area_vector(planes.area_vector, at // 3, surface.position, centre, one, two)
        planes.fresh[one] = 0
        at = surface.swung[np.uint64(at)]
        if at == first:
            break
