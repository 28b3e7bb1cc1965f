"""CIEXYZ to CIELAB and back, relative to the D50 of ICC profiles, and adaptation to that white.

The D50 of the ICC (X 0.9642, Y 1, Z 0.8249) is used everywhere. It differs from that of
colour-science in the fourth digit. colour-science has the tables of illuminants and observers. It
takes 1.2 s and 80 MB to import, so only this module imports it, for data that needs the tables.
"""

from __future__ import annotations

import sys
import warnings
from functools import cache
from threading import Lock
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces.formulas import Cielab
from gamutcore.colours.spaces.white_points import adaptation_matrix, chromaticity_xyz

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = [
    "ICC_D50",
    "adaptation_to_d50",
    "colour_science",
    "lab_to_xyz",
    "white_of",
    "xyz_to_lab",
]

ICC_D50: FloatArray = np.array([0.9642, 1.0, 0.8249])
"""XYZ of the illuminant of the profile connection space (ICC.1:2022, 7.2.16), Y = 1."""
ICC_D50.setflags(write=False)

_IMPORT = Lock()


@cache
def colour_science() -> ModuleType:
    """Return the module `colour` of colour-science, imported on first use.

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
    values = np.asarray(xyz, np.float64)
    lab, _ = Cielab(white / white[1]).coordinates(values.reshape(-1, 3))
    return lab.reshape(values.shape)


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
    values = np.asarray(lab, np.float64)
    return Cielab(white / white[1]).xyz(values.reshape(-1, 3)).reshape(values.shape)


def adaptation_to_d50(xyz: FloatArray, white: FloatArray, adaptation: str) -> FloatArray:
    """Return colours (n, 3) adapted from a white to ICC's D50, with Y = 1 for that white.

    The white (3,) is in the scale of the colours.
    """
    adapted: FloatArray = (
        xyz / white[1] @ adaptation_matrix(white / white[1], ICC_D50, adaptation).T
    )
    return adapted


def white_of(illuminant: str, observer: str) -> FloatArray | None:
    """Return XYZ (3,) of a CIE illuminant for a standard observer, ``"2"`` or ``"10"`` degrees.

    Names are as in CIE 15, such as ``"D50"``, ``"A"`` or ``"F11"`` (or ``"FL11"``). Y is 1; D50 and
    2° give ICC's values; an unknown name gives None.
    """
    name = illuminant.upper()
    if name == "D50" and observer == "2":
        return ICC_D50
    standard = "CIE 1931 2 Degree" if observer == "2" else "CIE 1964 10 Degree"
    table = colour_science().CCS_ILLUMINANTS[f"{standard} Standard Observer"]
    chromaticity = table.get(name, table.get(name.replace("F", "FL", 1)))
    if chromaticity is None:
        return None
    return chromaticity_xyz(*(float(value) for value in chromaticity))
