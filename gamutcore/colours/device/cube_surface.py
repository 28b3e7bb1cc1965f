"""Device values that cover the surface of a device's cube of lights or inks.

The colours at a gamut's boundary come from device values with all but two channels at an end of
their range. These are the two-dimensional faces of the n-cube: 6 for RGB, 24 for CMYK,
C(n,2)·2^(n-2) for n channels. Each face has one uniform grid of points. Shared edges and corners
are taken once.
"""

from __future__ import annotations

from itertools import combinations
from math import comb, isqrt
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.columns import MAX_CHANNELS
from gamutcore.errors import SampleLimitError
from gamutcore.option_types import WholeNumber, check_option

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = ["SURFACE_SAMPLES", "cube_surface", "cube_surface_count", "surface_steps"]

SURFACE_SAMPLES = WholeNumber(8, 5_000_000)
"""Accepted numbers of points: from the corners of a cube of three channels to the number whose
convex hull takes gigabytes."""


def cube_surface_count(channels: int, steps: int) -> int:
    """Return the number of points on all two-dimensional faces, with shared points counted once.

    Parameters
    ----------
    channels : int
        Number n of channels, at least 1.
    steps : int
        Points m along each edge, at least 2.

    Returns
    -------
    int
        2^n corners, n·2^(n-1) edges with m - 2 points each, C(n,2)·2^(n-2) faces with (m - 2)²
        each; 6m² - 12m + 8 for RGB.

    Examples
    --------
    >>> cube_surface_count(3, 2), cube_surface_count(3, 3)
    (8, 26)
    """
    inner = steps - 2
    edges = channels << (channels - 1)
    return (1 << channels) + edges * inner + _faces(channels) * inner**2


def _faces(channels: int) -> int:
    return comb(channels, 2) << (channels - 2) if channels > 1 else 0


def surface_steps(channels: int, surface_samples: int) -> int:
    """Return the largest number of points along each edge that keeps the total within a limit.

    Parameters
    ----------
    channels : int
        Number of channels, 1 to 15.
    surface_samples : int
        Largest number of points. Two steps give the corners alone, however many there are.

    Returns
    -------
    int
        At least 2.

    Raises
    ------
    OptionError
        `surface_samples` is not within `SURFACE_SAMPLES`.
    SampleLimitError
        `channels` is not 1 to 15.
    """
    check_option("surface_samples", surface_samples, SURFACE_SAMPLES)
    if not 1 <= channels <= MAX_CHANNELS:
        raise SampleLimitError(
            f"The device has {channels} channels.",
            where={"field": "channels"},
            remedy=f"Give a device of 1 to {MAX_CHANNELS} channels.",
        )
    if channels == 1:
        return surface_samples
    steps = isqrt(surface_samples // _faces(channels)) + 3
    while steps > 2 and cube_surface_count(channels, steps) > surface_samples:
        steps -= 1
    return steps


def cube_surface(channels: int, steps: int) -> FloatArray:
    """Return points on all two-dimensional faces of the unit n-cube.

    Parameters
    ----------
    channels : int
        Number n of channels.
    steps : int
        Points m along each edge, at least 2.

    Returns
    -------
    (count, n) float
        Distinct device values from 0 to 1: the corners, then edge by edge, then face by face.
        `count` is `cube_surface_count(channels, steps)`.
    """
    inner = np.linspace(0.0, 1.0, steps)[1:-1]
    points = np.empty((cube_surface_count(channels, steps), channels))
    start = _fill(points, 0, (), np.empty((1, 0)))
    for axis in range(channels):
        start = _fill(points, start, (axis,), inner[:, np.newaxis])
    if channels == 1:
        return points
    face = np.stack(np.meshgrid(inner, inner, indexing="ij"), axis=-1).reshape(-1, 2)
    for axes in combinations(range(channels), 2):
        start = _fill(points, start, axes, face)
    return points


def _fill(points: FloatArray, start: int, free: tuple[int, ...], values: FloatArray) -> int:
    """Write `values` on the free axes for all corners of the other axes; return the next row."""
    fixed = [axis for axis in range(points.shape[1]) if axis not in free]
    corners = 1 << len(fixed)
    block = points[start : start + corners * len(values)]
    view = block.reshape(corners, len(values), points.shape[1])
    for bit, axis in enumerate(fixed):
        view[:, :, axis] = ((np.arange(corners) >> bit) & 1)[:, np.newaxis]
    for column, axis in enumerate(free):
        view[:, :, axis] = values[:, column]
    return start + len(block)
