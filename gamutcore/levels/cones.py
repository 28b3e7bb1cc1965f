"""Star-shaped surfaces, and the cones of their faces: location of points, and clipping of faces.

All positions are relative to the centre. The cone of a face is the set of all rays from the centre
through the face. The cones of a star-shaped surface fill space without a gap, so every point is in
one of them. A walk from cone to adjacent cone finds it.

A face of another surface is clipped into pieces by the cones. The part of a face outside one of the
three planes of a cone passes to the neighbour across that plane. Every split writes the same
corners to both sides, so the pieces always make up the whole face despite rounding.

Data layout: a `Surface` has the corners of its faces in one array, and the faces at each vertex in
another. `Cones` has a row for each face. `Clipping` is a stack of parts of one face. A corner
(u, v) of a part is the point a + u U + v V of the face.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.errors import MeshError
from gamutcore.geometry import (
    Vector,
    cone_products,
    cross,
    dot,
    faces_not_seeing_centre,
    minus,
    opposite_corners,
    row,
    vertex_fans,
    write_row,
)
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

if TYPE_CHECKING:
    from gamutcore.geometry import TriangleMesh

INDEX = np.uint64
"""Type of indices in inner loops. Unsigned indices need no test for negative numbers, so that loops
can be vectorised."""

ROUNDING = 1e-15
"""A determinant of three points counts as zero up to this part of the product of their lengths. Its
rounding error is a few times 2⁻⁵³ of the product."""

MOVES = 1000
"""Steps of a walk before all cones are tried. A walk can go in circles if the triangulation is not
Delaunay. Walks from a face nearby are shorter than this on the largest surfaces."""

PARTS = 48
"""Most parts of a face on the stack."""

CORNERS = 24
"""Most corners of a part."""

ROW = 2 * CORNERS
"""Numbers per part."""

TRY_ALL = 2**30
"""Number of moves that marks a part for trying the cones of all faces in turn."""


class Surface(NamedTuple):
    """A closed triangle mesh about the origin, with the faces at each vertex."""

    position: FloatArray  # (V, 3)
    corner: IndexArray  # (3 F,) vertices at the corners of all faces
    fan_start: IndexArray  # (V + 1,) where the faces of each vertex begin in `fan`
    fan: IndexArray  # (3 F,) the faces at each vertex
    # (F,) upper bound of the distance from any point of the face to the reference surface; each
    # point of the reference surface is within this distance of some face, too
    deviation: FloatArray


def make_surface(position: FloatArray, corner: IndexArray) -> Surface:
    """Return a surface that is its own reference: without deviation."""
    return Surface(
        position, corner, *vertex_fans(corner, len(position)), np.zeros(len(corner) // 3)
    )


def star_shaped_surface(mesh: TriangleMesh, centre: FloatArray) -> Surface:
    """Return a mesh as a surface about a centre; MeshError if it is not star-shaped about it."""
    position = np.ascontiguousarray(mesh.vertices.astype(np.float64) - centre)
    corner = np.ascontiguousarray(mesh.faces, np.int32).ravel()
    hidden = faces_not_seeing_centre(position, corner.reshape(-1, 3))
    used = len(np.unique(corner))
    if len(hidden) or not used == len(position) == len(mesh.faces) // 2 + 2:
        raise MeshError(
            f"a mesh of {used} used vertices and {mesh.triangles} faces is not star-shaped: of"
            f" these {len(hidden)} do not see the centre from inside",
            remedy="Give closed meshes of genus 0 without other vertices, and a centre in their "
            "kernels.",
        )
    return make_surface(position, corner)


@kernel
def breadth_first(surface: Surface) -> tuple[IndexArray, IndexArray]:
    """Vertices in breadth-first order, and the predecessor of each vertex."""
    count = len(surface.position)
    order, near = np.zeros(count, np.int32), np.full(count, -1, np.int32)
    near[0] = 0
    filled = 1
    for index in range(count):
        vertex = order[index]
        for entry in range(surface.fan_start[vertex], surface.fan_start[vertex + 1]):
            for place in range(3):
                beside = surface.corner[3 * surface.fan[entry] + place]
                if near[beside] < 0:
                    near[beside] = vertex
                    order[filled] = beside
                    filled += 1
    return order, near


class Cones(NamedTuple):
    """The cones of the faces of a star-shaped surface."""

    neighbour: IndexArray  # (F, 3) the face across the edge opposite to each corner
    # (F, 9) for each corner, the vector product of the two other corners: normal to the plane
    # through the centre and the opposite edge, into the cone
    planes: FloatArray
    normal: FloatArray  # (F, 3) the vector N with N · p = 1 on the face
    slope: FloatArray  # (F,) length of N: 1 ÷ distance of the plane of the face from the centre
    rounding: FloatArray  # (F,) products of the planes with unit vectors are zero up to this value


def compute_cones(surface: Surface) -> Cones:
    """Return the cones of a closed, oriented surface that is star-shaped about the origin."""
    opposite = opposite_corners(surface.corner.reshape(-1, 3), len(surface.position))
    return Cones(opposite.reshape(-1, 3) // 3, *_cones(surface.position, surface.corner))


@kernel
def _cones(
    position: FloatArray, corner: IndexArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    faces = len(corner) // 3
    planes, normal = np.empty((faces, 9)), np.empty((faces, 3))
    slope, rounding = np.empty(faces), np.empty(faces)
    for face in range(faces):
        a = row(position, corner[3 * face], 0)
        b = row(position, corner[3 * face + 1], 0)
        c = row(position, corner[3 * face + 2], 0)
        write_row(planes, face, 0, cross(b, c))
        write_row(planes, face, 3, cross(c, a))
        write_row(planes, face, 6, cross(a, b))
        rounding[face] = ROUNDING * max(dot(a, a), dot(b, b), dot(c, c))
        # from the edges: a sum of the three planes would lose digits
        x, y, z = cross(minus(b, a), minus(c, a))
        height = dot(a, (x, y, z))
        write_row(normal, face, 0, (x / height, y / height, z / height))
        slope[face] = np.sqrt(dot((x, y, z), (x, y, z))) / height
    return planes, normal, slope, rounding


class Locations(NamedTuple):
    """Locations of points relative to a star-shaped surface."""

    face: IndexArray  # (n,) the face whose cone has the point
    beyond: FloatArray  # (n,) N · p − 1: distance from the centre ÷ that of the face, − 1
    along: FloatArray  # (n,) distance from the face along the ray


@kernel
def locate(
    position: FloatArray, order: IndexArray, near: IndexArray, cones: Cones, moves: int = MOVES
) -> Locations:
    """Locate points (n, 3), of which none is the origin, in the cones of a surface.

    They are located in the given order. A walk starts from the location of `near`, a close point
    earlier in the order; it is unused for the first point. All cones are tried after `moves` steps.
    """
    count = len(position)
    face, beyond, along = np.empty(count, np.int32), np.empty(count), np.empty(count)
    for index in range(count):
        point = order[INDEX(index)]
        place = row(position, INDEX(point), 0)
        radius = np.sqrt(dot(place, place))
        start = face[INDEX(near[INDEX(point)])] if index > 0 else 0
        found = _walk(place, radius, start, cones, moves)
        ratio = dot(row(cones.normal, INDEX(found), 0), place)
        face[INDEX(point)], beyond[INDEX(point)] = found, ratio - 1.0
        along[INDEX(point)] = abs(1.0 - 1.0 / ratio) * radius
    return Locations(face, beyond, along)


@inlined_kernel
def _walk(point: Vector, radius: float, face: int, cones: Cones, moves: int) -> int:
    """Walk to the face whose cone has a point, across the plane the point is furthest behind."""
    planes = cones.planes
    for _ in range(moves):
        one, two, three = cone_products(planes, INDEX(face), point)
        through, least = 0, one
        if two < least:
            through, least = 1, two
        if three < least:
            through, least = 2, three
        if least >= -cones.rounding[INDEX(face)] * radius:
            return face
        face = cones.neighbour[INDEX(face), through]
    chosen, best = face, -np.inf
    for face in range(len(planes)):
        one, two, three = cone_products(planes, INDEX(face), point)
        least = min(one, two, three) / (abs(one) + abs(two) + abs(three))
        if least > best:
            chosen, best = face, least
    return chosen


@inlined_kernel
def find_crossing(
    position: FloatArray, one: int, two: int, three: int, face: int, beyond: int, cones: Cones
) -> tuple[bool, float, float]:
    """Find where a triangle with two corners in a cone leaves the cone through a single plane.

    The first result states whether the cones of `face` and `beyond` hold the whole triangle. The
    others are the parts in the cone of `face` of the edges from the second and the first to the
    third corner.
    """
    side = -1
    for candidate in range(3):
        if cones.neighbour[INDEX(face), candidate] == beyond:
            side = candidate
    if side < 0:
        return False, 0.0, 0.0
    planes, at = cones.planes, INDEX(face)
    a, b = row(position, INDEX(one), 0), row(position, INDEX(two), 0)
    c = row(position, INDEX(three), 0)
    plane = row(planes, at, 3 * side)
    start_one, start_two, end = dot(plane, a), dot(plane, b), dot(plane, c)
    if not (start_one > 0.0 and start_two > 0.0 and end < 0.0):
        return False, 0.0, 0.0
    from_one, from_two = start_one / (start_one - end), start_two / (start_two - end)
    for turn in range(1, 3):
        plane = row(planes, at, 3 * ((side + turn) % 3))
        start_one, start_two, end = dot(plane, a), dot(plane, b), dot(plane, c)
        if (
            start_one + from_one * (end - start_one) < 0.0
            or start_two + from_two * (end - start_two) < 0.0
        ):
            return False, 0.0, 0.0
    return True, from_two, from_one


class Clipping(NamedTuple):
    """Work space for one face at a time."""

    frame: FloatArray  # (9,) a, U and V of the face
    source: FloatArray  # (`ROW`,) corners of the part to split; the first is repeated at the end
    part: FloatArray  # (rows × `ROW`,) stack of parts: u and v of their corners
    corners: IndexArray  # (rows,) number of corners of each part
    face: IndexArray  # (rows,) the next face whose cone clips the part
    came: IndexArray  # (rows,) the face before, or −1
    moves: IndexArray  # (rows,) number of times the whole part passed on
    value: FloatArray  # (`CORNERS`,) products of the corners with a plane
    piece: FloatArray  # (`CORNERS`, 3) u, v and N · p − 1 of the corners of the last piece
    triangle: FloatArray  # (3, 4) for the caller: positions and N · p − 1 of three corners


def clipping_workspace() -> Clipping:
    """Return work space for one face at a time."""
    rows = PARTS + 4
    return Clipping(
        frame=np.empty(9),
        source=np.empty(ROW),
        part=np.empty(rows * ROW),
        corners=np.empty(rows, np.int32),
        face=np.empty(rows, np.int32),
        came=np.empty(rows, np.int32),
        moves=np.empty(rows, np.int32),
        value=np.empty(CORNERS),
        piece=np.empty((CORNERS, 3)),
        triangle=np.empty((3, 4)),
    )


@inlined_kernel
def push_face(
    work: Clipping, position: FloatArray, one: int, two: int, three: int, face: int
) -> int:
    """Push a face that starts in the cone of `face`; return the height of the stack."""
    frame, part = work.frame, work.part
    for axis in range(3):
        frame[axis] = position[INDEX(one), axis]
        frame[3 + axis] = position[INDEX(two), axis] - position[INDEX(one), axis]
        frame[6 + axis] = position[INDEX(three), axis] - position[INDEX(one), axis]
    part[0], part[1] = 0.0, 0.0
    part[2], part[3] = 1.0, 0.0
    part[4], part[5] = 0.0, 1.0
    work.corners[0], work.face[0], work.came[0], work.moves[0] = 3, face, -1, 0
    return 1


@inlined_kernel
def pop_piece(  # noqa: C901, PLR0912  # the time is in these branches
    work: Clipping, top: int, cones: Cones, reach: float, moves: int
) -> tuple[int, int, int]:
    """Pop the next piece; return the face of its cone, its corners' number, and the stack's height.

    The face is −1 after the last piece. No corner of the clipped face may be farther from the
    origin than `reach`. A number of `moves` below `MOVES` tries all cones earlier.
    """
    part, value, frame, planes = work.part, work.value, work.frame, cones.planes
    source, neighbour = work.source, cones.neighbour
    a, b = (frame[0], frame[1], frame[2]), (frame[3], frame[4], frame[5])
    c = frame[6], frame[7], frame[8]
    while top > 0:
        base = top - 1
        face, count, moved = (
            work.face[INDEX(base)],
            work.corners[INDEX(base)],
            work.moves[INDEX(base)],
        )
        if count > CORNERS - 4:
            # two parts are equivalent to one with too many corners
            half = count // 2
            _copy(part, base, half, count, top, 1)
            _copy(part, base, 0, 1, top, 0)
            work.corners[base], work.corners[top] = half + 1, count - half + 1
            work.face[top], work.came[top], work.moves[top] = face, work.came[base], moved
            top += 1
            continue
        if moved != TRY_ALL and (moved > moves or top >= PARTS):
            face, moved = 0, TRY_ALL
        exhaustive = moved == TRY_ALL
        at, came = base, work.came[INDEX(base)]
        if exhaustive:
            came = -1
            # the part stays on the stack until all cones are tried
            if face == len(planes):
                top = base
                continue
            work.face[base], work.moves[base] = face + 1, moved
            at = top
            _copy(part, base, 0, count, at, 0)
        tolerance = cones.rounding[INDEX(face)] * reach
        for side in range(3):
            # this plane has clipped the part on its other side
            if neighbour[INDEX(face), side] == came:
                continue
            plane = row(planes, INDEX(face), 3 * side)
            constant, along_u, along_v = dot(plane, a), dot(plane, b), dot(plane, c)
            lowest, highest = np.inf, -np.inf
            start = ROW * at
            for index in range(count):
                u, v = part[INDEX(start + 2 * index)], part[INDEX(start + 2 * index + 1)]
                height = constant + along_u * u + along_v * v
                lowest = min(lowest, height)
                highest = max(highest, height)
                value[INDEX(index)] = height if abs(height) > tolerance else 0.0
                source[INDEX(2 * index)], source[INDEX(2 * index + 1)] = u, v
            if lowest < -tolerance:
                work.face[INDEX(at)] = neighbour[INDEX(face), side]
                work.came[INDEX(at)], work.moves[INDEX(at)] = face, moved + 1
                if highest <= tolerance:
                    work.corners[INDEX(at)] = count
                    count = 0
                    at += 1
                    break
                count, work.corners[INDEX(at)] = _split(part, source, value, at, count)
                at += 1
        top = base + 1 if exhaustive else at
        if count >= 3:
            for waiting in range(base, top):
                if not exhaustive:
                    work.moves[INDEX(waiting)] = 0
            normal, piece = cones.normal, work.piece
            plane = row(normal, INDEX(face), 0)
            constant, along_u, along_v = dot(plane, a) - 1.0, dot(plane, b), dot(plane, c)
            start = ROW * at
            for index in range(count):
                u, v = part[INDEX(start + 2 * index)], part[INDEX(start + 2 * index + 1)]
                piece[INDEX(index), 0], piece[INDEX(index), 1] = u, v
                piece[INDEX(index), 2] = constant + along_u * u + along_v * v
            return face, count, top
    return -1, 0, 0


@inlined_kernel
def _split(
    part: FloatArray, source: FloatArray, value: FloatArray, row: int, count: int
) -> tuple[int, int]:
    """Split a part by the signs of its values; return the number of corners of both parts.

    The outside stays, and the inside goes to row + 1. Every corner is written without a branch; the
    next corner overwrites a corner on the wrong side.
    """
    outside, inside = ROW * row, ROW * (row + 1)
    first_inside, first_outside = inside, outside
    u, v, here = source[0], source[1], value[0]
    source[INDEX(2 * count)], source[INDEX(2 * count + 1)], value[INDEX(count)] = u, v, here
    for index in range(1, count + 1):
        next_u, next_v, there = (
            source[INDEX(2 * index)],
            source[INDEX(2 * index + 1)],
            value[INDEX(index)],
        )
        part[INDEX(inside)], part[INDEX(inside + 1)] = u, v
        inside += 2 if here >= 0.0 else 0
        part[INDEX(outside)], part[INDEX(outside + 1)] = u, v
        outside += 2 if here <= 0.0 else 0
        share = here / (here - there)
        u += share * (next_u - u)
        v += share * (next_v - v)
        part[INDEX(inside)], part[INDEX(inside + 1)] = u, v
        part[INDEX(outside)], part[INDEX(outside + 1)] = u, v
        crossed = 2 if ((here > 0.0) & (there < 0.0)) | ((here < 0.0) & (there > 0.0)) else 0
        inside += crossed
        outside += crossed
        u, v, here = next_u, next_v, there
    return (inside - first_inside) // 2, (outside - first_outside) // 2


@leaf_kernel
def _copy(part: FloatArray, source: int, first: int, last: int, target: int, start: int) -> None:
    for number in range(2 * (last - first)):
        part[INDEX(ROW * target + 2 * start + number)] = part[
            INDEX(ROW * source + 2 * first + number)
        ]
