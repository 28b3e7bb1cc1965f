"""How a collapse or a move changes the deviation from a reference: mismatch by samples.

A collapse, or a move of a vertex, changes only the faces around it, hence only the sum over the
samples in these faces. The faces that would surround a vertex at some place are written to
`pair_plane`; samples find the one that they would be in by comparing them with the planes through
the centre and the new edges.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.samples import LARGEST_RING, LARGEST_SHARE, Deviation
from gamutcore.decimation.star import Surface
from gamutcore.decimation.symmetric import adjugate
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "change_by_collapse",
    "change_by_move",
    "deviation_around",
    "shortness",
    "step_towards_reference",
]

SOFTNESS = 1.0
"""Part of the mean residual below which a residual counts as that: keeps the weights 1 ÷ |e| of
iteratively reweighted least squares finite (Lawson 1961). With less of it the few samples next to
the present surface hold it where it is: 1e-3 instead of 1 is a tenth less accurate on spheres."""

FLATNESS = 1e-9
"""Weight of area times edge length in an edge's error: on flat sides, where no collapse changes the
deviation, it keeps vertices from merging into a few hubs; elsewhere it weighs nothing."""

PULL = 1e-5
"""Weight of staying in place in the solve for a move, as a part of the normal equations' trace; the
samples say little about moves along a flat surface, but what they say of curved ones is worth much:
1e-2 instead is a tenth less accurate."""


@inlined_kernel
def _write_pair(
    deviation: Deviation, position: FloatArray, one: int, two: int, place: FloatArray
) -> None:
    """Append the face (place, one, two) to the faces around a place."""
    index = deviation.counts[0]
    deviation.counts[0] += 1
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
    plane[index, 12] = scale * np.sqrt(nx * nx + ny * ny + nz * nz)
    plane[index, 13] = 1.0 / plane[index, 12]


@inlined_kernel
def _write_face(deviation: Deviation, face: int, pair: int) -> None:
    index = deviation.counts[1]
    deviation.counts[1] += 1
    deviation.face[index, 0], deviation.face[index, 1] = face, pair


@inlined_kernel
def _pair_of(deviation: Deviation, x: float, y: float, z: float, guess: int) -> int:
    """Face around the place whose cone a point is in, or is least outside of."""
    plane = deviation.pair_plane
    count = deviation.counts[0]
    nearest, depth = guess, -np.inf
    index, turn = guess, 0
    for _ in range(count):
        one = plane[index, 0] * x + plane[index, 1] * y + plane[index, 2] * z
        two = plane[index, 3] * x + plane[index, 4] * y + plane[index, 5] * z
        least = min(one, two)
        if least >= 0.0:
            return index
        if least > depth:
            nearest, depth = index, least
        # around the place, to the side that it is outside of
        if turn == 0:
            turn = 1 if two < one else -1
        index += turn
        if index == count:
            index = 0
        elif index < 0:
            index = count - 1
    return nearest


@inlined_kernel
def _write_sides(deviation: Deviation, home: int, begin: int, asked: int, count: int) -> None:
    """Write how deep in the cone of a face around the place samples are, and N·q.

    Nothing here depends on the sample before, so that several are computed at a time.
    """
    plane, side, inverse = deviation.pair_plane, deviation.side, deviation.inverse
    px, py, pz = plane[home, 0], plane[home, 1], plane[home, 2]
    qx, qy, qz = plane[home, 3], plane[home, 4], plane[home, 5]
    nx, ny, nz = plane[home, 6], plane[home, 7], plane[home, 8]
    # numbers without a sign: numba lets negative ones count from the end, one by one
    source, target = np.uint64(begin), np.uint64(asked)
    for index in range(count):
        sample = source + np.uint64(index)
        x, y, z = deviation.x[sample], deviation.y[sample], deviation.z[sample]
        left, right = px * x + py * y + pz * z, qx * x + qy * y + qz * z
        side[target + np.uint64(index)] = left if left < right else right
        inverse[target + np.uint64(index)] = nx * x + ny * y + nz * z


@inlined_kernel
def _error_around_place(deviation: Deviation) -> float:
    """Sum over the samples of the faces in question as if the faces around the place were there."""
    plane, pair_of, inverses = deviation.pair_plane, deviation.pair, deviation.inverse
    total, distances, areas, asked = 0.0, 0.0, 0.0, 0
    for index in range(deviation.counts[1]):
        face, home = deviation.face[index, 0], deviation.face[index, 1]
        begin = deviation.begin[face]
        count = deviation.end[face] - begin
        if home == deviation.counts[0]:
            home = 0
        _write_sides(deviation, home, begin, asked, count)
        for ahead in range(count):
            sample, number = np.uint64(begin + ahead), np.uint64(asked + ahead)
            pair = home
            if deviation.side[number] < 0.0:
                x, y, z = deviation.x[sample], deviation.y[sample], deviation.z[sample]
                pair = _pair_of(deviation, x, y, z, home)
                inverses[number] = plane[pair, 6] * x + plane[pair, 7] * y + plane[pair, 8] * z
            pair_of[number] = pair
            inverse, weight = inverses[number], deviation.weight[sample]
            share = LARGEST_SHARE
            if inverse > 0.0:
                t = 1.0 / inverse
                share = min(abs(1.0 - t * t * t), LARGEST_SHARE)
                distances += weight * abs(1.0 - t)
                areas += weight * t * plane[pair, 12]
            total += weight * share
        asked += count
    deviation.residual[0], deviation.residual[1] = distances, areas
    return total


@inlined_kernel
def deviation_around(deviation: Deviation) -> float:
    """Deviation of the faces that the last change was asked for, as they are now."""
    total = 0.0
    for index in range(deviation.counts[1]):
        total += deviation.error[deviation.face[index, 0]]
    return total


@leaf_kernel
def _load_edge(deviation: Deviation, surface: Surface, corner: int, place: FloatArray) -> bool:
    """Write the faces around an edge, and those that would surround a place instead."""
    vertex = surface.vertex
    one, two = vertex[following(corner)], vertex[preceding(corner)]
    deviation.residual[0] = 0.0
    # the faces around the edge; those around the place are two less
    if surface.degree[one] + surface.degree[two] - 2 > LARGEST_RING:
        return False
    deviation.counts[0] = deviation.counts[1] = 0
    # from the face that vanishes on one side of the edge around one end to that on the other side,
    # and from there around the other end: in this order the pairs go around the place
    for end in range(2):
        at = following(corner if end == 0 else surface.opposite[corner])
        _write_face(deviation, at // 3, deviation.counts[0])
        last = preceding(surface.opposite[corner] if end == 0 else corner)
        at = surface.swing[at]
        while at != last:
            start, stop = vertex[following(at)], vertex[preceding(at)]
            _write_face(deviation, at // 3, deviation.counts[0])
            _write_pair(deviation, surface.position, start, stop, place)
            at = surface.swing[at]
    return True


@leaf_kernel
def _load_vertex(deviation: Deviation, surface: Surface, centre: int, place: FloatArray) -> bool:
    """Write the faces around a vertex, and what they would be if it were at a place."""
    vertex = surface.vertex
    deviation.residual[0] = 0.0
    if surface.degree[centre] > LARGEST_RING:
        return False
    deviation.counts[0] = deviation.counts[1] = 0
    first = surface.corner_at[centre]
    at = first
    while True:
        one, two = vertex[following(at)], vertex[preceding(at)]
        _write_face(deviation, at // 3, deviation.counts[0])
        _write_pair(deviation, surface.position, one, two, place)
        at = surface.swing[at]
        if at == first:
            break
    return True


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
def shortness(deviation: Deviation, surface: Surface, corner: int) -> float:
    """What makes shorter edges come first where the last change asked for makes no difference.

    Parameters
    ----------
    deviation : Deviation
        As `change_by_collapse` left it.
    surface : Surface
    corner : int
        One of the two corners that face the edge.

    Returns
    -------
    float
        In the unit of the change.
    """
    position, squared = surface.position, 0.0
    one, two = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    for axis in range(3):
        difference = position[one, axis] - position[two, axis]
        squared += difference * difference
    return FLATNESS * deviation.residual[1] * np.sqrt(squared)


@leaf_kernel
def change_by_move(deviation: Deviation, surface: Surface, vertex: int, place: FloatArray) -> float:
    """Change of the deviation if a vertex is moved; as `change_by_collapse`."""
    if not _load_vertex(deviation, surface, vertex, place):
        return np.inf
    return _error_around_place(deviation) - deviation_around(deviation)


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
    plane, sums, pairs = deviation.pair_plane, deviation.pair_sum, deviation.counts[0]
    if not deviation.residual[0] > 0.0 or max(pairs, deviation.counts[1]) > LARGEST_RING:
        return False
    soft = SOFTNESS * deviation.residual[0] / deviation.residual[1]
    for pair in range(pairs):
        sums[pair, 0] = sums[pair, 1] = 0.0
    asked = 0
    for index in range(deviation.counts[1]):
        face = deviation.face[index, 0]
        begin = deviation.begin[face]
        for ahead in range(deviation.end[face] - begin):
            sample, number = np.uint64(begin + ahead), np.uint64(asked + ahead)
            inverse = deviation.inverse[number]
            if inverse > 0.0:
                pair = np.uint64(deviation.pair[number])
                e = (inverse - 1.0) * plane[pair, 13]
                size = max(abs(e), soft)
                # 1 ÷ both, for there is time for one division only
                reciprocal = 1.0 / (inverse * size)
                part = (
                    plane[pair, 9] * deviation.x[sample]
                    + plane[pair, 10] * deviation.y[sample]
                    + plane[pair, 11] * deviation.z[sample]
                ) * (reciprocal * size)
                weight = deviation.weight[sample] * part * plane[pair, 12] * reciprocal
                sums[pair, 0] += weight * part
                sums[pair, 1] += weight * e
        asked += deviation.end[face] - begin
    a00, a01, a02, a11, a12, a22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    b0, b1, b2 = 0.0, 0.0, 0.0
    for pair in range(pairs):
        distance = plane[pair, 13]
        nx, ny, nz = plane[pair, 6] * distance, plane[pair, 7] * distance, plane[pair, 8] * distance
        square, pulled = sums[pair, 0], sums[pair, 1]
        if not square > 0.0:
            continue
        a00 += square * nx * nx
        a01 += square * nx * ny
        a02 += square * nx * nz
        a11 += square * ny * ny
        a12 += square * ny * nz
        a22 += square * nz * nz
        b0 += pulled * nx
        b1 += pulled * ny
        b2 += pulled * nz
    pull = PULL * (a00 + a11 + a22)
    i00, i01, i02, i11, i12, i22, determinant = adjugate(
        a00 + pull, a01, a02, a11 + pull, a12, a22 + pull
    )
    if not determinant > 0.0:
        return False
    better[0] = place[0] + (i00 * b0 + i01 * b1 + i02 * b2) / determinant
    better[1] = place[1] + (i01 * b0 + i11 * b1 + i12 * b2) / determinant
    better[2] = place[2] + (i02 * b0 + i12 * b1 + i22 * b2) / determinant
    return True
