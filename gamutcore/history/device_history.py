"""Device values at the vertices of every level: what the device was told to make each colour.

The full boundary has them from the colours that it was wrapped around. Where an edge collapses,
the values of its two ends are interpolated at the place on the edge that is nearest to where the
vertex goes. That is as good as the colours themselves while edges are short. In coarse levels, with
fewer than `CORRECTED` vertices, it would lead astray bit by bit; there a vertex has, wherever it
goes, the values that the full boundary has nearest to it. Either way they are averages of the full
boundary's, within its range and its limits of ink.

Values are whole numbers of 1/5100 of full scale, in which whole percents and codes of eight
bits are exact. In a history file they are an optional section behind the geometry, told by
differences across the split edges and by corrections of the coarse levels; each group of them is
unpacked when a level that needs it is first asked for.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np

from gamutcore.errors import HistoryFileError, MeshError
from gamutcore.history.bit_codes import reader_of, written
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
from gamutcore.history.groups import (
    DAMAGED,
    DEVICE,
    Unbroken,
    group_name,
    groups_leading_to,
    groups_of,
    lengthened,
    refuse_bits_left,
)
from gamutcore.history.nearest_values import nearest_values
from gamutcore.history.stepping import refine
from gamutcore.mesh import DeviceValues

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.arrays import ByteArray, IndexArray, ShortArray
    from gamutcore.history.bit_codes import Contexts
    from gamutcore.history.prefix_order import Splits

__all__ = [
    "CORRECTED",
    "FULL_SCALE",
    "DeviceHistory",
    "DeviceSection",
    "PackedDeviceValues",
    "build_device_history",
    "device_history_in",
    "device_section",
    "packed_device_values",
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


class PackedStreams(NamedTuple):
    """What device values are unpacked from.

    Attributes
    ----------
    streams : sequence of (n,) uint8
        One for each group.
    contexts : Contexts
        As the groups that are unpacked have left them.
    step : float
        Of the grid that positions lie on.
    vertices : int
        Of the full boundary.
    """

    streams: Sequence[ByteArray]
    contexts: Contexts
    step: float
    vertices: int


class DeviceHistory:
    """Device values of all levels of a history.

    Parameters
    ----------
    section : DeviceSection
    base : (4, k) int16
        Values of slots 0 to 3 at the coarsest level, in steps.
    splits : SplitValues
    edges : SplitEdges
    packed : PackedStreams, optional
        What more rows of both are to be unpacked from; None if all are there.
    """

    def __init__(
        self,
        section: DeviceSection,
        base: ShortArray,
        splits: SplitValues,
        edges: SplitEdges,
        packed: PackedStreams | None = None,
    ) -> None:
        self.section = section
        self.base = base
        self.splits = splits
        self.edges = edges
        self._packed = packed
        vertices = len(edges.parent) + 4 if packed is None else packed.vertices
        self._groups = groups_of(vertices)
        self._snapshots = [base]
        self._unbroken = Unbroken()
        if packed is None:
            values = lengthened(base, vertices)
            for start, end in self._groups:
                split_values(values, edges, splits, start, end)
                self._snapshots.append(values[:end].copy())

    @property
    def unpacked(self) -> int:
        """How many groups can be read."""
        return len(self._snapshots) - 1

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        packed, snapshots = self._packed, list(self._snapshots)
        left = packed.streams[len(snapshots) - 1 :] if packed is not None else ()
        held = (self.splits, snapshots, left, (self.edges.place, self.edges.length))
        return sum(array.nbytes for arrays in held for array in arrays)

    def unpack(self, geometry: Splits) -> None:
        """Unpack and check the next group.

        Parameters
        ----------
        geometry : Splits
            At least to the end of that group.

        Raises
        ------
        HistoryFileError
            If it is damaged; from then on, whenever it is asked for.
        """
        with self._unbroken:
            snapshot = self._next_snapshot(geometry)
        self._snapshots.append(snapshot)
        if self.unpacked == len(self._groups):
            self._packed = None

    def level(self, vertices: int) -> DeviceValues:
        """Return the values of a level, in time proportional to it.

        Parameters
        ----------
        vertices : int
            From 4 to the number at the end of the last group that is unpacked.

        Returns
        -------
        DeviceValues
            float32, slot by slot.
        """
        snapshot = self._snapshots[groups_leading_to(vertices)]
        values = level_values(vertices, snapshot, self.edges, self.splits)
        channels, scale, _ = self.section
        return DeviceValues(channels, (values / scale).astype(np.float32))

    def _next_snapshot(self, geometry: Splits) -> ShortArray:
        packed = cast("PackedStreams", self._packed)
        channels, scale, _ = self.section
        number = self.unpacked
        start, end = self._groups[number]
        name = group_name(number, DEVICE)
        edges = self.edges._replace(
            parent=geometry.parent,
            place=lengthened(self.edges.place, end - 4),
            length=lengthened(self.edges.length, end - 4),
            shifted_end=geometry.shifted_end,
            shifted=geometry.shifted,
        )
        _fill_edges(edges, geometry, packed.step, slice(start - 4, end - 4))
        before, moves = _moves(edges, start), _moves(edges, end)
        corrected = max(min(end - 4, edges.corrected) - (start - 4), 0)
        reader = reader_of(packed.streams[number])
        if reader.length < len(channels) * (end - start + corrected + moves - before):
            raise HistoryFileError(
                f"{packed.streams[number].size} bytes are too few for the device values of the"
                f" splits that add slots {start} to {end - 1}",
                where={"field": name},
                remedy=DAMAGED,
            )
        rows = (*(end - 4,) * 3, moves, moves)
        splits = SplitValues(*map(lengthened, self.splits, rows))
        values = lengthened(self._snapshots[-1], end)
        faulty = read_values(reader, packed.contexts, edges, scale, values, splits, start, end)
        if faulty:
            raise HistoryFileError(
                f"the device values of the split that adds slot {faulty} are not there, or not"
                f" from 0 to {scale}",
                where={"field": name, "slot": int(faulty)},
                remedy=DAMAGED,
            )
        refuse_bits_left(reader, name)
        self.edges, self.splits = edges, splits
        return values


def build_device_history(device: DeviceValues, slots: IndexArray, splits: Splits) -> DeviceHistory:
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
    moves = _moves(edges, splits.vertices)
    rows = (*(len(edges.parent),) * 3, moves, moves)
    columns = SplitValues(*(np.empty((count, channels), np.int16) for count in rows))
    places = splits.coarse[: edges.corrected], splits.shifted_coarse[:moves]
    found = nearest_values(np.concatenate(places), positions, faces, values)
    nearest = NearestValues(found[: edges.corrected], found[edges.corrected :])
    collapse_values(values, edges, nearest, columns)
    section = DeviceSection(device.channels, FULL_SCALE, CORRECTED)
    return DeviceHistory(section, values[:4].copy(), columns, edges)


def packed_device_values(device: DeviceHistory, splits: Splits, step: float) -> PackedDeviceValues:
    """Return device values as a history file holds them.

    Parameters
    ----------
    device : DeviceHistory
    splits : Splits
    step : float
        Of the grid that positions lie on.

    Returns
    -------
    PackedDeviceValues
    """
    channels, scale, corrected = device.section
    edges = _split_edges(splits, step, corrected)
    contexts = first_value_contexts(len(channels))
    streams = [
        written(write_values(contexts, edges, scale, device.splits, start, end))
        for start, end in groups_of(splits.vertices)
    ]
    return PackedDeviceValues(device.section, device.base.astype("<i4"), streams)


def device_history_in(packed: PackedDeviceValues, vertices: int, step: float) -> DeviceHistory:
    """Return the device values that a history file holds, of which nothing is unpacked yet.

    Parameters
    ----------
    packed : PackedDeviceValues
    vertices : int
        Of the full boundary.
    step : float
        Of the grid that positions lie on.

    Returns
    -------
    DeviceHistory
    """
    channels = len(packed.section.channels)
    edges = _empty_edges(0, _corrected_splits(packed.section.corrected, vertices - 4))
    columns = SplitValues(*(np.empty((0, channels), np.int16) for _ in SplitValues._fields))
    streams = PackedStreams(packed.streams, first_value_contexts(channels), step, vertices)
    return DeviceHistory(packed.section, packed.base.astype(np.int16), columns, edges, streams)


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


def _moves(edges: SplitEdges, end: int) -> int:
    """How many moves of neighbours the splits below a slot tell the values of."""
    told = min(end - 4, edges.corrected)
    return int(edges.shifted_end[told - 1]) if told > 0 else 0


def _empty_edges(splits: int, corrected: int) -> SplitEdges:
    """Return edges of so many splits, of which nothing is known yet but how many are corrected."""
    return SplitEdges(
        np.empty(splits, np.int32),
        np.empty(splits),
        np.empty(splits, np.uint8),
        np.empty(splits, np.int32),
        np.empty(0, np.int32),
        corrected,
    )


def _corrected_splits(corrected: int, splits: int) -> int:
    """How many splits, from the first one on, lead to levels with fewer vertices than that."""
    return min(max(corrected - 4, 0), splits)


def _split_edges(splits: Splits, step: float, corrected: int) -> SplitEdges:
    """Return what device values are told by, of all splits."""
    count = len(splits.parent)
    edges = _empty_edges(count, _corrected_splits(corrected, count))._replace(
        parent=splits.parent, shifted_end=splits.shifted_end, shifted=splits.shifted
    )
    _fill_edges(edges, splits, step, slice(None))
    return edges


def _fill_edges(edges: SplitEdges, splits: Splits, step: float, rows: slice) -> None:
    """Put down where on its edge each split's parent was, and how long the edge is.

    Positions are on a grid of a power of two, at most 2²⁴ steps from the origin: the sums here
    are exact, so every reader gets the same quotients.
    """
    fine = splits.fine[rows].astype(np.float64)
    edge = splits.added[rows].astype(np.float64) - fine
    along = ((splits.coarse[rows] - fine) * edge).sum(axis=1)
    square = (edge * edge).sum(axis=1)
    place = np.zeros(len(edge))
    np.divide(along, square, out=place, where=square > 0)
    length = np.frexp(np.abs(edge).sum(axis=1) / step)[1]
    edges.place[rows] = np.clip(place, 0.0, 1.0)
    edges.length[rows] = np.clip(length, 0, LENGTHS - 1)
