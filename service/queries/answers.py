"""Forms of the answers to queries: JSON, structured .npy and CSV.

JSON is one document. The others are written piece by piece, because a million rows take more memory
as an answer than as a body.
"""

from __future__ import annotations

import csv
import io
from itertools import islice, pairwise
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from pydantic_core import to_json

from service.queries.bodies import CSV, JSON, NPY
from service.queries.operations import Result

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from service.queries.bodies import Body
    from service.queries.levels import QueryLevel
    from service.queries.operations import Operation
    from service.queries.views import Answered

__all__ = ["WRITERS", "Writer", "condition_headers", "level_document", "view_file"]

_AT_ONCE = 2000
"""Rows of CSV that are written without a chance for other threads: some milliseconds."""


class Writer(Protocol):
    """Writes an answer from its first row to its last."""

    def __init__(
        self, operation: Operation, level: QueryLevel, body: Body, warnings: Sequence[str]
    ) -> None: ...

    def piece(self, start: int, result: Result) -> bytes:
        """Return the bytes of the rows from `start` on."""

    def head(self, first: Result, entries: int) -> bytes:
        """Return what comes before the rows.

        Parameters
        ----------
        first : Result
            Result of the first rows, which has the columns of all others.
        entries : int
            Number of rows of the answer: more than those of the body if rows have several entries.
        """


def level_document(level: QueryLevel) -> dict[str, Any]:
    """Return the JSON of a level."""
    return {"triangles": level.triangles, "max_error": level.max_error}


def condition_headers(levels: Sequence[QueryLevel], warnings: Sequence[str]) -> dict[str, str]:
    """Return the header fields with the conditions of gamuts, and with warnings if there are any.

    Warnings are a list of strings (RFC 9651, 3.1 and 3.3.3), which are ASCII.
    """
    fields = {"Gamut-Conditions": ", ".join(each.gamut.conditions.header for each in levels)}
    if warnings:
        plain = (each.encode("ascii", "replace").decode() for each in warnings)
        escaped = (each.replace("\\", "\\\\").replace('"', '\\"') for each in plain)
        fields["Gamut-Warning"] = ", ".join(f'"{each}"' for each in escaped)
    return fields


class JsonWriter:
    """One object: the level, the conditions of the gamut, warnings, and one array per column."""

    def __init__(
        self, _operation: Operation, level: QueryLevel, _body: Body, warnings: Sequence[str]
    ) -> None:
        self._level, self._warnings = level, list(warnings)

    def head(self, _first: Result, _entries: int) -> bytes:
        """Return nothing."""
        return b""

    def piece(self, start: int, result: Result) -> bytes:
        """Return the document."""
        assert start == 0  # noqa: S101 - rows of JSON fit into one piece
        document: dict[str, Any] = {
            "level": level_document(self._level),
            "gamut": self._level.gamut.conditions.to_dict(),
            "warnings": self._warnings,
        }
        for name, values in result.columns.items():
            if result.offsets is None:
                document[name] = values.tolist()
            else:
                ends = pairwise(result.offsets.tolist())
                entries = values.tolist()
                document[name] = [entries[begin:end] for begin, end in ends]
        return to_json(document, inf_nan_mode="null") + b"\n"


class NpyWriter:
    """A structured array with one field per column.

    If rows have several entries, the field `row` has the number of the row.
    """

    def __init__(
        self, _operation: Operation, _level: QueryLevel, _body: Body, _warnings: Sequence[str]
    ) -> None:
        pass

    def head(self, first: Result, entries: int) -> bytes:
        """Return the header of the file."""
        file = io.BytesIO()
        header = {
            "descr": np.lib.format.dtype_to_descr(_record(first)),
            "fortran_order": False,
            "shape": (entries,),
        }
        np.lib.format.write_array_header_1_0(file, header)
        return file.getvalue()

    def piece(self, start: int, result: Result) -> bytes:
        """Return the records of some rows."""
        length = len(next(iter(result.columns.values())))
        records = np.empty(length, _record(result))
        for name, values in result.columns.items():
            records[name] = values
        if result.offsets is not None:
            counts = np.diff(result.offsets)
            records["row"] = np.repeat(np.arange(start, start + len(counts)), counts)
        return records.tobytes()


class CsvWriter:
    """A table: the client's columns or the colours, then the columns of the result.

    A row with several entries is repeated. A row without any has empty cells.
    """

    def __init__(
        self, operation: Operation, level: QueryLevel, body: Body, _warnings: Sequence[str]
    ) -> None:
        self._operation = operation
        self._level = level
        self._inputs = body.inputs
        self._axes = body.axes or level.axes
        self._own = None if body.table is None else body.table.rows()
        self._header = None if body.table is None else body.table.header

    def head(self, first: Result, _entries: int) -> bytes:
        """Return the line with the names of the columns."""
        own = self._header
        if own is None:
            prefixes = [f"{name}_" for name in self._operation.inputs]
            prefixes = prefixes if len(prefixes) > 1 else [""]
            own = [prefix + axis for prefix in prefixes for axis in self._axes]
        return _lines([own + self._names(first)])

    def _names(self, result: Result) -> list[str]:
        """Return the names of the appended columns."""
        parts = {column.name: column.parts for column in self._operation.columns}
        names = {
            "": [""],
            "axes": [f"_{axis}" for axis in self._axes],
            "channels": [f"_{channel}" for channel in result.channels],
        }
        return [name + part for name in result.columns for part in names[parts[name]]]

    def piece(self, start: int, result: Result) -> bytes:
        """Return the lines of some rows."""
        columns = [part for values in result.columns.values() for part in _parts(values)]
        if result.offsets is None:
            rows = len(columns[0])
            offsets = None
        else:
            rows = len(result.offsets) - 1
            offsets = result.offsets.tolist()
        pieces = []
        for begin in range(0, rows, _AT_ONCE):
            end = min(begin + _AT_ONCE, rows)
            own = self._cells(start + begin, start + end)
            if offsets is None:
                found = zip(*(_texts(column[begin:end]) for column in columns), strict=True)
                added = ([_empty_if_nan(cell) for cell in new] for new in found)
                pieces.append(_lines([*cells, *new] for cells, new in zip(own, added, strict=True)))
                continue
            first, last = offsets[begin], offsets[end]
            entries = list(zip(*(_texts(column[first:last]) for column in columns), strict=True))
            nothing = [("",) * len(columns)]
            ends = pairwise(offsets[begin : end + 1])
            pieces.append(
                _lines(
                    [*cells, *new]
                    for cells, (one, two) in zip(own, ends, strict=True)
                    for new in entries[one - first : two - first] or nothing
                )
            )
        return b"".join(pieces)

    def _cells(self, start: int, end: int) -> Sequence[Sequence[object]]:
        if self._own is not None:
            return list(islice(self._own, end - start))
        return np.hstack([points[start:end] for points in self._inputs]).tolist()  # type: ignore[no-any-return]


WRITERS: dict[str, type[JsonWriter | NpyWriter | CsvWriter]] = {
    JSON: JsonWriter,
    NPY: NpyWriter,
    CSV: CsvWriter,
}
"""Writers by media type."""


def view_file(media_type: str, levels: dict[str, Any], answered: Answered) -> bytes:
    """Return the answer to a view as a file.

    Parameters
    ----------
    media_type : str
        A key of `WRITERS`.
    levels : dict
        Members of the JSON document about the levels, their gamuts, and warnings.
    answered : Answered
    """
    if media_type == JSON:
        return to_json(_lists({**levels, **answered.document}), inf_nan_mode="null") + b"\n"
    table = answered.table
    if media_type == NPY:
        records = np.empty(len(next(iter(table.values()))), _record(Result(table)))
        for name, values in table.items():
            records[name] = values
        file = io.BytesIO()
        np.save(file, records, allow_pickle=False)
        return file.getvalue()
    names = []
    for name, values in table.items():
        parts = answered.parts.get(name, ())
        names += [f"{name}_{part}" for part in parts] if values.ndim > 1 else [name]
    columns = [_texts(part) for values in table.values() for part in _parts(values)]
    rows = zip(*columns, strict=True)
    return _lines([names]) + _lines([_empty_if_nan(cell) for cell in row] for row in rows)


def _lists(value: Any) -> Any:  # noqa: ANN401 - JSON
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, dict):
        return {name: _lists(member) for name, member in value.items()}
    if isinstance(value, list):
        return [_lists(member) for member in value]
    return value


def _empty_if_nan(cell: object) -> object:
    return "" if cell != cell else cell  # noqa: PLR0124 - NaN is unequal to itself


def _record(result: Result) -> np.dtype[Any]:
    """Return the type of the records of a result, without gaps."""
    fields: list[Any] = [] if result.offsets is None else [("row", "<i4")]
    for name, values in result.columns.items():
        kind = values.dtype.newbyteorder("<")
        fields.append((name, kind, values.shape[1:]) if values.ndim > 1 else (name, kind))
    return np.dtype(fields)


def _parts(values: NDArray[Any]) -> list[NDArray[Any]]:
    return [values] if values.ndim == 1 else list(values.T)


def _texts(values: NDArray[Any]) -> list[object]:
    if values.dtype.kind == "b":
        return ["true" if value else "false" for value in values.tolist()]
    texts: list[object] = values.tolist()
    return texts


def _lines(rows: Iterator[list[object]] | list[list[str]]) -> bytes:
    text = io.StringIO()
    csv.writer(text).writerows(rows)
    return text.getvalue().encode()
