"""Numbers as people read them. In `gamutclient` this file is a link, as `results.py` is."""

from __future__ import annotations

from decimal import Decimal
from typing import SupportsFloat

__all__ = ["fixed_text", "number_text", "volume_text", "volume_unit"]

_LEAST, _MOST = 1e-9, 1e15
"""Magnitudes that are written without an exponent."""


def number_text(value: SupportsFloat, digits: int = 6) -> str:
    """Return a number with some significant digits, and without an exponent.

    Examples
    --------
    >>> number_text(102.4, 2), number_text(1234567.8), number_text(0.0000123)
    ('100', '1234570', '0.0000123')
    """
    number = float(value) + 0.0  # no -0
    text = f"{number:.{digits}g}"
    return format(Decimal(text), "f") if "e" in text and _LEAST <= abs(number) < _MOST else text


def fixed_text(value: SupportsFloat, decimals: int, *, signed: bool = False) -> str:
    """Return a number with some decimals and commas between thousands, and never "-0.00".

    Examples
    --------
    >>> fixed_text(1234.567, 2), fixed_text(-0.001, 2)
    ('1,234.57', '0.00')
    """
    sign = "+" if signed else ""
    return f"{round(float(value), decimals) + 0.0:{sign},.{decimals}f}"


def volume_text(value: SupportsFloat) -> str:
    """Return a volume without an exponent: whole units from 1,000 on, else four digits.

    Examples
    --------
    >>> volume_text(454609.2), volume_text(0.0123456), volume_text(6.4e-11)
    ('454,609', '0.01235', '0.000000000064')
    """
    number = float(value)
    if abs(number) >= 1000.0:
        return fixed_text(number, 0)
    return format(Decimal(f"{number + 0.0:.4g}"), "f")


def volume_unit(space: str) -> str:
    """Return the unit of volumes in a colour space.

    Examples
    --------
    >>> volume_unit("CIELAB"), volume_unit("Oklab")
    ('cubic ΔE*ab', 'cubic units of Oklab')
    """
    return "cubic ΔE*ab" if space == "CIELAB" else f"cubic units of {space}"
