"""A closed, oriented surface of genus 0 from loose triangles, or the reason why they are none.

Files have vertices several times, faces without area, and faces turned the wrong way round; all of
that is put right without moving a vertex. Holes, handles, several pieces and edges with more than
two faces are refused, with what and where.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from gamutcore.errors import MeshError
from gamutcore.mesh import TriangleMesh

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray

__all__ = ["ClosedSurface", "closed_surface"]


class ClosedSurface(NamedTuple):
    """A closed surface, oriented outwards, and what became of the triangles that made it.

    Attributes
    ----------
    mesh : TriangleMesh
        Double precision; vertices and faces in the order in which they were given.
    sources : (m,) int64
        For each vertex, the first of the given ones at its place.
    welded : int
        Vertices that were at the place of another.
    unused : int
        Places that no face has, or only faces without area.
    dropped : int
        Faces that were dropped, as two of their corners are one place or they cover each other.
    turned : int
        Faces whose corners were put in the opposite order.
    """

    mesh: TriangleMesh
    sources: LongArray
    welded: int
    unused: int
    dropped: int
    turned: int


def closed_surface(vertices: FloatArray, faces: LongArray) -> ClosedSurface:
    """Return the closed surface that triangles make.

    Parameters
    ----------
    vertices : (v, 3) float
        Equal positions are one vertex.
    faces : (f, 3) int
        In either orientation.

    Returns
    -------
    ClosedSurface

    Raises
    ------
    MeshError
        The triangles are no closed surface of genus 0 in one piece; the reason, with the number of
        edges or pieces, and ``where`` names a vertex, edge or face of the given ones.
    """
    places, sources, of = _distinct(vertices)
    welded = len(vertices) - len(places)
    corners, numbers = _without_empty(of[faces])
    if not len(corners):
        raise MeshError(
            "All faces of the mesh are without area.",
            where={"field": "faces"},
            remedy="Triangles that enclose a volume.",
        )
    edge, ends = _edges(corners)
    _refuse_open(edge, ends, numbers, sources, places)
    turned = _turned(corners, edge)
    corners = np.where(turned[:, np.newaxis], corners[:, ::-1], corners)
    used = np.unique(corners)
    kept = np.zeros(len(places), np.int64)
    kept[used] = np.arange(len(used))
    mesh = TriangleMesh(places[used], kept[corners].astype(np.int32))
    _refuse_other_topology(mesh)
    if mesh.volume < 0:
        mesh = TriangleMesh(mesh.vertices, np.ascontiguousarray(mesh.faces[:, ::-1]))
        turned = ~turned
    return ClosedSurface(
        mesh,
        sources[used],
        welded,
        len(places) - len(used),
        len(faces) - len(corners),
        int(turned.sum()),
    )


def _distinct(vertices: FloatArray) -> tuple[FloatArray, LongArray, LongArray]:
    """Return the distinct positions, the first vertex at each, and the position of each vertex."""
    order = np.lexsort(vertices.T[::-1])
    ranked = vertices[order]
    new = np.ones(len(ranked), bool)
    new[1:] = (ranked[1:] != ranked[:-1]).any(axis=1)
    # in the order in which they are met in the file: stable sorting has the first of each first
    firsts = order[new]
    rank = np.empty(len(firsts), np.int64)
    rank[np.argsort(firsts)] = np.arange(len(firsts))
    of = np.empty(len(vertices), np.int64)
    of[order] = rank[np.cumsum(new) - 1]
    sources = np.sort(firsts)
    return vertices[sources], sources, of


def _without_empty(faces: LongArray) -> tuple[LongArray, LongArray]:
    """Return the faces of three different corners that do not cover each other; their numbers.

    Two faces with the same corners are what is left of a thin place whose sides were welded.
    """
    numbers = np.flatnonzero(
        (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    )
    faces = faces[numbers]
    if not len(faces):
        return faces, numbers
    _, group, counts = np.unique(
        np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    single = counts[group.ravel()] != 2
    return faces[single], numbers[single]


def _edges(faces: LongArray) -> tuple[LongArray, LongArray]:
    """Return the number of the edge before each corner's next, (f, 3), and the edges' ends."""
    starts, stops = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    pairs = np.stack([np.minimum(starts, stops), np.maximum(starts, stops)], axis=1)
    keys = pairs[:, 0] * (int(faces.max()) + 1) + pairs[:, 1]
    _, first, edge = np.unique(keys, return_index=True, return_inverse=True)
    return edge.reshape(faces.shape), pairs[first]


def _refuse_open(
    edge: LongArray, ends: LongArray, numbers: LongArray, sources: LongArray, places: FloatArray
) -> None:
    """Refuse triangles with an edge that has not exactly two of them."""
    counts = np.bincount(edge.ravel(), minlength=len(ends))
    wrong = np.flatnonzero(counts != 2)
    if not wrong.size:
        return
    alone, many = int((counts == 1).sum()), int((counts > 2).sum())
    first = int(wrong[0])
    one, two = (int(sources[end]) for end in ends[first])
    face = int(numbers[np.flatnonzero((edge == first).any(axis=1))[0]])
    at = [tuple(round(float(x), 4) for x in places[end]) for end in ends[first]]
    parts = []
    if alone:
        parts.append(f"{alone} edges have one face only")
    if many:
        parts.append(f"{many} edges have more than two")
    raise MeshError(
        f"The mesh is not closed: {' and '.join(parts)}. The first is that of vertices {one} and "
        f"{two}, from {at[0]} to {at[1]}, in face {face}.",
        where={"face": face, "vertex": one, "field": "faces"},
        remedy="A closed mesh: every edge has two faces. Fill holes, leave out inner walls.",
    )


def _turned(faces: LongArray, edge: LongArray) -> np.ndarray:
    """Return which faces are to be turned so that all have one orientation."""
    count = len(faces)
    starts, stops = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    order = np.argsort(edge.ravel(), kind="stable")
    one, two = order[::2], order[1::2]  # the two faces' sides of every edge
    same = (starts[one] == starts[two]) & (stops[one] == stops[two])
    left, right = one // 3, two // 3
    # every face twice, as it is and turned; neighbours are joined where they fit together
    rows = np.concatenate([left, left + count])
    columns = np.concatenate(
        [np.where(same, right + count, right), np.where(same, right, right + count)]
    )
    graph = coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(2 * count,) * 2)
    pieces, label = connected_components(graph, directed=False)
    if (label[:count] == label[count:]).any():
        raise MeshError(
            "The mesh has one side only, like a Klein bottle: its faces cannot be oriented.",
            where={"field": "faces"},
            remedy="A closed surface with an inside and an outside.",
        )
    if pieces > 2:
        largest = int(np.bincount(label).max())
        raise MeshError(
            f"The mesh has {pieces // 2} pieces; the largest has {largest} of {count} faces.",
            where={"field": "faces", "pieces": pieces // 2},
            remedy="One closed surface. Leave out markers, axes and inner shells.",
        )
    # the orientation that most faces have already
    chosen = label[:count] == label[0]
    return ~chosen if 2 * int(chosen.sum()) >= count else chosen


def _refuse_other_topology(mesh: TriangleMesh) -> None:
    validity = mesh.validity()
    if not validity.manifold:
        raise MeshError(
            "The mesh touches itself: at a vertex, its faces are more than one fan.",
            where={"field": "vertices"},
            remedy="A surface that is a disc around every vertex.",
        )
    euler = validity.euler_characteristic
    if euler != 2:
        raise MeshError(
            f"The mesh has {(2 - euler) // 2} handles: {len(mesh.vertices)} vertices and "
            f"{mesh.triangles} faces are no surface of genus 0.",
            where={"field": "faces", "handles": (2 - euler) // 2},
            remedy=f"{2 * len(mesh.vertices) - 4} faces over these vertices, as of a ball.",
        )
