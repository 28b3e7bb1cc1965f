"""Tables of colours from files: the colours, and the cells as they are."""

from __future__ import annotations

import csv
import io
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = ["ColourTable", "read_colours"]

_DELIMITERS = "\t;,"

_NPY_MAGIC = b"\x93NUMPY"


class ColourTable(NamedTuple):
    """Colours with the other columns of their file.

    Attributes
    ----------
    columns : dict of str to list of str
        The cells of each column, as in the file.
    colours : (n, 3) float64
    space : str
        Of the colours: ``CIELAB`` or ``LCHab`` by the names of the columns, or as given.
    """

    columns: dict[str, list[str]]
    colours: FloatArray
    space: str

    def label(self, row: int) -> str:
        """Return the first cell of a row that is no number, or the number of the row."""
        for cells in self.columns.values():
            if cells[row] and _number(cells[row]) is None:
                return cells[row]
        return f"row {row + 1}"


def read_colours(path: str, space: str | None = None, names: str | None = None) -> ColourTable:
    """Read colours from delimited text, or from a .npy file of shape (n, 3).

    Parameters
    ----------
    path : str
        ``-`` is standard input. Text is UTF-8, UTF-16 or Windows-1252. The first line has the names
        of the columns. The delimiter is the first of tab, semicolon and comma in it. Decimal commas
        are accepted unless it is a comma.
    space : str, optional
        Space of the colours. Columns in LCh are recognised by their names; CIELAB otherwise.
    names : str, optional
        Names of the three columns of the colours, separated by commas. They are recognised unless
        given: L, a, b or LAB_L, LAB_A, LAB_B, and so on, or R, G, B for sRGB.

    Returns
    -------
    ColourTable

    Raises
    ------
    MissingColumnError
        There are no columns of colours.
    UnrecognisedFormatError
        The content is a picture, a saved gamut or other binary data.
    MalformedFileError
        A row has too few cells, or a colour that is no number; ``where["line"]`` names it.
    OSError
        The file cannot be read.
    """
    import numpy as np  # noqa: PLC0415  # help needs no arrays

    from gamutcore.errors import MalformedFileError  # noqa: PLC0415

    data = sys.stdin.buffer.read() if path == "-" else Path(path).read_bytes()
    if data.startswith(_NPY_MAGIC):
        return ColourTable({}, _array(data, path), space or "CIELAB")
    text = _text(data, path)
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    first = lines[0] if lines else ""
    delimiter = next((mark for mark in _DELIMITERS if mark in first), ",")
    try:
        rows = list(csv.reader(lines, delimiter=delimiter))
    except csv.Error as error:
        raise MalformedFileError(
            f"The table cannot be split into cells: {error}.",
            where={"file": path},
            remedy="Close every quotation mark.",
        ) from error
    header = [cell.strip() for cell in rows[0]] if rows else []
    places, found = _colour_columns(header, space, names)
    colours = np.empty((len(rows) - 1, 3))
    for number, row in enumerate(rows[1:]):
        cells = [row[place].strip() if place < len(row) else "" for place in places]
        values = [_number(cell) for cell in cells]
        if None in values or len(row) > len(header):
            raise MalformedFileError(
                f"Row {number + 1} has the colour {', '.join(cells)}."
                if len(row) <= len(header)
                else f"Row {number + 1} has {len(row)} cells for {len(header)} columns.",
                where={"row": number + 1},
                remedy="Give three numbers in each row.",
            )
        colours[number] = values
        row.extend([""] * (len(header) - len(row)))
    columns = {name: [row[place] for row in rows[1:]] for place, name in enumerate(header)}
    return ColourTable(columns, colours, found)


def _array(data: bytes, path: str) -> FloatArray:
    import numpy as np  # noqa: PLC0415

    from gamutcore.errors import MalformedFileError  # noqa: PLC0415

    try:
        colours: FloatArray = np.load(io.BytesIO(data), allow_pickle=False)
    except (ValueError, EOFError) as error:
        raise MalformedFileError(
            "The .npy file is damaged, or holds objects.",
            where={"file": path},
            remedy="Save an (n, 3) array of numbers with numpy.save.",
        ) from error
    return colours


def _text(data: bytes, path: str) -> str:
    """Return the text of a table; name what other content is."""
    from gamutcore.characterisation import FORMATS, decoded_text  # noqa: PLC0415
    from gamutcore.characterisation.pictures import picture_format  # noqa: PLC0415
    from gamutcore.content import is_saved_gamut  # noqa: PLC0415
    from gamutcore.errors import UnrecognisedFormatError  # noqa: PLC0415

    if picture_format(data) is not None:
        kind, remedy = "a picture", "Give a CSV or .npy file of colours; gamut map takes pictures."
    elif is_saved_gamut(data):
        kind = "a saved gamut"
        remedy = "Give it as --gamut, and a CSV or .npy file of colours in its place."
    else:
        text = decoded_text(data)
        if text is not None:
            return text
        pictures = ", ".join(each.title for each in FORMATS if each.kind == "picture")
        kind = "binary data of an unknown format"
        remedy = f"Give a CSV or .npy file of colours, or for gamut map a picture: {pictures}."
    raise UnrecognisedFormatError(
        f"The content is {kind}, not a table of colours.", where={"file": path}, remedy=remedy
    )


def _colour_columns(
    header: list[str], space: str | None, names: str | None
) -> tuple[tuple[int, ...], str]:
    """Return the columns of the colours, and their space."""
    from gamutcore.characterisation.columns import column_roles  # noqa: PLC0415
    from gamutcore.errors import MissingColumnError  # noqa: PLC0415

    if names is not None:
        wanted = [name.strip() for name in names.split(",")]
        if len(wanted) != 3 or not set(wanted) <= set(header):
            raise MissingColumnError(
                f"The columns {names} are not three of {', '.join(header)}.",
                where={"field": "columns"},
                remedy="Give three names of columns, such as L,a,b.",
            )
        return tuple(header.index(name) for name in wanted), space or "CIELAB"
    upper = [name.upper() for name in header]
    if (space or "").lower() == "srgb" and {"R", "G", "B"} <= set(upper):
        return tuple(upper.index(name) for name in "RGB"), "sRGB"
    try:
        roles = column_roles([*header, ""])
        if roles.lab is not None:
            return roles.lab, space or "CIELAB"
        if roles.lch is not None:
            return roles.lch, space or "LCHab"
    except MissingColumnError:
        pass
    raise MissingColumnError(
        f"No columns of colours are among {', '.join(header) or 'none'}.",
        where={"field": "columns"},
        remedy="Name three columns L, a, b, or give their names with --columns.",
    )


def _number(cell: str) -> float | None:
    try:
        return float(cell.replace(",", "."))
    except ValueError:
        return None
