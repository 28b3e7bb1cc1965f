"""Text tables: their encoding, their lines and numbers, and samples in delimited text.

Spreadsheets and scripts write tables in many dialects. `DelimitedText` recognises the dialect of a
file, so that an answer can be written in the same one. `NumberTable` converts rows of text to
numbers in blocks: only needed columns, with the line of each row for errors. Memory is proportional
to the numbers, not to the text.
"""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections import Counter, deque
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.columns import are_wavelengths, column_roles, condition_label
from gamutcore.characterisation.samples import MAX_ROW_CONDITIONS, IntArray, samples_from_values
from gamutcore.errors import (
    MalformedFileError,
    MissingColumnError,
    SampleLimitError,
    UnrecognisedFormatError,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.columns import ColumnRoles
    from gamutcore.characterisation.samples import Samples

__all__ = [
    "MAX_TEXT_ROWS",
    "SEP_LINE",
    "DelimitedText",
    "NumberTable",
    "bounded_lines",
    "delimited_samples",
    "is_number",
    "mentions",
    "most_frequent_separator",
    "number",
    "text_encoding",
    "text_lines",
]

_BLOCK_BYTES = 2**20

_SEPARATORS = "\t;,|"
"""Separators in the order of preference, where several occur equally often."""

_NOWHERE = "\x1f"
"""The unit separator of ASCII: the separator for `csv` if lines are not to be split."""

SEP_LINE = re.compile(r'\ufeff?"?sep=(.)"?[\t;,|]*\r?\n?', re.IGNORECASE)
"""The first line by which Excel is told the separator."""

_COMMENT = re.compile(
    r"\s*#(?!(?:[0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})\s*(?:[\t;,|]|$))(?!\s*[\t;,|])",
    re.IGNORECASE,
)
"""A line of remarks: not a colour such as #ff0000, and not a column with the name #."""


def _encodings(data: bytes) -> Iterator[str]:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        yield "utf-16"
    start = data[:8]  # without a mark: tables and headers begin with letters of ASCII
    for encoding, high, low in (
        ("utf-16-le", start[1::2], start[::2]),
        ("utf-16-be", start[::2], start[1::2]),
    ):
        if not any(high) and low and all(low):
            yield encoding
    yield "utf-8-sig" if data.startswith(b"\xef\xbb\xbf") else "utf-8"
    yield "cp1252"
    yield "latin-1"


def _decoded_blocks(data: bytes, encoding: str) -> Iterator[str]:
    """Decode a text in blocks: all of it takes up to four bytes for each character."""
    decoder = codecs.getincrementaldecoder(encoding)()
    for start in range(0, len(data), _BLOCK_BYTES):
        end = start + _BLOCK_BYTES
        yield decoder.decode(data[start:end], final=end >= len(data))


def text_encoding(data: bytes) -> str | None:
    """Return the name of the encoding of a text; None if the content is binary."""
    for encoding in _encodings(data):
        blocks = _decoded_blocks(data, encoding)
        try:
            is_text = "\0" not in next(blocks, "")[:100_000]
            deque(blocks, maxlen=0)
        except UnicodeDecodeError:
            continue
        return encoding if is_text else None
    return None


def mentions(data: bytes, encoding: str, word: str) -> bool:
    """Return whether a text has a word, which is in lower case, in any case."""
    end = ""
    for block in _decoded_blocks(data, encoding):
        text = (end + block).lower()
        if word in text:
            return True
        end = text[-len(word) :]
    return False


class DelimitedText:
    """A text table, which is read row by row as often as needed.

    Parameters
    ----------
    data : bytes
    encoding : str
        As `text_encoding` finds it.

    Attributes
    ----------
    separator : str
        A character; a space if white space separates the cells; empty for a single column.
    preamble : list of str
        Lines before the first row: ``sep=``, remarks and empty lines.
    newline : str
        The first end of a line.
    all_quoted : bool
        Whether all cells of the first row are quoted.
    """

    def __init__(self, data: bytes, encoding: str = "utf-8") -> None:
        self._data = data
        self.encoding = encoding
        self.preamble: list[str] = []
        self._bounded = False
        first = stated = ""
        for _, line in self._lines():
            mark = None if self.preamble else SEP_LINE.fullmatch(line)
            if mark is None and line.strip() and not _COMMENT.match(line):
                first = line
                break
            stated = mark[1] if mark else stated
            self.preamble.append(line)
        content = first.rstrip("\r\n")
        ends = (line[len(line.rstrip("\r\n")) :] for line in (*self.preamble, first))
        self.newline = next(filter(None, ends), "\n")
        self.separator = stated or _separator(content)
        parts = content.split(self.separator) if self.separator else [content]
        self.all_quoted = bool(content) and all(
            len(part) > 1 and part[0] == part[-1] == '"' for part in parts
        )

    def _file(self) -> io.TextIOWrapper:
        return io.TextIOWrapper(io.BytesIO(self._data), encoding=self.encoding, newline="")

    def _lines(self) -> Iterator[tuple[int, str]]:
        return bounded_lines(self._file())

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Yield the rows, the header first, with the line in which each begins, from 1.

        Cells keep their white space and line breaks. Empty lines have no cells. Errors have the
        line.
        """
        if not self._bounded:  # a pass of its own, so that the other passes are fast
            deque(self._lines(), maxlen=0)
            self._bounded = True
        lines = self._file()
        skipped = len(self.preamble)
        for _ in range(skipped):
            next(lines)
        if self.separator == " ":
            for number, line in enumerate(lines, start=skipped + 1):
                yield number, line.split()
            return
        reader = csv.reader(lines, delimiter=self.separator or _NOWHERE, strict=True)
        start = skipped + 1
        try:
            for cells in reader:
                yield start, cells
                start = skipped + reader.line_num + 1
        except csv.Error as error:
            raise MalformedFileError(
                f"The row cannot be split into cells: {error}.",
                where={"line": start},
                remedy="Close every quotation mark, and double those within a cell.",
            ) from None

    def write(self, rows: Iterable[Sequence[str]], separator: str | None = None) -> Iterator[str]:
        """Yield rows as text, in the dialect of the table or with another separator."""
        mark = separator or self.separator or ","
        # csv quotes a cell with a line break only if the break is part of the line's end
        writer = csv.writer(
            _Echo(),
            delimiter=mark,
            quoting=csv.QUOTE_ALL if self.all_quoted else csv.QUOTE_MINIMAL,
            lineterminator="\r\n",
        )
        for cells in rows:
            if cells:
                line: str = writer.writerow(cells)
                yield line.removesuffix("\r\n") + self.newline
            else:
                yield self.newline


class _Echo:
    """A file that returns what is written."""

    def write(self, line: str) -> str:
        return line


def most_frequent_separator(line: str) -> str:
    """Return the separator that is most frequent outside of quotes and brackets; empty for none."""
    bare = re.sub(r'"[^"]*"|\([^()]*\)', '""', line)
    counts = Counter(mark for mark in bare if mark in _SEPARATORS)
    if not counts:
        return ""
    return max(counts, key=lambda mark: (counts[mark], -_SEPARATORS.index(mark)))


def _separator(line: str) -> str:
    """Return the separator of the cells of a header; a space, or nothing, without one."""
    spaces = len(line.split()) > 1 and '"' not in line
    return most_frequent_separator(line) or (" " if spaces else "")


MAX_TEXT_ROWS = 2_000_000
"""Maximum number of rows in a text file. The largest targets have a few ten thousand."""

MAX_LINE_CHARACTERS = 1_000_000
"""Maximum length of a line. All tokens of a line are in memory together."""

MAX_LINES = 2 * MAX_TEXT_ROWS
"""Maximum number of lines, including those between rows."""

MAX_TEXT_VALUES = 8_000_000
"""Maximum number of numbers in a text file: 200,000 spectra of 40 bands."""

_BLOCK = 8192
_BLOCK_TOKENS = 200_000
"""Maximum number of tokens before conversion. A token takes more memory than its number."""

_NUMBER = re.compile(r"[+\-\u2212]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d{1,3})?")


def number(token: str) -> float:
    """Return the number in a token, with a decimal point or comma, and any minus sign.

    A token that is no plain decimal number raises ValueError: ``nan``, ``inf``, ``1_000``, hex.
    """
    if not _NUMBER.fullmatch(token):
        raise ValueError(token)
    return float(token.replace(",", ".").replace("\u2212", "-"))


def is_number(token: str) -> bool:
    """Return whether a token is a plain decimal number; see `number`."""
    return _NUMBER.fullmatch(token) is not None


def text_lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield the numbers of lines, from 1, and the lines, for any mixture of CR, LF and CRLF.

    A line has a line feed at its end where it has an end. See `bounded_lines` for the limits.
    """
    return bounded_lines(io.StringIO(text, newline=None))


def bounded_lines(lines: Iterable[str]) -> Iterator[tuple[int, str]]:
    """Yield lines with their numbers from 1.

    More than `MAX_LINES` lines, and lines longer than `MAX_LINE_CHARACTERS`, are refused.
    """
    for line, content in enumerate(lines, start=1):
        if len(content) > MAX_LINE_CHARACTERS:
            raise MalformedFileError(
                f"The line has {len(content)} characters.",
                where={"line": line},
                remedy=f"Write one sample per line, of at most {MAX_LINE_CHARACTERS} characters.",
            )
        if line > MAX_LINES:
            raise SampleLimitError(
                f"The text has more than {MAX_LINES} lines.",
                where={"line": line},
                remedy="Thin the samples out, or send them as a NumPy .npy file.",
            )
        yield line, content


class NumberTable:
    """Collects the columns ``roles.selected`` of a text table as numbers.

    `count` is the number of rows so far. `labels` maps the measurement conditions in the condition
    column to numbers from 0.
    """

    def __init__(self, roles: ColumnRoles) -> None:
        self.roles = roles
        self.labels: dict[str, int] = {}
        self._selected = roles.selected
        self._block = max(1, min(_BLOCK, _BLOCK_TOKENS // max(1, len(self._selected))))
        self._most = min(MAX_TEXT_ROWS, MAX_TEXT_VALUES // max(1, len(self._selected)))
        self._rows: list[list[str]] = []
        self._row_lines: list[int] = []
        self._blocks: list[FloatArray] = []
        self._lines: list[IntArray] = []
        self.count = 0

    def append(self, tokens: Sequence[str], line: int) -> None:
        """Add a row with as many tokens as there are columns, from a line counted from 1.

        Rows are converted in blocks, so an error of this method or of `arrays` may concern an
        earlier row. Its ``where`` has line, column and column name.
        """
        row = [tokens[column] for column in self._selected]
        if self.roles.condition_column is not None:
            row[-1] = self._condition_number(row[-1], line)
        self._rows.append(row)
        self._row_lines.append(line)
        self.count += 1
        if self.count > self._most:
            raise SampleLimitError(
                f"The table has more than {self._most} rows of {len(self._selected)} numbers.",
                where={"line": line},
                remedy="Thin the samples out, or send them as a NumPy .npy file.",
            )
        if len(self._rows) >= self._block:
            self._convert()

    def arrays(self) -> tuple[FloatArray, IntArray]:
        """Return the numbers (n, c) of the selected columns, and the line (n,) of each row."""
        self._convert()
        if not self._blocks:
            return np.empty((0, len(self.roles.selected))), np.empty(0, dtype=np.int64)
        return np.concatenate(self._blocks), np.concatenate(self._lines)

    @property
    def row_conditions(self) -> tuple[str, ...]:
        """Measurement conditions, by their numbers in the last column."""
        return tuple(self.labels)

    def _condition_number(self, token: str, line: int) -> str:
        label = condition_label(token)
        number = self.labels.setdefault(label, len(self.labels))
        if number >= MAX_ROW_CONDITIONS:
            raise SampleLimitError(
                f"The rows have more than {MAX_ROW_CONDITIONS} measurement conditions.",
                where={"line": line, "field": self.roles.selected_names[-1]},
                remedy="Send the samples of one condition.",
            )
        return str(number)

    def _convert(self) -> None:
        if not self._rows:
            return
        width = len(self.roles.selected)
        try:
            # float() also accepts nan, infinities and underscores. Later checks find the first two.
            flat = [float(token) for token in chain.from_iterable(self._rows)]
            plain = not any("_" in token for token in chain.from_iterable(self._rows))
        except ValueError:
            plain = False
        if not plain:
            flat = self._numbers_one_by_one()
        self._blocks.append(np.array(flat, dtype=np.float64).reshape(-1, width))
        self._lines.append(np.array(self._row_lines, dtype=np.int64))
        self._rows, self._row_lines = [], []

    def _numbers_one_by_one(self) -> list[float]:
        flat = []
        names, columns = self.roles.selected_names, self.roles.selected
        for row, line in zip(self._rows, self._row_lines, strict=True):
            for index, token in enumerate(row):
                try:
                    flat.append(number(token))
                except ValueError:
                    raise MalformedFileError(
                        f"{token[:40]!r} in the column {names[index]} is not a number.",
                        where={
                            "line": line,
                            "column": columns[index] + 1,
                            "field": names[index],
                        },
                        remedy="Write plain decimal numbers, such as 12.5.",
                    ) from None
        return flat


def delimited_samples(text: DelimitedText, *, condition: str | None = None) -> Samples:
    """Return the samples in delimited text.

    Decimal commas are accepted, in quotation marks if the separator is a comma. `condition` is the
    measurement condition to read, if the text has several.
    """
    rows = (
        (line, cells)
        for line, cells in text.rows()
        if any(cell.strip() for cell in cells) and not cells[0].lstrip().startswith("#")
    )
    line, first = next(rows, (1, []))
    if not first:
        raise UnrecognisedFormatError(
            "The file is empty.", remedy="Send an ICC profile, or measurements as CGATS or CSV."
        )
    warnings = []
    names = [cell.strip() for cell in first]
    headless = all(map(is_number, names)) and not are_wavelengths(names)
    if headless:
        if len(names) != 3:
            raise MissingColumnError(
                f"The {len(names)} columns have no names.",
                where={"line": line},
                remedy="Name the columns in the first line, such as RGB_R,RGB_G,RGB_B,XYZ_X,XYZ_Y,"
                "XYZ_Z. Only three columns, L*, a*, b*, may go without names.",
            )
        warnings.append("The columns have no names; L*, a*, b* are assumed.")
        roles = column_roles(("LAB_L", "LAB_A", "LAB_B"))
    else:
        roles = _named_roles(names, line, text.separator, condition)
    table = NumberTable(roles)
    if headless:
        table.append(names, line)
    for line, row in rows:
        cells = [cell.strip() for cell in row]
        while len(cells) > len(names) and not cells[-1]:
            cells.pop()
        if len(cells) != len(names):
            raise MalformedFileError(
                f"The row has {len(cells)} values for {len(names)} columns.",
                where={"line": line, "column": min(len(cells), len(names)) + 1},
                remedy="Every row needs one value for each column.",
            )
        table.append(cells, line)
    values, lines = table.arrays()
    return samples_from_values(
        "csv",
        roles,
        values,
        lines=lines,
        condition=condition,
        row_conditions=table.row_conditions,
        warnings=warnings,
    )


def _named_roles(names: list[str], line: int, separator: str, condition: str | None) -> ColumnRoles:
    try:
        return column_roles(names, condition=condition, where={"line": line})
    except MissingColumnError as error:
        # Prose also splits at spaces and commas. Only a recognised column makes it a table.
        if len(names) >= 3 and (separator.strip() or separator == "\t" or "column" in error.where):
            raise
        raise UnrecognisedFormatError(
            "The text is not a table of samples.",
            where={"line": line},
            remedy="Send an ICC profile, measurements as CGATS text or JSON, or a table whose "
            "first line names its columns, such as LAB_L,LAB_A,LAB_B.",
        ) from None
