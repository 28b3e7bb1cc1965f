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
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.decimation.star import LARGEST_LINK, Surface
from gamutcore.decimation.vectors import row, triple
from gamutcore.kernels import leaf_kernel

__all__ = [
    "HALF_BEGIN",
    "HALF_SIZE",
    "LANES",
    "LARGEST_SHARE",
    "PENALTY_OUTSIDE",
    "QUERY_AREA",
    "QUERY_DISTANCE",
    "QUERY_FACES",
    "QUERY_PAIRS",
    "QUERY_SAMPLES",
    "QUERY_WEIGHT",
    "SAMPLES",
    "TOGETHER",
    "TOP",
    "TOTAL_WEIGHT",
    "Deviation",
    "deviation_on_faces",
    "empty_deviation",
    "is_face",
    "sample_capacity",
    "take_samples",
]

LARGEST_SHARE = 1e12
"""Bound of |1 − t³|, which keeps sums finite where the surface is nearly edge-on."""

PENALTY_OUTSIDE = 8.0
"""Value of |1 − t³| for a sample that no face lies in front of. The position is then not valid."""

LANES = 8
"""Largest number of samples that one vector instruction processes."""

TOGETHER = 4
"""Number of faces that each sample is compared with in one pass."""

SAMPLES, TOP, HALF_BEGIN, HALF_SIZE = range(4)
"""Indices into `Deviation.counts`.

Number of samples in use; index behind the last one, 0 while they are not assigned to faces; first
index of the half in use; length of a half.
"""

QUERY_PAIRS, QUERY_FACES, QUERY_SAMPLES = range(4, 7)
"""Indices into `Deviation.counts`, for the current query.

Number of pairs of the link; number of faces; number of samples including the padding.
"""

QUERY_DISTANCE, QUERY_AREA, QUERY_WEIGHT, TOTAL_WEIGHT = range(4)
"""Indices into `Deviation.sums`.

For the current query: distances of the samples from their faces, integrated over their area; that
area; the sum of their weights. `TOTAL_WEIGHT` is the sum over all samples.
"""


class Deviation(NamedTuple):
    """Samples of a reference and the faces that they lie in; scratch for queries.

    A query asks for the samples around an edge or a vertex (`costs.deviation`).

    Attributes
    ----------
    x, y, z : (4 S,) float64
        The samples, relative to the centre.
    weight : (4 S,) float64
        Their shares of the volume of the reference, times six.
    begin, end : (F,) int64
        Start and end of each face's samples in these arrays.
    error : (F,) float64
        Sum of w |1 − t³| over the samples of a face.
    cursor : (F,) int64
        Scratch: where the next sample of a face is written.
    link : (LARGEST_LINK, 2) int32
        Query: the directed link, in the order of its pairs around the position.
    plane : (LARGEST_LINK + TOGETHER, 10) float64
        Query, for the face (p, a, b) of the position p and each pair: p × a; N with N·q = 1 on the
        face; a × b ÷ det(p, a, b); |N|. The cone of the face lies between its p × a and the next.
    face_sum : (LARGEST_LINK, 8) float64
        Query, for each of these faces: two sums over its samples in four partial sums.
    face : (F + 2,) int32
        Query: the present faces. Reassignment: a corner of each face involved.
    query_x, query_y, query_z, query_weight : (S + LANES,) float64
        Query: the samples in these faces.
    pair : (S + LANES,) int64
        The pair whose face each of them lies in; when samples are assigned, a corner.
    depth, inverse, norm : (S + LANES,) float64
        How deep each lies in the cone of that face; N·q of that face, the inverse of t; its |N|.
    term, other_term, third_term : (S + LANES,) float64
        Terms of the sums over them.
    counts : (7,) int64
        Indexed by `SAMPLES`, `TOP`, `HALF_BEGIN`, `HALF_SIZE` and `QUERY_…`.
    sums : (4,) float64
        Indexed by `QUERY_DISTANCE`, `QUERY_AREA`, `QUERY_WEIGHT`, `TOTAL_WEIGHT`.
    """

    x: FloatArray
    y: FloatArray
    z: FloatArray
    weight: FloatArray
    begin: LongArray
    end: LongArray
    error: FloatArray
    cursor: LongArray
    link: IndexArray
    plane: FloatArray
    face_sum: FloatArray
    face: IndexArray
    query_x: FloatArray
    query_y: FloatArray
    query_z: FloatArray
    query_weight: FloatArray
    pair: LongArray
    depth: FloatArray
    inverse: FloatArray
    norm: FloatArray
    term: FloatArray
    other_term: FloatArray
    third_term: FloatArray
    counts: LongArray
    sums: FloatArray


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
def is_face(surface: Surface, face: int) -> bool:
    """Whether a face still exists. One corner of a removed face faces a removed edge."""
    facing, edge_of = surface.corner_facing, surface.edge_of
    one, two, three = edge_of[3 * face], edge_of[3 * face + 1], edge_of[3 * face + 2]
    return min(facing[one], facing[two], facing[three]) >= 0


@leaf_kernel
def _six_volumes(surface: Surface, face: int) -> float:
    """Six times the volume of the cone over a face; 0 for a removed face."""
    if not is_face(surface, face):
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
    deviation: Deviation, surface: Surface, face: int, part: float, share: float, passed: float
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
def take_samples(deviation: Deviation, surface: Surface, wanted: int) -> None:
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
        if is_face(surface, face):
            count += _divisions(_six_volumes(surface, face), part) ** 2
    share = 0.0 if count <= room else whole / (room // 2)
    passed = 0.5 * share
    for face in range(faces):
        if is_face(surface, face):
            passed = _add_lattice(deviation, surface, face, part, share, passed)
    deviation.counts[TOP], deviation.counts[HALF_SIZE] = 0, 2 * deviation.counts[SAMPLES]
    deviation.sums[TOTAL_WEIGHT] = whole
