"""Whether faces see a centre from inside: the property that all levels of a gamut share.

A face (p0, p1, p2), relative to the centre, sees it from inside when det(p0, p1, p2) > 0. If all
faces of a closed mesh of genus 0 do, their radial projection is a triangulation of the sphere. The
mesh then cannot intersect itself, and every ray from the centre meets it exactly once.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["MINIMUM_DETERMINANT", "faces_not_seeing_centre", "sees_centre"]

MINIMUM_DETERMINANT = 2.0**-44
"""Smallest det(p0, p1, p2) ÷ (|p0| |p1| |p2|) that counts as positive.

The relative error of a determinant in float64 is a few times 2⁻⁵³ of the product of the lengths.
With this margin, the sign is the same in any order of evaluation."""


@leaf_kernel
def sees_centre(
    ax: float, ay: float, az: float, bx: float, by: float, bz: float, x: float, y: float, z: float
) -> bool:
    """Whether the face (a, b, x), relative to the centre, sees it from inside beyond rounding.

    Corners are in counter-clockwise order. The answer for NaN is False.
    """
    determinant = x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)
    lengths = (
        (x * x + y * y + z * z) * (ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz)
    )
    return (
        determinant > 0.0
        and determinant * determinant > MINIMUM_DETERMINANT * MINIMUM_DETERMINANT * lengths
    )


@kernel
def faces_not_seeing_centre(position: FloatArray, faces: IndexArray) -> IndexArray:
    """Return the faces (m,) whose determinant about the centre is not positive beyond rounding.

    `position` (V, 3) is relative to the centre.
    """
    found = np.empty(len(faces), np.int32)
    count = 0
    for face in range(len(faces)):
        one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
        ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
        bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
        x, y, z = position[three, 0], position[three, 1], position[three, 2]
        if not sees_centre(ax, ay, az, bx, by, bz, x, y, z):
            found[count] = face
            count += 1
    return found[:count].copy()
