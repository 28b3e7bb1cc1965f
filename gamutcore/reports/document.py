"""A report as data: sentences, conditions, tables and charts, and its files.

Every report is a `Report`. It is written as text in 80 columns, CSV, JSON, a workbook, one HTML
page that needs no network, or PDF. matplotlib draws charts, and openpyxl writes workbooks.
"""

from __future__ import annotations

import base64
import csv
import hashlib
import io
import json
import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gamutcore.errors import OptionError
from gamutcore.number_text import fixed_text, number_text
from gamutcore.tables import write_sheets

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

__all__ = [
    "REPORT_SUFFIXES",
    "Chart",
    "Report",
    "ReportColumn",
    "ReportTable",
    "check_report_suffix",
]

REPORT_SUFFIXES = (".csv", ".xlsx", ".json", ".html", ".pdf", ".txt")
"""Suffixes of the files of a report."""

PICTURES = (".png", ".svg")
"""Suffixes of the first chart of a report that has any."""

MOST_ROWS = 40
"""Rows of a table in text."""

FEWEST = 16
"""Least characters that a column of texts is shortened to, so that others fit."""

SHADES = 10
"""Shades of cells, from 0 to 1."""

NO_CHARTS = (
    "The charts are left out, because matplotlib is not installed: "
    "pip install 'gamut-boundary-service[plot]'."
)
"""A page is worth reading without its charts."""

WIDTH = 80
"""Characters of a line of text."""

PAPER = (210 / 25.4, 297 / 25.4)
"""Width and height of a page of PDF, A4, in inches."""

LINES = 68
"""Lines of text on a page of PDF."""


@dataclass(frozen=True)
class ReportColumn:
    """A column of a table.

    `values` are numbers, texts, truth values, or None for an empty cell. Text and pages show
    numbers with `decimals`, other files in full. `heading` takes the place of name and unit there.

    `kind` is empty or one of three. "share" and "heat" are numbers from 0 to 1, shown in per cent;
    pages add a bar to a share, and shade the cell of a heat. "colour" is ``#rrggbb``, a swatch on
    pages.
    """

    name: str
    values: Sequence[Any] | NDArray[Any]
    unit: str = ""
    decimals: int = 2
    kind: str = ""
    heading: str = ""

    @property
    def title(self) -> str:
        """The heading, or the name with the unit."""
        if self.heading:
            return self.heading
        unit = "%" if self.kind == "share" else self.unit
        return f"{self.name} ({unit})" if unit else self.name

    def text(self, value: Any) -> str:  # noqa: ANN401
        """Return a cell as people read it."""
        value = _plain(value)
        if value is None:
            return "–"
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, int | float):
            if self.kind in {"share", "heat"}:
                return fixed_text(100 * value, max(self.decimals - 1, 0))
            return fixed_text(value, self.decimals if isinstance(value, float) else 0)
        return str(value)

    @property
    def is_number(self) -> bool:
        """Whether the cells are numbers."""
        plain = [_plain(value) for value in self.values]
        return any(_is_number(value) for value in plain) and not any(
            isinstance(value, str) for value in plain
        )


@dataclass(frozen=True)
class ReportTable:
    """A table with a title, its columns, and sentences about it."""

    title: str
    columns: Sequence[ReportColumn]
    notes: Sequence[str] = ()

    @property
    def rows(self) -> list[tuple[Any, ...]]:
        """The cells by rows."""
        return list(zip(*(column.values for column in self.columns), strict=True))


@dataclass(frozen=True)
class Chart:
    """A chart: `draw` draws on an empty figure of matplotlib. The title says what one sees."""

    title: str
    draw: Callable[[Figure], None]


@dataclass(frozen=True)
class Report:
    """A report.

    Attributes
    ----------
    title : str
    sentences : sequence of str
        The answer in words, most important first.
    conditions : mapping of str to str
        What the figures hold for: gamuts, intent, white, standard and edition.
    tables : sequence of ReportTable
        CSV has the first one only, unless there are `rows`.
    charts : sequence of Chart
        On pages and in PDF.
    warnings : sequence of str
        Reasons why the answer may mislead.
    data : mapping
        Members of the JSON document besides title, sentences, conditions, warnings and tables.
    rows : ReportTable, optional
        A long table: CSV has it alone, and workbooks have it besides the others.
    """

    title: str
    sentences: Sequence[str]
    conditions: Mapping[str, str] = field(default_factory=dict)
    tables: Sequence[ReportTable] = ()
    charts: Sequence[Chart] = ()
    warnings: Sequence[str] = ()
    data: Mapping[str, Any] = field(default_factory=dict)
    rows: ReportTable | None = None

    def __str__(self) -> str:
        return self.to_text()

    def save(self, path: str | Path) -> None:
        """Write the report in the format of the suffix, one of `REPORT_SUFFIXES`.

        Reports with charts are also written as PNG and SVG, which have the first chart.

        Raises
        ------
        OptionError
            The suffix is another one.
        ModuleNotFoundError
            matplotlib or openpyxl is needed, and not installed.
        """
        path = Path(path)
        suffix = check_report_suffix(path, charts=bool(self.charts))
        if suffix == ".xlsx":
            write_sheets(path, self._sheets())
        elif suffix == ".pdf":
            self._write_pdf(path)
        elif suffix in PICTURES:
            path.write_bytes(_chart_file(self.charts[0], suffix[1:]))
        else:
            text = {
                ".csv": self.to_csv,
                ".json": self.to_json,
                ".html": self.to_html,
                ".txt": self.to_text,
            }[suffix]()
            path.write_text(text, encoding="utf-8", newline="")

    def to_text(self) -> str:
        """Return the report in lines of at most 80 characters.

        Columns that do not fit are left out, and a line says so.
        """
        parts = [textwrap.fill(self.title, WIDTH)]
        parts += [textwrap.fill(sentence, WIDTH) for sentence in self.sentences]
        parts += [textwrap.fill(f"Warning: {warning}", WIDTH) for warning in self.warnings]
        if self.conditions:
            width = max(map(len, self.conditions)) + 2
            parts.append(
                "\n".join(
                    textwrap.fill(
                        value,
                        WIDTH,
                        initial_indent=f"{name:{width}}",
                        subsequent_indent=" " * width,
                    )
                    for name, value in self.conditions.items()
                )
            )
        parts += [_table_text(table) for table in self.tables]
        return "\n\n".join(parts) + "\n"

    def to_csv(self) -> str:
        """Return the long table, or else the first one, as CSV."""
        file = io.StringIO()
        writer = csv.writer(file, lineterminator="\n")
        tables = self.tables if self.rows is None else [self.rows]
        if tables:
            writer.writerow([column.name for column in tables[0].columns])
            writer.writerows([_csv_cell(cell) for cell in row] for row in tables[0].rows)
        return file.getvalue()

    def to_json(self) -> str:
        """Return the document as JSON; tables have a list of columns with name, unit and values."""
        return json.dumps(self.to_dict(), ensure_ascii=False, indent=1, allow_nan=False) + "\n"

    def to_dict(self) -> dict[str, Any]:
        """Return the members of the JSON document."""
        return {
            "title": self.title,
            "sentences": list(self.sentences),
            "warnings": list(self.warnings),
            "conditions": dict(self.conditions),
            **{name: _plain(value) for name, value in self.data.items()},
            "tables": [
                {
                    "title": table.title,
                    "notes": list(table.notes),
                    # a list, as a column may have the name of a gamut, and so that of another one
                    "columns": [
                        {
                            "name": column.name or column.kind,
                            "unit": column.unit,
                            "values": [_plain(value) for value in column.values],
                        }
                        for column in table.columns
                    ],
                }
                for table in self.tables
            ],
        }

    def to_html(self) -> str:
        """Return one page: its tables sort by a click on a heading, and it loads nothing."""
        sentences = "".join(f"<p class='answer'>{escape(text)}</p>" for text in self.sentences)
        warnings = "".join(
            f"<p class='warning'><b>Warning:</b> {escape(text)}</p>" for text in self.warnings
        )
        conditions = "".join(
            f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>"
            for name, value in self.conditions.items()
        )
        drawn = self.charts if find_spec("matplotlib") else ()
        left_out = "" if len(drawn) == len(self.charts) else f"<p class='note'>{NO_CHARTS}</p>"
        charts = left_out + "".join(
            f"<figure><figcaption>{escape(chart.title)}</figcaption>"
            f"<img alt='{escape(chart.title, quote=True)}' src='data:image/svg+xml;base64,"
            f"{base64.b64encode(_chart_file(chart, 'svg')).decode()}'></figure>"
            for chart in drawn
        )
        tables = "".join(_table_html(table) for table in self.tables)
        return (
            f"<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>\n"
            f"<meta name='viewport' content='width=device-width, initial-scale=1'>\n"
            f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
            f"<title>{escape(self.title)}</title>\n<style>{_STYLE}</style></head>\n"
            f"<body><main><h1>{escape(self.title)}</h1>\n{sentences}{warnings}\n"
            f"<dl>{conditions}</dl>\n{charts}\n{tables}</main>\n"
            f"<script>{_SCRIPT}</script></body></html>\n"
        )

    def _repr_html_(self) -> str:
        """Return the report for notebooks, where tables do not sort."""
        head = "".join(f"<p>{escape(text)}</p>" for text in self.sentences)
        return f"<h3>{escape(self.title)}</h3>{head}{''.join(map(_table_html, self.tables))}"

    def _sheets(self) -> dict[str, list[list[Any]]]:
        """Return the rows of the sheets of a workbook: the tables, and what they hold for."""
        tables = [*self.tables, *([] if self.rows is None else [self.rows])]
        sheets = {
            table.title: [
                # Shares are numbers from 0 to 1, so their names have no "%".
                [
                    column.name if column.heading or column.kind == "share" else column.title
                    for column in table.columns
                ],
                *([_plain(cell) for cell in row] for row in table.rows),
            ]
            for table in tables
        }
        about = [[self.title], *([text] for text in (*self.sentences, *self.warnings))]
        about += [list(pair) for pair in self.conditions.items()]
        about += [[f"{table.title}: {note}"] for table in self.tables for note in table.notes]
        return {**sheets, "About": about}

    def _write_pdf(self, path: Path) -> None:
        """Write pages of text in a fixed pitch, then a page for each chart."""
        from matplotlib.backends.backend_pdf import PdfPages  # noqa: PLC0415

        from gamutcore.questions import plot_text  # noqa: PLC0415

        lines = self.to_text().splitlines()
        # without a date, so that the same report has the same bytes
        with PdfPages(path, metadata={"Title": self.title, "CreationDate": None}) as pages:
            for first in range(0, len(lines), LINES):
                page = _new_figure(PAPER)
                text = "\n".join(map(plot_text, lines[first : first + LINES]))
                page.text(0.08, 0.95, text, family="monospace", fontsize=9, va="top")
                pages.savefig(page)
            for chart in self.charts:
                page = _new_figure(PAPER[::-1])
                chart.draw(page)
                page.suptitle(plot_text(chart.title))
                pages.savefig(page)


def check_report_suffix(path: Path, *, charts: bool = False) -> str:
    """Return the suffix of a report in lower case; refuse others before anything is computed."""
    suffix = path.suffix.lower()
    accepted = (*REPORT_SUFFIXES, *PICTURES) if charts else REPORT_SUFFIXES
    if suffix not in accepted:
        names = ", ".join(accepted)
        raise OptionError.refusal("output", path.name, f"a name that ends in one of {names}")
    return suffix


def _new_figure(size: tuple[float, float]) -> Figure:
    from gamutcore.questions import figure  # noqa: PLC0415  # says how to install matplotlib

    empty: Figure = figure()
    empty.set_size_inches(*size)
    return empty


def _chart_file(chart: Chart, form: str) -> bytes:
    page = _new_figure((8, 5))
    chart.draw(page)
    file = io.BytesIO()
    page.savefig(file, format=form, metadata={"Date": None})
    return file.getvalue()


def _table_text(table: ReportTable) -> str:
    """Return a table in lines of at most `WIDTH` characters."""
    cells = [
        [column.title, *map(column.text, column.values[:MOST_ROWS])]
        for column in table.columns
        if column.kind != "colour"
    ]
    numeric = [column.is_number for column in table.columns if column.kind != "colour"]
    widths = [max(map(len, column)) for column in cells]
    excess = sum(widths) + 2 * (len(widths) - 1) - WIDTH
    texts = [at for at, right in enumerate(numeric) if not right]
    for at in sorted(texts, key=lambda at: -widths[at]):  # long names must not hide the figures
        room = max(widths[at] - max(excess, 0), FEWEST, len(cells[at][0]))
        if room < widths[at]:
            cells[at] = [
                cell if len(cell) <= room else f"{cell[: room - 1]}…" for cell in cells[at]
            ]
            excess -= widths[at] - room
            widths[at] = room
    count, total = 0, -2
    while count < len(cells) and total + widths[count] + 2 <= WIDTH:
        total += widths[count] + 2
        count += 1
    lines = [
        "  ".join(
            f"{cell:>{width}}" if right else f"{cell:{width}}"
            for cell, width, right in zip(row, widths[:count], numeric[:count], strict=True)
        ).rstrip()
        for row in zip(*cells[:count], strict=True)
    ]
    left_out = len(cells) - count
    notes = [textwrap.fill(note, WIDTH) for note in table.notes]
    rows_left_out = max((len(column.values) for column in table.columns), default=0) - MOST_ROWS
    if rows_left_out > 0:
        rows = "1 more row" if rows_left_out == 1 else f"{rows_left_out:,} more rows"
        notes.append(f"{rows}; a file such as report.html has all.")
    if left_out:
        columns = "1 more column does" if left_out == 1 else f"{left_out} more columns do"
        notes.append(f"{columns} not fit; write a file with -o.")
    return "\n".join([table.title, *lines, *notes])


def _table_html(table: ReportTable) -> str:
    head = "".join(
        f"<th scope='col' aria-sort='none'><button>{escape(column.title)}</button></th>"
        for column in table.columns
    )
    numeric = [column.is_number for column in table.columns]
    body = "".join(
        "<tr>"
        + "".join(
            _cell_html(column, cell, right)
            for column, cell, right in zip(table.columns, row, numeric, strict=True)
        )
        + "</tr>"
        for row in table.rows
    )
    notes = "".join(f"<p class='note'>{escape(note)}</p>" for note in table.notes)
    return (
        f"<section><h2>{escape(table.title)}</h2><div class='scroll'><table><thead><tr>{head}</tr>"
        f"</thead><tbody>{body}</tbody></table></div>{notes}</section>\n"
    )


def _cell_html(column: ReportColumn, cell: Any, right: bool) -> str:  # noqa: ANN401
    value = _plain(cell)
    key = "" if value is None else str(value)
    shade = f" s{round(SHADES * value)}" if column.kind == "heat" and _is_number(value) else ""
    attributes = f" data-key='{escape(key, quote=True)}'"
    attributes += f" class='number{shade}'" if right else ""
    if column.kind == "colour" and value is not None:
        swatch = f"<rect width='16' height='16' fill='{escape(key, quote=True)}'/>"
        return f"<td{attributes}><svg width='16' height='16'>{swatch}</svg></td>"
    text = escape(column.text(cell))
    if column.kind == "share" and _is_number(value):
        # an attribute of SVG needs no style, which the policy of the page forbids
        width = round(100 * min(max(value, 0.0), 1.0), 1)
        bar = f"<svg class='bar'><rect width='{width}%' height='100%'/></svg>"
        return f"<td{attributes}>{text} {bar}</td>"
    return f"<td{attributes}>{text}</td>"


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _csv_cell(cell: Any) -> str:  # noqa: ANN401
    value = _plain(cell)
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return number_text(value, 12) if isinstance(value, float) else str(value)


def _plain(value: Any) -> Any:  # noqa: ANN401
    """Return a value as JSON has it: lists instead of arrays, and None instead of NaN."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {name: _plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


_STYLE = """
:root { color-scheme: light dark; font: 15px/1.45 system-ui, sans-serif }
main { max-width: 72rem; margin: 0 auto; padding: 1rem 1.25rem 3rem }
h1 { font-size: 1.5rem; margin: .5rem 0 }
h2 { font-size: 1.1rem; margin: 2rem 0 .5rem }
.answer { max-width: 46rem; margin: .3rem 0 }
.answer:first-of-type { font-size: 1.15rem }
.warning { max-width: 46rem; border-left: 3px solid #c60; padding-left: .6rem }
.note { max-width: 46rem; font-size: .9rem; opacity: .8 }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1rem; font-size: .9rem }
dt { font-weight: 600 } dd { margin: 0 }
.scroll { overflow: auto; max-height: 80vh }
table { border-collapse: collapse; font-variant-numeric: tabular-nums }
th { position: sticky; top: 0; background: Canvas; text-align: left; white-space: nowrap }
th button { font: inherit; font-weight: 600; background: none; border: 0; padding: .3rem 0;
  color: inherit; cursor: pointer }
th button::after { content: " ↕"; opacity: .4 }
th[aria-sort=ascending] button::after { content: " ↑"; opacity: 1 }
th[aria-sort=descending] button::after { content: " ↓"; opacity: 1 }
th, td { padding: .2rem .8rem .2rem 0; border-bottom: 1px solid color-mix(in srgb, currentcolor 15%,
  transparent) }
td { white-space: nowrap }
.number { text-align: right }
.bar { width: 3rem; height: .6rem; vertical-align: baseline; fill: #38c;
  background: color-mix(in srgb, currentcolor 12%, transparent) }
figure { margin: 1.5rem 0 } figcaption { font-weight: 600 }
img { max-width: 100%; height: auto; background: #fff }
@media print { .scroll { max-height: none; overflow: visible } th { position: static }
  th button::after { content: none !important } tr, figure { break-inside: avoid } }
""" + "".join(
    f".s{shade} {{ background: color-mix(in srgb, #38c {100 * shade // SHADES}%, transparent) }}\n"
    for shade in range(SHADES + 1)
)

_SCRIPT = """
for (const table of document.querySelectorAll("table")) {
  const heads = [...table.tHead.rows[0].cells], body = table.tBodies[0]
  heads.forEach((head, at) => head.firstChild.addEventListener("click", () => {
    const down = head.getAttribute("aria-sort") === "ascending"
    const keys = new Map([...body.rows].map(row => [row, row.cells[at].dataset.key]))
    const numbers = [...keys.values()].every(key => key === "" || !isNaN(key))
    const order = (a, b) => numbers ? a - b : a.localeCompare(b, undefined, { numeric: true })
    const rows = [...body.rows].sort((a, b) => {
      const [p, q] = [keys.get(a), keys.get(b)]
      return p === "" || q === "" ? (p === "") - (q === "") : (down ? -1 : 1) * order(p, q)
    })
    heads.forEach(other => other.setAttribute("aria-sort", "none"))
    head.setAttribute("aria-sort", down ? "descending" : "ascending")
    body.append(...rows)
  }))
}
"""


def _digest(text: str) -> str:
    """Return the source expression of an inline script or style (CSP level 3, 2.3.1)."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


_POLICY = (
    f"default-src 'none'; script-src {_digest(_SCRIPT)}; style-src {_digest(_STYLE)}; "
    "img-src data:; base-uri 'none'; form-action 'none'"
)
"""Content security policy of the page: it loads nothing."""
