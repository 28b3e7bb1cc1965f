"""The radial envelope of crossing triangles: in each direction from a centre, the outermost point.

Vertices are the outermost corners of triangles, and the outermost points at which an edge passes
through a triangle. Their directions are triangulated by a convex hull on the unit sphere. Flips
then restore the edges of the triangles, and the lines along which two triangles cross. Pieces of
triangles are left between these lines, or walls where the outermost surface ends above another. The
result is star-shaped because the hull is, and because flips keep it so.

Which points are outermost: the directions from the centre are divided into cells, a grid on each
face of a cube around the centre. A cell lists the triangles that rays through it may meet
(`gamutcore.geometry.cube_map`).

Flips: Sloan, "A fast algorithm for generating constrained Delaunay triangulations" (1993), on the
sphere of directions. An edge is flipped only if both new faces see the centre, so the mesh stays
valid whatever the pairs are. A pair is given up where it crosses an earlier pair, or passes through
a vertex.

The volume of the envelope needs no mesh: rays through the pixels of the cube sample it. Each
triangle is drawn on the sides of the cube, and each pixel keeps the largest radius.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import BooleanArray, FloatArray, IndexArray, LongArray
from gamutcore.boundary.radial_hull import radial_hull
from gamutcore.errors import BoundaryError
from gamutcore.geometry import (
    Vector,
    add_cells,
    cell_of,
    cross,
    curve_positions,
    direction_cells,
    dot,
    insertion_order,
    minus,
    nearest_grid_points,
    next_corner,
    opposite_corners,
    plus,
    previous_corner,
    row,
    scaled,
    sees_centre,
    swing,
    triple,
    write_row,
)
from gamutcore.kernels import kernel, leaf_kernel

FINE = 256
"""Pixels along an edge of the cube for volumes. The volumes of real devices differ by 0.0005 % from
those with twice as many."""

COARSE = 64
"""Pixels for comparisons of centres, and for whether triangles surround a centre."""

TRIANGLES_PER_CELL = 2
"""Mean number of triangles that begin in a cell. Measured: 1 and 4 are slower."""

MOST_CELLS = 400
"""Largest number of cells along a side of the cube."""

RIM = 1e-12
"""Distance from a triangle, as a share of the largest possible, that counts as within it."""

MOST_CROSSINGS = 50
"""Largest mean number of triangles that an examined edge passes through. Presses of seven inks have
6. A sheet that is crumpled into a point has 560, which would take many minutes."""

MOST_CROSSED = 256
"""Largest number of edges between the vertices of a pair. Pairs are edges of similar meshes, and
cross few."""

MOST_VALENCE = 4096
"""Largest number of faces around a vertex that are searched."""

ROUNDS = 8
"""Flips that are tried, as a multiple of the number of crossed edges."""


class Envelope(NamedTuple):
    """A closed surface, star-shaped about the origin."""

    position: FloatArray  # (m, 3) on the grid
    faces: IndexArray  # (f, 3)
    ends: IndexArray  # (m, 2) the points on whose edge each vertex is; twice itself for a point
    share: FloatArray  # (m,) position between them, 0 to 1


def radial_envelope(position: FloatArray, corners: IndexArray, step: float) -> Envelope:
    """Return the outermost surface of triangles (m, 3), of any orientation, around the origin.

    Points (n, 3) are relative to the centre, on a grid with the given step. The envelope has no
    faces if the triangles do not surround the centre. Raise `BoundaryError` if they are crumpled:
    `MOST_CROSSINGS`.
    """
    if radial_volume(position, corners, np.zeros(3), COARSE).uncovered:
        return Envelope(position, np.empty((0, 3), np.int32), *_no_cuts(len(position)))
    sheets = _arrange(position, corners, step)
    vertices = np.unique(sheets.corner)
    seen = np.zeros(len(position), bool)
    seen[vertices] = ~_is_hidden(sheets, position[vertices])
    rims = _rims(sheets.corner, seen)
    crossings = _outermost_crossings(sheets, rims.edges, seen)
    cut = nearest_grid_points(_points_on(position, rims.edges, crossings), step)

    count = len(position)
    points = np.concatenate([position, cut])
    own_ends, own_share = _no_cuts(count)
    ends = np.concatenate([own_ends, rims.edges[crossings.edge]])
    share = np.concatenate([own_share, crossings.share])
    chosen = np.concatenate([np.flatnonzero(seen), np.arange(count, len(points))])
    pairs = np.concatenate(
        [_creases(rims, crossings, count), _pieces(sheets, rims, crossings, seen)]
    )

    distinct, number = _distinct(points, chosen, step)
    order = distinct[insertion_order(curve_positions(points[distinct]))]
    ordered = points[order]
    faces = radial_hull(ordered / np.linalg.norm(ordered, axis=1)[:, np.newaxis])
    place = np.full(len(points), -1, np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    faces, _ = recover_edges(ordered, faces, place[number[pairs]])
    return Envelope(ordered, faces, ends[order], share[order])


def _no_cuts(count: int) -> tuple[IndexArray, FloatArray]:
    """Ends and shares of points that are not between others."""
    own = np.arange(count, dtype=np.int32)
    return np.column_stack([own, own]), np.zeros(count)


class _Rims(NamedTuple):
    """The edges of the triangles that have an outermost corner."""

    edges: IndexArray  # (e, 2)
    start: LongArray  # (e + 1,) first entry of each edge in `triangle`
    triangle: IndexArray  # (k,) the triangles on both sides of the edges


def _rims(corner: IndexArray, seen: BooleanArray) -> _Rims:
    partly = np.flatnonzero(seen[corner].any(axis=1)).astype(np.int32)
    sides = np.concatenate([corner[partly][:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    keys = sides.min(axis=1).astype(np.int64) * len(seen) + sides.max(axis=1)
    order = np.argsort(keys, kind="stable")
    edge_keys, start = np.unique(keys[order], return_index=True)
    edges = np.column_stack(np.divmod(edge_keys, len(seen))).astype(np.int32)
    return _Rims(edges, np.append(start, len(keys)), np.tile(partly, 3)[order])


def _points_on(position: FloatArray, edges: IndexArray, crossings: _EdgeCrossings) -> FloatArray:
    start, end = (position[edges[crossings.edge, side]] for side in (0, 1))
    return np.asarray(start + crossings.share[:, np.newaxis] * (end - start))


def _outermost_crossings(sheets: _Sheets, edges: IndexArray, seen: BooleanArray) -> _EdgeCrossings:
    """Crossings that no triangle hides, edge by edge from the first end.

    Triangles that cross continue below each other. Only edges of triangles with a hidden corner,
    and edges between these triangles, are therefore examined.
    """
    count = seen[sheets.corner].sum(axis=1)
    near = np.zeros(len(seen), bool)
    near[sheets.corner[(count > 0) & (count < 3)]] = True
    examined = np.flatnonzero(near[edges].all(axis=1)).astype(np.int32)
    room, most = len(examined), MOST_CROSSINGS * (len(examined) + 1000)
    total, crossings = _edge_crossings(sheets, edges[examined], room, most)
    if total > most:
        raise BoundaryError(
            "The device's surface passes through itself too often.",
            remedy="Ask for another colour space, or the modified convex hull.",
        )
    if total > room:
        _, crossings = _edge_crossings(sheets, edges[examined], total, most)
    crossings = _EdgeCrossings(examined[crossings.edge], crossings.triangle, crossings.share)
    visible = np.flatnonzero(~_is_hidden(sheets, _points_on(sheets.position, edges, crossings)))
    visible = visible[np.lexsort((crossings.share[visible], crossings.edge[visible]))]
    return _EdgeCrossings(
        crossings.edge[visible], crossings.triangle[visible], crossings.share[visible]
    )


def _creases(rims: _Rims, crossings: _EdgeCrossings, first: int) -> IndexArray:
    """Pairs of crossings at the ends of the line along which two triangles cross."""
    begin, end = rims.start[crossings.edge], rims.start[crossings.edge + 1]
    crossing = np.repeat(np.arange(len(begin)), end - begin)
    entry = np.arange(len(crossing)) - np.repeat(
        np.cumsum(end - begin) - (end - begin), end - begin
    )
    one = rims.triangle[np.repeat(begin, end - begin) + entry].astype(np.int64)
    two = crossings.triangle[crossing].astype(np.int64)
    keys = np.minimum(one, two) << 32 | np.maximum(one, two)
    order = np.argsort(keys, kind="stable")
    keys, crossing = keys[order], crossing[order]
    same = np.flatnonzero(keys[1:] == keys[:-1])
    return (np.column_stack([crossing[same], crossing[same + 1]]) + first).astype(np.int32)


def _pieces(
    sheets: _Sheets, rims: _Rims, crossings: _EdgeCrossings, seen: BooleanArray
) -> IndexArray:
    """Pairs of points at the ends of the outermost pieces of edges, the cut edges first."""
    first, edges = len(sheets.position), rims.edges
    whole = seen[edges[:, 0]] & seen[edges[:, 1]]
    whole[crossings.edge] = False
    count = len(crossings.edge)
    opens = np.ones(count + 1, bool)
    opens[1:-1] = crossings.edge[1:] != crossings.edge[:-1]
    number = np.arange(count) + first
    before = np.where(opens[:-1], edges[crossings.edge, 0], number - 1)
    low = np.where(opens[:-1], 0.0, np.concatenate([[0.0], crossings.share[:-1]])[:count])
    last = opens[1:]
    pairs = np.concatenate(
        [
            np.column_stack([before, number]),
            np.column_stack([number[last], edges[crossings.edge[last], 1]]),
        ]
    )
    middles = _EdgeCrossings(
        np.concatenate([crossings.edge, crossings.edge[last]]),
        np.empty(0, np.int32),
        np.concatenate([(low + crossings.share) / 2, (crossings.share[last] + 1) / 2]),
    )
    visible = ~_is_hidden(sheets, _points_on(sheets.position, edges, middles))
    known = np.append(seen, np.ones(count, bool))
    visible &= known[pairs].all(axis=1)
    return np.concatenate([pairs[visible], edges[whole]]).astype(np.int32)


def _distinct(points: FloatArray, chosen: LongArray, step: float) -> tuple[LongArray, LongArray]:
    """One of each group of equal points, and for every point the one of its group."""
    # odd factors, so that different points have different keys but for rare collisions
    whole = np.rint(points[chosen] / step).astype(np.int64)
    keys = whole @ np.array([0x9E3779B97F4A7C1, 0xBF58476D1CE4E5B, 0x94D049BB133111E | 1])
    order = np.argsort(keys, kind="stable")
    opens = np.append(True, keys[order[1:]] != keys[order[:-1]])
    own = np.empty(len(chosen), np.int64)
    own[order] = chosen[order[opens]][np.cumsum(opens) - 1]
    collided = (points[own] != points[chosen]).any(axis=1)
    own[collided] = chosen[collided]
    number = np.arange(len(points))
    number[chosen] = own
    return chosen[own == chosen], number


class _Sheets(NamedTuple):
    """Triangles around the centre, sorted into cells."""

    position: FloatArray  # (n, 3) relative to the centre
    corner: IndexArray  # (m, 3) counter-clockwise, seen from outside
    plane: FloatArray  # (m, 5) unit normal, distance from the centre, largest radius of a corner
    cells: int  # number of cells along a side of the cube
    start: IndexArray  # (6 cells² + 1,) first entry of each cell in `listed`
    listed: IndexArray  # (k,) triangles of the cells
    tolerance: float  # radial distance that does not hide a point


class _EdgeCrossings(NamedTuple):
    """Points at which edges pass through triangles."""

    edge: IndexArray  # (k,)
    triangle: IndexArray  # (k,)
    share: FloatArray  # (k,) position along the edge, 0 to 1


@kernel
def _arrange(position: FloatArray, corner: IndexArray, tolerance: float) -> _Sheets:
    """Turn triangles outwards and sort them into cells; positions are relative to the centre.

    Triangles seen from the centre on edge, or with a corner there, hide nothing.
    """
    cells = min(max(int(np.sqrt(len(corner) / (6.0 * TRIANGLES_PER_CELL))), 4), MOST_CELLS)
    turned, plane = corner.copy(), np.zeros((len(corner), 5))
    _set_planes(position, turned, plane)
    start, listed = direction_cells(position, turned, cells)
    return _Sheets(position, turned, plane, cells, start, listed, tolerance)


@kernel
def _is_hidden(sheets: _Sheets, points: FloatArray) -> BooleanArray:
    """Return whether each point is nearer to the centre than a triangle on the same ray.

    Points are relative to the centre.
    """
    hidden = np.empty(len(points), np.bool_)
    for index in range(len(points)):
        hidden[index] = _point_is_hidden(sheets, row(points, index, 0))
    return hidden


@leaf_kernel
def _point_is_hidden(sheets: _Sheets, point: Vector) -> bool:
    """Whether a triangle is further out than a point, on the same ray."""
    plane, radius = sheets.plane, np.sqrt(dot(point, point))
    if radius == 0.0:
        return True
    cell = cell_of(point, sheets.cells)
    for entry in range(sheets.start[cell], sheets.start[cell + 1]):
        face = sheets.listed[entry]
        if plane[face, 4] <= radius + sheets.tolerance:
            continue
        slope = dot(row(plane, face, 0), point)
        # further out than the point: distance ÷ slope > 1 + tolerance ÷ radius
        if (
            slope > 0.0
            and plane[face, 3] * radius > slope * (radius + sheets.tolerance)
            and _is_within(sheets, face, point)
        ):
            return True
    return False


@leaf_kernel
def _is_within(sheets: _Sheets, face: int, point: Vector) -> bool:
    """Whether the ray through a point meets a triangle."""
    position, corner = sheets.position, sheets.corner
    tolerance = RIM * np.sqrt(dot(point, point)) * sheets.plane[face, 4] * sheets.plane[face, 4]
    a, b, c = (
        row(position, corner[face, 0], 0),
        row(position, corner[face, 1], 0),
        row(position, corner[face, 2], 0),
    )
    return min(triple(a, b, point), triple(b, c, point), triple(c, a, point)) >= -tolerance


@kernel
def _edge_crossings(
    sheets: _Sheets, edges: IndexArray, room: int, most: int
) -> tuple[int, _EdgeCrossings]:
    """Return the number of crossings of edges and triangles, and the first `room` crossings.

    Counting ends after the edge with which there are more than `most`.
    """
    position, plane = sheets.position, sheets.plane
    found_edge, found_face = np.empty(room, np.int32), np.empty(room, np.int32)
    found_share, count = np.empty(room), 0
    cells = np.empty(len(sheets.start) - 1, np.int32)
    for edge in range(len(edges)):
        one, two = edges[edge, 0], edges[edge, 1]
        a, b = row(position, one, 0), row(position, two, 0)
        along = minus(b, a)
        share = min(max(-dot(a, along) / dot(along, along), 0.0), 1.0)
        closest = plus(a, scaled(share, along))
        nearest = np.sqrt(dot(closest, closest))
        if count > most:
            break
        for cell in cells[: add_cells(a, b, b, sheets.cells, cells, 0)]:
            for entry in range(sheets.start[cell], sheets.start[cell + 1]):
                face = sheets.listed[entry]
                if plane[face, 4] < nearest:
                    continue
                over_a = dot(row(plane, face, 0), a) - plane[face, 3]
                over_b = dot(row(plane, face, 0), b) - plane[face, 3]
                if (over_a > 0.0) == (over_b > 0.0) or (
                    abs(over_a) <= sheets.tolerance and abs(over_b) <= sheets.tolerance
                ):
                    continue
                if _has_corner(sheets.corner, face, one, two):
                    continue
                share = over_a / (over_a - over_b)
                point = plus(a, scaled(share, along))
                # each crossing once: in its own cell
                if cell_of(point, sheets.cells) == cell and _is_within(sheets, face, point):
                    if count < room:
                        found_edge[count], found_face[count] = edge, face
                        found_share[count] = share
                    count += 1
    kept = min(count, room)
    return count, _EdgeCrossings(
        found_edge[:kept].copy(), found_face[:kept].copy(), found_share[:kept].copy()
    )


@leaf_kernel
def _has_corner(corner: IndexArray, face: int, one: int, two: int) -> bool:
    first, second, third = corner[face, 0], corner[face, 1], corner[face, 2]
    return first in (one, two) or second in (one, two) or third in (one, two)


@leaf_kernel
def _set_planes(position: FloatArray, corner: IndexArray, plane: FloatArray) -> None:
    """Turn triangles outwards, and write their planes; 0 for those seen on edge."""
    for face in range(len(corner)):
        one, two, three = corner[face, 0], corner[face, 1], corner[face, 2]
        a, b, c = row(position, one, 0), row(position, two, 0), row(position, three, 0)
        normal = cross(minus(b, a), minus(c, a))
        length, distance = np.sqrt(dot(normal, normal)), dot(a, normal)
        if distance < 0.0:
            corner[face, 1], corner[face, 2] = three, two
            length = -length
        reach = np.sqrt(max(dot(a, a), dot(b, b), dot(c, c)))
        if abs(distance) > RIM * abs(length) * reach:
            x, y, z = normal
            write_row(plane, face, 0, (x / length, y / length, z / length))
            plane[face, 3], plane[face, 4] = distance / length, reach


class _Flipping(NamedTuple):
    """A mesh whose edges are flipped."""

    position: FloatArray  # (n, 3) relative to the centre
    vertex: IndexArray  # (3 F,) corner table
    opposite: IndexArray  # (3 F,)
    fixed: BooleanArray  # (3 F,) whether the edge that a corner faces is one of the pairs
    corner_at: IndexArray  # (n,) a corner at each vertex; −1 for a vertex without a face


@kernel
def recover_edges(
    position: FloatArray, faces: IndexArray, pairs: IndexArray
) -> tuple[IndexArray, int]:
    """Return a mesh in which given pairs of vertices are edges, and the number of pairs given up.

    The mesh is closed and star-shaped about the origin of `position`, before and after. The more
    important pairs come first.
    """
    vertex = faces.copy().reshape(-1)
    mesh = _Flipping(
        position,
        vertex,
        opposite_corners(faces, len(position)),
        np.zeros(len(vertex), np.bool_),
        np.full(len(position), -1, np.int32),
    )
    for corner in range(len(vertex)):
        mesh.corner_at[vertex[corner]] = corner
    waiting, given_up = np.empty((MOST_CROSSED, 2), np.int32), 0
    for pair in range(len(pairs)):
        start, end = pairs[pair, 0], pairs[pair, 1]
        if start == end or mesh.corner_at[start] < 0 or mesh.corner_at[end] < 0:
            given_up += 1
            continue
        corner = _edge(mesh, start, end)
        if corner < 0 and _flip_between(mesh, start, end, waiting):
            corner = _edge(mesh, start, end)
        if corner < 0:
            given_up += 1
        else:
            mesh.fixed[corner] = mesh.fixed[mesh.opposite[corner]] = True
    return vertex.reshape(-1, 3), given_up


@leaf_kernel
def _edge(mesh: _Flipping, start: int, end: int) -> int:
    """Return a corner that faces the edge between two vertices, or −1."""
    first = mesh.corner_at[start]
    corner = first
    for _ in range(MOST_VALENCE):
        if mesh.vertex[next_corner(corner)] == end:
            return previous_corner(corner)
        corner = swing(mesh.opposite, corner)
        if corner == first:
            break
    return -1


@leaf_kernel
def _side(mesh: _Flipping, start: int, end: int, vertex: int) -> float:
    """Return the side of the plane through the centre and two vertices that a vertex is on."""
    position = mesh.position
    return triple(row(position, start, 0), row(position, end, 0), row(position, vertex, 0))


@leaf_kernel
def _crossed_edges(mesh: _Flipping, start: int, end: int, waiting: IndexArray) -> int:
    """Write the edges between two vertices; return their number, or −1 if one must stay."""
    vertex, opposite = mesh.vertex, mesh.opposite
    first = mesh.corner_at[start]
    corner, found = first, -1
    for _ in range(MOST_VALENCE):
        right, left = vertex[next_corner(corner)], vertex[previous_corner(corner)]
        if _side(mesh, start, right, end) > 0.0 and _side(mesh, left, start, end) > 0.0:
            found = corner
            break
        corner = swing(opposite, corner)
        if corner == first:
            break
    if found < 0:
        return -1
    count, corner = 0, found
    while count < MOST_CROSSED:
        if mesh.fixed[corner]:
            return -1
        waiting[count, 0], waiting[count, 1] = (
            vertex[next_corner(corner)],
            vertex[previous_corner(corner)],
        )
        count += 1
        corner = opposite[corner]
        beyond = vertex[corner]
        if beyond == end:
            return count
        side = _side(mesh, start, end, beyond)
        if side == 0.0:
            return -1
        # leave through the edge between the vertex beyond and the one on the other side
        corner = previous_corner(corner) if side < 0.0 else next_corner(corner)
    return -1


@leaf_kernel
def _flip_between(mesh: _Flipping, start: int, end: int, waiting: IndexArray) -> bool:
    """Flip edges until none is between two vertices; return whether that succeeds."""
    count = _crossed_edges(mesh, start, end, waiting)
    tries = ROUNDS * count
    while count > 0 and tries > 0:
        tries -= 1
        one, two = waiting[0, 0], waiting[0, 1]
        for index in range(count - 1):
            waiting[index, 0], waiting[index, 1] = waiting[index + 1, 0], waiting[index + 1, 1]
        count -= 1
        corner = _edge(mesh, one, two)
        if corner < 0:
            continue
        if not _flip(mesh, corner):
            waiting[count, 0], waiting[count, 1] = one, two
            count += 1
            continue
        # the new edge is opposite of the corner after the flipped one
        near, far = mesh.vertex[corner], mesh.vertex[previous_corner(corner)]
        if near in (start, end) or far in (start, end):
            continue
        if (_side(mesh, start, end, near) > 0.0) != (_side(mesh, start, end, far) > 0.0):
            waiting[count, 0], waiting[count, 1] = near, far
            count += 1
    return count == 0


@leaf_kernel
def _flip(mesh: _Flipping, corner: int) -> bool:
    """Replace the edge that a corner faces by the other diagonal, if both faces see the centre."""
    vertex, opposite, fixed, position = mesh.vertex, mesh.opposite, mesh.fixed, mesh.position
    other = opposite[corner]
    after, before = next_corner(corner), previous_corner(corner)
    other_after, other_before = next_corner(other), previous_corner(other)
    near, far = vertex[corner], vertex[other]
    right, left = vertex[after], vertex[before]
    if not (_sees(position, near, right, far) and _sees(position, far, left, near)):
        return False
    # two rims move: each to the corner that faces it now
    moved, other_moved = opposite[other_after], opposite[after]
    fixed[corner], fixed[other] = fixed[other_after], fixed[after]
    fixed[after] = fixed[other_after] = False
    vertex[before], vertex[other_before] = far, near
    opposite[corner], opposite[moved] = moved, corner
    opposite[other], opposite[other_moved] = other_moved, other
    opposite[after], opposite[other_after] = other_after, after
    mesh.corner_at[near], mesh.corner_at[far] = corner, other
    mesh.corner_at[right], mesh.corner_at[left] = after, other_after
    return True


@leaf_kernel
def _sees(position: FloatArray, one: int, two: int, three: int) -> bool:
    return sees_centre(row(position, one, 0), row(position, two, 0), row(position, three, 0))


class RadialVolume(NamedTuple):
    """The size of a radial envelope."""

    volume: float  # ∫ r³ ÷ 3 over all directions; directions without a triangle count as 0
    uncovered: float  # share of the rays that meet no triangle; 0 if the centre is surrounded
    depth: float  # smallest radius; 0 if a ray meets no triangle


@kernel
def radial_volume(
    points: FloatArray, faces: IndexArray, centre: FloatArray, pixels: int
) -> RadialVolume:
    """Return the volume of the radial envelope of triangles in any orientation.

    `pixels` is the number along an edge of the cube: `FINE` or `COARSE`.
    """
    radius = radial_map(points, faces, centre, pixels)
    volume, uncovered, depth = 0.0, 0, np.inf
    for side in range(6):
        for line in range(pixels):
            u = (line + 0.5) * 2.0 / pixels - 1.0
            for column in range(pixels):
                v = (column + 0.5) * 2.0 / pixels - 1.0
                along = radius[side, line, column]
                volume += along**3
                uncovered += along == 0.0
                depth = min(depth, along * np.sqrt(1.0 + u * u + v * v))
    rays = 6.0 * pixels * pixels
    # for a direction (1, u, v) scaled by t, the volume is ∫ t³ ÷ 3 du dv
    return RadialVolume(volume / 3.0 * (2.0 / pixels) ** 2, uncovered / rays, depth)


@kernel
def radial_map(
    points: FloatArray, faces: IndexArray, centre: FloatArray, pixels: int
) -> FloatArray:
    """Return the radii of the envelope (6, pixels, pixels) at the pixels of the sides of a cube.

    A radius is in units of the ray (1, u, v) through its pixel; 0 where no triangle is.
    """
    radius = np.zeros((6, pixels, pixels))
    corners = np.empty((3, 3))
    for face in range(len(faces)):
        for place in range(3):
            for axis in range(3):
                corners[place, axis] = points[faces[face, place], axis] - centre[axis]
        for side in range(6):
            _draw(radius, side, corners)
    return radius


@leaf_kernel
def _draw(radius: FloatArray, side: int, corners: FloatArray) -> None:
    """Raise the radii of the pixels of a side of the cube that a triangle covers.

    Radii are in units of (1, u, v). `corners` are relative to the centre, one per row.
    """
    axis, sign = side // 2, -1.0 if side % 2 == 0 else 1.0
    aw, bw, cw = sign * corners[0, axis], sign * corners[1, axis], sign * corners[2, axis]
    if aw <= 0.0 and bw <= 0.0 and cw <= 0.0:
        return
    second, third = (axis + 1) % 3, (axis + 2) % 3
    au, av = corners[0, second], corners[0, third]
    bu, bv = corners[1, second], corners[1, third]
    cu, cv = corners[2, second], corners[2, third]
    if (
        (au > aw and bu > bw and cu > cw)
        or (-au > aw and -bu > bw and -cu > cw)
        or (av > aw and bv > bw and cv > cw)
        or (-av > aw and -bv > bw and -cv > cw)
    ):
        return
    pixels = radius.shape[1]
    first_row, last_row, first_column, last_column = 0, pixels - 1, 0, pixels - 1
    if aw > 0.0 and bw > 0.0 and cw > 0.0:  # otherwise the triangle is seen under a wide angle
        first_row, last_row = _pixels(au / aw, bu / bw, cu / cw, pixels)
        first_column, last_column = _pixels(av / aw, bv / bw, cv / cw, pixels)
    # the planes through the centre and the edges; triangles that share an edge have exactly
    # opposite ones, so that no ray passes between them
    ab_w, ab_u, ab_v = au * bv - av * bu, av * bw - aw * bv, aw * bu - au * bw
    bc_w, bc_u, bc_v = bu * cv - bv * cu, bv * cw - bw * cv, bw * cu - bu * cw
    ca_w, ca_u, ca_v = cu * av - cv * au, cv * aw - cw * av, cw * au - cu * aw
    height = aw * bc_w + au * bc_u + av * bc_v
    if height == 0.0:
        return
    for line in range(first_row, last_row + 1):
        u = (line + 0.5) * 2.0 / pixels - 1.0
        for column in range(first_column, last_column + 1):
            v = (column + 0.5) * 2.0 / pixels - 1.0
            ab = ab_w + ab_u * u + ab_v * v
            bc = bc_w + bc_u * u + bc_v * v
            ca = ca_w + ca_u * u + ca_v * v
            along = ab + bc + ca
            if (
                (height > 0.0 and min(ab, bc, ca) >= 0.0)
                or (height < 0.0 and max(ab, bc, ca) <= 0.0)
            ) and height / along > radius[side, line, column]:
                radius[side, line, column] = height / along


@leaf_kernel
def _pixels(one: float, two: float, three: float, pixels: int) -> tuple[int, int]:
    """First and last pixel whose middle is between the least and the largest coordinate."""
    low, high = min(one, two, three), max(one, two, three)
    first = np.ceil((max(low, -1.0) + 1.0) / 2.0 * pixels - 0.5)
    last = np.floor((min(high, 1.0) + 1.0) / 2.0 * pixels - 0.5)
    return max(int(first), 0), min(int(last), pixels - 1)
