"""Triangles filled with interpolated colours, with a depth buffer.

Colours are linear, so the mean of the samples of a pixel is the light of the pixel. Samples lie in
the middles of a fine grid. The picture is computed in bands of rows, which bounds the memory.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["BAND_SAMPLES", "rasterise"]

SLACK = 1.0
"""Samples by which the ends of a row are extended before each sample is tested."""

TOLERANCE = 1e-9
"""Largest negative weight of a sample that counts as on the edge."""

BAND_SAMPLES = 2**21
"""Samples of a band: 34 MB of depths and colours."""


def rasterise(corners: FloatArray, colours: Float32Array, size: int, samples: int) -> Float32Array:
    """Return red, green and blue times coverage, and coverage, (size, size, 4), of every pixel.

    `corners` (n, 3, 3) are x to the right, y downwards, both in pixels, and the height towards the
    viewer. Triangles may have any orientation; of several, the highest is seen. `colours` (n, 3, 3)
    are linear. A pixel has `samples` samples in each direction.
    """
    rows = max(1, BAND_SAMPLES // (size * samples * samples))
    fine = np.ascontiguousarray(corners * (samples, samples, 1.0))
    pixels = np.empty((size, size, 4), np.float32)
    for first in range(0, size, rows):
        band = pixels[first : first + rows]
        _fill_band(fine, colours, first, samples, band)
    return pixels


@leaf_kernel
def _cut(
    left: float,
    right: float,
    x0: float,
    y0: float,
    x1: float,
    y1: float,
    y: float,
    area: float,
) -> tuple[float, float]:
    """Cut the part of a row that is on the inner side of an edge.

    Without it, the time for thin triangles would be that of the boxes around them.
    """
    rise = y1 - y0
    if rise == 0.0:
        return left, right
    crossing = x0 + (y - y0) * (x1 - x0) / rise
    if (rise > 0.0) == (area > 0.0):
        return left, min(right, crossing)
    return max(left, crossing), right


@kernel
def _fill_band(
    corners: FloatArray, colours: Float32Array, first: int, samples: int, band: Float32Array
) -> None:
    rows, columns = band.shape[0] * samples, band.shape[1] * samples
    top = first * samples
    depth = np.full((rows, columns), -np.inf, np.float32)
    light = np.zeros((rows, columns, 3), np.float32)
    for triangle in range(len(corners)):
        x0, y0, z0 = corners[triangle, 0]
        x1, y1, z1 = corners[triangle, 1]
        x2, y2, z2 = corners[triangle, 2]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area == 0.0:
            continue
        # samples have their middles at half numbers
        low_row = max(int(np.ceil(min(y0, y1, y2) - 0.5)) - top, 0)
        high_row = min(int(np.floor(max(y0, y1, y2) - 0.5)) - top, rows - 1)
        leftmost, rightmost = min(x0, x1, x2), max(x0, x1, x2)
        for row in range(low_row, high_row + 1):
            y = row + top + 0.5
            left, right = leftmost, rightmost
            left, right = _cut(left, right, x1, y1, x2, y2, y, area)
            left, right = _cut(left, right, x2, y2, x0, y0, y, area)
            left, right = _cut(left, right, x0, y0, x1, y1, y, area)
            low_column = max(int(np.ceil(left - SLACK)), 0)
            high_column = min(int(np.floor(right + SLACK)), columns - 1)
            for column in range(low_column, high_column + 1):
                x = column + 0.5
                first_weight = ((x1 - x) * (y2 - y) - (x2 - x) * (y1 - y)) / area
                second_weight = ((x2 - x) * (y0 - y) - (x0 - x) * (y2 - y)) / area
                third_weight = 1.0 - first_weight - second_weight
                if min(first_weight, second_weight, third_weight) < -TOLERANCE:
                    continue
                height = np.float32(first_weight * z0 + second_weight * z1 + third_weight * z2)
                if height > depth[row, column]:
                    depth[row, column] = height
                    for channel in range(3):
                        light[row, column, channel] = (
                            first_weight * colours[triangle, 0, channel]
                            + second_weight * colours[triangle, 1, channel]
                            + third_weight * colours[triangle, 2, channel]
                        )
    share = np.float32(1.0 / (samples * samples))
    for row in range(band.shape[0]):
        for column in range(band.shape[1]):
            covered, red, green, blue = 0, 0.0, 0.0, 0.0
            for down in range(row * samples, (row + 1) * samples):
                for right in range(column * samples, (column + 1) * samples):
                    if depth[down, right] > -np.inf:
                        covered += 1
                        red += light[down, right, 0]
                        green += light[down, right, 1]
                        blue += light[down, right, 2]
            band[row, column, 0] = red * share
            band[row, column, 1] = green * share
            band[row, column, 2] = blue * share
            band[row, column, 3] = covered * share
