"""Forms of the answers to queries: JSON, structured .npy and CSV.

JSON is one document. The others are written piece by piece, because a million rows take more memory
as an answer than as a body.
"""

from __future__ import annotations

import csv
import io
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic_core import to_json

from service.questions.colour_bodies import CSV, JSON, NPY

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from gamutcore.questions import Answer, Question
    from gamutcore.tables import ColourTable
    from service.library import QueryLevel
    from service.questions.colour_bodies import QuestionBody

__all__ = [
    "WRITERS",
    "Writer",
    "condition_headers",
    "level_document",
    "reading_header",
    "shape_file",
    "warning_header",
]

_AT_ONCE = 2000
"""Rows of CSV that are written without a chance for other threads: some milliseconds."""


LONGEST_LABEL = 100
"""Characters of a label that an answer repeats."""

_LONGEST_FIELD = 400
"""Characters of a text in a header field."""


def level_document(level: QueryLevel) -> dict[str, Any]:
    """Return the JSON of a level."""
    return {"triangles": level.triangles, "max_error": level.max_error}


def condition_headers(levels: Sequence[QueryLevel], warnings: Sequence[str]) -> dict[str, str]:
    """Return the header fields with the conditions of gamuts, and with warnings if there are any.

    Warnings are a list of strings (RFC 9651, 3.1 and 3.3.3), which are ASCII.
    """
    fields = {"Gamut-Conditions": ", ".join(level.gamut.conditions.header for level in levels)}
    return fields | warning_header(warnings)


def warning_header(warnings: Sequence[str]) -> dict[str, str]:
    """Return the header field with warnings if there are any."""
    if not warnings:
        return {}
    plain = (warning.encode("ascii", "replace").decode() for warning in warnings)
    escaped = (text.replace("\\", "\\\\").replace('"', '\\"') for text in plain)
    return {"Gamut-Warning": ", ".join(f'"{text}"' for text in escaped)}


def reading_header(table: ColourTable | None) -> dict[str, str]:
    """Return the header field with what was understood of a table.

    It is a string, or a display string if it is not ASCII (RFC 9651, 3.3.3 and 3.3.8).
    """
    if table is None:
        return {}
    text = table.reading[:_LONGEST_FIELD]
    if text.isascii() and text.isprintable():
        escaped = text.replace("\\", "\\\\").replace('"', '\\"')
        return {"Gamut-Reading": f'"{escaped}"'}
    plain = frozenset(range(0x20, 0x7F)) - set(b'%"')
    encoded = (chr(byte) if byte in plain else f"%{byte:02x}" for byte in text.encode())
    return {"Gamut-Reading": f'%"{"".join(encoded)}"'}


class Writer:
    """Writes an answer from its first row to its last."""

    def __init__(
        self, question: Question, level: QueryLevel, body: QuestionBody, warnings: Sequence[str]
    ) -> None:
        self.question, self.level, self.body, self.warnings = question, level, body, warnings

    def head(self, _first: Answer, _entries: int) -> bytes:
        """Return what comes before the rows, from the answer of the first rows.

        `entries` is the length of the answer: more than that of the body if rows have several.
        """
        return b""

    def piece(self, start: int, result: Answer) -> bytes:
        """Return the bytes of the rows from `start` on."""
        raise NotImplementedError


class JsonWriter(Writer):
    """One object: the level, the conditions of the gamut, warnings, and one array per column."""

    def piece(self, start: int, result: Answer) -> bytes:
        """Return the document."""
        assert start == 0  # noqa: S101 - rows of JSON fit into one piece
        document: dict[str, Any] = {
            "level": level_document(self.level),
            "gamut": self.level.gamut.conditions.to_dict(),
            "warnings": list(self.warnings),
            **result.echoed,
            **self._understood(),
        }
        for name, values in result.columns.items():
            document[name] = values.tolist()
            if result.offsets is not None:
                ends = pairwise(result.offsets.tolist())
                document[name] = [document[name][begin:end] for begin, end in ends]
        return to_json(document, inf_nan_mode="null") + b"\n"

    def _understood(self) -> dict[str, Any]:
        """Return what was understood of a table: its colours in the space of the gamut."""
        table = self.body.table
        if table is None:
            return {}
        convert = self.level.gamut.convert
        named = zip(self.question.inputs, table.inputs, strict=True)
        return {
            "reading": table.reading,
            "labels": [label[:LONGEST_LABEL] for label in table.labels()],
            "lines": table.lines_of_rows,
            **{name: convert(points, table.space).tolist() for name, points in named},
        }


class NpyWriter(Writer):
    """A structured array with one field per column.

    If rows have several entries, the field `row` has the number of the row.
    """

    def head(self, first: Answer, entries: int) -> bytes:
        """Return the header of the file."""
        return _npy_header(first, entries)

    def piece(self, start: int, result: Answer) -> bytes:
        """Return the records of some rows."""
        records = _records(result)
        if result.offsets is not None:
            counts = np.diff(result.offsets)
            records["row"] = np.repeat(np.arange(start, start + len(counts)), counts)
        return records.tobytes()


class CsvWriter(Writer):
    """A table: the client's columns or the colours, then the columns of the result.

    A row with several entries is repeated. A row without any, or without a colour, has empty cells.
    The client's table keeps its dialect, in UTF-8.
    """

    def __init__(
        self, question: Question, level: QueryLevel, body: QuestionBody, warnings: Sequence[str]
    ) -> None:
        super().__init__(question, level, body, warnings)
        self._axes = body.axes or level.axes
        self._table = body.table
        self._own = None if body.table is None else body.table.rows()
        self._column_parts = {column.name: column.parts for column in question.columns}

    def head(self, first: Answer, _entries: int) -> bytes:
        """Return the line with the names of the columns."""
        if self._table is not None:
            mark = "\ufeff" if self._table.encoding == "utf-8-sig" else ""
            head = self._table.head(self._table.added_names(self._names(first)))
            return (mark + head).encode()
        prefixes = [f"{name}_" for name in self.question.inputs]
        prefixes = prefixes if len(prefixes) > 1 else [""]
        axes = self.level.gamut.channels if self.question.of_device else self._axes
        columns = [prefix + axis for prefix in prefixes for axis in axes]
        return _lines([columns + self._names(first)])

    def _own_values(self, name: str, values: NDArray[Any]) -> NDArray[Any]:
        """Return a column of a result, whose colours are in the scale of the client's table."""
        is_colour = self._column_parts[name] == "axes"
        return self._table.own_values(values) if is_colour and self._table else values

    def _names(self, result: Answer) -> list[str]:
        """Return the names of the appended columns."""
        parts = self._column_parts
        names = {
            "": [""],
            "axes": [f"_{axis}" for axis in self._axes],
            "channels": [f"_{channel}" for channel in result.channels],
        }
        return [name + part for name in result.columns for part in names[parts[name]]]

    def piece(self, start: int, result: Answer) -> bytes:
        """Return the lines of some rows."""
        columns = [
            part
            for name, values in result.columns.items()
            for part in _parts(self._own_values(name, values))
        ]
        offsets = np.arange(len(columns[0]) + 1) if result.offsets is None else result.offsets
        rows, pieces = len(offsets) - 1, []
        for begin in range(0, rows, _AT_ONCE):
            ends = offsets[begin : begin + _AT_ONCE + 1].tolist()
            first, last = ends[0], ends[-1]
            flat = list(zip(*(_texts(column[first:last]) for column in columns), strict=True))
            entries = [flat[one - first : two - first] for one, two in pairwise(ends)]
            pieces.append(self._text(start + begin, entries, len(columns)))
        if self._own is not None and start + rows == len(self.body.inputs[0]):
            pieces.append(self._text(start + rows, [], len(columns)))  # rows without a colour
        return b"".join(pieces)

    def _text(self, start: int, entries: list[list[tuple[object, ...]]], width: int) -> bytes:
        """Return the lines of some rows, each with its entries."""
        nothing = ("",) * width
        if self._table is None or self._own is None:
            end = start + len(entries)
            colours = np.hstack([points[start:end] for points in self.body.inputs]).tolist()
            return _lines(
                [*cells, *(_empty_if_nan(cell) for cell in new)]
                for cells, entry in zip(colours, entries, strict=True)
                for new in entry or [nothing]
            )
        cell_of, rows = self._table.cell, []
        following = iter(entries)
        left = len(entries)
        while left or not entries:
            cells, known = next(self._own, ([], None))
            if known is None:
                break
            entry = next(following) if known else []
            left -= known
            rows += [[*cells, *map(cell_of, new)] for new in entry or [nothing]] if cells else [[]]
        return "".join(self._table.lines(iter(rows))).encode()


WRITERS: dict[str, type[Writer]] = {JSON: JsonWriter, NPY: NpyWriter, CSV: CsvWriter}
"""Writers by media type."""


def shape_file(
    media_type: str, levels: dict[str, Any], answer: Answer, axes: Sequence[str]
) -> bytes:
    """Return the answer to a question about a shape as a file of a media type of `WRITERS`.

    `levels` has the members of the JSON document about the levels, their gamuts, and warnings.
    `axes` are the names of the coordinates.
    """
    if media_type == JSON:
        document = {**levels, **answer.document}
        return to_json(document, inf_nan_mode="null", fallback=np.ndarray.tolist) + b"\n"
    table = answer.columns
    if media_type == NPY:
        return _npy_header(answer, len(next(iter(table.values())))) + _records(answer).tobytes()
    names = []
    for name, values in table.items():
        parts = answer.channels if name == "device" else axes
        names += [f"{name}_{part}" for part in parts] if values.ndim > 1 else [name]
    columns = [_texts(part) for values in table.values() for part in _parts(values)]
    rows = zip(*columns, strict=True)
    return _lines([names]) + _lines([_empty_if_nan(cell) for cell in row] for row in rows)


def _empty_if_nan(cell: object) -> object:
    return "" if cell != cell else cell  # noqa: PLR0124 - NaN is unequal to itself


def _record(result: Answer) -> np.dtype[Any]:
    """Return the type of the records of a result, without gaps."""
    fields: list[Any] = [] if result.offsets is None else [("row", "<i4")]
    for name, values in result.columns.items():
        fields.append((name, values.dtype.newbyteorder("<"), values.shape[1:]))
    return np.dtype(fields)


def _records(result: Answer) -> NDArray[Any]:
    """Return the columns of a result as records."""
    records = np.empty(len(next(iter(result.columns.values()))), _record(result))
    for name, values in result.columns.items():
        records[name] = values
    return records


def _npy_header(result: Answer, entries: int) -> bytes:
    file = io.BytesIO()
    descr = np.lib.format.dtype_to_descr(_record(result))
    header = {"descr": descr, "fortran_order": False, "shape": (entries,)}
    np.lib.format.write_array_header_1_0(file, header)
    return file.getvalue()


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
