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
from gamutcore.decimation.samples import (
    LANES,
    LARGEST_RING,
    LARGEST_SHARE,
    SHARE_OUTSIDE,
    TOGETHER,
    Deviation,
)
from gamutcore.decimation.star import Surface
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "HUB",
    "ask_for_edge",
    "ask_for_vertex",
    "change_at",
    "deviation_around",
    "evaluate_present",
    "shortness",
]

FLATNESS = 1e-9
"""Weight of area times edge length in an edge's error: on flat sides, where no collapse changes the
deviation, it keeps vertices from merging into a few hubs; elsewhere it weighs nothing."""

HUB = 16
"""A ring of more faces than this is a hub's if it has a good part of all samples..."""

HUB_PART = 8
"""... an eighth or more. Such rings are not evaluated: they take the time of a hundred others, and
where all vertices hang on two hubs that is nearly all of the time. No level of the boundaries of
devices changes by it, nor do bodies with such hubs come out worse (docs/decisions/ways.md)."""

GROWTH = 2.0
"""How many times the volume that samples stand for a ring may enclose before it counts by itself:
where the reference is near the centre there are hardly any samples, and nothing else would tell
that a surface is blown up there..."""

UNSEEN = 8.0
"""... beyond this many samples' shares: the volume of a few is not known any better."""


@inlined_kernel
def _write_pairs(deviation: Deviation, position: FloatArray, place: FloatArray) -> float:
    """Write the planes of the faces around a place, and what fills them up for `_compare`.

    Returns six times the volume between these faces and the centre.
    """
    plane, pairs, volume = deviation.pair_plane, deviation.counts[0], 0.0
    x, y, z = place[0], place[1], place[2]
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
    # the last face ends where the first one begins; nothing is deep in what is behind it
    for column in range(3):
        plane[pairs, column] = plane[0, column]
        for index in range(pairs + 1, pairs + TOGETHER):
            plane[index, column] = np.nan
    return volume


@inlined_kernel
def _add_face(deviation: Deviation, face: int, asked: int) -> int:
    """Ask for the samples of a face; returns how many there are then."""
    deviation.face[deviation.counts[1]] = face
    deviation.counts[1] += 1
    begin = deviation.begin[face]
    count = deviation.end[face] - begin
    # numbers without a sign: numba lets negative ones count from the end, one by one
    source, target = np.uint64(begin), np.uint64(asked)
    for ahead in range(count):
        sample, number = source + np.uint64(ahead), target + np.uint64(ahead)
        deviation.asked_x[number] = deviation.x[sample]
        deviation.asked_y[number] = deviation.y[sample]
        deviation.asked_z[number] = deviation.z[sample]
        deviation.asked_weight[number] = deviation.weight[sample]
    return asked + count


@inlined_kernel
def _add_link(deviation: Deviation, one: int, two: int) -> None:
    deviation.link[deviation.counts[0], 0] = one
    deviation.link[deviation.counts[0], 1] = two
    deviation.counts[0] += 1


@inlined_kernel
def _sum_in_lanes(terms: FloatArray, count: int) -> float:
    """Sum of terms, a multiple of `LANES`, in eight parts that do not wait for each other.

    Their order is written here and not left to the compiler, so all machines round alike.
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
def _fill_lanes(deviation: Deviation, asked: int) -> None:
    """Add samples without a weight, up to a multiple of `LANES`."""
    filled = (asked + LANES - 1) // LANES * LANES
    for number in range(asked, filled):
        deviation.asked_x[number] = deviation.asked_x[0]
        deviation.asked_y[number] = deviation.asked_y[0]
        deviation.asked_z[number] = deviation.asked_z[0]
        deviation.asked_weight[number] = 0.0
    deviation.counts[5] = filled
    deviation.residual[2] = _sum_in_lanes(deviation.asked_weight, filled)


@inlined_kernel
def _is_of_a_hub(deviation: Deviation) -> bool:
    """Whether what was asked for would take too long."""
    links, asked, samples = deviation.counts[0], deviation.counts[5], deviation.counts[2]
    return links > HUB and HUB_PART * asked > samples


@inlined_kernel
def _row(plane: FloatArray, index: int, column: int) -> tuple[float, float, float]:
    return plane[index, column], plane[index, column + 1], plane[index, column + 2]


@inlined_kernel
def _lesser(one: float, other: float) -> float:
    # the processor's own minimum, which takes no branch
    return one if one < other else other  # noqa: FURB136


@inlined_kernel
def _compare(deviation: Deviation, first: int, begins: bool, four: bool) -> None:
    """Compare all samples with the cones of some faces around the place, from one of them on.

    Two faces that follow each other share a plane, with its sides exchanged, so five planes do for
    the cones of `TOGETHER` faces.

    Parameters
    ----------
    deviation : Deviation
    first : int
        The first of the faces.
    begins : bool
        Whether there are none before it.
    four : bool
        False: only two of them.
    """
    plane, depth, pair = deviation.pair_plane, deviation.side, deviation.pair
    xs, ys, zs = deviation.asked_x, deviation.asked_y, deviation.asked_z
    ax, ay, az = _row(plane, first, 0)
    bx, by, bz = _row(plane, first + 1, 0)
    cx, cy, cz = _row(plane, first + 2, 0)
    if four:
        dx, dy, dz = _row(plane, first + 3, 0)
        ex, ey, ez = _row(plane, first + 4, 0)
    for number in range(deviation.counts[5]):
        x, y, z = xs[number], ys[number], zs[number]
        begin, second = ax * x + ay * y + az * z, bx * x + by * y + bz * z
        third = cx * x + cy * y + cz * z
        least = _lesser(begin, -second)
        if begins:
            deepest, chosen = least, first
        else:
            deepest, chosen = depth[number], pair[number]
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
        depth[number] = deepest
        pair[number] = chosen


@inlined_kernel
def _choose_pairs(deviation: Deviation) -> None:
    """Write the face around the place whose cone each sample is in, or is least outside of.

    All faces are tried on all samples: there are few of them, and that takes no branches, so that
    several samples are compared at a time.
    """
    pairs = deviation.counts[0]
    _compare(deviation, 0, True, True)
    first = TOGETHER
    while first + TOGETHER // 2 < pairs:
        _compare(deviation, first, False, True)
        first += TOGETHER
    if first < pairs:
        _compare(deviation, first, False, False)


@inlined_kernel
def _look_up_faces(deviation: Deviation) -> None:
    """Write N·q and |N| of the face that each sample is in."""
    plane, pairs = deviation.pair_plane, deviation.pair
    inverses, norms = deviation.inverse, deviation.norm
    xs, ys, zs = deviation.asked_x, deviation.asked_y, deviation.asked_z
    for number in range(deviation.counts[5]):
        pair = np.uint64(pairs[number])
        inverses[number] = (
            plane[pair, 3] * xs[number] + plane[pair, 4] * ys[number] + plane[pair, 5] * zs[number]
        )
        norms[number] = plane[pair, 9]


@inlined_kernel
def _error_around_place(deviation: Deviation) -> float:
    """Sum over the samples asked for as if the faces around the place were there."""
    weights, inverses, norms = deviation.asked_weight, deviation.inverse, deviation.norm
    errors, apart, areas = deviation.term, deviation.other_term, deviation.third_term
    # the terms first, several at a time, then their sums
    for number in range(deviation.counts[5]):
        inverse, weight = inverses[number], weights[number]
        inside = inverse > 0.0
        t = 1.0 / inverse
        share = _lesser(abs(1.0 - t * t * t), LARGEST_SHARE)
        errors[number] = weight * (share if inside else SHARE_OUTSIDE)
        apart[number] = weight * abs(1.0 - t) if inside else 0.0
        areas[number] = weight * t * norms[number] if inside else 0.0
    deviation.residual[0] = _sum_in_lanes(apart, deviation.counts[5])
    deviation.residual[1] = _sum_in_lanes(areas, deviation.counts[5])
    return _sum_in_lanes(errors, deviation.counts[5])


@inlined_kernel
def deviation_around(deviation: Deviation) -> float:
    """Deviation of the faces that the last change was asked for, as they are now."""
    total = 0.0
    for index in range(deviation.counts[1]):
        total += deviation.error[deviation.face[index]]
    return total


@leaf_kernel
def ask_for_edge(deviation: Deviation, surface: Surface, corner: int) -> bool:
    """Ask for what there is around an edge: its faces, their samples, and the edges opposite.

    Parameters
    ----------
    deviation : Deviation
    surface : Surface
    corner : int
        One of the two corners that face the edge.

    Returns
    -------
    bool
        False for very large rings, and for a hub's with a good part of all samples.
    """
    vertex = surface.vertex
    one, two = vertex[following(corner)], vertex[preceding(corner)]
    deviation.residual[0] = 0.0
    # the faces around the edge; those around the place are two less
    if surface.degree[one] + surface.degree[two] - 2 > LARGEST_RING:
        return False
    deviation.counts[0] = deviation.counts[1] = 0
    asked = 0
    # from the face that vanishes on one side of the edge around one end to that on the other side,
    # and from there around the other end: in this order the edges go around the place
    for end in range(2):
        at = following(corner if end == 0 else surface.opposite[corner])
        asked = _add_face(deviation, at // 3, asked)
        last = preceding(surface.opposite[corner] if end == 0 else corner)
        at = surface.swung[at]
        while at != last:
            asked = _add_face(deviation, at // 3, asked)
            _add_link(deviation, vertex[following(at)], vertex[preceding(at)])
            at = surface.swung[at]
    _fill_lanes(deviation, asked)
    return not _is_of_a_hub(deviation)


@leaf_kernel
def ask_for_vertex(deviation: Deviation, surface: Surface, centre: int) -> bool:
    """Ask for what there is around a vertex; as `ask_for_edge`."""
    vertex = surface.vertex
    deviation.residual[0] = 0.0
    if surface.degree[centre] > LARGEST_RING:
        return False
    deviation.counts[0] = deviation.counts[1] = 0
    asked = 0
    first = surface.corner_at[centre]
    at = first
    while True:
        asked = _add_face(deviation, at // 3, asked)
        _add_link(deviation, vertex[following(at)], vertex[preceding(at)])
        at = surface.swung[at]
        if at == first:
            break
    _fill_lanes(deviation, asked)
    return not _is_of_a_hub(deviation)


@inlined_kernel
def _excess(deviation: Deviation, volume: float) -> float:
    """How much volume there is around a place that the reference has not, whatever samples say."""
    reference, count = deviation.residual[3], deviation.counts[2]
    slack = reference * (UNSEEN / count) if count > 0 else np.inf
    return volume - (GROWTH * deviation.residual[2] + slack)


@leaf_kernel
def change_at(deviation: Deviation, surface: Surface, place: FloatArray) -> float:
    """Change of the deviation if there is a vertex at a place instead of what was asked for.

    Parameters
    ----------
    deviation : Deviation
        As `ask_for_edge` or `ask_for_vertex` left it.
    surface : Surface
    place : (3,) float64
        Where the vertex would be, relative to the centre.

    Returns
    -------
    float
        In six times the volume's unit; negative if the surface comes closer to the reference. No
        less than what the faces would enclose beyond what the samples can stand for.
    """
    volume = _write_pairs(deviation, surface.position, place)
    _choose_pairs(deviation)
    _look_up_faces(deviation)
    after = max(_error_around_place(deviation), _excess(deviation, volume))
    return after - deviation_around(deviation)


@leaf_kernel
def evaluate_present(deviation: Deviation, surface: Surface, place: FloatArray) -> None:
    """Leave for `step_towards_reference` what `change_at` leaves, for a vertex where it is.

    Every sample is in the face that it was asked for with: none has to be compared.

    Parameters
    ----------
    deviation : Deviation
        As `ask_for_vertex` left it.
    surface : Surface
    place : (3,) float64
        The vertex's own, relative to the centre.
    """
    _write_pairs(deviation, surface.position, place)
    asked = 0
    for index in range(deviation.counts[1]):
        face = deviation.face[index]
        count = deviation.end[face] - deviation.begin[face]
        for number in range(asked, asked + count):
            deviation.pair[np.uint64(number)] = index
        asked += count
    # those that fill up the lanes weigh nothing
    for number in range(asked, deviation.counts[5]):
        deviation.pair[number] = 0
    _look_up_faces(deviation)
    _error_around_place(deviation)


@leaf_kernel
def shortness(deviation: Deviation, surface: Surface, corner: int) -> float:
    """What makes shorter edges come first where the last change asked for makes no difference.

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
    position, squared = surface.position, 0.0
    one, two = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    for axis in range(3):
        difference = position[one, axis] - position[two, axis]
        squared += difference * difference
    return FLATNESS * deviation.residual[1] * np.sqrt(squared)
