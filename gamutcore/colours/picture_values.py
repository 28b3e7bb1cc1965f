"""Channel values of a picture for colours: the inverse of `picture_colours`.

Profiles have no inverse transform that is exact to 16 bits, so the values are searched with the
forward transform, by the method of Levenberg and Marquardt. The search begins at values that a
picture has and ends within its range: the result is the nearest colour that it finds there.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gamutcore.arrays import FloatArray

__all__ = ["find_values"]

ACCURACY = 1e-4
"""Distance in CIELAB at which a search ends: a fifteenth of a step of 16 bits."""

STEP = 1.0 / 1024.0
"""Difference of values for slopes. It has a slope at black also where the curve is a power."""

MOST_STEPS = 40


def find_values(
    lab: FloatArray,
    start: FloatArray,
    colours: Callable[[FloatArray], FloatArray],
    lowest: float = 0.0,
    highest: float = 1.0,
) -> tuple[FloatArray, FloatArray]:
    """Return values (n, 3) in the range whose colours are nearest to `lab`, and the distances (n,).

    `colours` maps values (m, 3) to CIELAB, and `start` is in the range. Distances are Euclidean.
    Values that would leave the range are held at its end.

    K. Levenberg, Quarterly of Applied Mathematics 2 (1944); D. W. Marquardt, SIAM Journal 11
    (1963).
    """
    values = np.clip(start, lowest, highest)
    if len(values) == 0:
        return values, np.empty(0)
    residual = lab - colours(values)
    distance = np.linalg.norm(residual, axis=1)
    damping = np.full(len(lab), 1e-3)
    for _ in range(MOST_STEPS):
        active = np.flatnonzero((distance > ACCURACY) & (damping < 1e6))
        if len(active) == 0:
            break
        at, wanted, left = values[active], lab[active], residual[active]
        slopes = _slopes(at, wanted - left, colours, highest)
        pull = np.einsum("nij,ni->nj", slopes, left)
        held = ((at <= lowest) & (pull < 0.0)) | ((at >= highest) & (pull > 0.0))
        slopes[np.broadcast_to(held[:, np.newaxis, :], slopes.shape)] = 0.0
        pull[held] = 0.0
        normal = np.einsum("nij,nik->njk", slopes, slopes)
        size = np.maximum(np.einsum("nii->n", normal) / 3.0, 1e-12)
        normal += (damping[active] * size)[:, np.newaxis, np.newaxis] * np.eye(3)
        step = np.linalg.solve(normal, pull[:, :, np.newaxis])[:, :, 0]
        tried = np.clip(at + step, lowest, highest)
        rest = wanted - colours(tried)
        length = np.linalg.norm(rest, axis=1)
        better = length < distance[active]
        kept = active[better]
        values[kept], residual[kept], distance[kept] = tried[better], rest[better], length[better]
        damping[active] *= np.where(better, 0.1, 10.0)
    return values, distance


def _slopes(
    values: FloatArray,
    lab: FloatArray,
    colours: Callable[[FloatArray], FloatArray],
    highest: float,
) -> FloatArray:
    """Return the derivatives (n, 3 of the colour, 3 of the values) by differences."""
    slopes = np.empty((len(values), 3, 3))
    for channel in range(3):
        step = np.where(values[:, channel] + STEP > highest, -STEP, STEP)
        moved = values.copy()
        moved[:, channel] += step
        slopes[:, :, channel] = (colours(moved) - lab) / step[:, np.newaxis]
    return slopes
