"""Bit codes: the streams of a history file, and the three codes of numbers in them.

A stream is read from the most significant bit of its first byte. Numbers below a known limit use
truncated binary. Numbers that are mostly small use an adaptive Golomb-Rice code. Its parameter
follows the mean of the numbers coded before in the same context, as in JPEG-LS (ITU-T T.87;
Weinberger, Seroussi & Sapiro, "The LOCO-I Lossless Image Compression Algorithm", 2000).
``docs/history-format.md`` specifies all codes for other readers.

The geometry and the device values each have a series of streams, one per group of splits, unpacked
in order on request. Each stream continues the adaptive code and the level of the stream before, so
a damaged stream makes all later ones unreadable.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.arrays import ByteArray, LongArray
from gamutcore.errors import HistoryFileError
from gamutcore.history.splits import group_ranges
from gamutcore.kernels import bit_length, inlined_kernel, leaf_kernel

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

__all__ = [
    "DAMAGE_REMEDY",
    "DEVICE",
    "LENGTH_CLASSES",
    "LONGEST_CODE",
    "SPLITS",
    "BitReader",
    "BitWriter",
    "Contexts",
    "Streams",
    "bit_reader",
    "decode_sign",
    "doublings_beyond",
    "encode_sign",
    "read_adaptive",
    "read_below",
    "read_bits",
    "read_differences",
    "stream_bytes",
    "stream_name",
    "write_adaptive",
    "write_below",
    "write_bits",
    "write_differences",
]


LONGEST_UNARY = 24
"""This many zeros announce a number in plain binary, which bounds the length of every code."""

PLAIN_BITS = 32
"""Bits of a plain number. Positions are below 2²⁴ and their predictions below 2²⁸."""

LONGEST_CODE = LONGEST_UNARY + PLAIN_BITS
"""Upper bound of the bits of one number in any of the codes."""

LARGEST_PARAMETER = 30

HALVING_COUNT = 64
"""A context halves its statistics after this many numbers (RESET of ITU-T T.87)."""

LENGTH_CLASSES = 32
"""A length class is the exponent of the power of two that a length is below, up to 2³¹ steps."""


class BitReader(NamedTuple):
    """A stream and the reading position."""

    # the stream as 32-bit numbers, with at least one word behind the end
    words: LongArray
    length: int  # bits of the stream
    position: LongArray  # (1,), bits read so far; more than length after reading beyond the end


class BitWriter(NamedTuple):
    """A stream and the writing position."""

    data: ByteArray  # long enough for the next write; zero from the position on
    position: LongArray  # (1,), bits written so far


class Contexts(NamedTuple):
    """Statistics of the adaptive code, one row per context."""

    totals: LongArray  # sum of the halves of the numbers, each half rounded up
    counts: LongArray  # how many numbers were coded, plus 1


def bit_reader(stream: ByteArray) -> BitReader:
    """Return a reader at the beginning of a stream of (n,) uint8."""
    padded = np.zeros(stream.size + 8 + -stream.size % 4, np.uint8)
    padded[: stream.size] = stream
    return BitReader(padded.view(">u4").astype(np.int64), 8 * stream.size, np.zeros(1, np.int64))


def stream_bytes(writer: BitWriter) -> ByteArray:
    """Return the written stream as (n,) uint8; zeros fill the last byte."""
    return writer.data[: (int(writer.position[0]) + 7) // 8]


@inlined_kernel
def read_bits(reader: BitReader, count: int) -> int:
    """Read a number of 0 to 32 bits; beyond the end, return 0 and stay there."""
    position = int(reader.position[0])
    if position + count > reader.length:
        reader.position[0] = reader.length + 1
        return 0
    reader.position[0] = position + count
    return _peek_32_bits(reader, position) >> (32 - count)


@inlined_kernel
def write_bits(writer: BitWriter, value: int, count: int) -> None:
    """Write a number of 0 to 32 bits."""
    position = int(writer.position[0])
    writer.position[0] = position + count
    while count > 0:
        free = 8 - (position & 7)
        taken = min(free, count)
        count -= taken
        bits = (value >> count) & ((1 << taken) - 1)
        writer.data[position >> 3] |= np.uint8(bits << (free - taken))
        position += taken


@inlined_kernel
def read_below(reader: BitReader, limit: int) -> int:
    """Read a number from 0 to limit − 1 in truncated binary; `limit` is from 1 to 2³¹."""
    count, short_codes = _truncated_binary(limit)
    value = read_bits(reader, count)
    return value if value < short_codes else 2 * value + read_bits(reader, 1) - short_codes


@inlined_kernel
def write_below(writer: BitWriter, value: int, limit: int) -> None:
    """Write a number for `read_below`."""
    count, short_codes = _truncated_binary(limit)
    long_code = int(value >= short_codes)
    write_bits(writer, value + short_codes * long_code, count + long_code)


@inlined_kernel
def read_adaptive(reader: BitReader, contexts: Contexts, context: int) -> int:
    """Read a number ≥ 0 in the adaptive Golomb-Rice code."""
    parameter = _rice_parameter(contexts, context)
    position = min(int(reader.position[0]), reader.length)
    window = _peek_32_bits(reader, position)
    zeros = min(32 - bit_length(window), LONGEST_UNARY)
    if zeros == LONGEST_UNARY:
        read_bits(reader, zeros)
        value = read_bits(reader, PLAIN_BITS)
    elif zeros + parameter < 32 and position + zeros + parameter < reader.length:
        # the whole code is in the window
        reader.position[0] = position + zeros + 1 + parameter
        rest = (window >> (31 - zeros - parameter)) & ((1 << parameter) - 1)
        value = (zeros << parameter) + rest
    else:
        read_bits(reader, zeros + 1)
        value = (zeros << parameter) + read_bits(reader, parameter)
    _update_context(contexts, context, value)
    return value


@inlined_kernel
def write_adaptive(writer: BitWriter, contexts: Contexts, context: int, value: int) -> None:
    """Write a number from 0 to 2³² − 1 for `read_adaptive`."""
    parameter = _rice_parameter(contexts, context)
    zeros = value >> parameter
    if zeros >= LONGEST_UNARY:
        write_bits(writer, 0, LONGEST_UNARY)
        write_bits(writer, value, PLAIN_BITS)
    else:
        write_bits(writer, 1, zeros + 1)
        write_bits(writer, value & ((1 << parameter) - 1), parameter)
    _update_context(contexts, context, value)


@leaf_kernel
def read_differences(
    reader: BitReader, contexts: Contexts, along: int, off: int
) -> tuple[int, int, int]:
    """Read two signed numbers in the context `along` and one in the context `off`."""
    one, two, three = 0, 0, 0
    for index in range(3):
        code = read_adaptive(reader, contexts, along if index < 2 else off)
        one, two, three = two, three, decode_sign(code)
    return one, two, three


@leaf_kernel
def write_differences(
    writer: BitWriter, contexts: Contexts, along: int, off: int, one: int, two: int, three: int
) -> None:
    """Write numbers from −2³¹ to 2³¹ − 1 for `read_differences`."""
    for index in range(3):
        value = (one, two, three)[index]
        write_adaptive(writer, contexts, along if index < 2 else off, encode_sign(value))


@inlined_kernel
def encode_sign(number: int) -> int:
    """Return 0, 1, 2, 3, 4 for 0, −1, 1, −2, 2, and so on."""
    return 2 * number if number >= 0 else -2 * number - 1


@inlined_kernel
def decode_sign(code: int) -> int:
    """Invert `encode_sign`."""
    return -((code + 1) >> 1) if code & 1 else code >> 1


@inlined_kernel
def _peek_32_bits(reader: BitReader, position: int) -> int:
    word, offset = position >> 5, position & 31
    first, second = int(reader.words[word]), int(reader.words[word + 1])
    window: int = ((first << offset) | (second >> (32 - offset))) & 0xFFFFFFFF
    return window


@inlined_kernel
def _truncated_binary(limit: int) -> tuple[int, int]:
    """Bits of the short codes of truncated binary, and the number of short codes."""
    count = bit_length(limit) - 1
    return count, (2 << count) - limit


@inlined_kernel
def doublings_beyond(number: int, count: int) -> int:
    """Smallest n with number < count · 2ⁿ, for a number ≥ 0 and a count ≥ 1."""
    # with bit lengths a and b: count · 2ᵃ⁻ᵇ has a bits as well, and the next power has more
    doublings = max(bit_length(number) - bit_length(count), 0)
    return doublings + int(number >= count << doublings)


@inlined_kernel
def _rice_parameter(contexts: Contexts, context: int) -> int:
    """Smallest k for which 2ᵏ is not below the mean."""
    total, count = int(contexts.totals[context]), int(contexts.counts[context])
    return min(doublings_beyond(max(total - 1, 0), count), LARGEST_PARAMETER)


@inlined_kernel
def _update_context(contexts: Contexts, context: int, value: int) -> None:
    contexts.totals[context] += (value + 1) >> 1
    contexts.counts[context] += 1
    if contexts.counts[context] == HALVING_COUNT:
        contexts.totals[context] >>= 1
        contexts.counts[context] >>= 1


SPLITS, DEVICE = "splits", "device"
"""Kinds of streams: the geometry of the splits, and their device values."""

DAMAGE_REMEDY = "Give the file as it was delivered, unchanged."


def stream_name(number: int, kind: str = SPLITS) -> str:
    """Return the name of a group's array in the file."""
    return f"{kind}.{number:02d}"


class Streams:
    """The streams of one kind, `SPLITS` or `DEVICE`.

    The first `unpacked` groups are unpacked; the full boundary has `vertices` vertices.
    """

    def __init__(self, kind: str, streams: Sequence[ByteArray], vertices: int) -> None:
        self.kind = kind
        self.vertices = vertices
        self.unpacked = 0
        self._streams = streams
        self._groups = group_ranges(vertices)
        self._fault: BaseException | None = None

    @property
    def is_complete(self) -> bool:
        """Whether all groups are unpacked."""
        return self.unpacked == len(self._groups)

    @property
    def nbytes(self) -> int:
        """Bytes of the streams that are not unpacked."""
        return sum(stream.nbytes for stream in self._streams[self.unpacked :])

    @contextmanager
    def next_group(self) -> Iterator[tuple[str, int, int, BitReader]]:
        """Unpack the next group in the body of a ``with`` statement.

        Yields the name of the stream, the first slot and the end of the group, and a reader. A
        failure leaves the state of the adaptive code undefined, so every later call raises the same
        error. More than the zeros that fill the last byte raise a `HistoryFileError`.
        """
        if self._fault is not None:
            raise self._fault.with_traceback(None)
        start, end = self._groups[self.unpacked]
        name = stream_name(self.unpacked, self.kind)
        reader = bit_reader(self._streams[self.unpacked])
        try:
            yield name, start, end, reader
            _refuse_bits_left(reader, name)
        except BaseException as fault:
            self._fault = fault
            raise
        self.unpacked += 1


def _refuse_bits_left(reader: BitReader, name: str) -> None:
    left = reader.length - int(reader.position[0])
    if left >= 8 or read_bits(reader, left):
        raise HistoryFileError(
            f"the last split of a group leaves {left} bits over",
            where={"field": name},
            remedy="Give zeros up to the end of a byte.",
        )
