"""Kernels of `gamutcore.history.device_history`: device values through splits and collapses.

Values are integers, in steps. When an edge collapses, the value of the vertex is interpolated
between those of the two ends and rounded. The difference between the ends then gives both back
exactly. This is integer lifting (Calderbank, Daubechies, Sweldens & Yeo, "Wavelet transforms that
map integers to integers", 1998). In coarse levels a stored correction replaces the interpolated
value by the value that the full boundary has nearest to the vertex.
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
    decode_sign,
    encode_sign,
    read_adaptive,
    write_adaptive,
)
from gamutcore.history.prefix_order import part_begin
from gamutcore.history.stepping import undo_splits
from gamutcore.kernels import inlined_kernel, kernel

__all__ = [
    "LENGTH_CLASSES",
    "SplitEdges",
    "SplitValues",
    "collapse_values",
    "first_value_contexts",
    "level_values",
    "read_values",
    "write_values",
]

LENGTH_CLASSES = 32

FIRST_TOTAL = 32
"""Initial total of a context: the code expects differences of about 16 steps."""

DIFFERENCE, CORRECTION, MOVE = range(3)
"""Kinds of numbers: the difference between the ends of an edge, the correction of the interpolated
value, and the change of a neighbour that moves."""


class SplitEdges(NamedTuple):
    """The geometry that device values depend on; row i is the split that adds slot i + 4.

    Attributes
    ----------
    parent : (V − 4,) int32
    fraction : (V − 4,) float64
        Position of the parent before the split on the edge from the parent to the new slot, 0 to 1.
    length : (V − 4,) uint8
        Length class of the edge.
    shifted_end : (V − 4,) int32
        End of each split's part of `shifted`; splits without corrections have no part.
    shifted : (s,) int32
        Neighbours that move.
    corrected : int
        This many splits, from the first one, have corrections.
    """

    parent: IndexArray
    fraction: FloatArray
    length: ByteArray
    shifted_end: IndexArray
    shifted: IndexArray
    corrected: int


class SplitValues(NamedTuple):
    """Device values of splits in steps; row i is the split that adds slot i + 4.

    Attributes
    ----------
    coarse, fine : (V − 4, k) int16
        Values of the parent before and after the split.
    added : (V − 4, k) int16
        Values of the new slot.
    shifted_coarse, shifted_fine : (shifted_end[corrected − 1], k) int16
        Values of neighbours that move, before and after the split.
    """

    coarse: ShortArray
    fine: ShortArray
    added: ShortArray
    shifted_coarse: ShortArray
    shifted_fine: ShortArray


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
