"""The places of a surface nearest to given points, and the values that it has there."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray, ShortArray
from gamutcore.corner_table import vertex_fans
from gamutcore.kernels import kernel, leaf_kernel

if TYPE_CHECKING:
    from gamutcore.arrays import Float32Array, PositionArray

__all__ = ["NearestPlaces", "nearest_places", "nearest_values"]

CANDIDATES = 8
"""The nearest point is searched in the faces around this many nearest vertices. With 4 the mean
distance is a tenth larger in levels of 1000 triangles; with 12 it is the same."""


class NearestPlaces(NamedTuple):
    """Places in the faces of a surface.

    Attributes
    ----------
    faces : (n,) int64
    second, third : (n,) float64
        Barycentric weights of the last two corners.
    """

    faces: LongArray
    second: FloatArray
    third: FloatArray


def nearest_places(
    points: PositionArray,
    vertices: PositionArray,
    faces: IndexArray,
    candidates: int = CANDIDATES,
) -> NearestPlaces:
    """Return the places of a closed surface that are nearest to given points, one or more.

    The faces around so many nearest vertices (`candidates`) are tried.
    """
    from scipy.spatial import cKDTree  # noqa: PLC0415  # 0.15 s and 15 MB; only builds need it

    origin = vertices.astype(np.float64).mean(axis=0)
    corners, targets = vertices - origin, points - origin
    count = min(candidates, len(corners))
    # vertices are spread evenly enough for halves at the middle, which take half the time
    tree = cKDTree(corners, balanced_tree=False, compact_nodes=False)
    near = tree.query(targets, count)[1].reshape(-1, count)
    return NearestPlaces(*_nearest_places(targets, near, corners, faces))


def nearest_values(
    points: Float32Array, vertices: Float32Array, faces: IndexArray, values: ShortArray
) -> ShortArray:
    """Return the values, (n, k) int16, of a closed surface at the points nearest to given points.

    Values are interpolated within the faces, so each is between those at the corners of its face.
    """
    if not len(points):
        return np.empty((0, values.shape[1]), np.int16)
    return _interpolate(*nearest_places(points, vertices, faces), faces, values)


@kernel
def _nearest_places(
    points: FloatArray,
    near: LongArray,
    vertices: FloatArray,
    faces: IndexArray,
) -> tuple[LongArray, FloatArray, FloatArray]:
    fan_end, fan = vertex_fans(faces.reshape(-1), len(vertices))
    tried = np.full(len(faces), -1, np.int32)
    count = len(points)
    best_face, best_v, best_w = np.zeros(count, np.int64), np.zeros(count), np.zeros(count)
    for point in range(count):
        best = np.inf
        for candidate in range(near.shape[1]):
            vertex = near[point, candidate]
            for index in range(fan_end[vertex - 1] if vertex > 0 else 0, fan_end[vertex]):
                face = fan[index]
                if tried[face] == point:
                    continue
                tried[face] = point
                square, v, w = _nearest_in_face(points, point, vertices, faces, face)
                if square < best:
                    best, best_face[point], best_v[point], best_w[point] = square, face, v, w
    return best_face, best_v, best_w


@kernel
def _interpolate(
    places: LongArray,
    second: FloatArray,
    third: FloatArray,
    faces: IndexArray,
    values: ShortArray,
) -> ShortArray:
    channels = values.shape[1]
    nearest = np.empty((len(places), channels), np.int16)
    for point in range(len(places)):
        face = places[point]
        one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
        for channel in range(channels):
            a = np.float64(values[one, channel])
            b = np.float64(values[two, channel])
            c = np.float64(values[three, channel])
            value = math.floor(a + second[point] * (b - a) + third[point] * (c - a) + 0.5)
            nearest[point, channel] = min(max(value, min(a, b, c)), max(a, b, c))
    return nearest


@leaf_kernel
def _nearest_in_face(
    points: FloatArray, point: int, vertices: FloatArray, faces: IndexArray, face: int
) -> tuple[float, float, float]:
    """Squared distance to a face, and the barycentric weights of its last two corners there.

    Ericson, "Real-Time Collision Detection" (2005), section 5.1.5, by the nearest region of the
    triangle.
    """
    one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
    d1, d2, d3, d4, d5, d6 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for axis in range(3):
        a, b, c = vertices[one, axis], vertices[two, axis], vertices[three, axis]
        p = points[point, axis]
        d1 += (b - a) * (p - a)
        d2 += (c - a) * (p - a)
        d3 += (b - a) * (p - b)
        d4 += (c - a) * (p - b)
        d5 += (b - a) * (p - c)
        d6 += (c - a) * (p - c)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    v, w = 0.0, 0.0
    if d1 <= 0.0 and d2 <= 0.0:
        pass
    elif d3 >= 0.0 and d4 <= d3:
        v = 1.0
    elif d6 >= 0.0 and d5 <= d6:
        w = 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v = d1 / (d1 - d3)
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        w = d2 / (d2 - d6)
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = 1.0 - w
    else:
        v, w = vb / (va + vb + vc), vc / (va + vb + vc)
    square = 0.0
    for axis in range(3):
        a, b, c = vertices[one, axis], vertices[two, axis], vertices[three, axis]
        off = a + v * (b - a) + w * (c - a) - points[point, axis]
        square += off * off
    return square, v, w
