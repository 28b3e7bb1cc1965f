"""Warnings about colours that no measurement supports, or that no surface can have.

A device model also answers far from its samples, and a profile may contain any number. Unusual
gamuts are never refused, but the description says what is unusual: device values far from all
samples, colours outside the optimal colour solid, and lightness outside 0 to 100.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.colorimetry import ICC_D50, lab_to_xyz

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation import Samples
    from gamutcore.colours.ink_limits import LimitedCube

_FAR = 0.5
"""Distance of a corner from the nearest sample at which the corner is far: half of an edge of the
device cube. Charts of displays and presses measure the corners themselves."""

_EXCESS = 1.1
"""Ratio of volumes above which a gamut is called larger than its samples. Presses and displays that
were measured at their corners have 0.99 to 1.04."""

_HULL_POINTS = 10_000
"""Largest number of points whose convex hull is computed, which takes 0.02 s."""

_TESTED = 2000
"""Largest number of colours that are compared with the optimal colour solid, which takes 0.01 s."""

_OUTSIDE = 0.005
"""Distance from the solid in X, Y, Z (white: Y = 1) above which a colour counts as outside: 1 to 3
ΔE*ab at L* 50. It allows for rounding, and for colours that were measured for another illuminant or
observer and adapted to D50."""

_BANDS = 1e-5 * np.array([
    [76, 233, 775, 1619, 2451, 2772, 2498, 1718, 860, 283, 40, 88, 594, 1589, 2800, 4204, 5657,
     7135, 8533, 9269, 9833, 9464, 8006, 5932, 4168, 2611, 1541, 854, 433, 194, 191],
    [2, 6, 23, 66, 162, 313, 514, 798, 1238, 1841, 2947, 4632, 6591, 8302, 9199, 9645, 9472,
     8905, 8105, 6839, 5837, 4751, 3572, 2446, 1628, 985, 570, 312, 157, 70, 69],
    [359, 1110, 3722, 7901, 12301, 14618, 14338, 11304, 7302, 4132, 2466, 1447, 737, 401, 196,
     85, 37, 20, 15, 10, 7, 4, 2, 1, 0, 0, 0, 0, 0, 0, 0],
])  # fmt: skip
"""Tristimulus values of 31 bands from 400 to 700 nm, for D50 and 2°: weights of ASTM E308-18 for
steps of 10 nm, with 1 as the sum of Y. The bands at both ends include those beyond. This table
spares most builds the import of colour-science, which takes a second."""

_LIGHTNESS = 0.5
"""Excess of L* over 0 to 100 that is not a warning: fits to measured whites overshoot by less."""


def range_warnings(samples: Samples, device: FloatArray, limited: LimitedCube) -> list[str]:
    """Return warnings about parts of the range of channels that were not measured.

    `device` has the samples' distinct device values, (n, k), 0 to 1.
    """
    warnings = [
        f"{channel} was measured only from {100 * low:.3g} to {100 * high:.3g} %; the gamut covers "
        "that range."
        for channel, low, high in zip(
            samples.channels, device.min(axis=0), device.max(axis=0), strict=True
        )
        if low > 0.005 or high < 0.995
    ]
    full = float(limited.base[~limited.free].sum() + limited.cube.largest_sum)
    most = float(device.sum(axis=1).max())
    if not samples.additive and most < 0.99 * full:
        warnings.append(
            f"The largest measured sum of inks is {100 * most:.0f} %; colours up to "
            f"{100 * full:.0f} % are extrapolated."
        )
    return warnings


def extrapolation_warnings(
    corners: FloatArray,
    device: FloatArray,
    points: FloatArray,
    measured: FloatArray,
) -> list[str]:
    """Return warnings about the part of a gamut that no sample supports.

    Warnings arise if a corner (c, k) of the cube is farther than half a channel's range from all
    samples `device` (n, k), or if the convex hull of `points` is clearly larger than that of
    `measured`.
    """
    from scipy.spatial import cKDTree  # noqa: PLC0415  # slow; only device models need it

    distances, _ = cKDTree(device).query(corners, distance_upper_bound=_FAR)
    far = int(np.isinf(distances).sum())
    own = _hull_volume(measured)
    ratio = _hull_volume(_thinned(points, _HULL_POINTS)) / own if own > 0 else 1.0
    warnings = []
    if far:
        warnings.append(
            f"{far} of the {len(corners)} corners of the device cube are farther from all samples "
            "than half the range of a channel; the gamut is extrapolated there."
        )
    if far or ratio > _EXCESS:
        warnings.append(
            f"The convex hull of the gamut has {ratio:.2f} times the volume of the convex hull of "
            "the measured colours."
        )
    return warnings


def _hull_volume(colours: FloatArray) -> float:
    """Volume of the convex hull of colours; 0 if they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  # as above

    try:
        return float(ConvexHull(colours).volume)
    except (QhullError, ValueError):
        return 0.0


def _thinned(colours: FloatArray, most: int) -> FloatArray:
    """Return evenly chosen rows, at most `most`."""
    return colours[:: -(-len(colours) // most)]


def impossible_colour_warnings(lab: FloatArray, *, lights: bool) -> list[str]:
    """Return warnings about colours (m, 3) in CIELAB that no surface, or no light, can have."""
    warnings = []
    beyond = (lab[:, 0] < -_LIGHTNESS) | (lab[:, 0] > 100.0 + _LIGHTNESS)
    if beyond.any():
        low, high = float(lab[:, 0].min()), float(lab[:, 0].max())
        warnings.append(
            f"{int(beyond.sum())} of {len(lab)} colours have an L* outside 0 to 100: from "
            f"{low:.1f} to {high:.1f}."
        )
    if lights:
        return warnings
    middle, normals, supports = _optimal_colour_solid()
    away = lab_to_xyz(_thinned(lab, _TESTED)) - middle
    outside = (np.abs(away @ normals.T) - supports).max(axis=1) > _OUTSIDE
    if outside.any():
        warnings.append(
            f"{100 * outside.mean():.3g} % of the colours are outside the optimal colour solid "
            "(D50, 2°). No reflecting surface can have them."
        )
    return warnings


@lru_cache(maxsize=1)
def _optimal_colour_solid() -> tuple[FloatArray, FloatArray, FloatArray]:
    """The middle (3,) of the optimal colour solid in XYZ, normals of its faces and their distances.

    Reflectances of 0 to 1 in bands of 10 nm have the colours of a zonotope: the sum of one segment
    for each band. Two bands span each pair of opposite faces, of which one is returned.
    """
    bands = _BANDS.T * (ICC_D50 / _BANDS.sum(axis=1))
    first, second = np.triu_indices(len(bands), 1)
    normals = np.cross(bands[first], bands[second])
    lengths = np.linalg.norm(normals, axis=1)
    # Bands at the ends of the spectrum have nearly the same chromaticity and span no face.
    normals = normals[lengths > 1e-12] / lengths[lengths > 1e-12, np.newaxis]
    return bands.sum(axis=0) / 2, normals, np.abs(normals @ bands.T).sum(axis=1) / 2
