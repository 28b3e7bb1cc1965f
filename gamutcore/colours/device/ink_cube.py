"""The cube of a device's values, cut by ink limits, as patches of its surface.

A press does not print all inks in full. A total ink limit cuts off the corner of the cube beyond a
plane of equal sums, and a black limit shortens one axis. The colours at the boundary of the rest
come from its two-dimensional faces. These are the cube's own faces, clipped at the plane, and the
intersections of the plane with the cube's three-dimensional faces (triangles to hexagons). Each
face is divided into trapezoids, which a lattice covers without gaps.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain, combinations
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.samples import IntArray

__all__ = ["InkCube", "Patches", "surface_corners", "surface_patches"]

_TINY = 1e-9
"""Smallest extent of a piece of a face, as a fraction of full ink."""


@dataclass(frozen=True, eq=False)
class InkCube:
    """The printable device values.

    Parameters
    ----------
    lowest, highest : (n,) float
        Range of each of n channels; no range is empty.
    total : float or None
        Largest sum of a device value; None without a limit.
    """

    lowest: FloatArray
    highest: FloatArray
    total: float | None = None

    @property
    def cut(self) -> bool:
        """Whether the limit of the sum cuts off a part of the cube."""
        return self.total is not None and self.total < float(self.highest.sum()) - _TINY

    @property
    def largest_sum(self) -> float:
        """The largest sum of a printable device value."""
        return min(float(self.highest.sum()), _limit(self))


@dataclass(frozen=True, eq=False)
class Patches:
    """Trapezoids that cover the surface of a cut cube.

    Parameters
    ----------
    corners : (p, 2, 2, n) float
        Device values at s, t of (0, 0), (0, 1), (1, 0), (1, 1).
    axes : (p, 2) int
        The channel that alone changes, over its whole range, along s and along t; -1 otherwise.
    """

    corners: FloatArray
    axes: IntArray


def surface_patches(cube: InkCube, most: int | None = None) -> Patches | None:
    """Return the trapezoids of all two-dimensional faces of a cut cube.

    Parameters
    ----------
    cube : InkCube
        Of n ≥ 2 channels.
    most : int, optional
        Largest number of trapezoids: fifteen inks have 860,160 faces.

    Returns
    -------
    Patches or None
        C(n, 2)·2^(n-2) patches for a cube without a cut. None if there are more than `most`.

    Examples
    --------
    >>> len(surface_patches(InkCube(np.zeros(3), np.ones(3))).corners)
    6
    """
    corners, axes, count = [], [], 0
    for some, their_axes in chain(_clipped_faces(cube), _cutting_faces(cube) if cube.cut else ()):
        corners.append(some)
        axes.append(their_axes)
        count += len(some)
        if most is not None and count > most:
            return None
    return Patches(np.concatenate(corners), np.concatenate(axes))


def surface_corners(cube: InkCube) -> FloatArray:
    """Return the corners of a cut cube.

    Parameters
    ----------
    cube : InkCube

    Returns
    -------
    (m, n) float
        Corners of the cube within the limit, and the points where its edges meet the limit.

    Examples
    --------
    >>> len(surface_corners(InkCube(np.zeros(3), np.ones(3), total=2.5)))
    10
    """
    n = len(cube.lowest)
    own = _cube_corners(cube, tuple(range(n)))
    found = [own[own.sum(axis=1) <= _limit(cube) + _TINY]]
    if cube.cut:
        for axis in range(n):
            fixed = _cube_corners(cube, _others(cube, axis))
            value = _limit(cube) - fixed.sum(axis=1)
            low, high = cube.lowest[axis] + _TINY, cube.highest[axis] - _TINY
            crossing = (value > low) & (value < high)
            points = fixed[crossing]
            points[:, axis] = value[crossing]
            found.append(points)
    return np.concatenate(found)


def _limit(cube: InkCube) -> float:
    return float("inf") if cube.total is None else cube.total


def _cube_corners(cube: InkCube, axes: tuple[int, ...]) -> FloatArray:
    """All corners of the cube in `axes`, (2^k, n), with the other channels at 0."""
    points = np.zeros((1 << len(axes), len(cube.lowest)))
    for bit, axis in enumerate(axes):
        high = ((np.arange(len(points)) >> bit) & 1).astype(bool)
        points[:, axis] = np.where(high, cube.highest[axis], cube.lowest[axis])
    return points


def _within(cube: InkCube, fixed: FloatArray) -> FloatArray:
    """The corners that leave room below the limit for the other channels."""
    kept: FloatArray = fixed[fixed.sum(axis=1) < _limit(cube)]
    return kept


def _others(cube: InkCube, *axes: int) -> tuple[int, ...]:
    return tuple(axis for axis in range(len(cube.lowest)) if axis not in axes)


def _clipped_faces(cube: InkCube) -> Iterator[tuple[FloatArray, IntArray]]:
    """Yield the parts of the cube's own faces that are within the limit.

    A face is a rectangle from the lowest b to the value where the highest a meets the limit.
    Beyond, it is a trapezoid with one side on the limit.
    """
    for a, b in combinations(range(len(cube.lowest)), 2):
        fixed = _within(cube, _cube_corners(cube, _others(cube, a, b)))
        rest = _limit(cube) - fixed.sum(axis=1)
        low, high = cube.lowest[b], cube.highest[b]
        bends = np.clip(rest - cube.highest[a], low, high)
        stops = [np.full(len(fixed), low), bends, np.clip(rest - cube.lowest[a], low, high)]
        least = np.full(len(fixed), cube.lowest[a])
        # if even the lowest b exceeds the limit, both strips have no height
        most = [np.minimum(cube.highest[a], rest - stop) for stop in stops]
        for i in (0, 1):
            ends = np.stack([least, most[i], least, most[i + 1]], axis=1)
            yield _trapezoids(cube, fixed, (a, b), (stops[i], stops[i + 1]), ends)


def _cutting_faces(cube: InkCube) -> Iterator[tuple[FloatArray, IntArray]]:
    """Yield the parts of the limiting plane within the cube's three-dimensional faces.

    a and b are free, and the third channel c is the rest of the limit. The range of a has two kinks
    along b, so there are up to three trapezoids.
    """
    for a, b, c in combinations(range(len(cube.lowest)), 3):
        fixed = _within(cube, _cube_corners(cube, _others(cube, a, b, c)))
        rest = _limit(cube) - fixed.sum(axis=1)
        least, most = rest - cube.highest[c], rest - cube.lowest[c]  # of a + b
        start = np.maximum(cube.lowest[b], least - cube.highest[a])
        end = np.maximum(start, np.minimum(cube.highest[b], most - cube.lowest[a]))
        bends = np.stack([least - cube.lowest[a], most - cube.highest[a]])
        stops = [start, *np.clip(np.sort(bends, axis=0), start, end), end]
        low = [np.maximum(cube.lowest[a], least - stop) for stop in stops]
        high = [np.minimum(cube.highest[a], most - stop) for stop in stops]
        for i in range(3):
            ends = np.stack([low[i], high[i], low[i + 1], high[i + 1]], axis=1)
            corners, axes = _trapezoids(cube, fixed, (a, b), (stops[i], stops[i + 1]), ends)
            corners[..., c] = _limit(cube) - corners.sum(axis=-1)
            yield corners, np.full_like(axes, -1)


def _trapezoids(
    cube: InkCube,
    fixed: FloatArray,
    axes: tuple[int, int],
    stops: tuple[FloatArray, FloatArray],
    ends: FloatArray,
) -> tuple[FloatArray, IntArray]:
    """Trapezoids between two values of b, with the ends of a at both; none without area."""
    a, b = axes
    spans = ends[:, [1, 3]] - ends[:, [0, 2]]
    real = (stops[1] - stops[0] > _TINY) & (spans.max(axis=1) > _TINY)
    count = int(real.sum())
    corners = np.empty((count, 2, 2, fixed.shape[1]))
    corners[:] = fixed[real, np.newaxis, np.newaxis]
    for t in (0, 1):
        corners[:, :, t, b] = stops[t][real, np.newaxis]
        corners[:, :, t, a] = ends[real, 2 * t : 2 * t + 2]
    whole_a = spans[real].min(axis=1) > cube.highest[a] - cube.lowest[a] - _TINY
    whole_b = (stops[1] - stops[0])[real] > cube.highest[b] - cube.lowest[b] - _TINY
    alone = np.ptp(corners[..., a], axis=2).max(axis=1) < _TINY if count else whole_a
    found = np.column_stack([np.where(whole_a, a, -1), np.where(whole_b & alone, b, -1)])
    return corners, found.astype(np.int64)
