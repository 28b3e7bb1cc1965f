"""Tristimulus values of spectra, by ASTM E308.

The colour of a spectrum is its product with a matrix of weights. The matrix combines the
colour-matching functions, the illuminant and the interpolation between bands. Bands of 5, 10 and 20
nm get the weights of ASTM E308 and E2022; other bands are interpolated to 1 nm. The perfect
diffuser gets exactly the white of CIELAB, so its L* is 100, and a* and b* are 0 (ISO 13655).
"""

from __future__ import annotations

import warnings
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.samples import reflectance_scale
from gamutcore.colours.spaces.cielab import colour_science, white_of

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = [
    "ILLUMINANTS",
    "OBSERVERS",
    "emission_xyz",
    "reflectance_xyz",
    "tristimulus_weights",
]

ILLUMINANTS = ("A", "C", "D50", "D55", "D65", "D75", "E", *(f"FL{n}" for n in range(1, 13)))
"""CIE illuminants of reflectance spectra (CIE 15:2018)."""

OBSERVERS = (2, 10)
"""Fields of view of the CIE 1931 and CIE 1964 standard observers, in degrees."""

_SHORTEST, _LONGEST = 360.0, 780.0
"""Range of the tables of ASTM E308 in nm; wavelengths beyond it have no weight."""

_TABLE_STEPS = (5.0, 10.0, 20.0)

LUMINOUS_EFFICACY = 683.0
"""Lumens per watt at the peak of V(λ) (CIE 15:2018, 7.1)."""


def reflectance_xyz(
    wavelengths: FloatArray, reflectances: FloatArray, illuminant: str, observer: int
) -> tuple[FloatArray, float]:
    """Return XYZ (n, 3) of reflecting or transmitting samples, and their scale, 1 or 100.

    `wavelengths` (b,) are ascending band centres in nm. The largest value of `reflectances` (n, b)
    shows the scale; fluorescence may exceed full scale. Y = 1 for the perfect diffuser, whose
    values are `white_of` the illuminant.

    ASTM E308-18, section 7; ISO 13655:2017, 5.
    """
    scale = reflectance_scale(reflectances)
    weights = tristimulus_weights(tuple(map(float, wavelengths)), illuminant, observer)
    white = white_of(illuminant, str(observer))
    assert white is not None  # noqa: S101 (the tables know every illuminant of ours)
    xyz: FloatArray = (reflectances / scale) @ weights * (white / weights.sum(axis=0))
    return xyz, scale


def emission_xyz(wavelengths: FloatArray, radiances: FloatArray, observer: int) -> FloatArray:
    """Return the tristimulus values (n, 3) of lights with spectral radiances (n, b).

    Y is in cd/m² for radiances in W/(m² sr nm). `wavelengths` (b,) are ascending band centres in
    nm. The weights are those of illuminant E without its normalisation (CIE 15:2018, 7.1).
    """
    matching = _matching_functions(observer)[1]
    weights = tristimulus_weights(tuple(map(float, wavelengths)), "E", observer)
    xyz: FloatArray = radiances @ weights * (LUMINOUS_EFFICACY * matching[:, 1].sum())
    return xyz


@lru_cache(maxsize=64)
def tristimulus_weights(
    wavelengths: tuple[float, ...], illuminant: str, observer: int
) -> FloatArray:
    """Return the contributions (b, 3) of the bands of a spectrum to X, Y and Z, read-only.

    `wavelengths` are ascending band centres in nm, and the sum for Y is 1. The weights of
    unmeasured wavelengths are added to those of the first and the last band (ASTM E308-18, 7.2 and
    7.3).
    """
    bands = np.array(wavelengths)
    used = (bands >= _SHORTEST) & (bands <= _LONGEST)
    weights = np.zeros((len(bands), 3))
    steps = np.unique(np.diff(bands[used]))
    in_tables = len(steps) == 1 and steps[0] in _TABLE_STEPS and not (bands[used] % steps[0]).any()
    make = _table_weights if in_tables else _interpolated_weights
    weights[used] = make(bands[used], illuminant, observer)
    weights.setflags(write=False)
    return weights


def _table_weights(bands: FloatArray, illuminant: str, observer: int) -> FloatArray:
    """Weights of the standard's own steps, by colour-science from an identity matrix."""
    colour = colour_science()
    identity = colour.MultiSpectralDistributions(np.eye(len(bands)), bands)
    with warnings.catch_warnings():
        # colour-science warns of each step of the standard
        warnings.simplefilter("ignore")
        xyz = colour.msds_to_XYZ(
            identity,
            colour.MSDS_CMFS[_observer_name(observer)],
            colour.SDS_ILLUMINANTS[illuminant],
            method="ASTM E308",
        )
    weights: FloatArray = np.asarray(xyz, dtype=np.float64) / 100.0
    return weights


def _interpolated_weights(bands: FloatArray, illuminant: str, observer: int) -> FloatArray:
    """Weights by way of 1 nm: a cubic spline between the bands, constant beyond the ends."""
    fine, matching = _matching_functions(observer)
    power = colour_science().SDS_ILLUMINANTS[illuminant]
    weighted = matching * np.interp(fine, power.wavelengths, power.values)[:, np.newaxis]
    inside = np.clip(fine, bands[0], bands[-1])
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  # 0.3 s, for uneven bands only

    splines: FloatArray = CubicSpline(bands, np.eye(len(bands)), axis=0)(inside)
    weights: FloatArray = splines.T @ weighted / weighted[:, 1].sum()
    return weights


@lru_cache(maxsize=4)
def _matching_functions(observer: int) -> tuple[FloatArray, FloatArray]:
    """Wavelengths from 360 to 780 nm and the colour-matching functions there."""
    functions = colour_science().MSDS_CMFS[_observer_name(observer)]
    wavelengths = np.asarray(functions.wavelengths, dtype=np.float64)
    used = (wavelengths >= _SHORTEST) & (wavelengths <= _LONGEST)
    return wavelengths[used], np.asarray(functions.values, dtype=np.float64)[used]


def _observer_name(observer: int) -> str:
    year = {2: 1931, 10: 1964}[observer]
    return f"CIE {year} {observer} Degree Standard Observer"
