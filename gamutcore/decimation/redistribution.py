"""Which samples are in which face: found at first, and kept up to date as faces change.

A collapse, or a move of a vertex, exchanges samples only among the faces around it. Most stay in
the face that they were in, so each of them is compared with that one first.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.samples import LARGEST_SHARE, SHARE_OUTSIDE, Deviation
from gamutcore.decimation.star import Surface
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = ["hand_over_samples", "locate_samples", "redistribute_samples", "thin_samples"]


@leaf_kernel
def locate_samples(deviation: Deviation, surface: Surface) -> None:
    """Put samples that are in no faces into those of a surface.

    Parameters
    ----------
    deviation : Deviation
        As `take_samples` left it, or `deviation_on` that, with room for all faces.
    surface : Surface
    """
    count, half = deviation.counts[2], deviation.counts[6]
    deviation.place[:] = 0
    at = 0
    for edge in range(surface.corner_facing.size):
        at = surface.corner_facing[edge]
        if at >= 0:
            break
    for sample in range(count):
        # they come in the order of memory, so the next one is near
        at = _corner_below(
            surface, deviation.x[sample], deviation.y[sample], deviation.z[sample], at
        )
        deviation.pair[sample] = at
        deviation.place[at // 3] += 1
    top = half
    for face in range(deviation.begin.size):
        deviation.begin[face] = top
        top += deviation.place[face]
        deviation.place[face] = deviation.begin[face]
        deviation.end[face] = top
    _move_to_places(deviation, 0, count, 0)
    deviation.counts[3], deviation.counts[4] = top, half
    for face in range(deviation.begin.size):
        if deviation.end[face] > deviation.begin[face]:
            _sum_errors(deviation, surface, 3 * face)


@leaf_kernel
def _corner_below(surface: Surface, x: float, y: float, z: float, begin: int) -> int:
    """A corner of the face whose cone a point is in, found by walking over the faces."""
    position, vertex, at = surface.position, surface.vertex, begin
    for _ in range(surface.corner_facing.size):
        zero, one, two = vertex[at], vertex[following(at)], vertex[preceding(at)]
        facing = _side(position, one, two, x, y, z)
        second = _side(position, two, zero, x, y, z)
        third = _side(position, zero, one, x, y, z)
        if min(facing, second, third) >= 0.0:
            return at
        if facing <= second and facing <= third:
            at = surface.opposite[at]
        elif second <= third:
            at = surface.opposite[following(at)]
        else:
            at = surface.opposite[preceding(at)]
    # a walk can go round for ever where faces are slivers (Devillers, Pion & Teillaud 2002)
    depth = -np.inf
    for edge in range(surface.corner_facing.size):
        corner = surface.corner_facing[edge]
        if corner < 0:
            continue
        for side in range(2):
            tried = corner if side == 0 else surface.opposite[corner]
            zero, one, two = vertex[tried], vertex[following(tried)], vertex[preceding(tried)]
            least = min(
                _side(position, one, two, x, y, z),
                _side(position, two, zero, x, y, z),
                _side(position, zero, one, x, y, z),
            )
            if least > depth:
                at, depth = tried, least
    return at


@leaf_kernel
def thin_samples(deviation: Deviation, surface: Surface, most: int) -> bool:
    """Let about half of the samples go, or more, if there are many.

    Their shares are lined up face by face, and those samples stay in whose share a mark falls, all
    marks being equally far apart; a sample stands for the marks in its share then (systematic
    resampling, Kitagawa 1996): small shares grow to the size of the others.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
    most : int
        Samples that need no thinning.

    Returns
    -------
    bool
        Whether there were more, and all errors have changed.
    """
    if deviation.counts[2] <= most:
        return False
    weight = deviation.weight
    total = 0.0
    for face in range(deviation.begin.size):
        for sample in range(deviation.begin[face], deviation.end[face]):
            total += weight[sample]
    # a mark in the middle of each part of the line; `passed`: since the last one
    share = total / (most // 2)
    kept, passed = 0, 0.5 * share
    for face in range(deviation.begin.size):
        begin, end = deviation.begin[face], deviation.end[face]
        if begin == end:
            continue
        last = begin
        for sample in range(begin, end):
            passed += weight[sample]
            if passed >= share:
                marks = np.floor(passed / share)
                passed -= marks * share
                _copy_sample(deviation, sample, last)
                weight[last] = marks * share
                last += 1
        deviation.end[face] = last
        kept += last - begin
        _sum_errors(deviation, surface, 3 * face)
    deviation.counts[2] = kept
    return True


@leaf_kernel
def hand_over_samples(deviation: Deviation, surface: Surface, corner: int) -> None:
    """Take the samples out of the two faces that vanish with an edge.

    `redistribute_samples` puts them into the faces around the new vertex.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
        Before the collapse.
    corner : int
        One of the two corners that face the edge.
    """
    for side in range(2):
        face = (corner if side == 0 else surface.opposite[corner]) // 3
        deviation.vanished[side, 0] = deviation.begin[face]
        deviation.vanished[side, 1] = deviation.end[face]
        deviation.end[face] = deviation.begin[face]
        deviation.error[face] = 0.0


@leaf_kernel
def redistribute_samples(deviation: Deviation, surface: Surface, centre: int) -> None:
    """Put the samples around a vertex into the faces that they are in now, and sum their errors.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
        After a collapse to the vertex, or after its move.
    centre : int
        The vertex.
    """
    begin, end, place, swung = deviation.begin, deviation.end, deviation.place, surface.swung
    vanished = deviation.vanished
    first = surface.corner_at[centre]
    count = vanished[0, 1] - vanished[0, 0] + vanished[1, 1] - vanished[1, 0]
    at = first
    while True:
        count += end[at // 3] - begin[at // 3]
        place[at // 3] = 0
        at = swung[at]
        if at == first:
            break
    _make_room(deviation, count)
    asked = 0
    while True:
        asked = _find_faces(deviation, surface, at, begin[at // 3], end[at // 3], asked)
        at = swung[at]
        if at == first:
            break
    for side in range(2):
        asked = _find_faces(deviation, surface, at, vanished[side, 0], vanished[side, 1], asked)
    top = deviation.counts[3]
    while True:
        more = place[at // 3]
        place[at // 3] = top
        top += more
        at = swung[at]
        if at == first:
            break
    asked = 0
    while True:
        _move_to_places(deviation, begin[at // 3], end[at // 3], asked)
        asked += end[at // 3] - begin[at // 3]
        at = swung[at]
        if at == first:
            break
    for side in range(2):
        _move_to_places(deviation, vanished[side, 0], vanished[side, 1], asked)
        asked += vanished[side, 1] - vanished[side, 0]
        vanished[side, 0] = vanished[side, 1] = 0
    top = deviation.counts[3]
    while True:
        face = at // 3
        begin[face], end[face] = top, place[face]
        top = end[face]
        _sum_errors(deviation, surface, at)
        at = swung[at]
        if at == first:
            break
    deviation.counts[3] = top


@leaf_kernel
def _find_faces(
    deviation: Deviation, surface: Surface, corner: int, begin: int, end: int, asked: int
) -> int:
    """Write to `pair` the corners at a vertex in whose faces samples are, and count them there.

    Most are in the face of the corner at hand; the others look for theirs around the vertex.
    """
    position, vertex, side = surface.position, surface.vertex, deviation.side
    centre, one, two = vertex[corner], vertex[following(corner)], vertex[preceding(corner)]
    cx, cy, cz = position[centre, 0], position[centre, 1], position[centre, 2]
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
    px, py, pz = cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax
    qx, qy, qz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    source, target, count = np.uint64(begin), np.uint64(asked), end - begin
    for index in range(count):
        sample = source + np.uint64(index)
        x, y, z = deviation.x[sample], deviation.y[sample], deviation.z[sample]
        left, right = px * x + py * y + pz * z, qx * x + qy * y + qz * z
        side[target + np.uint64(index)] = min(right, left)
    for index in range(asked, asked + count):
        chosen = corner
        depth = side[index]
        if depth < 0.0:
            found = begin + index - asked
            x, y, z = deviation.x[found], deviation.y[found], deviation.z[found]
            at = surface.swung[corner]
            while at != corner:
                one, two = vertex[following(at)], vertex[preceding(at)]
                least = min(
                    _side(position, centre, one, x, y, z), _side(position, two, centre, x, y, z)
                )
                if least > depth:
                    chosen, depth = at, least
                if least >= 0.0:
                    break
                at = surface.swung[at]
        deviation.pair[index] = chosen
        deviation.place[chosen // 3] += 1
    return asked + count


@leaf_kernel
def _make_room(deviation: Deviation, more: int) -> None:
    """See to it that so many samples, of those in use, can be written behind the last ones."""
    half = deviation.counts[6]
    if deviation.counts[3] + more <= deviation.counts[4] + half:
        return
    deviation.counts[4] = half - deviation.counts[4]
    top = deviation.counts[4]
    for face in range(deviation.begin.size):
        begin, end = deviation.begin[face], deviation.end[face]
        deviation.begin[face] = top
        for sample in range(begin, end):
            _copy_sample(deviation, sample, top)
            top += 1
        deviation.end[face] = top
    for side in range(2):
        begin, end = deviation.vanished[side, 0], deviation.vanished[side, 1]
        deviation.vanished[side, 0] = top
        for sample in range(begin, end):
            _copy_sample(deviation, sample, top)
            top += 1
        deviation.vanished[side, 1] = top
    deviation.counts[3] = top


@leaf_kernel
def _move_to_places(deviation: Deviation, begin: int, end: int, asked: int) -> None:
    """Copy samples to the places of the faces of the corners in `pair`, from `asked` on."""
    for sample in range(begin, end):
        face = deviation.pair[asked + sample - begin] // 3
        _copy_sample(deviation, sample, deviation.place[face])
        deviation.place[face] += 1


@inlined_kernel
def _copy_sample(deviation: Deviation, source: int, target: int) -> None:
    deviation.x[target] = deviation.x[source]
    deviation.y[target] = deviation.y[source]
    deviation.z[target] = deviation.z[source]
    deviation.weight[target] = deviation.weight[source]


@leaf_kernel
def _side(position: FloatArray, one: int, two: int, x: float, y: float, z: float) -> float:
    """(one × two)·(x, y, z): on which side of the plane through the centre and an edge it lies."""
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
    return x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)


@leaf_kernel
def _sum_errors(deviation: Deviation, surface: Surface, at: int) -> None:
    """Sum the errors of the samples in the face of a corner."""
    position, vertex = surface.position, surface.vertex
    centre, one, two = vertex[at], vertex[following(at)], vertex[preceding(at)]
    x, y, z = position[centre, 0], position[centre, 1], position[centre, 2]
    ux, uy, uz = position[one, 0] - x, position[one, 1] - y, position[one, 2] - z
    vx, vy, vz = position[two, 0] - x, position[two, 1] - y, position[two, 2] - z
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    determinant = nx * x + ny * y + nz * z
    scale = 1.0 / determinant if determinant > 0.0 else 0.0
    nx, ny, nz = scale * nx, scale * ny, scale * nz
    total = 0.0
    for sample in range(deviation.begin[at // 3], deviation.end[at // 3]):
        inverse = nx * deviation.x[sample] + ny * deviation.y[sample] + nz * deviation.z[sample]
        t = 1.0 / inverse
        share = abs(1.0 - t * t * t) if inverse > 0.0 else SHARE_OUTSIDE
        total += deviation.weight[sample] * min(share, LARGEST_SHARE)
    deviation.error[at // 3] = total
