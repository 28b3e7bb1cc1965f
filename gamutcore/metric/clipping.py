"""Cutting a face along the cones of another surface's faces, from a centre.

What a cone's three planes leave outside goes on to the neighbour across the plane that cut it off.
Every split writes the same corners to both sides, so the pieces always make up the whole face,
whatever rounding does to them. Corners are pairs (u, v): the point a + u U + v V of the face.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import inlined_kernel, leaf_kernel
from gamutcore.metric.cones import Cones

__all__ = ["Clipping", "begin", "clipping", "next_piece"]

PARTS = 48
"""Parts of a face that can wait at a time."""

CORNERS = 24
"""Corners that a part can have."""


TRYING_ALL = 2**30
"""In place of the number of moves: the cones of all faces are tried, one after the other."""


class Clipping(NamedTuple):
    """Work space for one face at a time.

    Attributes
    ----------
    frame : (3, 3) float64
        a, U and V of the face.
    part : (rows, corners, 2) float64
        Parts that wait on a stack, and below its top the one at work.
    corners, face, came, moves : (rows,) int32
        Corners of a part; the face whose cone is cut off next; the face that passed the part on to
        that one, or −1; how often it was passed on whole.
    value : (corners,) float64
        Products of the corners with a plane.
    piece : (corners, 3) float64
        u, v and N · p − 1 of the corners of the last piece.
    triangle : (3, 4) float64
        For the caller: positions and N · p − 1 of a part of it.
    """

    frame: FloatArray
    part: FloatArray
    corners: IndexArray
    face: IndexArray
    came: IndexArray
    moves: IndexArray
    value: FloatArray
    piece: FloatArray
    triangle: FloatArray


def clipping() -> Clipping:
    """Return work space for one face at a time."""
    rows = PARTS + 4
    return Clipping(
        frame=np.empty((3, 3)),
        part=np.empty((rows, CORNERS, 2)),
        corners=np.empty(rows, np.int32),
        face=np.empty(rows, np.int32),
        came=np.empty(rows, np.int32),
        moves=np.empty(rows, np.int32),
        value=np.empty(CORNERS),
        piece=np.empty((CORNERS, 3)),
        triangle=np.empty((3, 4)),
    )


@inlined_kernel
def begin(work: Clipping, position: FloatArray, one: int, two: int, three: int, face: int) -> int:
    """Put a face on the stack, to be cut from the cone of `face` on; returns the stack's height."""
    for axis in range(3):
        work.frame[0, axis] = position[one, axis]
        work.frame[1, axis] = position[two, axis] - position[one, axis]
        work.frame[2, axis] = position[three, axis] - position[one, axis]
    work.part[0, 0, 0], work.part[0, 0, 1] = 0.0, 0.0
    work.part[0, 1, 0], work.part[0, 1, 1] = 1.0, 0.0
    work.part[0, 2, 0], work.part[0, 2, 1] = 0.0, 1.0
    work.corners[0], work.face[0], work.came[0], work.moves[0] = 3, face, -1, 0
    return 1


@leaf_kernel
def _copy(part: FloatArray, source: int, first: int, last: int, target: int, start: int) -> None:
    for index in range(first, last):
        part[target, start + index - first, 0] = part[source, index, 0]
        part[target, start + index - first, 1] = part[source, index, 1]


@inlined_kernel
def _split(part: FloatArray, value: FloatArray, row: int, count: int) -> tuple[int, int]:
    """Split a part by the signs of its values: what is outside stays, the inside goes to row + 1.

    Returns the corners of both. No corner is overwritten before it is read, as at most one more is
    written than was read.
    """
    kept, cut = 0, 0
    first_u, first_v = part[row, 0, 0], part[row, 0, 1]
    u, v, here = first_u, first_v, value[0]
    for index in range(count):
        if index < count - 1:
            next_u, next_v = part[row, index + 1, 0], part[row, index + 1, 1]
            there = value[index + 1]
        else:
            next_u, next_v, there = first_u, first_v, value[0]
        if here >= 0.0:
            part[row + 1, kept, 0], part[row + 1, kept, 1] = u, v
            kept += 1
        if here <= 0.0:
            part[row, cut, 0], part[row, cut, 1] = u, v
            cut += 1
        if (here > 0.0 and there < 0.0) or (here < 0.0 and there > 0.0):
            share = here / (here - there)
            u += share * (next_u - u)
            v += share * (next_v - v)
            part[row + 1, kept, 0], part[row + 1, kept, 1] = u, v
            part[row, cut, 0], part[row, cut, 1] = u, v
            kept += 1
            cut += 1
        u, v, here = next_u, next_v, there
    return kept, cut


@inlined_kernel
def next_piece(  # noqa: C901, PLR0912  # the time is in these branches
    work: Clipping, top: int, cones: Cones, reach: float, moves: int
) -> tuple[int, int, int]:
    """Cut off the next piece of the face that was put on the stack.

    Parameters
    ----------
    work : Clipping
    top : int
        Height of the stack.
    cones : Cones
    reach : float
        At least as much as the length of the face's corners.
    moves : int
        `MOVES`; less to try all cones earlier.

    Returns
    -------
    face : int
        The face in whose cone the piece is; −1 when there are no more.
    count : int
        Corners of the piece.
    top : int
        Height of the stack.
    """
    part, value, frame, planes = work.part, work.value, work.frame, cones.planes
    while top > 0:
        base = top - 1
        face, count, moved = work.face[base], work.corners[base], work.moves[base]
        if count > CORNERS - 4:
            # two parts are as good as one with many corners
            half = count // 2
            _copy(part, base, half, count, top, 1)
            _copy(part, base, 0, 1, top, 0)
            work.corners[base], work.corners[top] = half + 1, count - half + 1
            work.face[top], work.came[top], work.moves[top] = face, work.came[base], moved
            top += 1
            continue
        if moved != TRYING_ALL and (moved > moves or top >= PARTS):
            face, moved = 0, TRYING_ALL
        exhaustive = moved == TRYING_ALL
        row, came = base, work.came[base]
        if exhaustive:
            came = -1
            # the part stays on the stack until all cones have been tried
            if face == len(planes):
                top = base
                continue
            work.face[base], work.moves[base] = face + 1, moved
            row = top
            _copy(part, base, 0, count, row, 0)
        tolerance = cones.rounding[face] * reach
        for place in range(3):
            # the other side of the plane that cut the part off: all of it is inside
            if cones.neighbour[face, place] == came:
                continue
            x = planes[face, 3 * place]
            y = planes[face, 3 * place + 1]
            z = planes[face, 3 * place + 2]
            constant = x * frame[0, 0] + y * frame[0, 1] + z * frame[0, 2]
            along_u = x * frame[1, 0] + y * frame[1, 1] + z * frame[1, 2]
            along_v = x * frame[2, 0] + y * frame[2, 1] + z * frame[2, 2]
            lowest, highest = np.inf, -np.inf
            for index in range(count):
                side = constant + along_u * part[row, index, 0] + along_v * part[row, index, 1]
                lowest = min(lowest, side)
                highest = max(highest, side)
                value[index] = side if abs(side) > tolerance else 0.0
            if lowest < -tolerance:
                work.face[row] = cones.neighbour[face, place]
                work.came[row], work.moves[row] = face, moved + 1
                if highest <= tolerance:
                    work.corners[row] = count
                    count = 0
                    row += 1
                    break
                count, work.corners[row] = _split(part, value, row, count)
                row += 1
        top = base + 1 if exhaustive else row
        if count >= 3:
            for waiting in range(base, top):
                if not exhaustive:
                    work.moves[waiting] = 0
            x, y, z = cones.normal[face, 0], cones.normal[face, 1], cones.normal[face, 2]
            constant = x * frame[0, 0] + y * frame[0, 1] + z * frame[0, 2] - 1.0
            along_u = x * frame[1, 0] + y * frame[1, 1] + z * frame[1, 2]
            along_v = x * frame[2, 0] + y * frame[2, 1] + z * frame[2, 2]
            for index in range(count):
                u, v = part[row, index, 0], part[row, index, 1]
                work.piece[index, 0], work.piece[index, 1] = u, v
                work.piece[index, 2] = constant + along_u * u + along_v * v
            return face, count, top
    return -1, 0, 0
