"""How far a triangle reaches from a surface: an upper bound within a few per cent.

The distance from a point to one triangle is a convex function of the point, so over a piece of
surface its maximum is at the piece's corners, and the distance from the whole piece to a surface is
at most the largest of its corners' distances to any one face of it. Pieces for which no nearby face
gives a good bound are halved. The bound holds whatever faces are looked at; it is tight where the
nearest ones are found, by descending from face to adjacent face.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.errors import MeshError
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel
from gamutcore.star_shape import faces_not_seeing_centre

if TYPE_CHECKING:
    from gamutcore.mesh import TriangleMesh

__all__ = [
    "SLACK",
    "STACK",
    "Faces",
    "faces_of",
    "halvings_for",
    "nearest_face",
    "raise_bound",
    "squared_distance",
    "star_shaped_faces",
]

SLACK = 1.03
"""A bound this close to a distance that is attained is not improved further."""

DEGENERATE = 1e-12
"""Squared sine of a face's angle below which only its edges are looked at: what the regions are
told apart by has lost half of its digits by then."""

HALVINGS = 16
"""How often a piece is halved at most; its bound is then taken as it is."""

STACK = (HALVINGS + 2, 17)
"""Shape of the work array of `raise_bound`: nine coordinates, a face, the halvings made, and for
each corner the nearest face, −1 before it is looked for, and its squared distance."""


class Faces(NamedTuple):
    """A surface that distances are taken to.

    Attributes
    ----------
    position : (V, 3) float64
    corner : (3 F,) int32
        Vertices at the corners of all faces.
    fan_end : (V,) int32
        Where a vertex's part of `fan` ends; it begins where the part before it ends.
    fan : (3 F,) int32
        The faces at each vertex.
    off : (F,) float64
        Where the surface stands for another one: how far from it any point of a face is at most,
        and each of the other's points from some face that has this number or more.
    """

    position: FloatArray
    corner: IndexArray
    fan_end: IndexArray
    fan: IndexArray
    off: FloatArray


def faces_of(position: FloatArray, corner: IndexArray) -> Faces:
    """Return a surface with the faces at each vertex, standing for itself.

    Parameters
    ----------
    position : (V, 3) float64
    corner : (3 F,) int32

    Returns
    -------
    Faces
    """
    fan_end, fan = _fans(corner, len(position))
    return Faces(position, corner, fan_end, fan, np.zeros(len(corner) // 3))


def star_shaped_faces(mesh: TriangleMesh, centre: FloatArray) -> Faces:
    """Return a mesh's surface, its positions relative to a centre that it is star-shaped about.

    Raises
    ------
    MeshError
        It is not.
    """
    position = np.ascontiguousarray(mesh.vertices.astype(np.float64) - centre)
    corner = np.ascontiguousarray(mesh.faces, np.int32).ravel()
    hidden = faces_not_seeing_centre(position, corner.reshape(-1, 3))
    used = len(np.unique(corner))
    if len(hidden) or not used == len(position) == len(mesh.faces) // 2 + 2:
        raise MeshError(
            f"a mesh of {used} used vertices and {mesh.triangles} faces is not star-shaped: of"
            f" these {len(hidden)} do not see the centre from inside",
            remedy="closed meshes of genus 0 without other vertices, and a centre in their kernels",
        )
    return faces_of(position, corner)


def halvings_for(surface: Faces, least: float = 10_000.0) -> float:
    """How often pieces of a surface may be halved, each of which takes 1 to 4 µs.

    Parameters
    ----------
    surface : Faces
        A quarter of its faces may be, a few times what gamuts of devices in CIELAB take.
    least : float
        And so many more: the less, the less tight are the bounds of very flat bodies.

    Returns
    -------
    float
    """
    return least + len(surface.corner) // 12


@kernel
def _fans(corner: IndexArray, vertices: int) -> tuple[IndexArray, IndexArray]:
    end = np.zeros(vertices, np.int32)
    for index in range(len(corner)):
        end[corner[index]] += 1
    total = 0
    for vertex in range(vertices):
        count = end[vertex]
        end[vertex] = total
        total += count
    fan = np.empty(len(corner), np.int32)
    for face in range(len(corner) // 3):
        for place in range(3):
            vertex = corner[3 * face + place]
            fan[end[vertex]] = face
            end[vertex] += 1
    return end, fan


@inlined_kernel
def squared_distance(x: float, y: float, z: float, surface: Faces, face: int) -> float:
    """Squared distance from a point to a face.

    By the regions of the plane that are nearest to a corner, an edge or the inside: Ericson,
    "Real-Time Collision Detection" (2005), section 5.1.5. It is always the distance to some point
    of the face: rounding may miss the nearest one, but the result is not too small.
    """
    position = surface.position
    one = surface.corner[3 * face]
    two = surface.corner[3 * face + 1]
    three = surface.corner[3 * face + 2]
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    ux, uy, uz = position[two, 0] - ax, position[two, 1] - ay, position[two, 2] - az
    vx, vy, vz = position[three, 0] - ax, position[three, 1] - ay, position[three, 2] - az
    x, y, z = x - ax, y - ay, z - az
    # scalar products of both edges with the point as seen from each of the corners
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
        # no inside to speak of: the nearest point is on an edge
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
def nearest_face(x: float, y: float, z: float, surface: Faces, face: int) -> tuple[int, float]:
    """Face near a point, and its squared distance, by descent from a face.

    No face that has a vertex in common with it is nearer. That is the nearest one of all, or
    another one that a concave place keeps from being left: its distance is an upper bound.
    """
    corner, fan_end, fan = surface.corner, surface.fan_end, surface.fan
    least = squared_distance(x, y, z, surface, face)
    before_one, before_two, before_three = -1, -1, -1
    while True:
        best = face
        for place in range(3):
            vertex = corner[3 * face + place]
            # all faces at a vertex of the face before have been looked at
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
def _bound(piece: FloatArray, row: int, surface: Faces, face: int) -> float:
    """Squared distance to a face, the largest of a piece's corners."""
    return max(
        squared_distance(piece[row, 0], piece[row, 1], piece[row, 2], surface, face),
        squared_distance(piece[row, 3], piece[row, 4], piece[row, 5], surface, face),
        squared_distance(piece[row, 6], piece[row, 7], piece[row, 8], surface, face),
    )


@leaf_kernel
def raise_bound(
    stack: FloatArray,
    surface: Faces,
    face: int,
    off: float,
    lower: float,
    upper: float,
    halvings: float,
) -> tuple[float, float, float]:
    """Raise the bound on what lies furthest from a surface so that it holds for one more triangle.

    Parameters
    ----------
    stack : `STACK` float64
        The triangle's corners as the first nine numbers; the rest is work space.
    surface : Faces
    face : int
        A face near the triangle.
    off : float
        Added to all distances, as is what the faces of the surface are off.
    lower, upper : float
        What is known of other pieces: a distance that is attained, and the bound.
    halvings : float
        How often pieces may be halved, all in all.

    Returns
    -------
    lower, upper : float
        The same with this triangle. The upper one is certain; the lower one is attained if descent
        finds the nearest faces.
    halvings : float
        How many are left.
    """
    stack[0, 9], stack[0, 10] = face, 0.0
    stack[0, 11], stack[0, 12], stack[0, 13] = -1.0, -1.0, -1.0
    top = 1
    while top > 0:
        top -= 1
        face = int(stack[top, 9])
        accepted = max(upper, SLACK * lower)
        if np.sqrt(_bound(stack, top, surface, face)) + surface.off[face] + off <= accepted:
            upper = accepted
            continue
        # two corners of a half are corners of the whole, whose nearest faces are known
        for row in range(3):
            if stack[top, 11 + row] < 0.0:
                x, y, z = stack[top, 3 * row], stack[top, 3 * row + 1], stack[top, 3 * row + 2]
                stack[top, 11 + row], stack[top, 14 + row] = nearest_face(x, y, z, surface, face)
        one, two, three = int(stack[top, 11]), int(stack[top, 12]), int(stack[top, 13])
        attained = max(
            np.sqrt(stack[top, 14]) + surface.off[one],
            np.sqrt(stack[top, 15]) + surface.off[two],
            np.sqrt(stack[top, 16]) + surface.off[three],
        )
        bound = np.sqrt(_bound(stack, top, surface, one)) + surface.off[one]
        if two != one:
            bound = min(bound, np.sqrt(_bound(stack, top, surface, two)) + surface.off[two])
        if three not in (one, two):
            bound = min(bound, np.sqrt(_bound(stack, top, surface, three)) + surface.off[three])
        attained, bound = attained + off, bound + off
        # where descent ended too early, the bound by another corner's face may be the better one
        lower = max(lower, min(attained, bound))
        if bound <= max(upper, SLACK * lower) or halvings <= 0.0 or stack[top, 10] >= HALVINGS:
            upper = max(upper, bound)
            continue
        # halve the longest edge; each half begins with the face that is nearest to its own end
        longest, greatest = 0, -1.0
        for edge in range(3):
            i, j = 3 * edge, 3 * ((edge + 1) % 3)
            x = stack[top, i] - stack[top, j]
            y = stack[top, i + 1] - stack[top, j + 1]
            z = stack[top, i + 2] - stack[top, j + 2]
            if x * x + y * y + z * z > greatest:
                longest, greatest = edge, x * x + y * y + z * z
        first, second = 3 * longest, 3 * ((longest + 1) % 3)
        for column in range(17):
            stack[top + 1, column] = stack[top, column]
        for axis in range(3):
            middle = 0.5 * (stack[top, first + axis] + stack[top, second + axis])
            stack[top, second + axis] = middle
            stack[top + 1, first + axis] = middle
        stack[top, 10] += 1.0
        stack[top + 1, 10] = stack[top, 10]
        stack[top, 9] = one if first == 0 else two if first == 3 else three
        stack[top + 1, 9] = one if second == 0 else two if second == 3 else three
        stack[top, 11 + second // 3] = stack[top + 1, 11 + first // 3] = -1.0
        top += 2
        halvings -= 1.0
    return lower, upper, halvings
