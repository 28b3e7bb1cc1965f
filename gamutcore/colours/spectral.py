"""Tristimulus values of spectra, by ASTM E308.

A spectrum's colour is one product with a matrix of weights, which holds the colour-matching
functions, the illuminant and the interpolation between bands; it is made once for each set of
wavelengths. Bands of 5, 10 and 20 nm get the weights that ASTM E308 and E2022 define, any others
are interpolated to 1 nm. The perfect diffuser gets the very white that CIELAB is computed with, so
that its L* is 100 and its a* and b* are 0, as in ISO 13655.
"""

from __future__ import annotations

import warnings
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.spectra import reflectance_scale
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
"""CIE illuminants (CIE 15:2018) that colours can be computed for."""

OBSERVERS = (2, 10)
"""Fields of view of the CIE 1931 and CIE 1964 standard observers, in degrees."""

_SHORTEST, _LONGEST = 360.0, 780.0
"""Range of the tables of ASTM E308, in nm; what was measured beyond it has no weight."""

_TABLE_STEPS = (5.0, 10.0, 20.0)

LUMINOUS_EFFICACY = 683.0
"""Lumens per watt at the peak of V(λ) (CIE 15:2018, 7.1)."""


def reflectance_xyz(
    wavelengths: FloatArray, reflectances: FloatArray, illuminant: str, observer: int
) -> tuple[FloatArray, float]:
    """Return the tristimulus values of reflecting (or transmitting) samples.

    Parameters
    ----------
    wavelengths : (b,) float
        Centres of the bands in nm, ascending.
    reflectances : (n, b) float
        On the scale 0-1 or 0-100, told apart by the highest; above full scale for fluorescence.
    illuminant : str
        One of `ILLUMINANTS`.
    observer : int
        One of `OBSERVERS`.

    Returns
    -------
    xyz : (n, 3) float
        With Y = 1 for the perfect diffuser, whose values are `white_of` the illuminant.
    scale : float
        What the reflectances were divided by, 1 or 100.

    Notes
    -----
    ASTM E308-18, section 7; ISO 13655:2017, 5.
    """
    scale = reflectance_scale(reflectances)
    weights = tristimulus_weights(tuple(map(float, wavelengths)), illuminant, observer)
    white = white_of(illuminant, str(observer))
    assert white is not None  # noqa: S101 (the tables know every illuminant of ours)
    xyz: FloatArray = (reflectances / scale) @ weights * (white / weights.sum(axis=0))
    return xyz, scale


def emission_xyz(wavelengths: FloatArray, radiances: FloatArray, observer: int) -> FloatArray:
    """Return the tristimulus values of lights.

    Parameters
    ----------
    wavelengths : (b,) float
        Centres of the bands in nm, ascending.
    radiances : (n, b) float
        Spectral radiances; in W/(m² sr nm), Y is a luminance in cd/m².
    observer : int
        One of `OBSERVERS`.

    Returns
    -------
    (n, 3) float

    Notes
    -----
    CIE 15:2018, 7.1. The weights of illuminant E are those of no illuminant; its normalisation is
    taken out again.
    """
    matching = _matching_functions(observer)[1]
    weights = tristimulus_weights(tuple(map(float, wavelengths)), "E", observer)
    xyz: FloatArray = radiances @ weights * (LUMINOUS_EFFICACY * matching[:, 1].sum())
    return xyz


@lru_cache(maxsize=64)
def tristimulus_weights(
    wavelengths: tuple[float, ...], illuminant: str, observer: int
) -> FloatArray:
    """Return what the bands of a spectrum contribute to X, Y and Z.

    Parameters
    ----------
    wavelengths : tuple of b float
        Centres of the bands in nm, ascending.
    illuminant : str
        One of `ILLUMINANTS`.
    observer : int
        One of `OBSERVERS`.

    Returns
    -------
    (b, 3) float
        With a sum of 1 for Y. Not to be changed: it is kept for the next spectrum.

    Notes
    -----
    ASTM E308-18, 7.2 and 7.3: the weights of wavelengths that were not measured are added to those
    of the first and the last band that was.
    """
    places = np.array(wavelengths)
    used = (places >= _SHORTEST) & (places <= _LONGEST)
    weights = np.zeros((len(places), 3))
    steps = np.unique(np.diff(places[used]))
    in_tables = len(steps) == 1 and steps[0] in _TABLE_STEPS and not (places[used] % steps[0]).any()
    make = _table_weights if in_tables else _interpolated_weights
    weights[used] = make(places[used], illuminant, observer)
    weights.setflags(write=False)
    return weights


def _table_weights(places: FloatArray, illuminant: str, observer: int) -> FloatArray:
    """Return the weights of the standard's own steps, by colour-science: once on an identity."""
    colour = colour_science()
    identity = colour.MultiSpectralDistributions(np.eye(len(places)), places)
    with warnings.catch_warnings():
        # It warns of each step that the standard prescribes.
        warnings.simplefilter("ignore")
        xyz = colour.msds_to_XYZ(
            identity,
            colour.MSDS_CMFS[_observer_name(observer)],
            colour.SDS_ILLUMINANTS[illuminant],
            method="ASTM E308",
        )
    weights: FloatArray = np.asarray(xyz, dtype=np.float64) / 100.0
    return weights


def _interpolated_weights(places: FloatArray, illuminant: str, observer: int) -> FloatArray:
    """Return weights by way of 1 nm: a cubic spline between the bands, the ends held beyond."""
    fine, matching = _matching_functions(observer)
    power = colour_science().SDS_ILLUMINANTS[illuminant]
    weighted = matching * np.interp(fine, power.wavelengths, power.values)[:, np.newaxis]
    inside = np.clip(fine, places[0], places[-1])
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  # a third of a second

    bands: FloatArray = CubicSpline(places, np.eye(len(places)), axis=0)(inside)
    weights: FloatArray = bands.T @ weighted / weighted[:, 1].sum()
    return weights


@lru_cache(maxsize=4)
def _matching_functions(observer: int) -> tuple[FloatArray, FloatArray]:
    """Return wavelengths from 360 to 780 nm and the colour-matching functions at them."""
    functions = colour_science().MSDS_CMFS[_observer_name(observer)]
    wavelengths = np.asarray(functions.wavelengths, dtype=np.float64)
    used = (wavelengths >= _SHORTEST) & (wavelengths <= _LONGEST)
    return wavelengths[used], np.asarray(functions.values, dtype=np.float64)[used]


def _observer_name(observer: int) -> str:
    year = {2: 1931, 10: 1964}[observer]
    return f"CIE {year} {observer} Degree Standard Observer"
