"""Prediction of a split from the level before it, and the star test of the new faces.

Positions are integers in steps of the grid. The ring of the parent gives the plane that both
vertices nearly lie in, the likely size of the differences, and a first guess of the positions.
Writer and reader compute these alike, in integers and in float64 operations of a fixed order.
``docs/history-format.md`` repeats them for readers in other languages.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.history.rings import BEGIN, CORNER, DEGREE, LINKED, NEIGHBOUR, ROOM, Replay
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "CLASSES",
    "LARGEST_CLASS",
    "Frame",
    "find_frame",
    "plane_height",
    "sees_centre_after_split",
    "star_sees_centre",
]

LARGEST_CLASS = 31
CLASSES = LARGEST_CLASS + 1
"""A length class is the power of two that a length is below, up to 2³¹ steps."""


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
def find_frame(replay: Replay, slot: int, ring: IndexArray, degree: int, kept: int) -> Frame:
    """Return the prediction of a split.

    Parameters
    ----------
    replay : Replay
        The level before the split.
    slot : int
        The parent.
    ring : (≥ degree, 2) int32
        Its ring, beginning with the face (parent, left, …).
    degree : int
    kept : int
        How many of the faces the parent keeps, from the first one.

    Returns
    -------
    Frame
    """
    position = replay.position
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
        _length_class(float(distance), degree),
        _length_class(off, degree),
    )


@inlined_kernel
def _expected_offset(near: int, near_count: int, far: int, far_count: int) -> int:
    """Expected offset of the parent along an axis, from sums over both parts of its ring.

    The parent goes towards the middle of the neighbours that it keeps, and away from the others.
    The factors 0.4 and 0.2 are the best round numbers on real gamuts.
    """
    return math.floor((2.0 * (near / near_count) - far / far_count) / 5.0 + 0.5)


@inlined_kernel
def _length_class(total: float, count: int) -> int:
    """Smallest n with total ÷ count < 2ⁿ, at most `LARGEST_CLASS`."""
    limit = float(count)
    length_class = 0
    while length_class < LARGEST_CLASS and not total < limit:
        limit *= 2.0
        length_class += 1
    return length_class


@inlined_kernel
def plane_height(frame: Frame, along_u: int, along_v: int) -> int:
    """Height of the plane in w, rounded to whole steps, halves upwards."""
    return math.floor(frame.slope_u * along_u + frame.slope_v * along_v + 0.5)


@inlined_kernel
def sees_centre_after_split(
    replay: Replay,
    parent: int,
    slot: int,
    ring: IndexArray,
    degree: int,
    kept: int,
    centre: FloatArray,
    step: float,
) -> bool:
    """Whether the centre is on the inner side of all faces around both slots of a split.

    `replay` is the level after the split; `ring`, `degree` and `kept` are as for `split_slot`;
    `centre` is (3,) float64.
    """
    px, py, pz = _relative_position(replay, parent, centre, step)
    kx, ky, kz = _relative_position(replay, slot, centre, step)
    x, y, z = _relative_position(replay, int(ring[0, NEIGHBOUR]), centre, step)
    valid = _determinant(px, py, pz, kx, ky, kz, x, y, z) > 0.0
    for index in range(degree):
        ax, ay, az = x, y, z
        following = ring[index + 1, NEIGHBOUR] if index + 1 < degree else ring[0, NEIGHBOUR]
        x, y, z = _relative_position(replay, int(following), centre, step)
        if index < kept:
            valid &= _determinant(px, py, pz, ax, ay, az, x, y, z) > 0.0
        else:
            valid &= _determinant(kx, ky, kz, ax, ay, az, x, y, z) > 0.0
        if index == kept - 1:
            valid &= _determinant(kx, ky, kz, px, py, pz, x, y, z) > 0.0
    return valid


@leaf_kernel
def star_sees_centre(replay: Replay, slot: int, centre: FloatArray, step: float) -> bool:
    """Whether the centre is on the inner side of all faces around a slot."""
    begin, degree = int(replay.span[slot, BEGIN]), int(replay.span[slot, DEGREE])
    linked = replay.span[slot, ROOM] == LINKED
    corner = begin
    last = replay.links[begin, NEIGHBOUR] if linked else replay.entries[begin + degree - 1, 1]
    ax, ay, az = _relative_position(replay, slot, centre, step)
    x, y, z = _relative_position(replay, int(last), centre, step)
    valid = True
    for index in range(degree):
        bx, by, bz = x, y, z
        if linked:
            corner = int(replay.links[corner, CORNER])
            following = replay.links[corner, NEIGHBOUR]
        else:
            following = replay.entries[begin + index, NEIGHBOUR]
        x, y, z = _relative_position(replay, int(following), centre, step)
        valid &= _determinant(ax, ay, az, bx, by, bz, x, y, z) > 0.0
    return valid


@inlined_kernel
def _relative_position(
    replay: Replay, slot: int, centre: FloatArray, step: float
) -> tuple[float, float, float]:
    """Position of a slot relative to the centre."""
    position = replay.position
    return (
        position[slot, 0] * step - centre[0],
        position[slot, 1] * step - centre[1],
        position[slot, 2] * step - centre[2],
    )


@inlined_kernel
def _determinant(
    ax: float, ay: float, az: float, bx: float, by: float, bz: float, x: float, y: float, z: float
) -> float:
    """det(a, b, x).

    Writers keep the determinant so far above zero (`gamutcore.star_shape`) that its sign does not
    depend on the order of the operations.
    """
    return x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)
