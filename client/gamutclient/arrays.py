"""Colours to the bytes of ``.npy`` files and of tables, and the answers back to arrays."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from gamutclient.errors import InvalidPointsError

__all__ = [
    "BooleanArray",
    "ColourRows",
    "Colours",
    "FloatArray",
    "IndexArray",
    "array_rows",
    "colour_rows",
    "npy_bytes",
    "npy_records",
]

FloatArray: TypeAlias = NDArray[np.float64]
BooleanArray: TypeAlias = NDArray[np.bool_]
IndexArray: TypeAlias = NDArray[np.int64]

Colours: TypeAlias = Any
"""Anything that NumPy takes as an array (..., 3), a data frame, or a file of colours.

The service finds the colours of a data frame by the names of its columns. A file is a path or
bytes, in any form that the service reads; rows without a colour have no answer.
"""

Scalar = TypeVar("Scalar", bound=np.generic)


class ColourRows(NamedTuple):
    """Colours (n, 3), and the shape of the array that they came in, without the last axis.

    A table has the bytes of its file in the place of the points; the shape of a file is -1.
    """

    points: FloatArray
    shape: tuple[int, ...]
    table: bytes | None = None

    def in_shape(self, rows: NDArray[Scalar]) -> NDArray[Scalar]:
        """Return one answer for each row in the shape of the colours."""
        return rows.reshape(self.shape + rows.shape[1:])


def colour_rows(colours: Colours) -> ColourRows:
    """Return colours as rows of float64, or as a table; the service checks their values."""
    if isinstance(colours, os.PathLike):
        colours = Path(colours).read_bytes()
    if isinstance(colours, bytes):
        return ColourRows(np.empty((0, 3)), (-1,), colours)
    names = list(getattr(colours, "columns", ()))
    if names and all(isinstance(name, str) for name in names):
        return ColourRows(np.empty((0, 3)), (len(colours),), _csv(colours, names))
    return array_rows(colours)


def array_rows(colours: Colours) -> ColourRows:
    """Return the colours in an array, or in three columns, as rows of float64."""
    if callable(getattr(colours, "to_numpy", None)):
        colours = colours.to_numpy()
    remedy = "Give an array (..., 3) of numbers."
    try:
        found = np.asarray(colours)
        if found.dtype.kind == "O":  # a table of columns of different types
            found = found.astype(np.float64)
    except (ValueError, TypeError) as error:
        raise InvalidPointsError(f"The colours are not rows of three numbers. {remedy}") from error
    if not found.ndim or found.shape[-1] != 3 or found.dtype.kind not in "fiu":
        message = f"The colours have the shape {found.shape} and the type {found.dtype}."
        raise InvalidPointsError(f"{message} {remedy}")
    points = np.ascontiguousarray(found.reshape(-1, 3), np.float64)
    return ColourRows(points, found.shape[:-1])


def _csv(frame: Any, names: list[str]) -> bytes:  # noqa: ANN401 - any data frame
    """Return a data frame as CSV, with all digits."""
    text = io.StringIO(newline="")
    text.write("sep=,\n")
    writer = csv.writer(text)
    writer.writerow(names)
    writer.writerows(zip(*(np.asarray(frame[name]).tolist() for name in names), strict=True))
    return text.getvalue().encode()


def npy_bytes(array: NDArray[Any]) -> bytes:
    """Return an array as an ``.npy`` file."""
    file = io.BytesIO()
    np.save(file, array, allow_pickle=False)
    return file.getvalue()


def npy_records(content: bytes) -> NDArray[Any]:
    """Return the records in an ``.npy`` file: a structured array with one field per column."""
    found: NDArray[Any] = np.load(io.BytesIO(content), allow_pickle=False)
    return found
