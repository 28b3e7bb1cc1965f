"""Change of the deviation from a reference by a collapse or a move: mismatch by samples.

A collapse, or a move of a vertex, changes only the faces around it, hence only the sum over the
samples in these faces. A query collects the samples. `change_at` writes the faces that would
surround the vertex at some position. It finds the face of each sample by comparing the sample with
the planes through the centre and the new edges.

A step of a vertex then minimises the deviation by one step of iteratively reweighted least squares.
It uses the results of the last `change_at`: the samples around a point and their faces.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.decimation.deviation_samples import (
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
from gamutcore.decimation.quadrics import Quadrics, shift_to_preserve_volume
from gamutcore.decimation.surface_mesh import LARGEST_LINK, SurfaceMesh, squared_length
from gamutcore.geometry import (
    add_outer,
    adjugate,
    cross,
    dot,
    following,
    minus,
    plus,
    preceding,
    product,
    row,
    scaled,
    write_row,
)
from gamutcore.kernels import inlined_kernel, leaf_kernel


@leaf_kernel
def query_edge(deviation: Deviation, surface: SurfaceMesh, corner: int) -> bool:
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
        corner = int(surface.swung[corner])
        filled = _add_face(deviation, corner // 3, filled)
        pair = deviation.counts[QUERY_PAIRS]
        deviation.link[pair, 0] = surface.vertex[following(corner)]
        deviation.link[pair, 1] = surface.vertex[preceding(corner)]
        deviation.counts[QUERY_PAIRS] += 1
    return filled


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
"""Columns of `Deviation.plane`: p × a (3), N (3), a × b ÷ det(p, a, b) (3), |N|."""


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
def _lesser(one: float, other: float) -> float:
    # compiles to the processor's minimum instruction, without a branch
    return one if one < other else other  # noqa: FURB136


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
        total += deviation.error[deviation.face[index]]
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
    plane, sums, pairs = deviation.plane, deviation.face_sum, deviation.counts[QUERY_PAIRS]
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
    plane, pairs, weights = deviation.plane, deviation.pair, deviation.query_weight
    inverses, norms, sums = deviation.inverse, deviation.norm, deviation.face_sum
    xs, ys, zs = deviation.query_x, deviation.query_y, deviation.query_z
    squares, pulls, count = deviation.term, deviation.other_term, deviation.counts[QUERY_SAMPLES]
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
