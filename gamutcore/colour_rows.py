"""Colours as arguments: arrays (..., 3) of any kind as rows, and answers in the same shape."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from gamutcore.arrays import FloatArray
from gamutcore.errors import InvalidPointsError

__all__ = ["ColourRows", "Colours", "colour_rows"]

Colours: TypeAlias = Any
"""An array (..., 3) in any form that NumPy accepts, or a table such as a pandas DataFrame."""

Scalar = TypeVar("Scalar", bound=np.generic)


class ColourRows(NamedTuple):
    """Colours in rows, and the shape of their array.

    Attributes
    ----------
    points : (n, 3) float64
    shape : tuple of int
        Without the last axis.
    """

    points: FloatArray
    shape: tuple[int, ...]

    def in_shape(self, rows: NDArray[Scalar]) -> NDArray[Scalar]:
        """Return one answer for each row in the shape of the colours: (n, ...) to (*shape, ...)."""
        return rows.reshape(self.shape + rows.shape[1:])


def colour_rows(colours: Colours, name: str = "colours") -> ColourRows:
    """Return colours as rows of float64; `name` is the argument in messages.

    Tables need a method `to_numpy`. Values that are not finite, or another last axis than 3, raise
    InvalidPointsError. ``where["row"]`` is the first such row, counted from 0.
    """
    if callable(getattr(colours, "to_numpy", None)):
        colours = colours.to_numpy()
    remedy = "Give an array (..., 3) of numbers: one colour, or rows of colours."
    try:
        array = np.asarray(colours)
        if array.dtype.kind == "O":  # a table of columns of different types
            array = array.astype(np.float64)
    except (ValueError, TypeError) as error:
        message = f"The {name} are not rows of three numbers."
        raise InvalidPointsError(message, where={"field": name}, remedy=remedy) from error
    if not array.ndim or array.shape[-1] != 3 or array.dtype.kind not in "fiu":
        raise InvalidPointsError(
            f"The {name} have the shape {array.shape} and the type {array.dtype}.",
            where={"field": name},
            remedy=remedy,
        )
    points = np.ascontiguousarray(array.reshape(-1, 3), np.float64)
    finite = np.isfinite(points)
    if not finite.all():
        row = int(np.argmin(finite.all(axis=1)))
        raise InvalidPointsError(
            f"Row {row} of the {name} is {points[row].tolist()}.",
            where={"field": name, "row": row},
            remedy="Give finite numbers. Leave out rows without a colour.",
        )
    return ColourRows(points, array.shape[:-1])
