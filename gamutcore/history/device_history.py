"""Device values at the vertices of every level: what the device was told to make each colour.

The full boundary has them from the colours that it was wrapped around. Where an edge collapses,
the values of its two ends are interpolated at the place on the edge that is nearest to where the
vertex goes. That is as good as the colours themselves while edges are short. In coarse levels, with
fewer than `CORRECTED` vertices, it would lead astray bit by bit; there a vertex has, wherever it
goes, the values that the full boundary has nearest to it. Either way they are averages of the full
boundary's, within its range and its limits of ink.

Values are whole numbers of 1/5100 of full scale, in which whole percents and codes of eight
bits are exact. In a history file they are an optional section behind the geometry, told by
differences across the split edges and by corrections of the coarse levels; they are unpacked when
they are first asked for.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np

from gamutcore.device_values import DeviceValues
from gamutcore.errors import HistoryFileError, MeshError
from gamutcore.history.bit_codes import read_bits, reader_of, written
from gamutcore.history.device_codes import (
    LENGTHS,
    NearestValues,
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
from gamutcore.history.stepping import refine

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.arrays import ByteArray, IndexArray, ShortArray
    from gamutcore.history.prefix_order import Splits

__all__ = [
    "CORRECTED",
    "FULL_SCALE",
    "DeviceHistory",
    "DeviceSection",
    "PackedDeviceValues",
    "device_history_of",
    "device_section",
    "packed_device_values",
    "unpacked_device_values",
]

FULL_SCALE = 5100
"""Steps of full scale: 51 for each percent, 20 for each of 255 codes."""

CORRECTED = 8192
"""Levels with fewer vertices have corrections: a twentieth of the error with 500 vertices, for
2 bits for each vertex of the full boundary."""

LARGEST_SCALE = 2**15 - 1
"""Values in steps must be within int16."""

MOST_CHANNELS = 64
"""More than any characterisation has; bounds what a file may ask for."""

DELIVERED = "the file as it was delivered, unchanged"

LONGEST_NAME = 1000
"""Characters of a channel's name."""


class DeviceSection(NamedTuple):
    """What a history file says of its device values in its metadata.

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


class PackedDeviceValues(NamedTuple):
    """The section of a history file that holds device values.

    Attributes
    ----------
    section : DeviceSection
    base : (4, k) int32
        Values of slots 0 to 3 at the coarsest level, in steps.
    streams : list of (n,) uint8
        The groups of splits, as those of the geometry.
    """

    section: DeviceSection
    base: IndexArray
    streams: Sequence[ByteArray]


class DeviceHistory:
    """Device values of all levels of a history.

    Parameters
    ----------
    section : DeviceSection
    base : (4, k) int16
        Values of slots 0 to 3 at the coarsest level, in steps.
    splits : SplitValues
    edges : SplitEdges
    """

    def __init__(
        self, section: DeviceSection, base: ShortArray, splits: SplitValues, edges: SplitEdges
    ) -> None:
        self.section = section
        self.base = base
        self.splits = splits
        self.edges = edges
        total = len(edges.parent) + 4
        values = np.empty((total, len(section.channels)), np.int16)
        values[:4] = base
        self._counts, self._snapshots = [4], [values[:4].copy()]
        while self._counts[-1] < total:
            count = min(2 * self._counts[-1], total)
            split_values(values, edges, splits, self._counts[-1], count)
            self._counts.append(count)
            self._snapshots.append(values[:count].copy())

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        edges = self.edges.place.nbytes + self.edges.length.nbytes + self.base.nbytes
        return edges + sum(array.nbytes for array in (*self.splits, *self._snapshots))

    def level(self, vertices: int) -> DeviceValues:
        """Return the values of a level, in time proportional to it.

        Parameters
        ----------
        vertices : int
            From 4 to the full boundary's number.

        Returns
        -------
        DeviceValues
            float32, slot by slot.
        """
        index = min((vertices - 1).bit_length() - 2, len(self._counts) - 1)
        values = level_values(vertices, self._snapshots[index], self.edges, self.splits)
        channels, scale, _ = self.section
        return DeviceValues(channels, (values / scale).astype(np.float32))


def device_history_of(device: DeviceValues, slots: IndexArray, splits: Splits) -> DeviceHistory:
    """Return the device values of all levels from those of the full boundary.

    Parameters
    ----------
    device : DeviceValues
        Of the vertices of the full boundary.
    slots : (V,) int32
        The slot that each of these vertices is.
    splits : Splits

    Returns
    -------
    DeviceHistory

    Raises
    ------
    MeshError
        If there is not one row for each vertex.
    """
    if len(device) != len(slots):
        raise MeshError(
            f"there are device values of {len(device)} vertices, not of {len(slots)}",
            where={"field": "device"},
            remedy="one row for each vertex of the full boundary",
        )
    channels = len(device.channels)
    edges = _split_edges(splits, 1.0, CORRECTED)
    values = np.empty(device.values.shape, np.int16)
    values[slots] = np.rint(device.values.astype(np.float64) * FULL_SCALE)
    positions = np.empty((splits.vertices, 3), np.float32)
    faces = np.empty((2 * splits.vertices - 4, 3), np.int32)
    positions[:4], faces[:4] = splits.base_positions, splits.base_faces
    refine(splits, positions, faces.reshape(-1), 4, splits.vertices)
    columns = _empty_columns(edges, channels)
    places = splits.coarse[: edges.corrected], splits.shifted_coarse[: len(columns.shifted_coarse)]
    found = nearest_values(np.concatenate(places), positions, faces, values)
    nearest = NearestValues(found[: edges.corrected], found[edges.corrected :])
    collapse_values(values, edges, nearest, columns)
    section = DeviceSection(device.channels, FULL_SCALE, CORRECTED)
    return DeviceHistory(section, values[:4].copy(), columns, edges)


def packed_device_values(
    device: DeviceHistory, splits: Splits, step: float, groups: Sequence[tuple[int, int]]
) -> PackedDeviceValues:
    """Return device values as a history file holds them.

    Parameters
    ----------
    device : DeviceHistory
    splits : Splits
    step : float
        Of the grid that positions lie on.
    groups : sequence of (int, int)
        The slots that each group adds: the first, and the one behind the last.

    Returns
    -------
    PackedDeviceValues
    """
    channels, scale, corrected = device.section
    edges = _split_edges(splits, step, corrected)
    contexts = first_value_contexts(len(channels))
    streams = [
        written(write_values(contexts, edges, scale, device.splits, start, end))
        for start, end in groups
    ]
    return PackedDeviceValues(device.section, device.base.astype("<i4"), streams)


def unpacked_device_values(
    packed: PackedDeviceValues, splits: Splits, step: float, groups: Sequence[tuple[int, int]]
) -> DeviceHistory:
    """Return device values from what a history file holds; parameters as of the other direction.

    Raises
    ------
    HistoryFileError
        If a stream ends early or late, or puts a value beyond 0 and full scale.
    """
    channels, scale, corrected = packed.section
    edges = _split_edges(splits, step, corrected)
    moves = int(edges.shifted_end[edges.corrected - 1]) if edges.corrected else 0
    least = len(channels) * (len(edges.parent) + edges.corrected + moves)
    if 8 * sum(stream.size for stream in packed.streams) < least:
        raise HistoryFileError(
            "the streams of device values are too short for the splits of the history",
            where={"field": "device"},
            remedy=DELIVERED,
        )
    contexts = first_value_contexts(len(channels))
    values = np.empty((splits.vertices, len(channels)), np.int16)
    values[:4] = packed.base
    columns = _empty_columns(edges, len(channels))
    for number, (start, end) in enumerate(groups):
        reader = reader_of(packed.streams[number])
        faulty = read_values(reader, contexts, edges, scale, values, columns, start, end)
        if faulty:
            raise HistoryFileError(
                f"the device values of the split that adds slot {faulty} are not there, or not"
                f" from 0 to {scale}",
                where={"field": f"device.{number:02d}", "slot": int(faulty)},
                remedy=DELIVERED,
            )
        left = reader.length - int(reader.place[0])
        if left >= 8 or read_bits(reader, left):
            raise HistoryFileError(
                f"the last device values of a group leave {left} bits over",
                where={"field": f"device.{number:02d}"},
                remedy="zeros up to the end of a byte",
            )
    return DeviceHistory(packed.section, packed.base.astype(np.int16), columns, edges)


def device_section(text: str) -> DeviceSection:
    """Return what a history file's metadata says of device values.

    Parameters
    ----------
    text : str
        JSON with ``channels``, ``steps`` and ``corrected``.

    Returns
    -------
    DeviceSection

    Raises
    ------
    HistoryFileError
        If it is anything else.
    """
    try:
        entry: Mapping[str, object] = json.loads(text)
        channels = cast("list[str]", entry["channels"])
        scale, corrected = cast("int", entry["steps"]), cast("int", entry["corrected"])
        sound = (
            isinstance(channels, list)
            and all(isinstance(name, str) and len(name) <= LONGEST_NAME for name in channels)
            and 1 <= len(channels) <= MOST_CHANNELS
            and type(scale) is type(corrected) is int
            and 1 <= scale <= LARGEST_SCALE
            and corrected >= 0
        )
    except (ValueError, KeyError, TypeError, RecursionError):
        sound = False
    if not sound:
        raise HistoryFileError(
            f"the device channels are described by {text[:40]!r}",
            where={"field": "device"},
            remedy=f"JSON with the names of 1 to {MOST_CHANNELS} channels, with steps from 1 to"
            f" {LARGEST_SCALE}, and with the number of vertices below which levels are corrected",
        )
    return DeviceSection(tuple(channels), scale, corrected)


def _empty_columns(edges: SplitEdges, channels: int) -> SplitValues:
    moves = int(edges.shifted_end[edges.corrected - 1]) if edges.corrected else 0
    rows = (*(len(edges.parent),) * 3, moves, moves)
    return SplitValues(*(np.empty((count, channels), np.int16) for count in rows))


def _split_edges(splits: Splits, step: float, corrected: int) -> SplitEdges:
    """Return where on its edge each split's parent was, and how long the edge is.

    Positions are on a grid of a power of two, at most 2²⁴ steps from the origin: the sums here
    are exact, so every reader gets the same quotients.
    """
    fine = splits.fine.astype(np.float64)
    edge = splits.added.astype(np.float64) - fine
    along = ((splits.coarse - fine) * edge).sum(axis=1)
    square = (edge * edge).sum(axis=1)
    place = np.zeros(len(edge))
    np.divide(along, square, out=place, where=square > 0)
    length = np.frexp(np.abs(edge).sum(axis=1) / step)[1]
    return SplitEdges(
        splits.parent,
        np.clip(place, 0.0, 1.0),
        np.clip(length, 0, LENGTHS - 1).astype(np.uint8),
        splits.shifted_end,
        splits.shifted,
        min(max(corrected - 4, 0), len(edge)),
    )
