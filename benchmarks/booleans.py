"""Volumes by exact boolean operations of the Manifold library on any two closed meshes.

Measurements and tests compare them with the volumes of `gamutcore`, which are computed for
star-shaped meshes alone.
"""

from __future__ import annotations

from typing import Any

import manifold3d
import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.errors import MeshError
from gamutcore.geometry import TriangleMesh

REMEDY = "Give a closed mesh whose faces are all oriented outwards."


def mismatch(reference: TriangleMesh, other: TriangleMesh) -> float:
    """Return the volume of the symmetric difference ÷ the volume of the reference.

    A mesh that is not closed and oriented, or has no volume, raises MeshError.
    """
    first, second, common = _volumes(reference, other)
    return max(0.0, (first + second - 2 * common) / first)


def intersection_volume(one: TriangleMesh, other: TriangleMesh) -> float:
    """Return the volume that two gamuts have in common; errors are those of `mismatch`."""
    return _volumes(one, other)[2]


def _volumes(one: TriangleMesh, other: TriangleMesh) -> tuple[float, float, float]:
    """Return the volumes of two meshes and of their intersection, by the same arithmetic."""
    # a common origin and scale keep the digits in which the meshes differ
    lowest, highest = one.bounds
    origin, scale = (lowest + highest) / 2, float(np.max(highest - lowest)) / 2
    first, second = _solid(one, origin, scale), _solid(other, origin, scale)
    if not first.volume() > 0:
        raise MeshError("the reference encloses no volume", remedy=REMEDY)
    common = (first ^ second).volume()
    return first.volume() * scale**3, second.volume() * scale**3, common * scale**3


def _solid(mesh: TriangleMesh, origin: FloatArray, scale: float) -> Any:  # noqa: ANN401
    vertices = (mesh.vertices.astype(np.float64) - origin) / scale
    solid = manifold3d.Manifold(
        manifold3d.Mesh64(
            np.ascontiguousarray(vertices), np.ascontiguousarray(mesh.faces, np.uint64)
        )
    )
    if solid.status() != manifold3d.Error.NoError:
        raise MeshError(f"the mesh bounds no solid: {solid.status().name}", remedy=REMEDY)
    return solid
