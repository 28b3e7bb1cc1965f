"""A mesh file as the boundary itself: repaired where that is safe, else refused with the reason.

Positions are first rounded to a grid, as for every boundary. The mesh is accepted if it is closed,
of genus 0 and star-shaped about the centre after rounding. The centre is the requested one, else
the file's own, else the point that is farthest inside of all faces.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from gamutcore.boundary.closed_surface import ClosedSurface, closed_surface
from gamutcore.boundary.modified_convex_hull import Boundary
from gamutcore.boundary.star_kernel import Planes, StarKernelPoint, face_planes, star_kernel_point
from gamutcore.characterisation.samples import JSON
from gamutcore.colours.spaces.cielab import xyz_to_lab
from gamutcore.errors import CentreError, MeshError
from gamutcore.grid import grid_step, mesh_grid_step, nearest_grid_points
from gamutcore.mesh import TriangleMesh
from gamutcore.star_shape import faces_not_seeing_centre

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation import GamutMesh

__all__ = ["mesh_boundary"]


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
    vertices = mesh.vertices if mesh.space == "CIELAB" else xyz_to_lab(mesh.vertices)
    exact = closed_surface(vertices, mesh.faces)
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
    exact: ClosedSurface, step: float, mesh: GamutMesh, centre: ArrayLike | Literal["auto"]
) -> tuple[ClosedSurface, FloatArray, str, float]:
    """Surface on a grid, its centre, the origin of the centre, and its margin."""
    rounded = nearest_grid_points(exact.mesh.vertices, step)
    surface = closed_surface(rounded, np.asarray(exact.mesh.faces, np.int64))
    flat = _flat_faces(surface.mesh)
    if flat.size:
        one, two, three = surface.mesh.faces[flat[0]]
        raise MeshError(
            f"{flat.size} faces have no area on the grid of {step:.3g} that positions are rounded "
            f"to; the first has the corners {_text_of(surface.mesh, one)}, "
            f"{_text_of(surface.mesh, two)} and {_text_of(surface.mesh, three)}.",
            where={"field": "faces", "faces": int(flat.size)},
            remedy="Send a mesh without slivers: merge vertices that are close together.",
        )
    if not isinstance(centre, str):
        asked = nearest_grid_points(np.asarray(centre, np.float64), step)
        _refuse_inverted_faces(surface.mesh, asked)
        return surface, asked, "the option centre", _margin(surface.mesh, asked)
    if mesh.centre is not None:
        own = nearest_grid_points(mesh.centre, step)
        if not _inverted_faces(surface.mesh, own).size:
            return surface, own, "the file", _margin(surface.mesh, own)
    found = _star_kernel_point(surface.mesh)
    point = nearest_grid_points(found.point, step)
    unseen = _inverted_faces(surface.mesh, point)
    if unseen.size:
        raise _not_star_shaped(surface.mesh, found.margin, len(unseen), found.decisive[:4])
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
    found = star_kernel_point(_planes(mesh, middle), float((highest - lowest).max()))
    return found._replace(point=found.point + middle)


def _flat_faces(mesh: TriangleMesh) -> np.ndarray:
    first, second, third = mesh.corners(mesh.vertices[0])
    return np.flatnonzero((np.cross(second - first, third - first) == 0).all(axis=1))


def _refuse_inverted_faces(mesh: TriangleMesh, centre: FloatArray) -> None:
    unseen = _inverted_faces(mesh, centre)
    if not unseen.size:
        return
    found = _star_kernel_point(mesh)
    if found.margin <= 0:
        raise _not_star_shaped(mesh, found.margin, len(unseen), found.decisive[:4])
    raise CentreError(
        f"The mesh is not star-shaped about the centre {tuple(centre.tolist())}: {unseen.size} of "
        f"{mesh.triangles} faces do not see it from inside, the first of them at "
        f"{_text_of(mesh, mesh.faces[unseen[0]][0])}.",
        where={"field": "centre"},
        remedy=f"Give 'auto', or a point near {[round(x, 3) for x in found.point.tolist()]}, which "
        "all faces see from inside.",
    )


def _not_star_shaped(
    mesh: TriangleMesh, margin: float, unseen: int, decisive: np.ndarray
) -> MeshError:
    at = ", ".join(_text_of(mesh, mesh.faces[face][0]) for face in decisive)
    problem = (
        f"no point sees all faces from inside (the best point misses by {-margin:.4g})"
        if margin <= 0
        else f"the points that see all faces from inside are within {margin:.4g} of each other, "
        f"too close for the grid ({unseen} faces are missed)"
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
    exact: ClosedSurface, surface: ClosedSurface, mesh: GamutMesh, origin: str
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
