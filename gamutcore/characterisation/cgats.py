"""The CGATS family of text files: CGATS.17, IT8.7/x, Argyll's .ti3, ECI2002, ISO 28178, IDMS.

The family has one grammar (CGATS.17-2009) and many dialects. The reader is therefore tolerant: it
trusts the data rather than the counts in the header, and its warnings state the differences. It
makes one pass over the lines. It uses the first table with colours, or the table of the chosen
measurement condition. Measurement and envelope files of the colour gamut envelope (CGE, IDMS 1.3)
belong to the family.

A spreadsheet saves such a file as cells: it separates them by tabs, commas or semicolons, encloses
cells in quotation marks and doubles those within.

Argyll's charts (.ti1, .ti2) have the same form, but their colours are estimates, made before
anything was printed. They are refused unless the caller wants estimates. Only their first table has
the patches; the others have the densest inks and the combinations of inks.
"""

from __future__ import annotations

import csv
import re
from collections import deque
from enum import Enum, auto
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.characterisation.columns import (
    CONDITION_KEYWORDS,
    MAX_COLUMNS,
    WHOLE_KEYWORDS,
    ColumnRoles,
    chosen_condition,
    column_roles,
    condition_label,
    stated_condition,
)
from gamutcore.characterisation.samples import samples_from_values
from gamutcore.characterisation.text import (
    SEP_LINE,
    NumberTable,
    most_frequent_separator,
    number,
    text_lines,
)
from gamutcore.errors import (
    ConditionError,
    MalformedFileError,
    MissingColumnError,
    SampleLimitError,
    UnrecognisedFormatError,
)

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.samples import Samples

__all__ = ["cgats_rows", "cgats_samples", "looks_like_cgats"]

_DATA_MARK = re.compile(r"\bBEGIN_DATA(?:_FORMAT)?\b", re.IGNORECASE)
_HEADER_TOKEN = re.compile(r'""([^"]+)""|"([^"]*)(?:"|$)|([^\s"]+)')
_DATA_TOKEN = re.compile(r'"([^"]*)(?:"|$)|([^\s"]+)')
_SPECIAL = re.compile(r"[\"#]|END_DATA", re.IGNORECASE)
_COUNTS = ("NUMBER_OF_FIELDS", "NUMBER_OF_SETS")
_STRUCTURE = frozenset({*_COUNTS, "BEGIN_DATA_FORMAT", "END_DATA_FORMAT", "BEGIN_DATA", "END_DATA"})
_ILLUMINATION = "ILLUMINATION_PERFECT_DIFFUSE_REFLECTOR_XYZ"
"""IDMS 1.3: the reference of the colours of reflective displays."""

_SINGLE_VALUES = frozenset(
    {
        *("ILLUMINANT", "ILLUMINATION_NAME", _ILLUMINATION, "LUMINANCE_XYZ_CDM2"),
        *("OBSERVER", "OBSERVER_ANGLE", "CIE_OBSERVER", "CIE_OBSERVER_ANGLE"),
        *("DEVICE_CLASS", "CGV_DISPLAY_TYPE", "COLOR_REP", "IDMS_FILE_TYPE"),
        *WHOLE_KEYWORDS,
    }
)
"""Keywords that have one value. Other keywords may repeat, with one statement each."""

_CHARTS = {"CTI1": ".ti1", "CTI2": ".ti2"}
"""First words of Argyll's charts (ArgyllCMS, File Formats), and their extensions."""

_CHART_DESCRIPTOR = re.compile(r"Calibration Target chart information ([12])\b", re.IGNORECASE)
"""Descriptor of the same charts, for files whose first line another program has changed."""

_CHART_WHITE = "APPROX_WHITE_POINT"
"""Keyword of the white that the estimates of a chart are relative to, Y 100."""

_FORMAT_START = re.compile("BEGIN_DATA_FORMAT", re.IGNORECASE)
_FORMAT_END = re.compile("END_DATA_FORMAT", re.IGNORECASE)
_HEADER_CHARACTERS = 1_000_000
"""Length of the part of a text in which the names of the columns are sought."""

_MAX_KEYWORDS = 10_000
_MAX_REPETITIONS = 20
"""Maximum number of texts of one keyword that are kept."""
_MAX_TABLES = 100
"""Maximum number of tables in a file. Real files have one or two."""


class _State(Enum):
    HEADER = auto()
    FORMAT = auto()
    DATA = auto()
    SKIPPED_DATA = auto()


class _Token(NamedTuple):
    text: str
    quoted: bool

    @property
    def structure(self) -> str:
        """The structural keyword in upper case; empty for other tokens."""
        upper = self.text.upper()
        return upper if not self.quoted and upper in _STRUCTURE else ""


def looks_like_cgats(text: str) -> bool:
    """Return whether a text has a CGATS data or data format section."""
    # the expression alone takes seconds for a large table
    return "begin_data" in text.lower() and _DATA_MARK.search(text) is not None


def cgats_samples(text: str, *, condition: str | None = None, estimates: bool = False) -> Samples:
    """Return the samples of the first table with colours in a text of the CGATS family.

    `estimates` accepts charts. Their samples have the white of the chart, and their provenance has
    ``chart``.

    Conditions are the keywords before the end of the table. Different texts of a repeated keyword
    in one header are joined by "; ". Of keywords with a single value, such as DEVICE_CLASS, the
    last one counts.
    """
    return _parsed(_Parser(condition), text).samples(estimates=estimates)


def cgats_rows(text: str, *, condition: str | None = None) -> tuple[list[str], list[list[str]]]:
    """Return the names of the columns and the cells of the table that `cgats_samples` reads."""
    reader = _Parser(condition)
    reader.cells = []
    _parsed(reader, text)
    return [] if reader.table is None else list(reader.table.roles.names), reader.cells


def _parsed(reader: _Parser, text: str) -> _Parser:
    """Return the reader after all lines of a text, or of the cells of a spreadsheet."""
    separator = _spreadsheet_separator(text[:_HEADER_CHARACTERS])
    for line, content in text_lines(text):
        if separator is None:
            reader.read(content, line)
        elif line > 1 or not SEP_LINE.fullmatch(content):
            reader.read_cells(_cells(content, separator, line), line)
    return reader


def _spreadsheet_separator(text: str) -> str | None:
    """Return the separator of the cells that a spreadsheet saved; None for plain CGATS.

    Names of columns have no commas or semicolons. Without such a separator, the quotation marks of
    the header tell.
    """
    start = _FORMAT_START.search(text)
    end = None if start is None else _FORMAT_END.search(text, start.end())
    if start is None or end is None:
        return None
    # whole lines, because quotation marks and separators may surround the keywords
    lines = text[start.end() : end.start()].splitlines()
    names = " ".join(line.strip(",;\t ") for line in lines[1:] or lines)
    # without one between the names, all of them are in the first of several cells
    separator = most_frequent_separator(names) or "".join(lines[:1]).strip()[-1:]
    if separator in {",", ";"}:
        return separator
    header = text[: start.end()] + '"' * (text[start.end() : start.end() + 1] == '"')
    quoted = (_is_quoted_cell(line, number) for number, line in enumerate(header.splitlines(), 1))
    return "\t" if any(quoted) else None


def _is_quoted_cell(content: str, line: int) -> bool:
    """Return whether a line of the header is quoted as a whole, or has a cell with quoted quotes.

    MeasureTool writes quoted lines without a keyword, and others double the quotes of a value.
    """
    if not content.startswith('"') and '"""' not in content:
        return False
    cells = _cells(content, "\t", line)
    if cells and content.startswith('"') and cells[0].upper() in _STRUCTURE:
        return True
    return any('"' in cell and '""' not in cell for cell in cells)


def _cells(content: str, separator: str, line: int) -> list[str]:
    """Return the cells of a line without surrounding space and without empty cells at the end."""
    rows = csv.reader([content.rstrip("\r\n")], delimiter=separator, skipinitialspace=True)
    try:
        cells = [cell.strip() for cell in next(rows, [])]
    except csv.Error as error:
        raise MalformedFileError(
            f"The row cannot be split into cells: {error}.",
            where={"line": line},
            remedy="Close every quotation mark, and double those within a cell.",
        ) from None
    while cells and not cells[-1]:
        cells.pop()
    return cells


class _Parser:
    """State machine over the tokens of lines, in linear time."""

    def __init__(self, condition: str | None) -> None:
        self.condition = condition
        self.conditions: list[str | None] = []
        self.state = _State.HEADER
        self.keywords: dict[str, str] = {}
        self.keyword_lines: dict[str, int] = {}
        self.header: dict[str, list[str]] = {}
        self.own: dict[str, str] = {}
        self.stated: str | None = None
        self.dialect = ""
        self.dialect_line = 1
        self.warnings: list[str] = []
        self.counts: dict[str, str] = {}
        self.fields: list[str] = []
        self.fields_line = 0
        self.table: NumberTable | None = None
        self.cells: list[list[str]] | None = None
        self.row: list[str] = []
        self.row_line = 0
        self.refusal: MissingColumnError | None = None
        self.finished = False
        self.other_tables = 0
        self.tables = 0

    def read(self, content: str, line: int) -> None:
        if self.state is _State.DATA and not _SPECIAL.search(content):
            # Fast path for plain rows: str.split instead of the regular expression.
            words = content.split()
            if words:
                self._data_row(words, line)
            return
        tokens = _tokens(content, data=self.state in (_State.DATA, _State.SKIPPED_DATA))
        # Each section takes tokens from the left of the line.
        while tokens:
            if self.state is _State.HEADER:
                self._header(tokens, line)
            elif self.state is _State.FORMAT:
                self._format(tokens, line)
            else:
                self._data(tokens, line)

    def read_cells(self, cells: list[str], line: int) -> None:
        """Read a line of a spreadsheet. A single cell holds a line of plain CGATS."""
        if len(cells) < 2 or cells[0].startswith("#"):
            self.read(cells[0] if cells else "", line)
        elif self.state is _State.DATA and cells[0].upper() != "END_DATA":
            # cells that are empty up to the end of the row have been removed
            self._data_row([*cells, *[""] * (len(self.fields) - len(cells))], line)
        elif self.state is _State.FORMAT and cells[0].upper() not in _STRUCTURE:
            self._format(deque(_Token(cell, quoted=True) for cell in cells), line)
        else:
            self.read(" ".join(cells), line)

    def samples(self, *, estimates: bool) -> Samples:
        chart = self._chart()
        if chart and not estimates:
            raise self._refused_chart(chart)
        if self.state is _State.DATA and self.table is not None:
            self.warnings.append("END_DATA is missing; the data ends with the file.")
            self._end_of_table()
        if len(set(self.conditions)) > 1 or (self.conditions and self.table is None):
            chosen_condition(self.conditions, self.condition)
        if self.table is None or not self.finished:
            if self.refusal is not None:
                raise self.refusal
            raise MalformedFileError(
                "The file has no table of data.",
                where={"line": self.fields_line or 1},
                remedy="A table is BEGIN_DATA_FORMAT, column names, END_DATA_FORMAT, BEGIN_DATA, "
                "rows, END_DATA.",
            )
        if self.other_tables:
            self.warnings.append(f"{self.other_tables} further table(s) in the file are not used.")
        values, lines = self.table.arrays()
        samples = samples_from_values(
            "cgats",
            self.table.roles,
            values,
            lines=lines,
            conditions=self.keywords,
            white=self._chart_white() if chart else None,
            illumination=self._illumination(),
            condition=self.condition,
            row_conditions=self.table.row_conditions,
            warnings=self.warnings,
        )
        samples.provenance["dialect"] = self.keywords.get("IDMS_FILE_TYPE", self.dialect)[:80]
        if chart:
            samples.provenance["chart"] = chart
        return samples

    def _chart(self) -> str:
        """Return the kind of the chart, a key of `_CHARTS`; empty for measurements."""
        dialect = self.dialect.upper()
        if dialect in _CHARTS or dialect == "CTI3":
            return dialect if dialect in _CHARTS else ""
        descriptor = _CHART_DESCRIPTOR.search(self.keywords.get("DESCRIPTOR", ""))
        return "" if descriptor is None else f"CTI{descriptor[1]}"

    def _refused_chart(self, chart: str) -> UnrecognisedFormatError:
        by_first_word = self.dialect.upper() == chart
        line = self.dialect_line if by_first_word else self.keyword_lines["DESCRIPTOR"]
        return UnrecognisedFormatError(
            f"The file is a chart of Argyll ({chart}, {_CHARTS[chart]}), not measurements: its "
            "colours are estimates, which give the gamut of a device that does not exist.",
            where={"line": line},
            remedy="Print or show the chart, measure it (chartread, dispread), and give the "
            "measurements (.ti3). Or ask how its patches lie in a gamut: gamut query "
            f"chart{_CHARTS[chart]} --gamut press.icc.",
        )

    def _chart_white(self) -> FloatArray | None:
        """Return XYZ of the white of a chart, Y about 100; None if the chart does not state it."""
        try:
            white = np.array([number(word) for word in self.keywords[_CHART_WHITE].split()])
        except (KeyError, ValueError):
            return None
        if len(white) != 3 or not ((white > 0) & (white < 1000)).all():
            return None
        return white if white[1] > 2.0 else 100.0 * white

    def _illumination(self) -> FloatArray | None:
        """Return XYZ of the perfect diffuser, the reference of reflective displays."""
        text = self.keywords.get(_ILLUMINATION)
        if text is None:
            return None
        try:
            values = [number(word) for word in text.split()]
        except ValueError:
            values = []
        if len(values) != 3 or not all(0 < value < 1e6 for value in values):
            raise MalformedFileError(
                f"{_ILLUMINATION} is {text[:40]!r}.",
                where={"line": self.keyword_lines[_ILLUMINATION], "field": _ILLUMINATION},
                remedy="Write X, Y and Z of the perfect diffuser, such as 102 100 63.7.",
            )
        return np.array(values)

    def _header(self, tokens: deque[_Token], line: int) -> None:
        head = tokens.popleft()
        word = head.structure
        if word in _COUNTS:
            plain = bool(tokens) and not tokens[0].structure
            self.counts[word] = tokens.popleft().text if plain else ""
        elif word == "BEGIN_DATA_FORMAT":
            self.state, self.fields, self.fields_line = _State.FORMAT, [], line
        elif word == "BEGIN_DATA":
            self._begin_data(line)
        elif not word and not head.quoted:
            value = []
            if tokens and tokens[0].quoted:
                value.append(tokens.popleft().text)
            else:
                while tokens and not tokens[0].structure:
                    value.append(tokens.popleft().text)
            if not self.dialect and not self.tables and not self.keywords:
                self.dialect, self.dialect_line = head.text, line
            if value and head.text.upper() != "KEYWORD":
                self._keyword(head.text.upper(), " ".join(value).strip(), line)
        elif head.quoted and "MEASUREMENTCONDITION=" in head.text.upper():
            # MeasureTool writes such lines without a keyword.
            self._keyword("MEASUREMENT_SOURCE", head.text, line)

    def _keyword(self, name: str, value: str, line: int) -> None:
        if name in self.header and name not in _SINGLE_VALUES:
            texts = self.header[name]
            if value not in texts and len(texts) < _MAX_REPETITIONS:
                texts.append(value)
            value = "; ".join(texts)
        elif len(self.header) < _MAX_KEYWORDS:
            self.header[name] = [value]
        if name in CONDITION_KEYWORDS:
            self.own[name] = value
        if self.finished:  # keywords after the used table do not apply to it
            return
        if len(self.keywords) >= _MAX_KEYWORDS and name not in self.keywords:
            raise SampleLimitError(
                f"The file has more than {_MAX_KEYWORDS} keywords.",
                where={"line": line},
                remedy="Leave out keywords that do not describe the table.",
            )
        self.keywords[name] = value
        self.keyword_lines[name] = line

    def _format(self, tokens: deque[_Token], line: int) -> None:
        while tokens:
            if tokens[0].structure == "BEGIN_DATA":
                self.warnings.append(f"END_DATA_FORMAT is missing before line {line}.")
                self.state = _State.HEADER
                return
            token = tokens.popleft()
            if token.structure == "END_DATA_FORMAT":
                self.state = _State.HEADER
                return
            self.fields_line = line if not self.fields else self.fields_line
            self.fields.append(token.text)
            if len(self.fields) > MAX_COLUMNS:
                raise SampleLimitError(
                    f"The table has more than {MAX_COLUMNS} columns.",
                    where={"line": line},
                    remedy=f"Leave out columns that are not needed, down to {MAX_COLUMNS}.",
                )

    def _begin_data(self, line: int) -> None:
        self.state = _State.SKIPPED_DATA
        self.header = {}
        self.tables += 1
        if self.tables > _MAX_TABLES:
            raise SampleLimitError(
                f"The file has more than {_MAX_TABLES} tables.",
                where={"line": line},
                remedy="Send the table with the measurements alone.",
            )
        if not self.fields:
            if self.finished:
                self.other_tables += 1
                return
            raise MalformedFileError(
                "The data section has no column names before it.",
                where={"line": line},
                remedy="Put BEGIN_DATA_FORMAT, the column names and END_DATA_FORMAT before it.",
            )
        if self.finished:
            self._later_table()
            return
        if self.tables > 1 and self._chart():
            self.other_tables += 1
            return
        try:
            roles = column_roles(
                self.fields, condition=self.condition, where={"line": self.fields_line}
            )
        except MissingColumnError as error:
            self.refusal = self.refusal or error
            return
        if roles.condition is None and roles.condition_column is None:
            stated = self._table_condition()
            self.conditions.append(stated)
            if self.condition is not None and stated != condition_label(self.condition):
                self.other_tables += 1
                return
        self.state, self.table = _State.DATA, NumberTable(roles)
        self.row, self.row_line = [], 0
        self._compare("NUMBER_OF_FIELDS", len(self.fields), "columns")

    def _table_condition(self) -> str | None:
        """Return the condition of the next table: of its header, or else of the table before."""
        stated = stated_condition(self.own)
        if stated is not None:
            for name in CONDITION_KEYWORDS - set(self.own):
                self.keywords.pop(name, None)
            self.stated = stated
        self.own = {}
        return self.stated

    def _later_table(self) -> None:
        """Record the measurement condition of a table after the used one."""
        self.other_tables += 1
        stated = stated_condition(self.own)
        self.own = {}
        if stated is not None and self.conditions and self.conditions[0] is not None:
            try:
                column_roles(self.fields)
            except (MissingColumnError, ConditionError):
                return
            self.conditions.append(stated)

    def _data(self, tokens: deque[_Token], line: int) -> None:
        row, ended = [], False
        while tokens and not ended:
            token = tokens.popleft()
            ended = token.structure == "END_DATA"
            if not ended:
                row.append(token.text)
        if row and self.state is _State.DATA:
            self._data_row(row, line)
        if not ended:
            return
        if self.state is _State.DATA:
            self._end_of_table()
        self.state = _State.HEADER

    def _data_row(self, words: list[str], line: int) -> None:
        assert self.table is not None  # noqa: S101 (the state DATA is entered with a table)
        width = len(self.fields)
        if not self.row and len(words) == width:
            self._append(words, line)
            return
        # A row may span several lines; it ends at the end of a line.
        if not self.row:
            self.row_line = line
        self.row.extend(words)
        if len(self.row) > width:
            self.row = _with_names_joined(self.row, self.table.roles)
        if len(self.row) == width:
            self._append(self.row, self.row_line)
            self.row = []
        elif len(self.row) > width:
            raise self._wrong_row()

    def _append(self, row: list[str], line: int) -> None:
        assert self.table is not None  # noqa: S101 (the state DATA is entered with a table)
        self.table.append(row, line)
        if self.cells is not None:
            self.cells.append(row)

    def _wrong_row(self) -> MalformedFileError:
        return MalformedFileError(
            f"The row that starts here has {len(self.row)} values for {len(self.fields)} columns.",
            where={"line": self.row_line, "column": min(len(self.row), len(self.fields)) + 1},
            remedy="Every row needs one value for each name between BEGIN_DATA_FORMAT and "
            "END_DATA_FORMAT; names with spaces are quoted.",
        )

    def _end_of_table(self) -> None:
        if self.row:
            raise self._wrong_row()
        assert self.table is not None  # noqa: S101 (only the state DATA ends a table)
        self._compare("NUMBER_OF_SETS", self.table.count, "rows")
        self.finished = True

    def _compare(self, keyword: str, count: int, what: str) -> None:
        announced = self.counts.pop(keyword, None)
        if announced is None:
            self.warnings.append(f"{keyword} is missing; the table has {count} {what}.")
        elif announced != str(count):
            self.warnings.append(
                f"{keyword} is {announced[:20]}, but the table has {count} {what}."
            )


def _tokens(content: str, *, data: bool) -> deque[_Token]:
    tokens: deque[_Token] = deque()
    for match in (_DATA_TOKEN if data else _HEADER_TOKEN).finditer(content):
        plain = match[match.re.groups]
        if plain is None:
            tokens.append(
                _Token(next((g for g in match.groups() if g is not None), ""), quoted=True)
            )
        elif plain.startswith("#"):
            break
        else:
            tokens.append(_Token(plain, quoted=False))
    return tokens


def _with_names_joined(row: list[str], roles: ColumnRoles) -> list[str]:
    """Return a row with an unquoted name of several words, before the numbers, as one value."""
    first = min(roles.selected)
    surplus = len(row) - len(roles.names)
    if first == 0 or not row[first - 1 : first + surplus]:
        return row
    joined = " ".join(row[first - 1 : first + surplus])
    if any(character.isalpha() for character in joined):
        return [*row[: first - 1], joined, *row[first + surplus :]]
    return row
