"""Mismatch of two gamuts: the volume that they disagree about, relative to the reference.

The mismatch is the volume of the symmetric difference ÷ the volume of the reference (the relative
volume mismatch of Bakke & Farup, who count voxels). Here the volumes come from exact boolean
operations of the Manifold library on the two meshes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gamutcore.errors import MeshError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.mesh import TriangleMesh

__all__ = ["intersection_volume", "mismatch"]


def mismatch(reference: TriangleMesh, other: TriangleMesh) -> float:
    """Return the volume of the symmetric difference ÷ the volume of the reference.

    Parameters
    ----------
    reference, other : TriangleMesh
        Closed meshes in the same colour space.

    Returns
    -------
    float
        0 for equal gamuts, 1 + V(other) ÷ V(reference) for disjoint ones.

    Raises
    ------
    MeshError
        If a mesh is not closed and oriented, or the reference has no volume.
    """
    first, second, common = _volumes(reference, other)
    if not first > 0:
        raise MeshError(
            "the reference encloses no volume", remedy="Give a closed mesh, oriented outwards."
        )
    return max(0.0, (first + second - 2 * common) / first)


def intersection_volume(one: TriangleMesh, other: TriangleMesh) -> float:
    """Return the volume that two gamuts have in common (cubic units).

    Parameters
    ----------
    one, other : TriangleMesh
        Closed meshes in the same colour space.

    Raises
    ------
    MeshError
        If a mesh is not closed and oriented.
    """
    return _volumes(one, other)[2]


def _volumes(one: TriangleMesh, other: TriangleMesh) -> tuple[float, float, float]:
    """Volumes of two meshes and of their intersection, by the same arithmetic."""
    if one.triangles == 0 or other.triangles == 0:
        raise MeshError("a mesh has no faces", remedy="Give closed meshes, oriented outwards.")
    # a common origin and scale keep the digits in which the meshes differ
    lowest, highest = one.bounds
    origin, scale = (lowest + highest) / 2, float(np.max(highest - lowest)) / 2
    if not 0 < scale < np.inf:
        raise MeshError(
            f"the first mesh reaches from {lowest.tolist()} to {highest.tolist()}",
            remedy="Give a closed mesh of finite numbers that encloses a volume.",
        )
    first, second = _manifold(one, origin, scale), _manifold(other, origin, scale)
    common = (first ^ second).volume()
    return first.volume() * scale**3, second.volume() * scale**3, common * scale**3


def _manifold(mesh: TriangleMesh, origin: FloatArray, scale: float) -> Any:  # noqa: ANN401
    import manifold3d  # noqa: PLC0415  # only needed here

    vertices = (mesh.vertices.astype(np.float64) - origin) / scale
    solid = manifold3d.Manifold(
        manifold3d.Mesh64(
            np.ascontiguousarray(vertices), np.ascontiguousarray(mesh.faces, np.uint64)
        )
    )
    if solid.status() != manifold3d.Error.NoError:
        raise MeshError(
            f"the mesh bounds no solid: {solid.status().name}",
            remedy="Give a closed mesh whose faces are all oriented outwards.",
        )
    return solid
