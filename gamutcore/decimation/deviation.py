"""How far the surface at hand deviates from a reference: mismatch by samples, kept up to date.

Every sample is a point of the reference surface that stands for a part of its volume. All surfaces
are star-shaped about the centre, so a sample lies in the cone of exactly one face of the surface at
hand, and what the two disagree about in its direction is w |1 − t³|, w being its share of the
reference's volume (the cone between the centre and its part of the surface) and t the surface's
radius there ÷ its own. The sum over all samples is the volume of the symmetric difference. A
collapse, or a move of a vertex, changes only the faces around it, hence only the sum over the
samples in these faces.

Each face has a linked list of its samples. The faces that would surround a vertex at some place are
written to `pair_plane`; samples pass from the old faces to the new ones by comparing them with the
planes through the centre and the new edges.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.corner_table import following, preceding, swung
from gamutcore.decimation.star import Surface
from gamutcore.kernels import kernel, leaf_kernel

__all__ = [
    "Deviation",
    "change_by_collapse",
    "change_by_move",
    "deviation_around",
    "hand_over_samples",
    "no_deviation",
    "redistribute_samples",
    "start_at_surface",
    "start_at_vertices",
    "step_towards_reference",
]

LARGEST_RING = 256
"""Rings with more faces are not evaluated: with so many the error of their edge would not be the
least."""

LARGEST_SHARE = 8.0
"""Bound of |1 − t³|: the surface at hand may reach far out where a place is not valid anyway."""

SOFTNESS = 1e-3
"""Part of the mean residual below which a residual counts as that: keeps the weights 1 ÷ |e| of
iteratively reweighted least squares finite (Lawson 1961)."""

PULL = 1e-2
"""Weight of staying in place in the solve for a move, as a part of the normal equations' trace; the
samples say little about moves along a flat surface."""


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
    pair_plane : (LARGEST_RING, 12) float64
        Scratch, for each face (x, a, b) around a place x: x × a and b × x, between which the cone
        of the face lies, N such that N·p = 1 on the face, and a × b ÷ det(x, a, b).
    face : (LARGEST_RING,) int32
        Scratch: the faces whose samples are in question.
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
        pair_plane=np.empty((LARGEST_RING, 12)),
        face=np.empty(LARGEST_RING, np.int32),
        counts=np.zeros(3, np.int32),
        residual=np.zeros(2),
    )


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


@kernel
def start_at_vertices(deviation: Deviation, surface: Surface) -> None:
    """Take the surface as the reference, and its vertices as the samples.

    A vertex stands for a third of the cones over its faces.

    Parameters
    ----------
    deviation : Deviation
        Without samples, with room for all vertices of the surface.
    surface : Surface
        Before its first collapse.
    """
    vertex, position = surface.vertex, surface.position
    share = np.zeros(len(position))
    for face in range(vertex.size // 3):
        one, two, three = vertex[3 * face], vertex[3 * face + 1], vertex[3 * face + 2]
        third = _six_volumes(position, one, two, three) / 3.0
        share[one] += third
        share[two] += third
        share[three] += third
    for index in range(len(position)):
        x, y, z = position[index, 0], position[index, 1], position[index, 2]
        _add_sample(deviation, surface.corner_at[index] // 3, x, y, z, share[index])


@kernel
def start_at_surface(deviation: Deviation, surface: Surface) -> None:
    """Take the surface as the reference, and points on its faces as the samples.

    Each face has the four points of the quadrature rule of degree 3 with positive weights that
    includes none of the vertices would need six; here it is the three midpoints between centroid
    and corner and the centroid itself, each standing for a quarter of the cone.

    Parameters
    ----------
    deviation : Deviation
        Without samples, with room for four for each face that is left.
    surface : Surface
        At any level.
    """
    vertex, position = surface.vertex, surface.position
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
            quarter = _six_volumes(position, one, two, three) / 4.0
            cx = (position[one, 0] + position[two, 0] + position[three, 0]) / 3.0
            cy = (position[one, 1] + position[two, 1] + position[three, 1]) / 3.0
            cz = (position[one, 2] + position[two, 2] + position[three, 2]) / 3.0
            _add_sample(deviation, at // 3, cx, cy, cz, quarter)
            for end in (one, two, three):
                x = 0.5 * (cx + position[end, 0])
                y = 0.5 * (cy + position[end, 1])
                z = 0.5 * (cz + position[end, 2])
                _add_sample(deviation, at // 3, x, y, z, quarter)


@leaf_kernel
def _write_pair(
    deviation: Deviation, position: FloatArray, one: int, two: int, place: FloatArray
) -> None:
    """Append the face (place, one, two) to the faces around a place."""
    index = deviation.counts[0]
    deviation.counts[0] += 1
    if index >= LARGEST_RING:
        return
    plane = deviation.pair_plane
    x, y, z = place[0], place[1], place[2]
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
    plane[index, 0], plane[index, 1], plane[index, 2] = (
        y * az - z * ay,
        z * ax - x * az,
        x * ay - y * ax,
    )
    plane[index, 3], plane[index, 4], plane[index, 5] = (
        by * z - bz * y,
        bz * x - bx * z,
        bx * y - by * x,
    )
    ux, uy, uz = ax - x, ay - y, az - z
    vx, vy, vz = bx - x, by - y, bz - z
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    determinant = nx * x + ny * y + nz * z
    scale = 1.0 / determinant if determinant > 0.0 else 0.0
    plane[index, 6], plane[index, 7], plane[index, 8] = scale * nx, scale * ny, scale * nz
    plane[index, 9] = scale * (ay * bz - az * by)
    plane[index, 10] = scale * (az * bx - ax * bz)
    plane[index, 11] = scale * (ax * by - ay * bx)


@leaf_kernel
def _write_face(deviation: Deviation, face: int) -> None:
    index = deviation.counts[1]
    deviation.counts[1] += 1
    if index < LARGEST_RING:
        deviation.face[index] = face


@leaf_kernel
def _pair_of(deviation: Deviation, sample: int, guess: int) -> int:
    """Face around the place whose cone a sample is in, or is least outside of."""
    plane, point = deviation.pair_plane, deviation.point
    x, y, z = point[sample, 0], point[sample, 1], point[sample, 2]
    count = deviation.counts[0]
    nearest, depth = guess, -np.inf
    index = guess
    for _ in range(count):
        one = plane[index, 0] * x + plane[index, 1] * y + plane[index, 2] * z
        two = plane[index, 3] * x + plane[index, 4] * y + plane[index, 5] * z
        least = min(one, two)
        if least >= 0.0:
            return index
        if least > depth:
            nearest, depth = index, least
        index = index + 1 if index + 1 < count else 0
    return nearest


@leaf_kernel
def _share(deviation: Deviation, sample: int, pair: int) -> float:
    """What a sample contributes if it is in a face around the place: w |1 − t³|."""
    plane, point = deviation.pair_plane, deviation.point
    inverse = (
        plane[pair, 6] * point[sample, 0]
        + plane[pair, 7] * point[sample, 1]
        + plane[pair, 8] * point[sample, 2]
    )
    cube = inverse * inverse * inverse
    # |1 − t³| = |s³ − 1| ÷ s³ with s = 1 ÷ t
    share = abs(cube - 1.0) / cube if cube > 0.0 else LARGEST_SHARE
    return deviation.weight[sample] * min(share, LARGEST_SHARE)


@leaf_kernel
def _error_around_place(deviation: Deviation) -> float:
    """Sum over the samples of the faces in question as if the faces around the place were there."""
    plane, point, weight = deviation.pair_plane, deviation.point, deviation.weight
    total, pair, distances, areas = 0.0, 0, 0.0, 0.0
    for index in range(deviation.counts[1]):
        sample = deviation.first[deviation.face[index]]
        while sample >= 0:
            pair = _pair_of(deviation, sample, pair)
            nx, ny, nz = plane[pair, 6], plane[pair, 7], plane[pair, 8]
            inverse = nx * point[sample, 0] + ny * point[sample, 1] + nz * point[sample, 2]
            share = LARGEST_SHARE
            if inverse > 0.0:
                cube = inverse * inverse * inverse
                # |1 − t³| = |s³ − 1| ÷ s³ with s = 1 ÷ t
                share = min(abs(cube - 1.0) / cube, LARGEST_SHARE)
                distances += weight[sample] * abs(inverse - 1.0) / inverse
                areas += weight[sample] * np.sqrt(nx * nx + ny * ny + nz * nz) / inverse
            total += weight[sample] * share
            sample = deviation.after[sample]
    deviation.residual[0], deviation.residual[1] = distances, areas
    return total


@leaf_kernel
def deviation_around(deviation: Deviation) -> float:
    """Deviation of the faces that the last change was asked for, as they are now."""
    total = 0.0
    for index in range(deviation.counts[1]):
        total += deviation.error[deviation.face[index]]
    return total


@leaf_kernel
def _load_edge(deviation: Deviation, surface: Surface, corner: int, place: FloatArray) -> bool:
    """Write the faces around an edge, and those that would surround a place instead."""
    vertex = surface.vertex
    one, two = vertex[following(corner)], vertex[preceding(corner)]
    deviation.counts[0] = deviation.counts[1] = 0
    for end in range(2):
        centre, other = (one, two) if end == 0 else (two, one)
        first = surface.corner_at[centre]
        at = first
        while True:
            start, stop = vertex[following(at)], vertex[preceding(at)]
            if start != other and stop != other:
                _write_pair(deviation, surface.position, start, stop, place)
                _write_face(deviation, at // 3)
            elif end == 0:
                _write_face(deviation, at // 3)
            at = swung(surface.opposite, at)
            if at == first:
                break
    return max(deviation.counts[0], deviation.counts[1]) <= LARGEST_RING


@leaf_kernel
def _load_vertex(deviation: Deviation, surface: Surface, centre: int, place: FloatArray) -> bool:
    """Write the faces around a vertex, and what they would be if it were at a place."""
    vertex = surface.vertex
    deviation.counts[0] = deviation.counts[1] = 0
    first = surface.corner_at[centre]
    at = first
    while True:
        one, two = vertex[following(at)], vertex[preceding(at)]
        _write_pair(deviation, surface.position, one, two, place)
        _write_face(deviation, at // 3)
        at = swung(surface.opposite, at)
        if at == first:
            break
    return deviation.counts[0] <= LARGEST_RING


@leaf_kernel
def change_by_collapse(
    deviation: Deviation, surface: Surface, corner: int, place: FloatArray
) -> float:
    """Change of the deviation if an edge is replaced by a vertex; infinite for very large rings.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
    corner : int
        One of the two corners that face the edge.
    place : (3,) float64
        Where the vertex would be, relative to the centre.

    Returns
    -------
    float
        In six times the volume's unit; negative if the surface comes closer to the reference.
    """
    if not _load_edge(deviation, surface, corner, place):
        return np.inf
    return _error_around_place(deviation) - deviation_around(deviation)


@leaf_kernel
def change_by_move(
    deviation: Deviation, surface: Surface, vertex: int, place: FloatArray
) -> float:
    """Change of the deviation if a vertex is moved; as `change_by_collapse`."""
    if not _load_vertex(deviation, surface, vertex, place):
        return np.inf
    return _error_around_place(deviation) - deviation_around(deviation)


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
    position, vertex, opposite = surface.position, surface.vertex, surface.opposite
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
            pending, sample = sample, then
        at = swung(opposite, at)
        if at == first:
            break
    # the ring may be larger than the scratch, so each sample walks around the vertex by itself
    while pending >= 0:
        sample, pending = pending, deviation.after[pending]
        x, y, z = (
            deviation.point[sample, 0],
            deviation.point[sample, 1],
            deviation.point[sample, 2],
        )
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
            at = swung(opposite, at)
            if at == start:
                break
        at = chosen
        face = chosen // 3
        deviation.after[sample] = deviation.first[face]
        deviation.first[face] = sample
    at = first
    while True:
        face = at // 3
        deviation.counts[0] = 0
        if deviation.first[face] >= 0:
            _write_pair_at_vertex(deviation, position, centre, surface, at)
        total = 0.0
        sample = deviation.first[face]
        while sample >= 0:
            total += _share(deviation, sample, 0)
            sample = deviation.after[sample]
        deviation.error[face] = total
        at = swung(opposite, at)
        if at == first:
            break


@leaf_kernel
def _side(position: FloatArray, one: int, two: int, x: float, y: float, z: float) -> float:
    """(one × two)·(x, y, z): on which side of the plane through the centre and an edge it lies."""
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
    return x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)


@leaf_kernel
def _write_pair_at_vertex(
    deviation: Deviation, position: FloatArray, centre: int, surface: Surface, at: int
) -> None:
    """Write the face of a corner as the only one around its vertex."""
    one, two = surface.vertex[following(at)], surface.vertex[preceding(at)]
    plane = deviation.pair_plane
    deviation.counts[0] = 1
    x, y, z = position[centre, 0], position[centre, 1], position[centre, 2]
    ux, uy, uz = position[one, 0] - x, position[one, 1] - y, position[one, 2] - z
    vx, vy, vz = position[two, 0] - x, position[two, 1] - y, position[two, 2] - z
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    determinant = nx * x + ny * y + nz * z
    scale = 1.0 / determinant if determinant > 0.0 else 0.0
    plane[0, 6], plane[0, 7], plane[0, 8] = scale * nx, scale * ny, scale * nz


@leaf_kernel
def step_towards_reference(deviation: Deviation, place: FloatArray, better: FloatArray) -> bool:
    """Write where the vertex should go that a change was asked for, to first order.

    A move δ of the vertex shifts the surface at a sample along the normal n of its face by λ n·δ, λ
    being the sample's barycentric coordinate for the vertex. δ minimises Σ ω |e − λ n·δ| over the
    samples, e being their distances from the faces' planes and ω the area that they stand for, by a
    step of iteratively reweighted least squares.

    Parameters
    ----------
    deviation : Deviation
        As the last `change_by_...` left it.
    place : (3,) float64
        The place that it was asked for.
    better : (3,) float64
        Receives the position.

    Returns
    -------
    bool
        False if the samples give no direction.
    """
    plane, point = deviation.pair_plane, deviation.point
    if not deviation.residual[0] > 0.0:
        return False
    soft = SOFTNESS * deviation.residual[0] / deviation.residual[1]
    a00, a01, a02, a11, a12, a22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    b0, b1, b2 = 0.0, 0.0, 0.0
    pair = 0
    for index in range(deviation.counts[1]):
        sample = deviation.first[deviation.face[index]]
        while sample >= 0:
            pair = _pair_of(deviation, sample, pair)
            x, y, z = point[sample, 0], point[sample, 1], point[sample, 2]
            nx, ny, nz = plane[pair, 6], plane[pair, 7], plane[pair, 8]
            inverse = nx * x + ny * y + nz * z
            if inverse > 0.0:
                distance = 1.0 / np.sqrt(nx * nx + ny * ny + nz * nz)
                nx, ny, nz = nx * distance, ny * distance, nz * distance
                e = (inverse - 1.0) * distance
                part = (
                    plane[pair, 9] * x + plane[pair, 10] * y + plane[pair, 11] * z
                ) / inverse
                weight = (
                    deviation.weight[sample] * part / (inverse * distance * max(abs(e), soft))
                )
                square = weight * part
                a00 += square * nx * nx
                a01 += square * nx * ny
                a02 += square * nx * nz
                a11 += square * ny * ny
                a12 += square * ny * nz
                a22 += square * nz * nz
                b0 += weight * e * nx
                b1 += weight * e * ny
                b2 += weight * e * nz
            sample = deviation.after[sample]
    pull = PULL * (a00 + a11 + a22)
    a, b, c, d, e, f = a00 + pull, a01, a02, a11 + pull, a12, a22 + pull
    i00, i01, i02 = d * f - e * e, c * e - b * f, b * e - c * d
    i11, i12, i22 = a * f - c * c, b * c - a * e, a * d - b * b
    determinant = a * i00 + b * i01 + c * i02
    if not determinant > 0.0:
        return False
    better[0] = place[0] + (i00 * b0 + i01 * b1 + i02 * b2) / determinant
    better[1] = place[1] + (i01 * b0 + i11 * b1 + i12 * b2) / determinant
    better[2] = place[2] + (i02 * b0 + i12 * b1 + i22 * b2) / determinant
    return True
