"""Samples of a reference surface, each assigned to the face of the current surface that it lies in.

A sample is a point of the reference that represents a part of its volume. All surfaces are
star-shaped about the centre, so a sample lies in the cone of exactly one face of the current
surface. In the direction of the sample the two surfaces differ by w |1 − t³|. Here w is the
sample's share of the reference volume, and t the radius of the surface divided by the radius of the
sample. The sum over all samples approximates the volume of the symmetric difference.

Data layout: one array per coordinate, with the samples of a face next to each other. A loop over
them reads consecutive memory and compiles to vector instructions. When faces exchange samples, all
samples involved are written behind the last ones. The arrays have two halves. When one half is
full, the samples in use move to the other.

Samples represent nearly equal shares. With one sample per face, the few samples of the large faces
would carry most of the sum: it came out up to a half below the mismatch of the chosen levels.

A collapse, or a move of a vertex, exchanges samples only among the faces around it. Most samples
stay in their face, so each sample is compared with its present face first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.decimation.surface_mesh import LARGEST_LINK, SurfaceMesh
from gamutcore.geometry import Vector, cross, dot, following, minus, preceding, row, scaled, triple
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


class Deviation(NamedTuple):
    """Samples of a reference and the faces that they lie in; scratch for queries.

    A query asks for the samples around an edge or a vertex (module `deviation`). There is room for
    S samples on F faces.
    """

    x: FloatArray  # (4 S,) the samples, relative to the centre
    y: FloatArray
    z: FloatArray
    weight: FloatArray  # (4 S,) their shares of the volume of the reference, times six
    begin: LongArray  # (F,) start and end of each face's samples in these arrays
    end: LongArray
    error: FloatArray  # (F,) sum of w |1 − t³| over the samples of a face
    cursor: LongArray  # (F,) scratch: where the next sample of a face is written
    link: IndexArray  # (LARGEST_LINK, 2) query: directed link, in order around the position
    # (LARGEST_LINK + TOGETHER, 10) query, for the face (p, a, b) of the position p and each pair:
    # p × a; N with N·q = 1 on the face; a × b ÷ det(p, a, b); |N|. The cone of the face lies
    # between its p × a and the next.
    plane: FloatArray
    face_sum: FloatArray  # (LARGEST_LINK, 8) query: two sums over its samples, in four parts each
    face: IndexArray  # (F + 2,) query: present faces; reassignment: a corner of each face involved
    query_x: FloatArray  # (S + LANES,) query: the samples in these faces
    query_y: FloatArray
    query_z: FloatArray
    query_weight: FloatArray
    pair: LongArray  # (S + LANES,) the pair whose face each lies in; in an assignment, a corner
    depth: FloatArray  # (S + LANES,) how deep each lies in the cone of that face
    inverse: FloatArray  # (S + LANES,) N·q of that face, the inverse of t
    norm: FloatArray  # (S + LANES,) |N| of that face
    term: FloatArray  # (S + LANES,) terms of the sums over them
    other_term: FloatArray
    third_term: FloatArray
    counts: LongArray  # (7,) by `SAMPLES`, `TOP`, `HALF_BEGIN`, `HALF_SIZE` and `QUERY_…`
    sums: FloatArray  # (4,) by `QUERY_DISTANCE`, `QUERY_AREA`, `QUERY_WEIGHT`, `TOTAL_WEIGHT`


def empty_deviation(samples: int, faces: int) -> Deviation:
    """Return a deviation without samples, with room for `samples` samples on `faces` faces."""
    of_samples = {name: np.empty(4 * samples) for name in ("x", "y", "z", "weight")}
    of_query = {
        name: np.empty(samples + LANES)
        for name in ("query_x", "query_y", "query_z", "query_weight", "depth", "inverse", "norm")
    }
    terms = {name: np.empty(samples + LANES) for name in ("term", "other_term", "third_term")}
    return Deviation(
        **of_samples,
        begin=np.zeros(faces, np.int64),
        end=np.zeros(faces, np.int64),
        error=np.zeros(faces),
        cursor=np.zeros(faces, np.int64),
        link=np.empty((LARGEST_LINK, 2), np.int32),
        plane=np.empty((LARGEST_LINK + TOGETHER, 10)),
        face_sum=np.empty((LARGEST_LINK, 8)),
        face=np.empty(faces + 2, np.int32),
        **of_query,
        pair=np.empty(samples + LANES, np.int64),
        **terms,
        counts=np.zeros(7, np.int64),
        sums=np.zeros(4),
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
    copy = empty_deviation(used or deviation.query_x.size - LANES, faces)
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
    room, faces = deviation.query_x.size - LANES, surface.vertex.size // 3
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


@inlined_kernel
def _point(deviation: Deviation, sample: int) -> Vector:
    return deviation.x[sample], deviation.y[sample], deviation.z[sample]


@inlined_kernel
def _depths(surface: SurfaceMesh, corner: int, point: Vector) -> Vector:
    """Determinants of a point with a face's edges: none is negative in the cone of the face."""
    position, vertex = surface.position, surface.vertex
    a = row(position, vertex[corner], 0)
    b = row(position, vertex[following(corner)], 0)
    c = row(position, vertex[preceding(corner)], 0)
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
            at = int(surface.opposite[following(at)])
        else:
            at = int(surface.opposite[preceding(at)])
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
    corners, present = deviation.face, int(surface.degree[centre])
    at = int(surface.corner_at[centre])
    for number in range(present):
        corners[number] = at
        cursor[at // 3] = 0
        at = int(surface.swung[at])
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
    position, vertex, depths = surface.position, surface.vertex, deviation.depth
    centre = row(position, vertex[corner], 0)
    left = cross(centre, row(position, vertex[following(corner)], 0))
    right = cross(row(position, vertex[preceding(corner)], 0), centre)
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
            at = int(surface.swung[corner])
            while at != corner:
                _, second, third = _depths(surface, at, point)
                least = min(third, second)
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


LARGEST_SHARE = 1e12
"""Bound of |1 − t³|, which keeps sums finite where the surface is nearly edge-on."""

PENALTY_OUTSIDE = 8.0
"""Value of |1 − t³| for a sample that no face lies in front of. The position is then not valid."""


@leaf_kernel
def _sum_errors(deviation: Deviation, surface: SurfaceMesh, at: int) -> None:
    """Sum the errors of the samples in the face of a corner."""
    position, vertex = surface.position, surface.vertex
    centre = row(position, vertex[at], 0)
    one = minus(row(position, vertex[following(at)], 0), centre)
    normal = cross(one, minus(row(position, vertex[preceding(at)], 0), centre))
    determinant = dot(normal, centre)
    normal = scaled(1.0 / determinant if determinant > 0.0 else 0.0, normal)
    total = 0.0
    for sample in range(deviation.begin[at // 3], deviation.end[at // 3]):
        inverse = dot(normal, _point(deviation, sample))
        t = 1.0 / inverse
        share = abs(1.0 - t * t * t) if inverse > 0.0 else PENALTY_OUTSIDE
        total += deviation.weight[sample] * min(share, LARGEST_SHARE)
    deviation.error[at // 3] = total
