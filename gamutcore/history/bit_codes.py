"""Numbers as bits: the three codes that a history file's streams are made of.

A stream is read from the most significant bit of its first byte on. Whole numbers below a known
limit are in truncated binary; numbers that are mostly small are in a Golomb-Rice code whose
parameter follows the mean of what was coded before in the same context, as in JPEG-LS
(Weinberger, Seroussi & Sapiro, "The LOCO-I Lossless Image Compression Algorithm", 2000; ITU-T
T.87). All of it is integer arithmetic, and ``docs/history-format.md`` states it for other readers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, LongArray
from gamutcore.kernels import inlined_kernel, leaf_kernel

__all__ = [
    "LONGEST_CODE",
    "BitReader",
    "BitWriter",
    "Contexts",
    "read_adaptive",
    "read_below",
    "read_bits",
    "read_differences",
    "reader_of",
    "write_adaptive",
    "write_below",
    "write_bits",
    "write_differences",
    "written",
]

LONGEST_UNARY = 24
"""So many zeros announce a number in plain binary, which bounds the length of any code."""

PLAIN_BITS = 32
"""Bits of such a number; positions are below 2²⁴ and their predictions below 2²⁸."""

LONGEST_CODE = LONGEST_UNARY + PLAIN_BITS
"""Upper bound of the bits of one number in any of the codes: a Rice parameter is below 31."""

LARGEST_PARAMETER = 30

HALVED_AT = 64
"""Numbers after which a context counts only half of what it has seen (RESET of ITU-T T.87)."""


class BitReader(NamedTuple):
    """A stream that is being read.

    Attributes
    ----------
    words : (n,) int64
        The stream as numbers of 32 bits, with at least one word behind its end.
    length : int
        Bits of the stream.
    place : (1,) int64
        Bits that were read; more than `length` once something was asked for beyond the end.
    """

    words: LongArray
    length: int
    place: LongArray


class BitWriter(NamedTuple):
    """A stream that is being written.

    Attributes
    ----------
    data : (n,) uint8
        Zero from `place` on, and long enough for what is written.
    place : (1,) int64
        Bits that were written.
    """

    data: ByteArray
    place: LongArray


class Contexts(NamedTuple):
    """What the adaptive code has seen in each context.

    Attributes
    ----------
    totals : (n,) int64
        Sum of the numbers' halves, rounded up.
    counts : (n,) int64
        How many numbers, 1 at the beginning.
    """

    totals: LongArray
    counts: LongArray


def reader_of(stream: ByteArray) -> BitReader:
    """Return a reader at the beginning of a stream.

    Parameters
    ----------
    stream : (n,) uint8

    Returns
    -------
    BitReader
    """
    padded = np.zeros(stream.size + 8 + -stream.size % 4, np.uint8)
    padded[: stream.size] = stream
    return BitReader(padded.view(">u4").astype(np.int64), 8 * stream.size, np.zeros(1, np.int64))


def written(writer: BitWriter) -> ByteArray:
    """Return the stream that was written, filled with zeros up to the end of a byte.

    Parameters
    ----------
    writer : BitWriter

    Returns
    -------
    (n,) uint8
    """
    return writer.data[: (int(writer.place[0]) + 7) // 8]


@inlined_kernel
def read_bits(reader: BitReader, count: int) -> int:
    """Read a number of 0 to 32 bits; 0 beyond the end, where the reader then stands."""
    place = reader.place[0]
    if place + count > reader.length:
        reader.place[0] = reader.length + 1
        return 0
    reader.place[0] = place + count
    return _next_32_bits(reader, place) >> (32 - count)


@inlined_kernel
def write_bits(writer: BitWriter, value: int, count: int) -> None:
    """Write a number of 0 to 32 bits."""
    place = writer.place[0]
    for bit in range(count - 1, -1, -1):
        if (value >> bit) & 1:
            writer.data[place >> 3] |= np.uint8(128 >> (place & 7))
        place += 1
    writer.place[0] = place


@inlined_kernel
def read_below(reader: BitReader, limit: int) -> int:
    """Read a number from 0 to limit − 1, limit being from 1 to 2³¹, in truncated binary."""
    count, short = _short_codes(limit)
    value = read_bits(reader, count)
    return value if value < short else 2 * value + read_bits(reader, 1) - short


@inlined_kernel
def write_below(writer: BitWriter, value: int, limit: int) -> None:
    """Write a number as `read_below` reads it."""
    count, short = _short_codes(limit)
    if value < short:
        write_bits(writer, value, count)
    else:
        write_bits(writer, value + short, count + 1)


@inlined_kernel
def read_adaptive(reader: BitReader, contexts: Contexts, context: int) -> int:
    """Read a number ≥ 0 in the adaptive Golomb-Rice code."""
    parameter = _parameter(contexts, context)
    window = _next_32_bits(reader, min(reader.place[0], reader.length))
    zeros = 0
    while zeros < LONGEST_UNARY and not (window >> (31 - zeros)) & 1:
        zeros += 1
    if zeros == LONGEST_UNARY:
        read_bits(reader, zeros)
        value = read_bits(reader, PLAIN_BITS)
    else:
        read_bits(reader, zeros + 1)
        value = (zeros << parameter) + read_bits(reader, parameter)
    _see(contexts, context, value)
    return value


@inlined_kernel
def write_adaptive(writer: BitWriter, contexts: Contexts, context: int, value: int) -> None:
    """Write a number from 0 to 2³² − 1 as `read_adaptive` reads it."""
    parameter = _parameter(contexts, context)
    zeros = value >> parameter
    if zeros >= LONGEST_UNARY:
        write_bits(writer, 0, LONGEST_UNARY)
        write_bits(writer, value, PLAIN_BITS)
    else:
        write_bits(writer, 1, zeros + 1)
        write_bits(writer, value & ((1 << parameter) - 1), parameter)
    _see(contexts, context, value)


@leaf_kernel
def read_differences(
    reader: BitReader, contexts: Contexts, along: int, off: int
) -> tuple[int, int, int]:
    """Read two numbers of either sign in one context, and one in another.

    0, −1, 1, −2, 2, ... are 0, 1, 2, 3, 4, ... in the adaptive code.
    """
    one, two, three = 0, 0, 0
    for index in range(3):
        code = read_adaptive(reader, contexts, along if index < 2 else off)
        one, two, three = two, three, -((code + 1) >> 1) if code & 1 else code >> 1
    return one, two, three


@leaf_kernel
def write_differences(
    writer: BitWriter, contexts: Contexts, along: int, off: int, one: int, two: int, three: int
) -> None:
    """Write numbers from −2³¹ to 2³¹ − 1 as `read_differences` reads them."""
    for index in range(3):
        value = (one, two, three)[index]
        code = 2 * value if value >= 0 else -2 * value - 1
        write_adaptive(writer, contexts, along if index < 2 else off, code)


@inlined_kernel
def _next_32_bits(reader: BitReader, place: int) -> int:
    word, offset = place >> 5, place & 31
    first, second = reader.words[word], reader.words[word + 1]
    window: int = ((first << offset) | (second >> (32 - offset))) & 0xFFFFFFFF
    return window


@inlined_kernel
def _short_codes(limit: int) -> tuple[int, int]:
    """Bits of the shorter codes of truncated binary, and how many of them there are."""
    count = 0
    while limit >> (count + 1):
        count += 1
    return count, (2 << count) - limit


@inlined_kernel
def _parameter(contexts: Contexts, context: int) -> int:
    """Rice parameter: the smallest k for which 2ᵏ is not below the mean."""
    total, count = contexts.totals[context], contexts.counts[context]
    parameter = 0
    while parameter < LARGEST_PARAMETER and (count << parameter) < total:
        parameter += 1
    return parameter


@inlined_kernel
def _see(contexts: Contexts, context: int, value: int) -> None:
    contexts.totals[context] += (value + 1) >> 1
    contexts.counts[context] += 1
    if contexts.counts[context] == HALVED_AT:
        contexts.totals[context] >>= 1
        contexts.counts[context] >>= 1
