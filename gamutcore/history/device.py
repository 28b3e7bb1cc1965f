"""Device values at the vertices of every level: the device input that produces each colour.

The vertices of the full boundary have the device values of their colours. When an edge collapses,
the values are interpolated at the point of the edge nearest to the new vertex. That is as accurate
as the colours while edges are short, but errors add up. In levels with fewer than `CORRECTED`
vertices a vertex therefore has the values that the full boundary has nearest to it. Either way
values are averages of those of the full boundary, within its range and ink limits.

Values are integers in steps of 1/5100 of full scale; whole percents and 8-bit codes are exact. In a
history file each group of splits has columns of device values (`columns`).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from gamutcore.arrays import FloatArray, IndexArray, LongArray, ShortArray
from gamutcore.errors import HistoryFileError, MeshError
from gamutcore.geometry import DeviceValues, closest_point, minus, row, vertex_fans
from gamutcore.history.splits import (
    extended_copy,
    group_count,
    group_ranges,
    part_begin,
    refine,
    undo_splits,
)
from gamutcore.kernels import inlined_kernel, kernel

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.arrays import PositionArray
    from gamutcore.history.splits import Splits

__all__ = [
    "CORRECTED",
    "FULL_SCALE",
    "DeviceHistory",
    "DeviceSection",
    "NearestPlaces",
    "SplitValues",
    "build_device_history",
    "nearest_places",
    "parse_device_section",
]

FULL_SCALE = 5100
"""Steps of full scale: 51 for each percent, 20 for each of 255 codes."""

CORRECTED = 8192
"""Levels with fewer vertices have the nearest values of the full boundary. With 500 vertices, that
has a twentieth of the error."""

LARGEST_SCALE = 2**15 - 1
"""Values in steps must fit into int16."""

MOST_CHANNELS = 64
"""More than any characterisation has; bounds what a file may ask for."""

LONGEST_NAME = 1000
"""Characters of a channel's name."""


class DeviceSection(NamedTuple):
    """What the header of a history file says about device values."""

    channels: tuple[str, ...]
    scale: int  # steps of full scale


class SplitValues(NamedTuple):
    """Device values of splits in steps, k channels; row i is the split that adds slot i + 4."""

    # (V - 4, k), values of the parent before and after the split, and of the new slot
    coarse: ShortArray
    fine: ShortArray
    added: ShortArray
    # (s, k), values of neighbours that move, before and after the split
    shifted_coarse: ShortArray
    shifted_fine: ShortArray


class DeviceHistory:
    """Device values of all levels of a history.

    `snapshots` are the values of the levels with 4, 8, 16, … vertices and of the full boundary,
    (v, k) int16 in steps, as far as the splits are known.
    """

    def __init__(
        self, section: DeviceSection, snapshots: list[ShortArray], splits: SplitValues
    ) -> None:
        self.section = section
        self.splits = splits
        self.snapshots = snapshots

    @property
    def base(self) -> ShortArray:
        """Values of slots 0 to 3 at the coarsest level, (4, k) int16 in steps."""
        return self.snapshots[0]

    @property
    def nbytes(self) -> int:
        """Memory in bytes."""
        return sum(array.nbytes for array in (*self.splits, *list(self.snapshots)))

    def append(self, values: list[NDArray[Any]], geometry: Splits) -> None:
        """Append the values of the next group, which `geometry` has.

        `values` are the columns of `SplitValues`.
        """
        columns = [
            np.concatenate([old, new.astype(np.int16)])
            for old, new in zip(self.splits, values, strict=True)
        ]
        splits = SplitValues(*columns)
        start, end = len(self.splits.fine) + 4, len(splits.fine) + 4
        level = extended_copy(self.snapshots[-1], end)
        _refine_values(level, geometry, splits, start, end)
        self.splits = splits
        self.snapshots.append(level)

    def level(self, vertices: int, geometry: Splits) -> DeviceValues:
        """Return the values of a level as float32, in time proportional to the level.

        The level has 4 vertices to the end of the last group that is known.
        """
        snapshot = self.snapshots[group_count(vertices)]
        values = _level_values(
            vertices,
            snapshot,
            geometry.parent,
            self.splits.coarse,
            geometry.shifted_end,
            geometry.shifted,
            self.splits.shifted_coarse,
        )
        channels, scale = self.section
        return DeviceValues(channels, (values / scale).astype(np.float32))


def build_device_history(device: DeviceValues, slots: IndexArray, splits: Splits) -> DeviceHistory:
    """Return the device values of all levels from those of the full boundary.

    `slots` are those of the vertices of the full boundary. Another number of device values than of
    vertices raises a `MeshError`.
    """
    if len(device) != len(slots):
        raise MeshError(
            f"there are device values of {len(device)} vertices, not of {len(slots)}",
            where={"field": "device"},
            remedy="Give one row for each vertex of the full boundary.",
        )
    section = DeviceSection(device.channels, FULL_SCALE)
    corrected = min(CORRECTED - 4, len(splits.parent))
    values = np.empty(device.values.shape, np.int16)
    values[slots] = np.rint(device.values.astype(np.float64) * FULL_SCALE)
    positions = extended_copy(splits.base_positions, splits.vertices)
    faces = extended_copy(splits.base_faces, 2 * splits.vertices - 4)
    refine(splits, positions, faces.reshape(-1), 4, splits.vertices)
    shifts = int(splits.shifted_end[:corrected].max(initial=0))
    targets = np.concatenate([splits.coarse[:corrected], splits.shifted_coarse[:shifts]])
    places = nearest_places(targets, positions, faces)
    corners = values[faces[places.faces]].astype(np.float64)
    one, two, three = np.moveaxis(corners, 1, 0)
    second, third = places.second[:, np.newaxis], places.third[:, np.newaxis]
    within = np.floor(one + second * (two - one) + third * (three - one) + 0.5)
    nearest = np.clip(within, corners.min(axis=1), corners.max(axis=1)).astype(np.int16)
    rows = np.empty((3, len(splits.parent), len(device.channels)), np.int16)
    shifted = np.empty((2, len(splits.shifted), len(device.channels)), np.int16)
    columns = SplitValues(rows[0], rows[1], rows[2], shifted[0], shifted[1])
    fraction = _edge_fractions(splits)
    snapshots = [values.copy()]
    for start, end in reversed(group_ranges(splits.vertices)):
        _collapse_values(
            values,
            splits.parent,
            fraction,
            splits.shifted_end,
            splits.shifted,
            nearest,
            corrected,
            columns,
            start,
            end,
        )
        snapshots.insert(0, values[:start].copy())
    return DeviceHistory(section, snapshots, columns)


def parse_device_section(entry: object) -> tuple[DeviceSection, ShortArray]:
    """Return what the header of a history file says about device values, and those of slots 0 to 3.

    Anything but an object with ``channels``, ``steps`` and ``base`` raises a `HistoryFileError`.
    """
    try:
        mapping = cast("Mapping[str, object]", entry)
        channels, scale = cast("list[str]", mapping["channels"]), cast("int", mapping["steps"])
        base = np.array(mapping["base"])
        is_sound = (
            isinstance(channels, list)
            and all(isinstance(name, str) and len(name) <= LONGEST_NAME for name in channels)
            and 1 <= len(channels) <= MOST_CHANNELS
            and type(scale) is int
            and 1 <= scale <= LARGEST_SCALE
            and base.dtype == np.int64
            and base.shape == (4, len(channels))
            and bool(((base >= 0) & (base <= scale)).all())
        )
    except (ValueError, KeyError, TypeError, OverflowError):
        is_sound = False
    if not is_sound:
        raise HistoryFileError(
            f"the device values are described by {str(entry)[:40]!r}",
            where={"field": "device"},
            remedy=f"Give the names of 1 to {MOST_CHANNELS} channels, steps from 1 to "
            f"{LARGEST_SCALE}, and four rows of values from 0 to the steps.",
        )
    return DeviceSection(tuple(channels), scale), base.astype(np.int16)


def _edge_fractions(splits: Splits) -> FloatArray:
    """Return the position of each parent before its split along the new edge, 0 to 1.

    It is 0 at the parent after the split, and 1 at the new slot.

    Positions are multiples of a power of two and at most 2²⁴ steps from the origin. All sums are
    exact, so every order of operations gives the same quotients.
    """
    fine = splits.fine.astype(np.float64)
    edge = splits.added.astype(np.float64) - fine
    # einsum takes a third of the time of a product and a sum over three columns
    along = np.einsum("ij,ij->i", splits.coarse - fine, edge)
    square = np.einsum("ij,ij->i", edge, edge)
    fraction = np.zeros(len(edge))
    np.divide(along, square, out=fraction, where=square > 0)
    return np.clip(fraction, 0.0, 1.0)


def _refine_values(
    values: ShortArray, geometry: Splits, splits: SplitValues, start: int, end: int
) -> None:
    """Split the values of a level with `start` slots until it has `end`, in place."""
    ends, index = geometry.shifted_end, np.arange(start - 4, end - 4)
    begin, stop = part_begin(ends, start - 4), part_begin(ends, end - 4)
    counts = np.diff(ends[start - 4 : end - 4], prepend=begin)
    order = np.argsort(np.concatenate([index, index, np.repeat(index, counts)]), kind="stable")
    slots: list[NDArray[Any]] = [geometry.parent[index], index + 4, geometry.shifted[begin:stop]]
    rows = [splits.fine[index], splits.added[index], splits.shifted_fine[begin:stop]]
    # the last value of a slot stays
    values[np.concatenate(slots)[order]] = np.concatenate(rows)[order]


@kernel
def _collapse_values(
    values: ShortArray,
    parents: IndexArray,
    fraction: FloatArray,
    shifted_end: IndexArray,
    shifted: IndexArray,
    nearest: ShortArray,
    corrected: int,
    splits: SplitValues,
    start: int,
    end: int,
) -> None:
    """Collapse the values of a level with `end` slots to `start` in place, and record each split.

    `nearest` has the values of the full boundary nearest to the parents of `corrected` splits, then
    those nearest to their neighbours that move.
    """
    for split in range(end - 5, start - 5, -1):
        parent = parents[split]
        for channel in range(values.shape[1]):
            fine = int(values[parent, channel])
            added = int(values[split + 4, channel])
            coarse = _interpolate(fine, added - fine, fraction[split])
            if split < corrected:
                coarse = int(nearest[split, channel])
            splits.fine[split, channel] = fine
            splits.added[split, channel] = added
            splits.coarse[split, channel] = coarse
            values[parent, channel] = coarse
        for index in range(part_begin(shifted_end, split), shifted_end[split]):
            for channel in range(values.shape[1]):
                fine = int(values[shifted[index], channel])
                coarse = int(nearest[corrected + index, channel]) if split < corrected else fine
                splits.shifted_fine[index, channel] = fine
                splits.shifted_coarse[index, channel] = coarse
                values[shifted[index], channel] = coarse


@kernel
def _level_values(
    vertices: int,
    snapshot: ShortArray,
    parent: IndexArray,
    coarse: ShortArray,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_coarse: ShortArray,
) -> ShortArray:
    """Return the (vertices, k) int16 values of a level from a snapshot that is not coarser."""
    values = snapshot[:vertices].copy()
    undo_splits(
        values,
        values.shape[1],
        len(snapshot),
        vertices,
        parent,
        coarse,
        shifted_end,
        shifted,
        shifted_coarse,
    )
    return values


@inlined_kernel
def _interpolate(value: int, change: int, fraction: float) -> int:
    return value + math.floor(fraction * change + 0.5)


CANDIDATES = 8
"""The nearest point is searched in the faces around this many nearest vertices. With 4 the mean
distance is a tenth larger in levels of 1000 triangles; with 12 it is the same."""


class NearestPlaces(NamedTuple):
    """Places in the faces of a surface, as barycentric weights of the last two corners."""

    faces: LongArray
    second: FloatArray
    third: FloatArray


def nearest_places(
    points: PositionArray, vertices: PositionArray, faces: IndexArray, candidates: int = CANDIDATES
) -> NearestPlaces:
    """Return the places of a closed surface that are nearest to given points.

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


@kernel
def _nearest_places(
    points: FloatArray, near: LongArray, vertices: FloatArray, faces: IndexArray
) -> tuple[LongArray, FloatArray, FloatArray]:
    fan_start, fan = vertex_fans(faces.reshape(-1), len(vertices))
    tried = np.full(len(faces), -1, np.int32)
    count = len(points)
    best_face, best_v, best_w = np.zeros(count, np.int64), np.zeros(count), np.zeros(count)
    for point in range(count):
        best = np.inf
        for candidate in range(near.shape[1]):
            vertex = near[point, candidate]
            for index in range(fan_start[vertex], fan_start[vertex + 1]):
                face = fan[index]
                if tried[face] == point:
                    continue
                tried[face] = point
                a = row(vertices, faces[face, 0], 0)
                b = minus(row(vertices, faces[face, 1], 0), a)
                c = minus(row(vertices, faces[face, 2], 0), a)
                square, v, w = closest_point(minus(row(points, point, 0), a), b, c)
                if square < best:
                    best, best_face[point], best_v[point], best_w[point] = square, face, v, w
    return best_face, best_v, best_w
