"""Deflated data, unpacked as far as it is wanted: whole pictures need not be held for it."""

from __future__ import annotations

import zlib
from collections.abc import Iterable

__all__ = ["Inflated"]

_FED = 2**18
"""Packed bytes that are handed to zlib at a time: what it does not take yet is copied."""


class Inflated:
    """A zlib stream (RFC 1950) that is read from its beginning.

    Parameters
    ----------
    parts : iterable of memoryview
        The packed bytes, in parts.
    """

    def __init__(self, parts: Iterable[memoryview]) -> None:
        self._unpacker = zlib.decompressobj()
        self._waiting = (
            part[start : start + _FED] for part in parts for start in range(0, len(part), _FED)
        )
        self._fed: bytes | memoryview = b""

    def read(self, size: int) -> bytes:
        """Return the next bytes.

        Parameters
        ----------
        size : int
            How many at most.

        Returns
        -------
        bytes
            Fewer only at the end of the stream.

        Raises
        ------
        zlib.error
            The stream is broken.
        """
        found: list[bytes] = []
        while size and not self._unpacker.eof:
            if not self._fed:
                self._fed = next(self._waiting, b"")
            ended = not self._fed
            unpacked = self._unpacker.decompress(self._fed, size)
            self._fed = self._unpacker.unconsumed_tail
            if ended and not unpacked:
                break
            size -= len(unpacked)
            found.append(unpacked)
        return found[0] if len(found) == 1 else b"".join(found)
