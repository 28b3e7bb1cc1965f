"""Prediction of a split from the level before it, and the star test of the new faces.

The ring of the parent gives the plane that both vertices nearly lie in. It also gives the likely
size of the differences, and a first guess of the positions. Writer and reader both replay the
history, and compute predictions alike: in integers and in float64 operations of a fixed order,
which ``docs/history-format.md`` specifies.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.history.bit_codes import Contexts, doublings_beyond
from gamutcore.history.rings import DEGREE, NEIGHBOUR, Cut, Replay, copy_ring
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "ADDED",
    "CLASSES",
    "KEPT",
    "KINDS",
    "PARENT",
    "SHIFTED",
    "Frame",
    "difference_contexts",
    "find_frame",
    "first_contexts",
    "plane_height",
    "star_sees_centre",
]

LARGEST_CLASS = 31
CLASSES = LARGEST_CLASS + 1
"""A length class is the exponent of the power of two that a mean is below, up to 2³¹ steps."""

KEPT = 0
"""Context of the number of faces that the parent keeps."""

PARENT, ADDED, SHIFTED = 1, 3, 5
"""Differences of the parent, the new slot and a neighbour that moves: the kind of the differences
along the plane of the ring. The next kind has those off the plane."""

KINDS = 7
"""Kinds of numbers. Each has a context for every length class."""


class Frame(NamedTuple):
    """Prediction of a split. Lengths are in steps, relative to the parent before the split.

    Attributes
    ----------
    u, v, w : int
        Axes; w is the axis closest to the normal of the ring.
    slope_u, slope_v : float
        Rise in w per step in u and v of the plane through the parent, across that normal.
    ahead_u, ahead_v : int
        Expected position of the parent after the split.
    size, height : int
        Length classes of the neighbours' distances, and of their distances from the plane.
    """

    u: int
    v: int
    w: int
    slope_u: float
    slope_v: float
    ahead_u: int
    ahead_v: int
    size: int
    height: int


@inlined_kernel
def find_frame(replay: Replay, cut: Cut) -> Frame:
    """Return the prediction of a split from the level before it."""
    position, ring = replay.position, replay.ring
    slot, degree, kept = cut.parent, cut.degree, cut.kept
    cx, cy, cz = int(position[slot, 0]), int(position[slot, 1]), int(position[slot, 2])
    near_x, near_y, near_z, far_x, far_y, far_z = 0, 0, 0, 0, 0, 0
    normal_x, normal_y, normal_z = 0.0, 0.0, 0.0
    distance = 0
    left = ring[0, NEIGHBOUR]
    x = int(position[left, 0]) - cx
    y = int(position[left, 1]) - cy
    z = int(position[left, 2]) - cz
    for index in range(degree):
        neighbour = ring[index + 1, NEIGHBOUR] if index + 1 < degree else left
        px, py, pz = x, y, z
        x = int(position[neighbour, 0]) - cx
        y = int(position[neighbour, 1]) - cy
        z = int(position[neighbour, 2]) - cz
        distance += abs(px) + abs(py) + abs(pz)
        if index <= kept:
            near_x, near_y, near_z = near_x + px, near_y + py, near_z + pz
        if index >= kept or index == 0:
            far_x, far_y, far_z = far_x + px, far_y + py, far_z + pz
        ax, ay, az = float(px), float(py), float(pz)
        bx, by, bz = float(x), float(y), float(z)
        normal_x += ay * bz - az * by
        normal_y += az * bx - ax * bz
        normal_z += ax * by - ay * bx

    normal = (normal_x, normal_y, normal_z)
    w = 0
    if abs(normal[1]) > abs(normal[0]):
        w = 1
    if abs(normal[2]) > abs(normal[w]):
        w = 2
    u, v = (w + 1) % 3, (w + 2) % 3
    slope_u, slope_v = 0.0, 0.0
    if normal[w] != 0.0:
        slope_u, slope_v = -normal[u] / normal[w], -normal[v] / normal[w]

    centre = (cx, cy, cz)
    off = 0.0
    for index in range(degree):
        neighbour = ring[index, NEIGHBOUR]
        du = float(position[neighbour, u] - centre[u])
        dv = float(position[neighbour, v] - centre[v])
        dw = float(position[neighbour, w] - centre[w])
        off += abs(dw - (slope_u * du + slope_v * dv))

    near, far = (near_x, near_y, near_z), (far_x, far_y, far_z)
    near_count, far_count = kept + 1, degree - kept + 1
    return Frame(
        u,
        v,
        w,
        slope_u,
        slope_v,
        _expected_offset(near[u], near_count, far[u], far_count),
        _expected_offset(near[v], near_count, far[v], far_count),
        min(doublings_beyond(distance, degree), LARGEST_CLASS),
        min(doublings_beyond(math.floor(off), degree), LARGEST_CLASS),
    )


@inlined_kernel
def _expected_offset(near: int, near_count: int, far: int, far_count: int) -> int:
    """Expected offset of the parent along an axis, from sums over both parts of its ring.

    The parent goes towards the middle of the neighbours that it keeps, and away from the others.
    The factors 0.4 and 0.2 are the best round numbers on real gamuts.
    """
    return math.floor((2.0 * (near / near_count) - far / far_count) / 5.0 + 0.5)


def first_contexts() -> Contexts:
    """Return the contexts at the beginning of a file: a guess for each length class."""
    total = np.tile(2 ** np.arange(CLASSES, dtype=np.int64) // 2, KINDS)
    return Contexts(total, np.ones(KINDS * CLASSES, np.int64))


@inlined_kernel
def difference_contexts(frame: Frame, kind: int) -> tuple[int, int]:
    """Contexts of the differences of a position along the plane and off it."""
    along = frame.height if kind == ADDED else frame.size
    return CLASSES * kind + along, CLASSES * (kind + 1) + frame.height


@inlined_kernel
def plane_height(frame: Frame, along_u: int, along_v: int) -> int:
    """Height of the plane in w, rounded to whole steps, halves upwards."""
    return math.floor(frame.slope_u * along_u + frame.slope_v * along_v + 0.5)


@leaf_kernel
def star_sees_centre(replay: Replay, slot: int, centre: FloatArray) -> bool:
    """Whether the centre, in steps, is on the inner side of all faces around a slot.

    Leaves the ring of the slot in `replay.ring`.
    """
    copy_ring(replay, slot, 0)
    ring, degree = replay.ring, replay.span[slot, DEGREE]
    ax, ay, az = _relative_position(replay, slot, centre)
    x, y, z = _relative_position(replay, int(ring[degree - 1, NEIGHBOUR]), centre)
    valid = True
    for index in range(degree):
        bx, by, bz = x, y, z
        x, y, z = _relative_position(replay, int(ring[index, NEIGHBOUR]), centre)
        valid &= _determinant(ax, ay, az, bx, by, bz, x, y, z) > 0.0
    return valid


@inlined_kernel
def _relative_position(replay: Replay, slot: int, centre: FloatArray) -> tuple[float, float, float]:
    """Position of a slot relative to the centre."""
    x, y, z = replay.position[slot, 0], replay.position[slot, 1], replay.position[slot, 2]
    return x - centre[0], y - centre[1], z - centre[2]


@inlined_kernel
def _determinant(
    ax: float, ay: float, az: float, bx: float, by: float, bz: float, x: float, y: float, z: float
) -> float:
    """det(a, b, x).

    Writers keep the determinant so far above zero (`gamutcore.star_shape`) that its sign does not
    depend on the order of the operations.
    """
    return x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)
