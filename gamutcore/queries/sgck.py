"""SGCK: sigmoidal lightness mapping that depends on chroma, then a knee towards the cusp.

1. Lightness. The range of the source's lightness is mapped to that of the gamut by a cumulative
   normal distribution. Colours of high chroma keep their lightness: the sigmoid has the weight
   1 − √(C³ ÷ (C³ + 5·10⁵)).
2. Knee. Colours move on lines to the point on the axis that has the lightness of the cusp of their
   hue. Up to 90 % of the distance to the gamut's surface nothing changes. The rest of the way, up
   to the source's surface, is compressed linearly into the last 10 %.

Hue is kept. The constants are for spaces whose lightness is 0 to 100, such as CIELAB.

Source: CIE 156:2004, "Guidelines for the evaluation of gamut mapping algorithms". The sigmoid is
G. Braun & M. Fairchild, "Image lightness rescaling using sigmoidal contrast enhancement functions",
Journal of Electronic Imaging 8 (1999), table 3 (images of normal lightness). The public
implementation of J. Morovič, PGMA 2.1 (2002), has the same constants and the same order of steps.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.errors import MeshError
from gamutcore.queries.crossings import crossings
from gamutcore.queries.cusps import cusp_points
from gamutcore.queries.index import LevelIndex, build_index

__all__ = ["compress", "mapped_lightness"]

DARKEST = (5.0, 10.0, 15.0, 20.0)
"""Lowest lightness of the gamut for which Braun & Fairchild give a sigmoid."""

MEANS = (53.7, 56.8, 58.2, 60.6)
"""The mean of the normal distribution for each of them."""

DEVIATIONS = (43.0, 40.0, 35.0, 34.5)
"""The standard deviation for each of them."""

CHROMA_CUBED = 5e5
"""The cube of the chroma at which the weight of the sigmoid is 1 − √½ (CIE 156:2004)."""

KNEE = 0.9
"""Share of the distance to the gamut's surface that is not compressed (CIE 156:2004)."""


def compress(points: FloatArray, index: LevelIndex, source: LevelIndex) -> FloatArray:
    """Return colours (n, 3) of `source` compressed into `index` by SGCK, in gamut within rounding.

    Exceptions are colours outside the source, and lines that do not begin in gamut. The knee ends
    at the source's surface after the mapping of lightness. If the centre does not see all of that
    surface, the knee ends at the surface before the mapping.
    """
    ranges = (*source.box[:, 0].tolist(), *index.box[:, 0].tolist())
    scaled = _with_lightness(points, ranges)
    hues = np.degrees(np.arctan2(points[:, 2], points[:, 1]))
    focus = np.zeros_like(points)
    focus[:, 0] = cusp_points(hues, index).points[:, 0]
    rows = np.flatnonzero(np.isfinite(focus[:, 0]) & (scaled != focus).any(axis=1))
    focus, target = focus[rows], scaled[rows]
    # distances from the focus ÷ that of the colour
    surface = _distances(focus, target, index, 0)
    limit = _distances(focus, target, _compressed_source(source, ranges), -1)
    with np.errstate(invalid="ignore", divide="ignore"):
        knee = KNEE * surface
        slope = np.where(limit > surface, (surface - knee) / (limit - knee), 1.0)
        share = np.where(knee < 1.0, np.minimum(knee + slope * (1.0 - knee), surface), 1.0)
    share[~np.isfinite(share)] = 1.0
    scaled[rows] = focus + share[:, np.newaxis] * (target - focus)
    return scaled


def mapped_lightness(
    lightness: FloatArray, chroma: FloatArray, ranges: tuple[float, float, float, float]
) -> FloatArray:
    """Return the lightness after the sigmoid and before the knee.

    `ranges` has the lowest and highest lightness of the source, then of the gamut.
    """
    from scipy.special import ndtr  # noqa: PLC0415  # 15 MB; only this method needs it

    low, high, darkest, lightest = ranges
    mean, deviation = np.interp(darkest, DARKEST, MEANS), np.interp(darkest, DARKEST, DEVIATIONS)
    part = 100.0 * (lightness - low) / (high - low)
    shares = np.asarray(ndtr((part - mean) / deviation))
    least, most = ndtr((np.array([0.0, 100.0]) - mean) / deviation)
    sigmoid = darkest + (lightest - darkest) * (shares - least) / (most - least)
    cubed = chroma**3
    weight = 1.0 - np.sqrt(cubed / (cubed + CHROMA_CUBED))
    found: FloatArray = weight * sigmoid + (1.0 - weight) * lightness
    return found


def _with_lightness(points: FloatArray, ranges: tuple[float, float, float, float]) -> FloatArray:
    chroma = np.hypot(points[:, 1], points[:, 2])
    return np.column_stack([mapped_lightness(points[:, 0], chroma, ranges), points[:, 1:]])


def _compressed_source(source: LevelIndex, ranges: tuple[float, float, float, float]) -> LevelIndex:
    """Return the source after the mapping of lightness."""
    vertices = _with_lightness(source.vertices, ranges)
    centre = _with_lightness(source.centre[np.newaxis], ranges)[0]
    try:
        return build_index(vertices, source.faces, centre)
    except MeshError:
        return source  # the centre does not see all faces any more


def _distances(focus: FloatArray, target: FloatArray, index: LevelIndex, which: int) -> FloatArray:
    """Return t where rays leave a level first (0) or last (−1); NaN if they do not begin inside."""
    found = crossings(focus, target, index, "ray")
    begin, end = found.offsets[:-1], found.offsets[1:]
    inside = np.flatnonzero((end - begin) % 2 == 1)
    distances = np.full(len(begin), np.nan)
    distances[inside] = found.t[begin[inside] if which == 0 else end[inside] - 1]
    return distances
