"""In gamut: whether points are inside a level, decided without rounding errors.

A level is star-shaped about its centre. A point is therefore inside if it is not beyond the face
whose cone it is in. The cube map of the index gives a few candidates for the face. Points outside
the box, or in the ball around the centre, need none. Where the sign of a product is uncertain in
float64, the exact determinant decides: points near the planes through the edges, or near a face.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.kernels import leaf_kernel
from gamutcore.queries.directions import cell_of
from gamutcore.queries.exact import orientation
from gamutcore.queries.index import LevelIndex

__all__ = ["is_inside"]

NEAR = 2.0**-10
"""Part of the farthest vertex's distance from the centre beyond which the cell is certain."""


@leaf_kernel
def is_inside(px: float, py: float, pz: float, index: LevelIndex, terms: FloatArray) -> bool:
    """Whether a point is inside a level, or on its surface.

    Parameters
    ----------
    px, py, pz : float
    index : LevelIndex
    terms : (TERMS,) float64
        Work array of the exact predicates.
    """
    box, planes = index.box, index.planes
    if (
        px < box[0, 0]
        or px > box[1, 0]
        or py < box[0, 1]
        or py > box[1, 1]
        or pz < box[0, 2]
        or pz > box[1, 2]
    ):
        return False
    x, y, z = px - index.centre[0], py - index.centre[1], pz - index.centre[2]
    if x * x + y * y + z * z < index.inner * index.inner:
        return True
    cell = cell_of(x, y, z, index.resolution)
    for place in range(index.cell_start[cell], index.cell_start[cell + 1]):
        face = np.uint64(index.cell_faces[place])
        if (
            planes[face, 0] * x + planes[face, 1] * y + planes[face, 2] * z > 1.0
            and planes[face, 3] * x + planes[face, 4] * y + planes[face, 5] * z > 1.0
            and planes[face, 6] * x + planes[face, 7] * y + planes[face, 8] * z > 1.0
        ):
            below = planes[face, 12] - (
                planes[face, 9] * x + planes[face, 10] * y + planes[face, 11] * z
            )
            if below > 1.0:
                return True
            if below < -1.0:
                return False
            return _height(px, py, pz, index, index.cell_faces[place], terms) >= 0.0
    return _is_inside_exactly(px, py, pz, index, cell, terms)


@leaf_kernel
def _is_inside_exactly(
    px: float, py: float, pz: float, index: LevelIndex, cell: int, terms: FloatArray
) -> bool:
    x, y, z = px - index.centre[0], py - index.centre[1], pz - index.centre[2]
    if x * x + y * y + z * z > (NEAR / index.tree.scale) ** 2:
        # the signs of the cones do not matter if the heights of all possible faces agree
        below = above = 0
        for place in range(index.cell_start[cell], index.cell_start[cell + 1]):
            face = index.cell_faces[place]
            if _may_be_in_cone(x, y, z, index, face):
                if _height(px, py, pz, index, face, terms) >= 0.0:
                    below += 1
                else:
                    above += 1
        if above == 0 and below > 0:
            return True
        if below == 0 and above > 0:
            return False
    for place in range(index.cell_start[cell], index.cell_start[cell + 1]):
        face = index.cell_faces[place]
        if _in_cone(px, py, pz, index, face, terms):
            return _height(px, py, pz, index, face, terms) >= 0.0
    # rounding has moved the direction out of the cell: the point is very near the centre
    for face in range(len(index.faces)):
        if _in_cone(px, py, pz, index, face, terms):
            return _height(px, py, pz, index, face, terms) >= 0.0
    return False


@leaf_kernel
def _may_be_in_cone(x: float, y: float, z: float, index: LevelIndex, face: int) -> bool:
    """Whether a point relative to the centre may be in the cone of a face, within rounding."""
    planes = index.planes
    return (
        planes[face, 0] * x + planes[face, 1] * y + planes[face, 2] * z >= -1.0
        and planes[face, 3] * x + planes[face, 4] * y + planes[face, 5] * z >= -1.0
        and planes[face, 6] * x + planes[face, 7] * y + planes[face, 8] * z >= -1.0
    )


@leaf_kernel
def _in_cone(
    px: float, py: float, pz: float, index: LevelIndex, face: int, terms: FloatArray
) -> bool:
    """Whether a point is in the closed cone of a face. Every point is in one at least."""
    vertices, centre = index.vertices, index.centre
    for at in range(3):
        one, two = index.faces[face, at], index.faces[face, (at + 1) % 3]
        side = orientation(
            vertices[one, 0],
            vertices[one, 1],
            vertices[one, 2],
            vertices[two, 0],
            vertices[two, 1],
            vertices[two, 2],
            px,
            py,
            pz,
            centre[0],
            centre[1],
            centre[2],
            terms,
        )
        if side < 0.0:
            return False
    return True


@leaf_kernel
def _height(
    px: float, py: float, pz: float, index: LevelIndex, face: int, terms: FloatArray
) -> float:
    """Return a positive number below the plane of a face, 0 on it, a negative one above."""
    vertices = index.vertices
    one, two, three = index.faces[face, 0], index.faces[face, 1], index.faces[face, 2]
    return orientation(
        vertices[one, 0],
        vertices[one, 1],
        vertices[one, 2],
        vertices[two, 0],
        vertices[two, 1],
        vertices[two, 2],
        vertices[three, 0],
        vertices[three, 1],
        vertices[three, 2],
        px,
        py,
        pz,
        terms,
    )
