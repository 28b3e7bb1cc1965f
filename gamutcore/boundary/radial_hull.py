"""The convex hull of points around a centre, one point after the other, in compiled code.

The hull is star-shaped about the centre, and that makes an incremental hull simple. A point can
only be above the hull if it is above the face that its ray from the centre passes, and a walk over
the corner table from the face before finds that one: crossing an edge that the ray lies behind
raises the ray's product with the pole of the face's plane, so that the walk never goes in circles.
A point above its face sees a connected part of the hull, the cavity, which is taken out and
replaced by a fan of triangles from the cavity's rim to the point.

It starts from four seeds, the corners of a tiny tetrahedron around the centre. Where the centre is
inside the hull of the points, by more than the seeds' distance, the hull swallows them; where they
are not swallowed, it is not.

What makes the result valid: a fan is put in only if the rim is one closed cycle and each of its
triangles sees the centre from inside, by twice the margin that all levels are held to. The
triangles then turn around the point in one direction, and as the rim goes around the point once,
they turn around it once: the fan covers the cavity's directions once, and the new surface projects
onto the sphere one to one if the old one did.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.boundary.orientation import is_above
from gamutcore.corner_table import following, preceding
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.star_shape import MINIMUM_DETERMINANT

__all__ = ["CLEARANCE", "radial_hull"]

CLEARANCE = 2.0**-30
"""Distance of the seeds from the centre ÷ largest radius: how far inside a centre has to be."""

SEEDS = np.array([(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)]) / math.sqrt(3.0)
SEED_FACES = np.array([0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3])

ENOUGH = 2.0 * MINIMUM_DETERMINANT
"""Smallest determinant of a face ÷ the product of its corners' radii. Points whose radii have been
changed keep their directions within a few times 2⁻⁵³, so half of this holds before as after."""

BEHIND = 2.0**-50
"""A determinant of three directions that counts as negative: beyond what rounding makes of 0."""

WIDENINGS = 32
"""How often a cavity is widened before its point is given up."""

FORCED = 256
"""How many faces may be added to a cavity by widening."""


class Hull(NamedTuple):
    """A hull while it grows.

    Attributes
    ----------
    position : (n, 4) float64
        Coordinates relative to the centre, and their distance from it; the seeds come first.
    vertex, opposite : (3 F,) int32
        The corner table; faces that are free have −1 as vertices.
    mark : (F,) int32
        The number of the last cavity that a face was in; negative: it is to be in that one.
    """

    position: FloatArray
    vertex: IndexArray
    opposite: IndexArray
    mark: IndexArray


class Cavity(NamedTuple):
    """The faces that a point replaces, and working storage to find them.

    Attributes
    ----------
    face : (F,) int32
        The faces taken out, then those of the fan.
    start, end : (F,) int32
        Vertices of the rim's edges, counter-clockwise around the cavity.
    outer : (F,) int32
        The corner that faces each of the rim's edges from without.
    ahead : (3 F,) int32
        Corners of the cavity whose edges are still to be looked at.
    forced : (FORCED,) int32
        Faces that are in the cavity though the point is not above them.
    """

    face: IndexArray
    start: IndexArray
    end: IndexArray
    outer: IndexArray
    ahead: IndexArray
    forced: IndexArray


class Slots(NamedTuple):
    """The faces' places in the corner table.

    Attributes
    ----------
    free : (F,) int32
        A stack of faces that are free again.
    counts : (3,) int64
        Faces ever used, length of the stack, number of the last cavity.
    """

    free: IndexArray
    counts: LongArray


@kernel
def radial_hull(points: FloatArray) -> IndexArray:
    """Triangulated convex hull of points around the origin.

    Parameters
    ----------
    points : (n, 3) float64
        Best in the order of `gamutcore.boundary.insertion_order`. Points at the origin and
        duplicates do no harm.

    Returns
    -------
    (F, 3) int32
        Counter-clockwise from outside; closed, of genus 0, and every face sees the origin. Empty
        if the origin is not inside the hull by more than `CLEARANCE`. Points on the hull within
        rounding may be vertices or not.
    """
    count = len(points) + 4
    hull = _seeds(points)
    room = len(hull.mark)
    cavity = Cavity(
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(3 * room, np.int32),
        np.empty(FORCED, np.int32),
    )
    slots = Slots(np.empty(room, np.int32), np.array([4, 0, 0], np.int64))
    queue = np.arange(4, count)
    waiting, face = len(queue), 0
    # points that could not be put in are tried again when the hull is the final one but for them,
    # so that what they would displace is known
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
    return _faces(hull.vertex, slots.counts[0])


@kernel
def _seeds(points: FloatArray) -> Hull:
    """Start with a small regular tetrahedron around the centre."""
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
                vertex[following(corner)] == vertex[preceding(other)]
                and vertex[preceding(corner)] == vertex[following(other)]
            ):
                opposite[corner] = other
    return Hull(position, vertex, opposite, np.zeros(room, np.int32))


@kernel
def _faces(vertex: IndexArray, used: int) -> IndexArray:
    """Faces in use, numbered as the points are; none if a seed is left."""
    faces = np.empty((used, 3), np.int32)
    count = 0
    for face in range(used):
        if vertex[3 * face] < 0:
            continue
        for place in range(3):
            faces[count, place] = vertex[3 * face + place] - 4
        if min(faces[count, 0], faces[count, 1], faces[count, 2]) < 0:
            return faces[:0].copy()
        count += 1
    return faces[:count].copy()


@leaf_kernel
def _insert(
    hull: Hull, cavity: Cavity, slots: Slots, point: int, face: int, may_widen: bool
) -> tuple[int, bool]:
    """Put a point into the hull if it is above it.

    Returns
    -------
    face : int
        One near the point, to start from for the next.
    settled : bool
        False if the point is above the hull and yet has not been put in, because the fan would not
        see the centre.
    """
    face = _face_in_direction(hull, point, face, slots.counts[0])
    first = 3 * face
    one, two, three = hull.vertex[first], hull.vertex[first + 1], hull.vertex[first + 2]
    if not is_above(hull.position, one, two, three, point):
        return face, True
    slots.counts[2] += 1
    removed, edges = _open_cavity(hull, cavity, face, point, slots.counts[2])
    if not _sees_centre(hull.position, cavity, edges, point):
        if not may_widen:
            return face, False
        removed, edges = _widened_cavity(hull, cavity, slots, face, point, edges)
        if edges == 0:
            return face, False
    _close_cavity(hull, cavity, slots, point, removed, edges)
    return cavity.face[0], True


@leaf_kernel
def _side(position: FloatArray, one: int, two: int, three: int) -> float:
    """det(p1, p2, p3): positive if they are counter-clockwise seen from outside."""
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
    x, y, z = position[three, 0], position[three, 1], position[three, 2]
    return x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)


@leaf_kernel
def _face_in_direction(hull: Hull, point: int, face: int, used: int) -> int:
    """Face that a point's ray from the centre passes, walking from another.

    The walk ends on every convex surface. Should rounding have left one that is not quite convex,
    it is given up after as many steps as there are faces, and all of them are looked at.
    """
    position, vertex, opposite = hull.position, hull.vertex, hull.opposite
    radius = position[point, 3]
    entered = -1
    for _ in range(used):
        through = -1
        for corner in range(3 * face, 3 * face + 3):
            if corner != entered:
                one, two = vertex[following(corner)], vertex[preceding(corner)]
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
                one, two = vertex[following(corner)], vertex[preceding(corner)]
                side = _side(position, one, two, point)
                least = min(least, side / (position[one, 3] * position[two, 3]))
            if least > best:
                best, chosen = least, candidate
    return chosen


@leaf_kernel
def _open_cavity(hull: Hull, cavity: Cavity, face: int, point: int, number: int) -> tuple[int, int]:
    """Gather the faces that a point is above, from one of them outwards, and their rim.

    Going around each face counter-clockwise from where it was entered gives the rim's edges in
    their order.

    Returns
    -------
    removed, edges : int
        Number of faces in `cavity.face`, and of edges in `cavity.start`, `end` and `outer`.
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
            hull.position, vertex[first], vertex[first + 1], vertex[first + 2], point
        ):
            mark[beyond] = number
            cavity.face[removed] = beyond
            removed += 1
            ahead[left], ahead[left + 1] = preceding(corner), following(corner)
            left += 2
        else:
            cavity.start[edges], cavity.end[edges] = (
                vertex[preceding(corner)],
                vertex[following(corner)],
            )
            cavity.outer[edges] = corner
            edges += 1
    return removed, edges


@leaf_kernel
def _edge_sees_centre(position: FloatArray, cavity: Cavity, edge: int, point: int) -> bool:
    start, end = cavity.start[edge], cavity.end[edge]
    return (
        _side(position, start, end, point)
        > ENOUGH * position[start, 3] * position[end, 3] * position[point, 3]
    )


@leaf_kernel
def _sees_centre(position: FloatArray, cavity: Cavity, edges: int, point: int) -> bool:
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
def _widened_cavity(
    hull: Hull, cavity: Cavity, slots: Slots, face: int, point: int, edges: int
) -> tuple[int, int]:
    """Add faces to a cavity until the fan sees the centre.

    Where an edge of the rim and the point lie on one great circle within rounding, the middle one
    of the three is on the line between the others. If that is the point, it splits the edge, and
    the face beyond belongs to the cavity; if it is a vertex, all its faces do.

    A face that the point is further below than it is above the hull is not added: leaving the
    point out is the lesser evil then.

    Returns
    -------
    removed, edges : int
        As from `_open_cavity`; 0 edges if it cannot be done.
    """
    position, vertex = hull.position, hull.vertex
    allowance = max(_height(position, vertex, face, point), 0.0) + BEHIND * position[point, 3]
    forced, removed = 0, 0
    for _ in range(WIDENINGS):
        before = forced
        for edge in range(edges):
            beyond = cavity.outer[edge] // 3
            if not _edge_sees_centre(position, cavity, edge, point) and (
                hull.mark[beyond] != -slots.counts[2]
            ):
                if forced == FORCED or _height(position, vertex, beyond, point) < -allowance:
                    return 0, 0
                hull.mark[beyond] = -slots.counts[2]
                cavity.forced[forced] = beyond
                forced += 1
        if forced == before:
            break
        slots.counts[2] += 1
        for index in range(forced):
            hull.mark[cavity.forced[index]] = -slots.counts[2]
        removed, edges = _open_cavity(hull, cavity, face, point, slots.counts[2])
        if _sees_centre(position, cavity, edges, point):
            return removed, edges
    return 0, 0


@leaf_kernel
def _height(position: FloatArray, vertex: IndexArray, face: int, point: int) -> float:
    """Height of a point above the plane of a face, in double precision."""
    one, two, three = vertex[3 * face], vertex[3 * face + 1], vertex[3 * face + 2]
    x, y, z = position[one, 0], position[one, 1], position[one, 2]
    ux, uy, uz = position[two, 0] - x, position[two, 1] - y, position[two, 2] - z
    vx, vy, vz = position[three, 0] - x, position[three, 1] - y, position[three, 2] - z
    px, py, pz = position[point, 0] - x, position[point, 1] - y, position[point, 2] - z
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return (px * nx + py * ny + pz * nz) / np.sqrt(nx * nx + ny * ny + nz * nz)


@leaf_kernel
def _close_cavity(
    hull: Hull, cavity: Cavity, slots: Slots, point: int, removed: int, edges: int
) -> None:
    """Replace the cavity's faces by triangles from its rim to the point."""
    vertex, opposite, face, counts = hull.vertex, hull.opposite, cavity.face, slots.counts
    while removed < edges:
        if counts[1] > 0:
            counts[1] -= 1
            face[removed] = slots.free[counts[1]]
        else:
            face[removed] = counts[0]
            counts[0] += 1
        removed += 1
    for index in range(edges, removed):  # vertices inside the cavity took more faces than the fan
        slots.free[counts[1]] = face[index]
        counts[1] += 1
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
        # triangles that follow each other share the edge from the point to the vertex between them
        opposite[3 * before + 1] = 3 * new + 2
        opposite[3 * new + 2] = 3 * before + 1
        before = new
