"""The corner table: a triangle mesh's connectivity as two flat integer arrays.

Corner ``c = 3 f + i`` is the i-th corner of face f. ``vertex[c]`` is the vertex at it;
``opposite[c]`` is the corner facing it across the edge that joins the face's other two corners
(Rossignac, Safonova & Szymczak, "3D Compression Made Simple: Edgebreaker on a Corner-Table",
2001). All traversal is index arithmetic: ``following`` and ``preceding`` within a face, ``swing``
around a vertex.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import IndexArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["following", "opposite_corners", "preceding", "swing"]


UNKNOWN, TWICE = -1, -2
"""Of an edge whose counterpart has not been found, and of one that is that of several."""

ZERO, TWO, THREE = np.uint64(0), np.uint64(2), np.uint64(3)
"""Unsigned: the remainder of a number that may be negative takes three times the instructions."""


@leaf_kernel
def following(corner: int) -> int:
    """Next corner of the same face, counter-clockwise."""
    return corner - 2 if np.uint64(corner) % THREE == TWO else corner + 1


@leaf_kernel
def preceding(corner: int) -> int:
    """Previous corner of the same face."""
    return corner + 2 if np.uint64(corner) % THREE == ZERO else corner - 1


@leaf_kernel
def swing(opposite: IndexArray, corner: int) -> int:
    """Corner at the same vertex in the face across the edge to the preceding corner."""
    return following(opposite[following(corner)])


@leaf_kernel
def _counterpart(end_of: IndexArray, facing: IndexArray, begin: int, end: int, start: int) -> int:
    """Corner facing the one edge, of those from a vertex, that ends where another starts; or −1."""
    found, matches = -1, 0
    for place in range(begin, end):
        if end_of[place] == start:
            found = facing[place]
            matches += 1
    return found if matches == 1 else -1


@kernel
def opposite_corners(faces: IndexArray, vertex_count: int) -> IndexArray:
    """Opposite corner of every corner of a closed, oriented mesh.

    Parameters
    ----------
    faces : (n, 3) int32
        Vertex indices within 0 to `vertex_count` − 1.
    vertex_count : int

    Returns
    -------
    (3 n,) int32
        −1 where the edge has no counterpart running the other way, or more than one: not a closed
        oriented manifold.
    """
    count = 3 * len(faces)
    # for the edges from each vertex, vertex by vertex: where they end, and the corner facing them
    offset = np.zeros(vertex_count + 1, np.int32)
    for face in range(len(faces)):
        for place in range(3):
            offset[faces[face, place] + 1] += 1
    for index in range(vertex_count):
        offset[index + 1] += offset[index]
    end_of, facing = np.empty(count, np.int32), np.empty(count, np.int32)
    filled = offset[:-1].copy()
    for face in range(len(faces)):
        for place in range(3):
            start = faces[face, place]
            end_of[filled[start]] = faces[face, (place + 1) % 3]
            facing[filled[start]] = 3 * face + (place + 2) % 3
            filled[start] += 1
    opposite = np.full(count, UNKNOWN, np.int32)
    for start in range(vertex_count):
        here = offset[start + 1] - offset[start]
        for edge in range(offset[start], offset[start + 1]):
            end = end_of[edge]
            # among the edges of the end that has fewer: a hub's would be gone through for each
            there = offset[end + 1] - offset[end]
            if there > here or (there == here and end < start):  # found from its other end
                continue
            found = _counterpart(end_of, facing, offset[end], offset[end + 1], start)
            if found >= 0:
                opposite[facing[edge]] = found
                # an edge used twice in one direction would be found twice from the other one
                known = opposite[found] != UNKNOWN and found != facing[edge]
                opposite[found] = TWICE if known else facing[edge]
    for corner in range(count):
        if opposite[corner] < 0 or opposite[opposite[corner]] != corner:
            opposite[corner] = -1
    return opposite
