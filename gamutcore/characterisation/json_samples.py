"""Samples as JSON, as programs send them inline.

The document is an object with `samples` (rows of numbers, or objects by column name), `columns`
(names; L*, a*, b* by default), and optionally `white`, `illuminant`, `observer` and other
conditions. An array of rows alone is accepted too. Size and structure are limited before decoding.
"""

from __future__ import annotations

import json
from collections import Counter
from typing import Any, NoReturn

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.characterisation.columns import ColumnRoles, column_roles
from gamutcore.characterisation.conditions import condition_label
from gamutcore.characterisation.samples import Samples, samples_from_values
from gamutcore.characterisation.table import MAX_ROW_CONDITIONS
from gamutcore.errors import MalformedFileError, SampleLimitError

__all__ = ["MAX_JSON_SAMPLES", "json_samples"]

MAX_JSON_SAMPLES = 1_000_000
"""Maximum number of samples in a JSON document. Each takes about 200 bytes when decoded."""

MAX_JSON_CHARACTERS = 64_000_000
MAX_JSON_VALUES = 8_000_000

_DEFAULT_COLUMNS = ("LAB_L", "LAB_A", "LAB_B")
_EXAMPLE = '{"columns": ["LAB_L", "LAB_A", "LAB_B"], "samples": [[50, 0, 0], ...]}'


def json_samples(text: str, *, condition: str | None = None) -> Samples:
    """Return the samples in a JSON document.

    The document is ``{"columns": [names], "samples": [[numbers], ...], "white": [X, Y, Z],
    "conditions": {keyword: text}}``. Only ``samples`` is required. Other members with a text or a
    number are conditions. A sample may be an object from column name to number. The column
    ``MEASUREMENT_CONDITION`` has texts.
    """
    document = _decoded(text)
    if isinstance(document, list):
        document = {"samples": document}
    if not isinstance(document, dict) or not isinstance(document.get("samples"), list):
        raise MalformedFileError(
            "The JSON document has no array of samples.",
            where={"field": "samples"},
            remedy=f"Send it as {_EXAMPLE}.",
        )
    rows = document["samples"]
    columns = _columns(document, rows)
    roles = column_roles(columns, condition=condition, where={"field": "columns"})
    labels: dict[str, int] = {}
    values = _values(rows, columns, roles, labels)
    white = document.get("white")
    return samples_from_values(
        "json",
        roles,
        values,
        conditions=_conditions(document),
        condition=condition,
        row_conditions=tuple(labels),
        white=None if white is None else _white(white),
    )


def _decoded(text: str) -> Any:  # noqa: ANN401 (JSON before its shape is known)
    if (
        len(text) > MAX_JSON_CHARACTERS
        or text.count("[") + text.count("{") > MAX_JSON_SAMPLES + 100
        or text.count(",") > MAX_JSON_VALUES
    ):
        raise SampleLimitError(
            f"The JSON document is too large for {MAX_JSON_SAMPLES} samples.",
            where={"field": "samples"},
            remedy="Thin the samples out, or send them as a NumPy .npy file.",
        )
    try:
        return json.loads(
            text, parse_constant=_refuse_constant, object_pairs_hook=_with_unique_names
        )
    except json.JSONDecodeError as error:
        raise MalformedFileError(
            f"The JSON document is malformed: {error.msg}.",
            where={"line": error.lineno, "column": error.colno},
            remedy=f"Send it as {_EXAMPLE}.",
        ) from None
    except (ValueError, RecursionError) as error:
        problem = "is nested too deeply" if isinstance(error, RecursionError) else "has a number "
        problem += "" if isinstance(error, RecursionError) else "with too many digits"
        raise MalformedFileError(
            f"The JSON document {problem}.", remedy=f"Send it as {_EXAMPLE}."
        ) from None


def _with_unique_names(members: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object; refuse repeated names, because either value could be meant."""
    found = dict(members)
    if len(found) < len(members):
        name = Counter(name for name, _ in members).most_common(1)[0][0]
        raise MalformedFileError(
            f"The JSON document has more than one member named {name[:80]!r} in an object.",
            where={"field": name[:80]},
            remedy="Give every member of an object once (RFC 7493, 2.3).",
        )
    return found


def _refuse_constant(name: str) -> NoReturn:
    raise MalformedFileError(
        f"{name} is not a number in JSON.",
        where={"field": "samples"},
        remedy="Every colour and device value must be a plain, finite number.",
    )


def _columns(document: dict[str, Any], rows: list[Any]) -> tuple[str, ...]:
    columns = document.get("columns")
    if columns is None:
        if rows and isinstance(rows[0], dict):
            return tuple(rows[0])
        return _DEFAULT_COLUMNS
    if not isinstance(columns, list) or not all(isinstance(name, str) for name in columns):
        raise MalformedFileError(
            "The columns are not an array of names.",
            where={"field": "columns"},
            remedy=f"Send them as in {_EXAMPLE}.",
        )
    return tuple(columns)


def _values(
    rows: list[Any], columns: tuple[str, ...], roles: ColumnRoles, labels: dict[str, int]
) -> FloatArray:
    """Return the numbers of the selected columns; `labels` maps condition names to numbers."""
    flat: list[float] = []
    # bool is a subclass of int in Python, but not a number in JSON.
    numeric = {int, float}
    selected = roles.selected
    for index, row in enumerate(rows):
        cells = [row.get(name) for name in columns] if isinstance(row, dict) else row
        if not isinstance(cells, list) or len(cells) != len(columns):
            raise MalformedFileError(
                f"Sample {index + 1} is not an array of {len(columns)} numbers.",
                where={"row": index + 1, "field": f"samples[{index}]"},
                remedy=f"Every sample has one number for each of {', '.join(columns)[:300]}.",
            )
        if roles.condition_column is not None:
            cells = _with_condition_number(cells, index, roles.condition_column, labels)
        needed = [cells[column] for column in selected]
        if not {*map(type, needed)} <= numeric:
            raise _not_a_number(needed, index, roles)
        try:
            flat.extend(map(float, needed))
        except OverflowError:
            raise _not_a_number(needed, index, roles) from None
    return np.array(flat, dtype=np.float64).reshape(-1, len(selected))


def _with_condition_number(
    cells: list[Any], row: int, column: int, labels: dict[str, int]
) -> list[Any]:
    text = cells[column]
    if not isinstance(text, str) and text is not None:
        raise MalformedFileError(
            f"The measurement condition of sample {row + 1} is not a text.",
            where={"row": row + 1, "field": f"samples[{row}][{column}]"},
            remedy='Write it as in "M1".',
        )
    number = labels.setdefault(condition_label(text or ""), len(labels))
    if number >= MAX_ROW_CONDITIONS:
        raise SampleLimitError(
            f"The samples have more than {MAX_ROW_CONDITIONS} measurement conditions.",
            where={"row": row + 1, "field": f"samples[{row}][{column}]"},
            remedy=f"Send the samples of at most {MAX_ROW_CONDITIONS} conditions at a time.",
        )
    return [*cells[:column], number, *cells[column + 1 :]]


def _not_a_number(cells: list[Any], row: int, roles: ColumnRoles) -> MalformedFileError:
    place = next(
        (i for i, c in enumerate(cells) if type(c) not in {int, float} or abs(c) > 1e300), 0
    )
    shown = json.dumps(cells[place])[:40]
    return MalformedFileError(
        f"{shown} in the column {roles.selected_names[place]} of sample {row + 1} is not a number.",
        where={
            "row": row + 1,
            "column": roles.selected[place] + 1,
            "field": f"samples[{row}][{roles.selected[place]}]",
        },
        remedy="Every colour and device value must be a plain, finite number.",
    )


def _white(white: object) -> FloatArray:
    fine = (
        isinstance(white, list)
        and len(white) == 3
        and all(type(value) in {int, float} and 0 < value < 1e6 for value in white)
    )
    if not fine:
        raise MalformedFileError(
            "The white is not three positive numbers.",
            where={"field": "white"},
            remedy="Give X, Y and Z of the white in the scale of the samples' XYZ.",
        )
    return np.array(white, dtype=np.float64)


def _conditions(document: dict[str, Any]) -> dict[str, str]:
    stated = document.get("conditions", {})
    if not isinstance(stated, dict):
        raise MalformedFileError(
            "The conditions are not an object.",
            where={"field": "conditions"},
            remedy='Give them as {"ILLUMINANT": "D50", "OBSERVER": "2 degree"}.',
        )
    found: dict[str, str] = {}
    members = {**document, **stated}
    for name, value in members.items():
        if name in {"samples", "columns", "white", "conditions"}:
            continue
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise MalformedFileError(
                f"The member {name[:40]!r} is unknown, and its value is not a text or number.",
                where={"field": name[:80]},
                remedy="Members are samples, columns, white, conditions, and conditions by name.",
            )
        found[name.upper()] = value if isinstance(value, str) else f"{value:.6g}"
    return found
