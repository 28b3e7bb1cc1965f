"""Device values at the vertices of every level: what the device was told to make each colour.

The full boundary has them from the colours that it was wrapped around. Where an edge collapses,
the values of its two ends are interpolated at the place on the edge that is nearest to where the
vertex goes, so every level's values are averages of the full boundary's: they stay on the faces,
and within the ink limits, that these are on. A vertex that only moves keeps its values.

Values are whole numbers of 1/5100 of full scale, in which whole percents and codes of eight
bits are exact. In a history file they are an optional section behind the geometry, told by
differences across the split edges; they are unpacked when they are first asked for.
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
    SplitValues,
    collapse_values,
    first_value_contexts,
    level_values,
    read_values,
    split_values,
    write_values,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.arrays import ByteArray, FloatArray, IndexArray, ShortArray
    from gamutcore.history.prefix_order import Splits

__all__ = [
    "FULL_SCALE",
    "DeviceHistory",
    "PackedDeviceValues",
    "device_history_of",
    "device_scale",
    "packed_device_values",
    "unpacked_device_values",
]

FULL_SCALE = 5100
"""Steps of full scale: 51 for each percent, 20 for each of 255 codes."""

LARGEST_SCALE = 2**15 - 1
"""Values in steps must be within int16."""

MOST_CHANNELS = 64
"""More than any characterisation has; bounds what a file may ask for."""

LONGEST_NAME = 1000
"""Characters of a channel's name."""


class PackedDeviceValues(NamedTuple):
    """The section of a history file that holds device values.

    Attributes
    ----------
    channels : tuple of str
    scale : int
        Steps of full scale.
    base : (4, k) int32
        Values of slots 0 to 3 at the coarsest level, in steps.
    streams : list of (n,) uint8
        The groups of splits, as those of the geometry.
    """

    channels: tuple[str, ...]
    scale: int
    base: IndexArray
    streams: Sequence[ByteArray]


class DeviceHistory:
    """Device values of all levels of a history.

    Parameters
    ----------
    channels : tuple of str
    scale : int
        Steps of full scale.
    base : (4, k) int16
        Values of slots 0 to 3 at the coarsest level, in steps.
    splits : SplitValues
    parent : (V − 4,) int32
        The slot that each split splits.
    """

    def __init__(
        self,
        channels: tuple[str, ...],
        scale: int,
        base: ShortArray,
        splits: SplitValues,
        parent: IndexArray,
    ) -> None:
        self.channels = channels
        self.scale = scale
        self.base = base
        self.splits = splits
        self._parent = parent
        total = len(parent) + 4
        values = np.empty((total, len(channels)), np.int16)
        values[:4] = base
        self._counts, self._snapshots = [4], [values[:4].copy()]
        while self._counts[-1] < total:
            count = min(2 * self._counts[-1], total)
            split_values(values, parent, splits, self._counts[-1], count)
            self._counts.append(count)
            self._snapshots.append(values[:count].copy())

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return sum(array.nbytes for array in (self.base, *self.splits, *self._snapshots))

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
        values = level_values(vertices, self._snapshots[index], self._parent, self.splits)
        return DeviceValues(self.channels, (values / self.scale).astype(np.float32))


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
    values = np.empty(device.values.shape, np.int16)
    values[slots] = np.rint(device.values.astype(np.float64) * FULL_SCALE)
    shape = (len(values) - 4, values.shape[1])
    columns = SplitValues(*(np.empty(shape, np.int16) for _ in range(3)))
    place, _ = _split_edges(splits, 1.0)
    collapse_values(values, splits.parent, place, columns)
    return DeviceHistory(device.channels, FULL_SCALE, values[:4].copy(), columns, splits.parent)


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
    _, length = _split_edges(splits, step)
    contexts = first_value_contexts(len(device.channels))
    streams = [
        written(write_values(contexts, length, device.scale, device.splits, start, end))
        for start, end in groups
    ]
    return PackedDeviceValues(device.channels, device.scale, device.base.astype("<i4"), streams)


def unpacked_device_values(
    packed: PackedDeviceValues, splits: Splits, step: float, groups: Sequence[tuple[int, int]]
) -> DeviceHistory:
    """Return device values from what a history file holds; parameters as of the other direction.

    Raises
    ------
    HistoryFileError
        If a stream ends early or late, or puts a value beyond 0 and full scale.
    """
    place, length = _split_edges(splits, step)
    channels = len(packed.channels)
    contexts = first_value_contexts(channels)
    values = np.empty((splits.vertices, channels), np.int16)
    values[:4] = packed.base
    columns = SplitValues(*(np.empty((splits.vertices - 4, channels), np.int16) for _ in range(3)))
    for number, (start, end) in enumerate(groups):
        reader = reader_of(packed.streams[number])
        faulty = read_values(
            reader,
            contexts,
            splits.parent,
            place,
            length,
            packed.scale,
            values,
            columns,
            start,
            end,
        )
        if faulty:
            raise HistoryFileError(
                f"the device values of the split that adds slot {faulty} are not there, or not"
                f" from 0 to {packed.scale}",
                where={"field": f"device.{number:02d}", "slot": int(faulty)},
                remedy="the file as it was delivered, unchanged",
            )
        left = reader.length - int(reader.place[0])
        if left >= 8 or read_bits(reader, left):
            raise HistoryFileError(
                f"the last device values of a group leave {left} bits over",
                where={"field": f"device.{number:02d}"},
                remedy="zeros up to the end of a byte",
            )
    base = packed.base.astype(np.int16)
    return DeviceHistory(packed.channels, packed.scale, base, columns, splits.parent)


def device_scale(text: str) -> tuple[tuple[str, ...], int]:
    """Return channels and steps of full scale from a history file's metadata.

    Parameters
    ----------
    text : str
        JSON with ``channels`` and ``steps``.

    Returns
    -------
    channels : tuple of str
    scale : int

    Raises
    ------
    HistoryFileError
        If it is anything else.
    """
    try:
        entry: Mapping[str, object] = json.loads(text)
        channels, scale = cast("list[str]", entry["channels"]), cast("int", entry["steps"])
        sound = (
            isinstance(channels, list)
            and all(isinstance(name, str) and len(name) <= LONGEST_NAME for name in channels)
            and 1 <= len(channels) <= MOST_CHANNELS
            and type(scale) is int
            and 1 <= scale <= LARGEST_SCALE
        )
    except (ValueError, KeyError, TypeError, RecursionError):
        sound = False
    if not sound:
        raise HistoryFileError(
            f"the device channels are described by {text[:40]!r}",
            where={"field": "device"},
            remedy=f"JSON with the names of 1 to {MOST_CHANNELS} channels, and with steps from 1 to"
            f" {LARGEST_SCALE}",
        )
    return tuple(channels), scale


def _split_edges(splits: Splits, step: float) -> tuple[FloatArray, ByteArray]:
    """Where on its edge each split's parent was, from 0 (parent) to 1 (new slot); length classes.

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
    return np.clip(place, 0.0, 1.0), np.clip(length, 0, LENGTHS - 1).astype(np.uint8)
