"""Kernels of `gamutcore.history.device_history`: device values through splits and collapses.

They are whole numbers of steps here. Where an edge collapses, the values follow the place between
those of its two ends, rounded; the difference between the ends is then all that is needed to get
both back, exactly, as in integer lifting (Calderbank, Daubechies, Sweldens & Yeo, "Wavelet
transforms that map integers to integers", 1998).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, FloatArray, IndexArray, ShortArray
from gamutcore.history.bit_codes import (
    LONGEST_CODE,
    BitReader,
    BitWriter,
    Contexts,
    read_adaptive,
    write_adaptive,
)
from gamutcore.kernels import kernel, leaf_kernel

__all__ = [
    "LENGTHS",
    "SplitValues",
    "collapse_values",
    "first_value_contexts",
    "level_values",
    "read_values",
    "split_values",
    "write_values",
]

LENGTHS = 32
"""Classes of edges by their length."""

FIRST_TOTAL = 32
"""What the adaptive code expects at first: differences of 32 steps, in its mapping."""


class SplitValues(NamedTuple):
    """Device values at splits, row i being the split that adds slot i + 4; in steps.

    Attributes
    ----------
    coarse, fine : (V − 4, k) int16
        Of the parent before and after the split.
    added : (V − 4, k) int16
        Of the new slot.
    """

    coarse: ShortArray
    fine: ShortArray
    added: ShortArray


def first_value_contexts(channels: int) -> Contexts:
    """Return the contexts as they are at the beginning: of each channel, edge length and kind.

    Parameters
    ----------
    channels : int

    Returns
    -------
    Contexts
    """
    size = channels * 2 * LENGTHS
    return Contexts(np.full(size, FIRST_TOTAL, np.int64), np.ones(size, np.int64))


@leaf_kernel
def collapse_values(
    values: ShortArray, parent: IndexArray, place: FloatArray, splits: SplitValues
) -> None:
    """Go from the full boundary to four slots, in place, and write down each split.

    Parameters
    ----------
    values : (V, k) int16
        Of the full boundary; of four slots afterwards.
    parent : (V − 4,) int32
    place : (V − 4,) float64
        How far along the edge from the parent to the new slot the collapse leads, 0 to 1.
    splits : SplitValues
        Receives the values.
    """
    for split in range(len(parent) - 1, -1, -1):
        above = parent[split]
        for channel in range(values.shape[1]):
            fine = np.int64(values[above, channel])
            added = np.int64(values[split + 4, channel])
            coarse = fine + math.floor(place[split] * (added - fine) + 0.5)
            splits.fine[split, channel] = fine
            splits.added[split, channel] = added
            splits.coarse[split, channel] = coarse
            values[above, channel] = coarse


@kernel
def write_values(
    contexts: Contexts,
    length: ByteArray,
    largest: int,
    splits: SplitValues,
    start: int,
    end: int,
) -> BitWriter:
    """Write the values of some splits as a stream.

    Parameters
    ----------
    contexts : Contexts
        As the group before left them.
    length : (V − 4,) uint8
        Class of the edge between parent and new slot.
    largest : int
        Steps of full scale.
    splits : SplitValues
    start, end : int
        Slots that they add.

    Returns
    -------
    BitWriter
    """
    channels = splits.coarse.shape[1]
    room = ((end - start) * channels * LONGEST_CODE) // 8 + 8
    writer = BitWriter(np.zeros(room, np.uint8), np.zeros(1, np.int64))
    for split in range(start - 4, end - 4):
        for channel in range(channels):
            coarse = np.int64(splits.coarse[split, channel])
            change = np.int64(splits.added[split, channel]) - splits.fine[split, channel]
            code = 2 * change if change >= 0 else -2 * change - 1
            write_adaptive(
                writer, contexts, _context(channel, coarse, largest, length[split]), code
            )
    return writer


@leaf_kernel
def read_values(
    reader: BitReader,
    contexts: Contexts,
    parent: IndexArray,
    place: FloatArray,
    length: ByteArray,
    largest: int,
    values: ShortArray,
    splits: SplitValues,
    start: int,
    end: int,
) -> int:
    """Read the values of some splits and apply them.

    Parameters
    ----------
    reader, contexts, parent, place, length, largest
        As for `write_values` and `collapse_values`.
    values : (V, k) int16
        Of the level with `start` slots; of that with `end` afterwards.
    splits : SplitValues
        Receives the values.
    start, end : int

    Returns
    -------
    int
        The first slot whose values the stream does not have, or puts beyond 0 and `largest`; 0 if
        there is none.
    """
    for slot in range(start, end):
        split = slot - 4
        above = parent[split]
        for channel in range(values.shape[1]):
            coarse = np.int64(values[above, channel])
            code = read_adaptive(
                reader, contexts, _context(channel, coarse, largest, length[split])
            )
            change = -((code + 1) >> 1) if code & 1 else code >> 1
            fine = coarse - math.floor(place[split] * change + 0.5)
            added = fine + change
            if reader.place[0] > reader.length or not (
                0 <= fine <= largest and 0 <= added <= largest
            ):
                return slot
            splits.coarse[split, channel] = coarse
            splits.fine[split, channel] = fine
            splits.added[split, channel] = added
            values[above, channel] = fine
            values[slot, channel] = added
    return 0


@leaf_kernel
def split_values(
    values: ShortArray, parent: IndexArray, splits: SplitValues, start: int, end: int
) -> None:
    """Go from a level with `start` slots to one with `end`, in place."""
    for slot in range(start, end):
        for channel in range(values.shape[1]):
            values[parent[slot - 4], channel] = splits.fine[slot - 4, channel]
            values[slot, channel] = splits.added[slot - 4, channel]


@kernel
def level_values(
    vertices: int, snapshot: ShortArray, parent: IndexArray, splits: SplitValues
) -> ShortArray:
    """Return the values of a level from those of one that is not coarser.

    Parameters
    ----------
    vertices : int
    snapshot : (≥ vertices, k) int16
    parent : (V − 4,) int32
    splits : SplitValues

    Returns
    -------
    (vertices, k) int16
    """
    values = np.empty((vertices, snapshot.shape[1]), np.int16)
    for slot in range(vertices):
        for channel in range(snapshot.shape[1]):
            values[slot, channel] = snapshot[slot, channel]
    for slot in range(len(snapshot) - 1, vertices - 1, -1):
        above = parent[slot - 4]
        if above < vertices:
            for channel in range(snapshot.shape[1]):
                values[above, channel] = splits.coarse[slot - 4, channel]
    return values


@leaf_kernel
def _context(channel: int, coarse: int, largest: int, length: int) -> int:
    """A channel at one of its ends mostly stays there, as on a face of the cube of inks."""
    between = 1 if 0 < coarse < largest else 0
    return (2 * channel + between) * LENGTHS + length
