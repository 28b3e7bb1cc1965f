"""Measured spectra of samples, and the names of their columns.

The name of a band has its wavelength in nm (`SPEC_380`, `SPECTRAL_NM380`, `NM_380`, `380`).
Reflectances have the scale 0-1 or per cent. The unit of emissions does not matter, because colours
of lights are relative to their white.
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
"""Minimum number of bands. Eight bands of 40 nm span the visible range."""

_BAND = re.compile(
    r"(?:(?:SPEC|SPECTRAL|SPECTRUM|SPECTRAL_NM|NM|R|REFL|REFLECTANCE|RADIANCE)[_ ]?)?"
    r"([1-9]\d{2,3}(?:\.\d{1,3})?)(?:[_ ]?NM)?",
    re.IGNORECASE,
)
_SHORTEST, _LONGEST = 200.0, 1200.0
"""Range of optical wavelengths in nm. Other numbers are not wavelengths."""

_REACHES = (430.0, 650.0)
"""Range in nm that a spectrum must cover. Less than 1 % of the luminance lies outside; the ends are
extended. The shortest ranges in CxF files end at 680 nm."""

FRACTION_LIMIT = 2.0
"""Maximum reflectance on the scale 0-1. Fluorescent papers reach 1.3 (M1). Per cent values of a
paper exceed 2."""


@dataclass(frozen=True, eq=False)
class Spectra:
    """Spectra of samples.

    Attributes
    ----------
    wavelengths : (b,) float
        Centres of the bands in nm, ascending.
    values : (n, b) float
        Reflectances (perfect diffuser 1) or radiances in any unit.
    kind : str
        ``"reflectance"``, ``"emission"``, or ``"unknown"`` if the device decides.
    scale : float
        Divisor of the values in the file if they are reflectances: 1 or 100.
    """

    wavelengths: FloatArray
    values: FloatArray
    kind: str = "unknown"
    scale: float = 1.0


def wavelength(name: str) -> float | None:
    """Return the wavelength in the name of a column, in nm; None for other names."""
    match = _BAND.fullmatch(name.strip())
    if match is None:
        return None
    number = float(match[1])
    return number if _SHORTEST <= number <= _LONGEST else None


def are_wavelengths(cells: Sequence[str]) -> bool:
    """Return whether a row of numbers consists of wavelengths, ascending in even steps."""
    found = [wavelength(cell) for cell in cells]
    numbers = [number for number in found if number is not None]
    if len(numbers) < max(FEWEST_BANDS, len(found)):
        return False
    steps = {round(b - a, 3) for a, b in pairwise(numbers)}
    return len(steps) == 1 and min(steps) > 0


def spectral_columns(
    names: Sequence[str], where: Where | None = None
) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Return the columns of a spectrum by ascending wavelength, and the wavelengths in nm.

    Both are empty if fewer than `FEWEST_BANDS` columns are bands. Repeated bands, and bands that do
    not span the visible range, are refused; `where` is the location of the names.
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
    """Return whether ascending wavelengths in nm cover enough of the visible range."""
    return wavelengths[0] <= _REACHES[0] and wavelengths[-1] >= _REACHES[1]


def reflectance_scale(values: FloatArray) -> float:
    """Return the divisor, 1 or 100, that makes reflectances (n, b) 1 for the perfect diffuser."""
    return 1.0 if float(values.max(initial=0.0)) <= FRACTION_LIMIT else 100.0
