"""White points, chromatic adaptation, CIELAB and the black point: the colorimetry of all folders.

Colours arrive relative to the D50 of ICC profiles (X 0.9642, Y 1, Z 0.8249), which differs from
that of colour-science in the fourth digit. They are adapted to other whites by a linear von Kries
transform, which scales cone-like responses by the ratio of those of the whites. Such transforms
with one matrix compose, so adaptation by way of D50 equals adaptation in one step.

colour-science has the tables of illuminants and observers. It takes 1.2 s and 80 MB to import, so
it is imported on first use, for data that needs the tables.
"""

from __future__ import annotations

import sys
import warnings
from functools import cache
from threading import Lock
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from gamutcore.arrays import FloatArray

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
        return ICC_D50.copy()
    return chromaticity_xyz(*WHITES[name])


def chromaticity_xyz(x: float, y: float) -> FloatArray:
    """Return the tristimulus values, (3,), of a chromaticity, with Y = 1."""
    return np.array([x / y, 1.0, (1 - x - y) / y])


def rgb_to_xyz(primaries: Iterable[tuple[float, float]], white: FloatArray) -> FloatArray:
    """Return the matrix (3, 3) from linear RGB to tristimulus values: ``matrix @ rgb``.

    Primaries are the chromaticities of red, green and blue. The white is X, Y, Z of equal red,
    green and blue of 1 (SMPTE RP 177).
    """
    # a primary is a direction: y = 0 has no luminance, such as X and Z of CIE XYZ
    columns = np.column_stack(
        [chromaticity_xyz(x, y) if y else np.array([x, 0.0, 1 - x]) for x, y in primaries]
    )
    matrix: FloatArray = columns * np.linalg.solve(columns, white)
    return matrix


def decode_srgb(values: FloatArray) -> FloatArray:
    """Return linear values, 0 or more, of values encoded by sRGB (IEC 61966-2-1, 5.2)."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def encode_srgb(linear: FloatArray) -> FloatArray:
    """Return the encoded values of linear ones; the inverse of `decode_srgb`."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


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
    """Return CIELAB (..., 3) of tristimulus values (CIE 15:2018, equations 8.3 to 8.8).

    The linear part continues for negative tristimulus values.

    Parameters
    ----------
    xyz : (..., 3) float
        X, Y, Z, with Y = 1 for the white.
    white : (3,) float
        X, Y, Z of the reference white.

    Examples
    --------
    >>> xyz_to_lab(ICC_D50).round(3).tolist()
    [100.0, 0.0, 0.0]
    """
    ratio = np.asarray(xyz, np.float64) / (white / white[1])
    values = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio * (841 / 108) + 4 / 29)
    x, y, z = np.moveaxis(values, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def lab_to_xyz(lab: FloatArray, white: FloatArray = ICC_D50) -> FloatArray:
    """Return the tristimulus values of CIELAB colours, (..., 3); the inverse of `xyz_to_lab`."""
    lightness, a, b = np.moveaxis(np.asarray(lab, np.float64), -1, 0)
    y = (lightness + 16) / 116
    values = np.stack([y + a / 500, y, y - b / 200], axis=-1)
    ratio = np.where(values > 6 / 29, values**3, (values - 4 / 29) * (108 / 841))
    xyz: FloatArray = ratio * (white / white[1])
    return xyz


def adaptation_to_d50(xyz: FloatArray, white: FloatArray, adaptation: str) -> FloatArray:
    """Return colours (n, 3) adapted from a white to ICC's D50, with Y = 1 for that white.

    The white (3,) is in the scale of the colours.
    """
    matrix = adaptation_matrix(white / white[1], ICC_D50, adaptation)
    adapted: FloatArray = xyz / white[1] @ matrix.T
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


LIGHTEST_BLACK = 0.184187
"""Luminance of L* 50, to which both publications limit blacks."""


def luminance_of_black(xyz: FloatArray) -> float:
    """Return the luminance of the neutral that stands for a black; xyz is (3,), and white has 1."""
    return float(np.clip(xyz[1], 0.0, LIGHTEST_BLACK))


def compensate_black(xyz: FloatArray, source: float, destination: float) -> FloatArray:
    """Return tristimulus values (n, 3) with another black; white is unchanged.

    Values are relative to D50, with Y = 1 for the white. `source` and `destination` are the
    luminances of the two blacks, which are neutral.
    """
    scale = (1.0 - destination) / (1.0 - source)
    return scale * xyz + (1.0 - scale) * ICC_D50
