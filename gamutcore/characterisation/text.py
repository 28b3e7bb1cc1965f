"""Text of tables: its encoding, its separator, and its rows with the lines of the file.

Spreadsheets and scripts write tables in many dialects. `DelimitedText` recognises the dialect of a
file, so that an answer can be written in the same one.
"""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections import Counter, deque
from typing import TYPE_CHECKING

from gamutcore.characterisation.table import bounded_lines
from gamutcore.errors import MalformedFileError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

__all__ = ["DelimitedText", "decoded_text", "mentions", "text_and_encoding", "text_encoding"]

_BLOCK_BYTES = 2**20

_SEPARATORS = "\t;,|"
"""Separators in the order of preference, where several occur equally often."""

_NOWHERE = "\x1f"
"""The unit separator of ASCII: the separator for `csv` if lines are not to be split."""

_SEP_LINE = re.compile(r'\ufeff?"?sep=(.)"?[\t;,|]*\r?\n?', re.IGNORECASE)
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


def text_and_encoding(data: bytes) -> tuple[str, str] | None:
    """Return a text and the name of its encoding; None if the content is binary."""
    encoding = text_encoding(data)
    return None if encoding is None else (data.decode(encoding), encoding)


def decoded_text(data: bytes) -> str | None:
    r"""Return the text in UTF-8, UTF-16 or Windows-1252; None if the content is binary.

    Examples
    --------
    >>> decoded_text("Grün".encode("cp1252"))
    'Grün'
    """
    found = text_and_encoding(data)
    return None if found is None else found[0]


class DelimitedText:
    """A text table, which is read row by row as often as needed.

    Parameters
    ----------
    data : bytes
    encoding : str
        As `text_and_encoding` finds it.

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
            mark = None if self.preamble else _SEP_LINE.fullmatch(line)
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

        Cells keep their white space and line breaks. Empty lines have no cells.

        Raises
        ------
        MalformedFileError
            A quotation mark is not closed, or a cell is too long; ``where["line"]`` has the line.
        SampleLimitError
            There are too many lines.
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
        sink = _Lines()
        # csv quotes a cell with a line break only if the break is part of the line's end
        writer = csv.writer(
            sink,
            delimiter=mark,
            quoting=csv.QUOTE_ALL if self.all_quoted else csv.QUOTE_MINIMAL,
            lineterminator="\r\n",
        )
        for cells in rows:
            if cells:
                writer.writerow(cells)
                yield sink.line.removesuffix("\r\n") + self.newline
            else:
                yield self.newline


class _Lines:
    """A file that keeps the last line alone."""

    line = ""

    def write(self, line: str) -> None:
        self.line = line


def _separator(line: str) -> str:
    """Return the separator of a header: the most frequent one outside of quotes and brackets."""
    bare = re.sub(r'"[^"]*"|\([^()]*\)', '""', line)
    counts = Counter(mark for mark in bare if mark in _SEPARATORS)
    if counts:
        return max(counts, key=lambda mark: (counts[mark], -_SEPARATORS.index(mark)))
    return " " if len(line.split()) > 1 and '"' not in line else ""
