"""The text of ``.cube`` files.

Source: Adobe, "Cube LUT Specification", version 1.0 (2013).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    from gamutcore.arrays import FloatArray

__all__ = ["DECIMALS", "cube_file"]

DECIMALS = 6
"""Digits after the point, as in the specification's examples; a step of 16 bits is 1.5e-5."""

_LONGEST_LINE = 250
"""Largest number of characters of a line in the specification, its end included."""


def cube_file(title: str, comments: Iterable[str], nodes: FloatArray) -> bytes:
    """Return the file of nodes (n, n, n, 3) by red, green and blue, with values from 0 to 1.

    Title and comments are of one line each. They are cut to the longest line, and characters
    outside ASCII become question marks.
    """
    head = [
        f'TITLE "{_line(title, len("TITLE __")).replace(chr(34), chr(39))}"',
        *(f"# {_line(comment, 2)}" for comment in comments),
        f"LUT_3D_SIZE {len(nodes)}",
        "DOMAIN_MIN 0.0 0.0 0.0",
        "DOMAIN_MAX 1.0 1.0 1.0",
        "",
    ]
    rows = nodes.transpose(2, 1, 0, 3).reshape(-1, 3)  # red is fastest
    return "\n".join(head).encode("ascii") + _numbers(rows)


def _line(text: str, used: int) -> str:
    ascii_text = " ".join(text.split()).encode("ascii", "replace").decode("ascii")
    return ascii_text[: _LONGEST_LINE - 1 - used]


def _numbers(rows: FloatArray) -> bytes:
    """Return lines of three numbers from 0 to 1, formatted at once: Python takes 0.5 s for 65³."""
    left = np.round(rows * 10**DECIMALS).astype(np.int32)
    text = np.empty((*rows.shape, DECIMALS + 3), np.uint8)
    for place in range(DECIMALS + 1, 1, -1):
        left, digit = np.divmod(left, 10)
        text[:, :, place] = ord("0") + digit
    text[:, :, 0], text[:, :, 1] = ord("0") + left, ord(".")
    text[:, :, -1] = np.frombuffer(b"  \n", np.uint8)
    return text.tobytes()
