"""Change of the deviation from a reference by a collapse or a move: mismatch by samples.

A collapse, or a move of a vertex, changes only the faces around it, hence only the sum over the
samples in these faces. A query collects the samples. `change_at` writes the faces that would
surround the vertex at some position. It finds the face of each sample by comparing the sample with
the planes through the centre and the new edges.
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
from gamutcore.decimation.vectors import cross, dot, minus, row, scaled, write_row
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "DENSE_LINK",
    "LENGTH",
    "NORMAL",
    "OPPOSITE",
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

SIDE, NORMAL, OPPOSITE, LENGTH = 0, 3, 6, 9
"""Columns of `Deviation.plane`: p × a (3), N (3), a × b ÷ det(p, a, b) (3), |N|."""

UNSEEN = 8.0
"""Number of samples whose mean share is added to that limit: few samples give a coarse estimate."""


@inlined_kernel
def _write_planes(deviation: Deviation, position: FloatArray, point: FloatArray) -> float:
    """Write the planes of the faces around a point and the padding that `_compare` needs.

    Returns six times the volume between these faces and the centre.
    """
    plane, pairs, volume = deviation.plane, deviation.counts[QUERY_PAIRS], 0.0
    p = (point[0], point[1], point[2])
    for index in range(pairs):
        a = row(position, deviation.link[index, 0], 0)
        b = row(position, deviation.link[index, 1], 0)
        normal = cross(minus(a, p), minus(b, p))
        determinant = dot(normal, p)
        volume += determinant
        scale = 1.0 / determinant if determinant > 0.0 else 0.0
        write_row(plane, index, SIDE, cross(p, a))
        write_row(plane, index, NORMAL, scaled(scale, normal))
        write_row(plane, index, OPPOSITE, scaled(scale, cross(a, b)))
        plane[index, LENGTH] = scale * np.sqrt(dot(normal, normal))
    # the last face ends where the first one begins; no sample is deep in the padding behind it
    write_row(plane, pairs, SIDE, row(plane, 0, SIDE))
    for index in range(pairs + 1, pairs + TOGETHER):
        write_row(plane, index, SIDE, (np.nan, np.nan, np.nan))
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
def _lesser(one: float, other: float) -> float:
    # compiles to the processor's minimum instruction, without a branch
    return one if one < other else other  # noqa: FURB136


@inlined_kernel
def _compare(deviation: Deviation, first: int, begins: bool, four: bool) -> None:
    """Compare all samples with the cones of four faces (`TOGETHER`) around the point, or of two.

    Consecutive faces share a plane with opposite signs, so five planes serve four cones. `begins`
    says that no faces were compared before `first`.
    """
    plane, depths, pair = deviation.plane, deviation.depth, deviation.pair
    xs, ys, zs = deviation.query_x, deviation.query_y, deviation.query_z
    a, b, c = row(plane, first, SIDE), row(plane, first + 1, SIDE), row(plane, first + 2, SIDE)
    d, e = c, c
    if four:
        d, e = row(plane, first + 3, SIDE), row(plane, first + 4, SIDE)
    for number in range(deviation.counts[QUERY_SAMPLES]):
        point = (xs[number], ys[number], zs[number])
        second, third = dot(b, point), dot(c, point)
        least = _lesser(dot(a, point), -second)
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
            fourth = dot(d, point)
            least = _lesser(third, -fourth)
            deeper = least > deepest
            deepest = least if deeper else deepest
            chosen = first + 2 if deeper else chosen
            least = _lesser(fourth, -dot(e, point))
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
    plane, xs, ys, zs = deviation.plane, deviation.query_x, deviation.query_y, deviation.query_z
    for number in range(deviation.counts[QUERY_SAMPLES]):
        pair = np.uint64(deviation.pair[number])
        normal = (plane[pair, NORMAL], plane[pair, NORMAL + 1], plane[pair, NORMAL + 2])
        deviation.inverse[number] = dot(normal, (xs[number], ys[number], zs[number]))
        deviation.norm[number] = plane[pair, LENGTH]


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
    """Collect the faces around an edge, their samples, and the link of the edge.

    `corner` is one of the two that face the edge. The result is False for links of more than
    `LARGEST_LINK` pairs and for dense ones.
    """
    vertex, twin = surface.vertex, int(surface.opposite[corner])
    one, two = vertex[following(corner)], vertex[preceding(corner)]
    deviation.sums[QUERY_DISTANCE] = 0.0
    # faces around the edge; around the new vertex there are two fewer
    if surface.degree[one] + surface.degree[two] - 2 > LARGEST_LINK:
        return False
    deviation.counts[QUERY_PAIRS] = deviation.counts[QUERY_FACES] = 0
    # Walk around one end from one removed face to the other, then around the other end. In this
    # order the pairs of the link follow each other around the new vertex.
    filled = _add_face(deviation, corner // 3, 0)
    filled = _add_star(deviation, surface, following(corner), surface.degree[one] - 2, filled)
    filled = _add_face(deviation, twin // 3, filled)
    filled = _add_star(deviation, surface, following(twin), surface.degree[two] - 2, filled)
    _pad_query(deviation, filled)
    return not _is_dense(deviation)


@inlined_kernel
def _add_star(deviation: Deviation, surface: Surface, corner: int, faces: int, filled: int) -> int:
    """Add the next faces around a vertex behind a corner, with their pairs of the link."""
    for _ in range(faces):
        corner = int(surface.swung[corner])
        filled = _add_face(deviation, corner // 3, filled)
        pair = deviation.counts[QUERY_PAIRS]
        deviation.link[pair, 0] = surface.vertex[following(corner)]
        deviation.link[pair, 1] = surface.vertex[preceding(corner)]
        deviation.counts[QUERY_PAIRS] += 1
    return filled


@leaf_kernel
def query_vertex(deviation: Deviation, surface: Surface, centre: int) -> bool:
    """Collect the faces around a vertex, their samples and its link, as `query_edge` does."""
    deviation.sums[QUERY_DISTANCE] = 0.0
    faces = surface.degree[centre]
    if faces > LARGEST_LINK:
        return False
    deviation.counts[QUERY_PAIRS] = deviation.counts[QUERY_FACES] = 0
    filled = _add_star(deviation, surface, int(surface.corner_at[centre]), faces, 0)
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

    The result is six times a volume, negative if the surface approaches the reference. It is at
    least the enclosed volume beyond what the samples can account for.
    """
    volume = _write_planes(deviation, surface.position, point)
    _choose_faces(deviation)
    _look_up_faces(deviation)
    after = max(_sum_query(deviation), _excess(deviation, volume))
    return after - current_deviation(deviation)


@leaf_kernel
def length_penalty(deviation: Deviation, surface: Surface, corner: int) -> float:
    """Penalty of an edge's length, in the unit of `change_at`, which has just evaluated the edge.

    It orders edges whose collapses change nothing.
    """
    return FLATNESS * deviation.sums[QUERY_AREA] * np.sqrt(squared_length(surface, corner))
