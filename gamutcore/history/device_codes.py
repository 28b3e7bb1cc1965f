"""Kernels of `gamutcore.history.device_history`: device values through splits and collapses.

They are whole numbers of steps here. Where an edge collapses, the values are interpolated between
those of its two ends, rounded; the difference between the ends is then all that is needed to get
both back, exactly, as in integer lifting (Calderbank, Daubechies, Sweldens & Yeo, "Wavelet
transforms that map integers to integers", 1998). In coarse levels, a correction that is told as
well replaces them by what the full boundary has nearest to the vertex.
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
    "NearestValues",
    "SplitEdges",
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

DIFFERENCE, CORRECTION, MOVE = 0, 1, 2
"""Kinds of numbers: differences between the ends of an edge, corrections of what is interpolated
between them, and changes of neighbours that move."""


class SplitEdges(NamedTuple):
    """The geometry that device values are read with, row i being the split that adds slot i + 4.

    Attributes
    ----------
    parent : (V − 4,) int32
    place : (V − 4,) float64
        Where on the edge from the parent to the new slot the parent was before the split, 0 to 1.
    length : (V − 4,) uint8
        Class of the edge's length.
    shifted_end : (V − 4,) int32
        Where the split's part of the next one ends.
    shifted : (s,) int32
        Neighbours that move.
    corrected : int
        How many splits, from the first one on, have corrections.
    """

    parent: IndexArray
    place: FloatArray
    length: ByteArray
    shifted_end: IndexArray
    shifted: IndexArray
    corrected: int


class NearestValues(NamedTuple):
    """What the full boundary has nearest to the vertices of corrected splits, before these.

    Attributes
    ----------
    parent : (corrected, k) int16
    shifted : (shifted_end[corrected − 1], k) int16
    """

    parent: ShortArray
    shifted: ShortArray


class SplitValues(NamedTuple):
    """Device values at splits, row i being the split that adds slot i + 4; in steps.

    Attributes
    ----------
    coarse, fine : (V − 4, k) int16
        Of the parent before and after the split.
    added : (V − 4, k) int16
        Of the new slot.
    shifted_coarse, shifted_fine : (shifted_end[corrected − 1], k) int16
        Of neighbours that move, before and after.
    """

    coarse: ShortArray
    fine: ShortArray
    added: ShortArray
    shifted_coarse: ShortArray
    shifted_fine: ShortArray


def first_value_contexts(channels: int) -> Contexts:
    """Return the contexts as they are at the beginning: of each kind, channel and edge length.

    Parameters
    ----------
    channels : int

    Returns
    -------
    Contexts
    """
    size = 3 * channels * 2 * LENGTHS
    return Contexts(np.full(size, FIRST_TOTAL, np.int64), np.ones(size, np.int64))


@leaf_kernel
def collapse_values(
    values: ShortArray, edges: SplitEdges, nearest: NearestValues, splits: SplitValues
) -> None:
    """Go from the full boundary to four slots, in place, and write down each split.

    Parameters
    ----------
    values : (V, k) int16
        Of the full boundary; of four slots afterwards.
    edges : SplitEdges
    nearest : NearestValues
    splits : SplitValues
        Receives the values.
    """
    for split in range(len(edges.parent) - 1, -1, -1):
        above = edges.parent[split]
        for channel in range(values.shape[1]):
            fine = int(values[above, channel])
            added = int(values[split + 4, channel])
            coarse = _interpolated(fine, added - fine, edges.place[split])
            if split < edges.corrected:
                coarse = int(nearest.parent[split, channel])
            splits.fine[split, channel] = fine
            splits.added[split, channel] = added
            splits.coarse[split, channel] = coarse
            values[above, channel] = coarse
        for index in range(_first_shift(edges, split), _last_shift(edges, split)):
            for channel in range(values.shape[1]):
                splits.shifted_fine[index, channel] = values[edges.shifted[index], channel]
                splits.shifted_coarse[index, channel] = nearest.shifted[index, channel]
                values[edges.shifted[index], channel] = nearest.shifted[index, channel]


@kernel
def write_values(
    contexts: Contexts, edges: SplitEdges, largest: int, splits: SplitValues, start: int, end: int
) -> BitWriter:
    """Write the values of some splits as a stream.

    Parameters
    ----------
    contexts : Contexts
        As the group before left them.
    edges : SplitEdges
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
    numbers = 2 * (end - start)
    for split in range(start - 4, end - 4):
        numbers += _last_shift(edges, split) - _first_shift(edges, split)
    room = (numbers * channels * LONGEST_CODE) // 8 + 8
    writer = BitWriter(np.zeros(room, np.uint8), np.zeros(1, np.int64))
    for split in range(start - 4, end - 4):
        length = edges.length[split]
        for channel in range(channels):
            coarse = int(splits.coarse[split, channel])
            fine = int(splits.fine[split, channel])
            change = splits.added[split, channel] - fine
            context = _context(DIFFERENCE, channel, channels, coarse, largest, length)
            write_adaptive(writer, contexts, context, _code(change))
            if split < edges.corrected:
                correction = coarse - _interpolated(fine, change, edges.place[split])
                context = _context(CORRECTION, channel, channels, coarse, largest, length)
                write_adaptive(writer, contexts, context, _code(correction))
        for index in range(_first_shift(edges, split), _last_shift(edges, split)):
            for channel in range(channels):
                coarse = int(splits.shifted_coarse[index, channel])
                change = splits.shifted_fine[index, channel] - coarse
                context = _context(MOVE, channel, channels, coarse, largest, length)
                write_adaptive(writer, contexts, context, _code(change))
    return writer


@leaf_kernel
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
    """Read the values of some splits and apply them.

    Parameters
    ----------
    reader : BitReader
    contexts, edges, largest
        As for `write_values`.
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
    channels = values.shape[1]
    for slot in range(start, end):
        split = slot - 4
        above, length = edges.parent[split], edges.length[split]
        for channel in range(channels):
            coarse = int(values[above, channel])
            context = _context(DIFFERENCE, channel, channels, coarse, largest, length)
            change = _signed(read_adaptive(reader, contexts, context))
            correction = 0
            if split < edges.corrected:
                context = _context(CORRECTION, channel, channels, coarse, largest, length)
                correction = _signed(read_adaptive(reader, contexts, context))
            fine = coarse - correction - _interpolated(0, change, edges.place[split])
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
        for index in range(_first_shift(edges, split), _last_shift(edges, split)):
            moved = edges.shifted[index]
            for channel in range(channels):
                coarse = int(values[moved, channel])
                context = _context(MOVE, channel, channels, coarse, largest, length)
                fine = coarse + _signed(read_adaptive(reader, contexts, context))
                if reader.place[0] > reader.length or not 0 <= fine <= largest:
                    return slot
                splits.shifted_coarse[index, channel] = coarse
                splits.shifted_fine[index, channel] = fine
                values[moved, channel] = fine
    return 0


@leaf_kernel
def split_values(
    values: ShortArray, edges: SplitEdges, splits: SplitValues, start: int, end: int
) -> None:
    """Go from a level with `start` slots to one with `end`, in place."""
    for slot in range(start, end):
        split = slot - 4
        for channel in range(values.shape[1]):
            values[edges.parent[split], channel] = splits.fine[split, channel]
            values[slot, channel] = splits.added[split, channel]
        for index in range(_first_shift(edges, split), _last_shift(edges, split)):
            for channel in range(values.shape[1]):
                values[edges.shifted[index], channel] = splits.shifted_fine[index, channel]


@kernel
def level_values(
    vertices: int, snapshot: ShortArray, edges: SplitEdges, splits: SplitValues
) -> ShortArray:
    """Return the values of a level from those of one that is not coarser.

    Parameters
    ----------
    vertices : int
    snapshot : (≥ vertices, k) int16
    edges : SplitEdges
    splits : SplitValues

    Returns
    -------
    (vertices, k) int16
    """
    channels = snapshot.shape[1]
    values = np.empty((vertices, channels), np.int16)
    for slot in range(vertices):
        for channel in range(channels):
            values[slot, channel] = snapshot[slot, channel]
    for slot in range(len(snapshot) - 1, vertices - 1, -1):
        above = edges.parent[slot - 4]
        if above < vertices:
            for channel in range(channels):
                values[above, channel] = splits.coarse[slot - 4, channel]
        for index in range(_first_shift(edges, slot - 4), _last_shift(edges, slot - 4)):
            if edges.shifted[index] < vertices:
                for channel in range(channels):
                    values[edges.shifted[index], channel] = splits.shifted_coarse[index, channel]
    return values


@leaf_kernel
def _interpolated(one: int, change: int, place: float) -> int:
    return one + math.floor(place * change + 0.5)


@leaf_kernel
def _code(number: int) -> int:
    """0, −1, 1, −2, 2, ... as 0, 1, 2, 3, 4, ..."""
    return 2 * number if number >= 0 else -2 * number - 1


@leaf_kernel
def _signed(code: int) -> int:
    return -((code + 1) >> 1) if code & 1 else code >> 1


@leaf_kernel
def _first_shift(edges: SplitEdges, split: int) -> int:
    """Where the moves of a split begin that its values tell."""
    return edges.shifted_end[split - 1] if 0 < split < edges.corrected else 0


@leaf_kernel
def _last_shift(edges: SplitEdges, split: int) -> int:
    return edges.shifted_end[split] if split < edges.corrected else 0


@leaf_kernel
def _context(kind: int, channel: int, channels: int, coarse: int, largest: int, length: int) -> int:
    """A channel at one of its ends mostly stays there, as on a face of the cube of inks."""
    between = 1 if 0 < coarse < largest else 0
    return ((kind * channels + channel) * 2 + between) * LENGTHS + length
