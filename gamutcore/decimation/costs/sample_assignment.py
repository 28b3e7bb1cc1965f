"""Assignment of samples to faces: the initial search, and updates as faces change.

A collapse, or a move of a vertex, exchanges samples only among the faces around it. Most samples
stay in their face, so each sample is compared with its present face first.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.costs.samples import (
    HALF_BEGIN,
    HALF_SIZE,
    LARGEST_SHARE,
    PENALTY_OUTSIDE,
    SAMPLES,
    TOP,
    Deviation,
)
from gamutcore.decimation.star import Surface
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = ["assign_samples", "reassign_samples", "release_samples", "thin_samples"]


@leaf_kernel
def assign_samples(deviation: Deviation, surface: Surface) -> None:
    """Assign samples that are in no face yet to the faces of a surface.

    Parameters
    ----------
    deviation : Deviation
        As `take_samples` or `deviation_on_faces` left it, with room for all faces.
    surface : Surface
    """
    count, half = deviation.counts[SAMPLES], deviation.counts[HALF_SIZE]
    for face in range(deviation.cursor.size):
        deviation.cursor[face] = 0
    at = 0
    for edge in range(surface.corner_facing.size):
        at = int(surface.corner_facing[edge])
        if at >= 0:
            break
    for sample in range(count):
        # samples follow each other in space, so the next face is near
        at = _corner_below(
            surface, deviation.x[sample], deviation.y[sample], deviation.z[sample], at
        )
        deviation.pair[sample] = at
        deviation.cursor[at // 3] += 1
    top = half
    for face in range(deviation.begin.size):
        deviation.begin[face] = top
        top += deviation.cursor[face]
        deviation.cursor[face] = deviation.begin[face]
        deviation.end[face] = top
    _move_to_cursors(deviation, 0, count, 0)
    deviation.counts[TOP], deviation.counts[HALF_BEGIN] = top, half
    for face in range(deviation.begin.size):
        if deviation.end[face] > deviation.begin[face]:
            _sum_errors(deviation, surface, 3 * face)


@leaf_kernel
def _depth_in_face(surface: Surface, corner: int, x: float, y: float, z: float) -> float:
    """Smallest determinant of a point with the edges of a face; not negative inside its cone."""
    position, vertex = surface.position, surface.vertex
    zero, one = int(vertex[corner]), int(vertex[following(corner)])
    two = int(vertex[preceding(corner)])
    return min(
        _side(position, one, two, x, y, z),
        _side(position, two, zero, x, y, z),
        _side(position, zero, one, x, y, z),
    )


@leaf_kernel
def _corner_below(surface: Surface, x: float, y: float, z: float, begin: int) -> int:
    """A corner of the face whose cone contains a point, found by walking over the faces."""
    position, vertex, at = surface.position, surface.vertex, begin
    for _ in range(surface.corner_facing.size):
        zero, one, two = int(vertex[at]), int(vertex[following(at)]), int(vertex[preceding(at)])
        facing = _side(position, one, two, x, y, z)
        second = _side(position, two, zero, x, y, z)
        third = _side(position, zero, one, x, y, z)
        if min(facing, second, third) >= 0.0:
            return at
        if facing <= second and facing <= third:
            at = int(surface.opposite[at])
        elif second <= third:
            at = int(surface.opposite[following(at)])
        else:
            at = int(surface.opposite[preceding(at)])
    # a walk can cycle where faces are slivers (Devillers, Pion & Teillaud 2002)
    depth = -np.inf
    for edge in range(surface.corner_facing.size):
        corner = int(surface.corner_facing[edge])
        if corner < 0:
            continue
        for side in range(2):
            tried = corner if side == 0 else int(surface.opposite[corner])
            least = _depth_in_face(surface, tried, x, y, z)
            if least > depth:
                at, depth = tried, least
    return at


@leaf_kernel
def thin_samples(deviation: Deviation, surface: Surface, most: int) -> bool:
    """Remove at least about half of the samples if there are more than `most`.

    The weights form a line, face by face, with marks at equal distances. A sample stays if a mark
    falls on its weight, and then represents its marks (systematic resampling, Kitagawa 1996). Small
    weights thereby grow to the size of the others.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
    most : int

    Returns
    -------
    bool
        Whether samples were removed. All errors of edges have then changed.
    """
    if deviation.counts[SAMPLES] <= most:
        return False
    weight = deviation.weight
    total = 0.0
    for face in range(deviation.begin.size):
        for sample in range(deviation.begin[face], deviation.end[face]):
            total += weight[sample]
    # marks lie in the middle of each share; `passed` is the distance from the last mark
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
    deviation.counts[SAMPLES] = kept
    return True


@leaf_kernel
def release_samples(deviation: Deviation, surface: Surface, corner: int) -> None:
    """Take the samples out of the two faces that a collapse removes.

    `reassign_samples` assigns them to the faces around the new vertex.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
        Before the collapse.
    corner : int
        One of the two corners that face the edge.
    """
    for side in range(2):
        face = (corner if side == 0 else int(surface.opposite[corner])) // 3
        deviation.released[side, 0] = deviation.begin[face]
        deviation.released[side, 1] = deviation.end[face]
        deviation.end[face] = deviation.begin[face]
        deviation.error[face] = 0.0


@leaf_kernel
def reassign_samples(deviation: Deviation, surface: Surface, centre: int) -> None:
    """Assign the samples around a vertex to their present faces and sum the faces' errors.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
        After a collapse to the vertex or a move of it.
    centre : int
        The vertex.
    """
    begin, end, cursor, swung = deviation.begin, deviation.end, deviation.cursor, surface.swung
    released = deviation.released
    first = int(np.int64(surface.corner_at[centre]))
    count = released[0, 1] - released[0, 0] + released[1, 1] - released[1, 0]
    at = first
    while True:
        count += end[at // 3] - begin[at // 3]
        cursor[at // 3] = 0
        at = int(np.int64(swung[at]))
        if at == first:
            break
    _make_room(deviation, count)
    found = 0
    while True:
        found = _find_faces(deviation, surface, at, begin[at // 3], end[at // 3], found)
        at = int(np.int64(swung[at]))
        if at == first:
            break
    for side in range(2):
        found = _find_faces(deviation, surface, at, released[side, 0], released[side, 1], found)
    top = deviation.counts[TOP]
    while True:
        more = cursor[at // 3]
        cursor[at // 3] = top
        top += more
        at = int(np.int64(swung[at]))
        if at == first:
            break
    moved = 0
    while True:
        _move_to_cursors(deviation, begin[at // 3], end[at // 3], moved)
        moved += end[at // 3] - begin[at // 3]
        at = int(np.int64(swung[at]))
        if at == first:
            break
    for side in range(2):
        _move_to_cursors(deviation, released[side, 0], released[side, 1], moved)
        moved += released[side, 1] - released[side, 0]
        released[side, 0] = released[side, 1] = 0
    top = deviation.counts[TOP]
    while True:
        face = at // 3
        begin[face], end[face] = top, cursor[face]
        top = end[face]
        _sum_errors(deviation, surface, at)
        at = int(np.int64(swung[at]))
        if at == first:
            break
    deviation.counts[TOP] = top


@leaf_kernel
def _find_faces(
    deviation: Deviation, surface: Surface, corner: int, begin: int, end: int, found: int
) -> int:
    """Write corners of the faces around a vertex that samples lie in to `pair`, and count them.

    Most samples lie in the face of `corner`. The others search around the vertex. `found` entries
    of `pair` are in use before; the result is their number afterwards.
    """
    position, vertex, depths = surface.position, surface.vertex, deviation.depth
    centre = int(vertex[corner])
    one, two = vertex[following(corner)], vertex[preceding(corner)]
    cx, cy, cz = position[centre, 0], position[centre, 1], position[centre, 2]
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
    px, py, pz = cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax
    qx, qy, qz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    source, target, count = np.uint64(begin), np.uint64(found), end - begin
    for index in range(count):
        sample = source + np.uint64(index)
        x, y, z = deviation.x[sample], deviation.y[sample], deviation.z[sample]
        left, right = px * x + py * y + pz * z, qx * x + qy * y + qz * z
        depths[target + np.uint64(index)] = min(right, left)
    for index in range(found, found + count):
        chosen = corner
        depth = depths[index]
        if depth < 0.0:
            sample_index = begin + index - found
            x = deviation.x[sample_index]
            y = deviation.y[sample_index]
            z = deviation.z[sample_index]
            at = int(surface.swung[corner])
            while at != corner:
                after, before = int(vertex[following(at)]), int(vertex[preceding(at)])
                least = min(
                    _side(position, centre, after, x, y, z),
                    _side(position, before, centre, x, y, z),
                )
                if least > depth:
                    chosen, depth = at, least
                if least >= 0.0:
                    break
                at = int(surface.swung[at])
        deviation.pair[index] = chosen
        deviation.cursor[chosen // 3] += 1
    return found + count


@leaf_kernel
def _make_room(deviation: Deviation, more: int) -> None:
    """Move all samples to the other half if `more` samples do not fit behind the last one."""
    counts, half = deviation.counts, deviation.counts[HALF_SIZE]
    if counts[TOP] + more <= counts[HALF_BEGIN] + half:
        return
    counts[HALF_BEGIN] = half - counts[HALF_BEGIN]
    top = counts[HALF_BEGIN]
    for face in range(deviation.begin.size):
        begin, end = deviation.begin[face], deviation.end[face]
        deviation.begin[face] = top
        for sample in range(begin, end):
            _copy_sample(deviation, sample, top)
            top += 1
        deviation.end[face] = top
    for side in range(2):
        begin, end = deviation.released[side, 0], deviation.released[side, 1]
        deviation.released[side, 0] = top
        for sample in range(begin, end):
            _copy_sample(deviation, sample, top)
            top += 1
        deviation.released[side, 1] = top
    counts[TOP] = top


@leaf_kernel
def _move_to_cursors(deviation: Deviation, begin: int, end: int, first: int) -> None:
    """Copy samples to the cursors of the faces that `pair` names, from entry `first` on."""
    for sample in range(begin, end):
        face = deviation.pair[first + sample - begin] // 3
        _copy_sample(deviation, sample, deviation.cursor[face])
        deviation.cursor[face] += 1


@inlined_kernel
def _copy_sample(deviation: Deviation, source: int, target: int) -> None:
    deviation.x[target] = deviation.x[source]
    deviation.y[target] = deviation.y[source]
    deviation.z[target] = deviation.z[source]
    deviation.weight[target] = deviation.weight[source]


@leaf_kernel
def _side(position: FloatArray, one: int, two: int, x: float, y: float, z: float) -> float:
    """(one × two)·(x, y, z): the side of the plane through the centre and an edge."""
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
        share = abs(1.0 - t * t * t) if inverse > 0.0 else PENALTY_OUTSIDE
        total += deviation.weight[sample] * min(share, LARGEST_SHARE)
    deviation.error[at // 3] = total
