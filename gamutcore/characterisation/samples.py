"""Samples: measured colours, with or without their device values, and their plain readers.

The readers of measurements (CGATS, CxF3, delimited text, JSON, NumPy) call `samples_from_values`.
It checks the numbers and scales device values to 0 to 1. Colours stay exactly as in the file.
`gamutcore.colours` decides about their white and scale, where the medium is known.

JSON is what programs send inline: an object with `samples` (rows of numbers, or objects by column
name), `columns` (names; L*, a*, b* by default), and optionally `white`, `illuminant`, `observer`
and other conditions, or an array of rows alone. NumPy's .npy format is for large sets of colours:
an (m, 3) array is L*, a*, b*, and the fields of a structured array are columns. Sizes and types are
checked before a document is decoded or an array is made.
"""

from __future__ import annotations

import ast
import json
import math
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NoReturn, TypeAlias

import numpy as np
import numpy.typing as npt

from gamutcore.arrays import FloatArray
from gamutcore.characterisation.columns import (
    MAX_COLUMNS,
    ColumnRoles,
    chosen_condition,
    column_roles,
    condition_label,
    stated_condition,
)
from gamutcore.errors import (
    InvalidPointsError,
    MalformedFileError,
    MissingColumnError,
    SampleLimitError,
    TooFewPointsError,
)
from gamutcore.limits import current_limits

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.errors import Where

__all__ = [
    "JSON",
    "MAX_JSON_SAMPLES",
    "MAX_ROW_CONDITIONS",
    "NPY_MAGIC",
    "IntArray",
    "Samples",
    "Spectra",
    "json_samples",
    "npy_samples",
    "place_of_row",
    "reflectance_scale",
    "samples_from_values",
]

JSON: TypeAlias = "bool | int | float | str | list[JSON] | dict[str, JSON] | None"
IntArray: TypeAlias = npt.NDArray[np.int64]

DEVICE_SCALES = (1.0, 100.0, 255.0, 1023.0, 4095.0, 65535.0)
"""Full scales of device values in files: 1, per cent, and 8, 10, 12 and 16 bits."""

ADDITIVE_CHANNELS = frozenset("RGBW")
"""Channels of light, for which full scale is white. For inks, zero is white."""

_LIMITS = {
    "device": 1e5,
    "lab": 1e3,
    "lch": 1e3,
    "xyz": 1e6,
    "xyy": 1e6,
    "spectrum": 1e6,
    "condition": 1e6,
}
"""Maximum absolute values. No measured colour exceeds them, and their cubes do not overflow."""

MAX_ROW_CONDITIONS = 50
"""Maximum number of measurement conditions among the rows of a table."""

MAX_CONDITIONS = 200
MAX_CONDITION_LENGTH = 500
MAX_WARNINGS = 50


@dataclass(frozen=True, eq=False)
class Samples:
    """Measured colours of one device, or bare colours.

    Parameters
    ----------
    format : str
        ``"cgats"``, ``"cxf"``, ``"csv"``, ``"json"`` or ``"npy"``.
    device : (n, k) float or None
        Device values, 0 to 1; None for bare colours.
    channels : tuple of str
        The k channel names, such as ``("C", "M", "Y", "K")``; empty for bare colours.
    lab : (n, 3) float or None
        CIELAB L*, a*, b* as in the file.
    xyz : (n, 3) float or None
        Tristimulus values as in the file, in its scale (0-1, 0-100 or cd/m²).
    spectra : Spectra or None
        Spectra as in the file. At least one of `lab`, `xyz` and `spectra` is not None.
    white : (3,) float or None
        White of the samples, in the scale of `xyz`.
    illumination : (3,) float or None
        XYZ of the perfect diffuser under the light of the measurement, in the scale of `xyz`.
    condition : str or None
        Measurement condition, such as ``"M1"``; None if not stated.
    lines : (n,) int or None
        Line of each sample in a text, from 1; None for other data.
    conditions : dict
        Keywords of the file, in upper case, to texts.
    provenance : dict
        Format, patches read, device scale, and so on; JSON-able.
    warnings : tuple of str
        Faults that the reader tolerated.
    """

    format: str
    device: FloatArray | None
    channels: tuple[str, ...]
    lab: FloatArray | None
    xyz: FloatArray | None
    white: FloatArray | None = None
    conditions: dict[str, str] = field(default_factory=dict)
    provenance: dict[str, JSON] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    spectra: Spectra | None = None
    illumination: FloatArray | None = None
    condition: str | None = None
    lines: IntArray | None = None

    def __len__(self) -> int:
        if self.spectra is not None:
            return len(self.spectra.values)
        colours = self.lab if self.lab is not None else self.xyz
        return 0 if colours is None else len(colours)

    @property
    def inks(self) -> bool:
        """Whether the channels are inks, not lights or gray."""
        return bool(self.channels) and not self.additive and len(self.channels) > 1

    @property
    def additive(self) -> bool:
        """Whether all channels at full scale give white (lights, not inks)."""
        return bool(self.channels) and set(self.channels) <= ADDITIVE_CHANNELS


def samples_from_values(
    file_format: str,
    roles: ColumnRoles,
    values: FloatArray,
    *,
    lines: IntArray | None = None,
    conditions: Mapping[str, str] | None = None,
    white: FloatArray | None = None,
    illumination: FloatArray | None = None,
    condition: str | None = None,
    row_conditions: Sequence[str] = (),
    spectra_kind: str = "unknown",
    dropped: int = 0,
    warnings: Sequence[str] = (),
) -> Samples:
    """Return checked samples from the columns ``roles.selected`` (n, c), in that order.

    `lines` (n,) has the line of each row; without it, errors name rows, counted from 1.
    `conditions` has the keywords of the file. `white` and `illumination` (3,) are as in `Samples`.
    `condition` is the requested measurement condition, and `row_conditions` has the names of those
    that are numbers in the column ``roles.condition_column``. `dropped` counts patches that are not
    among the rows.
    """
    if len(values) == 0:
        raise TooFewPointsError(
            "The data has no samples.", remedy="Send at least four different colours."
        )
    most = current_limits().samples
    if len(values) > most:
        raise SampleLimitError(
            f"The data has {len(values)} samples, more than {most}.",
            where={"field": "samples"},
            remedy="Thin the samples out.",
        )
    read = len(values) + dropped
    _refuse_numbers_beyond(values, roles, lines)
    # Every description of the gamut contains the conditions, so their size is limited.
    kept_conditions = {
        name[:80]: text[:MAX_CONDITION_LENGTH]
        for name, text in list((conditions or {}).items())[:MAX_CONDITIONS]
    }
    if roles.condition_column is None:
        stated = roles.condition or stated_condition(kept_conditions)
        label = chosen_condition([stated], condition)
    else:
        values, lines, label = _rows_of_one_condition(values, lines, row_conditions, condition)
    device, scale = None, None
    if roles.device:
        device, scale = _device_fractions(values[:, : len(roles.device)], roles, lines)
    lab, xyz = _colours(values, roles, lines)
    said = list(warnings)
    if roles.ignored:
        said.append(f"Columns that are not used: {', '.join(roles.ignored)}.")
    bands = _columns(values, roles, "spectrum")
    spectra = None if bands is None else Spectra(np.array(roles.wavelengths), bands, spectra_kind)
    patches: dict[str, JSON] = {"read": read, "dropped": read - len(values), "averaged": 0}
    provenance: dict[str, JSON] = {
        "format": file_format,
        "channels": list(roles.channels),
        "patches": patches,
        "colour_columns": [kind.upper() for kind in roles.colours],
        "measurement_condition": label,
    }
    if scale is not None:
        provenance["device_scale"] = scale
    if spectra is not None:
        provenance["spectra"] = _described(spectra)
    if kept_conditions:
        provenance["conditions"] = dict(kept_conditions)
    return Samples(
        format=file_format,
        device=device,
        channels=roles.channels,
        lab=lab,
        xyz=xyz,
        white=white,
        conditions=kept_conditions,
        provenance=provenance,
        warnings=tuple(said[:MAX_WARNINGS]),
        spectra=spectra,
        illumination=illumination,
        condition=label,
        lines=lines,
    )


def _rows_of_one_condition(
    values: FloatArray, lines: IntArray | None, labels: Sequence[str], asked: str | None
) -> tuple[FloatArray, IntArray | None, str | None]:
    numbers = values[:, -1].astype(np.intp)
    conditions = [labels[number] or None for number in np.unique(numbers)]
    label = chosen_condition(conditions, asked)
    is_chosen = numbers == list(labels).index(label or "")
    return values[is_chosen], None if lines is None else lines[is_chosen], label


def xyz_of_xyy(xyy: FloatArray) -> FloatArray:
    """Return X, Y, Z (n, 3) of x, y, Y (n, 3). Black has no chromaticity; y may be 0 there."""
    x, y, luminance = xyy.T
    scale = luminance / np.where(y > 0, y, 1.0)
    return np.stack([x * scale, luminance, (1 - x - y) * scale], axis=1)


def _colours(
    values: FloatArray, roles: ColumnRoles, lines: IntArray | None
) -> tuple[FloatArray | None, FloatArray | None]:
    """Return Lab and XYZ, also from LCh and xyY."""
    lab, xyz = _columns(values, roles, "lab"), _columns(values, roles, "xyz")
    lch, xyy = _columns(values, roles, "lch"), _columns(values, roles, "xyy")
    if lch is not None:
        hue = np.radians(lch[:, 2])
        lab = np.stack([lch[:, 0], lch[:, 1] * np.cos(hue), lch[:, 1] * np.sin(hue)], axis=1)
    if xyy is not None:
        x, y, luminance = xyy.T
        # Meters write zeros for black.
        bad = ((luminance != 0) & (y <= 0)) | (x < 0) | (y < 0) | (x + y > 1.001)
        if bad.any():
            row = int(np.argmax(bad))
            raise InvalidPointsError(
                f"The chromaticity x {x[row]:g}, y {y[row]:g} is impossible.",
                where={**place_of_row(row, lines), "field": "xyY"},
                remedy="Give x of at least 0, y above 0, and a sum of at most 1.",
            )
        xyz = xyz_of_xyy(xyy)
    return lab, xyz


def _columns(values: FloatArray, roles: ColumnRoles, kind: str) -> FloatArray | None:
    if kind not in roles.colours:
        return None
    start = roles.kinds.index(kind)
    return np.ascontiguousarray(values[:, start : start + len(roles.colours[kind])])


def _described(spectra: Spectra) -> JSON:
    steps = np.unique(np.round(np.diff(spectra.wavelengths), 3))
    return {
        "from": float(spectra.wavelengths[0]),
        "to": float(spectra.wavelengths[-1]),
        "bands": len(spectra.wavelengths),
        "step": float(steps[0]) if len(steps) == 1 else None,
    }


def place_of_row(row: int, lines: IntArray | None) -> Where:
    """Return the location of a row for an error: its line in a text, else its number from 1."""
    return {"row": row + 1} if lines is None else {"line": int(lines[row])}


def _place_of_cell(row: int, place: int, roles: ColumnRoles, lines: IntArray | None) -> Where:
    """Return the location of a cell for an error: row, and number and name of the column."""
    return {
        **place_of_row(row, lines),
        "column": roles.selected[place] + 1,
        "field": roles.selected_names[place],
    }


def _refuse_numbers_beyond(values: FloatArray, roles: ColumnRoles, lines: IntArray | None) -> None:
    limit = np.array([_LIMITS[kind] for kind in roles.kinds])
    with np.errstate(invalid="ignore"):
        bad = ~(np.abs(values) <= limit)
    if not bad.any():
        return
    row, place = (int(index) for index in np.argwhere(bad)[0])
    name, value = roles.selected_names[place], float(values[row, place])
    problem = "is not a finite number" if not np.isfinite(value) else "is beyond any colour"
    raise InvalidPointsError(
        f"The value {value} of {name} {problem}.",
        where=_place_of_cell(row, place, roles, lines),
        remedy="Every colour and device value must be a plain, finite number.",
    )


def _device_fractions(
    device: FloatArray, roles: ColumnRoles, lines: IntArray | None
) -> tuple[FloatArray, float]:
    lowest, highest = float(device.min()), float(device.max())
    # Some tables exceed full scale or zero by a rounding error (100.0001).
    scale = next((s for s in DEVICE_SCALES if highest <= s * 1.00001), None)
    if scale is None or lowest < -1e-5 * scale:
        fault = device > DEVICE_SCALES[-1] if scale is None else device < 0
        row, place = (int(index) for index in np.argwhere(fault)[0])
        raise MalformedFileError(
            f"The device value {float(device[row, place])} of {roles.selected_names[place]} is "
            "outside every known scale.",
            where=_place_of_cell(row, place, roles, lines),
            remedy="Device values run from 0 to 1, 100, 255, 1023, 4095 or 65535.",
        )
    return np.clip(device / scale, 0.0, 1.0), scale


FRACTION_LIMIT = 2.0
"""Maximum reflectance on the scale 0-1. Fluorescent papers reach 1.3 (M1). Per cent values of a
paper exceed 2."""


@dataclass(frozen=True, eq=False)
class Spectra:
    """Spectra of samples: `values` (n, b) at the `wavelengths` (b,) in nm, ascending.

    Reflectances are 1 for the perfect diffuser, or have the divisor `scale`, 1 or 100. Radiances
    may have any unit. `kind` is ``"reflectance"``, ``"emission"``, or ``"unknown"`` if the device
    decides.
    """

    wavelengths: FloatArray
    values: FloatArray
    kind: str = "unknown"
    scale: float = 1.0


def reflectance_scale(values: FloatArray) -> float:
    """Return the divisor, 1 or 100, that makes reflectances (n, b) 1 for the perfect diffuser."""
    return 1.0 if float(values.max(initial=0.0)) <= FRACTION_LIMIT else 100.0


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
    columns = _json_columns(document, rows)
    roles = column_roles(columns, condition=condition, where={"field": "columns"})
    labels: dict[str, int] = {}
    values = _json_values(rows, columns, roles, labels)
    white = document.get("white")
    return samples_from_values(
        "json",
        roles,
        values,
        conditions=_json_conditions(document),
        condition=condition,
        row_conditions=tuple(labels),
        white=None if white is None else _json_white(white),
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
    mapping = dict(members)
    if len(mapping) < len(members):
        name = Counter(name for name, _ in members).most_common(1)[0][0]
        raise MalformedFileError(
            f"The JSON document has more than one member named {name[:80]!r} in an object.",
            where={"field": name[:80]},
            remedy="Give every member of an object once (RFC 7493, 2.3).",
        )
    return mapping


def _refuse_constant(name: str) -> NoReturn:
    raise MalformedFileError(
        f"{name} is not a number in JSON.",
        where={"field": "samples"},
        remedy="Every colour and device value must be a plain, finite number.",
    )


def _json_columns(document: dict[str, Any], rows: list[Any]) -> tuple[str, ...]:
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


def _json_values(
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
        raise _too_many_conditions({"row": row + 1, "field": f"samples[{row}][{column}]"})
    return [*cells[:column], number, *cells[column + 1 :]]


def _too_many_conditions(where: Where) -> SampleLimitError:
    return SampleLimitError(
        f"The samples have more than {MAX_ROW_CONDITIONS} measurement conditions.",
        where=where,
        remedy=f"Send the samples of at most {MAX_ROW_CONDITIONS} conditions at a time.",
    )


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


def _json_white(white: object) -> FloatArray:
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


def _json_conditions(document: dict[str, Any]) -> dict[str, str]:
    stated = document.get("conditions", {})
    if not isinstance(stated, dict):
        raise MalformedFileError(
            "The conditions are not an object.",
            where={"field": "conditions"},
            remedy='Give them as {"ILLUMINANT": "D50", "OBSERVER": "2 degree"}.',
        )
    conditions: dict[str, str] = {}
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
        conditions[name.upper()] = value if isinstance(value, str) else f"{value:.6g}"
    return conditions


NPY_MAGIC = b"\x93NUMPY"
MAX_VALUES = 16_000_000
"""Maximum number of numbers: 128 MB."""

MAX_ROW_BYTES = 100_000
_MAX_HEADER = 100_000
_NPY_REMEDY = "Save an (m, 3) array of L*, a*, b*, or a structured array, with numpy.save."


def npy_samples(data: bytes, *, condition: str | None = None) -> Samples:
    """Return the samples in a .npy file; a field may state their measurement conditions."""
    array = _array(data)
    if array.dtype.names is None:
        if array.ndim != 2 or array.shape[1] != 3:
            raise MissingColumnError(
                f"An array of shape {array.shape} has no names for its columns.",
                where={"field": "shape"},
                remedy=_NPY_REMEDY,
            )
        roles = column_roles(("LAB_L", "LAB_A", "LAB_B"))
        return samples_from_values("npy", roles, _float(array), condition=condition)
    if array.ndim != 1:
        raise MissingColumnError(
            f"A structured array of shape {array.shape} is not a list of samples.",
            where={"field": "shape"},
            remedy=_NPY_REMEDY,
        )
    names = array.dtype.names
    roles = column_roles(names, condition=condition, where={"field": "descr"})
    if len(array) * len(roles.selected) > MAX_VALUES:
        raise SampleLimitError(
            f"The array has {len(array)} samples of {len(roles.selected)} numbers, too many.",
            where={"field": "shape"},
            remedy=f"Send at most {MAX_VALUES} numbers.",
        )
    values = np.empty((len(array), len(roles.selected)))
    labels: tuple[str, ...] = ()
    for place, column in enumerate(roles.selected):
        field = array[names[column]]
        if column == roles.condition_column:
            values[:, place], labels = _condition_numbers(field)
        elif field.dtype.kind in "SU":
            raise MalformedFileError(
                f"The field {names[column]} holds texts.",
                where={"column": column + 1, "field": names[column]},
                remedy="Colours and device values are numbers.",
            )
        else:
            values[:, place] = _float(field)
    return samples_from_values("npy", roles, values, condition=condition, row_conditions=labels)


def _condition_numbers(field: npt.NDArray[Any]) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the number of each row's measurement condition, and the condition names."""
    try:
        texts = field.astype(str) if field.dtype.kind in "SU" else None
    except (UnicodeDecodeError, ValueError):
        texts = None
    if texts is None:
        raise MalformedFileError(
            "The measurement conditions are not texts.",
            where={"field": "descr"},
            remedy='Save them as a field of texts, such as "M1".',
        )
    distinct_texts, places = np.unique(texts, return_inverse=True)
    if len(distinct_texts) > MAX_ROW_CONDITIONS:
        raise _too_many_conditions({"field": "descr"})
    labels: dict[str, int] = {}
    numbers = [
        labels.setdefault(condition_label(str(text)), len(labels)) for text in distinct_texts
    ]
    return np.array(numbers, dtype=np.float64)[places.ravel()], tuple(labels)


def _float(array: npt.NDArray[Any]) -> FloatArray:
    with np.errstate(over="ignore", invalid="ignore"):
        return np.ascontiguousarray(array, dtype=np.float64)


def _malformed_npy(problem: str) -> MalformedFileError:
    return MalformedFileError(
        f"The .npy file {problem}.", where={"field": "header"}, remedy=_NPY_REMEDY
    )


def _array(data: bytes) -> npt.NDArray[Any]:
    header, start = _header(data)
    try:
        tree = ast.literal_eval(header)
    except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError):
        raise _malformed_npy("has a broken header") from None
    if not isinstance(tree, dict) or set(tree) != {"descr", "fortran_order", "shape"}:
        raise _malformed_npy("has a header without descr, fortran_order and shape")
    shape = tree["shape"]
    if (
        not isinstance(shape, tuple)
        or len(shape) > 4
        or not all(type(size) is int and 0 <= size < 2**40 for size in shape)
    ):
        raise _malformed_npy("has a broken shape")
    dtype = _dtype(tree["descr"])
    if math.prod(shape) * dtype.itemsize != len(data) - start:
        raise _malformed_npy(
            f"holds {len(data) - start} bytes of data where its header says shape {shape} of "
            f"{dtype.itemsize} bytes each"
        )
    most = current_limits().samples
    if shape and shape[0] > most:
        raise SampleLimitError(
            f"The array has {shape[0]} samples, more than {most}.",
            where={"field": "shape"},
            remedy="Thin the samples out.",
        )
    flat = np.frombuffer(data, dtype=dtype, offset=start)
    return flat.reshape(shape, order="F" if tree["fortran_order"] else "C")


def _header(data: bytes) -> tuple[str, int]:
    if len(data) < 12:
        raise _malformed_npy("ends within its header")
    major = data[6]
    if major not in {1, 2, 3}:
        raise _malformed_npy(f"is of version {major}, which is not known")
    start = 10 if major == 1 else 12
    length = int.from_bytes(data[8:start], "little")
    if length > min(_MAX_HEADER, len(data) - start):
        raise _malformed_npy(f"has a header of {length} bytes, which is too long")
    try:
        return data[start : start + length].decode(
            "utf-8" if major == 3 else "latin-1"
        ), start + length
    except UnicodeDecodeError:
        raise _malformed_npy("has a header that is no text") from None


def _dtype(description: Any) -> np.dtype[Any]:  # noqa: ANN401 (a literal of unknown shape)
    if isinstance(description, list) and len(description) > MAX_COLUMNS:
        raise SampleLimitError(
            f"The array has {len(description)} columns, more than {MAX_COLUMNS}.",
            where={"field": "descr"},
            remedy=f"Leave out columns that are not needed, down to {MAX_COLUMNS}.",
        )
    try:
        dtype: np.dtype[Any] = np.lib.format.descr_to_dtype(description)
    except (ValueError, TypeError, LookupError, SyntaxError, RecursionError, OverflowError):
        raise _malformed_npy("has data of an unknown type") from None
    parts = [dtype] if dtype.fields is None else [entry[0] for entry in dtype.fields.values()]
    kinds = "fiu" if dtype.fields is None else "fiuSU"  # fields of texts are names of patches
    if not all(part.kind in kinds and part.shape == () for part in parts):
        raise _malformed_npy("has fields that are not real numbers")
    if not 0 < dtype.itemsize <= MAX_ROW_BYTES:
        raise _malformed_npy(f"has samples of {dtype.itemsize} bytes")
    return dtype
