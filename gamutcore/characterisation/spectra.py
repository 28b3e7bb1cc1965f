"""Spectra of samples as they were measured, and the names that their columns go by.

A band's column is a word and its wavelength in nm (`SPEC_380`, `SPECTRAL_NM380`, `NM_380`, `380`).
Reflectances come on the scale 0-1 or in per cent; what an emission's unit is does not matter, as
colours of lights are relative to their white.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from gamutcore.errors import MissingColumnError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gamutcore.arrays import FloatArray
    from gamutcore.errors import Where

__all__ = [
    "FEWEST_BANDS",
    "Spectra",
    "are_wavelengths",
    "reflectance_scale",
    "spectral_columns",
    "wavelength",
]

FEWEST_BANDS = 8
"""Bands of a spectrum at least: with 40 nm each, the least that spans the visible range."""

_BAND = re.compile(
    r"(?:(?:SPEC|SPECTRAL|SPECTRUM|SPECTRAL_NM|NM|R|REFL|REFLECTANCE|RADIANCE)[_ ]?)?"
    r"([1-9]\d{2,3}(?:\.\d{1,3})?)(?:[_ ]?NM)?",
    re.IGNORECASE,
)
_SHORTEST, _LONGEST = 200.0, 1200.0
"""Wavelengths in nm that are taken for such; other numbers are not of optical radiation."""

_REACHES = (430.0, 650.0)
"""What a spectrum must reach on both sides for its ends to be extended to the visible range: beyond
lies less than 1 % of the luminance, and as little of a CxF file's shortest ranges (to 680 nm)."""

FRACTION_LIMIT = 2.0
"""Highest reflectance on the scale 0-1: fluorescent papers reach 1.3 (M1), and no patch set in per
cent stays below 2, as it has a paper."""


@dataclass(frozen=True, eq=False)
class Spectra:
    """Spectra of samples.

    Parameters
    ----------
    wavelengths : (b,) float
        Centres of the bands in nm, ascending.
    values : (n, b) float
        One row per sample: reflectances with 1 for the perfect diffuser, or radiances in any unit.
    kind : str
        ``"reflectance"``, ``"emission"``, or ``"unknown"`` where the device decides.
    scale : float
        What the file's values were divided by, 1 or 100, if they are reflectances.
    """

    wavelengths: FloatArray
    values: FloatArray
    kind: str = "unknown"
    scale: float = 1.0


def wavelength(name: str) -> float | None:
    """Return the wavelength that a column's name states, in nm.

    Parameters
    ----------
    name : str

    Returns
    -------
    float or None
        None if the name is not one of a spectral band.
    """
    match = _BAND.fullmatch(name.strip())
    if match is None:
        return None
    number = float(match[1])
    return number if _SHORTEST <= number <= _LONGEST else None


def are_wavelengths(cells: Sequence[str]) -> bool:
    """Return whether a row of numbers is one of column names: ascending wavelengths, even steps.

    Parameters
    ----------
    cells : sequence of str

    Returns
    -------
    bool
    """
    found = [wavelength(cell) for cell in cells]
    numbers = [number for number in found if number is not None]
    if len(numbers) < max(FEWEST_BANDS, len(found)):
        return False
    steps = {round(b - a, 3) for a, b in pairwise(numbers)}
    return len(steps) == 1 and min(steps) > 0


def spectral_columns(
    names: Sequence[str], where: Where | None = None
) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Return the columns of a spectrum in the order of their wavelengths.

    Parameters
    ----------
    names : sequence of str
        All column names.
    where : dict, optional
        Where the names stand, for errors.

    Returns
    -------
    columns : tuple of int
        Empty if fewer than `FEWEST_BANDS` columns are bands.
    wavelengths : tuple of float
        In nm, ascending.

    Raises
    ------
    MissingColumnError
        A band appears twice, or the bands do not span the visible range.
    """
    bands = [
        (number, column)
        for column, name in enumerate(names)
        if (number := wavelength(name)) is not None
    ]
    if len(bands) < FEWEST_BANDS:
        return (), ()
    bands.sort()
    for (one, _), (other, column) in pairwise(bands):
        if one == other:
            raise MissingColumnError(
                f"The band of {one:g} nm appears twice.",
                where={**(where or {}), "field": names[column]},
                remedy="Keep one spectrum, of one measurement condition.",
            )
    wavelengths = tuple(number for number, _ in bands)
    if not spans_the_visible_range(wavelengths):
        raise MissingColumnError(
            f"The spectrum runs from {wavelengths[0]:g} to {wavelengths[-1]:g} nm only.",
            where={**(where or {}), "field": names[bands[0][1]]},
            remedy=f"A spectrum must reach from {_REACHES[0]:g} nm or less to {_REACHES[1]:g} nm "
            "or more.",
        )
    return tuple(column for _, column in bands), wavelengths


def spans_the_visible_range(wavelengths: Sequence[float]) -> bool:
    """Return whether ascending wavelengths reach far enough for a colour to be computed.

    Parameters
    ----------
    wavelengths : sequence of float
        In nm.

    Returns
    -------
    bool
    """
    return wavelengths[0] <= _REACHES[0] and wavelengths[-1] >= _REACHES[1]


def reflectance_scale(values: FloatArray) -> float:
    """Return what reflectances are divided by to have 1 for the perfect diffuser.

    Parameters
    ----------
    values : (n, b) float

    Returns
    -------
    float
        1 or 100.
    """
    return 1.0 if float(values.max(initial=0.0)) <= FRACTION_LIMIT else 100.0
