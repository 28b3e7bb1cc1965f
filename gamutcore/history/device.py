"""Device values at the vertices of every level: the device input that produces each colour.

The vertices of the full boundary have the device values of their colours. When an edge collapses,
the values are interpolated at the point of the edge nearest to the new vertex. That is as accurate
as the colours while edges are short, but errors add up. In levels with fewer than `CORRECTED`
vertices a vertex therefore has the values that the full boundary has nearest to it. Either way
values are averages of those of the full boundary, within its range and ink limits.

Values are integers in steps of 1/5100 of full scale; whole percents and 8-bit codes are exact. The
difference between the ends of an edge and the rounded value between them give both back exactly:
integer lifting (Calderbank, Daubechies, Sweldens & Yeo, "Wavelet transforms that map integers to
integers", 1998). In a history file device values are an optional section behind the geometry, with
one stream per group. ``docs/history-format.md`` specifies it.
"""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np

from gamutcore.arrays import ByteArray, FloatArray, IndexArray, LongArray, ShortArray
from gamutcore.errors import HistoryFileError, MeshError
from gamutcore.geometry import DeviceValues, closest_point, minus, row, vertex_fans
from gamutcore.history.bit_codes import (
    DAMAGE_REMEDY,
    DEVICE,
    LENGTH_CLASSES,
    LONGEST_CODE,
    BitReader,
    BitWriter,
    Contexts,
    Streams,
    decode_sign,
    encode_sign,
    read_adaptive,
    stream_bytes,
    write_adaptive,
)
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
    from collections.abc import Mapping, Sequence

    from gamutcore.arrays import PositionArray
    from gamutcore.history.splits import Splits

__all__ = [
    "CORRECTED",
    "FULL_SCALE",
    "DeviceHistory",
    "DeviceSection",
    "NearestPlaces",
    "SplitEdges",
    "SplitValues",
    "build_device_history",
    "collapse_values",
    "device_streams",
    "first_value_contexts",
    "level_values",
    "nearest_places",
    "open_device_history",
    "parse_device_section",
    "read_values",
    "write_values",
]

FULL_SCALE = 5100
"""Steps of full scale: 51 for each percent, 20 for each of 255 codes."""

CORRECTED = 8192
"""Levels with fewer vertices have corrections: a twentieth of the error with 500 vertices, for
2 bits for each vertex of the full boundary."""

LARGEST_SCALE = 2**15 - 1
"""Values in steps must fit into int16."""

MOST_CHANNELS = 64
"""More than any characterisation has; bounds what a file may ask for."""

LONGEST_NAME = 1000
"""Characters of a channel's name."""


class DeviceSection(NamedTuple):
    """What the metadata of a history file says about its device values."""

    channels: tuple[str, ...]
    scale: int  # steps of full scale
    corrected: int  # levels with fewer vertices have corrections

    def to_json(self) -> str:
        """Return the text for the metadata."""
        entry = {"channels": self.channels, "steps": self.scale, "corrected": self.corrected}
        return json.dumps(entry, separators=(",", ":"))


class SplitEdges(NamedTuple):
    """The geometry that device values depend on; row i is the split that adds slot i + 4."""

    parent: IndexArray
    # position of the parent before the split on the edge from the parent to the new slot, 0 to 1
    fraction: FloatArray
    length: ByteArray  # length class of the edge
    # end of each split's part of shifted; splits without corrections have no part
    shifted_end: IndexArray
    shifted: IndexArray  # neighbours that move
    corrected: int  # this many splits, from the first one, have corrections


class SplitValues(NamedTuple):
    """Device values of splits in steps, k channels; row i is the split that adds slot i + 4."""

    # (V - 4, k), values of the parent before and after the split, and of the new slot
    coarse: ShortArray
    fine: ShortArray
    added: ShortArray
    # (shifted_end[corrected - 1], k), values of neighbours that move, before and after the split
    shifted_coarse: ShortArray
    shifted_fine: ShortArray


class DeviceHistory:
    """Device values of all levels of a history.

    `snapshots` are the values of the levels with 4, 8, 16, … vertices and of the full boundary,
    (v, k) int16 in steps, as far as they are unpacked. More rows of `splits` and `edges` are
    unpacked from `streams`, for positions on a grid of the given step.
    """

    def __init__(
        self,
        section: DeviceSection,
        snapshots: list[ShortArray],
        splits: SplitValues,
        edges: SplitEdges,
        streams: Streams | None = None,
        step: float = 1.0,
    ) -> None:
        self.section = section
        self.splits = splits
        self.edges = edges
        self._snapshots = snapshots
        self._streams = streams
        self._step = step
        self._contexts = first_value_contexts(len(section.channels))

    @property
    def base(self) -> ShortArray:
        """Values of slots 0 to 3 at the coarsest level, (4, k) int16 in steps."""
        return self._snapshots[0]

    @property
    def unpacked(self) -> int:
        """Number of groups that can be read."""
        return len(self._snapshots) - 1

    @property
    def nbytes(self) -> int:
        """Memory in bytes."""
        streams = self._streams
        left = streams.nbytes if streams is not None else 0
        own = self.edges.fraction.nbytes + self.edges.length.nbytes
        return left + own + sum(array.nbytes for array in (*self.splits, *list(self._snapshots)))

    def unpack(self, geometry: Splits) -> None:
        """Unpack and check the next group, with all splits at least up to its end.

        Damage raises a `HistoryFileError`; every later call raises the same error.
        """
        channels, scale, _ = self.section
        streams = cast("Streams", self._streams)
        with streams.next_group() as (name, start, end, reader):
            fraction, length = _edge_shapes(geometry, self._step, slice(start - 4, end - 4))
            edges = self.edges._replace(
                parent=geometry.parent,
                fraction=np.concatenate([self.edges.fraction, fraction]),
                length=np.concatenate([self.edges.length, length]),
                shifted_end=_stored_shift_ends(geometry, self.edges.corrected),
                shifted=geometry.shifted,
            )
            shifts_before, shifts = len(self.splits.shifted_fine), int(edges.shifted_end[end - 5])
            corrected = max(min(end - 4, edges.corrected) - (start - 4), 0)
            if reader.length < len(channels) * (end - start + corrected + shifts - shifts_before):
                raise HistoryFileError(
                    f"{reader.length // 8} bytes are too few for the device values of the"
                    f" splits that add slots {start} to {end - 1}",
                    where={"field": name},
                    remedy=DAMAGE_REMEDY,
                )
            rows = (end - 4, end - 4, end - 4, shifts, shifts)
            splits = SplitValues(*map(extended_copy, self.splits, rows))
            values = extended_copy(self._snapshots[-1], end)
            faulty = read_values(reader, self._contexts, edges, scale, values, splits, start, end)
            if faulty:
                raise HistoryFileError(
                    f"the device values of the split that adds slot {faulty} are not there, or"
                    f" not from 0 to {scale}",
                    where={"field": name, "slot": int(faulty)},
                    remedy=DAMAGE_REMEDY,
                )
        self.edges, self.splits = edges, splits
        self._snapshots.append(values)
        if streams.is_complete:
            self._streams = None

    def level(self, vertices: int) -> DeviceValues:
        """Return the values of a level as float32, in time proportional to the level.

        The level has 4 vertices to the end of the last group that is unpacked.
        """
        snapshot = self._snapshots[group_count(vertices)]
        values = level_values(vertices, snapshot, self.edges, self.splits)
        channels, scale, _ = self.section
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
    section = DeviceSection(device.channels, FULL_SCALE, CORRECTED)
    edges = _split_edges(splits, 1.0, CORRECTED)
    values = np.empty(device.values.shape, np.int16)
    values[slots] = np.rint(device.values.astype(np.float64) * FULL_SCALE)
    positions = extended_copy(splits.base_positions, splits.vertices)
    faces = extended_copy(splits.base_faces, 2 * splits.vertices - 4)
    refine(splits, positions, faces.reshape(-1), 4, splits.vertices)
    shifts = int(edges.shifted_end.max(initial=0))
    targets = np.concatenate([splits.coarse[: edges.corrected], splits.shifted_coarse[:shifts]])
    places = nearest_places(targets, positions, faces)
    corners = values[faces[places.faces]].astype(np.float64)
    one, two, three = np.moveaxis(corners, 1, 0)
    second, third = places.second[:, np.newaxis], places.third[:, np.newaxis]
    within = np.floor(one + second * (two - one) + third * (three - one) + 0.5)
    nearest = np.clip(within, corners.min(axis=1), corners.max(axis=1)).astype(np.int16)
    rows = np.empty((3, len(splits.parent), len(device.channels)), np.int16)
    shifted_coarse = nearest[edges.corrected :]
    columns = SplitValues(rows[0], rows[1], rows[2], shifted_coarse, np.empty_like(shifted_coarse))
    snapshots = [values.copy()]
    for start, end in reversed(group_ranges(splits.vertices)):
        collapse_values(values, edges, nearest, columns, start, end)
        snapshots.insert(0, values[:start].copy())
    return DeviceHistory(section, snapshots, columns, edges)


def device_streams(device: DeviceHistory, splits: Splits, step: float) -> list[ByteArray]:
    """Return the streams of a history file with device values, one per group."""
    channels, scale, corrected = device.section
    edges = _split_edges(splits, step, corrected)
    contexts = first_value_contexts(len(channels))
    return [
        stream_bytes(write_values(contexts, edges, scale, device.splits, start, end))
        for start, end in group_ranges(splits.vertices)
    ]


def open_device_history(
    section: DeviceSection,
    base: ShortArray,
    streams: Sequence[ByteArray],
    vertices: int,
    step: float,
) -> DeviceHistory:
    """Return the device values of a history file without unpacking any stream.

    `base` is `DeviceHistory.base`; there is one stream per group.
    """
    none = np.empty(0, np.int32)
    corrected = _corrected_splits(section.corrected, vertices - 4)
    edges = SplitEdges(none, np.empty(0), np.empty(0, np.uint8), none, none, corrected)
    splits = SplitValues(*np.empty((5, 0, len(section.channels)), np.int16))
    return DeviceHistory(section, [base], splits, edges, Streams(DEVICE, streams, vertices), step)


def parse_device_section(text: str) -> DeviceSection:
    """Return what the metadata of a history file says about its device values.

    Any text but JSON with ``channels``, ``steps`` and ``corrected`` raises a `HistoryFileError`.
    """
    try:
        entry: Mapping[str, object] = json.loads(text)
        channels = cast("list[str]", entry["channels"])
        scale, corrected = cast("int", entry["steps"]), cast("int", entry["corrected"])
        is_sound = (
            isinstance(channels, list)
            and all(isinstance(name, str) and len(name) <= LONGEST_NAME for name in channels)
            and 1 <= len(channels) <= MOST_CHANNELS
            and type(scale) is type(corrected) is int
            and 1 <= scale <= LARGEST_SCALE
            and corrected >= 0
        )
    except (ValueError, KeyError, TypeError, RecursionError):
        is_sound = False
    if not is_sound:
        raise HistoryFileError(
            f"the device channels are described by {text[:40]!r}",
            where={"field": "device"},
            remedy=f"Give JSON with the names of 1 to {MOST_CHANNELS} channels, with steps from 1 "
            f"to {LARGEST_SCALE}, and with the number of vertices below which levels are "
            "corrected.",
        )
    return DeviceSection(tuple(channels), scale, corrected)


def _stored_shift_ends(splits: Splits, corrected: int) -> IndexArray:
    """Return the ends of the parts of `splits.shifted`, of which only corrected splits have one."""
    ends = splits.shifted_end
    return np.clip(ends, 0, ends[:corrected].max(initial=0))


def _corrected_splits(corrected: int, splits: int) -> int:
    """Number of splits that lead to levels with fewer vertices than `corrected`."""
    return min(max(corrected - 4, 0), splits)


def _split_edges(splits: Splits, step: float, corrected: int) -> SplitEdges:
    count = _corrected_splits(corrected, len(splits.parent))
    fraction, length = _edge_shapes(splits, step, slice(None))
    ends = _stored_shift_ends(splits, count)
    return SplitEdges(splits.parent, fraction, length, ends, splits.shifted, count)


def _edge_shapes(splits: Splits, step: float, rows: slice) -> tuple[FloatArray, ByteArray]:
    """Return `fraction` and `length` of `SplitEdges` for some splits.

    Positions are multiples of a power of two and at most 2²⁴ steps from the origin. All sums are
    exact, so every reader gets the same quotients.
    """
    fine = splits.fine[rows].astype(np.float64)
    edge = splits.added[rows].astype(np.float64) - fine
    # einsum takes a third of the time of a product and a sum over three columns
    along = np.einsum("ij,ij->i", splits.coarse[rows] - fine, edge)
    square = np.einsum("ij,ij->i", edge, edge)
    fraction = np.zeros(len(edge))
    np.divide(along, square, out=fraction, where=square > 0)
    length = np.frexp(np.einsum("ij->i", np.abs(edge)) / step)[1]
    return np.clip(fraction, 0.0, 1.0), np.clip(length, 0, LENGTH_CLASSES - 1).astype(np.uint8)


FIRST_TOTAL = 32
"""Initial total of a context: the code expects differences of about 16 steps."""


DIFFERENCE, CORRECTION, MOVE = range(3)
"""Kinds of numbers: the difference between the ends of an edge, the correction of the interpolated
value, and the change of a neighbour that moves."""


def first_value_contexts(channels: int) -> Contexts:
    """Return the contexts at the beginning: one per kind, channel, interior flag and length."""
    size = 3 * channels * 2 * LENGTH_CLASSES
    return Contexts(np.full(size, FIRST_TOTAL, np.int64), np.ones(size, np.int64))


@kernel
def collapse_values(
    values: ShortArray,
    edges: SplitEdges,
    nearest: ShortArray,
    splits: SplitValues,
    start: int,
    end: int,
) -> None:
    """Collapse the values of a level with `end` slots to `start` in place, and record each split.

    `nearest` has the values of the full boundary nearest to the parents of corrected splits. The
    given `splits.shifted_coarse` has those nearest to the neighbours that move.
    """
    for split in range(end - 5, start - 5, -1):
        parent = edges.parent[split]
        for channel in range(values.shape[1]):
            fine = int(values[parent, channel])
            added = int(values[split + 4, channel])
            coarse = _interpolate(fine, added - fine, edges.fraction[split])
            if split < edges.corrected:
                coarse = int(nearest[split, channel])
            splits.fine[split, channel] = fine
            splits.added[split, channel] = added
            splits.coarse[split, channel] = coarse
            values[parent, channel] = coarse
        for index in range(part_begin(edges.shifted_end, split), edges.shifted_end[split]):
            for channel in range(values.shape[1]):
                splits.shifted_fine[index, channel] = values[edges.shifted[index], channel]
                values[edges.shifted[index], channel] = splits.shifted_coarse[index, channel]


@kernel
def write_values(
    contexts: Contexts, edges: SplitEdges, largest: int, splits: SplitValues, start: int, end: int
) -> BitWriter:
    """Write the values of the splits that add slots [start, end); `largest` is full scale."""
    channels = splits.coarse.shape[1]
    ends = edges.shifted_end
    numbers = 2 * (end - start) + part_begin(ends, end - 4) - part_begin(ends, start - 4)
    room = (numbers * channels * LONGEST_CODE) // 8 + 8
    writer = BitWriter(np.zeros(room, np.uint8), np.zeros(1, np.int64))
    for split in range(start - 4, end - 4):
        length = int(edges.length[split])
        for channel in range(channels):
            coarse = int(splits.coarse[split, channel])
            fine = int(splits.fine[split, channel])
            change = int(splits.added[split, channel]) - fine
            context = _context(DIFFERENCE, channel, channels, coarse, largest, length)
            write_adaptive(writer, contexts, context, encode_sign(change))
            if split < edges.corrected:
                correction = coarse - _interpolate(fine, change, edges.fraction[split])
                context = _context(CORRECTION, channel, channels, coarse, largest, length)
                write_adaptive(writer, contexts, context, encode_sign(correction))
        for index in range(part_begin(edges.shifted_end, split), edges.shifted_end[split]):
            for channel in range(channels):
                coarse = int(splits.shifted_coarse[index, channel])
                change = int(splits.shifted_fine[index, channel]) - coarse
                context = _context(MOVE, channel, channels, coarse, largest, length)
                write_adaptive(writer, contexts, context, encode_sign(change))
    return writer


@kernel
def read_values(
    reader: BitReader,
    contexts: Contexts,
    edges: SplitEdges,
    largest: int,
    values: ShortArray,
    splits: SplitValues,
    start: int,
    end: int,
) -> int:
    """Read the values of the splits that add slots [start, end), and apply them to a level.

    Return the first slot whose values are missing, or not from 0 to `largest`; 0 if there is none.
    """
    channels = values.shape[1]
    for slot in range(start, end):
        split = slot - 4
        parent, length = edges.parent[split], int(edges.length[split])
        for channel in range(channels):
            coarse = int(values[parent, channel])
            context = _context(DIFFERENCE, channel, channels, coarse, largest, length)
            change = decode_sign(read_adaptive(reader, contexts, context))
            correction = 0
            if split < edges.corrected:
                context = _context(CORRECTION, channel, channels, coarse, largest, length)
                correction = decode_sign(read_adaptive(reader, contexts, context))
            fine = coarse - correction - _interpolate(0, change, edges.fraction[split])
            added = fine + change
            if not (0 <= fine <= largest and 0 <= added <= largest):
                return slot
            splits.coarse[split, channel] = coarse
            splits.fine[split, channel] = fine
            splits.added[split, channel] = added
            values[parent, channel] = fine
            values[slot, channel] = added
        for index in range(part_begin(edges.shifted_end, split), edges.shifted_end[split]):
            moved = edges.shifted[index]
            for channel in range(channels):
                coarse = int(values[moved, channel])
                context = _context(MOVE, channel, channels, coarse, largest, length)
                fine = coarse + decode_sign(read_adaptive(reader, contexts, context))
                if not 0 <= fine <= largest:
                    return slot
                splits.shifted_coarse[index, channel] = coarse
                splits.shifted_fine[index, channel] = fine
                values[moved, channel] = fine
        if reader.position[0] > reader.length:
            return slot
    return 0


@kernel
def level_values(
    vertices: int, snapshot: ShortArray, edges: SplitEdges, splits: SplitValues
) -> ShortArray:
    """Return the (vertices, k) int16 values of a level from a snapshot that is not coarser."""
    values = snapshot[:vertices].copy()
    undo_splits(
        values,
        values.shape[1],
        len(snapshot),
        vertices,
        edges.parent,
        splits.coarse,
        edges.shifted_end,
        edges.shifted,
        splits.shifted_coarse,
    )
    return values


@inlined_kernel
def _interpolate(value: int, change: int, fraction: float) -> int:
    return value + math.floor(fraction * change + 0.5)


@inlined_kernel
def _context(kind: int, channel: int, channels: int, coarse: int, largest: int, length: int) -> int:
    """Context of a number. A channel at 0 or full scale mostly stays there."""
    interior = int(0 < coarse < largest)
    return ((kind * channels + channel) * 2 + interior) * LENGTH_CLASSES + length


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
