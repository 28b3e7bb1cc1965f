"""A level while a history is written or read: its connectivity, and what a split can be told from.

Positions are whole numbers here, in steps of the grid. A split needs to be told only what cannot be
known from the level before it: the ring of the parent (its neighbours) gives the plane that both
vertices nearly lie in, how far they are likely to be from where the parent was, and a first guess
of their places. Writer and reader compute these alike, in integers and in float64 operations of
stated order, so `docs/history-format.md` can repeat them for readers in other languages.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.history.groups import lengthened
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

__all__ = [
    "CLASSES",
    "LARGEST_CLASS",
    "Frame",
    "Replay",
    "copy_ring",
    "frame_of",
    "has_room",
    "replay_for",
    "replay_of",
    "ring_of",
    "sees_centre_after_split",
    "split_slot",
    "star_sees_centre",
    "third",
    "with_room",
]

SMALLEST_ROOM = 8
"""Entries that a ring has room for at the beginning; most rings never have more."""

LARGEST_CLASS = 31
CLASSES = LARGEST_CLASS + 1
"""Lengths are told apart by the power of two that they are below, up to 2³¹ steps."""


class Replay(NamedTuple):
    """A level in arrays that have room for finer ones.

    Its connectivity is the ring of each slot: the faces around it, counter-clockwise, each as its
    corner at the slot and the slot that follows in it. Everything that a split changes is then in a
    few places that do not depend on each other, which takes half the time of walking through a
    corner table (docs/decisions/compact-histories.md).

    Attributes
    ----------
    position : (V, 3) int32
        In steps of the grid.
    span : (V, 3) int32
        Where the ring of a slot begins in `entries`, how long it is, and how much room there is.
    entries : (n, 2) int32
        Corner and following slot.
    filled : (1,) int64
        How many entries are taken, by rings or by what they have outgrown.
    """

    position: IndexArray
    span: IndexArray
    entries: IndexArray
    filled: LongArray


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


def replay_of(positions: IndexArray, faces: IndexArray, vertices: int = 4) -> Replay:
    """Return the coarsest level, ready to be refined.

    Parameters
    ----------
    positions : (4, 3) int32
        In steps.
    faces : (4, 3) int32
        A closed, oriented tetrahedron.
    vertices : int, optional
        That there is to be room for.

    Returns
    -------
    Replay
    """
    replay = Replay(
        np.empty((vertices, 3), np.int32),
        np.empty((vertices, 3), np.int32),
        np.empty((_entries_for(vertices), 2), np.int32),
        np.zeros(1, np.int64),
    )
    replay.position[:4] = positions
    for slot in range(4):
        corners = np.flatnonzero(faces.ravel() == slot)
        following = {int(faces[c // 3, (c + 1) % 3]): int(c) for c in corners}
        preceding = {int(c): int(faces[c // 3, (c + 2) % 3]) for c in corners}
        corner = int(corners[0])
        for index in range(3):
            neighbour = int(faces[corner // 3, (corner + 1) % 3])
            replay.entries[SMALLEST_ROOM * slot + index] = corner, neighbour
            corner = following[preceding[corner]]
        replay.span[slot] = SMALLEST_ROOM * slot, 3, SMALLEST_ROOM
    replay.filled[0] = 4 * SMALLEST_ROOM
    return replay


def replay_for(replay: Replay, vertices: int) -> Replay:
    """Return the same level with room for so many vertices and for rings of the usual length."""
    return Replay(
        lengthened(replay.position, vertices),
        lengthened(replay.span, vertices),
        lengthened(replay.entries, max(_entries_for(vertices), len(replay.entries))),
        replay.filled,
    )


def _entries_for(vertices: int) -> int:
    return SMALLEST_ROOM * vertices + 64


@inlined_kernel
def ring_of(replay: Replay, slot: int) -> tuple[int, int]:
    """Return the length of a slot's ring, and where the face with the smallest number is in it."""
    begin, degree = replay.span[slot, 0], replay.span[slot, 1]
    lowest, smallest = 0, replay.entries[begin, 0]
    for index in range(1, degree):
        corner = replay.entries[begin + index, 0]
        if corner < smallest:
            lowest, smallest = index, corner
    return degree, lowest


@inlined_kernel
def copy_ring(replay: Replay, slot: int, start: int, ring: IndexArray) -> None:
    """Copy a slot's ring, beginning with its entry number `start`.

    Parameters
    ----------
    replay : Replay
    slot, start : int
    ring : (≥ degree, 2) int32
        Receives the entries.
    """
    begin, degree = replay.span[slot, 0], replay.span[slot, 1]
    index = start
    for copied in range(degree):
        ring[copied, 0] = replay.entries[begin + index, 0]
        ring[copied, 1] = replay.entries[begin + index, 1]
        index = index + 1 if index + 1 < degree else 0


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
def has_room(replay: Replay, ring: IndexArray, degree: int, kept: int) -> bool:
    """Whether `split_slot` finds room for all rings that may have to go elsewhere."""
    left, right = ring[0, 1], ring[kept, 1]
    needed = 4 * (degree + 2) + 2 * (replay.span[left, 1] + replay.span[right, 1] + 2)
    return bool(replay.filled[0] + needed + 4 * SMALLEST_ROOM <= len(replay.entries))


@kernel
def with_room(replay: Replay, ring: IndexArray, degree: int, kept: int) -> Replay:
    """Return the same level with room for a split."""
    left, right = ring[0, 1], ring[kept, 1]
    needed = 4 * (degree + 2) + 2 * (replay.span[left, 1] + replay.span[right, 1] + 2)
    entries = np.empty((2 * (replay.filled[0] + needed + 4 * SMALLEST_ROOM), 2), np.int32)
    for index in range(replay.filled[0]):
        entries[index, 0] = replay.entries[index, 0]
        entries[index, 1] = replay.entries[index, 1]
    return Replay(replay.position, replay.span, entries, replay.filled)


@inlined_kernel
def split_slot(
    replay: Replay, parent: int, slot: int, ring: IndexArray, degree: int, kept: int
) -> int:
    """Split a slot: give part of its faces to a new one, and put two new faces between them.

    The new faces are (parent, slot, left) and (slot, parent, right).

    Parameters
    ----------
    replay : Replay
        A level with `slot` vertices and room for one more, whose position is not touched.
    parent, slot : int
    ring, degree, kept
        As for `frame_of`; 1 ≤ kept < degree.

    Returns
    -------
    int
        How many entries were looked at.
    """
    span, entries = replay.span, replay.entries
    left, right = ring[0, 1], ring[kept, 1]
    one, two = 6 * slot - 12, 6 * slot - 9
    visited: int = degree + span[left, 1] + span[right, 1]
    for index in range(kept + 1, degree):
        neighbour = ring[index, 1]
        entries[_entry(replay, neighbour, parent), 1] = slot
        visited += span[neighbour, 1]
    at = _inserted(replay, left, parent)
    entries[at, 0], entries[at, 1], entries[at + 1, 1] = one + 2, parent, slot
    at = _inserted(replay, right, parent)
    entries[at, 0], entries[at, 1] = two + 2, slot

    at = _room_for(replay, parent, kept + 2)
    for index in range(kept):
        entries[at + index, 0], entries[at + index, 1] = ring[index, 0], ring[index, 1]
    at += kept
    entries[at, 0], entries[at, 1] = two + 1, right
    entries[at + 1, 0], entries[at + 1, 1] = one, slot
    span[slot, 1], span[slot, 2] = 0, 0
    at = _room_for(replay, slot, degree - kept + 2)
    for index in range(kept, degree):
        entries[at, 0], entries[at, 1] = ring[index, 0], ring[index, 1]
        at += 1
    entries[at, 0], entries[at, 1] = one + 1, left
    entries[at + 1, 0], entries[at + 1, 1] = two, parent
    return visited


@inlined_kernel
def _entry(replay: Replay, slot: int, neighbour: int) -> int:
    """Where the ring of a slot names a neighbour."""
    entry: int = replay.span[slot, 0]
    while replay.entries[entry, 1] != neighbour:
        entry += 1
    return entry


@inlined_kernel
def _room_for(replay: Replay, slot: int, degree: int) -> int:
    """Give a ring its new length, and where it does not fit a new place; returns the place."""
    span = replay.span
    span[slot, 1] = degree
    if degree > span[slot, 2]:
        room = SMALLEST_ROOM
        while room < degree:
            room *= 2
        span[slot, 0], span[slot, 2] = replay.filled[0], room
        replay.filled[0] += room
    begin: int = span[slot, 0]
    return begin


@leaf_kernel
def _inserted(replay: Replay, slot: int, neighbour: int) -> int:
    """Open a gap before the entry of a neighbour in a ring; returns the gap's place."""
    entries = replay.entries
    begin: int = replay.span[slot, 0]
    degree: int = replay.span[slot, 1]
    gap = _entry(replay, slot, neighbour) - begin
    to = _room_for(replay, slot, degree + 1)
    if to != begin:
        for index in range(gap):
            entries[to + index, 0] = entries[begin + index, 0]
            entries[to + index, 1] = entries[begin + index, 1]
    for index in range(degree - 1, gap - 1, -1):
        entries[to + index + 1, 0] = entries[begin + index, 0]
        entries[to + index + 1, 1] = entries[begin + index, 1]
    return to + gap


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
    ax, ay, az = _seen_from(replay, slot, centre, step)
    x, y, z = _seen_from(replay, replay.entries[begin + degree - 1, 1], centre, step)
    valid = True
    for index in range(degree):
        bx, by, bz = x, y, z
        x, y, z = _seen_from(replay, replay.entries[begin + index, 1], centre, step)
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
