"""Letters and digits as polylines, for the labels of axes.

A letter is 4 units wide and 6 high, lower-case letters are 4 high, and the base line is at 0. Only
the characters of numbers and of the axes of `gamutcore.colours.spaces` exist.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray

__all__ = ["GLYPHS", "HEIGHT", "text_strokes"]

HEIGHT = 6.0
ADVANCE = 5.5
"""Distance between the left edges of neighbouring letters."""

_PATHS = {
    "0": "10 30 41 45 36 16 05 01 10",
    "1": "04 26 20;00 40",
    "2": "05 16 36 45 44 00 40",
    "3": "06 46 24 34 43 41 30 10 01",
    "4": "30 36 02 42",
    "5": "46 06 03 33 42 41 30 10 01",
    "6": "46 16 05 01 10 30 41 42 33 03",
    "7": "06 46 10",
    "8": "13 04 05 16 36 45 44 33 13 02 01 10 30 41 42 33",
    "9": "00 30 41 45 36 16 05 04 13 43",
    "-": "03 43",
    "+": "03 43;21 25",
    ".": "20 20",
    "'": "26 24",
    "*": "26 23;05 44;45 04",
    "C": "45 36 16 05 01 10 30 41",
    "I": "20 26;10 30;16 36",
    "J": "46 41 30 10 01",
    "L": "06 00 40",
    "P": "00 06 36 45 44 33 03",
    "T": "20 26;06 46",
    "X": "00 46;06 40",
    "Y": "06 23 46;23 20",
    "Z": "06 46 00 40",
    "a": "40 44;43 34 14 03 01 10 30 41",
    "b": "06 00;01 10 30 41 43 34 14 03",
    "o": "10 30 41 43 34 14 03 01 10",
    "p": "04 0b;01 10 30 41 43 34 14 03",
    "t": "26 21 30 40;04 44",
    "u": "04 01 10 30 41;44 40",
    "v": "04 20 44",
    "z": "04 44 00 40",
}
"""Points as two digits, x and y; ``b`` is −2. A semicolon lifts the pen."""


def _points(path: str) -> FloatArray:
    rows = [(float(at[0]), -2.0 if at[1] == "b" else float(at[1])) for at in path.split()]
    return np.array(rows, np.float64)


GLYPHS = {name: [_points(path) for path in paths.split(";")] for name, paths in _PATHS.items()}
"""Polylines by character."""


def text_strokes(text: str) -> list[FloatArray]:
    """Return the polylines (n, 2) of a text, centred at the origin.

    Characters without a glyph leave a gap.
    """
    middle = np.array([(ADVANCE * len(text) - (ADVANCE - 4.0)) / 2.0, HEIGHT / 2.0])
    return [
        np.add(stroke, (ADVANCE * place, 0.0)) - middle
        for place, character in enumerate(text)
        for stroke in GLYPHS.get(character, [])
    ]
