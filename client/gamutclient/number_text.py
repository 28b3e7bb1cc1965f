"""Numbers as people read them. In `gamutclient` this file is a link, as `results.py` is."""

from __future__ import annotations

from decimal import Decimal
from typing import SupportsFloat

__all__ = ["number_text"]

_LEAST, _MOST = 1e-9, 1e15
"""Magnitudes that are written without an exponent."""


def number_text(value: SupportsFloat, digits: int = 6) -> str:
    """Return a number with some significant digits, and without an exponent.

    Examples
    --------
    >>> number_text(102.4, 2), number_text(1234567.8), number_text(0.0000123)
    ('100', '1234570', '0.0000123')
    """
    number = float(value)
    text = f"{number:.{digits}g}"
    return format(Decimal(text), "f") if "e" in text and _LEAST <= abs(number) < _MOST else text
