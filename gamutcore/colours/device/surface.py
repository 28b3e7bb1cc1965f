"""Device values at the surface of a device's (cut) cube, denser where their colours curve.

A first, coarse look at every face measures how far its colours bend away from flat pieces, and how
near they lie to the outside. Points are then shared out so that the volume between the gamut and
the flat pieces through its points is as small as their number allows. Where there are too few
points for that, each face has the same lattice.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isqrt
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.device.cube_surface import cube_surface, cube_surface_count, surface_steps
from gamutcore.colours.device.ink_cube import InkCube, Patches, surface_corners, surface_patches

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.samples import IntArray

__all__ = ["MAX_PATCHES", "DeviceSurface", "device_surface", "distinct_rows"]

_COARSE = 12
"""Cells along an edge in the first look, where the model has no grid of its own."""
_FEWEST = 2
"""Cells along an edge at least, or the first look says too little."""
_BINS = (24, 48)
"""Polar and azimuth directions that tell what lies outside."""
_INSIDE, _OUTSIDE = 0.8, 0.95
"""Parts of the largest radius in a direction at which a colour counts for nothing, and fully."""
MAX_PATCHES = 200_000
"""Pieces of the surface at most; with more, of 13 inks and more, only the corners are taken."""
_BLOCK = 1 << 15
"""Points that are made at once, so that what is needed on the way stays small."""
_EVENLY = 0.1
"""Part of the mean bending that every place is taken to have: it may not have been seen."""


@dataclass(frozen=True, eq=False)
class DeviceSurface:
    """Device values at a device's surface.

    Parameters
    ----------
    device : (m, n) float
        The values of n channels.
    density : str
        ``"by curvature"``, ``"uniform"`` or ``"corners"``.
    """

    device: FloatArray
    density: str


def device_surface(
    cube: InkCube,
    colours: Callable[[FloatArray], FloatArray],
    surface_samples: int,
    nodes: FloatArray | None = None,
) -> DeviceSurface:
    """Return device values at the surface of a cut cube.

    Parameters
    ----------
    cube : InkCube
        Of n channels.
    colours : callable
        The device model: (m, n) device values to (m, 3) colours.
    surface_samples : int
        Points at most, unless the cube has more corners.
    nodes : (n, k) float, optional
        Values of each channel, rising from its lowest to its highest, between which the model has
        no kinks.

    Returns
    -------
    DeviceSurface
        The same for the same model, cube and number.
    """
    channels = len(cube.lowest)
    if channels == 1:
        high = cube.highest[0] if cube.total is None else min(cube.highest[0], cube.total)
        line = np.linspace(cube.lowest[0], high, surface_samples)
        return DeviceSurface(line[:, np.newaxis], "uniform")
    patches = surface_patches(cube, min(surface_samples, MAX_PATCHES))
    if patches is None:
        return DeviceSurface(surface_corners(cube), "corners")
    cells = (isqrt(surface_samples // len(patches.corners)) - 1) // 2
    if cells < _FEWEST:
        if cube.cut:
            return _evenly(cube, patches, surface_samples)
        return _uniform(cube, surface_samples)
    if nodes is not None and nodes.shape[1] - 1 <= cells:
        knots = _knots(patches, cube, nodes)
    else:
        knots = _knots(patches, cube, None, min(cells, _COARSE))
    lattice = _Lattice(patches, knots)
    weights, aspect = _weights(lattice, colours)
    return DeviceSurface(lattice.points(weights, aspect, surface_samples), "by curvature")


def _uniform(cube: InkCube, surface_samples: int) -> DeviceSurface:
    channels = len(cube.lowest)
    steps = surface_steps(channels, surface_samples)
    unit = cube_surface(channels, steps)
    device = cube.lowest + unit * (cube.highest - cube.lowest)
    few = cube_surface_count(channels, 2) == len(device)
    return DeviceSurface(device, "corners" if few else "uniform")


def _evenly(cube: InkCube, patches: Patches, surface_samples: int) -> DeviceSurface:
    lattice = _Lattice(patches, np.tile([0.0, 1.0], (len(patches.corners), 2, 1)))
    if lattice.count(np.ones((len(patches.corners), 1, 1, 2), dtype=np.int64)) > surface_samples:
        return DeviceSurface(surface_corners(cube), "corners")
    ones = np.ones((len(patches.corners), 1, 1))
    return DeviceSurface(lattice.points(ones, ones, surface_samples), "uniform")


def _knots(patches: Patches, cube: InkCube, nodes: FloatArray | None, cells: int = 0) -> FloatArray:
    """Return (p, 2, k + 1) places of the coarse lattice's lines along s and t, from 0 to 1."""
    count = len(patches.corners)
    if nodes is None:
        return np.tile(np.linspace(0.0, 1.0, cells + 1), (count, 2, 1))
    places = (nodes - cube.lowest[:, np.newaxis]) / (cube.highest - cube.lowest)[:, np.newaxis]
    regular = np.linspace(0.0, 1.0, places.shape[1])
    every = np.concatenate([places, regular[np.newaxis]])  # the last one is for -1
    knots: FloatArray = every[patches.axes]
    return knots


class _Lattice:
    """The coarse cells of all patches, each of which can be divided into more."""

    def __init__(self, patches: Patches, knots: FloatArray) -> None:
        self.corners = patches.corners
        self.knots = knots
        self.cells = knots.shape[2] - 1
        self.vertices, places = distinct_rows(
            np.round(self.corners.reshape(-1, self.corners.shape[3]), 9) + 0.0
        )
        corner = places.reshape(-1, 2, 2)
        # The edges of each patch: t = 0, t = 1 (along s), s = 0, s = 1 (along t).
        ends = np.stack(
            [corner[:, :, 0], corner[:, :, 1], corner[:, 0, :], corner[:, 1, :]], axis=1
        )
        self.turned = ends[..., 0] > ends[..., 1]
        keys = np.sort(ends, axis=2).reshape(-1, 2) @ [len(self.vertices), 1]
        found, first, which = np.unique(keys, return_index=True, return_inverse=True)
        edges = np.column_stack(np.divmod(found, len(self.vertices)))
        self.edges, self.which = edges, which.reshape(-1, 4)
        self.collapsed = edges[:, 0] == edges[:, 1]
        along = np.stack([knots[:, 0], knots[:, 0], knots[:, 1], knots[:, 1]], axis=1)
        turned = self.turned[..., np.newaxis]
        along = np.where(turned, 1.0 - along[..., ::-1], along)
        self.edge_knots = along.reshape(-1, self.cells + 1)[first]

    def device(self, patch: IntArray, s: FloatArray, t: FloatArray) -> FloatArray:
        """Return device values at places of patches."""
        values = np.empty((len(patch), self.corners.shape[3]))
        for start in range(0, len(patch), _BLOCK):
            rows = slice(start, start + _BLOCK)
            corners = self.corners[patch[rows]]
            at_s, at_t = s[rows, np.newaxis], t[rows, np.newaxis]
            near = corners[:, 0, 0] * (1 - at_t) + corners[:, 0, 1] * at_t
            far = corners[:, 1, 0] * (1 - at_t) + corners[:, 1, 1] * at_t
            values[rows] = near * (1 - at_s) + far * at_s
        return values

    def divided(self, weights: FloatArray, aspect: FloatArray, scale: float) -> IntArray:
        """Return (p, k, k, 2) parts of each cell along s and t."""
        wanted = np.maximum(weights * scale, 1.0)
        along = np.clip(np.rint(np.sqrt(wanted * aspect)), 1, None)
        across = np.clip(np.rint(wanted / along), 1, None)
        return np.stack([along, across], axis=-1).astype(np.int64)

    def edge_parts(self, parts: IntArray) -> IntArray:
        """Return (edges, k) parts of each piece of each edge: the most of the cells beside it."""
        beside = np.stack(
            [parts[:, :, 0, 0], parts[:, :, -1, 0], parts[:, 0, :, 1], parts[:, -1, :, 1]], axis=1
        )
        beside = np.where(self.turned[..., np.newaxis], beside[..., ::-1], beside)
        most = np.ones((len(self.edges), self.cells), dtype=np.int64)
        np.maximum.at(most, self.which.reshape(-1), beside.reshape(-1, self.cells))
        most[self.collapsed] = 0
        return most

    def count(self, parts: IntArray) -> int:
        """Return how many points there are with so many parts."""
        along, across = parts[..., 0], parts[..., 1]
        inner = int((along * across).sum())
        # Points on the patch's own edges belong to the edges.
        inner -= int(across[:, 0, :].sum() + along[:, :, 0].sum()) - len(parts)
        edge_parts = self.edge_parts(parts)
        on_edges = int(edge_parts.sum()) - int((~self.collapsed).sum())
        return len(self.vertices) + on_edges + inner

    def points(self, weights: FloatArray, aspect: FloatArray, wanted: int) -> FloatArray:
        """Return as many points as fit into `wanted`, shared out by weight."""
        low, high = 0.0, 1.0 + 2.0 * wanted / max(float(weights.sum()), 1e-300)
        for _ in range(24):
            middle = (low + high) / 2
            if self.count(self.divided(weights, aspect, middle)) <= wanted:
                low = middle
            else:
                high = middle
        parts = self.divided(weights, aspect, low)
        return np.concatenate([self.vertices, self._on_edges(parts), self._inside(parts)])

    def _on_edges(self, parts: IntArray) -> FloatArray:
        counts = self.edge_parts(parts)
        cell, place = _places(counts.reshape(-1))
        edge, piece = np.divmod(cell, self.cells)
        fraction = place / counts.reshape(-1)[cell]
        start, end = self.edge_knots[edge, piece], self.edge_knots[edge, piece + 1]
        at = (start + fraction * (end - start))[:, np.newaxis]
        kept = (piece > 0) | (place > 0)
        ends = self.vertices[self.edges[edge]]
        values: FloatArray = (ends[:, 0] * (1 - at) + ends[:, 1] * at)[kept]
        return values

    def _inside(self, parts: IntArray) -> FloatArray:
        along, across = parts[..., 0].reshape(-1), parts[..., 1].reshape(-1)
        cell, place = _places(along * across)
        patch, rest = np.divmod(cell, self.cells**2)
        i, j = np.divmod(rest, self.cells)
        di, dj = np.divmod(place, across[cell])
        kept = ((i > 0) | (di > 0)) & ((j > 0) | (dj > 0))
        patch, i, j, cell, di, dj = (a[kept] for a in (patch, i, j, cell, di, dj))
        s = self._between(patch, 0, i, di / along[cell])
        t = self._between(patch, 1, j, dj / across[cell])
        return self.device(patch, s, t)

    def _between(
        self, patch: IntArray, side: int, piece: IntArray, fraction: FloatArray
    ) -> FloatArray:
        start, end = self.knots[patch, side, piece], self.knots[patch, side, piece + 1]
        values: FloatArray = start + fraction * (end - start)
        return values


def distinct_rows(rows: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the distinct rows of an array, in order, and for each row which of them it is.

    Parameters
    ----------
    rows : (m, n) float
        Without negative zeros and NaN.

    Returns
    -------
    distinct : (k, n) float
    places : (m,) int

    Notes
    -----
    `numpy.unique` along an axis compares whole rows, of which twelve inks with a limit have half a
    million: two seconds. Sums of their bits by odd factors tell nearly all of them apart, and what
    they do not is seen by comparing.
    """
    bits = np.ascontiguousarray(rows).view(np.uint64)
    # Any odd factors with bits all over will do; the low bits of short fractions are all zero.
    factors = np.random.default_rng(0).integers(2**63, size=rows.shape[1], dtype=np.uint64) * 2 + 1
    keys = ((bits ^ (bits >> np.uint64(29))) * factors).sum(axis=1, dtype=np.uint64)
    _, first, group = np.unique(keys, return_index=True, return_inverse=True)
    few = rows[first]
    if not np.array_equal(few[group], rows):
        few, group = rows, np.arange(len(rows))
    distinct, places = np.unique(few, axis=0, return_inverse=True)
    return distinct, places.reshape(-1)[group]


def _places(counts: IntArray) -> tuple[IntArray, IntArray]:
    """Return for each of sum(counts) points the cell that it is in, and its place there."""
    cell = np.repeat(np.arange(len(counts)), counts)
    starts = np.cumsum(counts) - counts
    return cell, np.arange(len(cell)) - starts[cell]


def _weights(
    lattice: _Lattice, colours: Callable[[FloatArray], FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Return (p, k, k) shares of the points, and the parts along s for one along t, squared.

    A cell of the area A, which bends by e away from flat, is off by A·e/N in volume if it has N
    points. The sum over all cells is least if N is proportional to √(A·e).
    """
    count, fine = len(lattice.corners), 2 * lattice.cells + 1
    halves = (lattice.knots[..., 1:] + lattice.knots[..., :-1]) / 2
    lines = np.empty((count, 2, fine))
    lines[..., ::2], lines[..., 1::2] = lattice.knots, halves
    patch = np.repeat(np.arange(count), fine**2)
    s = np.repeat(lines[:, 0], fine, axis=1).reshape(-1)
    t = np.tile(lines[:, 1], (1, fine)).reshape(-1)
    grid = colours(lattice.device(patch, s, t)).reshape(count, fine, fine, 3)

    first, last, middle = slice(0, -1, 2), slice(2, None, 2), slice(1, None, 2)
    low, high = grid[:, first, first], grid[:, last, last]
    left, right = grid[:, first, last], grid[:, last, first]
    normal = np.cross(high - low, left - right)
    area = np.linalg.norm(normal, axis=-1)
    normal /= np.maximum(area, 1e-12)[..., np.newaxis]

    def bent(*deviations: FloatArray) -> FloatArray:
        heights = [np.abs(np.einsum("...i,...i->...", d, normal)) for d in deviations]
        highest: FloatArray = np.max(heights, axis=0)
        return highest

    along = bent(
        grid[:, middle, first] - (low + right) / 2,
        grid[:, middle, middle] - (grid[:, first, middle] + grid[:, last, middle]) / 2,
        grid[:, middle, last] - (left + high) / 2,
    )
    across = bent(
        grid[:, first, middle] - (low + left) / 2,
        grid[:, middle, middle] - (grid[:, middle, first] + grid[:, middle, last]) / 2,
        grid[:, last, middle] - (right + high) / 2,
    )
    twist = bent((low + high - left - right) / 4)
    outside = _outside(grid)
    bending = along + across + twist
    mean = float((area * outside * bending).sum() / max(float((area * outside).sum()), 1e-300))
    floor = _EVENLY * mean + 1e-6
    weights = outside * np.sqrt(area * (bending + floor))
    aspect = np.clip((along + twist / 2 + floor) / (across + twist / 2 + floor), 1 / 16, 16)
    return weights, aspect


def _outside(grid: FloatArray) -> FloatArray:
    """Return (p, k, k) how much each cell counts, by how far out it is among those seen near it."""
    flat = grid.reshape(-1, 3)
    offset = grid - (flat.min(axis=0) + flat.max(axis=0)) / 2
    radius = np.linalg.norm(offset, axis=-1)
    polar = np.arccos(np.clip(offset[..., 0] / np.maximum(radius, 1e-12), -1, 1)) / np.pi
    azimuth = np.arctan2(offset[..., 2], offset[..., 1]) / (2 * np.pi) + 0.5
    rows = np.minimum((polar * _BINS[0]).astype(np.int64), _BINS[0] - 1)
    columns = np.minimum((azimuth * _BINS[1]).astype(np.int64), _BINS[1] - 1)
    bins = rows * _BINS[1] + columns
    largest = np.zeros(_BINS[0] * _BINS[1])
    np.maximum.at(largest, bins.reshape(-1), radius.reshape(-1))
    part = radius / np.maximum(largest[bins], 1e-12)
    cells = np.maximum.reduce(
        [part[:, i::2, j::2][:, : part.shape[1] // 2, : part.shape[2] // 2] for i, j in _NEAR]
    )
    share: FloatArray = np.clip((cells - _INSIDE) / (_OUTSIDE - _INSIDE), 0.0, 1.0)
    return share


_NEAR = ((0, 0), (0, 1), (1, 0), (1, 1))
"""Of the nine places of a cell that were looked at, those whose distance is compared."""
