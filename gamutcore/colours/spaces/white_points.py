"""White points by name, and chromatic adaptation from one white to another.

Colours arrive relative to ICC's D50, and each space has its own white. They are adapted by a linear
von Kries transform, which scales cone-like responses by the ratio of those of the whites. Such
transforms with one matrix compose, so adaptation by way of D50 equals adaptation in one step from
the measured white.

This module does not use colour-science: the service imports it to serve meshes.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from gamutcore.arrays import FloatArray

__all__ = [
    "ADAPTATIONS",
    "WHITES",
    "adaptation_matrix",
    "adaptation_text",
    "chromaticity_xyz",
    "rgb_to_xyz",
    "white_point",
]

WHITES: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "A": (0.44758, 0.40745),
        "C": (0.31006, 0.31616),
        "D50": (0.34567, 0.35851),  # of ICC profiles; CIE 15 has y 0.3585
        "D55": (0.33243, 0.34744),
        "D60": (0.32168, 0.33767),  # ACES' white, SMPTE ST 2065-1
        "D65": (0.3127, 0.3290),  # as in ITU-R BT.709 and BT.2100, IEC 61966-2-1
        "D75": (0.29903, 0.31488),
        "DCI": (0.314, 0.351),  # of theatres, SMPTE RP 431-2
        "E": (1 / 3, 1 / 3),
    }
)
"""Chromaticities x, y for the CIE 1931 observer (CIE 15:2018, tables 11.3 and T.3)."""

_ICC_D50 = (0.9642, 1.0, 0.8249)  # ICC.1:2022, 7.2.16

ADAPTATIONS: Mapping[str, tuple[tuple[float, float, float], ...] | None] = MappingProxyType(
    {
        "Bradford": (
            (0.8951, 0.2664, -0.1614),
            (-0.7502, 1.7135, 0.0367),
            (0.0389, -0.0685, 1.0296),
        ),
        "CAT02": (
            (0.7328, 0.4296, -0.1624),
            (-0.7036, 1.6975, 0.0061),
            (0.0030, 0.0136, 0.9834),
        ),
        "CAT16": (
            (0.401288, 0.650173, -0.051461),
            (-0.250268, 1.204414, 0.045854),
            (-0.002079, 0.048952, 0.953127),
        ),
        "von-Kries": (
            (0.40024, 0.70760, -0.08081),
            (-0.22630, 1.16532, 0.04570),
            (0.0, 0.0, 0.91822),
        ),
        "XYZ-scaling": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        "none": None,
    }
)
"""Matrices from tristimulus values to cone-like responses. Bradford: ICC.1:2022, annex E. CAT02:
CIE 159:2004. CAT16: Li et al. 2017. von Kries: Hunt, Pointer and Estévez's cones, D65 normalised
(Fairchild 2013, chapter 9). None leaves the values unchanged."""


def white_point(name: str) -> FloatArray:
    """Return X, Y, Z (3,) of a white of `WHITES`, with Y = 1; ICC's values for D50."""
    if name == "D50":
        return np.array(_ICC_D50)
    return chromaticity_xyz(*WHITES[name])


def chromaticity_xyz(x: float, y: float) -> FloatArray:
    """Return the tristimulus values, (3,), of a chromaticity, with Y = 1."""
    return np.array([x / y, 1.0, (1 - x - y) / y])


def rgb_to_xyz(primaries: Iterable[tuple[float, float]], white: FloatArray) -> FloatArray:
    """Return the matrix (3, 3) from linear RGB to tristimulus values: ``matrix @ rgb``.

    Primaries are the chromaticities of red, green and blue. The white is X, Y, Z of equal red,
    green and blue of 1 (SMPTE RP 177).
    """
    columns = np.column_stack([chromaticity_xyz(*primary) for primary in primaries])
    matrix: FloatArray = columns * np.linalg.solve(columns, white)
    return matrix


def adaptation_matrix(source: FloatArray, target: FloatArray, adaptation: str) -> FloatArray:
    """Return the matrix (3, 3) that adapts colours from one white to another: ``matrix @ xyz``.

    The whites are X, Y, Z in any common scale, all positive. "none" gives the identity.
    """
    cones = ADAPTATIONS[adaptation]
    if cones is None or np.array_equal(source, target):
        return np.eye(3)
    matrix = np.array(cones)
    scaled: FloatArray = np.linalg.solve(
        matrix, ((matrix @ target) / (matrix @ source))[:, np.newaxis] * matrix
    )
    return scaled


def adaptation_text(adaptation: str, white: str) -> str:
    """Describe the adaptation of colours from a white, in words, to D50."""
    return "none, as asked" if adaptation == "none" else f"{adaptation} from {white} to D50"
