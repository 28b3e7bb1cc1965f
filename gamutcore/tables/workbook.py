"""Answers as workbooks (.xlsx), by openpyxl, which is the extra ``excel``."""

from __future__ import annotations

import importlib.util
import re
from typing import TYPE_CHECKING, Any

from gamutcore.characterisation.text import number

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from gamutcore.tables.table import ColourTable

__all__ = ["write_workbook"]

_CONTROLS = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f]")
"""Characters that XML 1.0, 2.2, does not have."""

_LONGEST = 32_767
"""Characters of a cell, by Excel's specifications."""


def write_workbook(table: ColourTable, columns: Mapping[str, Sequence[Any]], path: Path) -> None:
    """Write a table with further columns as a workbook of one sheet.

    The colours of the table and the added numbers are numbers. Other cells are texts, also if they
    look like numbers or formulas.

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
    sheet = book.create_sheet("colours")

    def text(value: str) -> Any:  # noqa: ANN401  # openpyxl has no types
        cell = WriteOnlyCell(sheet, value=None)
        cell.value = _CONTROLS.sub("", value)[:_LONGEST]
        cell.data_type = "s"
        return cell

    sheet.append([text(name) for name in (*table.header, *table.added_names(list(columns)))])
    numbers = set(table.colour_places)
    answers = zip(*columns.values(), strict=True) if columns else iter(())
    for cells, known in table.rows():
        row = [
            _number(cell) if known and at in numbers else (text(cell) if cell else None)
            for at, cell in enumerate(cells)
        ]
        if known:
            row += [_plain(value) for value in next(answers)]
        sheet.append([text(each) if isinstance(each, str) else each for each in row])
    book.save(path)


def _number(cell: str) -> float | str:
    try:
        return number(cell.strip())
    except ValueError:
        return cell


def _plain(value: Any) -> Any:  # noqa: ANN401
    value = value.item() if hasattr(value, "item") else value
    return None if value != value else value  # noqa: PLR0124  # NaN is unequal to itself
