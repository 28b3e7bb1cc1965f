"""Clip a face into pieces by the cones of another surface.

The part of a face outside one of the three planes of a cone passes to the neighbour across that
plane. Every split writes the same corners to both sides, so the pieces always make up the whole
face despite rounding. A corner (u, v) is the point a + u U + v V of the face.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import inlined_kernel, leaf_kernel
from gamutcore.metric.cones import INDEX, Cones

__all__ = ["Clipping", "clipping_workspace", "pop_piece", "push_face"]

PARTS = 48
"""Most parts of a face on the stack."""

CORNERS = 24
"""Most corners of a part."""

ROW = 2 * CORNERS
"""Numbers per part."""

TRY_ALL = 2**30
"""Number of moves that marks a part for trying the cones of all faces in turn."""


class Clipping(NamedTuple):
    """Work space for one face at a time.

    Attributes
    ----------
    frame : (9,) float64
        a, U and V of the face.
    source : (`ROW`,) float64
        u and v of the corners of the part to split; the first corner is repeated at the end.
    part : (rows × `ROW`,) float64
        Stack of parts: u and v of their corners. The current part is above the top.
    corners, face, came, moves : (rows,) int32
        For each part: number of corners; the next face whose cone clips the part; the face before,
        or −1; number of times the whole part passed on.
    value : (corners,) float64
        Products of the corners with a plane.
    piece : (corners, 3) float64
        u, v and N · p − 1 of the corners of the last piece.
    triangle : (3, 4) float64
        For the caller: positions and N · p − 1 of three corners.
    """

    frame: FloatArray
    source: FloatArray
    part: FloatArray
    corners: IndexArray
    face: IndexArray
    came: IndexArray
    moves: IndexArray
    value: FloatArray
    piece: FloatArray
    triangle: FloatArray


def clipping_workspace() -> Clipping:
    """Return work space for one face at a time."""
    rows = PARTS + 4
    return Clipping(
        frame=np.empty(9),
        source=np.empty(ROW),
        part=np.empty(rows * ROW),
        corners=np.empty(rows, np.int32),
        face=np.empty(rows, np.int32),
        came=np.empty(rows, np.int32),
        moves=np.empty(rows, np.int32),
        value=np.empty(CORNERS),
        piece=np.empty((CORNERS, 3)),
        triangle=np.empty((3, 4)),
    )


@inlined_kernel
def push_face(
    work: Clipping, position: FloatArray, one: int, two: int, three: int, face: int
) -> int:
    """Push a face that starts in the cone of `face`; return the height of the stack."""
    frame, part = work.frame, work.part
    for axis in range(3):
        frame[axis] = position[INDEX(one), axis]
        frame[3 + axis] = position[INDEX(two), axis] - position[INDEX(one), axis]
        frame[6 + axis] = position[INDEX(three), axis] - position[INDEX(one), axis]
    part[0], part[1] = 0.0, 0.0
    part[2], part[3] = 1.0, 0.0
    part[4], part[5] = 0.0, 1.0
    work.corners[0], work.face[0], work.came[0], work.moves[0] = 3, face, -1, 0
    return 1


@leaf_kernel
def _copy(part: FloatArray, source: int, first: int, last: int, target: int, start: int) -> None:
    for number in range(2 * (last - first)):
        part[INDEX(ROW * target + 2 * start + number)] = part[
            INDEX(ROW * source + 2 * first + number)
        ]


@inlined_kernel
def _split(
    part: FloatArray, source: FloatArray, value: FloatArray, row: int, count: int
) -> tuple[int, int]:
    """Split a part by the signs of its values; return the number of corners of both parts.

    The outside stays, and the inside goes to row + 1. Every corner is written without a branch; the
    next corner overwrites a corner on the wrong side.
    """
    outside, inside = ROW * row, ROW * (row + 1)
    first_inside, first_outside = inside, outside
    u, v, here = source[0], source[1], value[0]
    source[INDEX(2 * count)], source[INDEX(2 * count + 1)], value[INDEX(count)] = u, v, here
    for index in range(1, count + 1):
        next_u, next_v, there = (
            source[INDEX(2 * index)],
            source[INDEX(2 * index + 1)],
            value[INDEX(index)],
        )
        part[INDEX(inside)], part[INDEX(inside + 1)] = u, v
        inside += 2 if here >= 0.0 else 0
        part[INDEX(outside)], part[INDEX(outside + 1)] = u, v
        outside += 2 if here <= 0.0 else 0
        share = here / (here - there)
        u += share * (next_u - u)
        v += share * (next_v - v)
        part[INDEX(inside)], part[INDEX(inside + 1)] = u, v
        part[INDEX(outside)], part[INDEX(outside + 1)] = u, v
        crossed = 2 if ((here > 0.0) & (there < 0.0)) | ((here < 0.0) & (there > 0.0)) else 0
        inside += crossed
        outside += crossed
        u, v, here = next_u, next_v, there
    return (inside - first_inside) // 2, (outside - first_outside) // 2


@inlined_kernel
def pop_piece(  # noqa: C901, PLR0912  # the time is in these branches
    work: Clipping, top: int, cones: Cones, reach: float, moves: int
) -> tuple[int, int, int]:
    """Pop the next piece; return the face of its cone, its corners' number, and the stack's height.

    The face is −1 after the last piece. No corner of the clipped face may be farther from the
    origin than `reach`. A number of `moves` below `MOVES` tries all cones earlier.
    """
    part, value, frame, planes = work.part, work.value, work.frame, cones.planes
    source, neighbour = work.source, cones.neighbour
    while top > 0:
        base = top - 1
        face, count, moved = (
            work.face[INDEX(base)],
            work.corners[INDEX(base)],
            work.moves[INDEX(base)],
        )
        if count > CORNERS - 4:
            # two parts are equivalent to one with too many corners
            half = count // 2
            _copy(part, base, half, count, top, 1)
            _copy(part, base, 0, 1, top, 0)
            work.corners[base], work.corners[top] = half + 1, count - half + 1
            work.face[top], work.came[top], work.moves[top] = face, work.came[base], moved
            top += 1
            continue
        if moved != TRY_ALL and (moved > moves or top >= PARTS):
            face, moved = 0, TRY_ALL
        exhaustive = moved == TRY_ALL
        row, came = base, work.came[INDEX(base)]
        if exhaustive:
            came = -1
            # the part stays on the stack until all cones are tried
            if face == len(planes):
                top = base
                continue
            work.face[base], work.moves[base] = face + 1, moved
            row = top
            _copy(part, base, 0, count, row, 0)
        tolerance = cones.rounding[INDEX(face)] * reach
        for side in range(3):
            # this plane has clipped the part on its other side
            if neighbour[INDEX(face), side] == came:
                continue
            x = planes[INDEX(face), 3 * side]
            y = planes[INDEX(face), 3 * side + 1]
            z = planes[INDEX(face), 3 * side + 2]
            constant = x * frame[0] + y * frame[1] + z * frame[2]
            along_u = x * frame[3] + y * frame[4] + z * frame[5]
            along_v = x * frame[6] + y * frame[7] + z * frame[8]
            lowest, highest = np.inf, -np.inf
            start = ROW * row
            for index in range(count):
                u, v = part[INDEX(start + 2 * index)], part[INDEX(start + 2 * index + 1)]
                height = constant + along_u * u + along_v * v
                lowest = min(lowest, height)
                highest = max(highest, height)
                value[INDEX(index)] = height if abs(height) > tolerance else 0.0
                source[INDEX(2 * index)], source[INDEX(2 * index + 1)] = u, v
            if lowest < -tolerance:
                work.face[INDEX(row)] = neighbour[INDEX(face), side]
                work.came[INDEX(row)], work.moves[INDEX(row)] = face, moved + 1
                if highest <= tolerance:
                    work.corners[INDEX(row)] = count
                    count = 0
                    row += 1
                    break
                count, work.corners[INDEX(row)] = _split(part, source, value, row, count)
                row += 1
        top = base + 1 if exhaustive else row
        if count >= 3:
            for waiting in range(base, top):
                if not exhaustive:
                    work.moves[INDEX(waiting)] = 0
            normal, piece = cones.normal, work.piece
            x, y, z = normal[INDEX(face), 0], normal[INDEX(face), 1], normal[INDEX(face), 2]
            constant = x * frame[0] + y * frame[1] + z * frame[2] - 1.0
            along_u = x * frame[3] + y * frame[4] + z * frame[5]
            along_v = x * frame[6] + y * frame[7] + z * frame[8]
            start = ROW * row
            for index in range(count):
                u, v = part[INDEX(start + 2 * index)], part[INDEX(start + 2 * index + 1)]
                piece[INDEX(index), 0], piece[INDEX(index), 1] = u, v
                piece[INDEX(index), 2] = constant + along_u * u + along_v * v
            return face, count, top
    return -1, 0, 0
