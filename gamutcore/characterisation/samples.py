"""Samples: measured colours, with or without their device values.

The readers of measurements (CGATS, CxF3, CSV, JSON, NumPy) call `samples_from_values`. It checks
the numbers and scales device values to 0 to 1. Colours stay exactly as in the file.
`gamutcore.colours` decides about their white and scale, where the medium is known.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from gamutcore.characterisation.conditions import chosen_condition, stated_condition
from gamutcore.characterisation.spectra import Spectra
from gamutcore.errors import (
    InvalidPointsError,
    MalformedFileError,
    SampleLimitError,
    TooFewPointsError,
)
from gamutcore.limits import current_limits

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.columns import ColumnRoles
    from gamutcore.errors import Where

__all__ = [
    "JSON",
    "IntArray",
    "Samples",
    "place_of_row",
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
    """Return checked samples from an array of numbers.

    Parameters
    ----------
    file_format : str
        Name of the file format.
    roles : ColumnRoles
        Roles of the columns.
    values : (n, c) float
        The columns ``roles.selected``, in that order.
    lines : (n,) int, optional
        The line of each row. Without it, errors name rows, counted from 1.
    conditions : mapping, optional
        Keywords of the file.
    white : (3,) float, optional
        White XYZ of the samples, in their scale.
    illumination : (3,) float, optional
        XYZ of the perfect diffuser under the light of the measurement, in their scale.
    condition : str, optional
        The requested measurement condition.
    row_conditions : sequence of str
        Condition names, by the numbers in the column ``roles.condition_column``.
    spectra_kind : str
        ``Spectra.kind``, if the format states it.
    dropped : int
        Number of patches that could not be used and are not among the rows.
    warnings : sequence of str
        Faults tolerated so far.

    Raises
    ------
    TooFewPointsError
        There are no samples.
    InvalidPointsError
        A colour is not finite or too large.
    MalformedFileError
        Device values are negative or exceed every known scale.
    ConditionError
        The samples have several conditions and none is requested, or not the requested one.
    SampleLimitError
        There are more rows than `current_limits` allow.
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
    kept_conditions = _bounded_conditions(conditions or {})
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
    spectra = _spectra(values, roles, spectra_kind)
    patches: dict[str, JSON] = {"read": read, "dropped": read - len(values), "averaged": 0}
    provenance: dict[str, JSON] = {
        "format": file_format,
        "channels": list(roles.channels),
        "patches": patches,
        "colour_columns": list(roles.colour_columns),
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
    )


def _rows_of_one_condition(
    values: FloatArray, lines: IntArray | None, labels: Sequence[str], asked: str | None
) -> tuple[FloatArray, IntArray | None, str | None]:
    numbers = values[:, -1].astype(np.intp)
    found = [labels[number] or None for number in np.unique(numbers)]
    label = chosen_condition(found, asked)
    kept = numbers == list(labels).index(label or "")
    return values[kept], None if lines is None else lines[kept], label


def _colours(
    values: FloatArray, roles: ColumnRoles, lines: IntArray | None
) -> tuple[FloatArray | None, FloatArray | None]:
    """Return Lab and XYZ, also from LCh and xyY."""
    places = {column: index for index, column in enumerate(roles.selected)}
    lab, xyz = _columns(values, roles.lab, places), _columns(values, roles.xyz, places)
    lch, xyy = _columns(values, roles.lch, places), _columns(values, roles.xyy, places)
    if lch is not None:
        hue = np.radians(lch[:, 2])
        lab = np.stack([lch[:, 0], lch[:, 1] * np.cos(hue), lch[:, 1] * np.sin(hue)], axis=1)
    if xyy is not None:
        x, y, luminance = xyy.T
        # Black has no chromaticity, and meters write zeros.
        black = luminance == 0
        bad = (~black & (y <= 0)) | (x < 0) | (y < 0) | (x + y > 1.001)
        if bad.any():
            row = int(np.argmax(bad))
            raise InvalidPointsError(
                f"The chromaticity x {x[row]:g}, y {y[row]:g} is impossible.",
                where={**place_of_row(row, lines), "field": "xyY"},
                remedy="Give x of at least 0, y above 0, and a sum of at most 1.",
            )
        scale = luminance / np.where(black, 1.0, y)
        xyz = np.stack([x * scale, luminance, (1 - x - y) * scale], axis=1)
    return lab, xyz


def _spectra(values: FloatArray, roles: ColumnRoles, kind: str) -> Spectra | None:
    if not roles.spectrum:
        return None
    last = len(roles.selected) - (roles.condition_column is not None)
    bands = np.ascontiguousarray(values[:, last - len(roles.spectrum) : last])
    return Spectra(np.array(roles.wavelengths), bands, kind)


def _described(spectra: Spectra) -> JSON:
    steps = np.unique(np.round(np.diff(spectra.wavelengths), 3))
    return {
        "from": float(spectra.wavelengths[0]),
        "to": float(spectra.wavelengths[-1]),
        "bands": len(spectra.wavelengths),
        "step": float(steps[0]) if len(steps) == 1 else None,
    }


def _bounded_conditions(conditions: Mapping[str, str]) -> dict[str, str]:
    # Every description of the gamut contains the conditions, so their size is limited.
    return {
        name[:80]: text[:MAX_CONDITION_LENGTH]
        for name, text in list(conditions.items())[:MAX_CONDITIONS]
    }


def _columns(
    values: FloatArray, columns: tuple[int, ...] | None, places: Mapping[int, int]
) -> FloatArray | None:
    if columns is None:
        return None
    return np.ascontiguousarray(values[:, [places[column] for column in columns]])


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
