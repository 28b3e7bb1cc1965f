"""The appearance of colours on an sRGB display, for the vertex colours of meshes.

CIELAB with ICC's D50 is adapted to D65 by the Bradford transform and clipped to the gamut of sRGB.
Vertex colours are for display only; the positions are the data.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, PositionArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["linear_srgb", "srgb"]

D50_TO_LINEAR_SRGB = np.array(
    [
        [3.134186364, -1.617208959, -0.490694064],
        [-0.978748504, 1.916130097, 0.033433399],
        [0.071963928, -0.228993873, 1.405753733],
    ]
)
"""XYZ relative to ICC's D50 → linear sRGB: Bradford (ICC.1:2022, annex E) to D65, then the
inverse of the matrix of the sRGB primaries (IEC 61966-2-1). The tests derive it with
colour-science."""

WHITE_X, WHITE_Z = 0.9642, 0.8249  # ICC.1:2022, 7.2.16


@leaf_kernel
def _inverse_f(value: float) -> float:
    """Inverse of CIELAB's f (CIE 15:2018, 8.2.1.1) with its linear part."""
    return value * value * value if value > 6.0 / 29.0 else (value - 4.0 / 29.0) * 108.0 / 841.0


def linear_srgb(lab: PositionArray) -> FloatArray:
    """Return linear sRGB of CIELAB colours, clipped to the gamut of sRGB.

    Parameters
    ----------
    lab : (n, 3) float
        L*, a*, b* with ICC's D50 as white.

    Returns
    -------
    (n, 3) float64
        Red, green, blue in 0 to 1.

    Examples
    --------
    >>> linear_srgb(np.array([[100.0, 0.0, 0.0]])).round(3).tolist()
    [[1.0, 1.0, 1.0]]
    """
    return _linear_srgb(np.ascontiguousarray(lab, np.float64))


@kernel
def _linear_srgb(lab: FloatArray) -> FloatArray:
    result = np.empty((len(lab), 3), np.float64)
    for row in range(len(lab)):
        middle = (lab[row, 0] + 16.0) / 116.0
        x = WHITE_X * _inverse_f(middle + lab[row, 1] / 500.0)
        y = _inverse_f(middle)
        z = WHITE_Z * _inverse_f(middle - lab[row, 2] / 200.0)
        for channel in range(3):
            value = (
                D50_TO_LINEAR_SRGB[channel, 0] * x
                + D50_TO_LINEAR_SRGB[channel, 1] * y
                + D50_TO_LINEAR_SRGB[channel, 2] * z
            )
            result[row, channel] = min(max(value, 0.0), 1.0)
    return result


def srgb(lab: PositionArray) -> FloatArray:
    """Return sRGB of CIELAB colours, encoded by its transfer function (IEC 61966-2-1) and clipped.

    Parameters
    ----------
    lab : (n, 3) float
        L*, a*, b* with ICC's D50 as white.

    Returns
    -------
    (n, 3) float64
        Red, green, blue in 0 to 1.
    """
    return _encoded_srgb(linear_srgb(lab))


@kernel
def _encoded_srgb(linear: FloatArray) -> FloatArray:
    result = np.empty(linear.shape)
    for row in range(len(result)):
        for channel in range(3):
            value = linear[row, channel]
            result[row, channel] = (
                12.92 * value if value <= 0.0031308 else 1.055 * value ** (1.0 / 2.4) - 0.055
            )
    return result
