"""Optimal colours: the largest gamut of reflecting surfaces under an illuminant (MacAdam limits).

An optimal colour reflects all light of one band of wavelengths and none of the rest, or the
reverse. Each is a sum of neighbouring bands on the closed circle of wavelengths, so it is computed
exactly as a difference of two cumulative sums of the weighted colour-matching functions. The
colours bound a convex body in CIEXYZ, the zonoid of those weights.
"""

from __future__ import annotations

from functools import lru_cache
from math import isqrt
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces.cielab import adaptation_to_d50, colour_science, xyz_to_lab
from gamutcore.references.catalogue import OPTIMAL_WAVELENGTHS

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, IndexArray, LongArray

__all__ = ["optimal_colours", "optimal_faces", "spectral_weights"]

_FEWEST_BANDS = 16


@lru_cache(maxsize=8)
def spectral_weights(illuminant: str, observer: int) -> FloatArray:
    """Return the tristimulus values of the light in each nanometre, (n, 3), read-only.

    The range is 360 to 780 nm by 1 nm; the sum is the white, with Y = 1 (CIE 15:2018, 7.1).
    Illuminants are interpolated linearly between their tables' 5 nm.
    """
    colour = colour_science()
    first, last = OPTIMAL_WAVELENGTHS
    wavelengths = np.arange(first, last + 1.0)
    year = {2: 1931, 10: 1964}[observer]
    functions = colour.MSDS_CMFS[f"CIE {year} {observer} Degree Standard Observer"]
    power = colour.SDS_ILLUMINANTS[illuminant]
    matching = np.asarray(functions.values)[np.searchsorted(functions.wavelengths, wavelengths)]
    light = np.interp(wavelengths, power.wavelengths, power.values)
    weights: FloatArray = matching * light[:, np.newaxis]
    weights /= weights[:, 1].sum()
    weights.setflags(write=False)
    return weights


def optimal_colours(illuminant: str, observer: int, count: int) -> FloatArray:
    """Return the tristimulus values of optimal colours (n, 3), at most `count`.

    They are black, white, and the b·(b − 1) bands between b wavelengths, with Y = 1 for the white.
    The wavelengths are dense where the bands that end there change fast in CIELAB.

    D. L. MacAdam, The theory of the maximum visual efficiency of colored materials, JOSA 25 (1935).
    """
    weights = spectral_weights(illuminant, observer)
    bands = max(_FEWEST_BANDS, (1 + isqrt(max(4 * count - 7, 1))) // 2)
    if bands < len(weights):
        weights = _merged_weights(weights, bands)
    bands = len(weights)
    sums = np.zeros((2 * bands + 1, 3))
    np.cumsum(np.concatenate([weights, weights]), axis=0, out=sums[1:])
    start, width = np.meshgrid(np.arange(bands), np.arange(1, bands), indexing="ij")
    parts = (sums[start + width] - sums[start]).reshape(-1, 3)
    return np.concatenate([np.zeros((1, 3)), parts, sums[bands : bands + 1]])


def optimal_faces(count: int) -> IndexArray:
    """Return triangles (2·(count − 2), 3) between `count` optimal colours: the zonoid's faces.

    Each face is a parallelogram: a band, the same with one more wavelength at its end, with one
    less at its start, and with both changes.
    """
    bands = (1 + isqrt(4 * count - 7)) // 2
    start, width = (
        grid.astype(np.int64).ravel()
        for grid in np.meshgrid(np.arange(bands), np.arange(1, bands), indexing="ij")
    )

    def index(start: LongArray, width: LongArray) -> LongArray:
        band = 1 + start % bands * (bands - 1) + width - 1
        found: LongArray = np.where(width == 0, 0, np.where(width == bands, count - 1, band))
        return found

    band, longer = index(start, width), index(start, width + 1)
    shorter, moved = index(start + 1, width - 1), index(start + 1, width)
    # the other diagonal would fold 4 % of the area in CIELAB, this one 0.02 %
    faces = np.concatenate(
        [np.stack([band, longer, moved], axis=1), np.stack([band, moved, shorter], axis=1)]
    )
    return faces.astype(np.int32)


def _merged_weights(weights: FloatArray, bands: int) -> FloatArray:
    """Weights of fewer, wider bands, which add up to the same white."""
    sums = np.zeros((len(weights) + 1, 3))
    np.cumsum(weights, axis=0, out=sums[1:])
    white = sums[-1]
    change = sum(
        np.linalg.norm(
            np.diff(xyz_to_lab(adaptation_to_d50(ends, white, "Bradford")), axis=0), axis=1
        )
        for ends in (sums, white - sums)
    )
    places = np.concatenate([[0.0], np.cumsum(change)])
    chosen = np.interp(np.linspace(0, places[-1], bands + 1), places, np.arange(len(places)))
    ends = np.stack([np.interp(chosen, np.arange(len(sums)), each) for each in sums.T], axis=1)
    return np.diff(ends, axis=0)
