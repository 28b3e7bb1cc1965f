"""Samples of a reference surface, each in the face of the surface at hand that it belongs to.

Every sample is a point of the reference that stands for a part of its volume. All surfaces are
star-shaped about the centre, so a sample lies in the cone of exactly one face of the surface at
hand, and what the two disagree about in its direction is w |1 − t³|, w being its share of the
reference's volume (the cone between the centre and its part of the surface) and t the surface's
radius there ÷ its own. The sum over all samples is the volume of the symmetric difference
(`gamutcore.decimation.deviation` has its changes). Each face has a linked list of its samples.

Samples stand for nearly equal shares. Faces of a boundary differ in size by a factor of thousands,
and with one sample on each, the few samples of the large ones carried most of the sum: it was up to
a half less than the mismatch of the levels that were chosen by it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.star import Surface
from gamutcore.kernels import leaf_kernel

__all__ = [
    "LARGEST_RING",
    "LARGEST_SHARE",
    "Deviation",
    "hand_over_samples",
    "no_deviation",
    "redistribute_samples",
    "room_for_samples",
    "start_at_surface",
    "thin_samples",
]

LARGEST_RING = 64
"""Rings with more faces are not evaluated: their edge would not be among the cheapest."""

LARGEST_SHARE = 8.0
"""Bound of |1 − t³|: the surface at hand may reach far out where a place is not valid anyway."""


class Deviation(NamedTuple):
    """Samples of a reference, and the faces that they are in.

    Attributes
    ----------
    point : (S, 3) float64
        The samples, relative to the centre.
    weight : (S,) float64
        Their shares of the reference's volume, in six times the unit.
    after : (S,) int32
        The sample that follows in its face's list; −1: none.
    first : (F,) int32
        The first sample in a face's list; −1: none.
    error : (F,) float64
        Sum of w |1 − t³| over the samples of a face.
    pair_plane : (LARGEST_RING, 13) float64
        Scratch, for each face (x, a, b) around a place x, counter-clockwise: x × a and b × x,
        between which the cone of the face lies, N such that N·p = 1 on the face, a × b ÷ det(x, a,
        b), and |N|.
    face : (LARGEST_RING, 2) int32
        Scratch: the faces whose samples are in question, and where to begin to look for these
        among the faces around the place.
    pair : (S,) int32
        Scratch: the face around the place that a sample in question is in, or the corner in the
        middle of the face that it was in.
    counts : (3,) int32
        Scratch: entries of `pair_plane`, entries of `face`, samples in use.
    residual : (2,) float64
        Scratch: the samples' distances from the faces around the place, summed over the area that
        they stand for, and that area.
    """

    point: FloatArray
    weight: FloatArray
    after: IndexArray
    first: IndexArray
    error: FloatArray
    pair_plane: FloatArray
    face: IndexArray
    pair: IndexArray
    counts: IndexArray
    residual: FloatArray


def no_deviation(samples: int, faces: int) -> Deviation:
    """Return a deviation with room for so many samples on so many faces, without any yet."""
    return Deviation(
        point=np.empty((samples, 3)),
        weight=np.empty(samples),
        after=np.empty(samples, np.int32),
        first=np.full(faces, -1, np.int32),
        error=np.zeros(faces),
        pair_plane=np.empty((LARGEST_RING, 13)),
        face=np.empty((LARGEST_RING, 2), np.int32),
        pair=np.empty(samples, np.int32),
        counts=np.zeros(3, np.int32),
        residual=np.zeros(2),
    )


def room_for_samples(wanted: int, faces: int) -> int:
    """How many samples `start_at_surface` takes of so many faces at most.

    One of each face, and where a face of x shares has more, at most (x + ½)² ≤ 16/9 x of them.
    """
    return faces + 16 * wanted // 9 + 1


@leaf_kernel
def _add_sample(
    deviation: Deviation, face: int, x: float, y: float, z: float, weight: float
) -> None:
    """Put a sample at the head of a face's list."""
    sample = deviation.counts[2]
    deviation.counts[2] += 1
    deviation.point[sample, 0] = x
    deviation.point[sample, 1] = y
    deviation.point[sample, 2] = z
    deviation.weight[sample] = weight
    deviation.after[sample] = deviation.first[face]
    deviation.first[face] = sample


@leaf_kernel
def _six_volumes(position: FloatArray, one: int, two: int, three: int) -> float:
    """Six times the volume of the cone over a face."""
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
    cx, cy, cz = position[three, 0], position[three, 1], position[three, 2]
    return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)


@leaf_kernel
def _add_lattice(
    deviation: Deviation, position: FloatArray, one: int, two: int, three: int, face: int, m: int
) -> None:
    """Add the centroids of the m² equal triangles that a face is divided into."""
    share = _six_volumes(position, one, two, three) / (m * m)
    for i in range(m):
        for j in range(m - i):
            for turned in range(2 if i + j < m - 1 else 1):
                u = (i + (1.0 + turned) / 3.0) / m
                v = (j + (1.0 + turned) / 3.0) / m
                w = 1.0 - u - v
                x = u * position[one, 0] + v * position[two, 0] + w * position[three, 0]
                y = u * position[one, 1] + v * position[two, 1] + w * position[three, 1]
                z = u * position[one, 2] + v * position[two, 2] + w * position[three, 2]
                _add_sample(deviation, face, x, y, z, share)


@leaf_kernel
def start_at_surface(deviation: Deviation, surface: Surface, wanted: int) -> None:
    """Take the surface as the reference, and points on its faces as the samples.

    They are the centroids of equal parts of each face, and stand for one part each: what two
    surfaces of triangles differ by is linear but where the faces' edges cross or the surfaces do.

    Parameters
    ----------
    deviation : Deviation
        Without samples, with `room_for_samples`.
    surface : Surface
        At any level.
    wanted : int
        Faces are divided into parts of about this part of the volume; each has one sample at least.
    """
    share = _volume_in_faces(deviation, surface, 0.0) / wanted
    _volume_in_faces(deviation, surface, share)


@leaf_kernel
def _volume_in_faces(deviation: Deviation, surface: Surface, share: float) -> float:
    """Six times the volume; with a positive share, samples that stand for that much are added."""
    vertex, position, total = surface.vertex, surface.position, 0.0
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
            total += volume
            if share > 0.0:
                divisions = max(1, int(np.rint(np.sqrt(volume / share))))
                _add_lattice(deviation, position, one, two, three, at // 3, divisions)
    return total


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
    total = 0.0
    for face in range(deviation.first.size):
        sample = deviation.first[face]
        while sample >= 0:
            total += deviation.weight[sample]
            sample = deviation.after[sample]
    # a mark in the middle of each part of the line; `passed`: since the last one
    share = total / (most // 2)
    kept, passed = 0, 0.5 * share
    for face in range(deviation.first.size):
        sample = deviation.first[face]
        if sample < 0:
            continue
        last = -1
        while sample >= 0:
            then = deviation.after[sample]
            passed += deviation.weight[sample]
            if passed >= share:
                marks = np.floor(passed / share)
                passed -= marks * share
                deviation.weight[sample] = marks * share
                deviation.after[sample] = last
                last = sample
                kept += 1
            sample = then
        deviation.first[face] = last
        _sum_errors(deviation, surface, 3 * face)
    deviation.counts[2] = kept
    return True


@leaf_kernel
def hand_over_samples(deviation: Deviation, surface: Surface, corner: int) -> None:
    """Give the samples of the two faces that vanish with an edge to neighbours that stay.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
        Before the collapse.
    corner : int
        One of the two corners that face the edge.
    """
    for side in range(2):
        at = corner if side == 0 else surface.opposite[corner]
        gone, stays = at // 3, surface.opposite[following(at)] // 3
        sample = deviation.first[gone]
        deviation.first[gone] = -1
        deviation.error[gone] = 0.0
        while sample >= 0:
            then = deviation.after[sample]
            deviation.after[sample] = deviation.first[stays]
            deviation.first[stays] = sample
            sample = then


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
    position, vertex = surface.position, surface.vertex
    # unhook all samples of the faces around the vertex into one list
    first = surface.corner_at[centre]
    pending, at = -1, first
    while True:
        face = at // 3
        sample = deviation.first[face]
        deviation.first[face] = -1
        deviation.error[face] = 0.0
        while sample >= 0:
            then = deviation.after[sample]
            deviation.after[sample] = pending
            deviation.pair[sample] = at
            pending, sample = sample, then
        at = surface.swing[at]
        if at == first:
            break
    # the ring may be larger than the scratch, so each sample walks around the vertex by itself,
    # from the face that it was in, where most are still
    while pending >= 0:
        sample, pending = pending, deviation.after[pending]
        x, y, z = (
            deviation.point[sample, 0],
            deviation.point[sample, 1],
            deviation.point[sample, 2],
        )
        at = deviation.pair[sample]
        chosen, depth, start = at, -np.inf, at
        while True:
            one, two = vertex[following(at)], vertex[preceding(at)]
            least = min(
                _side(position, centre, one, x, y, z), _side(position, two, centre, x, y, z)
            )
            if least > depth:
                chosen, depth = at, least
            if least >= 0.0:
                break
            at = surface.swing[at]
            if at == start:
                break
        face = chosen // 3
        deviation.after[sample] = deviation.first[face]
        deviation.first[face] = sample
    at = first
    while True:
        _sum_errors(deviation, surface, at)
        at = surface.swing[at]
        if at == first:
            break


@leaf_kernel
def _sum_errors(deviation: Deviation, surface: Surface, at: int) -> None:
    """Sum the errors of the samples in the face of a corner."""
    total = 0.0
    sample = deviation.first[at // 3]
    if sample >= 0:
        _write_face_plane(deviation, surface, at)
    while sample >= 0:
        total += _share(deviation, sample, 0)
        sample = deviation.after[sample]
    deviation.error[at // 3] = total


@leaf_kernel
def _side(position: FloatArray, one: int, two: int, x: float, y: float, z: float) -> float:
    """(one × two)·(x, y, z): on which side of the plane through the centre and an edge it lies."""
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
    return x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)


@leaf_kernel
def _write_face_plane(deviation: Deviation, surface: Surface, at: int) -> None:
    """Write N of the face of a corner as that of the only one in question."""
    position, vertex, plane = surface.position, surface.vertex, deviation.pair_plane
    centre, one, two = vertex[at], vertex[following(at)], vertex[preceding(at)]
    x, y, z = position[centre, 0], position[centre, 1], position[centre, 2]
    ux, uy, uz = position[one, 0] - x, position[one, 1] - y, position[one, 2] - z
    vx, vy, vz = position[two, 0] - x, position[two, 1] - y, position[two, 2] - z
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    determinant = nx * x + ny * y + nz * z
    scale = 1.0 / determinant if determinant > 0.0 else 0.0
    plane[0, 6], plane[0, 7], plane[0, 8] = scale * nx, scale * ny, scale * nz


@leaf_kernel
def _share(deviation: Deviation, sample: int, pair: int) -> float:
    """What a sample contributes if it is in a face around the place: w |1 − t³|."""
    plane, point = deviation.pair_plane, deviation.point
    inverse = (
        plane[pair, 6] * point[sample, 0]
        + plane[pair, 7] * point[sample, 1]
        + plane[pair, 8] * point[sample, 2]
    )
    t = 1.0 / inverse
    share = abs(1.0 - t * t * t) if inverse > 0.0 else LARGEST_SHARE
    return deviation.weight[sample] * min(share, LARGEST_SHARE)
