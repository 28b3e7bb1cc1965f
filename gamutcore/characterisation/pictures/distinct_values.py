"""Distinct values of a picture's pixels, and the number of pixels of each.

Each pixel becomes one integer in Morton order: the bits of its channels interleaved (Morton 1966).
After sorting, equal values are neighbours, and so are all values in one cell of a lattice that
divides every channel into 2ⁿ levels. If there are too many distinct values, the finest lattice with
few enough cells is chosen, and each cell is represented by its outermost value.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gamutcore.characterisation.samples import IntArray

__all__ = ["MAX_VALUES", "DistinctValues", "distinct_values"]

MAX_VALUES = 2**21
"""Maximum number of values to evaluate: 2 s with a CMYK profile, or 7 bits of R, G and B each."""

_BLOCK = 2**22
"""Keys that are compared at a time, to avoid copies of all of them."""

_Key = type[np.unsignedinteger[Any]]


@dataclass(frozen=True, eq=False)
class DistinctValues:
    """Distinct values of pixels.

    Attributes
    ----------
    values : (m, k) uint32
        Channel values.
    counts : (m,) int64
        Number of pixels of each value, or of its cell if `levels` is not None.
    distinct : int
        Number of distinct values in the picture.
    levels : int or None
        Lattice levels per channel; None if `values` has all distinct values.
    """

    values: npt.NDArray[np.uint32]
    counts: IntArray
    distinct: int
    levels: int | None


def distinct_values(
    bands: Iterable[npt.NDArray[Any]],
    pixels: int,
    channels: int,
    bits: int,
    *,
    most: int = MAX_VALUES,
) -> DistinctValues:
    """Return at most `most` distinct values of pixels, in Morton order.

    `bands` are the pixels in parts (n, channels), with at most `pixels` pixels in all. There are 1
    to 4 channels of 8 or 16 bits, or three of up to 21 bits.
    """
    if channels == 1:
        return _distinct_of_one_channel(bands, bits)
    kind: Any = np.uint32 if channels * bits <= 32 else np.uint64
    keys = _sorted_keys(bands, pixels, channels, bits, kind)
    kept, distinct = bits, _count_runs(keys, 0)
    runs = distinct
    while kept > 1 and runs > most:
        kept -= 1
        runs = _count_runs(keys, channels * (bits - kept))
    starts = _run_starts(keys, channels * (bits - kept))
    counts = np.diff(np.append(starts, len(keys)))
    chosen = keys[starts]
    if kept < bits:
        chosen = _outermost_keys(keys, starts, counts, channels, bits, kept)
    values = _gather_bits(chosen, channels, bits)
    return DistinctValues(values, counts, distinct, None if kept == bits else 2**kept)


def _sorted_keys(
    bands: Iterable[npt.NDArray[Any]], pixels: int, channels: int, bits: int, kind: _Key
) -> npt.NDArray[Any]:
    spread = _spread_bits(channels, bits, kind)
    keys = np.zeros(pixels, kind)
    filled = 0
    for band in bands:
        part = keys[filled : filled + len(band)]
        for channel in range(channels):
            part |= spread[band[:, channel]] << kind(channels - 1 - channel)
        filled += len(band)
    keys = keys[:filled]
    keys.sort()
    return keys


def _distinct_of_one_channel(bands: Iterable[npt.NDArray[Any]], bits: int) -> DistinctValues:
    numbers = np.zeros(2**bits, np.int64)
    for band in bands:
        numbers += np.bincount(band[:, 0], minlength=2**bits)
    found = np.flatnonzero(numbers)
    return DistinctValues(found.astype(np.uint32)[:, np.newaxis], numbers[found], len(found), None)


def _spread_bits(channels: int, bits: int, kind: _Key) -> npt.NDArray[Any]:
    """Return every channel value with its bits `channels` places apart."""
    values = np.arange(2**bits, dtype=kind)
    spread = np.zeros(2**bits, kind)
    for bit in range(bits):
        spread |= ((values >> kind(bit)) & kind(1)) << kind(bit * channels)
    return spread


def _gather_bits(keys: npt.NDArray[Any], channels: int, bits: int) -> npt.NDArray[np.uint32]:
    """Return the channel values of keys: the inverse of `_spread_bits`."""
    values = np.zeros((len(keys), channels), np.uint32)
    kind = keys.dtype.type
    for channel in range(channels):
        for bit in range(bits):
            place = kind(bit * channels + channels - 1 - channel)
            values[:, channel] |= (((keys >> place) & kind(1)) << kind(bit)).astype(np.uint32)
    return values


def _changes(keys: npt.NDArray[Any], shift: int) -> Iterator[tuple[int, npt.NDArray[np.bool_]]]:
    """Yield where sorted keys, less their lowest bits, differ from their predecessors."""
    places = keys.dtype.type(shift)
    for start in range(0, len(keys) - 1, _BLOCK):
        cells = keys[start : start + _BLOCK + 1] >> places
        yield start + 1, cells[1:] != cells[:-1]


def _count_runs(keys: npt.NDArray[Any], shift: int) -> int:
    return 1 + sum(int(np.count_nonzero(changed)) for _, changed in _changes(keys, shift))


def _run_starts(keys: npt.NDArray[Any], shift: int) -> IntArray:
    found = [np.flatnonzero(changed) + first for first, changed in _changes(keys, shift)]
    return np.concatenate([np.zeros(1, np.int64), *found])


def _outermost_keys(
    keys: npt.NDArray[Any],
    starts: IntArray,
    counts: IntArray,
    channels: int,
    bits: int,
    kept: int,
) -> npt.NDArray[Any]:
    """Return the outermost key of each cell: the last in Morton order, with axes turned outwards.

    An axis is turned in cells below the middle of the picture's values.
    """
    kind = keys.dtype.type
    cells = _gather_bits(keys[starts], channels, bits) >> (bits - kept)
    middle = (cells.min(axis=0).astype(np.float64) + cells.max(axis=0)) / 2
    ones = _spread_bits(channels, bits, kind)[2 ** (bits - kept) - 1]
    turned = np.zeros(len(cells), kind)
    for channel in range(channels):
        below = cells[:, channel] < middle[channel]
        turned[below] |= ones << kind(channels - 1 - channel)
    # Blocks of whole cells avoid a second array of all keys.
    chosen = np.empty(len(cells), kind)
    first = 0
    while first < len(cells):
        last = int(np.searchsorted(starts, starts[first] + _BLOCK, side="left"))
        last = min(max(last, first + 1), len(cells))
        end = starts[last] if last < len(cells) else len(keys)
        members = keys[starts[first] : end] ^ np.repeat(turned[first:last], counts[first:last])
        chosen[first:last] = np.maximum.reduceat(members, starts[first:last] - starts[first])
        first = last
    return chosen ^ turned
