"""Checks of query arguments: shape, numbers, range. Errors name the row."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray
from gamutcore.errors import InvalidPointsError

__all__ = ["LARGEST", "checked_numbers", "checked_points"]

LARGEST = 1e60
"""Largest accepted magnitude of a coordinate. Products of five coordinates must stay finite."""


def checked_points(points: ArrayLike, name: str = "points") -> FloatArray:
    """Return points as an (n, 3) array in double precision.

    Another shape, or a coordinate that is not within ±1e60, raises InvalidPointsError.
    ``where["row"]`` is the first such row, counted from 0, and `name` is the argument in the
    message.
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
    """Return finite numbers, such as hue angles, as an (n,) array in double precision.

    Errors are as for `checked_points`.
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
