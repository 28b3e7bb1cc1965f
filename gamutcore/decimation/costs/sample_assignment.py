"""Assignment of samples to faces: the initial search, and updates as faces change.

A collapse, or a move of a vertex, exchanges samples only among the faces around it. Most samples
stay in their face, so each sample is compared with its present face first.
"""

from __future__ import annotations

import numpy as np

from gamutcore.corner_table import following, preceding
from gamutcore.decimation.costs.samples import (
    HALF_BEGIN,
    HALF_SIZE,
    LARGEST_SHARE,
    PENALTY_OUTSIDE,
    SAMPLES,
    TOP,
    Deviation,
    is_face,
)
from gamutcore.decimation.star import Surface
from gamutcore.decimation.vectors import Vector, cross, dot, minus, row, scaled, triple
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = ["NO_FACE", "assign_samples", "reassign_samples", "thin_samples"]

NO_FACE = -1
"""Instead of a removed face, where there is none."""


@leaf_kernel
def assign_samples(deviation: Deviation, surface: Surface) -> None:
    """Assign samples that are in no face yet to the faces of a surface, for which there is room."""
    count, half = deviation.counts[SAMPLES], deviation.counts[HALF_SIZE]
    for face in range(deviation.cursor.size):
        deviation.cursor[face] = 0
    at = 0
    while not is_face(surface, at // 3):
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
def _depths(surface: Surface, corner: int, point: Vector) -> Vector:
    """Determinants of a point with the edges that face a corner and the two following ones.

    None is negative where the point lies in the cone of the face.
    """
    position, vertex = surface.position, surface.vertex
    a = row(position, vertex[corner], 0)
    b = row(position, vertex[following(corner)], 0)
    c = row(position, vertex[preceding(corner)], 0)
    return triple(b, c, point), triple(c, a, point), triple(a, b, point)


@leaf_kernel
def _corner_below(surface: Surface, point: Vector, begin: int) -> int:
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
        if is_face(surface, face):
            facing, second, third = _depths(surface, 3 * face, point)
            depth = min(facing, second, third)
            if depth > deepest:
                at, deepest = 3 * face, depth
    return at


@leaf_kernel
def thin_samples(deviation: Deviation, surface: Surface, most: int) -> bool:
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


@leaf_kernel
def reassign_samples(
    deviation: Deviation, surface: Surface, centre: int, left: int, right: int
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
    deviation: Deviation, surface: Surface, corner: int, begin: int, end: int, found: int
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


@leaf_kernel
def _sum_errors(deviation: Deviation, surface: Surface, at: int) -> None:
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
