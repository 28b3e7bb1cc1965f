"""Repeated readings of one device value that contradict each other.

A reading of zero beside light ones has failed. A reading far from the median of its repeats, by the
median absolute deviation (MAD), is an outlier. Both are left out. Repeats that contradict each
other without such a reading are refused: their mean would be a colour that nobody measured. Honest
repeats of presses and displays differ by 1 to 2 ΔE*ab and are all used.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.samples import IntArray, Spectra, place_of_row
from gamutcore.colours.colorimetry import ICC_D50, xyz_to_lab
from gamutcore.colours.measured import reflectance_xyz
from gamutcore.errors import InvalidPointsError

if TYPE_CHECKING:
    import numpy.typing as npt

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.samples import Samples

_SAME_DEVICE_VALUE = 5e-4
"""Largest difference of repeated device values: rounding to 0.1 %. The steps of 10 bits are 1e-3;
such a step changes the colour by less than the noise of an instrument."""

_CONTRADICTION = 3.0
"""ΔE*ab beyond which repeats contradict each other."""

_DEVIATIONS = 3.5
"""MADs from the median beyond which a reading is an outlier (Iglewicz and Hoaglin, How to Detect
and Handle Outliers, 1993, without their factor for normal noise)."""

_ZERO = 0.1
"""Largest ΔE*ab from black of a reading of zero."""

_LISTED = 10
"""Largest number of readings that warnings list."""


def consistent_samples(samples: Samples) -> Samples:
    """Return samples without failed readings and outliers among the repeats of a device value.

    Warnings name the line of each. The samples themselves are returned if there is none.

    Raises
    ------
    InvalidPointsError
        Repeats contradict each other, and none of them is an outlier.
    """
    if samples.device is None:
        return samples
    groups = [rows for rows in device_groups(samples.device) if len(rows) > 1]
    if not groups:
        return samples
    lab = _colours(samples)
    is_used = np.ones(len(lab), dtype=bool)
    warnings: list[str] = []
    for rows in groups:
        reasons = _left_out(samples, rows, lab[rows])
        is_used[list(reasons)] = False
        warnings += reasons.values()
    if is_used.all():
        return samples
    if len(warnings) > _LISTED:
        more = len(warnings) - _LISTED
        warnings = [*warnings[:_LISTED], f"{more} more repeated readings are left out."]
    return _selected(samples, is_used, warnings)


def device_groups(device: FloatArray) -> list[IntArray]:
    """Return the rows of each distinct device value, ascending."""
    cells = np.empty(device.shape, dtype=np.int64)
    for channel, values in enumerate(device.T):
        order = np.argsort(values, kind="stable")
        ranked = values[order]
        first = np.concatenate([[True], np.diff(ranked) > _SAME_DEVICE_VALUE])
        level = np.cumsum(first) - 1
        # a smooth ramp is no single level
        steps = np.floor((ranked - ranked[first][level]) / _SAME_DEVICE_VALUE).astype(np.int64)
        cells[order, channel] = level * (int(steps.max()) + 1) + steps
    order = np.lexsort(cells.T[::-1])
    ranked_cells = cells[order]
    starts = np.flatnonzero((ranked_cells[1:] != ranked_cells[:-1]).any(axis=1)) + 1
    return [np.sort(rows) for rows in np.split(order, starts)]


def _colours(samples: Samples) -> FloatArray:
    """CIELAB of the samples (n, 3), by their own white where they are not CIELAB already."""
    assert samples.device is not None  # noqa: S101 (only called with device values)
    if samples.lab is not None:
        return samples.lab
    xyz = samples.xyz
    if xyz is None:
        assert isinstance(samples.spectra, Spectra)  # noqa: S101 (samples have a colour)
        xyz, _ = reflectance_xyz(samples.spectra.wavelengths, samples.spectra.values, "D50", 2)
    target = 1.0 if samples.additive else 0.0
    whites = xyz[np.abs(samples.device - target).max(axis=1) <= _SAME_DEVICE_VALUE]
    if len(whites):
        white = whites[np.argsort(whites[:, 1])[len(whites) // 2]]
        if (white > 0).all():  # the white of lights has a chromaticity of its own
            return xyz_to_lab(xyz * (ICC_D50 / white))
    return xyz_to_lab(xyz / (float(xyz[:, 1].max()) or 1.0))


def _left_out(samples: Samples, rows: IntArray, lab: FloatArray) -> dict[int, str]:
    """Rows of one device value to leave out, with the reasons."""
    assert samples.device is not None  # noqa: S101 (only called with device values)
    reasons: dict[int, str] = {}
    value = _device_text(samples, int(rows[0]))
    zero = np.linalg.norm(lab, axis=1) <= _ZERO
    # the black of a display may be no light at all
    dark = samples.additive and bool((samples.device[rows] <= _SAME_DEVICE_VALUE).all())
    if zero.any() and not zero.all() and not dark:
        light = np.median(lab[~zero], axis=0)
        if float(np.linalg.norm(light)) > _CONTRADICTION:
            for row in rows[zero]:
                reasons[int(row)] = (
                    f"{_line(samples, int(row))} is left out: a reading of zero for {value}, of "
                    f"which other readings have L* {light[0]:.1f}."
                )
            rows, lab = rows[~zero], lab[~zero]
    if len(rows) < 2:
        return reasons
    distances = np.linalg.norm(lab - np.median(lab, axis=0), axis=1)
    deviation = float(np.median(distances))
    outlier = (distances > _DEVIATIONS * deviation) & (distances > _CONTRADICTION)
    for row, distance in zip(rows[outlier], distances[outlier], strict=True):
        reasons[int(row)] = (
            f"{_line(samples, int(row))} is left out: it is {distance:.1f} ΔE*ab from the median "
            f"of the {len(rows)} readings of {value}."
        )
    rows, lab = rows[~outlier], lab[~outlier]
    apart = float(np.linalg.norm(lab[0] - lab[1])) if len(rows) == 2 else deviation
    if apart > _CONTRADICTION:
        raise _contradiction(samples, rows, lab, value)
    return reasons


def _contradiction(
    samples: Samples, rows: IntArray, lab: FloatArray, value: str
) -> InvalidPointsError:
    """Return the error that names the two readings that are farthest from each other."""
    one = int(np.argmax(np.linalg.norm(lab - np.median(lab, axis=0), axis=1)))
    distances = np.linalg.norm(lab - lab[one], axis=1)
    other = int(np.argmax(distances))
    first, second = sorted((int(rows[one]), int(rows[other])))
    lines = f"{_line(samples, first)} and {_line(samples, second).lower()}"
    colours = " and ".join(
        "L* {:.1f}, a* {:.1f}, b* {:.1f}".format(*lab[place])
        for place in sorted((one, other), key=lambda place: int(rows[place]))
    )
    return InvalidPointsError(
        f"{lines} contradict each other: readings of {value} are {distances[other]:.1f} ΔE*ab "
        f"apart ({colours}), and no other reading tells which is wrong.",
        where={
            **place_of_row(second, samples.lines),
            "field": "samples",
            "readings": [_line(samples, first), _line(samples, second)],
        },
        remedy="Remove the wrong reading, or measure the patch again.",
    )


def _line(samples: Samples, row: int) -> str:
    ((kind, number),) = place_of_row(row, samples.lines).items()
    return f"{kind.capitalize()} {number}"


def _device_text(samples: Samples, row: int) -> str:
    assert samples.device is not None  # noqa: S101 (only called with device values)
    values = 100.0 * samples.device[row]
    named = zip(samples.channels, values, strict=True)
    return ", ".join(f"{channel} {value:.4g}" for channel, value in named) + " %"


def _selected(samples: Samples, is_used: npt.NDArray[np.bool_], warnings: list[str]) -> Samples:
    spectra = samples.spectra
    assert samples.device is not None  # noqa: S101 (only called with device values)
    patches = samples.provenance.get("patches")
    provenance = dict(samples.provenance)
    if isinstance(patches, dict):
        dropped = patches.get("dropped")
        before = dropped if isinstance(dropped, int) else 0
        provenance["patches"] = {**patches, "dropped": before + int((~is_used).sum())}
    return replace(
        samples,
        device=samples.device[is_used],
        lab=None if samples.lab is None else samples.lab[is_used],
        xyz=None if samples.xyz is None else samples.xyz[is_used],
        spectra=None if spectra is None else replace(spectra, values=spectra.values[is_used]),
        lines=None if samples.lines is None else samples.lines[is_used],
        provenance=provenance,
        warnings=(*samples.warnings, *warnings),
    )
