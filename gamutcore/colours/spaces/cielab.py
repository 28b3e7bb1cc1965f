"""CIEXYZ to CIELAB and back, by colour-science, relative to the D50 of ICC profiles.

The D50 of the ICC (X 0.9642, Y 1, Z 0.8249) is used everywhere. It differs from that of
colour-science in the fourth digit. colour-science takes most of a second and 40 MB to import, so
only this module imports it, on first use.
"""

from __future__ import annotations

import sys
import warnings
from functools import cache
from threading import Lock
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = ["ICC_D50", "colour_science", "lab_to_xyz", "white_of", "xyz_to_lab"]

ICC_D50: FloatArray = np.array([0.9642, 1.0, 0.8249])
"""XYZ of the illuminant of the profile connection space (ICC.1:2022, 7.2.16), Y = 1."""
ICC_D50.setflags(write=False)

_IMPORT = Lock()


@cache
def colour_science() -> ModuleType:
    """Return the module `colour` of colour-science, imported on first use.

    Returns
    -------
    module

    Notes
    -----
    Without matplotlib, colour-science 0.4 puts MagicMock objects in its place in `sys.modules`, and
    other packages then take it as installed. They are removed here; colour-science keeps its own
    references. Its warning about matplotlib is suppressed.
    """
    from unittest.mock import MagicMock  # noqa: PLC0415  # colour-science imports it as well

    with _IMPORT:
        before = set(sys.modules)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import colour  # noqa: PLC0415 (0.7 s, and only where colour is computed)
        for name in set(sys.modules) - before:
            if isinstance(sys.modules[name], MagicMock):
                del sys.modules[name]
    return colour


def xyz_to_lab(xyz: FloatArray, white: FloatArray = ICC_D50) -> FloatArray:
    """Return CIELAB of tristimulus values.

    Parameters
    ----------
    xyz : (..., 3) float
        X, Y, Z, with Y = 1 for the white.
    white : (3,) float
        X, Y, Z of the reference white; ICC's D50 by default.

    Returns
    -------
    (..., 3) float
        L* (0 to 100), a*, b*. The linear part of CIELAB continues for negative tristimulus values.

    Notes
    -----
    CIE 15:2018, equations 8.3 to 8.8.

    Examples
    --------
    >>> xyz_to_lab(ICC_D50).round(3).tolist()
    [100.0, 0.0, 0.0]
    """
    lab = colour_science().XYZ_to_Lab(np.asarray(xyz, dtype=np.float64), _xy(white))
    return np.ascontiguousarray(lab, dtype=np.float64)


def lab_to_xyz(lab: FloatArray, white: FloatArray = ICC_D50) -> FloatArray:
    """Return the tristimulus values of CIELAB colours.

    Parameters
    ----------
    lab : (..., 3) float
        L* (0 to 100), a*, b*.
    white : (3,) float
        X, Y, Z of the reference white; ICC's D50 by default.

    Returns
    -------
    (..., 3) float
        X, Y, Z, with Y = 1 for the white.

    Notes
    -----
    CIE 15:2018, equations 8.9 to 8.14.
    """
    xyz = colour_science().Lab_to_XYZ(np.asarray(lab, dtype=np.float64), _xy(white))
    return np.ascontiguousarray(xyz, dtype=np.float64)


def white_of(illuminant: str, observer: str) -> FloatArray | None:
    """Return XYZ of a CIE illuminant for a standard observer.

    Parameters
    ----------
    illuminant : str
        Name as in CIE 15, such as ``"D50"``, ``"A"`` or ``"F11"`` (or ``"FL11"``).
    observer : str
        ``"2"`` or ``"10"``, degrees.

    Returns
    -------
    (3,) float or None
        With Y = 1; ICC's values for D50 and 2°; None for an unknown name.
    """
    name = illuminant.upper()
    if name == "D50" and observer == "2":
        return ICC_D50
    standard = "CIE 1931 2 Degree" if observer == "2" else "CIE 1964 10 Degree"
    table = colour_science().CCS_ILLUMINANTS[f"{standard} Standard Observer"]
    chromaticity = table.get(name, table.get(name.replace("F", "FL", 1)))
    if chromaticity is None:
        return None
    x, y = (float(value) for value in chromaticity)
    return np.array([x / y, 1.0, (1 - x - y) / y])


def _xy(white: FloatArray) -> FloatArray:
    return np.array([white[0], white[1]]) / float(white.sum())
