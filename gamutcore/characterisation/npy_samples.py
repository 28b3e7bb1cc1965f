"""Samples in NumPy's .npy format, for large sets of colours.

A plain (m, 3) array is L*, a*, b*. The fields of a structured array are columns. The header is
checked against the length of the file before an array is made. Types with Python objects are
refused, so a file cannot run code. The format is NumPy Enhancement Proposal 1, versions 1.0 to 3.0.
"""

from __future__ import annotations

import ast
import math
from typing import Any

import numpy as np
import numpy.typing as npt

from gamutcore.arrays import FloatArray
from gamutcore.characterisation.columns import MAX_COLUMNS, column_roles
from gamutcore.characterisation.conditions import condition_label
from gamutcore.characterisation.samples import (
    Samples,
    samples_from_values,
)
from gamutcore.characterisation.table import MAX_ROW_CONDITIONS
from gamutcore.errors import MalformedFileError, MissingColumnError, SampleLimitError
from gamutcore.limits import current_limits

__all__ = ["NPY_MAGIC", "npy_samples"]

NPY_MAGIC = b"\x93NUMPY"
MAX_VALUES = 16_000_000
"""Maximum number of numbers: 128 MB."""

MAX_ROW_BYTES = 100_000
_MAX_HEADER = 100_000
_REMEDY = "Save an (m, 3) array of L*, a*, b*, or a structured array, with numpy.save."


def npy_samples(data: bytes, *, condition: str | None = None) -> Samples:
    """Return the samples in a .npy file; a field may state their measurement conditions."""
    array = _array(data)
    if array.dtype.names is None:
        if array.ndim != 2 or array.shape[1] != 3:
            raise MissingColumnError(
                f"An array of shape {array.shape} has no names for its columns.",
                where={"field": "shape"},
                remedy=_REMEDY,
            )
        roles = column_roles(("LAB_L", "LAB_A", "LAB_B"))
        return samples_from_values("npy", roles, _float(array), condition=condition)
    if array.ndim != 1:
        raise MissingColumnError(
            f"A structured array of shape {array.shape} is not a list of samples.",
            where={"field": "shape"},
            remedy=_REMEDY,
        )
    names = array.dtype.names
    roles = column_roles(names, condition=condition, where={"field": "descr"})
    if len(array) * len(roles.selected) > MAX_VALUES:
        raise SampleLimitError(
            f"The array has {len(array)} samples of {len(roles.selected)} numbers, too many.",
            where={"field": "shape"},
            remedy=f"Send at most {MAX_VALUES} numbers.",
        )
    values = np.empty((len(array), len(roles.selected)))
    labels: tuple[str, ...] = ()
    for place, column in enumerate(roles.selected):
        field = array[names[column]]
        if column == roles.condition_column:
            values[:, place], labels = _condition_numbers(field)
        elif field.dtype.kind in "SU":
            raise MalformedFileError(
                f"The field {names[column]} holds texts.",
                where={"column": column + 1, "field": names[column]},
                remedy="Colours and device values are numbers.",
            )
        else:
            values[:, place] = _float(field)
    return samples_from_values("npy", roles, values, condition=condition, row_conditions=labels)


def _condition_numbers(field: npt.NDArray[Any]) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the number of each row's measurement condition, and the condition names."""
    try:
        texts = field.astype(str) if field.dtype.kind in "SU" else None
    except (UnicodeDecodeError, ValueError):
        texts = None
    if texts is None:
        raise MalformedFileError(
            "The measurement conditions are not texts.",
            where={"field": "descr"},
            remedy='Save them as a field of texts, such as "M1".',
        )
    found, places = np.unique(texts, return_inverse=True)
    if len(found) > MAX_ROW_CONDITIONS:
        raise SampleLimitError(
            f"The samples have more than {MAX_ROW_CONDITIONS} measurement conditions.",
            where={"field": "descr"},
            remedy=f"Send the samples of at most {MAX_ROW_CONDITIONS} conditions at a time.",
        )
    labels: dict[str, int] = {}
    numbers = [labels.setdefault(condition_label(str(text)), len(labels)) for text in found]
    return np.array(numbers, dtype=np.float64)[places.ravel()], tuple(labels)


def _float(array: npt.NDArray[Any]) -> FloatArray:
    with np.errstate(over="ignore", invalid="ignore"):
        return np.ascontiguousarray(array, dtype=np.float64)


def _malformed(problem: str) -> MalformedFileError:
    return MalformedFileError(
        f"The .npy file {problem}.", where={"field": "header"}, remedy=_REMEDY
    )


def _array(data: bytes) -> npt.NDArray[Any]:
    header, start = _header(data)
    try:
        tree = ast.literal_eval(header)
    except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError):
        raise _malformed("has a broken header") from None
    if not isinstance(tree, dict) or set(tree) != {"descr", "fortran_order", "shape"}:
        raise _malformed("has a header without descr, fortran_order and shape")
    shape, dtype = _shape(tree["shape"]), _dtype(tree["descr"])
    if math.prod(shape) * dtype.itemsize != len(data) - start:
        raise _malformed(
            f"holds {len(data) - start} bytes of data where its header says shape {shape} of "
            f"{dtype.itemsize} bytes each"
        )
    most = current_limits().samples
    if shape and shape[0] > most:
        raise SampleLimitError(
            f"The array has {shape[0]} samples, more than {most}.",
            where={"field": "shape"},
            remedy="Thin the samples out.",
        )
    flat = np.frombuffer(data, dtype=dtype, offset=start)
    return flat.reshape(shape, order="F" if tree["fortran_order"] else "C")


def _header(data: bytes) -> tuple[str, int]:
    if len(data) < 12:
        raise _malformed("ends within its header")
    major = data[6]
    if major not in {1, 2, 3}:
        raise _malformed(f"is of version {major}, which is not known")
    start = 10 if major == 1 else 12
    length = int.from_bytes(data[8:start], "little")
    if length > min(_MAX_HEADER, len(data) - start):
        raise _malformed(f"has a header of {length} bytes, which is too long")
    try:
        return data[start : start + length].decode(
            "utf-8" if major == 3 else "latin-1"
        ), start + length
    except UnicodeDecodeError:
        raise _malformed("has a header that is no text") from None


def _shape(shape: object) -> tuple[int, ...]:
    if (
        not isinstance(shape, tuple)
        or len(shape) > 4
        or not all(type(size) is int and 0 <= size < 2**40 for size in shape)
    ):
        raise _malformed("has a broken shape")
    return shape


def _dtype(description: Any) -> np.dtype[Any]:  # noqa: ANN401 (a literal of unknown shape)
    if isinstance(description, list) and len(description) > MAX_COLUMNS:
        raise SampleLimitError(
            f"The array has {len(description)} columns, more than {MAX_COLUMNS}.",
            where={"field": "descr"},
            remedy=f"Leave out columns that are not needed, down to {MAX_COLUMNS}.",
        )
    try:
        dtype: np.dtype[Any] = np.lib.format.descr_to_dtype(description)
    except (
        ValueError,
        TypeError,
        KeyError,
        SyntaxError,
        IndexError,
        RecursionError,
        OverflowError,
    ):
        raise _malformed("has data of an unknown type") from None
    parts = [dtype] if dtype.fields is None else [entry[0] for entry in dtype.fields.values()]
    kinds = "fiu" if dtype.fields is None else "fiuSU"  # fields of texts are names of patches
    if not all(part.kind in kinds and part.shape == () for part in parts):
        raise _malformed("has fields that are not real numbers")
    if not 0 < dtype.itemsize <= MAX_ROW_BYTES:
        raise _malformed(f"has samples of {dtype.itemsize} bytes")
    return dtype
