"""A closed, oriented surface of genus 0 from loose triangles, or the reason why they are none.

Files have vertices several times, faces without area, and faces turned the wrong way round; all of
that is put right without moving a vertex. Holes, handles, several pieces and edges with more than
two faces are refused, with what and where.
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
"""Faces of a mesh at most for which handles are told from places where it touches itself: 1 s."""


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
    corners = of[faces]
    numbers = np.flatnonzero(
        (corners[:, 0] != corners[:, 1])
        & (corners[:, 1] != corners[:, 2])
        & (corners[:, 2] != corners[:, 0])
    )
    corners = corners[numbers]
    try:
        return _oriented(places, sources, corners, numbers, vertices, faces)
    except MeshError:
        single = _uncovered(corners)
        if len(single) == len(corners):
            raise
        return _oriented(places, sources, corners[single], numbers[single], vertices, faces)


def _oriented(
    places: FloatArray,
    sources: LongArray,
    corners: LongArray,
    numbers: LongArray,
    vertices: FloatArray,
    faces: LongArray,
) -> ClosedSurface:
    """Return the surface of faces between distinct places, which are numbers of the given ones."""
    if not len(corners):
        raise MeshError(
            "All faces of the mesh are without area.",
            where={"field": "faces"},
            remedy="Triangles that enclose a volume.",
        )
    edge, order = _edges(corners)
    _refuse_open(edge, corners, numbers, sources, places)
    turned = _turned(corners, order)
    corners = np.where(turned[:, np.newaxis], corners[:, ::-1], corners)
    is_used = np.zeros(len(places), bool)
    is_used[corners.ravel()] = True
    used = np.flatnonzero(is_used)
    mesh = TriangleMesh(places[used], (np.cumsum(is_used) - 1)[corners].astype(np.int32))
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
        len(vertices) - len(places),
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


def _uncovered(faces: LongArray) -> LongArray:
    """Return the faces that do not cover another in a pair.

    Two faces with the same corners are what is left of a thin place whose sides were welded.
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
    """Return the number of the edge after each corner, (f, 3), and the corners in its order."""
    starts, stops = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    keys = np.minimum(starts, stops) * (int(faces.max()) + 1) + np.maximum(starts, stops)
    order = np.argsort(keys, kind="stable")
    ranked = keys[order]
    edge = np.empty(len(keys), np.int64)
    edge[order] = np.concatenate([[0], np.cumsum(ranked[1:] != ranked[:-1])])
    return edge.reshape(faces.shape), order


def _refuse_open(
    edge: LongArray, faces: LongArray, numbers: LongArray, sources: LongArray, places: FloatArray
) -> None:
    """Refuse triangles with an edge that has not exactly two of them."""
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
    at = [tuple(round(float(x), 4) for x in places[end]) for end in ends]
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


def _turned(faces: LongArray, order: LongArray) -> np.ndarray:
    """Return which faces are to be turned so that all have one orientation."""
    count = len(faces)
    starts = faces.ravel()
    one, two = order[::2], order[1::2]  # the two faces' sides of every edge
    same = starts[one] == starts[two]
    left, right = one // 3, two // 3
    if not same.any():
        pieces, label = connected_components(left, right, count)
        if pieces > 1:
            raise _several(pieces, label, count)
        return np.zeros(count, bool)
    # every face twice, as it is and turned; neighbours are joined where they fit together
    pieces, label = connected_components(
        np.concatenate([left, left + count]),
        np.concatenate(
            [np.where(same, right + count, right), np.where(same, right, right + count)]
        ),
        2 * count,
    )
    if (label[:count] == label[count:]).any():
        raise MeshError(
            "The mesh has one side only, like a Klein bottle: its faces cannot be oriented.",
            where={"field": "faces"},
            remedy="A closed surface with an inside and an outside.",
        )
    if pieces > 2:
        raise _several(pieces // 2, label, count)
    # the orientation that most faces have already
    chosen = label[:count] == label[0]
    return ~chosen if 2 * int(chosen.sum()) >= count else chosen


def _several(pieces: int, label: np.ndarray, count: int) -> MeshError:
    largest = int(np.bincount(label).max())
    return MeshError(
        f"The mesh has {pieces} pieces; the largest has {largest} of {count} faces.",
        where={"field": "faces", "pieces": pieces},
        remedy="One closed surface. Leave out markers, axes and inner shells.",
    )


def _other_topology(mesh: TriangleMesh) -> MeshError:
    """Return why a closed surface in one piece has not as many faces as a ball."""
    if mesh.triangles > EXPLAINED:
        return MeshError(
            f"The mesh has handles, or touches itself: {len(mesh.vertices)} vertices and "
            f"{mesh.triangles} faces are no surface of genus 0.",
            where={"field": "faces"},
            remedy=f"{2 * len(mesh.vertices) - 4} faces over these vertices, as of a ball.",
        )
    validity = mesh.validity()
    if not validity.manifold:
        return MeshError(
            "The mesh touches itself: at a vertex, its faces are more than one fan.",
            where={"field": "vertices"},
            remedy="A surface that is a disc around every vertex.",
        )
    handles = (2 - validity.euler_characteristic) // 2
    return MeshError(
        f"The mesh has {handles} handles: {len(mesh.vertices)} vertices and {mesh.triangles} "
        "faces are no surface of genus 0.",
        where={"field": "faces", "handles": handles},
        remedy=f"{2 * len(mesh.vertices) - 4} faces over these vertices, as of a ball.",
    )
