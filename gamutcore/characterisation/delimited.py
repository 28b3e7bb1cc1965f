"""Text separated by commas, semicolons, tabs or spaces, with column names in the first line.

Spreadsheets and scripts write such files. Empty lines and lines that start with `#` are skipped.
Three columns without names are L*, a*, b*.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from gamutcore.characterisation.columns import column_roles
from gamutcore.characterisation.samples import samples_from_values
from gamutcore.characterisation.spectra import are_wavelengths
from gamutcore.characterisation.table import NumberTable, number
from gamutcore.errors import MalformedFileError, MissingColumnError, UnrecognisedFormatError

if TYPE_CHECKING:
    from gamutcore.characterisation.columns import ColumnRoles
    from gamutcore.characterisation.samples import Samples
    from gamutcore.characterisation.text import DelimitedText

__all__ = ["delimited_samples"]


def delimited_samples(text: DelimitedText, *, condition: str | None = None) -> Samples:
    """Return the samples in delimited text.

    Parameters
    ----------
    text : DelimitedText
        Decimal commas are accepted, in quotation marks if the separator is a comma.
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


def _is_number(cell: str) -> bool:
    try:
        number(cell)
    except ValueError:
        return False
    return True


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
