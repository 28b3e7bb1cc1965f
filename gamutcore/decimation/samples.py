"""Samples of a reference surface, each in the face of the surface at hand that it belongs to.

Every sample is a point of the reference that stands for a part of its volume. All surfaces are
star-shaped about the centre, so a sample lies in the cone of exactly one face of the surface at
hand, and what the two disagree about in its direction is w |1 − t³|, w being its share of the
reference's volume (the cone between the centre and its part of the surface) and t the surface's
radius there ÷ its own. The sum over all samples is the volume of the symmetric difference
(`gamutcore.decimation.deviation` has its changes).

Data layout: one array for each coordinate, in which the samples of a face follow each other, so
that a loop over them waits for no memory and the compiler takes several at a time. Where faces
exchange samples, all of these are written anew behind the last ones; the arrays have two halves,
and when one is full the samples in use move to the other.

Samples stand for nearly equal shares. Faces of a boundary differ in size by a factor of thousands,
and with one sample on each, the few samples of the large ones carried most of the sum: it was up to
a half less than the mismatch of the levels that were chosen by it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.star import Surface
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "LANES",
    "LARGEST_RING",
    "LARGEST_SHARE",
    "Deviation",
    "deviation_on",
    "hand_over_samples",
    "locate_samples",
    "no_deviation",
    "redistribute_samples",
    "room_for_samples",
    "take_samples",
    "thin_samples",
]

LARGEST_RING = 64
"""Rings with more faces are not evaluated: their edge would not be among the cheapest."""

LARGEST_SHARE = 8.0
"""Bound of |1 − t³|: the surface at hand may reach far out where a place is not valid anyway."""

LANES = 32
"""Samples that the compiler takes at a time, at most: four vectors of eight numbers."""


class Deviation(NamedTuple):
    """Samples of a reference, and the faces that they are in.

    Attributes
    ----------
    x, y, z : (4 S,) float64
        The samples, relative to the centre.
    weight : (4 S,) float64
        Their shares of the reference's volume, in six times the unit.
    begin, end : (F,) int64
        Where the samples of a face are in these.
    error : (F,) float64
        Sum of w |1 − t³| over the samples of a face.
    place : (F,) int64
        Scratch: where the next sample of a face goes.
    vanished : (2, 2) int64
        Where the samples of the two faces are that have vanished last; empty once they are handed
        on.
    link : (LARGEST_RING, 2) int32
        Scratch: the edges opposite a place, in the order in which they go around it.
    pair_plane : (LARGEST_RING, 14) float64
        Scratch, for each face (p, a, b) of the place p and one of them, counter-clockwise: p × a
        and b × p, between which the cone of the face lies, N such that N·q = 1 on the face, a × b ÷
        det(p, a, b), |N| and 1 ÷ |N|.
    pair_sum : (LARGEST_RING, 2) float64
        Scratch, for each of them: sums over its samples.
    face : (LARGEST_RING,) int32
        Scratch: the faces around the place as they are now.
    asked_x, asked_y, asked_z, asked_weight : (S + LANES,) float64
        Scratch: the samples in these, and some without a weight, so that they are a multiple of
        LANES.
    pair : (S + LANES,) int64
        Scratch: the face around the place that each of them is in, or the corner in the middle of
        the face that it is in.
    side, inverse : (S + LANES,) float64
        Scratch: how deep each of them is in the cone of a face, and N·q for its face.
    counts : (6,) int64
        Scratch: entries of `link`, entries of `face`; samples in use; where the next ones go; where
        the half of the arrays begins that they are in; samples asked for, and those without weight.
    residual : (2,) float64
        Scratch: the samples' distances from the faces around the place, summed over the area that
        they stand for, and that area.
    """

    x: FloatArray
    y: FloatArray
    z: FloatArray
    weight: FloatArray
    begin: LongArray
    end: LongArray
    error: FloatArray
    place: LongArray
    vanished: LongArray
    link: IndexArray
    pair_plane: FloatArray
    pair_sum: FloatArray
    face: IndexArray
    asked_x: FloatArray
    asked_y: FloatArray
    asked_z: FloatArray
    asked_weight: FloatArray
    pair: LongArray
    side: FloatArray
    inverse: FloatArray
    counts: LongArray
    residual: FloatArray


def no_deviation(samples: int, faces: int) -> Deviation:
    """Return a deviation with room for so many samples on so many faces, without any yet."""
    return Deviation(
        x=np.empty(4 * samples),
        y=np.empty(4 * samples),
        z=np.empty(4 * samples),
        weight=np.empty(4 * samples),
        begin=np.zeros(faces, np.int64),
        end=np.zeros(faces, np.int64),
        error=np.zeros(faces),
        place=np.zeros(faces, np.int64),
        vanished=np.zeros((2, 2), np.int64),
        link=np.empty((LARGEST_RING, 2), np.int32),
        pair_plane=np.empty((LARGEST_RING, 14)),
        pair_sum=np.empty((LARGEST_RING, 2)),
        face=np.empty(LARGEST_RING, np.int32),
        asked_x=np.empty(samples + LANES),
        asked_y=np.empty(samples + LANES),
        asked_z=np.empty(samples + LANES),
        asked_weight=np.empty(samples + LANES),
        pair=np.empty(samples + LANES, np.int64),
        side=np.empty(samples + LANES),
        inverse=np.empty(samples + LANES),
        counts=np.zeros(6, np.int64),
        residual=np.zeros(2),
    )


def room_for_samples(wanted: int, faces: int, most: int) -> int:
    """How many samples `take_samples` takes of so many faces at most.

    One of each face, and where a face of x shares has more, at most (x + ½)² ≤ 16/9 x of them.
    """
    return min(faces + 16 * wanted // 9, most) + 1


def deviation_on(deviation: Deviation, faces: IndexArray) -> Deviation:
    """Return the same samples on a surface that has only some of the faces, in another order.

    Parameters
    ----------
    deviation : Deviation
        Of a surface; or with samples that are in no faces yet.
    faces : (F,) int32
        Their numbers there.

    Returns
    -------
    Deviation
        With room for these samples only.
    """
    used = int(deviation.counts[2])
    copy = no_deviation(used, len(faces))
    copy.counts[2] = used
    kept = np.arange(used)
    if deviation.begin.size:
        begin, end = deviation.begin[faces], deviation.end[faces]
        copy.counts[3] = used
        copy.end[:] = np.cumsum(end - begin)
        copy.begin[1:] = copy.end[:-1]
        copy.error[:] = deviation.error[faces]
        kept = np.arange(used) + np.repeat(begin - copy.begin, end - begin)
    for name in ("x", "y", "z", "weight"):
        getattr(copy, name)[:used] = getattr(deviation, name)[kept]
    return copy


@leaf_kernel
def _six_volumes(position: FloatArray, one: int, two: int, three: int) -> float:
    """Six times the volume of the cone over a face."""
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
    cx, cy, cz = position[three, 0], position[three, 1], position[three, 2]
    return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)


@leaf_kernel
def _add_lattice(
    deviation: Deviation,
    position: FloatArray,
    one: int,
    two: int,
    three: int,
    m: int,
    share: float,
    passed: float,
) -> float:
    """Add the centroids of the m² equal triangles that a face is divided into.

    With a positive share only those that a mark falls into, marks being a share apart: `passed` is
    how far the last one is behind, and what is returned, how far it is after the face.
    """
    weight = _six_volumes(position, one, two, three) / (m * m)
    for i in range(m):
        for j in range(m - i):
            for turned in range(2 if i + j < m - 1 else 1):
                stands_for = weight
                if share > 0.0:
                    passed += weight
                    if passed < share:
                        continue
                    stands_for = np.floor(passed / share) * share
                    passed -= stands_for
                u = (i + (1.0 + turned) / 3.0) / m
                v = (j + (1.0 + turned) / 3.0) / m
                w = 1.0 - u - v
                sample = deviation.counts[2]
                deviation.counts[2] += 1
                deviation.x[sample] = (
                    u * position[one, 0] + v * position[two, 0] + w * position[three, 0]
                )
                deviation.y[sample] = (
                    u * position[one, 1] + v * position[two, 1] + w * position[three, 1]
                )
                deviation.z[sample] = (
                    u * position[one, 2] + v * position[two, 2] + w * position[three, 2]
                )
                deviation.weight[sample] = stands_for
    return passed


@leaf_kernel
def take_samples(deviation: Deviation, surface: Surface, wanted: int, most: int) -> None:
    """Take the surface as the reference, and points on its faces as the samples.

    They are the centroids of equal parts of each face, and stand for one part each: what two
    surfaces of triangles differ by is linear but where the faces' edges cross or the surfaces do.
    If they are too many, about half as many as are allowed are chosen as `thin_samples` does.

    Parameters
    ----------
    deviation : Deviation
        Without samples, with `room_for_samples`. If it has room for all faces, the samples are in
        theirs then, else `locate_samples` puts them into faces.
    surface : Surface
        At any level.
    wanted : int
        Faces are divided into parts of about this part of the volume; each has one sample at least.
    most : int
        Samples that are not too many.
    """
    whole, _ = _gone_through(deviation, surface, 0.0, 0.0)
    share = whole / wanted
    _, count = _gone_through(deviation, surface, share, -1.0)
    _gone_through(deviation, surface, share, 0.0 if count <= most else whole / (most // 2))
    deviation.counts[3] = deviation.counts[2] if deviation.begin.size > 0 else 0


@leaf_kernel
def _gone_through(
    deviation: Deviation, surface: Surface, part: float, share: float
) -> tuple[float, int]:
    """Six times the volume and, with a positive part of it to divide faces into, how many there are.

    They are added as samples if the share is not negative, as by `_add_lattice`.
    """
    vertex, position = surface.vertex, surface.position
    whole, count, passed = 0.0, 0, 0.5 * share
    for edge in range(surface.corner_facing.size):
        corner = surface.corner_facing[edge]
        if corner < 0:
            continue
        for side in range(2):
            at = corner if side == 0 else surface.opposite[corner]
            # each face once: by the least of its three edges
            if edge > min(surface.edge_of[following(at)], surface.edge_of[preceding(at)]):
                continue
            one, two, three = vertex[at], vertex[following(at)], vertex[preceding(at)]
            volume = _six_volumes(position, one, two, three)
            whole += volume
            if not part > 0.0:
                continue
            divisions = max(1, int(np.rint(np.sqrt(volume / part))))
            count += divisions * divisions
            if share < 0.0:
                continue
            begin = deviation.counts[2]
            passed = _add_lattice(deviation, position, one, two, three, divisions, share, passed)
            if at // 3 < deviation.begin.size:
                deviation.begin[at // 3], deviation.end[at // 3] = begin, deviation.counts[2]
                deviation.error[at // 3] = 0.0
    return whole, count


@leaf_kernel
def locate_samples(deviation: Deviation, surface: Surface) -> None:
    """Put samples that are in no faces into those of a surface.

    Parameters
    ----------
    deviation : Deviation
        As `take_samples` left it, or `deviation_on` that, with room for all faces.
    surface : Surface
    """
    count, half = deviation.counts[2], deviation.x.size // 2
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


@inlined_kernel
def _copy_sample(deviation: Deviation, source: int, target: int) -> None:
    deviation.x[target] = deviation.x[source]
    deviation.y[target] = deviation.y[source]
    deviation.z[target] = deviation.z[source]
    deviation.weight[target] = deviation.weight[source]


@leaf_kernel
def _move_to_places(deviation: Deviation, begin: int, end: int, asked: int) -> None:
    """Copy samples to the places of the faces of the corners in `pair`, from `asked` on."""
    for sample in range(begin, end):
        face = deviation.pair[asked + sample - begin] // 3
        _copy_sample(deviation, sample, deviation.place[face])
        deviation.place[face] += 1


@leaf_kernel
def _make_room(deviation: Deviation, more: int) -> None:
    """See to it that so many samples, of those in use, can be written behind the last ones."""
    half = deviation.x.size // 2
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
    begin, end, place, swing = deviation.begin, deviation.end, deviation.place, surface.swing
    vanished = deviation.vanished
    first = surface.corner_at[centre]
    count = vanished[0, 1] - vanished[0, 0] + vanished[1, 1] - vanished[1, 0]
    at = first
    while True:
        count += end[at // 3] - begin[at // 3]
        place[at // 3] = 0
        at = swing[at]
        if at == first:
            break
    _make_room(deviation, count)
    asked = 0
    while True:
        asked = _find_faces(deviation, surface, at, begin[at // 3], end[at // 3], asked)
        at = swing[at]
        if at == first:
            break
    for side in range(2):
        asked = _find_faces(deviation, surface, at, vanished[side, 0], vanished[side, 1], asked)
    top = deviation.counts[3]
    while True:
        more = place[at // 3]
        place[at // 3] = top
        top += more
        at = swing[at]
        if at == first:
            break
    asked = 0
    while True:
        _move_to_places(deviation, begin[at // 3], end[at // 3], asked)
        asked += end[at // 3] - begin[at // 3]
        at = swing[at]
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
        at = swing[at]
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
        side[target + np.uint64(index)] = left if left < right else right
    for index in range(asked, asked + count):
        chosen = corner
        depth = side[index]
        if depth < 0.0:
            sample = begin + index - asked
            x, y, z = deviation.x[sample], deviation.y[sample], deviation.z[sample]
            at = surface.swing[corner]
            while at != corner:
                one, two = vertex[following(at)], vertex[preceding(at)]
                least = min(
                    _side(position, centre, one, x, y, z), _side(position, two, centre, x, y, z)
                )
                if least > depth:
                    chosen, depth = at, least
                if least >= 0.0:
                    break
                at = surface.swing[at]
        deviation.pair[index] = chosen
        deviation.place[chosen // 3] += 1
    return asked + count


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
        share = abs(1.0 - t * t * t) if inverse > 0.0 else LARGEST_SHARE
        total += deviation.weight[sample] * min(share, LARGEST_SHARE)
    deviation.error[at // 3] = total


@leaf_kernel
def _side(position: FloatArray, one: int, two: int, x: float, y: float, z: float) -> float:
    """(one × two)·(x, y, z): on which side of the plane through the centre and an edge it lies."""
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
    return x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)
