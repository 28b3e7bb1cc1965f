"""Change of the deviation from a reference by a collapse or a move: mismatch by samples.

A collapse, or a move of a vertex, changes only the faces around it, hence only the sum over the
samples in these faces. A query collects the samples. `change_at` writes the faces that would
surround the vertex at some position, and finds the face that each sample would lie in by comparing
it with the planes through the centre and the new edges.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.costs.samples import (
    LANES,
    LARGEST_SHARE,
    PENALTY_OUTSIDE,
    QUERY_AREA,
    QUERY_DISTANCE,
    QUERY_FACES,
    QUERY_PAIRS,
    QUERY_SAMPLES,
    QUERY_WEIGHT,
    SAMPLES,
    TOGETHER,
    TOTAL_WEIGHT,
    Deviation,
)
from gamutcore.decimation.star import LARGEST_LINK, Surface, squared_length
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "DENSE_LINK",
    "change_at",
    "current_deviation",
    "length_penalty",
    "query_edge",
    "query_vertex",
]

FLATNESS = 1e-9
"""Weight of area times edge length in the error of an edge. On flat sides, where no collapse
changes the deviation, it keeps vertices from merging into a few hubs."""

DENSE_LINK = 16
"""A link of more pairs than this is dense if it also contains `DENSE_PART` of all samples."""

DENSE_PART = 8
"""One in so many samples. Dense links are not evaluated, because the time for one is that of a
hundred others. On bodies whose vertices all hang on two hubs, that is nearly all of the time."""

GROWTH = 2.0
"""Ratio of the volume that a link may enclose to the volume of its samples. Beyond it the enclosed
volume itself counts: where the reference is near the centre there are hardly any samples, and
nothing else would reveal that the surface grows there."""

UNSEEN = 8.0
"""Number of samples whose mean share is added to that limit: few samples give a coarse estimate."""


@inlined_kernel
def _write_planes(deviation: Deviation, position: FloatArray, point: FloatArray) -> float:
    """Write the planes of the faces around a point and the padding that `_compare` needs.

    Returns six times the volume between these faces and the centre.
    """
    plane, pairs, volume = deviation.plane, deviation.counts[QUERY_PAIRS], 0.0
    x, y, z = point[0], point[1], point[2]
    for index in range(pairs):
        one, two = deviation.link[index, 0], deviation.link[index, 1]
        ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
        bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
        plane[index, 0], plane[index, 1], plane[index, 2] = (
            y * az - z * ay,
            z * ax - x * az,
            x * ay - y * ax,
        )
        ux, uy, uz = ax - x, ay - y, az - z
        vx, vy, vz = bx - x, by - y, bz - z
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        determinant = nx * x + ny * y + nz * z
        volume += determinant
        scale = 1.0 / determinant if determinant > 0.0 else 0.0
        plane[index, 3], plane[index, 4], plane[index, 5] = scale * nx, scale * ny, scale * nz
        plane[index, 6] = scale * (ay * bz - az * by)
        plane[index, 7] = scale * (az * bx - ax * bz)
        plane[index, 8] = scale * (ax * by - ay * bx)
        plane[index, 9] = scale * np.sqrt(nx * nx + ny * ny + nz * nz)
    # the last face ends where the first one begins; no sample is deep in the padding behind it
    for column in range(3):
        plane[pairs, column] = plane[0, column]
        for index in range(pairs + 1, pairs + TOGETHER):
            plane[index, column] = np.nan
    return volume


@inlined_kernel
def _add_face(deviation: Deviation, face: int, filled: int) -> int:
    """Add the samples of a face to the query; returns the number of samples then."""
    deviation.face[deviation.counts[QUERY_FACES]] = face
    deviation.counts[QUERY_FACES] += 1
    begin = deviation.begin[face]
    count = deviation.end[face] - begin
    # unsigned indices: numba lets negative ones count from the end, which prevents vectorisation
    source, target = np.uint64(begin), np.uint64(filled)
    for ahead in range(count):
        sample, number = source + np.uint64(ahead), target + np.uint64(ahead)
        deviation.query_x[number] = deviation.x[sample]
        deviation.query_y[number] = deviation.y[sample]
        deviation.query_z[number] = deviation.z[sample]
        deviation.query_weight[number] = deviation.weight[sample]
    return filled + count


@inlined_kernel
def _add_pair(deviation: Deviation, one: int, two: int) -> None:
    deviation.link[deviation.counts[QUERY_PAIRS], 0] = one
    deviation.link[deviation.counts[QUERY_PAIRS], 1] = two
    deviation.counts[QUERY_PAIRS] += 1


@inlined_kernel
def _sum_in_lanes(terms: FloatArray, count: int) -> float:
    """Sum of a multiple of `LANES` terms, in eight partial sums that do not wait for each other.

    The source fixes the order of the additions, so the result is the same on all machines.
    """
    a, b, c, d, e, f, g, h = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for number in range(0, count, 8):
        at = np.uint64(number)
        a += terms[at]
        b += terms[at + np.uint64(1)]
        c += terms[at + np.uint64(2)]
        d += terms[at + np.uint64(3)]
        e += terms[at + np.uint64(4)]
        f += terms[at + np.uint64(5)]
        g += terms[at + np.uint64(6)]
        h += terms[at + np.uint64(7)]
    return ((a + b) + (c + d)) + ((e + f) + (g + h))


@inlined_kernel
def _pad_query(deviation: Deviation, filled: int) -> None:
    """Add samples of weight zero up to a multiple of `LANES`, and sum the weights."""
    padded = (filled + LANES - 1) // LANES * LANES
    for number in range(filled, padded):
        deviation.query_x[number] = deviation.query_x[0]
        deviation.query_y[number] = deviation.query_y[0]
        deviation.query_z[number] = deviation.query_z[0]
        deviation.query_weight[number] = 0.0
    deviation.counts[QUERY_SAMPLES] = padded
    deviation.sums[QUERY_WEIGHT] = _sum_in_lanes(deviation.query_weight, padded)


@inlined_kernel
def _is_dense(deviation: Deviation) -> bool:
    """Whether the query's link is dense, and its evaluation would take too long."""
    counts = deviation.counts
    return counts[QUERY_PAIRS] > DENSE_LINK and DENSE_PART * counts[QUERY_SAMPLES] > counts[SAMPLES]


@inlined_kernel
def _row(plane: FloatArray, index: int) -> tuple[float, float, float]:
    return plane[index, 0], plane[index, 1], plane[index, 2]


@inlined_kernel
def _lesser(one: float, other: float) -> float:
    # compiles to the processor's minimum instruction, without a branch
    return one if one < other else other  # noqa: FURB136


@inlined_kernel
def _compare(deviation: Deviation, first: int, begins: bool, four: bool) -> None:
    """Compare all samples with the cones of some faces around the point.

    Consecutive faces share a plane with opposite signs, so five planes serve four cones.

    Parameters
    ----------
    deviation : Deviation
    first : int
        The first of the faces.
    begins : bool
        Whether no faces were compared before.
    four : bool
        Whether to compare with `TOGETHER` faces; otherwise with two.
    """
    plane, depths, pair = deviation.plane, deviation.depth, deviation.pair
    xs, ys, zs = deviation.query_x, deviation.query_y, deviation.query_z
    ax, ay, az = _row(plane, first)
    bx, by, bz = _row(plane, first + 1)
    cx, cy, cz = _row(plane, first + 2)
    if four:
        dx, dy, dz = _row(plane, first + 3)
        ex, ey, ez = _row(plane, first + 4)
    for number in range(deviation.counts[QUERY_SAMPLES]):
        x, y, z = xs[number], ys[number], zs[number]
        begin, second = ax * x + ay * y + az * z, bx * x + by * y + bz * z
        third = cx * x + cy * y + cz * z
        least = _lesser(begin, -second)
        if begins:
            deepest, chosen = least, first
        else:
            deepest, chosen = depths[number], pair[number]
            deeper = least > deepest
            deepest = least if deeper else deepest
            chosen = first if deeper else chosen
        least = _lesser(second, -third)
        deeper = least > deepest
        deepest = least if deeper else deepest
        chosen = first + 1 if deeper else chosen
        if four:
            fourth, fifth = dx * x + dy * y + dz * z, ex * x + ey * y + ez * z
            least = _lesser(third, -fourth)
            deeper = least > deepest
            deepest = least if deeper else deepest
            chosen = first + 2 if deeper else chosen
            least = _lesser(fourth, -fifth)
            deeper = least > deepest
            deepest = least if deeper else deepest
            chosen = first + 3 if deeper else chosen
        depths[number] = deepest
        pair[number] = chosen


@inlined_kernel
def _choose_faces(deviation: Deviation) -> None:
    """Write for each sample the face around the point whose cone it lies deepest in.

    All samples are compared with all faces. There are few faces, and without branches the loop
    processes several samples at a time.
    """
    pairs = deviation.counts[QUERY_PAIRS]
    _compare(deviation, 0, True, True)
    first = TOGETHER
    while first + TOGETHER // 2 < pairs:
        _compare(deviation, first, False, True)
        first += TOGETHER
    if first < pairs:
        _compare(deviation, first, False, False)


@inlined_kernel
def _look_up_faces(deviation: Deviation) -> None:
    """Write N·q and |N| of the face that each sample lies in."""
    plane, pairs = deviation.plane, deviation.pair
    inverses, norms = deviation.inverse, deviation.norm
    xs, ys, zs = deviation.query_x, deviation.query_y, deviation.query_z
    for number in range(deviation.counts[QUERY_SAMPLES]):
        pair = np.uint64(pairs[number])
        inverses[number] = (
            plane[pair, 3] * xs[number] + plane[pair, 4] * ys[number] + plane[pair, 5] * zs[number]
        )
        norms[number] = plane[pair, 9]


@inlined_kernel
def _sum_query(deviation: Deviation) -> float:
    """Deviation of the query's samples from the faces around the point."""
    count = deviation.counts[QUERY_SAMPLES]
    weights, inverses, norms = deviation.query_weight, deviation.inverse, deviation.norm
    errors, distances, areas = deviation.term, deviation.other_term, deviation.third_term
    # all terms first, several at a time, and then their sums
    for number in range(count):
        inverse, weight = inverses[number], weights[number]
        inside = inverse > 0.0
        t = 1.0 / inverse
        share = _lesser(abs(1.0 - t * t * t), LARGEST_SHARE)
        errors[number] = weight * (share if inside else PENALTY_OUTSIDE)
        distances[number] = weight * abs(1.0 - t) if inside else 0.0
        areas[number] = weight * t * norms[number] if inside else 0.0
    deviation.sums[QUERY_DISTANCE] = _sum_in_lanes(distances, count)
    deviation.sums[QUERY_AREA] = _sum_in_lanes(areas, count)
    return _sum_in_lanes(errors, count)


@inlined_kernel
def current_deviation(deviation: Deviation) -> float:
    """Deviation of the present faces of the query."""
    total = 0.0
    for index in range(deviation.counts[QUERY_FACES]):
        total += deviation.error[deviation.face[index]]
    return total


@leaf_kernel
def query_edge(deviation: Deviation, surface: Surface, corner: int) -> bool:
    """Collect the faces around an edge, their samples and the link of the edge.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
    corner : int
        One of the two corners that face the edge.

    Returns
    -------
    bool
        False for links of more than `LARGEST_LINK` pairs and for dense ones.
    """
    vertex, swung = surface.vertex, surface.swung
    one, two = vertex[following(corner)], vertex[preceding(corner)]
    deviation.sums[QUERY_DISTANCE] = 0.0
    # faces around the edge; around the new vertex there are two fewer
    if surface.degree[one] + surface.degree[two] - 2 > LARGEST_LINK:
        return False
    deviation.counts[QUERY_PAIRS] = deviation.counts[QUERY_FACES] = 0
    filled = 0
    twin = int(surface.opposite[corner])
    # Walk around one end from one removed face to the other, then around the other end. In this
    # order the pairs of the link follow each other around the new vertex.
    for end in range(2):
        at = following(corner if end == 0 else twin)
        filled = _add_face(deviation, at // 3, filled)
        last = preceding(twin if end == 0 else corner)
        at = int(swung[at])
        while at != last:
            filled = _add_face(deviation, at // 3, filled)
            _add_pair(deviation, int(vertex[following(at)]), int(vertex[preceding(at)]))
            at = int(swung[at])
    _pad_query(deviation, filled)
    return not _is_dense(deviation)


@leaf_kernel
def query_vertex(deviation: Deviation, surface: Surface, centre: int) -> bool:
    """Collect the faces around a vertex, their samples and its link, as `query_edge` does."""
    vertex = surface.vertex
    deviation.sums[QUERY_DISTANCE] = 0.0
    if surface.degree[centre] > LARGEST_LINK:
        return False
    deviation.counts[QUERY_PAIRS] = deviation.counts[QUERY_FACES] = 0
    filled = 0
    first = int(surface.corner_at[centre])
    at = first
    while True:
        filled = _add_face(deviation, at // 3, filled)
        _add_pair(deviation, int(vertex[following(at)]), int(vertex[preceding(at)]))
        at = int(surface.swung[at])
        if at == first:
            break
    _pad_query(deviation, filled)
    return not _is_dense(deviation)


@inlined_kernel
def _excess(deviation: Deviation, volume: float) -> float:
    """Volume around a point beyond what the samples can account for."""
    sums, count = deviation.sums, deviation.counts[SAMPLES]
    slack = sums[TOTAL_WEIGHT] * (UNSEEN / count) if count > 0 else np.inf
    return volume - (GROWTH * sums[QUERY_WEIGHT] + slack)


@leaf_kernel
def change_at(deviation: Deviation, surface: Surface, point: FloatArray) -> float:
    """Change of the deviation if a vertex at a point replaces the queried edge or vertex.

    Parameters
    ----------
    deviation : Deviation
        As `query_edge` or `query_vertex` left it.
    surface : Surface
    point : (3,) float64
        Position of the vertex, relative to the centre.

    Returns
    -------
    float
        Six times a volume; negative if the surface approaches the reference. It is at least the
        enclosed volume beyond what the samples can account for.
    """
    volume = _write_planes(deviation, surface.position, point)
    _choose_faces(deviation)
    _look_up_faces(deviation)
    after = max(_sum_query(deviation), _excess(deviation, volume))
    return after - current_deviation(deviation)


@leaf_kernel
def length_penalty(deviation: Deviation, surface: Surface, corner: int) -> float:
    """Penalty of an edge's length, which orders edges whose collapses change nothing.

    Parameters
    ----------
    deviation : Deviation
        As `change_at` left it for the edge.
    surface : Surface
    corner : int
        One of the two corners that face the edge.

    Returns
    -------
    float
        In the unit of the change.
    """
    return FLATNESS * deviation.sums[QUERY_AREA] * np.sqrt(squared_length(surface, corner))
