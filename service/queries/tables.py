"""Tables of colours as CSV (RFC 4180): the client's columns are kept, and results are appended.

The text is read twice: once for the colours, and once for the cells, while the answer is written.
The cells are therefore never in memory all at once.
"""

from __future__ import annotations

import csv
import io
import re
from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.errors import InvalidPointsError
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from gamutcore.arrays import FloatArray

__all__ = ["Table", "read_table"]

_AT_ONCE = 1000
"""Rows that are parsed without a chance for other threads: about a millisecond."""

_LONGEST_SHOWN = 40


class Table(NamedTuple):
    """The columns of a client.

    Attributes
    ----------
    content : bytearray
    header : list of str
    """

    content: bytearray
    header: list[str]

    def rows(self) -> Iterator[list[str]]:
        """Iterate over the cells of all rows."""
        reader = _reader(self.content)
        next(reader)
        return (cells for cells in reader if cells)

    def line_of(self, row: int) -> int:
        """Return the line in which a row ends, counted from 1."""
        reader = _reader(self.content)
        next(reader)
        for _ in islice((cells for cells in reader if cells), row + 1):
            pass
        line: int = reader.line_num
        return line


def read_table(
    content: bytearray, names: Sequence[str], axes: Sequence[str], most: int
) -> tuple[list[FloatArray], Table]:
    """Return the colours in a table.

    Parameters
    ----------
    content : bytearray
        UTF-8.
    names : sequence of str
        Names of the colours of a row. With several, columns have them as a prefix: ``from_L``.
    axes : sequence of three str
        Names of the coordinates. Columns are matched by their letters and digits, and may begin
        with ``LAB``: ``L*``, ``l`` and ``LAB_L`` are the same.
    most : int
        Largest number of rows.

    Returns
    -------
    list of (n, 3) float64
        Infinities and NaN are kept.
    Table

    Raises
    ------
    ProblemError
        There is no such column, rows have different lengths, or there are too many.
    InvalidPointsError
        A cell is not a number.
    """
    reader = _reader(content)
    try:
        header: list[str] = next(reader, [])
        places = [_places(header, name if len(names) > 1 else "", axes) for name in names]
        wanted = [place for three in places for place in three]
        values = np.empty((0, len(wanted)))
        parts = []
        count = 0
        while block := list(islice(reader, _AT_ONCE)):
            rows = [cells for cells in block if cells]
            parts.append(_numbers(rows, header, wanted, count))
            count += len(rows)
            if count > most:
                detail = f"There are more than {most} rows."
                raise ProblemError(Problem("too-many-rows", detail, {"limit": most}))
        values = np.concatenate([values, *parts])
    except csv.Error as error:
        raise _invalid(f"The table is malformed: {error}.", {"line": reader.line_num}) from error
    except UnicodeDecodeError as error:
        raise _invalid("The table is not UTF-8.", {"line": reader.line_num + 1}) from error
    inputs = [values[:, 3 * place : 3 * place + 3] for place in range(len(names))]
    return inputs, Table(content, header)


def _reader(content: bytearray) -> Any:  # noqa: ANN401 - the type has no name
    text = io.TextIOWrapper(io.BytesIO(content), encoding="utf-8-sig", newline="")
    return csv.reader(text, strict=True)


def _places(header: list[str], prefix: str, axes: Sequence[str]) -> list[int]:
    """Return the places of the three columns of a colour."""
    folded = [_fold(name) for name in header]
    places = []
    for axis in axes:
        accepted = {_fold(prefix + axis), _fold(f"{prefix}lab{axis}")}
        found = [place for place, name in enumerate(folded) if name in accepted]
        if len(found) != 1:
            column = f"{prefix}_{axis}" if prefix else axis
            shown = ", ".join(header)[:200] or "none"
            fault = "no column" if not found else f"{len(found)} columns"
            remedy = (
                f"Name the columns of the colours {', '.join(axes)}, with the prefixes of the "
                "operation if a row has several colours. Columns of another space need `space`."
            )
            if len(header) == 1 and any(mark in header[0] for mark in ";\t"):
                remedy = "Separate the cells by commas, and write numbers with a decimal point."
            raise _invalid(
                f"The table has {fault} {column}. Its columns are: {shown}.",
                {"line": 1, "field": column},
                remedy,
            )
        places.append(found[0])
    return places


def _numbers(rows: list[list[str]], header: list[str], wanted: list[int], start: int) -> FloatArray:
    width = len(header)
    for at, cells in enumerate(rows):
        if len(cells) != width:
            detail = f"Row {start + at} has {len(cells)} cells; the header has {width}."
            raise _invalid(detail, {"row": start + at})
    try:
        return np.array([[float(cells[place]) for place in wanted] for cells in rows]).reshape(
            -1, len(wanted)
        )
    except ValueError:
        for at, cells in enumerate(rows):
            for place in wanted:
                _check_number(cells[place], header[place], start + at)
        raise


def _check_number(cell: str, column: str, row: int) -> None:
    try:
        float(cell)
    except ValueError:
        raise InvalidPointsError(
            f"Row {row} has {cell[:_LONGEST_SHOWN]!r} in the column {column[:_LONGEST_SHOWN]}.",
            where={"field": column[:_LONGEST_SHOWN], "row": row},
            remedy="Give numbers with a decimal point.",
        ) from None


def _fold(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


def _invalid(detail: str, where: dict[str, Any], remedy: str = "") -> ProblemError:
    remedy = remedy or "Send a table as RFC 4180 defines it, in UTF-8, with a header line."
    return ProblemError(Problem("invalid-body", detail, where, remedy))
