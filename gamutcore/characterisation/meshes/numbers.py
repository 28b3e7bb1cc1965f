"""Numbers of mesh files: text to arrays, and polygons to triangles.

Text is converted in blocks. The memory for words is therefore a few times the size of a block.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.errors import MalformedFileError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray

__all__ = ["numbers_of", "polygon_triangles"]

_BLOCK = 1 << 20
"""Bytes of text that are converted together."""

_SPACE = re.compile(rb"\s")
_PLAIN = re.compile(rb"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?")
LONGEST_WORD = 400
"""Maximum length of a number. A double with all its decimals has about 330 characters."""


def numbers_of(text: bytes, line: int, most: int) -> FloatArray:
    """Return at most `most` numbers of a text that are separated by white space.

    Words such as ``nan``, ``inf`` or ``1e999`` give infinite values or NaN. `line` is the line at
    the start of the text; errors state the line.
    """
    blocks, found, place = [], 0, 0
    while place < len(text) and found < most:
        end = min(place + _BLOCK, len(text))
        if end < len(text):
            space = _SPACE.search(text, end, end + LONGEST_WORD)
            if space is None and len(text) > end + LONGEST_WORD:
                raise _no_number(text[end : end + 40], text, end, line)
            end = len(text) if space is None else space.end()
        words = text[place:end].split()
        try:
            block = np.array([float(word) for word in words])
        except ValueError:
            block = None
        # float() also accepts 1_000.
        if block is None or b"_" in text[place:end]:
            raise _first_fault(text, place, line)
        blocks.append(block)
        found += len(block)
        place = end
    numbers = np.concatenate(blocks) if blocks else np.empty(0)
    return numbers[:most]


def _first_fault(text: bytes, place: int, line: int) -> MalformedFileError:
    for word in re.finditer(rb"\S+", text[place : place + _BLOCK + LONGEST_WORD]):
        if len(word[0]) > LONGEST_WORD or not _PLAIN.fullmatch(word[0]):
            return _no_number(word[0], text, place + word.start(), line)
    return _no_number(b"", text, place, line)


def _no_number(word: bytes, text: bytes, place: int, line: int) -> MalformedFileError:
    shown = word[:40].decode("ascii", "backslashreplace")
    return MalformedFileError(
        f"{shown!r} is not a number.",
        where={"line": line + text.count(b"\n", 0, place)},
        remedy="Write plain decimal numbers, such as 12.5.",
    )


def polygon_triangles(sides: LongArray, corners: LongArray) -> LongArray:
    """Return the triangles (m, 3) of polygons, each split from its first corner.

    `sides` has the number of corners of each polygon, and `corners` their vertices, polygon by
    polygon. Polygons with fewer than three corners have no triangles.
    """
    triangles = np.maximum(sides - 2, 0)
    starts = np.repeat(np.cumsum(sides) - sides, triangles)
    # Number of each triangle in its polygon.
    within = np.arange(int(triangles.sum())) - np.repeat(
        np.cumsum(triangles) - triangles, triangles
    )
    places = np.stack([starts, starts + within + 1, starts + within + 2], axis=1)
    return np.asarray(corners[places], np.int64)
