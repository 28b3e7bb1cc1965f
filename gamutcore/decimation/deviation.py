"""Deviation of a surface from a reference by samples, and its change by a collapse or a move.

A sample is a point of the reference that represents a part of its volume. All surfaces are
star-shaped about the centre, so a sample lies in the cone of exactly one face of the current
surface. In the direction of the sample the two surfaces differ by w |1 − t³|. Here w is the
sample's share of the reference volume, and t the radius of the surface divided by the radius of the
sample. The sum over all samples approximates the volume of the symmetric difference.

Samples represent nearly equal shares. With one sample per face, the few samples of the large faces
would carry most of the sum: it came out up to a half below the mismatch of the chosen levels.

A collapse, or a move of a vertex, changes only the faces around it, hence only the sum over the
samples in these faces. A query collects the samples. `change_at` writes the faces that would
surround the vertex at some position. It finds the face of each sample by comparing the sample with
the planes through the centre and the new edges. Most samples stay in their face, so each is
compared with its present face first.

A step of a vertex then minimises the deviation by one step of iteratively reweighted least squares.
It uses the results of the last `change_at`: the samples around a point and their faces.

Data layout: one array per coordinate, with the samples of a face next to each other. A loop over
them reads consecutive memory and compiles to vector instructions. When faces exchange samples, all
samples involved are written behind the last ones. The arrays have two halves. When one half is
full, the samples in use move to the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.decimation.quadrics import Quadrics, shift_to_preserve_volume
from gamutcore.decimation.surface_mesh import LARGEST_LINK, SurfaceMesh, squared_length
from gamutcore.geometry import (
    Vector,
    add_outer,
    adjugate,
    cross,
    dot,
    minus,
    next_corner,
    plus,
    previous_corner,
    product,
    row,
    scaled,
    triple,
    write_row,
)
from gamutcore.kernels import inlined_kernel, leaf_kernel

SAMPLES, TOP, HALF_BEGIN, HALF_SIZE = range(4)
"""Indices into `Deviation.counts`: number of samples in use; index behind the last one, 0 while
they are not assigned to faces; first index of the half in use; length of a half."""

QUERY_PAIRS, QUERY_FACES, QUERY_SAMPLES = range(4, 7)
"""Indices into `Deviation.counts`, for the current query: number of pairs of the link; number of
faces; number of samples including the padding."""

QUERY_DISTANCE, QUERY_AREA, QUERY_WEIGHT, TOTAL_WEIGHT = range(4)
"""Indices into `Deviation.sums`. For the current query: distances of the samples from their faces,
integrated over their area; that area; the sum of their weights. For all samples: their weights."""

LANES = 8
"""Largest number of samples that one vector instruction processes."""

TOGETHER = 4
"""Number of faces that each sample is compared with in one pass."""


class Query(NamedTuple):
    """Samples around an edge or a vertex, and scratch for their faces.

    There is room for S samples on F faces.
    """

    link: IndexArray  # (LARGEST_LINK, 2) directed link, in order around the position
    # (LARGEST_LINK + TOGETHER, 10) for the face (p, a, b) of the position p and each pair:
    # p × a; N with N·q = 1 on the face; a × b ÷ det(p, a, b); |N|. The cone of the face lies
    # between its p × a and the next.
    plane: FloatArray
    face_sum: FloatArray  # (LARGEST_LINK, 8) two sums over its samples, in four parts each
    face: IndexArray  # (F + 2,) present faces; reassignment: a corner of each face involved
    x: FloatArray  # (S + LANES,) the samples in these faces
    y: FloatArray
    z: FloatArray
    weight: FloatArray
    pair: LongArray  # (S + LANES,) the pair whose face each lies in; in an assignment, a corner
    depth: FloatArray  # (S + LANES,) how deep each lies in the cone of that face
    inverse: FloatArray  # (S + LANES,) N·q of that face, the inverse of t
    norm: FloatArray  # (S + LANES,) |N| of that face
    term: FloatArray  # (S + LANES,) terms of the sums over them
    other_term: FloatArray
    third_term: FloatArray


class Deviation(NamedTuple):
    """Samples of a reference and the faces that they lie in, with room for S samples on F faces."""

    x: FloatArray  # (4 S,) the samples, relative to the centre
    y: FloatArray
    z: FloatArray
    weight: FloatArray  # (4 S,) their shares of the volume of the reference, times six
    begin: LongArray  # (F,) start and end of each face's samples in these arrays
    end: LongArray
    error: FloatArray  # (F,) sum of w |1 − t³| over the samples of a face
    cursor: LongArray  # (F,) scratch: where the next sample of a face is written
    counts: LongArray  # (7,) by `SAMPLES`, `TOP`, `HALF_BEGIN`, `HALF_SIZE` and `QUERY_…`
    sums: FloatArray  # (4,) by `QUERY_DISTANCE`, `QUERY_AREA`, `QUERY_WEIGHT`, `TOTAL_WEIGHT`
    query: Query


def empty_deviation(samples: int, faces: int) -> Deviation:
    """Return a deviation without samples, with room for `samples` samples on `faces` faces."""
    per_sample = (
        *("x", "y", "z", "weight", "depth", "inverse", "norm"),
        *("term", "other_term", "third_term"),
    )
    query = Query(
        link=np.empty((LARGEST_LINK, 2), np.int32),
        plane=np.empty((LARGEST_LINK + TOGETHER, 10)),
        face_sum=np.empty((LARGEST_LINK, 8)),
        face=np.empty(faces + 2, np.int32),
        pair=np.empty(samples + LANES, np.int64),
        **{name: np.empty(samples + LANES) for name in per_sample},
    )
    return Deviation(
        **{name: np.empty(4 * samples) for name in ("x", "y", "z", "weight")},
        begin=np.zeros(faces, np.int64),
        end=np.zeros(faces, np.int64),
        error=np.zeros(faces),
        cursor=np.zeros(faces, np.int64),
        counts=np.zeros(7, np.int64),
        sums=np.zeros(4),
        query=query,
    )


def sample_capacity(wanted: int, faces: int) -> int:
    """Upper bound of the number of samples that `take_samples` takes of `faces` faces.

    A face has one sample at least. A face of x > 1 shares has at most (x + ½)² ≤ 16/9 x samples.
    """
    return faces + 16 * wanted // 9 + 1


def deviation_on_faces(deviation: Deviation, faces: int) -> Deviation:
    """Return the same samples, not assigned to faces, for a surface of `faces` faces.

    There is room for the present samples; without samples, as much room as before.
    """
    used = int(deviation.counts[SAMPLES])
    copy = empty_deviation(used or deviation.query.x.size - LANES, faces)
    copy.counts[SAMPLES], copy.counts[HALF_SIZE] = used, 2 * used
    copy.sums[TOTAL_WEIGHT] = deviation.sums[TOTAL_WEIGHT]
    kept = np.arange(used)
    if deviation.counts[TOP] > 0:
        number = deviation.end - deviation.begin
        kept += np.repeat(deviation.begin - (np.cumsum(number) - number), number)
    for name in ("x", "y", "z", "weight"):
        getattr(copy, name)[:used] = getattr(deviation, name)[kept]
    return copy


@leaf_kernel
def _is_face(surface: SurfaceMesh, face: int) -> bool:
    """Whether a face still exists. One corner of a removed face faces a removed edge."""
    facing, edge_of = surface.corner_facing, surface.edge_of
    one, two, three = edge_of[3 * face], edge_of[3 * face + 1], edge_of[3 * face + 2]
    return min(facing[one], facing[two], facing[three]) >= 0


@leaf_kernel
def _six_volumes(surface: SurfaceMesh, face: int) -> float:
    """Six times the volume of the cone over a face; 0 for a removed face."""
    if not _is_face(surface, face):
        return 0.0
    position, vertex = surface.position, surface.vertex
    one, two, three = int(vertex[3 * face]), int(vertex[3 * face + 1]), int(vertex[3 * face + 2])
    return triple(row(position, two, 0), row(position, three, 0), row(position, one, 0))


@leaf_kernel
def _divisions(volume: float, part: float) -> int:
    """Into how many parts each side of a face is divided."""
    return max(1, int(np.rint(np.sqrt(volume / part))))


@leaf_kernel
def _add_lattice(
    deviation: Deviation, surface: SurfaceMesh, face: int, part: float, share: float, passed: float
) -> float:
    """Add the centroids of the equal triangles that a face is divided into.

    With a positive `share`, marks stand a share apart along the line of all weights, and only
    triangles with a mark are added. `passed` is the distance from the last mark to the beginning of
    the face. The result is the distance from the last mark to its end.
    """
    volume = _six_volumes(surface, face)
    divisions = _divisions(volume, part)
    weight = volume / (divisions * divisions)
    ax, ay, az = row(surface.position, surface.vertex[3 * face], 0)
    bx, by, bz = row(surface.position, surface.vertex[3 * face + 1], 0)
    cx, cy, cz = row(surface.position, surface.vertex[3 * face + 2], 0)
    for i in range(divisions):
        for j in range(divisions - i):
            for turned in range(2 if i + j < divisions - 1 else 1):
                represented = weight
                if share > 0.0:
                    passed += weight
                    if passed < share:
                        continue
                    represented = np.floor(passed / share) * share
                    passed -= represented
                u = (i + (1.0 + turned) / 3.0) / divisions
                v = (j + (1.0 + turned) / 3.0) / divisions
                w = 1.0 - u - v
                sample = deviation.counts[SAMPLES]
                deviation.counts[SAMPLES] += 1
                deviation.x[sample] = u * ax + v * bx + w * cx
                deviation.y[sample] = u * ay + v * by + w * cy
                deviation.z[sample] = u * az + v * bz + w * cz
                deviation.weight[sample] = represented
    return passed


@leaf_kernel
def take_samples(deviation: Deviation, surface: SurfaceMesh, wanted: int) -> None:
    """Make the surface the reference and take centroids of equal parts of its faces as samples.

    Parts have about 1 ÷ `wanted` of the volume. If the samples exceed the room, systematic
    resampling selects half as many as there is room for, as in `thin_samples`. `assign_samples`
    comes next.
    """
    room, faces = deviation.query.x.size - LANES, surface.vertex.size // 3
    whole, count = 0.0, 0
    for face in range(faces):
        whole += _six_volumes(surface, face)
    part = whole / wanted
    for face in range(faces):
        if _is_face(surface, face):
            count += _divisions(_six_volumes(surface, face), part) ** 2
    share = 0.0 if count <= room else whole / (room // 2)
    passed = 0.5 * share
    for face in range(faces):
        if _is_face(surface, face):
            passed = _add_lattice(deviation, surface, face, part, share, passed)
    deviation.counts[TOP], deviation.counts[HALF_SIZE] = 0, 2 * deviation.counts[SAMPLES]
    deviation.sums[TOTAL_WEIGHT] = whole


@leaf_kernel
def assign_samples(deviation: Deviation, surface: SurfaceMesh) -> None:
    """Assign samples that are in no face yet to the faces of a surface, for which there is room."""
    count, half = deviation.counts[SAMPLES], deviation.counts[HALF_SIZE]
    for face in range(deviation.cursor.size):
        deviation.cursor[face] = 0
    at = 0
    while not _is_face(surface, at // 3):
        at += 3
    for sample in range(count):
        # samples follow each other in space, so the next face is near
        at = _corner_below(surface, _point(deviation, sample), at)
        deviation.query.pair[sample] = at
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


@inlined_kernel
def _point(deviation: Deviation, sample: int) -> Vector:
    return deviation.x[sample], deviation.y[sample], deviation.z[sample]


@inlined_kernel
def _depths(surface: SurfaceMesh, corner: int, point: Vector) -> Vector:
    """Determinants of a point with a face's edges: none is negative in the cone of the face."""
    position, vertex = surface.position, surface.vertex
    a = row(position, vertex[corner], 0)
    b = row(position, vertex[next_corner(corner)], 0)
    c = row(position, vertex[previous_corner(corner)], 0)
    return triple(b, c, point), triple(c, a, point), triple(a, b, point)


@leaf_kernel
def _corner_below(surface: SurfaceMesh, point: Vector, begin: int) -> int:
    """A corner of the face whose cone contains a point, found by walking over the faces."""
    at, faces = begin, surface.vertex.size // 3
    for _ in range(faces):
        facing, second, third = _depths(surface, at, point)
        if min(facing, second, third) >= 0.0:
            return at
        if facing <= second and facing <= third:
            at = int(surface.opposite[at])
        elif second <= third:
            at = int(surface.opposite[next_corner(at)])
        else:
            at = int(surface.opposite[previous_corner(at)])
    # a walk can cycle where faces are slivers (Devillers, Pion & Teillaud 2002)
    deepest = -np.inf
    for face in range(faces):
        if _is_face(surface, face):
            facing, second, third = _depths(surface, 3 * face, point)
            depth = min(facing, second, third)
            if depth > deepest:
                at, deepest = 3 * face, depth
    return at


@leaf_kernel
def thin_samples(deviation: Deviation, surface: SurfaceMesh, most: int) -> bool:
    """Remove at least about half of the samples if there are more than `most`.

    The weights form a line, face by face, with marks at equal distances. A sample stays if a mark
    falls on its weight, and then represents its marks (systematic resampling, Kitagawa 1996). Small
    weights thereby grow to the size of the others. The result says whether samples were removed,
    which changes the errors of all edges.
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


NO_FACE = -1
"""Instead of a removed face, where there is none."""


@leaf_kernel
def reassign_samples(
    deviation: Deviation, surface: SurfaceMesh, centre: int, left: int, right: int
) -> None:
    """Assign the samples around vertex `centre` to their present faces and sum the faces' errors.

    A collapse to the vertex has removed the faces `left` and `right`, whose samples are assigned as
    well. After a move both are `NO_FACE`.
    """
    begin, end, cursor = deviation.begin, deviation.end, deviation.cursor
    corners, present = deviation.query.face, int(surface.degree[centre])
    at = int(surface.corner_at[centre])
    for number in range(present):
        corners[number] = at
        cursor[at // 3] = 0
        at = int(surface.swing[at])
    involved = present
    for gone in (left, right):
        if gone != NO_FACE:
            corners[involved] = 3 * gone
            involved += 1
    count = 0
    for number in range(involved):
        count += end[corners[number] // 3] - begin[corners[number] // 3]
    _make_room(deviation, count)
    found = 0
    for number in range(involved):
        face = int(corners[number] // 3)
        # samples of removed faces are first compared with any face around the vertex
        near = int(corners[number]) if number < present else at
        found = _find_faces(deviation, surface, near, begin[face], end[face], found)
    top = deviation.counts[TOP]
    for number in range(present):
        face = int(corners[number] // 3)
        cursor[face], top = top, top + cursor[face]
    found = 0
    for number in range(involved):
        face = int(corners[number] // 3)
        _move_to_cursors(deviation, begin[face], end[face], found)
        found += end[face] - begin[face]
    for number in range(present, involved):
        face = int(corners[number] // 3)
        end[face], deviation.error[face] = begin[face], 0.0
    top = deviation.counts[TOP]
    for number in range(present):
        face = int(corners[number] // 3)
        begin[face], end[face], top = top, cursor[face], cursor[face]
        _sum_errors(deviation, surface, int(corners[number]))
    deviation.counts[TOP] = top


@leaf_kernel
def _find_faces(
    deviation: Deviation, surface: SurfaceMesh, corner: int, begin: int, end: int, found: int
) -> int:
    """Write to `pair` the corners of faces around a vertex that samples lie in, and count them.

    Most samples lie in the face of `corner`; the others search around the vertex. `found` entries
    of `pair` are in use before. The result is the number afterwards.
    """
    position, vertex, depths = surface.position, surface.vertex, deviation.query.depth
    centre = row(position, vertex[corner], 0)
    left = cross(centre, row(position, vertex[next_corner(corner)], 0))
    right = cross(row(position, vertex[previous_corner(corner)], 0), centre)
    source, target, count = np.uint64(begin), np.uint64(found), end - begin
    for index in range(count):
        sample = source + np.uint64(index)
        point = (deviation.x[sample], deviation.y[sample], deviation.z[sample])
        depths[target + np.uint64(index)] = min(dot(point, right), dot(point, left))
    for index in range(found, found + count):
        chosen = corner
        depth = depths[index]
        if depth < 0.0:
            point = _point(deviation, begin + index - found)
            at = int(surface.swing[corner])
            while at != corner:
                _, second, third = _depths(surface, at, point)
                least = min(third, second)
                if least > depth:
                    chosen, depth = at, least
                if least >= 0.0:
                    break
                at = int(surface.swing[at])
        deviation.query.pair[index] = chosen
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
    counts[TOP] = top


@leaf_kernel
def _move_to_cursors(deviation: Deviation, begin: int, end: int, first: int) -> None:
    """Copy samples to the cursors of the faces that `pair` names, from entry `first` on."""
    for sample in range(begin, end):
        face = deviation.query.pair[first + sample - begin] // 3
        _copy_sample(deviation, sample, deviation.cursor[face])
        deviation.cursor[face] += 1


@inlined_kernel
def _copy_sample(deviation: Deviation, source: int, target: int) -> None:
    deviation.x[target] = deviation.x[source]
    deviation.y[target] = deviation.y[source]
    deviation.z[target] = deviation.z[source]
    deviation.weight[target] = deviation.weight[source]


LARGEST_SHARE = 1e12
"""Bound of |1 − t³|, which keeps sums finite where the surface is nearly edge-on."""

PENALTY_OUTSIDE = 8.0
"""Value of |1 − t³| for a sample that no face lies in front of. The position is then not valid."""


@leaf_kernel
def _sum_errors(deviation: Deviation, surface: SurfaceMesh, at: int) -> None:
    """Sum the errors of the samples in the face of a corner."""
    position, vertex = surface.position, surface.vertex
    centre = row(position, vertex[at], 0)
    one = minus(row(position, vertex[next_corner(at)], 0), centre)
    normal = cross(one, minus(row(position, vertex[previous_corner(at)], 0), centre))
    determinant = dot(normal, centre)
    normal = scaled(1.0 / determinant if determinant > 0.0 else 0.0, normal)
    total = 0.0
    for sample in range(deviation.begin[at // 3], deviation.end[at // 3]):
        inverse = dot(normal, _point(deviation, sample))
        t = 1.0 / inverse
        share = abs(1.0 - t * t * t) if inverse > 0.0 else PENALTY_OUTSIDE
        total += deviation.weight[sample] * min(share, LARGEST_SHARE)
    deviation.error[at // 3] = total


@leaf_kernel
def query_edge(deviation: Deviation, surface: SurfaceMesh, corner: int) -> bool:
    """Collect the faces around an edge, their samples, and the link of the edge.

    `corner` is one of the two that face the edge. The result is False for links of more than
    `LARGEST_LINK` pairs and for dense ones.
    """
    vertex, twin = surface.vertex, int(surface.opposite[corner])
    one, two = vertex[next_corner(corner)], vertex[previous_corner(corner)]
    deviation.sums[QUERY_DISTANCE] = 0.0
    # faces around the edge; around the new vertex there are two fewer
    if surface.degree[one] + surface.degree[two] - 2 > LARGEST_LINK:
        return False
    deviation.counts[QUERY_PAIRS] = deviation.counts[QUERY_FACES] = 0
    # Walk around one end from one removed face to the other, then around the other end. In this
    # order the pairs of the link follow each other around the new vertex.
    filled = _add_face(deviation, corner // 3, 0)
    filled = _add_star(deviation, surface, next_corner(corner), surface.degree[one] - 2, filled)
    filled = _add_face(deviation, twin // 3, filled)
    filled = _add_star(deviation, surface, next_corner(twin), surface.degree[two] - 2, filled)
    _pad_query(deviation, filled)
    return not _is_dense(deviation)


@leaf_kernel
def query_vertex(deviation: Deviation, surface: SurfaceMesh, centre: int) -> bool:
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
def _add_star(
    deviation: Deviation, surface: SurfaceMesh, corner: int, faces: int, filled: int
) -> int:
    """Add the next faces around a vertex behind a corner, with their pairs of the link."""
    for _ in range(faces):
        corner = int(surface.swing[corner])
        filled = _add_face(deviation, corner // 3, filled)
        pair = deviation.counts[QUERY_PAIRS]
        deviation.query.link[pair, 0] = surface.vertex[next_corner(corner)]
        deviation.query.link[pair, 1] = surface.vertex[previous_corner(corner)]
        deviation.counts[QUERY_PAIRS] += 1
    return filled


@inlined_kernel
def _add_face(deviation: Deviation, face: int, filled: int) -> int:
    """Add the samples of a face to the query; returns the number of samples then."""
    deviation.query.face[deviation.counts[QUERY_FACES]] = face
    deviation.counts[QUERY_FACES] += 1
    begin = deviation.begin[face]
    count = deviation.end[face] - begin
    # unsigned indices: numba lets negative ones count from the end, which prevents vectorisation
    source, target = np.uint64(begin), np.uint64(filled)
    for ahead in range(count):
        sample, number = source + np.uint64(ahead), target + np.uint64(ahead)
        deviation.query.x[number] = deviation.x[sample]
        deviation.query.y[number] = deviation.y[sample]
        deviation.query.z[number] = deviation.z[sample]
        deviation.query.weight[number] = deviation.weight[sample]
    return filled + count


@inlined_kernel
def _pad_query(deviation: Deviation, filled: int) -> None:
    """Add samples of weight zero up to a multiple of `LANES`, and sum the weights."""
    padded = (filled + LANES - 1) // LANES * LANES
    for number in range(filled, padded):
        deviation.query.x[number] = deviation.query.x[0]
        deviation.query.y[number] = deviation.query.y[0]
        deviation.query.z[number] = deviation.query.z[0]
        deviation.query.weight[number] = 0.0
    deviation.counts[QUERY_SAMPLES] = padded
    deviation.sums[QUERY_WEIGHT] = _sum_in_lanes(deviation.query.weight, padded)


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


DENSE_LINK = 16
"""A link of more pairs than this is dense if it also contains `DENSE_PART` of all samples."""

DENSE_PART = 8
"""One in so many samples. Dense links are not evaluated, because the time for one is that of a
hundred others. On bodies whose vertices all hang on two hubs, that is nearly all of the time."""


@inlined_kernel
def _is_dense(deviation: Deviation) -> bool:
    """Whether the query's link is dense, and its evaluation would take too long."""
    counts = deviation.counts
    return counts[QUERY_PAIRS] > DENSE_LINK and DENSE_PART * counts[QUERY_SAMPLES] > counts[SAMPLES]


SIDE, NORMAL, OPPOSITE, LENGTH = 0, 3, 6, 9
"""Columns of `Query.plane`: p × a (3), N (3), a × b ÷ det(p, a, b) (3), |N|."""


@leaf_kernel
def change_at(deviation: Deviation, surface: SurfaceMesh, point: FloatArray) -> float:
    """Change of the deviation if a vertex at a point replaces the queried edge or vertex.

    The result is six times a volume, negative if the surface approaches the reference. It is at
    least the enclosed volume beyond what the samples can account for.
    """
    volume = _write_planes(deviation, surface.position, point)
    _choose_faces(deviation)
    _look_up_faces(deviation)
    after = max(_sum_query(deviation), _excess(deviation, volume))
    return after - _current_deviation(deviation)


@inlined_kernel
def _write_planes(deviation: Deviation, position: FloatArray, point: FloatArray) -> float:
    """Write the planes of the faces around a point, and padding; return their volume, times six."""
    plane, pairs, volume = deviation.query.plane, deviation.counts[QUERY_PAIRS], 0.0
    p = (point[0], point[1], point[2])
    for index in range(pairs):
        a = row(position, deviation.query.link[index, 0], 0)
        b = row(position, deviation.query.link[index, 1], 0)
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
def _compare(deviation: Deviation, first: int, begins: bool, four: bool) -> None:
    """Compare all samples with the cones of four faces (`TOGETHER`) around the point, or of two.

    Consecutive faces share a plane with opposite signs, so five planes serve four cones. `begins`
    says that no faces were compared before `first`.
    """
    plane, depths, pair = deviation.query.plane, deviation.query.depth, deviation.query.pair
    xs, ys, zs = deviation.query.x, deviation.query.y, deviation.query.z
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
def _lesser(one: float, other: float) -> float:
    # compiles to the processor's minimum instruction, without a branch
    return one if one < other else other  # noqa: FURB136


@inlined_kernel
def _look_up_faces(deviation: Deviation) -> None:
    """Write N·q and |N| of the face that each sample lies in."""
    plane, xs, ys, zs = (
        deviation.query.plane,
        deviation.query.x,
        deviation.query.y,
        deviation.query.z,
    )
    for number in range(deviation.counts[QUERY_SAMPLES]):
        pair = np.uint64(deviation.query.pair[number])
        normal = (plane[pair, NORMAL], plane[pair, NORMAL + 1], plane[pair, NORMAL + 2])
        deviation.query.inverse[number] = dot(normal, (xs[number], ys[number], zs[number]))
        deviation.query.norm[number] = plane[pair, LENGTH]


@inlined_kernel
def _sum_query(deviation: Deviation) -> float:
    """Deviation of the query's samples from the faces around the point."""
    count = deviation.counts[QUERY_SAMPLES]
    weights, inverses, norms = deviation.query.weight, deviation.query.inverse, deviation.query.norm
    errors, distances, areas = (
        deviation.query.term,
        deviation.query.other_term,
        deviation.query.third_term,
    )
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


GROWTH = 2.0
"""Ratio of the volume that a link may enclose to the volume of its samples. Beyond it the enclosed
volume itself counts: where the reference is near the centre there are hardly any samples, and
nothing else would reveal that the surface grows there."""

UNSEEN = 8.0
"""Number of samples whose mean share is added to that limit: few samples give a coarse estimate."""


@inlined_kernel
def _excess(deviation: Deviation, volume: float) -> float:
    """Volume around a point beyond what the samples can account for."""
    sums, count = deviation.sums, deviation.counts[SAMPLES]
    slack = sums[TOTAL_WEIGHT] * (UNSEEN / count) if count > 0 else np.inf
    return volume - (GROWTH * sums[QUERY_WEIGHT] + slack)


@inlined_kernel
def _current_deviation(deviation: Deviation) -> float:
    """Deviation of the present faces of the query."""
    total = 0.0
    for index in range(deviation.counts[QUERY_FACES]):
        total += deviation.error[deviation.query.face[index]]
    return total


FLATNESS = 1e-9
"""Weight of area times edge length in the error of an edge. On flat sides, where no collapse
changes the deviation, it keeps vertices from merging into a few hubs."""


@leaf_kernel
def _length_penalty(deviation: Deviation, surface: SurfaceMesh, corner: int) -> float:
    """Penalty of the length of the edge just evaluated; orders edges whose collapses are free."""
    return FLATNESS * deviation.sums[QUERY_AREA] * np.sqrt(squared_length(surface, corner))


@leaf_kernel
def mismatch_error(
    deviation: Deviation, surface: SurfaceMesh, corner: int, point: FloatArray
) -> float:
    """Change of the deviation by a collapse, as six volumes; infinite for large or dense links."""
    if not query_edge(deviation, surface, corner):
        return np.inf
    return change_at(deviation, surface, point) + _length_penalty(deviation, surface, corner)


REFINEMENTS = 2
"""Largest number of steps of the position of a collapse."""


@leaf_kernel
def refine_point(
    deviation: Deviation,
    quadrics: Quadrics,
    surface: SurfaceMesh,
    corner: int,
    point: FloatArray,
    trial_point: FloatArray,
    preserves_volume: bool,
) -> float:
    """Move a position towards less deviation while that helps; return its `mismatch_error`.

    The position moves at most `REFINEMENTS` times. With `preserves_volume` it stays where the
    collapse preserves the volume.
    """
    if not query_edge(deviation, surface, corner):
        return np.inf
    least = change_at(deviation, surface, point)
    penalty = _length_penalty(deviation, surface, corner)
    for _ in range(REFINEMENTS):
        if not _step_towards_reference(deviation, point, trial_point):
            break
        if preserves_volume:
            shift_to_preserve_volume(quadrics, surface, corner, trial_point)
        change = change_at(deviation, surface, trial_point)
        if not change < least:
            break
        least = change
        point[0], point[1], point[2] = trial_point[0], trial_point[1], trial_point[2]
    return least + penalty


LEAST_GAIN = 1e-3
"""Fraction of the deviation around a vertex that a move must save."""

RELAXATION_FACTOR = 2.0
"""Length of a move, in units of the least-squares step.

Neighbours move the same way in their turn, so a step beyond the own optimum converges sooner
(successive over-relaxation).
"""


@inlined_kernel
def find_better_position(
    deviation: Deviation,
    surface: SurfaceMesh,
    vertex: int,
    point: FloatArray,
    trial_point: FloatArray,
) -> bool:
    """Write a position for a vertex that lowers the deviation; False if none was found."""
    for axis in range(3):
        point[axis] = surface.position[vertex, axis]
    if not query_vertex(deviation, surface, vertex):
        return False
    change_at(deviation, surface, point)
    if not _step_towards_reference(deviation, point, trial_point):
        return False
    present = _current_deviation(deviation)
    for axis in range(3):
        point[axis] += RELAXATION_FACTOR * (trial_point[axis] - point[axis])
    return change_at(deviation, surface, point) < -LEAST_GAIN * present


SOFTNESS = 1.0
"""Fraction of the mean residual that is the lower bound of residuals in the weights 1 ÷ |e|.

The bound keeps the weights of iteratively reweighted least squares finite (Lawson 1961). With a
small bound the few samples next to the present surface hold it in place: 10⁻³ instead of 1 is a
tenth less accurate on spheres.
"""

PULL = 1e-5
"""Weight of the present position in the solve, as a fraction of the trace of the normal equations.

The samples determine moves along a flat surface poorly and moves along a curved one well: 10⁻²
instead is a tenth less accurate.
"""


@leaf_kernel
def _step_towards_reference(deviation: Deviation, point: FloatArray, better: FloatArray) -> bool:
    """Write the position that the queried vertex should take, to first order.

    `point` is the position of the last `change_at`. Let n be the normal of a sample's face and λ
    the sample's barycentric coordinate for the vertex. A move δ shifts the surface at the sample
    along n by λ n·δ. δ minimises Σ ω |e − λ n·δ| by one step of iteratively reweighted least
    squares. Here e is the distance of a sample from the plane of its face, and ω the area that it
    represents. The result is False if the samples determine no step.
    """
    plane, sums, pairs = (
        deviation.query.plane,
        deviation.query.face_sum,
        deviation.counts[QUERY_PAIRS],
    )
    if not deviation.sums[QUERY_DISTANCE] > 0.0:
        return False
    soft = SOFTNESS * deviation.sums[QUERY_DISTANCE] / deviation.sums[QUERY_AREA]
    for around in range(pairs):
        for column in range(8):
            sums[around, column] = 0.0
    _sum_normal_equations(deviation, soft)
    matrix, right = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for around in range(pairs):
        normal = scaled(1.0 / plane[around, LENGTH], row(plane, around, NORMAL))
        square = (sums[around, 0] + sums[around, 2]) + (sums[around, 4] + sums[around, 6])
        pulled = (sums[around, 1] + sums[around, 3]) + (sums[around, 5] + sums[around, 7])
        if square > 0.0:
            matrix = add_outer(matrix, square, normal)
            right = plus(right, scaled(pulled, normal))
    inverse, determinant = adjugate(matrix, PULL * (matrix[0] + matrix[3] + matrix[5]))
    if not determinant > 0.0:
        return False
    step = product(inverse, right)
    for axis in range(3):
        better[axis] = point[axis] + step[axis] / determinant
    return True


@inlined_kernel
def _sum_normal_equations(deviation: Deviation, soft: float) -> None:
    """Sum the samples' contributions to the normal equations of a step, face by face."""
    plane, pairs, weights = deviation.query.plane, deviation.query.pair, deviation.query.weight
    inverses, norms, sums = deviation.query.inverse, deviation.query.norm, deviation.query.face_sum
    xs, ys, zs = deviation.query.x, deviation.query.y, deviation.query.z
    squares, pulls, count = (
        deviation.query.term,
        deviation.query.other_term,
        deviation.counts[QUERY_SAMPLES],
    )
    for number in range(count):
        pair = np.uint64(pairs[number])
        squares[number] = (
            plane[pair, OPPOSITE] * xs[number]
            + plane[pair, OPPOSITE + 1] * ys[number]
            + plane[pair, OPPOSITE + 2] * zs[number]
        )
    for number in range(count):
        inverse, norm = inverses[number], norms[number]
        inside = inverse > 0.0
        e = (inverse - 1.0) * (1.0 / norm)
        distance = abs(e)
        size = distance if distance > soft else soft  # noqa: FURB136
        # the reciprocal of both needs one division only
        reciprocal = 1.0 / (inverse * size)
        part = squares[number] * (reciprocal * size)
        weight = weights[number] * part * norm * reciprocal
        squares[number] = weight * part if inside else 0.0
        pulls[number] = weight * e if inside else 0.0
    # Consecutive samples mostly lie in the same face, so each addition would wait for the one
    # before. Four partial sums do not wait for each other.
    for number in range(0, count, 4):
        for lane in range(4):
            at = np.uint64(number + lane)
            pair = np.uint64(pairs[at])
            sums[pair, 2 * lane] += squares[at]
            sums[pair, 2 * lane + 1] += pulls[at]
