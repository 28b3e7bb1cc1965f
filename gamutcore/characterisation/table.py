"""Conversion of rows of text tokens to numbers, in blocks.

The readers of CGATS and CSV use it. Only needed columns are converted. The line of each row is kept
for errors. Memory is proportional to the numbers, not to the text.
"""

from __future__ import annotations

import io
import re
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.conditions import condition_label
from gamutcore.characterisation.samples import IntArray
from gamutcore.errors import MalformedFileError, SampleLimitError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.columns import ColumnRoles

__all__ = ["MAX_TEXT_ROWS", "NumberTable", "bounded_lines", "number", "text_lines"]

MAX_TEXT_ROWS = 2_000_000
"""Maximum number of rows in a text file. The largest targets have a few ten thousand."""

MAX_LINE_CHARACTERS = 1_000_000
"""Maximum length of a line. All tokens of a line are in memory together."""

MAX_LINES = 2 * MAX_TEXT_ROWS
"""Maximum number of lines, including those between rows."""

MAX_TEXT_VALUES = 8_000_000
"""Maximum number of numbers in a text file: 200,000 spectra of 40 bands."""

MAX_ROW_CONDITIONS = 50

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
