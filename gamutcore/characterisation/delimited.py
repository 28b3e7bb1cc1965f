"""Text separated by commas, semicolons, tabs or spaces, with column names in the first line.

Spreadsheets and scripts write such files. Empty lines and lines that start with `#` are skipped.
Three columns without names are L*, a*, b*.
"""

from __future__ import annotations

import csv
from typing import TYPE_CHECKING

from gamutcore.characterisation.columns import column_roles
from gamutcore.characterisation.samples import samples_from_values
from gamutcore.characterisation.spectra import are_wavelengths
from gamutcore.characterisation.table import NumberTable, number, text_lines
from gamutcore.errors import MalformedFileError, MissingColumnError, UnrecognisedFormatError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from gamutcore.characterisation.columns import ColumnRoles
    from gamutcore.characterisation.samples import Samples

__all__ = ["delimited_samples"]

_DELIMITERS = ("\t", ";", ",")


def delimited_samples(text: str, *, condition: str | None = None) -> Samples:
    """Return the samples in delimited text.

    Parameters
    ----------
    text : str
        The decoded file. The delimiter is the first of tab, semicolon and comma in the first line,
        else white space. Decimal commas are accepted unless the delimiter is a comma.
    condition : str, optional
        The measurement condition to read, if the text has several.

    Raises
    ------
    UnrecognisedFormatError
        The first line is neither column names nor numbers.
    MissingColumnError
        The columns have no colour and no spectrum.
    ConditionError
        The samples have several measurement conditions and none was chosen, or not the chosen one.
    MalformedFileError
        A row has too many or too few values, or a value is not a number.
    """
    delimiter = _delimiter(text)
    rows = _rows(text, delimiter)
    line, first = next(rows, (1, []))
    if not first:
        raise UnrecognisedFormatError(
            "The file is empty.", remedy="Send an ICC profile, or measurements as CGATS or CSV."
        )
    warnings = []
    names = [cell.strip() for cell in first]
    headless = all(_is_number(cell) for cell in names) and not are_wavelengths(names)
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
        roles = _named_roles(names, line, delimiter, condition)
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


def _is_number(cell: str) -> bool:
    try:
        number(cell)
    except ValueError:
        return False
    return True


def _named_roles(
    names: list[str], line: int, delimiter: str | None, condition: str | None
) -> ColumnRoles:
    try:
        return column_roles(names, condition=condition, where={"line": line})
    except MissingColumnError as error:
        # Prose also splits at spaces and commas. Only a recognised column makes it a table.
        if len(names) >= 3 and (delimiter is not None or "column" in error.where):
            raise
        raise UnrecognisedFormatError(
            "The text is not a table of samples.",
            where={"line": line},
            remedy="Send an ICC profile, measurements as CGATS text or JSON, or a table whose "
            "first line names its columns, such as LAB_L,LAB_A,LAB_B.",
        ) from None


def _delimiter(text: str) -> str | None:
    for _, content in text_lines(text):
        if content.strip() and not content.lstrip().startswith("#"):
            return next((mark for mark in _DELIMITERS if mark in content), None)
    return None


def _rows(text: str, delimiter: str | None) -> Iterator[tuple[int, list[str]]]:
    for line, content in text_lines(text):
        if not content.strip() or content.lstrip().startswith("#"):
            continue
        if delimiter is None:
            yield line, content.split()
            continue
        try:
            # One line at a time: an unclosed quotation mark must not include the rest of the file.
            yield line, next(csv.reader((content,), delimiter=delimiter))
        except csv.Error as error:
            raise MalformedFileError(
                f"The line cannot be split into cells: {error}.",
                where={"line": line},
                remedy="Close every quotation mark on its own line.",
            ) from None
