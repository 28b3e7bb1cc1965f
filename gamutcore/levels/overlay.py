"""Comparison of two surfaces that are star-shaped about one centre: volumes and distances.

All positions are relative to the centre. The cone of a face is the set of all rays from the centre
through the face. The cones of a star-shaped surface fill space without a gap, so every point is in
one of them. A walk from cone to adjacent cone finds it.

**Clipping.** A face of one surface is clipped into pieces by the cones of the other. The part of a
face outside one of the three planes of a cone passes to the neighbour across that plane. Every
split writes the same corners to both sides, so the pieces always make up the whole face despite
rounding. Most faces are seen through one face or cross a single edge; the others are clipped as
polygons.

**Volumes.** Each piece is seen through a single face of the other surface, whose plane is
N · p = 1. On the ray through a point p, the other surface is 1 ÷ (N · p) times as far from the
centre. N · p is linear on the piece, so volumes are closed forms.

**Distances.** The distance from a point to one face is a convex function of the point. Over a piece
its maximum is at a corner of the piece. The distance from a piece to a surface is therefore at most
the largest distance of its corners to any one face. The bound is valid for any choice of faces, and
tight for the nearest faces. Descent from face to adjacent face finds them. Pieces without a good
bound are halved (`raise_bound`).

Data layout: a `Surface` has the corners of its faces in one array, and the faces at each vertex in
another. `Cones` has a row for each face. `Clipping` is a stack of parts of one face. A corner
(u, v) of a part is the point a + u U + v V of the face. An array of `BOUNDS` numbers has the bounds
of the distances in both directions, the points where they are attained, and the halvings that are
left. Triangles of pieces are pushed to a queue, and a full queue is integrated in one loop without
branches, which the compiler vectorises: a third of the time. Results are added to the sums of the
faces in the order of the queue, so they do not depend on the batches.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.errors import MeshError
from gamutcore.geometry import (
    Vector,
    closest_point,
    cone_products,
    cross,
    dot,
    faces_not_seeing_centre,
    minus,
    opposite_corners,
    row,
    scaled,
    vertex_fans,
    write_row,
)
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

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


FROM_LOWER, FROM_UPPER, TO_LOWER, TO_UPPER, HALVINGS_LEFT, SLACK_USED = range(6)
FROM_POINT, TO_POINT, TO_FACE, BOUNDS = 6, 9, 12, 13
"""Elements of the array of bounds, and their number.

`FROM_LOWER` and `FROM_UPPER` bound the distances from the reference to the other surface.
`TO_LOWER` and `TO_UPPER` bound those from the other surface to the reference. `HALVINGS_LEFT` is
the number of halvings that are still allowed. An upper bound of at most `SLACK_USED` times the
lower is not improved. `FROM_POINT` and `TO_POINT` are the first of the three coordinates of points
at which `FROM_LOWER` and `TO_LOWER` are attained. `TO_FACE` is the face of the other surface that
the latter point is on.
"""

SLACK = 1.03
"""Ratio of a bound to an attained distance at which the bound is not improved further."""

HALVINGS = 16
"""Most halvings of a piece; its bound then stays."""

FACE, HALVED, NEAREST, SQUARED, COLUMNS = 9, 10, 11, 14, 17
"""Columns of the stack of `raise_bound`, after nine coordinates: a face near the piece, the number
of halvings, then for each corner the nearest face (−1 if unknown) and its squared distance."""

ATTAINED = HALVINGS + 2
"""Row of the stack with the point at which the lower bound was attained last."""

STACK = (HALVINGS + 3, COLUMNS)
"""Shape of the work array of `raise_bound`."""


def new_bounds(halvings: float, slack: float) -> FloatArray:
    """Return an array of bounds with nothing known."""
    bounds = np.zeros(BOUNDS)
    bounds[HALVINGS_LEFT], bounds[SLACK_USED] = halvings, slack
    return bounds


def halving_limit(surface: Surface, least: float = 10_000.0) -> float:
    """Return the most halvings of a comparison with a surface.

    A halving takes 1 to 4 µs. A quarter of the number of faces is a few times the need of device
    gamuts in CIELAB. `least` is added; smaller values give looser bounds for very flat bodies.
    """
    return least + len(surface.corner) // 12


@leaf_kernel
def raise_lower_bounds(
    reference: Surface,
    other: Surface,
    locations: Locations,
    points: IndexArray,
    bounds: FloatArray,
) -> None:
    """Raise all bounds by some vertices (m,) of the reference, and the other surface on their rays.

    `locations` has the vertices of the reference relative to the other surface.
    """
    position, deviation = reference.position, reference.deviation
    for index in range(len(points)):
        vertex = points[index]
        point = row(position, vertex, 0)
        face = reference.fan[INDEX(reference.fan_start[vertex + 1] - 1)]
        own = deviation[INDEX(face)]
        if locations.along[vertex] + own > bounds[FROM_LOWER]:
            _, squared = nearest_face(point, other, locations.face[vertex])
            if np.sqrt(squared) + own > bounds[FROM_LOWER]:
                bounds[FROM_LOWER] = np.sqrt(squared) + own
                bounds[FROM_POINT], bounds[FROM_POINT + 1], bounds[FROM_POINT + 2] = point
        if locations.along[vertex] + own > bounds[TO_LOWER]:
            point = scaled(1.0 / (1.0 + locations.beyond[vertex]), point)
            face, squared = nearest_face(point, reference, face)
            if np.sqrt(squared) + deviation[face] > bounds[TO_LOWER]:
                bounds[TO_LOWER] = np.sqrt(squared) + deviation[face]
                bounds[TO_POINT], bounds[TO_POINT + 1], bounds[TO_POINT + 2] = point
                bounds[TO_FACE] = locations.face[vertex]
    slack = bounds[SLACK_USED]
    bounds[FROM_UPPER] = max(bounds[FROM_UPPER], slack * bounds[FROM_LOWER])
    bounds[TO_UPPER] = max(bounds[TO_UPPER], slack * bounds[TO_LOWER])


@leaf_kernel
def raise_bounds(
    triangle: FloatArray,
    stack: FloatArray,
    reference: Surface,
    face: int,
    other: Surface,
    through: int,
    bounds: FloatArray,
    deviation: FloatArray,
) -> None:
    """Raise the bounds so that they hold for a triangle of the reference, seen through a face.

    The distance of a corner along its ray is at least its distance from the face, in both
    directions. The largest distance of a corner holds for the whole triangle, also for `deviation`.
    """
    furthest, own = 0.0, reference.deviation[face]
    for index in range(3):
        point = row(triangle, index, 0)
        shift = 1.0 - 1.0 / (1.0 + triangle[index, 3])
        furthest = max(furthest, shift * shift * dot(point, point))
    furthest = np.sqrt(furthest) + own
    if furthest > deviation[through]:
        # on steep faces the distance along rays is far larger than the distance from the face
        squared = 0.0
        for index in range(3):
            point = row(triangle, index, 0)
            squared = max(squared, squared_distance(point, other, through))
            point = scaled(1.0 / (1.0 + triangle[index, 3]), point)
            squared = max(squared, squared_distance(point, reference, face))
        deviation[through] = max(deviation[through], own + np.sqrt(squared))
    if furthest > bounds[FROM_UPPER]:
        for index in range(3):
            write_row(stack, 0, 3 * index, row(triangle, index, 0))
        before = bounds[FROM_LOWER]
        bounds[FROM_LOWER], bounds[FROM_UPPER], bounds[HALVINGS_LEFT] = raise_bound(
            stack,
            other,
            through,
            own,
            bounds[FROM_LOWER],
            bounds[FROM_UPPER],
            bounds[HALVINGS_LEFT],
            bounds[SLACK_USED],
        )
        if bounds[FROM_LOWER] > before:
            _keep_point(bounds, FROM_POINT, stack)
    if furthest > bounds[TO_UPPER]:
        for index in range(3):
            for axis in range(3):
                stack[0, 3 * index + axis] = triangle[index, axis] / (1.0 + triangle[index, 3])
        before = bounds[TO_LOWER]
        bounds[TO_LOWER], bounds[TO_UPPER], bounds[HALVINGS_LEFT] = raise_bound(
            stack,
            reference,
            face,
            0.0,
            bounds[TO_LOWER],
            bounds[TO_UPPER],
            bounds[HALVINGS_LEFT],
            bounds[SLACK_USED],
        )
        if bounds[TO_LOWER] > before:
            bounds[TO_FACE] = through
            _keep_point(bounds, TO_POINT, stack)


@inlined_kernel
def _keep_point(bounds: FloatArray, start: int, stack: FloatArray) -> None:
    for axis in range(3):
        bounds[start + axis] = stack[ATTAINED, axis]


@leaf_kernel
def raise_bound(
    stack: FloatArray,
    surface: Surface,
    face: int,
    deviation: float,
    lower: float,
    upper: float,
    halvings: float,
    slack: float,
) -> tuple[float, float, float]:
    """Raise bounds of the largest distance to a surface so that they hold for a triangle too.

    `stack` begins with the corners of the triangle; `ATTAINED` receives the point if `lower` rises.
    `face` is near the triangle, and `deviation` is added to all distances. Bounds of at most
    `slack` times an attained distance are not improved. The result is `lower`, `upper` and the
    halvings left. `upper` is certain; `lower` is attained if descent found the nearest faces.
    """
    stack[0, FACE], stack[0, HALVED] = face, 0.0
    for corner in range(3):
        stack[0, NEAREST + corner] = -1.0
    top = 1
    while top > 0:
        top -= 1
        face = int(stack[top, FACE])
        accepted = max(upper, slack * lower)
        if (
            np.sqrt(_bound(stack, top, surface, face)) + surface.deviation[face] + deviation
            <= accepted
        ):
            upper = accepted
            continue
        # a half shares two corners with the whole; their nearest faces are known
        for corner in range(3):
            if stack[top, NEAREST + corner] < 0.0:
                near, squared = nearest_face(row(stack, top, 3 * corner), surface, face)
                stack[top, NEAREST + corner], stack[top, SQUARED + corner] = near, squared
        one, two = int(stack[top, NEAREST]), int(stack[top, NEAREST + 1])
        three = int(stack[top, NEAREST + 2])
        attained = max(
            np.sqrt(stack[top, SQUARED]) + surface.deviation[one],
            np.sqrt(stack[top, SQUARED + 1]) + surface.deviation[two],
            np.sqrt(stack[top, SQUARED + 2]) + surface.deviation[three],
        )
        bound = np.sqrt(_bound(stack, top, surface, one)) + surface.deviation[one]
        if two != one:
            bound = min(bound, np.sqrt(_bound(stack, top, surface, two)) + surface.deviation[two])
        if three not in (one, two):
            bound = min(
                bound, np.sqrt(_bound(stack, top, surface, three)) + surface.deviation[three]
            )
        attained, bound = attained + deviation, bound + deviation
        # after a descent that ended too early, the bound may be below the distance found
        lower = _raised(lower, min(attained, bound), stack, top)
        if bound <= max(upper, slack * lower) or halvings <= 0.0 or stack[top, HALVED] >= HALVINGS:
            upper = max(upper, bound)
            continue
        # halve the longest edge; each half starts from the face nearest to its own end
        longest, greatest = 0, -1.0
        for edge in range(3):
            along = minus(row(stack, top, 3 * edge), row(stack, top, 3 * ((edge + 1) % 3)))
            if dot(along, along) > greatest:
                longest, greatest = edge, dot(along, along)
        first, second = 3 * longest, 3 * ((longest + 1) % 3)
        for column in range(COLUMNS):
            stack[top + 1, column] = stack[top, column]
        for axis in range(3):
            middle = 0.5 * (stack[top, first + axis] + stack[top, second + axis])
            stack[top, second + axis] = middle
            stack[top + 1, first + axis] = middle
        stack[top, HALVED] += 1.0
        stack[top + 1, HALVED] = stack[top, HALVED]
        stack[top, FACE] = one if first == 0 else two if first == 3 else three
        stack[top + 1, FACE] = one if second == 0 else two if second == 3 else three
        stack[top, NEAREST + second // 3] = stack[top + 1, NEAREST + first // 3] = -1.0
        top += 2
        halvings -= 1.0
    return lower, upper, halvings


@inlined_kernel
def _raised(lower: float, attained: float, stack: FloatArray, top: int) -> float:
    """Return the larger bound; keep the furthest corner as `ATTAINED` if `attained` is larger."""
    if attained <= lower:
        return lower
    furthest = 0
    for corner in range(1, 3):
        if stack[top, SQUARED + corner] > stack[top, SQUARED + furthest]:
            furthest = corner
    write_row(stack, ATTAINED, 0, row(stack, top, 3 * furthest))
    return attained


@inlined_kernel
def _bound(piece: FloatArray, top: int, surface: Surface, face: int) -> float:
    """Largest squared distance from the corners of a piece to a face."""
    return max(
        squared_distance(row(piece, top, 0), surface, face),
        squared_distance(row(piece, top, 3), surface, face),
        squared_distance(row(piece, top, 6), surface, face),
    )


@leaf_kernel
def nearest_face(point: Vector, surface: Surface, face: int) -> tuple[int, float]:
    """Return a face near a point and its squared distance, by descent from a face.

    No face that shares a vertex with the result is nearer. On concave surfaces the result may be a
    local minimum; its distance is then an upper bound.
    """
    corner, fan_start, fan = surface.corner, surface.fan_start, surface.fan
    least = squared_distance(point, surface, face)
    before_one, before_two, before_three = -1, -1, -1
    while True:
        best = face
        for place in range(3):
            vertex = corner[3 * face + place]
            # all faces at the vertices of the previous face have been visited
            if vertex in (before_one, before_two, before_three):
                continue
            for index in range(fan_start[vertex], fan_start[vertex + 1]):
                other = fan[index]
                if other != face:
                    distance = squared_distance(point, surface, other)
                    if distance < least:
                        least, best = distance, other
        if best == face:
            return face, least
        before_one, before_two = corner[3 * face], corner[3 * face + 1]
        before_three = corner[3 * face + 2]
        face = best


@inlined_kernel
def squared_distance(point: Vector, surface: Surface, face: int) -> float:
    """Squared distance from a point to a face; rounding never makes it too small."""
    position = surface.position
    a = row(position, surface.corner[3 * face], 0)
    b = minus(row(position, surface.corner[3 * face + 1], 0), a)
    c = minus(row(position, surface.corner[3 * face + 2], 0), a)
    return closest_point(minus(point, a), b, c)[0]


@leaf_kernel
def set_corner(triangle: FloatArray, at: int, position: FloatArray, vertex: int, d: float) -> None:
    """Set a corner of a triangle to a vertex, where N · p − 1 is `d`."""
    write_row(triangle, at, 0, row(position, vertex, 0))
    triangle[at, 3] = d


@leaf_kernel
def set_crossing(
    triangle: FloatArray, at: int, position: FloatArray, one: int, two: int, share: float, d: float
) -> None:
    """Set a corner of a triangle to the point at a share of an edge, where N · p − 1 is `d`."""
    for axis in range(3):
        start = position[one, axis]
        triangle[at, axis] = start + share * (position[two, axis] - start)
    triangle[at, 3] = d


CAPACITY = 256
"""Triangles in a queue. With their integrals they take 20 kB, which fit into the L1 cache."""

ONE, TWO, THREE, FOUR, FIVE, SIX = (INDEX(row * CAPACITY) for row in range(1, 7))
"""First indices of the rows of a queue after the first."""


@dataclass(frozen=True)
class Distances:
    """Distances of the points of one surface from another surface.

    Attributes
    ----------
    mean : float
        Mean over the area of the distance from the plane of the other surface's face on the same
        ray. It is close to the mean distance from the surface if the surfaces are close.
    maximum : float
        Upper bound of the largest distance from the surface, usually within a few per cent.
    """

    mean: float
    maximum: float


@dataclass(frozen=True)
class RadialDifference:
    """Difference of two surfaces.

    Attributes
    ----------
    volume : float
        Volume within the reference.
    other_volume : float
        Volume within the other surface.
    difference : float
        Volume of the symmetric difference, exact except for rounding.
    from_reference : Distances
        Distances of the points of the reference from the other surface.
    to_reference : Distances
        Distances of the points of the other surface from the reference.
    """

    volume: float
    other_volume: float
    difference: float
    from_reference: Distances
    to_reference: Distances

    @property
    def mismatch(self) -> float:
        """Volume of the symmetric difference ÷ volume of the reference."""
        return self.difference / self.volume


def radial_difference(
    reference: TriangleMesh, other: TriangleMesh, centre: ArrayLike
) -> RadialDifference:
    """Compare two surfaces that are star-shaped about the same centre.

    Parameters
    ----------
    reference, other : TriangleMesh
        Closed, oriented, of genus 0, and star-shaped about the centre.
    centre : (3,) array_like

    Returns
    -------
    RadialDifference

    Raises
    ------
    MeshError
        If a mesh is not star-shaped about the centre.
    """
    origin = np.asarray(centre, np.float64)
    one, two = star_shaped_surface(reference, origin), star_shaped_surface(other, origin)
    # clipping the finer surface by the coarser one is faster than the reverse
    swapped = len(two.corner) > len(one.corner)
    if swapped:
        one, two = two, one
    result, _ = compare_surfaces(one, two, *breadth_first(one))
    if not swapped:
        return result
    return RadialDifference(
        volume=result.other_volume,
        other_volume=result.volume,
        difference=result.difference,
        from_reference=result.to_reference,
        to_reference=result.from_reference,
    )


def compare_surfaces(
    reference: Surface,
    other: Surface,
    order: IndexArray,
    near: IndexArray,
    *,
    bounds: FloatArray | None = None,
    moves: int = MOVES,
) -> tuple[RadialDifference, FloatArray]:
    """Compare two surfaces that are star-shaped about the origin; the reference is the finer one.

    A finer `other` gives the same result in more time. `order` and `near` (V,) are those of
    `locate` for the reference's vertices. `bounds` come from `new_bounds` and are updated; by
    default distances are within 3 %. Largest distances, and the returned deviations (F,) of the
    other surface's faces, refer to the surface that the reference represents.
    """
    cones = compute_cones(other)
    locations = locate(reference.position, order, near, cones, moves)
    if bounds is None:
        bounds = new_bounds(halving_limit(reference), SLACK)
    deviation, sums = np.zeros(len(other.deviation)), np.zeros((len(other.deviation), 3))
    raise_lower_bounds(reference, other, locations, order, bounds)
    waiting = _Queue(np.zeros(7 * CAPACITY), np.zeros(CAPACITY, np.int32), np.zeros(3 * CAPACITY))
    volume, area = _integrate_surfaces(
        reference,
        other,
        cones,
        locations,
        _Workspace(clipping_workspace(), waiting, np.empty(STACK)),
        bounds,
        sums,
        deviation,
        moves,
    )
    difference, first, second = sums.sum(axis=0).tolist()
    other_volume, other_area = _volume_and_area(other)
    result = RadialDifference(
        volume=volume,
        other_volume=other_volume,
        difference=difference,
        from_reference=Distances(first / area, float(bounds[FROM_UPPER])),
        to_reference=Distances(second / other_area, float(bounds[TO_UPPER])),
    )
    return result, deviation


def enclosed_volume(surface: Surface) -> float:
    """Return the volume within a surface that is star-shaped about the origin."""
    return _volume_and_area(surface)[0]


@leaf_kernel
def _volume_and_area(surface: Surface) -> tuple[float, float]:
    """Volume and area."""
    position, corner = surface.position, surface.corner
    volume, area = 0.0, 0.0
    for face in range(len(corner) // 3):
        one, two, three = _corners(corner, face)
        part, whole = _face_extent(position, one, two, three)
        volume += part
        area += whole
    return volume, area


@leaf_kernel
def _face_extent(position: FloatArray, one: int, two: int, three: int) -> tuple[float, float]:
    """Volume between a face and the centre, and the area of the face."""
    a = row(position, one, 0)
    across = cross(minus(row(position, two, 0), a), minus(row(position, three, 0), a))
    return dot(a, across) / 6.0, 0.5 * np.sqrt(dot(across, across))


@inlined_kernel
def _corners(corner: IndexArray, face: int) -> tuple[Any, Any, Any]:
    """Vertices of a face, as `INDEX`."""
    at = INDEX(3 * face)
    return INDEX(corner[at]), INDEX(corner[at + INDEX(1)]), INDEX(corner[at + INDEX(2)])


class _Queue(NamedTuple):
    """A queue of triangles, and room for their integrals."""

    # (7 `CAPACITY`,) seven rows: N · p − 1 at the three corners, the weights of the three
    # integrals, and the length of N
    triangle: FloatArray
    face: IndexArray  # (`CAPACITY`,) the face that each triangle is seen through
    integral: FloatArray  # (3 `CAPACITY`,) three rows of results of `_integrate`


class _Workspace(NamedTuple):
    """Work space for `_integrate_surfaces`. The queue `waiting` is empty between calls."""

    clipping: Clipping
    waiting: _Queue
    stack: FloatArray


@leaf_kernel
def _integrate_surfaces(  # noqa: C901, PLR0912  # the time is in these branches
    reference: Surface,
    other: Surface,
    cones: Cones,
    locations: Locations,
    workspace: _Workspace,
    bounds: FloatArray,
    sums: FloatArray,
    deviation: FloatArray,
    moves: int,
) -> tuple[float, float]:
    """Integrate over the pieces of all faces; return volume and area of the reference.

    `locations` has the reference's vertices in `cones`, those of the other surface. `bounds` (see
    `new_bounds`), `sums` and `deviation` (F,) are updated. `sums` (F, 3) has, for each face of the
    other surface, integrals over the pieces seen through it: the volume of the symmetric
    difference, and distances from the planes over the reference and over the other surface.
    """
    work, waiting, stack = workspace
    position, corner, triangle = reference.position, reference.corner, work.triangle
    beyond, along, slope = locations.beyond, locations.along, cones.slope
    volume, area = 0.0, 0.0
    queued = 0
    for face in range(len(corner) // 3):
        if queued > CAPACITY - 3:
            _flush(waiting, queued, sums)
            queued = 0
        one, two, three = _corners(corner, face)
        # rotate the corners so that the first two share a cone if any two do
        if locations.face[two] == locations.face[three]:
            one, two, three = two, three, one
        elif locations.face[three] == locations.face[one]:
            one, two, three = three, one, two
        through, last = locations.face[one], locations.face[three]
        part, whole = _face_extent(position, one, two, three)
        volume += part
        area += whole
        # weight of the third integral, per volume below the piece
        weight = 3.0 * part * (3.0 * part / whole)
        d1, d2, d3 = beyond[one], beyond[two], beyond[three]
        own = reference.deviation[face]
        pending = own + max(along[one], along[two], along[three])
        weights = (part, whole, weight)
        if through == last == locations.face[two]:
            queued = _push(waiting, queued, through, (d1, d2, d3), weights, slope[INDEX(through)])
            if pending > min(bounds[FROM_UPPER], bounds[TO_UPPER]):
                set_corner(triangle, 0, position, one, d1)
                set_corner(triangle, 1, position, two, d2)
                set_corner(triangle, 2, position, three, d3)
                raise_bounds(triangle, stack, reference, face, other, through, bounds, deviation)
            else:
                deviation[INDEX(through)] = max(deviation[INDEX(through)], pending)
            continue
        a, b, c = row(position, one, 0), row(position, two, 0), row(position, three, 0)
        radius = np.sqrt(max(dot(a, a), dot(b, b), dot(c, c)))
        if through == locations.face[two]:
            single, from_two, from_one = find_crossing(
                position, one, two, three, through, last, cones
            )
            if single:
                at, beside = INDEX(through), INDEX(last)
                d = dot(row(cones.normal, at, 0), c) - 1.0
                d4, d5 = d2 + from_two * (d - d2), d1 + from_one * (d - d1)
                away = own + radius * max(abs(d4) / (1.0 + d4), abs(d5) / (1.0 + d5))
                close = max(pending, away) <= min(bounds[FROM_UPPER], bounds[TO_UPPER])
                share, corners = from_two, (d1, d2, d4)
                queued = _push_part(waiting, queued, through, corners, share, weights, slope[at])
                share, corners = from_one * (1.0 - from_two), (d1, d4, d5)
                queued = _push_part(waiting, queued, through, corners, share, weights, slope[at])
                if close:
                    deviation[at] = max(deviation[at], own + along[one], own + along[two], away)
                else:
                    set_corner(triangle, 0, position, one, d1)
                    set_corner(triangle, 1, position, two, d2)
                    set_crossing(triangle, 2, position, two, three, from_two, d4)
                    raise_bounds(
                        triangle, stack, reference, face, other, through, bounds, deviation
                    )
                    set_crossing(triangle, 1, position, one, three, from_one, d5)
                    raise_bounds(
                        triangle, stack, reference, face, other, through, bounds, deviation
                    )
                share, corners = (1.0 - from_two) * (1.0 - from_one), (d4, d3, d5)
                queued = _push_part(waiting, queued, last, corners, share, weights, slope[beside])
                if close:
                    deviation[beside] = max(deviation[beside], own + along[three], away)
                else:
                    set_crossing(triangle, 2, position, two, three, from_two, d4)
                    set_crossing(triangle, 1, position, one, three, from_one, d5)
                    set_corner(triangle, 0, position, three, d3)
                    raise_bounds(triangle, stack, reference, face, other, last, bounds, deviation)
                continue
        top = push_face(work, position, one, two, three, through)
        piece, frame = work.piece, work.frame
        while True:
            through, count, top = pop_piece(work, top, cones, radius, moves)
            if through < 0:
                break
            largest, least = 0.0, np.inf
            for index in range(count):
                largest = max(largest, abs(piece[INDEX(index), 2]))
                least = min(least, piece[INDEX(index), 2])
            # a cheap upper bound first; it mostly changes nothing
            pending = own + radius * (largest / (1.0 + least))
            accepted = min(bounds[FROM_UPPER], bounds[TO_UPPER])
            at = INDEX(through)
            if not pending <= min(accepted, deviation[at]):
                pending = 0.0
                for index in range(count):
                    pending = max(pending, abs(piece[index, 2]) / (1.0 + piece[index, 2]))
                pending = own + radius * pending
                if pending <= accepted:
                    deviation[at] = max(deviation[at], pending)
            for index in range(1, count - 1):
                share = (piece[index, 0] - piece[0, 0]) * (piece[index + 1, 1] - piece[0, 1]) - (
                    piece[index, 1] - piece[0, 1]
                ) * (piece[index + 1, 0] - piece[0, 0])
                if queued == CAPACITY:
                    _flush(waiting, queued, sums)
                    queued = 0
                corners = (piece[0, 2], piece[index, 2], piece[index + 1, 2])
                queued = _push_part(waiting, queued, through, corners, share, weights, slope[at])
                if pending > min(bounds[FROM_UPPER], bounds[TO_UPPER]):
                    for side in range(3):
                        number = 0 if side == 0 else index + side - 1
                        u, v = piece[number, 0], piece[number, 1]
                        for axis in range(3):
                            triangle[side, axis] = (
                                frame[axis] + u * frame[3 + axis] + v * frame[6 + axis]
                            )
                        triangle[side, 3] = piece[number, 2]
                    raise_bounds(
                        triangle, stack, reference, face, other, through, bounds, deviation
                    )
    _flush(waiting, queued, sums)
    return volume, area


@inlined_kernel
def _push(
    waiting: _Queue,
    count: int,
    face: int,
    corners: tuple[float, float, float],
    weights: tuple[float, float, float],
    slope: float,
) -> int:
    """Push a triangle to a queue with `count` < `CAPACITY` triangles; return the new count.

    The triangle is seen through `face`. `corners` are N · p − 1, and `weights` are factors of the
    three integrals. The second integral is also divided by the length of N, `slope`; the third is
    multiplied.
    """
    triangle, at = waiting.triangle, INDEX(count)
    triangle[at], triangle[at + ONE], triangle[at + TWO] = corners
    triangle[at + THREE], triangle[at + FOUR], triangle[at + FIVE] = weights
    triangle[at + SIX] = slope
    waiting.face[at] = face
    return count + 1


@inlined_kernel
def _push_part(
    waiting: _Queue,
    count: int,
    face: int,
    corners: tuple[float, float, float],
    share: float,
    weights: tuple[float, float, float],
    slope: float,
) -> int:
    """Push a part of a triangle with a `share` of its area, as `_push`."""
    one, two, three = weights
    return _push(waiting, count, face, corners, (share * one, share * two, share * three), slope)


@leaf_kernel
def _flush(waiting: _Queue, count: int, sums: FloatArray) -> None:
    """Integrate the triangles of a queue, and add the weighted results to sums (F, 3) of faces."""
    _integrate(waiting, count)
    triangle, integral = waiting.triangle, waiting.integral
    for index in range(count):
        at, face = INDEX(index), INDEX(waiting.face[INDEX(index)])
        slope = triangle[at + SIX]
        sums[face, 0] += triangle[at + THREE] * integral[at]
        sums[face, 1] += triangle[at + FOUR] * integral[at + ONE] / slope
        sums[face, 2] += triangle[at + FIVE] * integral[at + TWO] * slope


@leaf_kernel
def _integrate(waiting: _Queue, count: int) -> None:
    """Compute the integrals of triangles of a queue, each ÷ volume between triangle and centre.

    Let d = N · p − 1 and t = 1 ÷ (N · p) at its corners. The other surface's part of the same cone
    has t₁ t₂ t₃ times the volume. The integrals are

    - the volume between the triangle and the face;
    - the mean of |d| over the triangle;
    - the mean of |t − 1| over the part of the face that the triangle is seen through, times t₁ t₂
      t₃.
    """
    triangle, integral = waiting.triangle, waiting.integral
    for index in range(count):
        at = INDEX(index)
        one, two, three = triangle[at], triangle[at + ONE], triangle[at + TWO]
        t1, t2, t3 = 1.0 + one, 1.0 + two, 1.0 + three
        product = 1.0 / (t1 * t2 * t3)
        t_sum = product * (t2 * t3 + t1 * t3 + t1 * t2)
        # rotate the corners so that the first is alone on its side of the face; d = 0 on the cut
        up1, up2, up3 = one >= 0.0, two >= 0.0, three >= 0.0
        third = up1 == up2
        second = (up1 == up3) & (not third)
        whole = third & (up2 == up3)
        a = three if third else (two if second else one)
        b = one if third else (three if second else two)
        c = two if third else (one if second else three)
        mean = (a + b + c) / 3.0
        part = a * a / ((a - b) * (a - c))
        t = 1.0 / (1.0 + a)
        volume_cut = part * (1.0 - t)
        mean_cut = part * a / 3.0
        a, b, c = a * t, b / (1.0 + b), c / (1.0 + c)
        back_cut = a * a * a / ((a - b) * (a - c) * 3.0)
        gap = abs(1.0 - product - volume_cut) + abs(volume_cut)
        here = abs(mean - mean_cut) + abs(mean_cut)
        back = product * (abs((a + b + c) / 3.0 - back_cut) + abs(back_cut))
        integral[at] = abs(1.0 - product) if whole else gap
        integral[at + ONE] = abs(one + two + three) / 3.0 if whole else here
        integral[at + TWO] = product * abs(t_sum - 3.0) / 3.0 if whole else back
