"""A mesh file as the boundary itself: repaired where that is safe, else refused with the reason.

Files repeat vertices, and contain faces without area and faces of the wrong orientation. These
defects are repaired without moving a vertex. Holes, handles, several pieces and edges with more
than two faces are refused, with their number and the first location.

Positions are then rounded to a grid, as for every boundary. The mesh is accepted if it is closed,
of genus 0 and star-shaped about the centre after rounding. The centre is the requested one, else
the file's own, else the point that is farthest inside of all faces.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from gamutcore.boundary.centre import Planes, StarKernelPoint, face_planes, star_kernel_point
from gamutcore.boundary.modified_convex_hull import Boundary
from gamutcore.characterisation.samples import JSON
from gamutcore.colours import xyz_to_lab
from gamutcore.errors import CentreError, MeshError
from gamutcore.geometry import (
    TriangleMesh,
    connected_components,
    faces_not_seeing_centre,
    grid_step,
    mesh_grid_step,
    nearest_grid_points,
)
from gamutcore.number_text import number_text

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.characterisation import GamutMesh

EXPLAINED = 200_000
"""Largest number of faces for which self-contacts are told from handles: the check takes 1 s."""


def mesh_vertices(mesh: GamutMesh) -> FloatArray:
    """Return the vertices in the space of the boundary, (v, 3): CIEXYZ of a profile as CIELAB."""
    return mesh.vertices if mesh.space == "CIELAB" else xyz_to_lab(mesh.vertices)


def mesh_boundary(
    mesh: GamutMesh, centre: ArrayLike | Literal["auto"] = "auto"
) -> tuple[Boundary, dict[str, JSON]]:
    """Return the boundary that a gamut mesh describes, with its provenance.

    Parameters
    ----------
    mesh : GamutMesh
    centre : (3,) array_like or "auto", optional
        Point about which the mesh must be star-shaped. "auto" takes the file's own centre if all
        faces see it from inside, else the point that is farthest inside of all faces.

    Returns
    -------
    boundary : Boundary
        Its sources are the mesh's vertices. γ is 0, because no power was used.
    provenance : dict
        The mesh's own, with ``mesh`` (numbers of read, welded, dropped and turned elements, step of
        the grid, origin of the centre) and ``warnings``.

    Raises
    ------
    MeshError
        The mesh is not closed, not in one piece, not of genus 0, or not star-shaped.
    CentreError
        The mesh is star-shaped, but not about the requested centre.
    """
    exact = _closed_surface(mesh_vertices(mesh), mesh.faces)
    steps = _steps(np.asarray(exact.mesh.vertices, np.float64))
    for step in steps:
        try:
            surface, point, origin, margin = _on_grid(exact, step, mesh, centre)
            break
        except (MeshError, CentreError):
            if step == steps[-1]:
                raise
    boundary = Boundary(
        TriangleMesh(surface.mesh.vertices.astype(np.float32), surface.mesh.faces),
        point,
        exact.sources[surface.sources],
        0.0,
    )
    warnings = [*mesh.warnings, *_warnings(exact, surface, mesh, origin)]
    provenance: dict[str, JSON] = {
        **mesh.provenance,
        "model": {"name": "none: the file is a boundary"},
        "mesh": {
            "welded": exact.welded,
            "merged_on_grid": surface.welded,
            "unused": exact.unused + surface.unused,
            "dropped": exact.dropped + surface.dropped,
            "turned": exact.turned,
            "centre": {"from": origin, "margin": round(margin, 6)},
        },
        "warnings": list[JSON](warnings),
    }
    for name in ("vertices_read", "triangles_read"):
        provenance.pop(name, None)
        read = mesh.provenance.get(name)
        counts = provenance["mesh"]
        if read is not None and isinstance(counts, dict):
            counts[name] = read
    return boundary, provenance


def _steps(vertices: FloatArray) -> list[float]:
    """Steps of the grids to try: the mesh's own grid, else a coarse and a fine one."""
    fine = mesh_grid_step(vertices)
    if np.array_equal(nearest_grid_points(vertices, fine), vertices):
        return [fine]
    return [max(grid_step(vertices), fine), fine]


def _on_grid(
    exact: _ClosedSurface, step: float, mesh: GamutMesh, centre: ArrayLike | Literal["auto"]
) -> tuple[_ClosedSurface, FloatArray, str, float]:
    """Surface on a grid, its centre, the origin of the centre, and its margin."""
    rounded = nearest_grid_points(exact.mesh.vertices, step)
    surface = _closed_surface(rounded, np.asarray(exact.mesh.faces, np.int64))
    flat = _flat_faces(surface.mesh)
    if flat.size:
        one, two, three = surface.mesh.faces[flat[0]]
        raise MeshError(
            f"{flat.size} faces have no area on the grid of {number_text(step, 3)} that "
            f"positions are rounded to; the first has the corners {_text_of(surface.mesh, one)}, "
            f"{_text_of(surface.mesh, two)} and {_text_of(surface.mesh, three)}.",
            where={"field": "faces", "faces": int(flat.size)},
            remedy="Send a mesh without slivers: merge vertices that are close together.",
        )
    if not isinstance(centre, str):
        option_centre = nearest_grid_points(np.asarray(centre, np.float64), step)
        _refuse_inverted_faces(surface.mesh, option_centre)
        return surface, option_centre, "the option centre", _margin(surface.mesh, option_centre)
    if mesh.centre is not None:
        file_centre = nearest_grid_points(mesh.centre, step)
        if not _inverted_faces(surface.mesh, file_centre).size:
            return surface, file_centre, "the file", _margin(surface.mesh, file_centre)
    kernel_point = _star_kernel_point(surface.mesh)
    point = nearest_grid_points(kernel_point.point, step)
    unseen = _inverted_faces(surface.mesh, point)
    if unseen.size:
        raise _not_star_shaped(
            surface.mesh, kernel_point.margin, len(unseen), kernel_point.decisive[:4]
        )
    return surface, point, "found: furthest inside of all faces", _margin(surface.mesh, point)


def _inverted_faces(mesh: TriangleMesh, centre: FloatArray) -> np.ndarray:
    return faces_not_seeing_centre(
        np.ascontiguousarray(mesh.vertices - centre, np.float64),
        np.ascontiguousarray(mesh.faces, np.int32),
    )


def _margin(mesh: TriangleMesh, centre: FloatArray) -> float:
    """Smallest distance of the centre from the plane of a face."""
    return float(_planes(mesh, centre).offsets.min())


def _planes(mesh: TriangleMesh, centre: FloatArray) -> Planes:
    """Planes of the faces, relative to a centre."""
    return face_planes(
        np.ascontiguousarray(mesh.vertices - centre, np.float64),
        np.ascontiguousarray(mesh.faces, np.int32),
    )


def _star_kernel_point(mesh: TriangleMesh) -> StarKernelPoint:
    """The point that is farthest inside of the planes of all faces."""
    lowest, highest = mesh.bounds
    middle = (lowest + highest) / 2
    kernel_point = star_kernel_point(_planes(mesh, middle), float((highest - lowest).max()))
    return kernel_point._replace(point=kernel_point.point + middle)


def _flat_faces(mesh: TriangleMesh) -> np.ndarray:
    first, second, third = mesh.corners(mesh.vertices[0])
    return np.flatnonzero((np.cross(second - first, third - first) == 0).all(axis=1))


def _refuse_inverted_faces(mesh: TriangleMesh, centre: FloatArray) -> None:
    unseen = _inverted_faces(mesh, centre)
    if not unseen.size:
        return
    kernel_point = _star_kernel_point(mesh)
    if kernel_point.margin <= 0:
        raise _not_star_shaped(mesh, kernel_point.margin, len(unseen), kernel_point.decisive[:4])
    raise CentreError(
        f"The mesh is not star-shaped about the centre {tuple(centre.tolist())}: {unseen.size} of "
        f"{mesh.triangles} faces do not see it from inside, the first of them at "
        f"{_text_of(mesh, mesh.faces[unseen[0]][0])}.",
        where={"field": "centre"},
        remedy="Give 'auto', or a point near "
        f"{[round(x, 3) for x in kernel_point.point.tolist()]}, which all faces see from inside.",
    )


def _not_star_shaped(
    mesh: TriangleMesh, margin: float, unseen: int, decisive: np.ndarray
) -> MeshError:
    at = ", ".join(_text_of(mesh, mesh.faces[face][0]) for face in decisive)
    problem = (
        f"no point sees all faces from inside (the best point misses by {number_text(-margin, 4)})"
        if margin <= 0
        else f"the points that see all faces from inside are within {number_text(margin, 4)} of "
        f"each other, too close for the grid ({unseen} faces are missed)"
    )
    return MeshError(
        f"The mesh is not star-shaped: {problem}. Conflicting faces are at {at}.",
        where={"field": "faces", "face": int(decisive[0])},
        remedy="Send a surface that every ray from some inner point meets once. Vertices alone, "
        "sent as CSV or JSON, are wrapped in such a surface.",
    )


def _text_of(mesh: TriangleMesh, vertex: int) -> str:
    return str(tuple(round(float(x), 3) for x in mesh.vertices[vertex]))


def _warnings(
    exact: _ClosedSurface, surface: _ClosedSurface, mesh: GamutMesh, origin: str
) -> list[str]:
    warnings = []
    if mesh.space != "CIELAB":
        warnings.append(f"The vertices are {mesh.space[3:]}. Faces are plane in CIELAB, not there.")
    if exact.turned == exact.mesh.triangles:
        warnings.append("The mesh was inside out: all faces were reversed.")
    elif exact.turned:
        warnings.append(f"{exact.turned} faces were reversed to the orientation of the others.")
    dropped = exact.dropped + surface.dropped
    if dropped:
        warnings.append(f"{dropped} faces without area, or covering each other, were dropped.")
    unused = exact.unused + surface.unused
    if unused:
        warnings.append(f"{unused} vertices belong to no face and were dropped.")
    if mesh.centre is not None and origin.startswith("found"):
        warnings.append(
            f"Not all faces see the file's own centre {mesh.centre.tolist()} from inside. Another "
            "centre was found."
        )
    return warnings


class _ClosedSurface(NamedTuple):
    """A closed surface, oriented outwards, and the repairs that were made."""

    mesh: TriangleMesh  # double precision; vertices and faces in their given order
    sources: LongArray  # (m,) for each vertex, the first given vertex at its position
    welded: int  # vertices at the position of another vertex
    unused: int  # positions without a face, or only with faces without area
    dropped: int  # faces with two corners at one position, or that cover each other
    turned: int  # faces whose orientation was reversed


def _closed_surface(vertices: FloatArray, faces: LongArray) -> _ClosedSurface:
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
) -> _ClosedSurface:
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
    return _ClosedSurface(
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
