"""A closed, oriented surface of genus 0 from loose triangles, or the reason why there is none.

Files repeat vertices, and contain faces without area and faces of the wrong orientation. These
defects are repaired without moving a vertex. Holes, handles, several pieces and edges with more
than two faces are refused, with their number and the first location.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.errors import MeshError
from gamutcore.mesh import TriangleMesh, connected_components

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray

__all__ = ["ClosedSurface", "closed_surface"]

EXPLAINED = 200_000
"""Largest number of faces for which self-contacts are told from handles: the check takes 1 s."""


class ClosedSurface(NamedTuple):
    """A closed surface, oriented outwards, and the repairs that were made.

    Attributes
    ----------
    mesh : TriangleMesh
        Double precision; vertices and faces in their given order.
    sources : (m,) int64
        For each vertex, the first given vertex at its position.
    welded : int
        Vertices at the position of another vertex.
    unused : int
        Positions without a face, or only with faces without area.
    dropped : int
        Faces that were dropped: two corners at one position, or faces that cover each other.
    turned : int
        Faces whose orientation was reversed.
    """

    mesh: TriangleMesh
    sources: LongArray
    welded: int
    unused: int
    dropped: int
    turned: int


def closed_surface(vertices: FloatArray, faces: LongArray) -> ClosedSurface:
    """Return the closed surface of loose triangles, given in either orientation.

    A `MeshError` says why the triangles are not one closed surface of genus 0. The message has the
    number of faulty edges or pieces, and ``where`` names a given vertex, edge or face.
    """
    positions, sources, of = _distinct_positions(vertices)
    corners = of[faces]
    numbers = np.flatnonzero(
        (corners[:, 0] != corners[:, 1])
        & (corners[:, 1] != corners[:, 2])
        & (corners[:, 2] != corners[:, 0])
    )
    corners = corners[numbers]
    try:
        return _surface_of(positions, sources, corners, numbers, vertices, faces)
    except MeshError:
        single = _single_faces(corners)
        if len(single) == len(corners):
            raise
        return _surface_of(positions, sources, corners[single], numbers[single], vertices, faces)


def _surface_of(
    positions: FloatArray,
    sources: LongArray,
    corners: LongArray,
    numbers: LongArray,
    vertices: FloatArray,
    faces: LongArray,
) -> ClosedSurface:
    """Closed surface of faces between distinct positions; `numbers` are their given numbers."""
    if not len(corners):
        raise MeshError(
            "No face of the mesh has an area.",
            where={"field": "faces"},
            remedy="Send triangles that enclose a volume.",
        )
    edge, order = _edges(corners)
    _refuse_open(edge, corners, numbers, sources, positions)
    turned = _reversal(corners, order)
    corners = np.where(turned[:, np.newaxis], corners[:, ::-1], corners)
    is_used = np.zeros(len(positions), bool)
    is_used[corners.ravel()] = True
    used = np.flatnonzero(is_used)
    mesh = TriangleMesh(positions[used], (np.cumsum(is_used) - 1)[corners].astype(np.int32))
    # A closed, oriented surface in one piece that touches itself at no or some vertices has
    # 2 V' - 4 + 4 g faces, for V' >= V fans and g handles: 2 V - 4 of them only for V' = V, g = 0.
    if mesh.triangles != 2 * len(used) - 4:
        raise _other_topology(mesh)
    if mesh.volume < 0:
        mesh = TriangleMesh(mesh.vertices, np.ascontiguousarray(mesh.faces[:, ::-1]))
        turned = ~turned
    return ClosedSurface(
        mesh,
        sources[used],
        len(vertices) - len(positions),
        len(positions) - len(used),
        len(faces) - len(corners),
        int(turned.sum()),
    )


def _distinct_positions(vertices: FloatArray) -> tuple[FloatArray, LongArray, LongArray]:
    """Distinct positions, the first vertex at each, and the position of each vertex."""
    order = np.lexsort(vertices.T[::-1])
    ranked = vertices[order]
    new = np.ones(len(ranked), bool)
    new[1:] = (ranked[1:] != ranked[:-1]).any(axis=1)
    # keep the order of the file: stable sorting puts the first vertex of each position first
    firsts = order[new]
    rank = np.empty(len(firsts), np.int64)
    rank[np.argsort(firsts)] = np.arange(len(firsts))
    of = np.empty(len(vertices), np.int64)
    of[order] = rank[np.cumsum(new) - 1]
    sources = np.sort(firsts)
    return vertices[sources], sources, of


def _single_faces(faces: LongArray) -> LongArray:
    """Faces that do not form a pair with the same three corners.

    Such pairs remain of thin walls whose sides were welded.
    """
    if not len(faces):
        return np.empty(0, np.int64)
    named = np.sort(faces, axis=1)
    order = np.lexsort(named.T)
    ranked = named[order]
    group = np.empty(len(faces), np.int64)
    new = np.concatenate([[0], (ranked[1:] != ranked[:-1]).any(axis=1)])
    group[order] = np.cumsum(new)
    return np.flatnonzero(np.bincount(group)[group] != 2)


def _edges(faces: LongArray) -> tuple[LongArray, LongArray]:
    """Number of the edge after each corner, (f, 3), and the corners sorted by edge."""
    starts, stops = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    keys = np.minimum(starts, stops) * (int(faces.max()) + 1) + np.maximum(starts, stops)
    order = np.argsort(keys, kind="stable")
    ranked = keys[order]
    edge = np.empty(len(keys), np.int64)
    edge[order] = np.concatenate([[0], np.cumsum(ranked[1:] != ranked[:-1])])
    return edge.reshape(faces.shape), order


def _refuse_open(
    edge: LongArray, faces: LongArray, numbers: LongArray, sources: LongArray, positions: FloatArray
) -> None:
    """Refuse triangles with an edge that does not have exactly two faces."""
    counts = np.bincount(edge.ravel())
    wrong = np.flatnonzero(counts != 2)
    if not wrong.size:
        return
    alone, many = int((counts == 1).sum()), int((counts > 2).sum())
    first = int(wrong[0])
    corner = int(np.argmax(edge.ravel() == first))
    ends = (faces[corner // 3, corner % 3], faces[corner // 3, (corner + 1) % 3])
    face = int(numbers[corner // 3])
    one, two = (int(sources[end]) for end in ends)
    at = [tuple(round(float(x), 4) for x in positions[end]) for end in ends]
    parts = []
    if alone:
        parts.append(f"{alone} edges have only one face")
    if many:
        parts.append(f"{many} edges have more than two faces")
    raise MeshError(
        f"The mesh is not closed: {' and '.join(parts)}. The first is the edge of vertices {one} "
        f"and {two}, from {at[0]} to {at[1]}, in face {face}.",
        where={"face": face, "vertex": one, "field": "faces"},
        remedy="Send a mesh whose edges all have two faces: fill holes, leave out inner walls.",
    )


def _reversal(faces: LongArray, order: LongArray) -> np.ndarray:
    """Whether each face must be reversed to give all faces one orientation."""
    count = len(faces)
    starts = faces.ravel()
    one, two = order[::2], order[1::2]  # the two corners of every edge, one in each face
    same = starts[one] == starts[two]
    left, right = one // 3, two // 3
    if not same.any():
        pieces, label = connected_components(left, right, count)
        if pieces > 1:
            raise _several_pieces(pieces, label, count)
        return np.zeros(count, bool)
    # a graph of all faces in both orientations, with edges between consistent neighbours
    pieces, label = connected_components(
        np.concatenate([left, left + count]),
        np.concatenate(
            [np.where(same, right + count, right), np.where(same, right, right + count)]
        ),
        2 * count,
    )
    if (label[:count] == label[count:]).any():
        raise MeshError(
            "The mesh cannot be oriented: it has only one side, like a Klein bottle.",
            where={"field": "faces"},
            remedy="Send a closed surface with an inside and an outside.",
        )
    if pieces > 2:
        raise _several_pieces(pieces // 2, label, count)
    # keep the orientation of the majority
    chosen = label[:count] == label[0]
    return ~chosen if 2 * int(chosen.sum()) >= count else chosen


def _several_pieces(pieces: int, label: np.ndarray, count: int) -> MeshError:
    largest = int(np.bincount(label).max())
    return MeshError(
        f"The mesh has {pieces} pieces; the largest has {largest} of {count} faces.",
        where={"field": "faces", "pieces": pieces},
        remedy="Send one closed surface, without markers, axes and inner shells.",
    )


def _other_topology(mesh: TriangleMesh) -> MeshError:
    """Return the error for a closed surface in one piece that is not a topological sphere."""
    if mesh.triangles > EXPLAINED:
        return MeshError(
            f"The mesh has handles or touches itself: {len(mesh.vertices)} vertices and "
            f"{mesh.triangles} faces are not a surface of genus 0.",
            where={"field": "faces"},
            remedy="Send a surface without handles, which is a ball in shape.",
        )
    validity = mesh.validity()
    if not validity.manifold:
        return MeshError(
            "The mesh touches itself: at a vertex, its faces form more than one fan.",
            where={"field": "vertices"},
            remedy="Send a surface that is a disc around every vertex.",
        )
    handles = (2 - validity.euler_characteristic) // 2
    return MeshError(
        f"The mesh has {handles} handles: {len(mesh.vertices)} vertices and {mesh.triangles} "
        "faces are not a surface of genus 0.",
        where={"field": "faces", "handles": handles},
        remedy="Send a surface without handles, which is a ball in shape.",
    )
