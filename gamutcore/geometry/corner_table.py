"""The corner table: the connectivity of a triangle mesh as two flat integer arrays.

Corner ``c = 3 f + i`` is the i-th corner of face f, and ``vertex[c]`` is its vertex.
``opposite[c]`` is the corner of the neighbouring face across the edge between the other two corners
(Rossignac, Safonova & Szymczak, "3D Compression Made Simple: Edgebreaker on a Corner-Table",
2001). Traversal is index arithmetic: `following` and `preceding` within a face, `swing` around a
vertex.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import IndexArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["following", "opposite_corners", "preceding", "swing", "vertex_fans"]


UNKNOWN, TWICE = -1, -2
"""Marks of an edge without a known counterpart, and of an edge with several."""

ZERO, TWO, THREE = np.uint64(0), np.uint64(2), np.uint64(3)
"""Unsigned, because the remainder of a signed number takes three times the instructions."""


@leaf_kernel
def following(corner: int) -> int:
    """Return the next corner of the same face, counter-clockwise."""
    return corner - 2 if np.uint64(corner) % THREE == TWO else corner + 1


@leaf_kernel
def preceding(corner: int) -> int:
    """Return the previous corner of the same face."""
    return corner + 2 if np.uint64(corner) % THREE == ZERO else corner - 1


@leaf_kernel
def swing(opposite: IndexArray, corner: int) -> int:
    """Return the corner at the same vertex in the next face around it."""
    return following(opposite[following(corner)])


@leaf_kernel
def _counterpart(end_of: IndexArray, facing: IndexArray, begin: int, end: int, start: int) -> int:
    """Corner facing the only edge, among the edges from a vertex, that ends at `start`; or −1."""
    found, matches = -1, 0
    for edge in range(begin, end):
        if end_of[edge] == start:
            found = facing[edge]
            matches += 1
    return found if matches == 1 else -1


@kernel
def vertex_fans(corner: IndexArray, vertices: int) -> tuple[IndexArray, IndexArray]:
    """Return the faces around each vertex, one vertex after the other, as (end, fan).

    `corner` (3 F,) has the vertex of every corner. `end` (vertices,) is the end of each vertex's
    part of `fan` (3 F,); faces ascend within a part.
    """
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


@kernel
def opposite_corners(faces: IndexArray, vertex_count: int) -> IndexArray:
    """Return the opposite corner (3 n,) of every corner of a closed, oriented mesh.

    It is −1 where an edge has no counterpart in the opposite direction, or several. The mesh is
    then not a closed, oriented manifold.
    """
    count = 3 * len(faces)
    # edges grouped by their start vertex: the end vertex and the corner facing the edge
    offset = np.zeros(vertex_count + 1, np.int32)
    for face in range(len(faces)):
        for corner in range(3):
            offset[faces[face, corner] + 1] += 1
    for index in range(vertex_count):
        offset[index + 1] += offset[index]
    end_of, facing = np.empty(count, np.int32), np.empty(count, np.int32)
    filled = offset[:-1].copy()
    for face in range(len(faces)):
        for corner in range(3):
            start = faces[face, corner]
            end_of[filled[start]] = faces[face, (corner + 1) % 3]
            facing[filled[start]] = 3 * face + (corner + 2) % 3
            filled[start] += 1
    opposite = np.full(count, UNKNOWN, np.int32)
    for start in range(vertex_count):
        here = offset[start + 1] - offset[start]
        for edge in range(offset[start], offset[start + 1]):
            end = end_of[edge]
            # search at the end with fewer edges: a vertex with many would be searched many times
            there = offset[end + 1] - offset[end]
            if there > here or (there == here and end < start):  # found from the other end
                continue
            found = _counterpart(end_of, facing, offset[end], offset[end + 1], start)
            if found >= 0:
                opposite[facing[edge]] = found
                # an edge used twice in one direction is found twice from its counterpart
                known = opposite[found] != UNKNOWN and found != facing[edge]
                opposite[found] = TWICE if known else facing[edge]
    for corner in range(count):
        if opposite[corner] < 0 or opposite[opposite[corner]] != corner:
            opposite[corner] = -1
    return opposite
