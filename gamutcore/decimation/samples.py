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
from gamutcore.kernels import leaf_kernel

__all__ = [
    "LANES",
    "LARGEST_RING",
    "LARGEST_SHARE",
    "SHARE_OUTSIDE",
    "TOGETHER",
    "Deviation",
    "deviation_on",
    "no_deviation",
    "room_for_samples",
    "take_samples",
]

LARGEST_RING = 64
"""Rings with more faces are not evaluated: their edge would not be among the cheapest."""

LARGEST_SHARE = 1e12
"""Bound of |1 − t³|, which keeps sums finite: the surface at hand may be nearly edge-on."""

SHARE_OUTSIDE = 8.0
"""What it is for samples that no face is in front of: the place is not valid then."""

LANES = 8
"""Samples that the compiler takes at a time, at most: a vector of eight numbers."""

TOGETHER = 4
"""Faces around a place that samples are compared with at a time; of the last ones, maybe half as
many."""


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
    pair_plane : (LARGEST_RING + TOGETHER, 10) float64
        Scratch, for each face (p, a, b) of the place p and one of them, counter-clockwise: p × a,
        between which and that of the next face its cone lies, N such that N·q = 1 on the face,
        a × b ÷ det(p, a, b), and |N|.
    pair_sum : (LARGEST_RING, 8) float64
        Scratch, for each of them: two sums over its samples, in four parts.
    face : (LARGEST_RING,) int32
        Scratch: the faces around the place as they are now.
    asked_x, asked_y, asked_z, asked_weight : (S + LANES,) float64
        Scratch: the samples in these, and some without a weight, so that they are a multiple of
        LANES.
    pair : (S + LANES,) int64
        Scratch: the face around the place that each of them is in; where they are put into faces, a
        corner of the one that each goes to.
    side, inverse, norm : (S + LANES,) float64
        Scratch: how deep each of them is in the cone of a face, and N·q and |N| of that face.
    term, other_term, third_term : (S + LANES,) float64
        Scratch: what each of them adds to a sum.
    counts : (7,) int64
        Entries of `link`, entries of `face`; samples in use; where the next ones go, 0 as long as
        they are in no faces; where the half begins that they are in; samples asked for, with those
        without a weight; entries of either half of the arrays, of which no more are used than twice
        as many as there are samples at first.
    residual : (4,) float64
        Scratch: the samples' distances from the faces around the place, summed over the area that
        they stand for, and that area; the sum of the weights of the samples asked for. The last one
        stays: that of all samples.
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
    norm: FloatArray
    term: FloatArray
    other_term: FloatArray
    third_term: FloatArray
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
        pair_plane=np.empty((LARGEST_RING + TOGETHER, 10)),
        pair_sum=np.empty((LARGEST_RING, 8)),
        face=np.empty(LARGEST_RING, np.int32),
        asked_x=np.empty(samples + LANES),
        asked_y=np.empty(samples + LANES),
        asked_z=np.empty(samples + LANES),
        asked_weight=np.empty(samples + LANES),
        pair=np.empty(samples + LANES, np.int64),
        side=np.empty(samples + LANES),
        inverse=np.empty(samples + LANES),
        norm=np.empty(samples + LANES),
        term=np.empty(samples + LANES),
        other_term=np.empty(samples + LANES),
        third_term=np.empty(samples + LANES),
        counts=np.zeros(7, np.int64),
        residual=np.zeros(4),
    )


def room_for_samples(wanted: int, faces: int) -> int:
    """How many samples `take_samples` takes of so many faces at most.

    One of each face, and where a face of x shares has more, at most (x + ½)² ≤ 16/9 x of them.
    """
    return faces + 16 * wanted // 9 + 1


def deviation_on(deviation: Deviation, faces: IndexArray) -> Deviation:
    """Return the same samples on a surface that has only some of the faces.

    Parameters
    ----------
    deviation : Deviation
        Whose samples, if there are any, are all in these faces, or in none yet.
    faces : (f,) int32
        Their numbers there.

    Returns
    -------
    Deviation
        With room for these samples only, or, without any, for as many as before.
    """
    used = int(deviation.counts[2])
    if used == 0:
        return no_deviation(deviation.asked_x.size - LANES, len(faces))
    copy = no_deviation(used, len(faces))
    copy.counts[2], copy.counts[6] = used, 2 * used
    copy.residual[3] = deviation.residual[3]
    kept = np.arange(used)
    if deviation.counts[3] > 0:
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
def take_samples(deviation: Deviation, surface: Surface, wanted: int, in_faces: bool) -> None:
    """Take the surface as the reference, and points on its faces as the samples.

    They are the centroids of equal parts of each face, and stand for one part each: what two
    surfaces of triangles differ by is linear but where the faces' edges cross or the surfaces do.
    If there is no room for all of them, half as many as there is room for are chosen, as
    `thin_samples` does.

    Parameters
    ----------
    deviation : Deviation
        Without samples.
    surface : Surface
        At any level.
    wanted : int
        Faces are divided into parts of about this part of the volume; each has one sample at least.
    in_faces : bool
        Whether they are put into their faces at once; if not, `locate_samples` does it at a later
        level.
    """
    room = deviation.asked_x.size - LANES
    whole, _ = _gone_through(deviation, surface, 0.0, 0.0, False)
    part = whole / wanted
    _, count = _gone_through(deviation, surface, part, -1.0, False)
    share = 0.0 if count <= room else whole / (room // 2)
    _gone_through(deviation, surface, part, share, in_faces)
    deviation.counts[3] = deviation.counts[2] if in_faces else 0
    deviation.counts[6] = 2 * deviation.counts[2]
    deviation.residual[3] = whole


@leaf_kernel
def _gone_through(
    deviation: Deviation, surface: Surface, part: float, share: float, in_faces: bool
) -> tuple[float, int]:
    """Six times the volume and, with a positive part of it as the wanted size, how many samples.

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
            if in_faces:
                deviation.begin[at // 3], deviation.end[at // 3] = begin, deviation.counts[2]
    return whole, count
