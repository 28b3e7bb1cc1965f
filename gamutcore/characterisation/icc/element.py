"""Checked access to the bytes of one tag of an ICC profile.

Every read is checked against the bounds of the tag, and errors name the tag. A size or offset in
the file can therefore neither reach outside the tag nor allocate more than the tag. All numbers
are big-endian (ICC.1:2022, 4.1).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.errors import MalformedProfileError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = ["Element"]


@dataclass(frozen=True)
class Element:
    """The data of one tag, starting with its type signature. Errors name the tag."""

    tag: str
    data: bytes

    def malformed(self, problem: str, remedy: str = "") -> MalformedProfileError:
        """Return the error for a fault in this tag.

        The problem is a predicate with the tag as its subject.
        """
        return MalformedProfileError(
            f"The tag {self.tag} {problem}.",
            where={"tag": self.tag},
            remedy=remedy or "Make the profile again, or repair the tag.",
        )

    def raw(self, offset: int, size: int) -> bytes:
        """Return `size` bytes from `offset`.

        This method and those below raise `MalformedProfileError` if the bytes exceed the tag.
        """
        if offset < 0 or size < 0 or offset + size > len(self.data):
            raise self.malformed(
                f"needs {size} bytes at offset {offset} and has {len(self.data)} bytes in all"
            )
        return self.data[offset : offset + size]

    @property
    def kind(self) -> str:
        """The type signature, such as ``"mft2"``."""
        return self.raw(0, 4).decode("latin-1")

    def unsigned(self, offset: int, size: int) -> int:
        """Return the unsigned integer of `size` bytes at `offset`."""
        return int.from_bytes(self.raw(offset, size), "big")

    def integers(self, offset: int, count: int, size: int) -> np.ndarray:
        """Return unsigned integers of 1 or 2 bytes as (count,) uint16.

        Single bytes are multiplied by 257, which maps full scale exactly.
        """
        raw = self.raw(offset, count * size)
        if size == 1:
            return np.frombuffer(raw, dtype=np.uint8) * np.uint16(257)
        return np.frombuffer(raw, dtype=">u2").astype(np.uint16)

    def fixed(self, offset: int, count: int) -> FloatArray:
        """Return (count,) numbers of the type s15Fixed16Number."""
        return np.frombuffer(self.raw(offset, 4 * count), dtype=">i4") / 65536.0

    def floats(self, offset: int, count: int) -> FloatArray:
        """Return (count,) numbers of the type float32Number, which may be infinite or NaN."""
        raw = np.frombuffer(self.raw(offset, 4 * count), dtype=">f4")
        with np.errstate(invalid="ignore"):  # a signalling NaN becomes a quiet one
            return raw.astype(np.float64)
