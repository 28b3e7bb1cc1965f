"""Quadrics: the position of a new vertex, and the error of a collapse, by squared distances.

Memoryless quadrics under exact preservation of volume serve ``volume`` and ``finest``. The planes
are those of the present faces around the edge, weighted by area. There is no accumulated history
(Lindstrom & Turk, "Fast and Memory Efficient Polygonal Simplification", 1998; Hoppe, "New Quadric
Metric for Simplifying Meshes with Appearance Attributes", 1999). The new vertex minimises that
quadric among the positions that preserve the enclosed volume. These positions form a plane.

Let N be the area vector of a face (twice the area). Each vertex v has A = Σ N Nᵀ ÷ (2 |N|) and
G = Σ N over its own faces. All their planes contain v, so their quadric is (x − v)ᵀA (x − v), and
an edge is evaluated from its two ends alone. Let y be the position relative to the midpoint of the
edge and e half the edge from its second end to its first. The error is the square root of
[(y − e)ᵀA₁(y − e) + (y + e)ᵀA₂(y + e)] · tr(A₁ + A₂). The trace is the area, so the error is of the
order of a volume, as mismatch is. The volume is preserved where g·y = (G₁ − G₂)·e, where g is the
area vector of the link of the edge.

Accumulated, unweighted plane quadrics are the published cost, ``quadric`` (Garland & Heckbert,
"Surface Simplification Using Quadric Error Metrics", 1997, as Bakke & Farup use it). A face with
unit normal n and offset d has the quadric (A, b, c) = (n nᵀ, d n, d²). Its value
D²(v) = vᵀA v + 2 bᵀv + c is the squared distance of v from the plane of the face. A vertex starts
with the sum over its faces, and a collapse adds the quadrics of its two ends. The quadric of each
vertex is stored relative to the vertex and moved to the midpoint of the edge for a collapse. The
polynomial is the same, without the cancellation of absolute coordinates. `REGULARISATION` and
`FLATNESS` are additions to the publication that keep every level valid.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, FloatArray, IndexArray
from gamutcore.decimation.surface_mesh import (
    DEFICIT_LARGEST,
    DEFICIT_NOW,
    SurfaceMesh,
    squared_length,
)
from gamutcore.geometry import (
    Symmetric,
    Vector,
    add_outer,
    adjugate,
    cross,
    dot,
    linear_combination,
    minus,
    next_corner,
    plus,
    previous_corner,
    product,
    quadratic_form,
    row,
    scaled,
    symmetric_row,
    write_row,
    write_symmetric_row,
)
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

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


class Quadrics(NamedTuple):
    """Quadrics of all vertices, either accumulated or memoryless."""

    sums: FloatArray  # (V, 9) memoryless: A and G; (V, 10) accumulated: relative to the vertex
    fresh: ByteArray  # (V,) 1 where memoryless `sums` belong to the vertex's present faces
    area_vector: FloatArray  # (F, 4) memoryless: N and 1 ÷ (2 |N|) of every face


SUM_SIZE, GRADIENT = 9, 6
"""Numbers per vertex: A on and above its diagonal, and from index 6 on G."""

THREE = np.uint64(3)


class _Edge(NamedTuple):
    """The memoryless quadric and the constraint of an edge."""

    square: Symmetric  # A₁ + A₂
    linear: Vector  # (A₁ − A₂) e
    constant: float  # the error at the midpoint
    gradient: Vector  # g
    target: float  # right-hand side of g·y, with the volume that the level lacks
    midpoint: Vector  # relative to the centre


@leaf_kernel
def _write_area_vector(
    area_vector: FloatArray, face: int, position: FloatArray, one: int, two: int, three: int
) -> None:
    start = row(position, one, 0)
    area = cross(minus(row(position, two, 0), start), minus(row(position, three, 0), start))
    write_row(area_vector, face, 0, area)
    area_vector[face, 3] = 0.5 / np.sqrt(dot(area, area))


@kernel
def area_vectors(positions: FloatArray, faces: IndexArray) -> FloatArray:
    """Return N and 1 ÷ (2 |N|) of every face, (F, 4)."""
    vectors = np.empty((len(faces), 4))
    for face in range(len(faces)):
        one, two, three = int(faces[face, 0]), int(faces[face, 1]), int(faces[face, 2])
        _write_area_vector(vectors, face, positions, one, two, three)
    return vectors


@leaf_kernel
def _renew_sums(quadrics: Quadrics, surface: SurfaceMesh, centre: int) -> None:
    """Sum the contributions of the faces around a vertex."""
    area_vector, sums = quadrics.area_vector, quadrics.sums
    square, total = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    # an unsigned index needs no test for negative values
    corner = np.uint64(surface.corner_at[centre])
    for _ in range(surface.degree[centre]):
        face = corner // THREE
        area = (area_vector[face, 0], area_vector[face, 1], area_vector[face, 2])
        square = add_outer(square, area_vector[face, 3], area)
        total = plus(total, area)
        corner = np.uint64(surface.swing[corner])
    write_symmetric_row(sums, centre, square)
    write_row(sums, centre, GRADIENT, total)
    quadrics.fresh[centre] = 1


@inlined_kernel
def _combine_ends(quadrics: Quadrics, surface: SurfaceMesh, corner: int) -> _Edge:
    """Combine the sums of an edge's ends into the quadric and the constraint of the edge."""
    position, sums, vertex = surface.position, quadrics.sums, surface.vertex
    one, two = int(vertex[next_corner(corner)]), int(vertex[previous_corner(corner)])
    if not quadrics.fresh[one]:
        _renew_sums(quadrics, surface, one)
    if not quadrics.fresh[two]:
        _renew_sums(quadrics, surface, two)
    start = row(position, two, 0)
    e = scaled(0.5, minus(row(position, one, 0), start))
    a, b = symmetric_row(sums, one), symmetric_row(sums, two)
    square = linear_combination(a, 1.0, b)
    # The two faces at the edge are in the sums of both ends, so once too often in the link's area
    # vector. Their common area vector is 2 e × (right − left).
    left, right = int(vertex[corner]), int(vertex[surface.opposite[corner]])
    shared = scaled(2.0, cross(e, minus(row(position, right, 0), row(position, left, 0))))
    g, h = row(sums, one, GRADIENT), row(sums, two, GRADIENT)
    return _Edge(
        square,
        product(linear_combination(a, -1.0, b), e),
        quadratic_form(square, e),
        minus(plus(g, h), shared),
        surface.deficit[DEFICIT_NOW] + dot(minus(g, h), e),
        plus(start, e),
    )


@inlined_kernel
def _error(edge: _Edge, surface: SurfaceMesh, corner: int, y: Vector) -> float:
    """Error at a position relative to the midpoint. Rounding must not make it negative."""
    area = edge.square[0] + edge.square[3] + edge.square[5]
    penalty = FLATNESS * area * squared_length(surface, corner)
    error = quadratic_form(edge.square, y) - 2.0 * dot(edge.linear, y) + edge.constant
    return np.sqrt((max(error, 0.0) + penalty) * area)


@inlined_kernel
def constrained_optimum(
    quadrics: Quadrics, surface: SurfaceMesh, corner: int, point: FloatArray
) -> float:
    """Write the position of least error that preserves the volume; return the error."""
    edge = _combine_ends(quadrics, surface, corner)
    pull = REGULARISATION * (edge.square[0] + edge.square[3] + edge.square[5])
    # the determinant cancels at the end
    inverse, determinant = adjugate(edge.square, pull)
    # A⁻¹ b is the unconstrained minimum. Along A⁻¹ g the volume changes at the least error.
    free, across = product(inverse, edge.linear), product(inverse, edge.gradient)
    along = dot(edge.gradient, across)
    x, y, z = 0.0, 0.0, 0.0
    if determinant > 0.0 and along > 0.0:
        step = (edge.target * determinant - dot(edge.gradient, free)) / along
        x = (free[0] + step * across[0]) / determinant
        y = (free[1] + step * across[1]) / determinant
        z = (free[2] + step * across[2]) / determinant
    middle = edge.midpoint
    point[0], point[1], point[2] = middle[0] + x, middle[1] + y, middle[2] + z
    return _error(edge, surface, corner, (x, y, z))


@leaf_kernel
def constrained_error(
    quadrics: Quadrics, surface: SurfaceMesh, corner: int, point: FloatArray
) -> float:
    """Error of replacing an edge by a vertex at a position, as in `constrained_optimum`."""
    edge = _combine_ends(quadrics, surface, corner)
    offset = minus((point[0], point[1], point[2]), edge.midpoint)
    return _error(edge, surface, corner, offset)


@leaf_kernel
def _missing_volume(edge: _Edge, point: FloatArray) -> float:
    """Six times the volume that the level lacks if a position replaces an edge."""
    offset = minus((point[0], point[1], point[2]), edge.midpoint)
    return edge.target - dot(edge.gradient, offset)


@leaf_kernel
def shift_to_preserve_volume(
    quadrics: Quadrics, surface: SurfaceMesh, corner: int, point: FloatArray
) -> None:
    """Shift a position along the area vector of an edge's link until the volume is preserved."""
    edge = _combine_ends(quadrics, surface, corner)
    square = dot(edge.gradient, edge.gradient)
    if square > 0.0:
        step = _missing_volume(edge, point) / square
        for axis in range(3):
            point[axis] += step * edge.gradient[axis]


@leaf_kernel
def account_for_volume(
    quadrics: Quadrics, surface: SurfaceMesh, corner: int, point: FloatArray
) -> None:
    """Update the surface's `deficit` for a collapse to a rounded position, before it happens."""
    missing = _missing_volume(_combine_ends(quadrics, surface, corner), point)
    surface.deficit[DEFICIT_NOW] = missing
    surface.deficit[DEFICIT_LARGEST] = max(surface.deficit[DEFICIT_LARGEST], abs(missing))


@leaf_kernel
def renew_quadrics(quadrics: Quadrics, surface: SurfaceMesh, centre: int) -> None:
    """Renew the area vectors around a vertex after a collapse to it or a move of it."""
    vertex, corner = surface.vertex, int(surface.corner_at[centre])
    quadrics.fresh[centre] = 0
    for _ in range(surface.degree[centre]):
        one, two = int(vertex[next_corner(corner)]), int(vertex[previous_corner(corner)])
        _write_area_vector(quadrics.area_vector, corner // 3, surface.position, centre, one, two)
        quadrics.fresh[one] = 0
        corner = int(surface.swing[np.uint64(corner)])


QUADRIC_SIZE, LINEAR, CONSTANT = 10, 6, 9
"""Numbers of a quadric: A on and above its diagonal, from index 6 on b, and at index 9 c."""


@kernel
def vertex_quadrics(positions: FloatArray, faces: IndexArray) -> FloatArray:
    """Return the quadric of every vertex of a full boundary, relative to the vertex, (V, 10)."""
    quadrics = np.zeros((len(positions), QUADRIC_SIZE))
    for face in range(len(faces)):
        one, two, three = int(faces[face, 0]), int(faces[face, 1]), int(faces[face, 2])
        start = row(positions, one, 0)
        normal = cross(minus(row(positions, two, 0), start), minus(row(positions, three, 0), start))
        length = np.sqrt(dot(normal, normal))
        if length > 0.0:
            normal = (normal[0] / length, normal[1] / length, normal[2] / length)
        for corner in (one, two, three):  # each corner lies in the plane, so d = 0 relative to it
            square = add_outer(symmetric_row(quadrics, corner), 1.0, normal)
            write_symmetric_row(quadrics, corner, square)
    return quadrics


@leaf_kernel
def _sum_at_point(
    sums: FloatArray, surface: SurfaceMesh, one: int, two: int, origin: FloatArray
) -> tuple[Symmetric, Vector, float]:
    """Sum of two vertices' quadrics, relative to an origin."""
    linear = plus(row(sums, one, LINEAR), row(sums, two, LINEAR))
    c = sums[one, CONSTANT] + sums[two, CONSTANT]
    for end in (one, two):
        offset = minus((origin[0], origin[1], origin[2]), row(surface.position, end, 0))
        change = product(symmetric_row(sums, end), offset)
        linear = plus(linear, change)
        c += 2.0 * dot(row(sums, end, LINEAR), offset) + dot(change, offset)
    square = linear_combination(symmetric_row(sums, one), 1.0, symmetric_row(sums, two))
    return square, linear, c


@leaf_kernel
def plane_optimum(
    quadrics: Quadrics, surface: SurfaceMesh, corner: int, point: FloatArray
) -> float:
    """Write the position of least error for an edge; return it, a sum of squared distances."""
    one, two = (
        int(surface.vertex[next_corner(corner)]),
        int(surface.vertex[previous_corner(corner)]),
    )
    for axis in range(3):
        point[axis] = 0.5 * (surface.position[one, axis] + surface.position[two, axis])
    square, linear, constant = _sum_at_point(quadrics.sums, surface, one, two, point)
    trace = square[0] + square[3] + square[5]
    inverse, determinant = adjugate(square, REGULARISATION * trace)
    x, y, z = 0.0, 0.0, 0.0
    if determinant > 0.0:
        x, y, z = product(inverse, linear)
        x, y, z = -x / determinant, -y / determinant, -z / determinant
    point[0], point[1], point[2] = point[0] + x, point[1] + y, point[2] + z
    error = quadratic_form(square, (x, y, z)) + 2.0 * dot(linear, (x, y, z)) + constant
    return max(error, 0.0) + FLATNESS * trace * squared_length(surface, corner)


@leaf_kernel
def plane_error(quadrics: Quadrics, surface: SurfaceMesh, corner: int, point: FloatArray) -> float:
    """Error of replacing an edge by a vertex at a position, as in `plane_optimum`."""
    one, two = (
        int(surface.vertex[next_corner(corner)]),
        int(surface.vertex[previous_corner(corner)]),
    )
    square, _, constant = _sum_at_point(quadrics.sums, surface, one, two, point)
    trace = square[0] + square[3] + square[5]
    return max(constant, 0.0) + FLATNESS * trace * squared_length(surface, corner)


@leaf_kernel
def accumulate(
    quadrics: Quadrics, surface: SurfaceMesh, kept: int, dead: int, point: FloatArray
) -> None:
    """Give the kept vertex the sum of both quadrics, relative to its new position."""
    square, linear, constant = _sum_at_point(quadrics.sums, surface, kept, dead, point)
    write_symmetric_row(quadrics.sums, kept, square)
    write_row(quadrics.sums, kept, LINEAR, linear)
    quadrics.sums[kept, CONSTANT] = constant
