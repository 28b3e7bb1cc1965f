"""The convex hull of points around a centre: incremental, in compiled code.

The hull is star-shaped about the centre, which makes an incremental hull simple. A point can only
be above the hull if it is above the face that its ray from the centre meets. A walk over the corner
table from the face of the last point finds that face. Each step crosses an edge that the ray lies
behind. The product of the ray with the pole of the face's plane then rises, so the walk never
cycles. A point above its face sees a connected part of the hull, the cavity. The cavity is replaced
by a fan of triangles from its rim to the point.

The hull starts with four seeds, the corners of a tiny tetrahedron around the centre. If the centre
is inside the hull of the points by more than the distance of the seeds, the hull absorbs all seeds.
Seeds that remain prove that the centre is not inside.

A fan is added only if its rim is one closed cycle and each triangle sees the centre from inside.
The margin is twice that of all levels. The triangles then wind around the point in one direction,
and once only, as the rim does. The fan covers the directions of the cavity once, so the new surface
projects one to one onto the sphere if the old surface did.

Points are inserted near in direction, near in time: directions are sorted along a Hilbert curve on
the sphere, so the face of each point is a few steps from the face of the point before. The points
are inserted in rounds of growing size, chosen at random, so a coarse hull exists before the fine
one is begun. No order of the input makes the work quadratic (Amenta, Choi & Rote, "Incremental
Constructions con BRIO", 2003). The random choice is a hash of the point's number, so the order is
the same in every run.

The side of a plane on which a point lies is exact (`gamutcore.geometry.predicates`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.geometry import (
    MINIMUM_DETERMINANT,
    TERMS,
    cross,
    dot,
    minus,
    next_corner,
    orientation,
    previous_corner,
    row,
    triple,
)
from gamutcore.kernels import kernel, leaf_kernel

CLEARANCE = 2.0**-30
"""Distance of the seeds from the centre ÷ largest radius: how far inside a centre must be."""

SEEDS = np.array([(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)]) / math.sqrt(3.0)

SEED_FACES = np.array([0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3])

ENOUGH = 2.0 * MINIMUM_DETERMINANT
"""Smallest determinant of a face ÷ product of the radii of its corners. Points with changed
radii keep their directions within a few times 2⁻⁵³, so half of this margin holds before and
after."""

BEHIND = 2.0**-50
"""Smallest determinant of three directions that counts as negative beyond rounding."""

WIDENINGS = 32
"""Number of attempts to widen a cavity before its point is given up."""

FORCED = 256
"""Largest number of faces that widening adds to a cavity."""

USED, FREE, CAVITIES = 0, 1, 2
"""Indices of `_Slots.counts`: faces ever used, faces on the stack, number of the last cavity."""


class _Hull(NamedTuple):
    """A growing hull."""

    position: FloatArray  # (n, 4) relative to the centre, and the distance from it; seeds first
    vertex: IndexArray  # (3 F,) corner table; free faces have −1 as vertices
    opposite: IndexArray  # (3 F,)
    # (F,) number of the last cavity that had the face; negative for a face that must be in that
    # cavity
    mark: IndexArray


class _Cavity(NamedTuple):
    """The faces that a point replaces, and working storage for their search."""

    face: IndexArray  # (F,) the removed faces, then those of the fan
    start: IndexArray  # (F,) edges of the rim, counter-clockwise around the cavity
    end: IndexArray  # (F,)
    outer: IndexArray  # (F,) the corner outside of the cavity that faces each edge of the rim
    ahead: IndexArray  # (3 F,) corners of the cavity whose edges are still to be examined
    forced: IndexArray  # (FORCED,) faces in the cavity although the point is not above them
    terms: FloatArray  # (TERMS,) for exact signs


class _Slots(NamedTuple):
    """Allocation of faces in the corner table."""

    free: IndexArray  # (F,) a stack of free faces
    counts: LongArray  # (3,) see `USED`, `FREE` and `CAVITIES`


@kernel
def radial_hull(points: FloatArray) -> IndexArray:
    """Return the triangulated convex hull of points around the origin.

    Faces are counter-clockwise from outside, and each sees the origin. The result is empty if the
    origin is not inside the hull by more than `CLEARANCE`. Points within rounding of the hull may
    or may not be vertices. The hull is fastest in the order of `insertion_order`.
    """
    count = len(points) + 4
    hull = _seeds(points)
    room = len(hull.mark)
    cavity = _Cavity(
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(3 * room, np.int32),
        np.empty(FORCED, np.int32),
        np.empty(TERMS),
    )
    slots = _Slots(np.empty(room, np.int32), np.array([4, 0, 0], np.int64))
    queue = np.arange(4, count)
    waiting, face = len(queue), 0
    # try rejected points again at the end, when the rest of the hull is final
    for may_widen in (False, True):
        left = 0
        for index in range(waiting):
            point = queue[index]
            if hull.position[point, 3] > 0.0:
                face, settled = _insert(hull, cavity, slots, point, face, may_widen)
                if not settled:
                    queue[left] = point
                    left += 1
        waiting = left
    return _faces(hull.vertex, slots.counts[USED])


@kernel
def _seeds(points: FloatArray) -> _Hull:
    """Hull of the seeds: a small regular tetrahedron around the centre."""
    count = len(points) + 4
    position = np.empty((count, 4), np.float64)
    largest = 0.0
    for index in range(len(points)):
        x, y, z = points[index, 0], points[index, 1], points[index, 2]
        radius = np.sqrt(x * x + y * y + z * z)
        position[index + 4, 0] = x
        position[index + 4, 1] = y
        position[index + 4, 2] = z
        position[index + 4, 3] = radius
        largest = max(largest, radius)
    for seed in range(4):
        for axis in range(3):
            position[seed, axis] = CLEARANCE * largest * SEEDS[seed, axis]
        position[seed, 3] = CLEARANCE * largest
    room = 2 * count
    vertex = np.empty(3 * room, np.int32)
    opposite = np.empty(3 * room, np.int32)
    for corner in range(12):
        vertex[corner] = SEED_FACES[corner]
    for corner in range(12):
        for other in range(12):
            if (
                vertex[next_corner(corner)] == vertex[previous_corner(other)]
                and vertex[previous_corner(corner)] == vertex[next_corner(other)]
            ):
                opposite[corner] = other
    return _Hull(position, vertex, opposite, np.zeros(room, np.int32))


@kernel
def _faces(vertex: IndexArray, used: int) -> IndexArray:
    """Faces in use, numbered as the points are; none if a seed is left."""
    faces = np.empty((used, 3), np.int32)
    count = 0
    for face in range(used):
        if vertex[3 * face] < 0:
            continue
        for corner in range(3):
            faces[count, corner] = vertex[3 * face + corner] - 4
        if min(faces[count, 0], faces[count, 1], faces[count, 2]) < 0:
            return faces[:0].copy()
        count += 1
    return faces[:count].copy()


@leaf_kernel
def _insert(
    hull: _Hull, cavity: _Cavity, slots: _Slots, point: int, face: int, may_widen: bool
) -> tuple[int, bool]:
    """Insert a point into the hull if it is above it; return a face near it, and if it is settled.

    The search for the next point starts at that face. The point is not settled if it is above the
    hull but its fan would not see the centre.
    """
    face = _face_in_direction(hull, point, face, slots.counts[USED])
    first = 3 * face
    one, two, three = hull.vertex[first], hull.vertex[first + 1], hull.vertex[first + 2]
    if not is_above(hull.position, one, two, three, point, cavity.terms):
        return face, True
    slots.counts[CAVITIES] += 1
    removed, edges = _open_cavity(hull, cavity, face, point, slots.counts[CAVITIES])
    if not _sees_centre(hull.position, cavity, edges, point):
        if not may_widen:
            return face, False
        removed, edges = _widen_cavity(hull, cavity, slots, face, point, edges)
        if edges == 0:
            return face, False
    _close_cavity(hull, cavity, slots, point, removed, edges)
    return cavity.face[0], True


@leaf_kernel
def _side(position: FloatArray, one: int, two: int, three: int) -> float:
    """det(p1, p2, p3): positive for three directions that are counter-clockwise from outside."""
    return triple(row(position, one, 0), row(position, two, 0), row(position, three, 0))


@leaf_kernel
def _face_in_direction(hull: _Hull, point: int, face: int, used: int) -> int:
    """Face that a point's ray from the centre meets, by a walk from another face.

    The walk ends on every convex surface. Rounding can leave a surface that is not quite convex.
    After as many steps as there are faces, all faces are examined instead.
    """
    position, vertex, opposite = hull.position, hull.vertex, hull.opposite
    radius = position[point, 3]
    entered = -1
    for _ in range(used):
        through = -1
        for corner in range(3 * face, 3 * face + 3):
            if corner != entered:
                one, two = vertex[next_corner(corner)], vertex[previous_corner(corner)]
                side = _side(position, one, two, point)
                if side < -BEHIND * position[one, 3] * position[two, 3] * radius:
                    through = corner
                    break
        if through < 0:
            return face
        entered = opposite[through]
        face = entered // 3
    best, chosen = -np.inf, face
    for candidate in range(used):
        if vertex[3 * candidate] >= 0:
            least = np.inf
            for corner in range(3 * candidate, 3 * candidate + 3):
                one, two = vertex[next_corner(corner)], vertex[previous_corner(corner)]
                side = _side(position, one, two, point)
                least = min(least, side / (position[one, 3] * position[two, 3]))
            if least > best:
                best, chosen = least, candidate
    return chosen


@leaf_kernel
def _open_cavity(
    hull: _Hull, cavity: _Cavity, face: int, point: int, number: int
) -> tuple[int, int]:
    """Collect the faces that a point is above, and their rim; return the counts of faces and edges.

    Going counter-clockwise around each face from the edge of entry gives the edges of the rim in
    order.
    """
    vertex, opposite, mark, ahead = hull.vertex, hull.opposite, hull.mark, cavity.ahead
    mark[face] = number
    cavity.face[0] = face
    ahead[0], ahead[1], ahead[2] = 3 * face + 2, 3 * face + 1, 3 * face
    removed, edges, left = 1, 0, 3
    while left > 0:
        left -= 1
        corner = opposite[ahead[left]]
        beyond = corner // 3
        if mark[beyond] == number:
            continue
        first = 3 * beyond
        if mark[beyond] == -number or is_above(
            hull.position, vertex[first], vertex[first + 1], vertex[first + 2], point, cavity.terms
        ):
            mark[beyond] = number
            cavity.face[removed] = beyond
            removed += 1
            ahead[left], ahead[left + 1] = previous_corner(corner), next_corner(corner)
            left += 2
        else:
            cavity.start[edges], cavity.end[edges] = (
                vertex[previous_corner(corner)],
                vertex[next_corner(corner)],
            )
            cavity.outer[edges] = corner
            edges += 1
    return removed, edges


@leaf_kernel
def _edge_sees_centre(position: FloatArray, cavity: _Cavity, edge: int, point: int) -> bool:
    """Whether the triangle of an edge of the rim and the point sees the centre."""
    start, end = cavity.start[edge], cavity.end[edge]
    return (
        _side(position, start, end, point)
        > ENOUGH * position[start, 3] * position[end, 3] * position[point, 3]
    )


@leaf_kernel
def _sees_centre(position: FloatArray, cavity: _Cavity, edges: int, point: int) -> bool:
    """Whether the rim is one cycle, and all triangles from it to the point see the centre."""
    if edges < 3:
        return False
    last = cavity.end[edges - 1]
    for edge in range(edges):
        if cavity.start[edge] != last or not _edge_sees_centre(position, cavity, edge, point):
            return False
        last = cavity.end[edge]
    return True


@leaf_kernel
def _widen_cavity(
    hull: _Hull, cavity: _Cavity, slots: _Slots, face: int, point: int, edges: int
) -> tuple[int, int]:
    """Add faces to a cavity until the fan sees the centre; return counts as `_open_cavity` does.

    An edge of the rim and the point may lie on one great circle within rounding. If the point is
    between the ends, the face beyond the edge joins the cavity; otherwise all faces of the middle
    vertex do. There are 0 edges if that fails, or if the point is further below such a face than
    above the hull: omitting the point is then the smaller error.
    """
    position, vertex = hull.position, hull.vertex
    allowance = max(_height(position, vertex, face, point), 0.0) + BEHIND * position[point, 3]
    forced, removed = 0, 0
    for _ in range(WIDENINGS):
        before = forced
        for edge in range(edges):
            beyond = cavity.outer[edge] // 3
            if not _edge_sees_centre(position, cavity, edge, point) and (
                hull.mark[beyond] != -slots.counts[CAVITIES]
            ):
                if forced == FORCED or _height(position, vertex, beyond, point) < -allowance:
                    return 0, 0
                hull.mark[beyond] = -slots.counts[CAVITIES]
                cavity.forced[forced] = beyond
                forced += 1
        if forced == before:
            break
        slots.counts[CAVITIES] += 1
        for index in range(forced):
            hull.mark[cavity.forced[index]] = -slots.counts[CAVITIES]
        removed, edges = _open_cavity(hull, cavity, face, point, slots.counts[CAVITIES])
        if _sees_centre(position, cavity, edges, point):
            return removed, edges
    return 0, 0


@leaf_kernel
def _height(position: FloatArray, vertex: IndexArray, face: int, point: int) -> float:
    """Height of a point above the plane of a face, in double precision."""
    a = row(position, vertex[3 * face], 0)
    b, c = row(position, vertex[3 * face + 1], 0), row(position, vertex[3 * face + 2], 0)
    normal = cross(minus(b, a), minus(c, a))
    return dot(minus(row(position, point, 0), a), normal) / np.sqrt(dot(normal, normal))


@leaf_kernel
def _close_cavity(
    hull: _Hull, cavity: _Cavity, slots: _Slots, point: int, removed: int, edges: int
) -> None:
    """Replace the cavity's faces by triangles from its rim to the point."""
    vertex, opposite, face, counts = hull.vertex, hull.opposite, cavity.face, slots.counts
    while removed < edges:
        if counts[FREE] > 0:
            counts[FREE] -= 1
            face[removed] = slots.free[counts[FREE]]
        else:
            face[removed] = counts[USED]
            counts[USED] += 1
        removed += 1
    for index in range(edges, removed):  # more faces in the cavity than in the fan
        slots.free[counts[FREE]] = face[index]
        counts[FREE] += 1
        vertex[3 * face[index]] = -1
    before = face[edges - 1]
    for edge in range(edges):
        new, outer = face[edge], cavity.outer[edge]
        vertex[3 * new], vertex[3 * new + 1], vertex[3 * new + 2] = (
            point,
            cavity.start[edge],
            cavity.end[edge],
        )
        opposite[3 * new] = outer
        opposite[outer] = 3 * new
        # consecutive triangles share the edge from the point to the vertex between them
        opposite[3 * before + 1] = 3 * new + 2
        opposite[3 * new + 2] = 3 * before + 1
        before = new


@leaf_kernel
def is_above(
    position: FloatArray, one: int, two: int, three: int, point: int, terms: FloatArray
) -> bool:
    """Whether a point is above the plane of a triangle, on its counter-clockwise side.

    A point on the plane is not above it. The answer is exact; `terms` is as for `orientation`.
    """
    a, b, c = row(position, one, 0), row(position, two, 0), row(position, three, 0)
    return orientation(a, b, c, row(position, point, 0), terms) < 0.0
