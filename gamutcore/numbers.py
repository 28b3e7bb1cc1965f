"""Numbers that come from outside: options, and what files state."""

from __future__ import annotations

import math

__all__ = ["finite_number"]


def finite_number(value: object) -> float | None:
    """Return a number as a float, if it is one.

    Parameters
    ----------
    value : object

    Returns
    -------
    float or None
        Finite, and never −0.0; None for anything else, truth values among it.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number + 0.0 if math.isfinite(number) else None
