"""A table of colours: read from the bytes of a file, and written back with an answer.

Workbooks (.xlsx) are written by openpyxl, which is the extra ``excel``.

The text of a table is read twice: for the colours, and for the cells while the answer is written.
The cells of a large table are therefore never in memory all at once.
"""

from __future__ import annotations

import importlib.util
import io
import math
import re
import tokenize
from array import array
from dataclasses import dataclass, replace
from itertools import chain, islice
from operator import itemgetter
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from gamutcore.characterisation import (
    FORMATS,
    DelimitedText,
    Samples,
    mentions,
    read_characterisation,
    text_encoding,
)
from gamutcore.characterisation.cgats import cgats_rows, looks_like_cgats
from gamutcore.characterisation.columns import FEWEST_BANDS, wavelength
from gamutcore.characterisation.cxf import looks_like_xml
from gamutcore.characterisation.icc import looks_like_icc
from gamutcore.characterisation.pictures import picture_format
from gamutcore.characterisation.samples import NPY_MAGIC
from gamutcore.characterisation.text import is_number, number
from gamutcore.colours import measured_colours
from gamutcore.colours.spaces import CIELAB, ColourConversion
from gamutcore.content import is_saved_gamut
from gamutcore.errors import (
    InvalidPointsError,
    MalformedFileError,
    MissingColumnError,
    OptionError,
    SampleLimitError,
    UnrecognisedFormatError,
)
from gamutcore.tables.columns import (
    PALETTE_MAGIC,
    axes_of,
    css_colour,
    find_columns,
    on_full_scale,
    space_named,
    swatches,
    unused_columns,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
    from pathlib import Path

    from gamutcore.arrays import FloatArray
    from gamutcore.errors import Where

__all__ = ["ColourTable", "read_table", "write_sheets", "write_workbook"]

_DAMAGED = (
    *(ValueError, EOFError, TypeError, SyntaxError, KeyError, MemoryError, RecursionError),
    *(OverflowError, tokenize.TokenError),
)
"""What NumPy raises for damaged .npy files."""

_WORKBOOK = b"PK\x03\x04"
_BLOCK = 256
"""Rows whose cells are converted at once. They fit into the cache of a processor: 4096 rows take
twice the time."""

_LONGEST_SHOWN = 40
_MOST_UNUSED = 3
_MARKS = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", " ": "spaces"}


class ColourTable:
    """Colours with the other columns of their file.

    Attributes
    ----------
    inputs : list of (n, 3) float64
        The colours in their space, one array for each colour of a row.
    space : str
    header : list of str
        Names of the columns as in the file; made up for a table without.
    scale : float
        The value of white in the file.
    reading : str
        What was understood, as sentences.
    is_chart : bool
        Whether the colours are the estimates of a chart, relative to its white.
    """

    def __init__(
        self, header: list[str], text: DelimitedText | None, cells: list[list[str]] | None = None
    ) -> None:
        self.header = header
        self.inputs: list[FloatArray] = [np.empty((0, 3))]
        self.space = "CIELAB"
        self.scale = 1.0
        self.reading = ""
        self.decimal = "."
        self.colour_places: tuple[int, ...] = ()
        self.headless = False
        self.is_chart = False
        self._list: _List | None = None
        self._full = 1.0
        self._text = text
        self._cells = cells
        self._lines = array("I")
        self._coloured = bytearray()

    @property
    def points(self) -> FloatArray:
        """The colours (n, 3), for a table of one colour in each row."""
        return self.inputs[0]

    @property
    def encoding(self) -> str:
        """The encoding of the file; UTF-8 for binary files."""
        return "utf-8" if self._text is None else self._text.encoding

    @property
    def without_colour(self) -> int:
        """Number of rows without a colour, empty lines included."""
        return self._coloured.count(0)

    def rows(self) -> Iterator[tuple[list[str], bool]]:
        """Yield the cells of all rows after the header, and whether the row has a colour."""
        width = len(self.header)
        for (_, cells), coloured in zip(self._numbered(), self._coloured, strict=False):
            fits = not cells or len(cells) == width
            yield (
                (cells if fits else [*cells, *[""] * (width - len(cells))][:width]),
                bool(coloured),
            )

    def _numbered(self) -> Iterator[tuple[int, list[str]]]:
        if self._text is None:
            return iter(enumerate(self._cells or [], start=1))
        rows = islice(self._text.rows(), 0 if self.headless else 1, None)
        return rows if self._list is None else map(self._list.numbered, rows)

    def place(self, row: int) -> Where:
        """Return the location of a row that has a colour: its line in the file, or its number."""
        return {"row": row + 1} if self._text is None else {"line": self._lines[row], "row": row}

    @property
    def lines_of_rows(self) -> list[int]:
        """The line in the file of each row that has a colour; without lines, its number from 1."""
        return list(range(1, 1 + len(self.points))) if self._text is None else list(self._lines)

    def label(self, row: int) -> str:
        """Return the first text of a row that has a colour, else its line or number."""
        return next(islice(self.labels(), row, None), "")

    def labels(self) -> Iterator[str]:
        """Yield the label of each row that has a colour; see `label`."""
        known = (cells for cells, coloured in self.rows() if coloured)
        for row, cells in enumerate(known):
            texts = (
                cell
                for at, cell in enumerate(cells)
                if at not in self.colour_places and cell.strip() and not is_number(cell.strip())
            )
            (name, value), *_ = self.place(row).items()
            colour = cells[self.colour_places[0]].strip() if len(self.colour_places) == 1 else ""
            yield next(texts, colour or f"{name} {value}")

    def own_values(self, points: FloatArray) -> FloatArray:
        """Return colours of the table's space in the scale of the table."""
        if self.scale == self._full:
            return points
        factor = np.full(3, self.scale / self._full)
        if self.space == "LCHab":
            factor[2] = 1.0
        values: FloatArray = points * factor
        return values

    def added_names(self, names: Sequence[str]) -> list[str]:
        """Return names for further columns, which differ from those of the table."""
        taken, free_names = set(self.header), []
        for name in names:
            free, at = name, 1
            while free in taken:
                free, at = f"gamut_{name}" if at == 1 else f"gamut_{name}_{at}", at + 1
            taken.add(free)
            free_names.append(free)
        return free_names

    def cell(self, value: Any, digits: int | None = None) -> str:  # noqa: ANN401
        """Return a value as a cell of this table: with its decimal mark, empty for NaN."""
        if hasattr(value, "item"):
            value = value.item()
        if value is None or (isinstance(value, float) and math.isnan(value)):
            return ""
        if isinstance(value, bool):
            return "true" if value else "false"
        if not isinstance(value, float):
            return str(value)
        text = repr(value) if digits is None else f"{value:.{digits}g}"
        return text.replace(".", self.decimal) if self.decimal != "." else text

    def lines(self, rows: Iterator[Sequence[str]], separator: str | None = None) -> Iterator[str]:
        """Yield rows as text in the dialect of the table."""
        text = self._text or DelimitedText(b"")
        return text.write(rows, separator)

    def head(self, added: Sequence[str], separator: str | None = None) -> str:
        """Return the lines before the rows: remarks, ``sep=`` and the names of the columns."""
        remarks = [] if self._text is None else self._text.preamble
        if separator is not None:
            remarks = [line for line in remarks if not line.lower().lstrip('"').startswith("sep=")]
        return "".join([*remarks, *self.lines(iter([[*self.header, *added]]), separator)])

    def with_answer(
        self, columns: Mapping[str, Sequence[Any]], digits: int | None = 6
    ) -> Iterator[list[str]]:
        """Yield the cells of all rows with further cells, which are empty without a colour.

        `columns` has one value for each row that has a colour. `digits` are the significant ones.
        """
        lists = [
            column.tolist() if hasattr(column, "tolist") else column for column in columns.values()
        ]
        answers = zip(*lists, strict=True) if lists else iter([()] * len(self._lines))
        nothing = [""] * len(columns)
        for cells, known in self.rows():
            if known:
                yield [*cells, *(self.cell(value, digits) for value in next(answers))]
            else:
                yield [*cells, *nothing] if cells else []

    def answer_text(
        self, columns: Mapping[str, Sequence[Any]], *, separator: str | None = None
    ) -> str:
        """Return the table with further columns, in its dialect or with another separator."""
        names = self.added_names(list(columns))
        rows = self.with_answer(columns)
        return "".join(chain([self.head(names, separator)], self.lines(rows, separator)))


def read_table(
    data: bytes,
    *,
    space: str | None = None,
    columns: str | None = None,
    scale: float | None = None,
    names: Sequence[str] = ("",),
    own: str | None = None,
    most: int | None = None,
    most_bytes: int | None = None,
) -> ColourTable:
    r"""Read a table of colours, recognised by its content.

    Parameters
    ----------
    data : bytes
        Delimited text with any separator, in UTF-8, UTF-16 or Windows-1252, with decimal points or
        commas; CGATS, CxF, spectra, Adobe swatches (.ase), or a .npy array (n, 3).
    space : str, optional
        Space of the colours. The names of the columns decide without it.
    columns : str, optional
        Names or numbers of the three columns of the colours, or of the one with texts such as
        ``#e4002b``, separated by commas.
    scale : float, optional
        The value of white, such as 1, 100 or 255. The values decide without it.
    names : sequence of str, optional
        Prefixes of the columns, if a row has several colours: ``from`` for ``from_L``.
    own : str, optional
        Space of a gamut, whose coordinates come first. Numbers of lists without names of columns
        are in it.
    most : int, optional
        Largest number of rows.
    most_bytes : int, optional
        Largest file of measurements or swatches, whose cells are in memory all at once.

    Raises
    ------
    MissingColumnError
        There are no columns of colours, or several sets of them.
    InvalidPointsError
        A colour is no number, is outside the scale, or fits several scales.
    MalformedFileError
        The file is damaged, or a row has too many cells.
    SampleLimitError
        There are too many rows.
    UnrecognisedFormatError
        The content is a picture, a profile, a saved gamut or other binary data.

    Examples
    --------
    >>> table = read_table(b"name;h;C;L\nRed;40,5;60;50\n;;;\n")
    >>> table.space, table.points.tolist(), table.without_colour
    ('LCHab', [[50.0, 60.0, 40.5]], 1)
    >>> print(table.answer_text({"inside": [True]}), end="")
    name;h;C;L;inside
    Red;40,5;60;50;true
    ;;;;
    """
    named_space = None if space is None else space_named(space)
    text = _delimited(data, most_bytes)
    table = None
    if text is not None:
        table = _of_text(text, named_space, columns, names, own, scale, most)
    if table is None:
        if most_bytes is not None and len(data) > most_bytes:
            raise SampleLimitError(
                f"The file of measurements or swatches has {len(data)} bytes.",
                where={"limit": most_bytes},
                remedy=f"Send at most {most_bytes} bytes, or the colours as CSV.",
            )
        if data.startswith(NPY_MAGIC):
            table = _of_array(data, named_space or own, scale)
        else:
            table = _of_swatches(data) if data.startswith(PALETTE_MAGIC) else _of_samples(data)
    if most is not None and len(table.points) > most:
        raise _too_many(most)
    return table


def _delimited(data: bytes, most_bytes: int | None) -> DelimitedText | None:
    """Return delimited text; None for measurements, palettes and arrays."""
    if data.startswith((NPY_MAGIC, PALETTE_MAGIC)):
        return None
    encoding = None if picture_format(data) is not None else text_encoding(data)
    if encoding is None or looks_like_icc(data):
        raise _no_table(data)
    if looks_like_xml(data):
        return None
    if mentions(data, encoding, "begin_data"):  # all of the text is decoded only then
        too_long = most_bytes is not None and len(data) > most_bytes
        if too_long or looks_like_cgats(data.decode(encoding)):
            return None
    return DelimitedText(data, encoding)


def _of_text(
    text: DelimitedText,
    space: str | None,
    columns: str | None,
    names: Sequence[str],
    own: str | None,
    scale: float | None,
    most: int | None,
) -> ColourTable | None:
    """Return the table in delimited text; None if its columns are the bands of spectra."""
    line, header = next(text.rows(), (1, []))
    first = [cell.strip() for cell in header]
    if space is None and columns is None and _has_spectra_alone(first):
        return None
    listed = _list_of(text, first) if columns is None and len(names) == 1 else None
    headless = bool(first) and (listed is not None or all(map(is_number, first)))
    if listed is not None:
        space = None if listed.width == 1 else space  # texts say their space
        first = _names_of(listed, first, space or own, line)
    elif headless:
        first = _made_up(first, space or own, columns, line)
    groups = [
        find_columns(
            first, space=space, columns=columns, prefix=name, own=own, where={"line": line}
        )
        for name in (names if len(names) > 1 else [""])
    ]
    if len({group.space for group in groups}) > 1:
        spaces = (f"{name} in {group.space}" for name, group in zip(names, groups, strict=True))
        raise MissingColumnError(
            f"The colours of a row are in several spaces: {', '.join(spaces)}.",
            where={"line": line, "field": "columns"},
            remedy="Give all colours of a row in the same space.",
        )
    table = ColourTable(first if headless else header, text)
    table.headless, table._list = headless, listed  # noqa: SLF001
    table.space = groups[0].space
    table.colour_places = tuple(place for group in groups for place in group.places)
    if any(group.kind == "TEXT" for group in groups):
        table.inputs = [_in_one_space(table, *_Colours(table, first, most).texts())]
        table.reading = _statement(table, [first[place] for place in table.colour_places], text)
        return table
    values = _Colours(table, first, most).numbers()
    for at, group in enumerate(groups):
        titles = [first[place] for place in group.places]
        points, table.scale = on_full_scale(
            group,
            values[:, 3 * at : 3 * at + 3],
            scale,
            titles,
            table.place,
            stated=space is not None
            or columns is not None
            or (group.space == own and not headless),
        )
        values[:, 3 * at : 3 * at + 3] = points
    table._full = 100.0 if groups[0].kind in {"LAB", "LCH"} else 1.0  # noqa: SLF001
    table.scale = table.scale if groups[0].kind else 1.0
    table.inputs = [values[:, 3 * at : 3 * at + 3] for at in range(len(groups))]
    table.reading = _statement(table, [first[place] for place in table.colour_places], text)
    return table


def _statement(table: ColourTable, titles: Sequence[str], text: DelimitedText) -> str:
    scale = f" with white at {table.scale:g}" if table.space in {"sRGB", "CIEXYZ"} else ""
    if table.scale != table._full and not scale:  # noqa: SLF001
        scale = f" with white at {table.scale:g}"
    texts = len(titles) == 1  # such as #e4002b, which have no scale
    if texts:
        scale = ""
    shown = ", ".join(" ".join(title.split())[:_LONGEST_SHOWN] for title in titles)
    columns = f"Column {shown} is" if len(titles) == 1 else f"Columns {shown} are"
    parts = [f"{columns} read as {table.space}{scale}"]
    if table.headless:
        unnamed = "Texts of colours" if texts else "Columns without names"
        parts = [f"{unnamed} are read as {table.space}{scale}"]
    if text.separator not in {",", ""}:
        parts.append(f"separated by {_MARKS.get(text.separator, text.separator)}")
    if table.decimal == ",":
        parts.append("with decimal commas")
    if not text.encoding.startswith("utf-8"):
        encoding = {"cp1252": "Windows-1252", "latin-1": "ISO 8859-1"}.get(text.encoding)
        parts.append(f"in {encoding or 'UTF-16'}")
    others = unused_columns(table.header, table.colour_places)[:_MOST_UNUSED]
    if others and len(table.inputs) == 1:
        shown = "; ".join(" ".join(text.split())[: 3 * _LONGEST_SHOWN] for text in others)
        return ", ".join(parts) + f". Other colours are not used: {shown}."
    return ", ".join(parts) + "."


def _has_spectra_alone(names: Sequence[str]) -> bool:
    if sum(wavelength(name) is not None for name in names) < FEWEST_BANDS:
        return False
    try:
        find_columns(names)
    except MissingColumnError as error:
        return "several" not in error.message
    return False


_FUNCTION_NAME = re.compile(r"(?:rgba?|hsla?|lab|lch|oklab|oklch|color)$", re.IGNORECASE)


def _parted(line: str) -> list[str] | None:
    """Return the name, if there is one, and the colour at the end of a line; None without."""
    text = line.rstrip()
    start = text.rfind("#")
    if text.endswith(")"):
        bracket = text.rfind("(")
        called = _FUNCTION_NAME.search(text[max(bracket - 5, 0) : max(bracket, 0)])
        start = bracket - len(called[0]) if called else -1
    if start < 0 or css_colour(text[start:]) is None:
        return None
    name = text[:start].rstrip(" \t,;|")
    return [name, text[start:]] if name else [text[start:]]


@dataclass(frozen=True)
class _List:
    """Rows of a list: the colour is at the end of a line, and a name before it.

    `width` is the number of cells of the colour: three numbers, or one text. `named` lines have a
    name. Texts contain separators, such as the commas of rgb(), so their lines are joined by
    `separator` first.
    """

    width: int
    named: bool = False
    separator: str = " "

    def numbered(self, row: tuple[int, list[str]]) -> tuple[int, list[str]]:
        """Return a row with one cell for the name, if there are names."""
        line, cells = row
        end = len(cells)
        while end and not cells[end - 1].strip():
            end -= 1
        if self.width == 1 and end and css_colour(cells[end - 1]) is None:
            cells = _parted(self.separator.join(cells[:end])) or cells[:end]
            end = len(cells)
        if not self.named or not end or (end == 1 and cells[0].lstrip().startswith("# ")):
            return line, cells[:end]
        start = max(end - self.width, 0)
        return line, [" ".join(map(str.strip, cells[:start])).strip(), *cells[start:end]]


def _list_of(text: DelimitedText, first: list[str]) -> _List | None:
    """Return how the rows of a list are split; None if the first row has no colour at its end."""
    cells = first
    while cells and not cells[-1]:
        cells = cells[:-1]
    if len(cells) > 3 and all(map(is_number, cells)):
        return None  # perhaps amounts of ink
    if len(cells) > 2 and all(map(is_number, cells[-3:])):
        layout = _List(3)
    elif cells and text.separator != " " and css_colour(cells[-1]):
        layout = _List(1, separator=text.separator)
    elif _parted((text.separator or " ").join(cells)):
        layout, text.separator = _List(1), ""
    else:
        return None
    named = any(len(layout.numbered(row)[1]) > layout.width for row in text.rows())
    return replace(layout, named=named)


def _names_of(listed: _List, cells: list[str], space: str | None, line: int) -> list[str]:
    """Return names for the columns of a list."""
    names = ["name"] if listed.named else []
    if listed.width == 1:
        return [*names, "hex"]
    return [*names, *(axes_of(space) if space is not None else _made_up(cells, None, None, line))]


def _made_up(cells: list[str], space: str | None, columns: str | None, line: int) -> list[str]:
    """Return names for the columns of a table without a header."""
    if columns is not None or (space is not None and len(cells) == 3):
        axes = axes_of(space) if space is not None and len(cells) == 3 else None
        return list(axes or (f"column {at + 1}" for at in range(len(cells))))
    raise MissingColumnError(
        f"The first line, {', '.join(cells)[:100]}, has numbers and no names of columns.",
        where={"line": line, "field": "columns"},
        remedy="Name the columns in the first line: L,a,b, L,C,h, X,Y,Z or R,G,B. Or name their "
        "space and numbers, such as --colours-in CIELAB --columns 1,2,3.",
    )


T = TypeVar("T")


class _Colours:
    """Reader of the columns of colours of a text, in blocks of rows."""

    def __init__(self, table: ColourTable, titles: Sequence[str], most: int | None) -> None:
        self._table = table
        self._titles = titles
        self._most = most
        self._places = table.colour_places
        self._end = 0
        self._comma: int | None = None
        self._point: int | None = None

    def _rows(self) -> Iterator[list[tuple[int, list[str]]]]:
        """Yield blocks of rows, which the caller notes by their lines."""
        lines, coloured = self._table._lines, self._table._coloured  # noqa: SLF001
        rows = self._table._numbered()  # noqa: SLF001
        while block := list(islice(rows, _BLOCK)):
            yield block
            if self._most is not None and len(lines) > self._most:
                raise _too_many(self._most)
        del coloured[self._end :]  # empty lines at the end are no rows

    def numbers(self) -> FloatArray:
        """Return the numbers (n, c) of the rows with a colour."""
        lines, coloured = self._table._lines, self._table._coloured  # noqa: SLF001
        blocks = [np.empty((0, len(self._places)))]
        for block in self._rows():
            values = self._plain([cells for _, cells in block], len(lines))
            if values is None:
                numbers = self._one_by_one(block, self._number)
                values = np.array(numbers, np.float64).reshape(-1, len(self._places))
            else:
                lines.extend(line for line, _ in block)
                coloured.extend(b"\1" * len(block))
                self._end = len(coloured)
            if self._comma is not None and self._point is not None:
                raise InvalidPointsError(
                    "The table has decimal points and decimal commas.",
                    where=self._table.place(max(self._comma, self._point)),
                    remedy="Write all numbers with the same decimal mark, and none of thousands.",
                )
            blocks.append(values)
        if self._comma is not None:
            self._table.decimal = ","
        return np.concatenate(blocks)

    def texts(self) -> tuple[list[str], FloatArray]:
        """Return the spaces and coordinates (n, 3) of a column of texts such as #e4002b."""
        colours = [
            colour for block in self._rows() for (colour,) in self._one_by_one(block, self._text)
        ]
        values = np.array([values for _, values in colours]).reshape(-1, 3)
        return [space for space, _ in colours], values

    def _plain(self, cells: Sequence[list[str]], start: int) -> FloatArray | None:
        """Return the numbers of rows that all have a colour and a usual form; None for others."""
        if set(map(len, cells)) != {len(self._titles)}:
            return None
        picked = list(map(itemgetter(*self._places), cells))
        if not all(map(all, picked)):
            return None
        joined = "\0".join(chain.from_iterable(picked))
        has_point, has_comma = "." in joined, "," in joined
        if "_" in joined or (has_point and has_comma):
            return None
        try:
            values = np.array(list(map(float, joined.replace(",", ".").split("\0"))))
        except ValueError:
            return None
        if not np.isfinite(values).all():
            return None
        self._note(start, point=has_point, comma=has_comma)
        return values.reshape(len(cells), -1)

    def _note(self, row: int, *, point: bool, comma: bool) -> None:
        """Keep the first row, or about that, with a decimal mark."""
        if point and self._point is None:
            self._point = row
        if comma and self._comma is None:
            self._comma = row

    def _one_by_one(
        self, block: Sequence[tuple[int, list[str]]], convert: Callable[[str, int, int, int], T]
    ) -> list[list[T]]:
        """Return the converted cells of rows with a colour, and note all rows."""
        lines, coloured = self._table._lines, self._table._coloured  # noqa: SLF001
        width, last, rows = len(self._titles), max(self._places), []
        for line, cells in block:
            row = len(lines)
            if len(cells) != width:
                cells = _fitted(cells, width, last, line, row)  # noqa: PLW2901
            picked = [cells[place] for place in self._places] if cells else []
            known = bool("".join(picked).strip()) and not (len(picked) > 1 and _is_remark(cells))
            coloured.append(known)
            self._end = len(coloured) if cells else self._end
            if known:
                lines.append(line)
                rows.append([convert(cell, line, row, at) for at, cell in enumerate(picked)])
        return rows

    def _number(self, cell: str, line: int, row: int, at: int) -> float:
        stripped = cell.strip()
        try:
            value = number(stripped)
        except ValueError:
            title = self._titles[self._places[at]][:_LONGEST_SHOWN]
            raise InvalidPointsError(
                f"{cell[:_LONGEST_SHOWN]!r} in the column {title} is not a number.",
                where={"line": line, "row": row, "field": title},
                remedy="Give three numbers for each colour, or leave all three cells empty.",
            ) from None
        self._note(row, point="." in stripped, comma="," in stripped)
        return value

    def _text(
        self, cell: str, line: int, row: int, at: int
    ) -> tuple[str, tuple[float, float, float]]:
        text, title = cell.strip(), self._titles[self._places[at]]
        colour = css_colour(text, bare_hex=True)
        if colour is None:
            raise InvalidPointsError(
                f"{text[:_LONGEST_SHOWN]!r} in the column {title} is not a colour.",
                where={"line": line, "row": row, "field": title},
                remedy="Give colours as #e4002b, rgb(), hsl(), lab(), lch(), oklab() or oklch().",
            )
        return colour


def _fitted(cells: list[str], width: int, last: int, line: int, row: int) -> list[str]:
    """Return the cells of a row as many as there are columns."""
    extra = [cell for cell in cells[width:] if cell.strip()]
    short = len(cells) <= last and any(cell.strip() for cell in cells)
    if extra or (short and not _is_remark(cells)):
        count = "one cell" if len(cells) == 1 else f"{len(cells)} cells"
        raise MalformedFileError(
            f"The row has {count} for {width} columns.",
            where={"line": line, "row": row},
            remedy="Give one cell for each column. Quote cells that contain the separator.",
        )
    return [*cells, *[""] * (width - len(cells))][:width] if cells else cells


def _is_remark(cells: Sequence[str]) -> bool:
    """Return whether a row is a line of remarks: it has one cell, which starts with #."""
    return (
        len(cells) > 0
        and cells[0].lstrip().startswith("#")
        and not any(cell.strip() for cell in cells[1:])
    )


def _too_many(most: int) -> SampleLimitError:
    return SampleLimitError(
        f"There are more than {most} rows.",
        where={"limit": most},
        remedy=f"Send at most {most} rows at once.",
    )


def _in_one_space(table: ColourTable, spaces: Sequence[str], values: FloatArray) -> FloatArray:
    """Set the space of a table, and return its colours in it: CIELAB if they are in several."""
    kinds = sorted(set(spaces))
    if len(kinds) <= 1:
        table.space = kinds[0] if kinds else table.space
        return values
    table.space = "CIELAB"
    points = values.copy()
    for kind in kinds:
        rows = np.array([name == kind for name in spaces])
        points[rows] = ColourConversion(kind, CIELAB).to_gamut(values[rows])
    return points


def _of_array(data: bytes, space: str | None, scale: float | None) -> ColourTable:
    try:
        array = np.load(io.BytesIO(data), allow_pickle=False)
    except _DAMAGED as error:
        raise MalformedFileError(
            "The .npy file is damaged, or holds objects.",
            remedy="Save an (n, 3) array of numbers with numpy.save.",
        ) from error
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "fiu":
        raise InvalidPointsError(
            f"The array has the shape {array.shape} and the type {array.dtype}.",
            remedy="Save an (n, 3) array of numbers with numpy.save.",
        )
    finite = np.isfinite(array).all(axis=1)
    if not finite.all():
        row = int(np.argmin(finite))
        raise InvalidPointsError(
            f"Row {row} of the array is {array[row].tolist()}.",
            where={"row": row},
            remedy="Give finite numbers.",
        )
    if scale is not None:
        raise OptionError.not_applicable("scale", scale, "an array has the scale of its space")
    values = np.ascontiguousarray(array, np.float64)
    chosen = space or "CIELAB"
    table = _of_cells(list(axes_of(chosen)), values, chosen)
    table.reading = f"The columns of the array are read as {chosen}."
    return table


def _of_cells(
    header: list[str],
    points: FloatArray,
    space: str,
    cells: list[list[str]] | None = None,
) -> ColourTable:
    """Return a table that is no delimited text, with the colours as cells by default."""
    table = ColourTable(header, None, cells)
    if cells is None:
        table._cells = [[f"{value:.10g}" for value in row] for row in points.tolist()]  # noqa: SLF001
    table.inputs, table.space = [points], space
    table._coloured = bytearray(b"\1" * len(points))  # noqa: SLF001
    return table


_MODELS = {"RGB": "sRGB", "LAB": "CIELAB", "Gray": "sRGB"}


def _of_swatches(data: bytes) -> ColourTable:
    """Return the colours of a palette: L*a*b*, and RGB and grays as sRGB."""
    palette = swatches(data)
    for row, swatch in enumerate(palette, start=1):
        if swatch.model not in _MODELS:
            raise MissingColumnError(
                f"The swatch {swatch.name[:_LONGEST_SHOWN]!r} is CMYK: amounts of ink, which are "
                "colours of one press only.",
                where={"row": row, "field": swatch.name[:_LONGEST_SHOWN]},
                remedy="Convert the swatches to Lab, and export them again.",
            )
    values = np.array(
        [
            (100.0 * swatch.values[0], *swatch.values[1:])
            if swatch.model == "LAB"
            else (swatch.values * 3)[:3]
            for swatch in palette
        ]
    ).reshape(-1, 3)
    if not np.isfinite(values).all():
        raise MalformedFileError(
            "The palette has a colour that is not finite.", remedy="Export the swatches again."
        )
    cells = [
        [swatch.name, swatch.group, swatch.model, *(f"{value:.6g}" for value in swatch.values)]
        + [""] * (3 - len(swatch.values))
        for swatch in palette
    ]
    header = ["name", "group", "model", "value_1", "value_2", "value_3"]
    table = _of_cells(header, values, "CIELAB", cells)
    spaces = [_MODELS[swatch.model] for swatch in palette]
    table.inputs = [_in_one_space(table, spaces, values)]
    models = ", ".join(sorted({swatch.model for swatch in palette}))
    table.reading = f"Adobe swatches ({models}) are read as {table.space}; RGB and grays are sRGB."
    return table


def _of_samples(data: bytes) -> ColourTable:
    """Return the colours of measurements as measured, in CIELAB with D50.

    The estimates of a chart are relative to the white of the chart, because no paper is known.
    """
    samples = read_characterisation(data, estimates=True)
    if not isinstance(samples, Samples):
        raise _no_table(data)
    chart = samples.provenance.get("chart")
    try:
        colours = measured_colours(samples, "relative" if chart else "absolute")
    except OptionError:
        colours = measured_colours(samples, "relative")
    points = np.ascontiguousarray(colours.lab, np.float64)
    header: list[str] = []
    cells: list[list[str]] | None = None
    encoding = text_encoding(data)
    text = "" if encoding is None else data.decode(encoding)
    if looks_like_cgats(text):
        header, cells = cgats_rows(text)
    elif encoding is not None and not looks_like_xml(data):
        lines = DelimitedText(data, encoding).rows()
        rows = [cells for _, cells in lines if any(cell.strip() for cell in cells)]
        header, cells = rows[0], [row[: len(rows[0])] for row in rows[1:]]
    if cells is None or len(cells) != len(points):
        device = samples.device if samples.device is not None else np.empty((len(points), 0))
        values = np.hstack([100.0 * device, points])
        header = [*samples.channels, "L*", "a*", "b*"]
        cells = [[f"{value:.6g}" for value in row] for row in values.tolist()]
    table = _of_cells(header, points, "CIELAB", cells)
    kinds = ", ".join(map(str, samples.provenance["colour_columns"]))  # type: ignore[arg-type]
    reading = f"{kinds} of {samples.format} data is read as CIELAB (D50)."
    if chart:
        reading = (
            f"{kinds} of a chart ({chart}), which are estimates and not measured, is read as "
            "CIELAB (D50) relative to the white of the chart."
        )
    table.is_chart = bool(chart)
    table.reading = " ".join([reading, *colours.warnings])
    return table


def _no_table(data: bytes) -> UnrecognisedFormatError:
    """Return the error for other content, which it names."""
    if picture_format(data) is not None:
        kind, remedy = "a picture", "Give a CSV or .npy file of colours; gamut map takes pictures."
    elif is_saved_gamut(data):
        kind = "a saved gamut"
        remedy = "Give it as --gamut, and a CSV or .npy file of colours in its place."
    elif looks_like_icc(data):
        kind = "an ICC profile"
        remedy = "Give it as --gamut, and a CSV or .npy file of colours in its place."
    elif data.startswith(_WORKBOOK):
        kind, remedy = "a workbook or an archive", "Save the sheet as CSV."
    else:
        pictures = ", ".join(form.title for form in FORMATS if form.kind == "picture")
        kind = "binary data of an unknown format"
        remedy = f"Give a CSV or .npy file of colours, or for gamut map a picture: {pictures}."
    return UnrecognisedFormatError(f"The content is {kind}, not a table of colours.", remedy=remedy)


_CONTROLS = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f]")
"""Characters that XML 1.0, 2.2, does not have."""

_LONGEST_CELL = 32_767
"""Characters of a cell, by Excel's specifications."""

_SHEET_TITLE = re.compile(r"[\\/*?:\[\]]")
"""Characters that Excel does not accept in the title of a sheet."""

_LONGEST_TITLE = 31
"""Characters of the title of a sheet, by Excel's specifications."""


def write_workbook(table: ColourTable, columns: Mapping[str, Sequence[Any]], path: Path) -> None:
    """Write a table with further columns as a workbook of one sheet.

    The colours of the table and the added numbers are numbers. Other cells are texts, also if they
    look like numbers or formulas.

    Raises
    ------
    ModuleNotFoundError
        openpyxl is not installed.
    """
    numbers = set(table.colour_places)
    answers = zip(*columns.values(), strict=True) if columns else iter(())
    rows: list[list[Any]] = [[*table.header, *table.added_names(list(columns))]]
    for cells, known in table.rows():
        row: list[Any] = [
            _cell_number(cell) if known and at in numbers else (cell or None)
            for at, cell in enumerate(cells)
        ]
        if known:
            row += [_plain(value) for value in next(answers)]
        rows.append(row)
    write_sheets(path, {"colours": rows})


def write_sheets(path: Path, sheets: Mapping[str, Sequence[Sequence[Any]]]) -> None:
    """Write rows of cells as a workbook, a sheet for each title. Texts are never formulas.

    Raises
    ------
    ModuleNotFoundError
        openpyxl is not installed.
    """
    if importlib.util.find_spec("openpyxl") is None:
        raise ModuleNotFoundError(
            "Workbooks need openpyxl, which is not installed. Install it with "
            "pip install 'gamut-boundary-service[excel]', or write a .csv file.",
            name="openpyxl",
        )
    from openpyxl import Workbook  # noqa: PLC0415
    from openpyxl.cell import WriteOnlyCell  # noqa: PLC0415

    book = Workbook(write_only=True)
    for title, rows in sheets.items():
        sheet = book.create_sheet(_sheet_title(title, {name.lower() for name in book.sheetnames}))
        for row in rows:
            cells = []
            for value in row:
                cell = WriteOnlyCell(sheet, value=None if isinstance(value, str) else value)
                if isinstance(value, str):
                    cell.value = _CONTROLS.sub("", value)[:_LONGEST_CELL]
                    cell.data_type = "s"
                cells.append(cell)
            sheet.append(cells)
    book.save(path)


def _sheet_title(title: str, titles: Collection[str]) -> str:
    """Return a title that Excel accepts and that is none of the lower-case titles."""
    plain = _SHEET_TITLE.sub(" ", title).strip().strip("'") or "table"
    sheet_title, number = plain[:_LONGEST_TITLE].strip(), 1
    while sheet_title.lower() in titles:
        number += 1
        end = f" ({number})"
        sheet_title = plain[: _LONGEST_TITLE - len(end)].strip() + end
    return sheet_title


def _cell_number(cell: str) -> float | str:
    try:
        return number(cell.strip())
    except ValueError:
        return cell


def _plain(value: Any) -> Any:  # noqa: ANN401
    value = value.item() if hasattr(value, "item") else value
    return None if value != value else value  # noqa: PLR0124  # NaN is unequal to itself
