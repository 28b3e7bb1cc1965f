"""The streams of a history file: one per group of splits, unpacked in order on request.

Geometry and device values each have such a series of streams. Each stream continues the adaptive
code and the level of the stream before, so a damaged stream makes all later ones unreadable.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from gamutcore.errors import HistoryFileError
from gamutcore.history.bit_codes import bit_reader, read_bits
from gamutcore.history.prefix_order import group_ranges

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from gamutcore.arrays import ByteArray
    from gamutcore.history.bit_codes import BitReader

__all__ = ["DAMAGE_REMEDY", "DEVICE", "SPLITS", "Streams", "stream_name"]

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
