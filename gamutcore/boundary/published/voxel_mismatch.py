"""The published mismatch: the voxels in only one of two gamuts ÷ the voxels in the reference.

A voxel is in a gamut if its centre is. Voxels are counted by scan lines. The surface cuts each
column of voxel centres, parallel to the first axis; voxels between a pair of cuts are inside. Two
gamuts differ between pairs of the cuts of both together, so no voxel is stored.

Source: A. M. Bakke & I. Farup, "Simplified Gamut Boundary Representation using Mesh Decimation".
They divide the number of voxels in only one gamut by the number in the reference.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.errors import MeshError, OptionError
from gamutcore.geometry import clip, opposite_corners
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.number_text import number_text

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.geometry import TriangleMesh

VOXELS = 256
"""Default number of voxels along the longest axis of the reference."""

MOST_VOXELS = 2048
"""Most voxels along an axis of the box around both gamuts. The cuts of four million columns take
about 100 MB."""

MARGIN = 2.0**-30
"""Thickness of the surface in voxels when the voxels that it meets are counted. It covers rounding
and is too small to matter."""


class VoxelMismatch(NamedTuple):
    """A mismatch in voxels.

    Attributes
    ----------
    mismatch : float
        Voxels in only one gamut ÷ voxels in the reference.
    bound : float
        Upper bound of the difference from the exact mismatch.
    edge : float
        Edge length of a voxel.
    reference_voxels : int
        Voxels in the reference.
    differing_voxels : int
        Voxels in only one gamut.
    """

    mismatch: float
    bound: float
    edge: float
    reference_voxels: int
    differing_voxels: int


def voxel_mismatch(
    reference: TriangleMesh, other: TriangleMesh, edge: float | None = None
) -> VoxelMismatch:
    """Count the voxels in only one of two gamuts, relative to those in the reference.

    Parameters
    ----------
    reference, other : TriangleMesh
        Closed meshes in the same colour space. A point is inside if a ray from it crosses the mesh
        an odd number of times.
    edge : float, optional
        Edge length of a voxel in units of the space; by default 1/256 of the largest extent of the
        reference. Voxels lie between integer multiples of it.

    Returns
    -------
    VoxelMismatch

    Raises
    ------
    MeshError
        If a mesh is not closed and oriented, or no voxel centre is in the reference.
    OptionError
        If the edge is not a positive number, or gives more than 2048 voxels along an axis.

    Notes
    -----
    A voxel that no surface meets is entirely inside or outside and counted exactly. A voxel that a
    surface meets is wrong by at most one voxel. Let n voxels differ and N be in the reference. Let
    s voxels meet either surface and s′ that of the reference. Let V and V′ be the exact volumes of
    the difference and of the reference in voxels. Then ``|n − V| ≤ s``, ``|N − V′| ≤ s′`` and::

        |n ÷ N − V ÷ V′| ≤ |n − V| ÷ N + V ÷ V′ · |V′ − N| ÷ N ≤ (s + (n + s) ÷ V′ · s′) ÷ N
    """
    for mesh in (reference, other):
        _check(mesh)
    bounds = np.stack([reference.bounds, other.bounds])
    length = _voxel_edge(edge, bounds)
    lowest = np.floor(bounds[:, 0].min(axis=0) / length)
    counts = (np.ceil(bounds[:, 1].max(axis=0) / length) - lowest).astype(np.int64) + 1
    meshes = [_in_voxels(mesh, length, lowest) for mesh in (reference, other)]
    columns = int(counts[1] * counts[2])
    cuts = [_written(_write_cuts, *mesh, counts, 4 * columns + len(mesh[1])) for mesh in meshes]
    inside = _between_pairs(cuts[0])
    if inside == 0:
        raise MeshError(
            f"no voxel of edge {number_text(length)} has its centre in the reference",
            remedy="Give a closed mesh that encloses a volume, and voxels much smaller than it.",
        )
    differing = _between_pairs(np.concatenate(cuts))
    met = [
        _written(_write_met_voxels, *mesh, counts, 4 * columns + 8 * len(mesh[1]))
        for mesh in meshes
    ]
    own, either = _count_distinct(met[0]), _count_distinct(np.concatenate(met))
    volume = abs(reference.volume) / length**3
    most = (differing + either) / volume if volume > 0 else math.inf
    return VoxelMismatch(
        mismatch=differing / inside,
        bound=(either + most * own) / inside,
        edge=length,
        reference_voxels=inside,
        differing_voxels=differing,
    )


def _check(mesh: TriangleMesh) -> None:
    finite = bool(np.isfinite(mesh.vertices).all())
    faces = np.ascontiguousarray(mesh.faces, np.int32)
    if not finite or len(faces) == 0 or (opposite_corners(faces, len(mesh.vertices)) < 0).any():
        raise MeshError(
            "the mesh bounds no solid: it is not closed and oriented, or not finite",
            remedy="Give a closed mesh of finite numbers whose faces are all oriented outwards.",
        )


def _voxel_edge(edge: float | None, bounds: FloatArray) -> float:
    """Return the edge length of a voxel, given or by default.

    `bounds` (2, 2, 3) has the lowest and highest coordinates of the reference and the other gamut.
    """
    length = float(np.ptp(bounds[0], axis=0).max()) / VOXELS if edge is None else float(edge)
    extent = float((bounds[:, 1].max(axis=0) - bounds[:, 0].min(axis=0)).max())
    if not 0 < length < math.inf or not extent / length <= MOST_VOXELS:
        raise OptionError(
            f"voxels of edge {number_text(length)} are asked for, in a box of "
            f"{number_text(extent)}",
            where={"field": "edge"},
            remedy=f"Give a positive length, at least {number_text(extent / MOST_VOXELS)}:"
            f" at most {MOST_VOXELS} voxels along an axis.",
        )
    return length


def _in_voxels(
    mesh: TriangleMesh, edge: float, lowest: FloatArray
) -> tuple[FloatArray, IndexArray]:
    """Vertices in units of voxels from the corner of the box, and faces."""
    vertices = mesh.vertices.astype(np.float64) / edge - lowest
    return np.ascontiguousarray(vertices), np.ascontiguousarray(mesh.faces, np.int32)


def _between_pairs(cuts: LongArray) -> int:
    """Number of voxels between the first and second, third and fourth ... cut."""
    ordered = np.sort(cuts)
    return int(ordered[1::2].sum() - ordered[::2].sum())


def _count_distinct(numbers: LongArray) -> int:
    """Number of distinct values, at least one. Sorting is much faster than hashing."""
    return 1 + int(np.count_nonzero(np.diff(np.sort(numbers))))


def _written(
    write: Callable[..., int],
    vertices: FloatArray,
    faces: IndexArray,
    counts: LongArray,
    room: int,
) -> LongArray:
    """Return the numbers that a kernel writes; it is called again if `room` was too small."""
    numbers = np.empty(room, np.int64)
    needed = write(vertices, faces, *counts, numbers)
    if needed > room:
        numbers = np.empty(needed, np.int64)
        write(vertices, faces, *counts, numbers)
    return numbers[:needed]


@leaf_kernel
def _first_centre(coordinate: float, count: int) -> int:
    """Number of the first voxel whose centre is not below a coordinate, at most `count`."""
    return min(max(math.ceil(coordinate - 0.5), 0), count)


@leaf_kernel
def _crossing(vertices: FloatArray, one: int, other: int, height: float) -> tuple[float, float]:
    """Return the first two coordinates at which an edge crosses a height of the third axis.

    The edge is oriented upwards, so that both faces at the edge get the same bits.
    """
    start, end = (one, other) if vertices[one, 2] < vertices[other, 2] else (other, one)
    part = (height - vertices[start, 2]) / (vertices[end, 2] - vertices[start, 2])
    return (
        vertices[start, 0] + part * (vertices[end, 0] - vertices[start, 0]),
        vertices[start, 1] + part * (vertices[end, 1] - vertices[start, 1]),
    )


@leaf_kernel
def _write_cuts(
    vertices: FloatArray, faces: IndexArray, deep: int, wide: int, high: int, cuts: LongArray
) -> int:
    """Write the cuts of all columns while there is room; return the number of all cuts.

    A cut is the number of the first voxel behind it; voxels are numbered column by column.
    A plane of voxel centres crosses an edge if it is above exactly one end, so it crosses a closed
    surface along closed polygons. A column of centres crosses a side of a polygon if it is behind
    exactly one end. These half-open intervals give every column an even number of cuts, whatever
    the rounding.
    """
    count = 0
    for face in range(len(faces)):
        corners = (faces[face, 0], faces[face, 1], faces[face, 2])
        bottom = min(vertices[corners[0], 2], vertices[corners[1], 2], vertices[corners[2], 2])
        top = max(vertices[corners[0], 2], vertices[corners[1], 2], vertices[corners[2], 2])
        for row in range(_first_centre(bottom, high), _first_centre(top, high)):
            height = row + 0.5
            ends = 0
            x0 = y0 = x1 = y1 = 0.0
            for side in range(3):
                one, other = corners[side], corners[(side + 1) % 3]
                if (vertices[one, 2] <= height) != (vertices[other, 2] <= height):
                    x0, y0 = x1, y1
                    x1, y1 = _crossing(vertices, one, other, height)
                    ends += 1
            if ends != 2:
                continue
            if y1 < y0:
                x0, y0, x1, y1 = x1, y1, x0, y0
            for column in range(_first_centre(y0, wide), _first_centre(y1, wide)):
                part = (column + 0.5 - y0) / (y1 - y0)
                if count < len(cuts):
                    depth = _first_centre(x0 + part * (x1 - x0), deep)
                    cuts[count] = (row * wide + column) * (deep + 1) + depth
                count += 1
    return count


@leaf_kernel
def _voxel_range(polygon: FloatArray, corners: int, axis: int, count: int) -> tuple[int, int]:
    """First voxel that a polygon reaches along an axis, and the first voxel behind it."""
    least = most = polygon[0, axis]
    for corner in range(1, corners):
        least, most = min(least, polygon[corner, axis]), max(most, polygon[corner, axis])
    return max(math.floor(least - MARGIN), 0), min(math.floor(most + MARGIN) + 1, count)


@kernel
def _write_met_voxels(
    vertices: FloatArray, faces: IndexArray, deep: int, wide: int, high: int, voxels: LongArray
) -> int:
    """Write the numbers of the voxels that each face meets while there is room; return how many.

    Planes of the third axis cut a face into slices, and planes of the second axis cut slices into
    strips. A strip covers a contiguous range of voxels along the first axis.
    """
    whole, half, slice_ = np.empty((10, 3)), np.empty((10, 3)), np.empty((10, 3))
    strip = np.empty((10, 3))
    count = 0
    for face in range(len(faces)):
        for corner in range(3):
            for k in range(3):
                whole[corner, k] = vertices[faces[face, corner], k]
        rows = _voxel_range(whole, 3, 2, high)
        for row in range(rows[0], rows[1]):
            corners = clip(whole, 3, (0.0, 0.0, 1.0), MARGIN - row, half)
            corners = clip(half, corners, (0.0, 0.0, -1.0), row + 1 + MARGIN, slice_)
            if corners == 0:  # by rounding, at the tip of a face
                continue
            columns = _voxel_range(slice_, corners, 1, wide)
            for column in range(columns[0], columns[1]):
                ends = clip(slice_, corners, (0.0, 1.0, 0.0), MARGIN - column, half)
                ends = clip(half, ends, (0.0, -1.0, 0.0), column + 1 + MARGIN, strip)
                if ends == 0:
                    continue
                reach = _voxel_range(strip, ends, 0, deep)
                for depth in range(reach[0], reach[1]):
                    if count < len(voxels):
                        voxels[count] = (row * wide + column) * deep + depth
                    count += 1
    return count
