"""Upper bound of the distance from a triangle to a surface, within a few per cent.

The distance from a point to one face is a convex function of the point. Over a piece of surface its
maximum is at a corner of the piece. The distance from a piece to a surface is therefore at most the
largest distance of its corners to any one face. Pieces without a good bound are halved.

The bound is valid for any choice of faces, and tight for the nearest faces. Descent from face to
adjacent face finds them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.corner_table import vertex_fans
from gamutcore.errors import MeshError
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel
from gamutcore.star_shape import faces_not_seeing_centre

if TYPE_CHECKING:
    from gamutcore.mesh import TriangleMesh

__all__ = [
    "ATTAINED",
    "SLACK",
    "STACK",
    "Surface",
    "breadth_first",
    "halving_limit",
    "make_surface",
    "nearest_face",
    "raise_bound",
    "squared_distance",
    "star_shaped_surface",
]

SLACK = 1.03
"""Ratio of a bound to an attained distance at which the bound is not improved further."""

DEGENERATE = 1e-12
"""Squared sine of a face's angle below which only the edges of the face are considered. The
quantities that separate the regions have lost half of their digits by then."""

HALVINGS = 16
"""Most halvings of a piece; its bound then stays."""

FACE, HALVED, NEAREST, SQUARED, COLUMNS = 9, 10, 11, 14, 17
"""Columns of the stack of `raise_bound`, after nine coordinates: a face near the piece, the number
of halvings, then for each corner the nearest face (−1 if unknown) and its squared distance."""

ATTAINED = HALVINGS + 2
"""Row of the stack with the point at which the lower bound was attained last."""

STACK = (HALVINGS + 3, COLUMNS)
"""Shape of the work array of `raise_bound`."""


class Surface(NamedTuple):
    """A closed triangle mesh about the origin, with the faces at each vertex.

    Attributes
    ----------
    position : (V, 3) float64
    corner : (3 F,) int32
        Vertices at the corners of all faces.
    fan_end : (V,) int32
        End of each vertex's part of `fan`; the part begins at the end of the part before.
    fan : (3 F,) int32
        The faces at each vertex.
    deviation : (F,) float64
        Upper bound of the distance from any point of the face to the reference surface. Each point
        of the reference surface is within this distance of some face, too.
    """

    position: FloatArray
    corner: IndexArray
    fan_end: IndexArray
    fan: IndexArray
    deviation: FloatArray


def make_surface(position: FloatArray, corner: IndexArray) -> Surface:
    """Return a surface that is its own reference: without deviation."""
    fan_end, fan = vertex_fans(corner, len(position))
    return Surface(position, corner, fan_end, fan, np.zeros(len(corner) // 3))


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


def halving_limit(surface: Surface, least: float = 10_000.0) -> float:
    """Return the most halvings of a comparison with a surface.

    A halving takes 1 to 4 µs. A quarter of the number of faces is a few times the need of device
    gamuts in CIELAB. `least` is added; smaller values give looser bounds for very flat bodies.
    """
    return least + len(surface.corner) // 12


@inlined_kernel
def squared_distance(x: float, y: float, z: float, surface: Surface, face: int) -> float:
    """Squared distance from a point to a face, by the region of the plane that has the point.

    Source: C. Ericson, "Real-Time Collision Detection" (2005), section 5.1.5. The result is the
    distance to some point of the face. Rounding may miss the nearest point, but never gives too
    small a result.
    """
    position = surface.position
    one = surface.corner[3 * face]
    two = surface.corner[3 * face + 1]
    three = surface.corner[3 * face + 2]
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    ux, uy, uz = position[two, 0] - ax, position[two, 1] - ay, position[two, 2] - az
    vx, vy, vz = position[three, 0] - ax, position[three, 1] - ay, position[three, 2] - az
    x, y, z = x - ax, y - ay, z - az
    # scalar products of both edges with the vector from each corner to the point
    u_a, v_a = ux * x + uy * y + uz * z, vx * x + vy * y + vz * z
    if u_a <= 0.0 and v_a <= 0.0:
        return x * x + y * y + z * z
    uu, vv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
    uv = ux * vx + uy * vy + uz * vz
    u_b, v_b = u_a - uu, v_a - uv
    u_c, v_c = u_a - uv, v_a - vv
    inside_a, inside_b = u_b * v_c - u_c * v_b, u_c * v_a - u_a * v_c
    inside_c = u_a * v_b - u_b * v_a
    if uu * vv - uv * uv <= DEGENERATE * uu * vv:
        # a sliver: the nearest point is on an edge
        along_u = min(max(u_a / uu, 0.0), 1.0)
        along_v = min(max(v_a / vv, 0.0), 1.0)
        ww = uu - 2.0 * uv + vv
        along_w = min(max((v_b - u_b) / ww, 0.0), 1.0) if ww > 0.0 else 0.0
        return min(
            _squared(x - along_u * ux, y - along_u * uy, z - along_u * uz),
            _squared(x - along_v * vx, y - along_v * vy, z - along_v * vz),
            _squared(
                x - ux - along_w * (vx - ux),
                y - uy - along_w * (vy - uy),
                z - uz - along_w * (vz - uz),
            ),
        )
    if u_b >= 0.0 and v_b <= u_b:
        along_u, along_v = 1.0, 0.0
    elif v_c >= 0.0 and u_c <= v_c:
        along_u, along_v = 0.0, 1.0
    elif inside_c <= 0.0 and u_a >= 0.0 and u_b <= 0.0:
        along_u, along_v = u_a / uu, 0.0
    elif inside_b <= 0.0 and v_a >= 0.0 and v_c <= 0.0:
        along_u, along_v = 0.0, v_a / vv
    elif inside_a <= 0.0 and v_b >= u_b and u_c >= v_c:
        along_v = (v_b - u_b) / ((v_b - u_b) + (u_c - v_c))
        along_u = 1.0 - along_v
    else:
        scale = 1.0 / (inside_a + inside_b + inside_c)
        along_u, along_v = inside_b * scale, inside_c * scale
    return _squared(
        x - along_u * ux - along_v * vx,
        y - along_u * uy - along_v * vy,
        z - along_u * uz - along_v * vz,
    )


@leaf_kernel
def _squared(x: float, y: float, z: float) -> float:
    return x * x + y * y + z * z


@leaf_kernel
def nearest_face(x: float, y: float, z: float, surface: Surface, face: int) -> tuple[int, float]:
    """Return a face near a point and its squared distance, by descent from a face.

    No face that shares a vertex with the result is nearer. On concave surfaces the result may be a
    local minimum; its distance is then an upper bound.
    """
    corner, fan_end, fan = surface.corner, surface.fan_end, surface.fan
    least = squared_distance(x, y, z, surface, face)
    before_one, before_two, before_three = -1, -1, -1
    while True:
        best = face
        for place in range(3):
            vertex = corner[3 * face + place]
            # all faces at the vertices of the previous face have been visited
            if vertex in (before_one, before_two, before_three):
                continue
            for index in range(fan_end[vertex - 1] if vertex > 0 else 0, fan_end[vertex]):
                other = fan[index]
                if other != face:
                    distance = squared_distance(x, y, z, surface, other)
                    if distance < least:
                        least, best = distance, other
        if best == face:
            return face, least
        before_one, before_two = corner[3 * face], corner[3 * face + 1]
        before_three = corner[3 * face + 2]
        face = best


@inlined_kernel
def _bound(piece: FloatArray, row: int, surface: Surface, face: int) -> float:
    """Largest squared distance from the corners of a piece to a face."""
    return max(
        squared_distance(piece[row, 0], piece[row, 1], piece[row, 2], surface, face),
        squared_distance(piece[row, 3], piece[row, 4], piece[row, 5], surface, face),
        squared_distance(piece[row, 6], piece[row, 7], piece[row, 8], surface, face),
    )


@inlined_kernel
def _raised(lower: float, attained: float, stack: FloatArray, row: int) -> float:
    """Return the larger bound; keep the furthest corner as `ATTAINED` if `attained` is larger."""
    if attained <= lower:
        return lower
    furthest = 0
    for corner in range(1, 3):
        if stack[row, SQUARED + corner] > stack[row, SQUARED + furthest]:
            furthest = corner
    for axis in range(3):
        stack[ATTAINED, axis] = stack[row, 3 * furthest + axis]
    return attained


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
                x, y = stack[top, 3 * corner], stack[top, 3 * corner + 1]
                near, squared = nearest_face(x, y, stack[top, 3 * corner + 2], surface, face)
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
            i, j = 3 * edge, 3 * ((edge + 1) % 3)
            x = stack[top, i] - stack[top, j]
            y = stack[top, i + 1] - stack[top, j + 1]
            z = stack[top, i + 2] - stack[top, j + 2]
            if x * x + y * y + z * z > greatest:
                longest, greatest = edge, x * x + y * y + z * z
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


@kernel
def breadth_first(surface: Surface) -> tuple[IndexArray, IndexArray]:
    """Vertices in breadth-first order, and the predecessor of each vertex."""
    count = len(surface.position)
    order, near = np.zeros(count, np.int32), np.full(count, -1, np.int32)
    near[0] = 0
    filled = 1
    for index in range(count):
        vertex = order[index]
        for entry in range(
            surface.fan_end[vertex - 1] if vertex > 0 else 0, surface.fan_end[vertex]
        ):
            for place in range(3):
                beside = surface.corner[3 * surface.fan[entry] + place]
                if near[beside] < 0:
                    near[beside] = vertex
                    order[filled] = beside
                    filled += 1
    return order, near
