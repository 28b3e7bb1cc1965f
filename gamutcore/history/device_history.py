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
    split_values,
    write_values,
)
from gamutcore.history.nearest_values import nearest_values
from gamutcore.history.prefix_order import group_count, group_ranges
from gamutcore.history.stepping import refine
from gamutcore.history.streams import DAMAGE_REMEDY, DEVICE, Streams, extended_copy
from gamutcore.mesh import DeviceValues

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.arrays import ByteArray, IndexArray, ShortArray
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
    base : (4, k) int16
        Values of slots 0 to 3 at the coarsest level, in steps.
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
        base: ShortArray,
        splits: SplitValues,
        edges: SplitEdges,
        streams: Streams | None = None,
        step: float = 1.0,
    ) -> None:
        self.section = section
        self.base = base
        self.splits = splits
        self.edges = edges
        self._streams = streams
        self._step = step
        self._contexts = first_value_contexts(len(section.channels))
        self._snapshots = [base]
        if streams is None:
            values = extended_copy(base, len(edges.parent) + 4)
            for start, end in group_ranges(len(values)):
                split_values(values, edges, splits, start, end)
                self._snapshots.append(values[:end].copy())

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
        """Unpack and check the next group.

        Parameters
        ----------
        geometry : Splits
            Rows at least to the end of that group.

        Raises
        ------
        HistoryFileError
            If the group is damaged; every later call raises the same error.
        """
        channels, scale, _ = self.section
        streams = cast("Streams", self._streams)
        with streams.next_group() as (name, start, end, reader):
            edges = self.edges._replace(
                parent=geometry.parent,
                fraction=extended_copy(self.edges.fraction, end - 4),
                length=extended_copy(self.edges.length, end - 4),
                shifted_end=geometry.shifted_end,
                shifted=geometry.shifted,
            )
            _fill_edges(edges, geometry, self._step, slice(start - 4, end - 4))
            shifts_before, shifts = _stored_shifts(edges, start), _stored_shifts(edges, end)
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

    Parameters
    ----------
    device : DeviceValues
        Values at the vertices of the full boundary.
    slots : (V,) int32
        Slot of each of these vertices.
    splits : Splits

    Returns
    -------
    DeviceHistory

    Raises
    ------
    MeshError
        If the number of rows is not the number of vertices.
    """
    if len(device) != len(slots):
        raise MeshError(
            f"there are device values of {len(device)} vertices, not of {len(slots)}",
            where={"field": "device"},
            remedy="one row for each vertex of the full boundary",
        )
    section = DeviceSection(device.channels, FULL_SCALE, CORRECTED)
    edges = _split_edges(splits, 1.0, CORRECTED)
    values = np.empty(device.values.shape, np.int16)
    values[slots] = np.rint(device.values.astype(np.float64) * FULL_SCALE)
    positions = extended_copy(splits.base_positions, splits.vertices)
    faces = extended_copy(splits.base_faces, 2 * splits.vertices - 4)
    refine(splits, positions, faces.reshape(-1), 4, splits.vertices)
    shifts = _stored_shifts(edges, splits.vertices)
    targets = np.concatenate([splits.coarse[: edges.corrected], splits.shifted_coarse[:shifts]])
    nearest = nearest_values(targets, positions, faces, values)
    rows = np.empty((3, len(splits.parent), len(device.channels)), np.int16)
    shifted_coarse = nearest[edges.corrected :]
    columns = SplitValues(rows[0], rows[1], rows[2], shifted_coarse, np.empty_like(shifted_coarse))
    collapse_values(values, edges, nearest, columns)
    return DeviceHistory(section, values[:4].copy(), columns, edges)


def device_streams(device: DeviceHistory, splits: Splits, step: float) -> list[ByteArray]:
    """Return the streams of a history file with device values, one per group.

    Parameters
    ----------
    device : DeviceHistory
    splits : Splits
    step : float
        Step of the grid of the positions.
    """
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

    Parameters
    ----------
    section : DeviceSection
    base : (4, k) int16
        Values of slots 0 to 3 at the coarsest level, in steps.
    streams : sequence of (n,) uint8
        One per group.
    vertices : int
        Vertices of the full boundary.
    step : float
        Step of the grid of the positions.
    """
    edges = SplitEdges(
        parent=np.empty(0, np.int32),
        fraction=np.empty(0),
        length=np.empty(0, np.uint8),
        shifted_end=np.empty(0, np.int32),
        shifted=np.empty(0, np.int32),
        corrected=_corrected_splits(section.corrected, vertices - 4),
    )
    splits = SplitValues(*np.empty((5, 0, len(section.channels)), np.int16))
    return DeviceHistory(section, base, splits, edges, Streams(DEVICE, streams, vertices), step)


def parse_device_section(text: str) -> DeviceSection:
    """Return what the metadata of a history file says about its device values.

    Parameters
    ----------
    text : str
        JSON with ``channels``, ``steps`` and ``corrected``.

    Raises
    ------
    HistoryFileError
        If the text is anything else.

    Examples
    --------
    >>> parse_device_section('{"channels":["C","M"],"steps":100,"corrected":0}').channels
    ('C', 'M')
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
            remedy=f"JSON with the names of 1 to {MOST_CHANNELS} channels, with steps from 1 to"
            f" {LARGEST_SCALE}, and with the number of vertices below which levels are corrected",
        )
    return DeviceSection(tuple(channels), scale, corrected)


def _stored_shifts(edges: SplitEdges, end: int) -> int:
    """Number of moved neighbours whose values are stored, over all splits below a slot."""
    splits = min(end - 4, edges.corrected)
    return int(edges.shifted_end[splits - 1]) if splits > 0 else 0


def _corrected_splits(corrected: int, splits: int) -> int:
    """Number of splits that lead to levels with fewer vertices than `corrected`."""
    return min(max(corrected - 4, 0), splits)


def _split_edges(splits: Splits, step: float, corrected: int) -> SplitEdges:
    count = len(splits.parent)
    edges = SplitEdges(
        parent=splits.parent,
        fraction=np.empty(count),
        length=np.empty(count, np.uint8),
        shifted_end=splits.shifted_end,
        shifted=splits.shifted,
        corrected=_corrected_splits(corrected, count),
    )
    _fill_edges(edges, splits, step, slice(None))
    return edges


def _fill_edges(edges: SplitEdges, splits: Splits, step: float, rows: slice) -> None:
    """Compute fractions and length classes of the edges of some splits.

    Positions are multiples of a power of two and at most 2²⁴ steps from the origin. All sums are
    exact, so every reader gets the same quotients.
    """
    fine = splits.fine[rows].astype(np.float64)
    edge = splits.added[rows].astype(np.float64) - fine
    along = ((splits.coarse[rows] - fine) * edge).sum(axis=1)
    square = (edge * edge).sum(axis=1)
    fraction = np.zeros(len(edge))
    np.divide(along, square, out=fraction, where=square > 0)
    length = np.frexp(np.abs(edge).sum(axis=1) / step)[1]
    edges.fraction[rows] = np.clip(fraction, 0.0, 1.0)
    edges.length[rows] = np.clip(length, 0, LENGTH_CLASSES - 1)
