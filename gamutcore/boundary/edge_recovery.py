"""Make given pairs of vertices edges of a star-shaped mesh, by flips of the edges between them.

Sloan, "A fast algorithm for generating constrained Delaunay triangulations" (1993), on the sphere
of directions. An edge is flipped only if both new faces see the centre, so the mesh stays valid
whatever the pairs are. A pair is given up where it crosses an earlier pair, or passes through a
vertex.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import BooleanArray, FloatArray, IndexArray
from gamutcore.corner_table import following, opposite_corners, preceding, swing
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.star_shape import sees_centre

__all__ = ["recover_edges"]

MOST_CROSSED = 256
"""Largest number of edges between the vertices of a pair. Pairs are edges of similar meshes, and
cross few."""

MOST_VALENCE = 4096
"""Largest number of faces around a vertex that are searched."""

ROUNDS = 8
"""Flips that are tried, as a multiple of the number of crossed edges."""


class Flipping(NamedTuple):
    """A mesh whose edges are flipped.

    Attributes
    ----------
    position : (n, 3) float64
        Relative to the centre.
    vertex, opposite : (3 F,) int32
        Corner table.
    fixed : (3 F,) bool
        Whether the edge that a corner faces is one of the pairs.
    corner_at : (n,) int32
        A corner at each vertex; −1 for a vertex without a face.
    """

    position: FloatArray
    vertex: IndexArray
    opposite: IndexArray
    fixed: BooleanArray
    corner_at: IndexArray


@kernel
def recover_edges(
    position: FloatArray, faces: IndexArray, pairs: IndexArray
) -> tuple[IndexArray, int]:
    """Return a mesh in which given pairs of vertices are edges, and the number of pairs given up.

    The mesh is closed and star-shaped about the origin of `position`, before and after. The more
    important pairs come first.
    """
    vertex = faces.copy().reshape(-1)
    mesh = Flipping(
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
def _edge(mesh: Flipping, start: int, end: int) -> int:
    """Return a corner that faces the edge between two vertices, or −1."""
    first = mesh.corner_at[start]
    corner = first
    for _ in range(MOST_VALENCE):
        if mesh.vertex[following(corner)] == end:
            return preceding(corner)
        corner = swing(mesh.opposite, corner)
        if corner == first:
            break
    return -1


@leaf_kernel
def _side(mesh: Flipping, start: int, end: int, vertex: int) -> float:
    """Return the side of the plane through the centre and two vertices that a vertex is on."""
    position = mesh.position
    ax, ay, az = position[start, 0], position[start, 1], position[start, 2]
    bx, by, bz = position[end, 0], position[end, 1], position[end, 2]
    x, y, z = position[vertex, 0], position[vertex, 1], position[vertex, 2]
    return float(x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx))


@leaf_kernel
def _crossed_edges(mesh: Flipping, start: int, end: int, waiting: IndexArray) -> int:
    """Write the edges between two vertices; return their number, or −1 if one must stay."""
    vertex, opposite = mesh.vertex, mesh.opposite
    first = mesh.corner_at[start]
    corner, found = first, -1
    for _ in range(MOST_VALENCE):
        right, left = vertex[following(corner)], vertex[preceding(corner)]
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
        waiting[count, 0], waiting[count, 1] = vertex[following(corner)], vertex[preceding(corner)]
        count += 1
        corner = opposite[corner]
        beyond = vertex[corner]
        if beyond == end:
            return count
        side = _side(mesh, start, end, beyond)
        if side == 0.0:
            return -1
        # leave through the edge between the vertex beyond and the one on the other side
        corner = preceding(corner) if side < 0.0 else following(corner)
    return -1


@leaf_kernel
def _flip_between(mesh: Flipping, start: int, end: int, waiting: IndexArray) -> bool:
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
        near, far = mesh.vertex[corner], mesh.vertex[preceding(corner)]
        if near in (start, end) or far in (start, end):
            continue
        if (_side(mesh, start, end, near) > 0.0) != (_side(mesh, start, end, far) > 0.0):
            waiting[count, 0], waiting[count, 1] = near, far
            count += 1
    return count == 0


@leaf_kernel
def _flip(mesh: Flipping, corner: int) -> bool:
    """Replace the edge that a corner faces by the other diagonal, if both faces see the centre."""
    vertex, opposite, fixed, position = mesh.vertex, mesh.opposite, mesh.fixed, mesh.position
    other = opposite[corner]
    after, before = following(corner), preceding(corner)
    other_after, other_before = following(other), preceding(other)
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
    return sees_centre(
        position[one, 0],
        position[one, 1],
        position[one, 2],
        position[two, 0],
        position[two, 1],
        position[two, 2],
        position[three, 0],
        position[three, 1],
        position[three, 2],
    )
