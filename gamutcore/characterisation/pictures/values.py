"""The distinct values of a picture's pixels, and how many pixels have each.

Pixels become whole numbers in Morton order (the bits of all channels interleaved, Morton 1966),
which are sorted. Equal values are then neighbours, and so are the values within any cell of a
lattice that halves every channel: where a picture has more distinct values than are evaluated, each
cell of the finest lattice that has few enough is represented by its outermost value.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gamutcore.characterisation.samples import IntArray

__all__ = ["MAX_VALUES", "DistinctValues", "TooManyValuesError", "distinct_values"]

MAX_VALUES = 2**21
"""Distinct values that are evaluated: 2 s of a CMYK profile, and 7 bits of each of R, G and B."""


class TooManyValuesError(ValueError):
    """There are more distinct values than may be."""


@dataclass(frozen=True, eq=False)
class DistinctValues:
    """Values of pixels, each once.

    Parameters
    ----------
    values : (m, k) uint16
        Channel values.
    counts : (m,) int64
        Pixels of that value, or of its cell where `levels` is not None.
    distinct : int
        How many distinct values the picture has.
    levels : int or None
        Cells that each channel was divided into; None where all distinct values are there.
    """

    values: npt.NDArray[np.uint16]
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
    sorted_bytes: float = math.inf,
    fewer: int = MAX_VALUES,
) -> DistinctValues:
    """Return the distinct values of pixels.

    Parameters
    ----------
    bands : iterable of (n, channels) uint8 or uint16
        The pixels, in parts; at least one pixel in all.
    pixels : int
        How many there are at most.
    channels : int
        1 to 4.
    bits : int
        Bits of a channel value, 8 or 16.
    most : int, optional
        Values to be returned at most.
    sorted_bytes : float, optional
        Bytes that the numbers of all pixels may take. If they took more, distinct ones are found
        in parts rather than all be held at once.
    fewer : int, optional
        How many of them there may be then.

    Returns
    -------
    DistinctValues
        In Morton order.

    Raises
    ------
    TooManyValuesError
        The numbers take more than `sorted_bytes`, and there are more than `fewer` distinct ones.
    """
    if channels == 1:
        return _distinct_numbers(bands, bits)
    kind: Any = np.uint32 if channels * bits <= 32 else np.uint64
    spread = _spread_bits(channels, bits, kind)
    parts = _keys(bands, channels, kind, spread)
    weights: IntArray | None = None
    if pixels * np.dtype(kind).itemsize > sorted_bytes:
        keys, weights = _joined(parts, kind, fewer)
    else:
        keys = np.empty(pixels, kind)
        filled = 0
        for part in parts:
            keys[filled : filled + len(part)] = part
            filled += len(part)
        keys = keys[:filled]
        keys.sort()
    kept = bits
    distinct = _runs(keys, 0)
    while kept > 1 and (distinct if kept == bits else _runs(keys, channels * (bits - kept))) > most:
        kept -= 1
    starts = _starts(keys, channels * (bits - kept))
    counts = np.diff(np.append(starts, len(keys)))
    chosen = keys[starts]
    if kept < bits:
        chosen = _outermost(keys, starts, counts, channels, bits, kept)
    if weights is not None:
        counts = np.add.reduceat(weights, starts)
    values = _gathered_bits(chosen, channels, bits)
    return DistinctValues(values, counts, distinct, None if kept == bits else 2**kept)


def _keys(
    bands: Iterable[npt.NDArray[Any]],
    channels: int,
    kind: type[np.unsignedinteger[Any]],
    spread: npt.NDArray[Any],
) -> Iterator[npt.NDArray[Any]]:
    """Yield the pixels as numbers in Morton order."""
    for band in bands:
        part = np.zeros(len(band), kind)
        for channel in range(channels):
            part |= spread[band[:, channel]] << kind(channels - 1 - channel)
        yield part


_JOINED = 2**19
"""Numbers that are gathered before they are joined with those that were seen."""


def _joined(
    parts: Iterable[npt.NDArray[Any]], kind: type[np.unsignedinteger[Any]], fewer: int
) -> tuple[npt.NDArray[Any], IntArray]:
    """Return each number once, in order, and how often it is there."""
    keys, weights = np.empty(0, kind), np.empty(0, np.int64)
    waiting: list[npt.NDArray[Any]] = []
    for part in parts:
        waiting.append(part)
        if sum(map(len, waiting)) >= _JOINED:
            keys, weights = _with(keys, weights, waiting, fewer)
            waiting = []
    return _with(keys, weights, waiting, fewer) if waiting else (keys, weights)


def _with(
    keys: npt.NDArray[Any], weights: IntArray, parts: list[npt.NDArray[Any]], fewer: int
) -> tuple[npt.NDArray[Any], IntArray]:
    """Return numbers that were seen and further ones, each once, and how often they are there."""
    numbers = np.concatenate(parts)
    numbers.sort()
    starts = _starts(numbers, 0)
    counts = np.diff(np.append(starts, len(numbers)))
    found = numbers[starts]
    places = np.searchsorted(keys, found)
    known = places < len(keys)
    known[known] = keys[places[known]] == found[known]
    weights[places[known]] += counts[known]
    fresh = ~known
    places = places[fresh]
    if len(keys) + len(places) > fewer:
        raise TooManyValuesError
    return np.insert(keys, places, found[fresh]), np.insert(weights, places, counts[fresh])


def _distinct_numbers(bands: Iterable[npt.NDArray[Any]], bits: int) -> DistinctValues:
    """Return the distinct values of one channel, of which there are few enough to be counted."""
    numbers = np.zeros(2**bits, np.int64)
    for band in bands:
        numbers += np.bincount(band[:, 0], minlength=2**bits)
    found = np.flatnonzero(numbers)
    return DistinctValues(found.astype(np.uint16)[:, np.newaxis], numbers[found], len(found), None)


def _spread_bits(channels: int, bits: int, kind: type[np.unsignedinteger[Any]]) -> Any:  # noqa: ANN401
    """Return the bits of every channel value, `channels` places apart."""
    values = np.arange(2**bits, dtype=kind)
    spread = np.zeros(2**bits, kind)
    for bit in range(bits):
        spread |= ((values >> kind(bit)) & kind(1)) << kind(bit * channels)
    return spread


def _gathered_bits(keys: npt.NDArray[Any], channels: int, bits: int) -> npt.NDArray[np.uint16]:
    values = np.zeros((len(keys), channels), np.uint16)
    kind = keys.dtype.type
    for channel in range(channels):
        for bit in range(bits):
            place = kind(bit * channels + channels - 1 - channel)
            values[:, channel] |= (((keys >> place) & kind(1)) << kind(bit)).astype(np.uint16)
    return values


_BAND = 2**22
"""Keys that are compared at a time, so that copies of all are never needed."""


def _changes(keys: npt.NDArray[Any], shift: int) -> Iterable[tuple[int, npt.NDArray[np.bool_]]]:
    places = keys.dtype.type(shift)
    for start in range(0, len(keys) - 1, _BAND):
        cells = keys[start : start + _BAND + 1] >> places
        yield start + 1, cells[1:] != cells[:-1]


def _runs(keys: npt.NDArray[Any], shift: int) -> int:
    return 1 + sum(int(np.count_nonzero(changed)) for _, changed in _changes(keys, shift))


def _starts(keys: npt.NDArray[Any], shift: int) -> IntArray:
    found = [np.flatnonzero(changed) + first for first, changed in _changes(keys, shift)]
    return np.concatenate([np.zeros(1, np.int64), *found])


def _outermost(
    keys: npt.NDArray[Any],
    starts: IntArray,
    counts: IntArray,
    channels: int,
    bits: int,
    kept: int,
) -> npt.NDArray[Any]:
    """Return one key of each cell: the last in Morton order with the axes turned outwards."""
    kind = keys.dtype.type
    cells = _gathered_bits(keys[starts], channels, bits) >> (bits - kept)
    middle = (cells.min(axis=0).astype(np.float64) + cells.max(axis=0)) / 2
    ones = _spread_bits(channels, bits, kind)[2 ** (bits - kept) - 1]  # of one channel, in a cell
    turned = np.zeros(len(cells), kind)
    for channel in range(channels):
        below = cells[:, channel] < middle[channel]
        turned[below] |= ones << kind(channels - 1 - channel)
    # In parts of whole cells, so that no second array of all pixels is needed.
    chosen = np.empty(len(cells), kind)
    first = 0
    while first < len(cells):
        last = int(np.searchsorted(starts, starts[first] + _BAND, side="left"))
        last = min(max(last, first + 1), len(cells))
        end = starts[last] if last < len(cells) else len(keys)
        members = keys[starts[first] : end] ^ np.repeat(turned[first:last], counts[first:last])
        chosen[first:last] = np.maximum.reduceat(members, starts[first:last] - starts[first])
        first = last
    return chosen ^ turned
