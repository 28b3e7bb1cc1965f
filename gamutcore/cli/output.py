"""Results as text, JSON or CSV, on standard output or in a file."""

from __future__ import annotations

import csv
import io
import json
import math
import sys
import textwrap
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from gamutcore.number_text import fixed_text, number_text

if TYPE_CHECKING:
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.reports import Report
    from gamutcore.results import Conditions, Interval
    from gamutcore.tables import ColourTable

__all__ = [
    "DIAGRAMS",
    "DIAGRAM_NAMES",
    "DRAWINGS",
    "INTERVAL_HEADINGS",
    "AsCsv",
    "AsJson",
    "Columns",
    "Output",
    "answer_form",
    "check_answer_form",
    "coordinate_text",
    "drawing_axes",
    "interval_row",
    "percent_text",
    "shortened",
    "state",
    "tell",
    "wrapped",
    "write_answer",
    "write_bytes",
    "write_drawing",
    "write_facts",
    "write_figures",
    "write_report",
    "write_rows",
    "write_table",
]

DIAGRAM_NAMES = {"xy": "chromaticity xy", "uv": "chromaticity u'v'"}
"""Names of the chromaticity diagrams in CSV and JSON."""

DIAGRAMS = {"xy": "xy", "uv": "u′v′"}
"""Names of the chromaticity diagrams in text."""

AsJson = Annotated[bool, typer.Option("--json", help="Write JSON.")]
AsCsv = Annotated[bool, typer.Option("--csv", help="Write CSV.")]
Output = Annotated[
    Path | None,
    typer.Option("--output", "-o", metavar="FILE", help="Write to this file."),
]

DRAWINGS = (".png", ".svg", ".pdf")
"""Suffixes of drawings by matplotlib."""

Columns: TypeAlias = Mapping[str, Any]
"""A table: values of each column, in the order of the rows. None is an empty cell."""


def write_facts(
    facts: Mapping[str, Any], output: Path | None, *, as_json: bool, as_csv: bool = False
) -> None:
    """Write names and values: aligned text, a JSON object, or CSV of one row.

    Without an output they go to standard output. The suffix of a file chooses the form if no form
    is asked for.
    """
    form = answer_form(output, as_json=as_json, as_csv=as_csv)
    if form == "json":
        text = json.dumps(facts, ensure_ascii=False, indent=2) + "\n"
    elif form == "csv":
        text = _csv({name: [value] for name, value in facts.items()})
    else:
        write_rows([(name, _text(value)) for name, value in facts.items()], output)
        return
    write_bytes(text.encode(), output)


LINE = 80
"""Columns of a terminal."""

LONGEST_NAME = 24
"""Characters of the name of a gamut as a heading."""


def wrapped(*sentences: str) -> str:
    """Return sentences as paragraphs of lines that fit a terminal."""
    return "".join(
        textwrap.fill(text, LINE, break_long_words=False, break_on_hyphens=False) + "\n"
        for text in sentences
    )


def tell(text: str, *, err: bool = True) -> None:
    """Write a line beside the result: in lines that fit a terminal, else as one for programs."""
    is_terminal = (sys.stderr if err else sys.stdout).isatty()
    typer.echo(wrapped(*text.splitlines()).rstrip("\n") if is_terminal else text, err=err)


def write_rows(rows: Sequence[tuple[str, str]], output: Path | None) -> None:
    """Write names and texts in two columns, in lines that fit a terminal."""
    width = max((len(name) for name, _ in rows), default=0) + 2
    text = "".join(
        textwrap.fill(
            text,
            LINE,
            initial_indent=f"{name:{width}}",
            subsequent_indent=" " * width,
            break_long_words=False,
            break_on_hyphens=False,
        ).rstrip()
        + "\n"
        for name, text in rows
    )
    write_bytes(text.encode(), output)


def write_figures(
    sentences: Sequence[str],
    headings: Sequence[str],
    rows: Mapping[str, Sequence[str]],
    output: Path | None,
    notes: Sequence[str] = (),
) -> None:
    """Write an answer: sentences, a small table with a label before each row, and notes."""
    names = [shortened(name) for name in headings]
    columns = zip(names, zip(*rows.values(), strict=True), strict=True)
    cells = [["", *rows], *([name, *column] for name, column in columns)]
    table = _aligned(cells, [False, *([True] * len(names))])
    parts = [wrapped(*sentences), table, *([wrapped(*notes)] if notes else [])]
    write_bytes("\n".join(parts).encode(), output)


def shortened(name: str) -> str:
    """Return a name of at most `LONGEST_NAME` characters."""
    return name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…"


def coordinate_text(value: float, space: ColourSpace) -> str:
    """Return a coordinate: to a thousandth of the lightness of white."""
    decimals = max(3 - round(math.log10(space.white_lightness)), 0)
    return fixed_text(value, decimals).replace(",", "")


def percent_text(share: float) -> str:
    """Return a share in per cent, for columns that have the unit in their heading."""
    return fixed_text(100.0 * share, 1)


def _aligned(cells: Sequence[Sequence[str]], right: Sequence[bool]) -> str:
    """Return columns of cells as lines of text."""
    widths = [max(map(len, column)) for column in cells]
    return "".join(
        "  ".join(
            f"{cell:>{width}}" if is_right else f"{cell:{width}}"
            for cell, width, is_right in zip(row, widths, right, strict=True)
        ).rstrip()
        + "\n"
        for row in zip(*cells, strict=True)
    )


def state(*gamuts: Conditions, warnings: Sequence[str] | None = None) -> dict[str, Any]:
    """Write the conditions of the gamuts that answer, and warnings, on standard error.

    Without `warnings`, these are those of the builds.
    Return the same as members of JSON: ``gamut``, or ``gamuts`` of two, and ``warnings``.
    """
    for name, gamut in zip("AB" if len(gamuts) > 1 else [""], gamuts, strict=False):
        tell(f"Gamut{name and ' '}{name}: {gamut}")
    if warnings is None:
        from gamutcore.questions import build_warnings  # noqa: PLC0415

        warnings = build_warnings(*gamuts)
    for warning in warnings:
        tell(f"Warning: {warning}")
    documents = [gamut.to_dict() for gamut in gamuts]
    named: dict[str, Any] = (
        {"gamut": documents[0]}
        if len(documents) == 1
        else {"gamuts": dict(zip("ab", documents, strict=True))}
    )
    return {**named, "warnings": list(warnings)}


def interval_row(interval: Interval, text: Callable[[float], str]) -> list[str]:
    """Return the cells of an interval under `INTERVAL_HEADINGS`."""
    return [text(value) for value in (interval.value, interval.low, interval.high)]


INTERVAL_HEADINGS = ("value", "from", "to (95 %)")
"""Columns of intervals in text."""


def write_report(report: Report, output: Path | None, *, as_json: bool, as_csv: bool) -> None:
    """Write a report: text, JSON or CSV on standard output, or a file in the form of its suffix."""
    if as_json and as_csv:
        raise typer.BadParameter("Give --json or --csv, not both.")
    if output is not None and not (as_json or as_csv):
        report.save(output)
        tell(f"{output}: {report.sentences[0]}")
        return
    text = report.to_json() if as_json else report.to_csv() if as_csv else report.to_text()
    write_bytes(text.encode(), output)


def write_table(
    columns: Columns,
    output: Path | None,
    *,
    as_json: bool,
    as_csv: bool,
    stated: Mapping[str, Any] | None = None,
    units: Mapping[str, str] | None = None,
) -> None:
    """Write a table: aligned text, JSON with one array for each column, or CSV.

    `stated` are further members of JSON, from `state`. Columns of the same names come first. Text
    has the `units` of columns in their headings.
    """
    form = answer_form(output, as_json=as_json, as_csv=as_csv)
    if form == "json":
        plain: dict[str, Any] = {
            **(stated or {}),
            **{name: [_plain(value) for value in values] for name, values in columns.items()},
        }
        text = json.dumps(plain, ensure_ascii=False, allow_nan=False) + "\n"
    elif form == "csv":
        text = _csv(columns)
    else:
        named = {name: (units or {}).get(name) for name in columns}
        headings = [f"{name} ({unit})" if unit else name for name, unit in named.items()]
        plain_columns = [[_plain(value) for value in values] for values in columns.values()]
        cells = [
            [heading, *_column_text(values)]
            for heading, values in zip(headings, plain_columns, strict=True)
        ]
        text = _aligned(
            cells, [not any(isinstance(value, str) for value in values) for values in plain_columns]
        )
    write_bytes(text.encode(), output)


_FORMS = {"": "text", ".txt": "text", ".json": "json", ".csv": "csv"}
"""Forms by the suffix of the file; a device such as /dev/stdout has none."""

_ANSWERS = (".csv", ".tsv", ".txt", ".json", ".xlsx")
"""Suffixes of answers beside a table."""


def check_answer_form(output: Path | None, *, as_json: bool) -> None:
    """Refuse a file whose suffix chooses no form, before anything is computed."""
    # a device such as /dev/stdout has no suffix
    if output is None or as_json or (output.exists() and not output.is_file()):
        return
    if output.suffix.lower() not in _ANSWERS:
        raise typer.BadParameter(
            f"Give a name that ends in {', '.join(_ANSWERS[:-1])} or {_ANSWERS[-1]}.",
            param_hint="--output",
        )


def write_answer(
    table: ColourTable,
    added: Columns,
    output: Path | None,
    *,
    as_json: bool,
    stated: Mapping[str, Any],
) -> None:
    """Write a table of colours with further columns.

    Text has the dialect of the table: separator, decimal mark, quotation, ends of lines, and in a
    file the encoding. A .tsv file has tabs. The columns have one value for each row with a colour.
    """
    suffix = "" if output is None else output.suffix.lower()
    if as_json or suffix == ".json":
        names = [*_distinct(table.header), *table.added_names(list(added))]
        rows = list(table.rows())
        columns: dict[str, list[Any]] = {
            name: [cells[at] if cells else "" for cells, _ in rows]
            for at, name in enumerate(names[: len(table.header)])
        }
        for name, values in zip(names[len(table.header) :], added.values(), strict=True):
            answers = iter(values)
            columns[name] = [next(answers) if known else None for _, known in rows]
        write_table(columns, output, as_json=True, as_csv=False, stated=stated)
    elif output is not None and suffix == ".xlsx":
        from gamutcore.tables import write_workbook  # noqa: PLC0415

        write_workbook(table, added, output)
    else:
        text = table.answer_text(added, separator="\t" if suffix == ".tsv" else None)
        write_bytes(text.encode("utf-8" if output is None else table.encoding), output)


def _distinct(names: Sequence[str]) -> list[str]:
    """Return names that differ, as members of JSON must."""
    distinct_names: list[str] = []
    for name in names:
        free, at = name, 1
        while free in distinct_names:
            at += 1
            free = f"{name}_{at}"
        distinct_names.append(free)
    return distinct_names


def drawing_axes(
    output: Path | None,
    *,
    as_json: bool,
    as_csv: bool,
    **kind: Any,  # noqa: ANN401  # of matplotlib
) -> Any | None:  # noqa: ANN401
    """Return new axes if a file is a drawing by its suffix; without matplotlib, the error says so.

    Files that are neither a drawing nor a table are refused: commands call this before they build a
    gamut.
    """
    if output is None or output.suffix.lower() not in DRAWINGS:
        answer_form(output, as_json=as_json, as_csv=as_csv, others=DRAWINGS)
        return None
    from gamutcore.questions import figure  # noqa: PLC0415

    return figure().add_subplot(**kind)


_UNDATED = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
"""Metadata of formats in which matplotlib states the time of writing by default."""


def write_drawing(axes: Any, output: Path) -> None:  # noqa: ANN401  # of matplotlib
    """Write the figure of axes in the format of the suffix, the same figure as the same bytes."""
    from matplotlib import rc_context  # noqa: PLC0415  # optional

    file_format = output.suffix[1:].lower()
    with rc_context({"svg.hashsalt": "gamut"}):  # ids of SVG are random otherwise
        axes.figure.savefig(output, format=file_format, metadata=_UNDATED.get(file_format))


def write_bytes(data: bytes, output: Path | None) -> None:
    """Write bytes to a file, or to standard output."""
    if output is None:
        sys.stdout.buffer.write(data)
        sys.stdout.flush()
    else:
        output.write_bytes(data)


def answer_form(
    output: Path | None, *, as_json: bool, as_csv: bool, others: Sequence[str] = ()
) -> str:
    """Return "text", "json" or "csv", as the options or the suffix of the file say.

    `others` are suffixes that the command writes besides.
    """
    if as_json and as_csv:
        raise typer.BadParameter("Give --json or --csv, not both.")
    if as_json or as_csv:
        return "json" if as_json else "csv"
    suffix = "" if output is None else output.suffix.lower()
    if suffix not in _FORMS:
        *names, last = (*others, ".txt", ".json", ".csv")
        raise typer.BadParameter(
            f"Give a name that ends in {', '.join(names)} or {last}.", param_hint="--output"
        )
    return _FORMS[suffix]


def _csv(columns: Columns) -> str:
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow([_cell(value) for value in row])
    return file.getvalue()


def _plain(value: Any) -> Any:  # noqa: ANN401
    """Return a value as JSON has it: NaN is null."""
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _cell(value: Any) -> str:  # noqa: ANN401
    value = _plain(value)
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return number_text(value) if isinstance(value, float) else str(value)


def _column_text(values: Sequence[Any]) -> list[str]:
    """Return the cells of a column: floats with two decimals, or more if all are small."""
    sizes = [abs(value) for value in values if isinstance(value, float)]
    digits = math.floor(math.log10(max(sizes))) if any(sizes) else 0
    decimals = 2 if digits > 0 else min(4 - digits, MOST_DECIMALS)
    return [
        fixed_text(value, decimals).replace(",", "") if isinstance(value, float) else _text(value)
        for value in values
    ]


MOST_DECIMALS = 6
"""Decimals of small numbers in tables of text."""


def _text(value: Any) -> str:  # noqa: ANN401
    if isinstance(value, list | tuple):
        return " ".join(map(_cell, value))
    return _cell(value) or "-"
