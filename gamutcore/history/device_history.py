"""Device values at the vertices of every level: the device input that produces each colour.

The vertices of the full boundary have the device values of their colours. When an edge collapses,
the values are interpolated at the point of the edge nearest to the new vertex. That is as accurate
as the colours while edges are short, but errors add up. In levels with fewer than `CORRECTED`
vertices a vertex therefore has the values that the full boundary has nearest to it. Either way
values are averages of those of the full boundary, within its range and ink limits.

Values are integers in steps of 1/5100 of full scale; whole percents and 8-bit codes are exact. In a
history file they are an optional section behind the geometry, with one stream per group.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np

from gamutcore.errors import HistoryFileError, MeshError
from gamutcore.history.bit_codes import stream_bytes
from gamutcore.history.device_codes import (
    LENGTH_CLASSES,
    SplitEdges,
    SplitValues,
    collapse_values,
    first_value_contexts,
    level_values,
    read_values,
    write_values,
)
from gamutcore.history.nearest_values import nearest_values
from gamutcore.history.prefix_order import extended_copy, group_count, group_ranges
from gamutcore.history.stepping import refine
from gamutcore.history.streams import DAMAGE_REMEDY, DEVICE, Streams
from gamutcore.mesh import DeviceValues

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.arrays import ByteArray, FloatArray, IndexArray, ShortArray
    from gamutcore.history.prefix_order import Splits

__all__ = [
    "CORRECTED",
    "FULL_SCALE",
    "DeviceHistory",
    "DeviceSection",
    "build_device_history",
    "device_streams",
    "open_device_history",
    "parse_device_section",
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
    """What the metadata of a history file says about its device values.

    Attributes
    ----------
    channels : tuple of str
    scale : int
        Steps of full scale.
    corrected : int
        Levels with fewer vertices have corrections.
    """

    channels: tuple[str, ...]
    scale: int
    corrected: int

    def to_json(self) -> str:
        """Return the text for the metadata."""
        entry = {"channels": self.channels, "steps": self.scale, "corrected": self.corrected}
        return json.dumps(entry, separators=(",", ":"))


class DeviceHistory:
    """Device values of all levels of a history.

    Parameters
    ----------
    section : DeviceSection
    snapshots : list of (v, k) int16
        Values of the levels with 4, 8, 16, … vertices, in steps, as far as they are unpacked. The
        last snapshot of an unpacked history is the full boundary.
    splits : SplitValues
    edges : SplitEdges
    streams : Streams, optional
        Streams from which more rows of `splits` and `edges` are unpacked; None if all are there.
    step : float, optional
        Step of the grid of the positions; only used with `streams`.
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

        Parameters
        ----------
        vertices : int
            From 4 to the end of the last group that is unpacked.

        Returns
        -------
        DeviceValues
            In the order of the slots.
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
    nearest = nearest_values(targets, positions, faces, values)
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
