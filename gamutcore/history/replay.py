"""What a split can be told from, and whether a level sees the centre while a history is read.

Positions are whole numbers here, in steps of the grid. A split needs to be told only what cannot be
known from the level before it: the ring of the parent (its neighbours) gives the plane that both
vertices nearly lie in, how far they are likely to be from where the parent was, and a first guess
of their places. Writer and reader compute these alike, in integers and in float64 operations of
stated order, so `docs/history-format.md` can repeat them for readers in other languages.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.history.rings import LINKED, Replay
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "CLASSES",
    "LARGEST_CLASS",
    "Frame",
    "frame_of",
    "sees_centre_after_split",
    "star_sees_centre",
    "third",
]

LARGEST_CLASS = 31
CLASSES = LARGEST_CLASS + 1
"""Lengths are told apart by the power of two that they are below, up to 2³¹ steps."""


class Frame(NamedTuple):
    """What the ring of a slot says about its split. Lengths are in steps, relative to the slot.

    Attributes
    ----------
    u, v, w : int
        The axes; w is the one that the ring's normal is closest to.
    slope_u, slope_v : float
        The plane through the slot across that normal rises in w by so much per step in u and v.
    ahead_u, ahead_v : int
        Where the parent is expected after the split.
    size, height : int
        Length classes of the ring: of its neighbours' distances, and of how far they are off the
        plane.
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
def frame_of(replay: Replay, slot: int, ring: IndexArray, degree: int, kept: int) -> Frame:
    """Return what the ring says about a split.

    Parameters
    ----------
    replay : Replay
        The level before the split.
    slot : int
        The parent.
    ring : (≥ degree, 2) int32
        Its ring, beginning with the face (parent, left, ...).
    degree : int
    kept : int
        How many of the faces the parent keeps, from the first one on.

    Returns
    -------
    Frame
    """
    position = replay.position
    cx, cy, cz = position[slot, 0], position[slot, 1], position[slot, 2]
    near_x, near_y, near_z, far_x, far_y, far_z = 0, 0, 0, 0, 0, 0
    normal_x, normal_y, normal_z = 0.0, 0.0, 0.0
    distance = 0
    left = ring[0, 1]
    x, y, z = position[left, 0] - cx, position[left, 1] - cy, position[left, 2] - cz
    for index in range(degree):
        neighbour = ring[index + 1, 1] if index + 1 < degree else left
        px, py, pz = x, y, z
        x, y, z = (
            position[neighbour, 0] - cx,
            position[neighbour, 1] - cy,
            position[neighbour, 2] - cz,
        )
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

    off = 0.0
    for index in range(degree):
        neighbour = ring[index, 1]
        du = float(position[neighbour, u] - position[slot, u])
        dv = float(position[neighbour, v] - position[slot, v])
        dw = float(position[neighbour, w] - position[slot, w])
        off += abs(dw - (slope_u * du + slope_v * dv))

    near, far = (near_x, near_y, near_z), (far_x, far_y, far_z)
    return Frame(
        u,
        v,
        w,
        slope_u,
        slope_v,
        _ahead(near[u], kept + 1, far[u], degree - kept + 1),
        _ahead(near[v], kept + 1, far[v], degree - kept + 1),
        _length_class(float(distance), degree),
        _length_class(off, degree),
    )


@inlined_kernel
def _ahead(near: int, near_count: int, far: int, far_count: int) -> int:
    """Expected place of the parent along an axis, from sums over both parts of its ring.

    0.4 and 0.2 are the best of round numbers on real gamuts: the parent goes towards the middle of
    the neighbours that it keeps, and away from those that it loses.
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
def third(frame: Frame, along_u: int, along_v: int) -> int:
    """Rise of the plane in w, rounded to a whole number of steps, halves upwards."""
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
    """Whether all faces around both slots of a split see the centre from inside.

    Parameters
    ----------
    replay : Replay
        The level after the split.
    parent, slot, ring, degree, kept
        As for `split_slot`.
    centre : (3,) float64
    step : float
    """
    px, py, pz = _seen_from(replay, parent, centre, step)
    kx, ky, kz = _seen_from(replay, slot, centre, step)
    x, y, z = _seen_from(replay, ring[0, 1], centre, step)
    valid = _determinant(px, py, pz, kx, ky, kz, x, y, z) > 0.0
    for index in range(degree):
        ax, ay, az = x, y, z
        following = ring[index + 1, 1] if index + 1 < degree else ring[0, 1]
        x, y, z = _seen_from(replay, following, centre, step)
        if index < kept:
            valid &= _determinant(px, py, pz, ax, ay, az, x, y, z) > 0.0
        else:
            valid &= _determinant(kx, ky, kz, ax, ay, az, x, y, z) > 0.0
        if index == kept - 1:
            valid &= _determinant(kx, ky, kz, px, py, pz, x, y, z) > 0.0
    return valid


@leaf_kernel
def star_sees_centre(replay: Replay, slot: int, centre: FloatArray, step: float) -> bool:
    """Whether all faces at a slot see the centre from inside."""
    begin, degree = replay.span[slot, 0], replay.span[slot, 1]
    linked = replay.span[slot, 2] == LINKED
    corner = begin
    last = replay.links[begin, 1] if linked else replay.entries[begin + degree - 1, 1]
    ax, ay, az = _seen_from(replay, slot, centre, step)
    x, y, z = _seen_from(replay, last, centre, step)
    valid = True
    for index in range(degree):
        bx, by, bz = x, y, z
        if linked:
            corner = replay.links[corner, 0]
            following = replay.links[corner, 1]
        else:
            following = replay.entries[begin + index, 1]
        x, y, z = _seen_from(replay, following, centre, step)
        valid &= _determinant(ax, ay, az, bx, by, bz, x, y, z) > 0.0
    return valid


@inlined_kernel
def _seen_from(
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

    Writers keep it so far above zero (`gamutcore.star_shape`) that its sign does not depend on the
    order of the operations.
    """
    return x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)
