"""Checks of the points that a query gets: shape, numbers, range. Errors name the row."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray
from gamutcore.errors import InvalidPointsError

__all__ = ["LARGEST", "checked_numbers", "checked_points"]

LARGEST = 1e60
"""Largest accepted magnitude of a coordinate. Products of five coordinates must stay finite."""


def checked_points(points: ArrayLike, name: str = "points") -> FloatArray:
    """Return points as an array in double precision.

    Parameters
    ----------
    points : (n, 3) array_like
    name : str, optional
        Name of the argument in messages.

    Returns
    -------
    (n, 3) float64

    Raises
    ------
    InvalidPointsError
        The shape is not (n, 3), or a coordinate is not a number within ±1e60. ``where["row"]`` is
        the first such row, counted from 0.

    Examples
    --------
    >>> checked_points([(50, 0, 0)]).tolist()
    [[50.0, 0.0, 0.0]]
    """
    remedy = "Give an (n, 3) array of numbers."
    try:
        found = np.ascontiguousarray(points)
    except ValueError as error:
        message = f"The rows of {name} do not have the same number of values."
        raise InvalidPointsError(message, where={"field": name}, remedy=remedy) from error
    if found.ndim != 2 or found.shape[1] != 3 or found.dtype.kind not in "fiu":
        raise InvalidPointsError(
            f"{name} has the shape {found.shape} and the type {found.dtype}.",
            where={"field": name},
            remedy=remedy,
        )
    # A read-only or unaligned array is of another type for the compiler, which would compile anew.
    found = np.require(found, np.float64, ["C", "ALIGNED", "WRITEABLE"])
    valid = np.abs(found) <= LARGEST  # false for NaN
    if not valid.all():
        row = int(np.argmin(valid.all(axis=1)))
        raise InvalidPointsError(
            f"Row {row} of {name} is {found[row].tolist()}.",
            where={"field": name, "row": row},
            remedy=f"Give finite coordinates within ±{LARGEST:g}.",
        )
    return found


def checked_numbers(numbers: ArrayLike, name: str) -> FloatArray:
    """Return numbers, such as hue angles, as an array in double precision.

    Parameters
    ----------
    numbers : (n,) array_like
    name : str
        Name of the argument in messages.

    Returns
    -------
    (n,) float64

    Raises
    ------
    InvalidPointsError
        The shape is not (n,), or a number is not finite. ``where["row"]`` is the first such row,
        counted from 0.

    Examples
    --------
    >>> checked_numbers(range(3), "hues").tolist()
    [0.0, 1.0, 2.0]
    """
    try:
        found = np.asarray(numbers)
    except ValueError:
        found = np.empty((0, 0))  # rows of different lengths
    if found.ndim != 1 or found.dtype.kind not in "fiu":
        raise InvalidPointsError(
            f"{name} are not one list of numbers.",
            where={"field": name},
            remedy="Give an (n,) array of numbers.",
        )
    found = np.ascontiguousarray(found, np.float64)
    if not np.isfinite(found).all():
        row = int(np.argmin(np.isfinite(found)))
        raise InvalidPointsError(
            f"Row {row} of {name} is {found[row]}.",
            where={"field": name, "row": row},
            remedy="Give finite numbers.",
        )
    return found
