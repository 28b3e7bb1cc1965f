"""The tables of a profile: device values to CIELAB (A2B), CIELAB to device values (B2A), and gamut.

Encodings are those of lut16Type: L* to 100 is 0 to 0xFF00, and a* and b* from −128 are 0 to 0xFFFF
(ICC.1:2010, 10.8). Codes of version 5 are 257/256 of these, and end at L* = 100 and a* = b* = 127.
Curves before the tables put the nodes where the device's colours are. White is at a node: L* = 100
is the last one, and a* = b* = 0 are nodes as well.

Nodes out of gamut decide about colours in gamut whose cell they share. With the device values of
clipped colours, interpolation would bend before the surface. These nodes therefore have device
values beyond 0 to 1, which the curves after the table clip. The values are those with the least
squared error of trilinear interpolation, at random colours of the cells across the surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours import LookupTable, cube_nodes, spread_values
from gamutcore.export.icc_file import lut16_element, lut_element

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.arrays import BooleanArray, FloatArray, LongArray
    from gamutcore.colours import DeviceModel
    from gamutcore.gamut import Gamut
    from gamutcore.recipes import BlackRule

__all__ = ["InverseTable", "InverseTables", "forward_table", "lab_codes"]

_SCALE = np.array((652.8, 256.0, 256.0)) / 65535.0
_OFFSET = np.array((0.0, 128.0, 128.0))
"""Codes 0 to 1 are (L*, a*, b* + offset) · scale."""

_LAB_ENTRIES = 1286
"""Entries of curves for L*, a* and b*. L* = 100 is the code 256/257, so it has an entry."""

_LAB_ENTRIES_5 = 1281
"""Entries of these up to the code 256/257, at which the encoding of version 5 ends."""

_INK_ENTRIES = 2001
"""Entries of curves for device values: steps of 0.05 %, which charts have."""

_USUAL = 0.01
"""Share of the samples that a level of a chart has."""

_CONVERGED_DE = 0.005
"""Least distance of the levels of a chart."""

_AT_NODE = 0.001
"""Largest distance of a sample from a node that it counts for: half a step of 8 bits."""

MOST_NODES = 2**17
"""Largest number of nodes of an A2B table: 17 a side for four inks, 5 for seven."""

MOST_A_SIDE = {3: 33}
"""Largest number of nodes a side by the number of channels; 17 for others."""

_MARGIN = 4.0
"""Distance in L*, a* and b* from the colours of the device to the outermost nodes but one."""

BEYOND = 0.5
"""Device values of nodes reach from −BEYOND to 1 + BEYOND."""

_CLIP = np.array((0.0, 0.0, 0.5, 1.0, 1.0))
"""The curve after a table, from codes of −0.5, 0, 0.5, 1 and 1.5 to device values."""

PER_CELL = 12
"""Random colours in each cell across the surface. 24 change the errors by less than 3 %."""

STEPS = 20
"""Steps of the least-squares solution. 40 change the errors by less than 3 %."""

_RIDGE = 0.02
"""Weight of the clipped device values in the solution, which matters for nodes that few colours
need."""

_OUTSIDE = 0.3
"""Weight of colours out of gamut beside those in gamut."""

_SLOPE = 0.02
"""Step of numerical derivatives."""

_FULL_INK = 60.0
"""ΔE*ab of a full ink, about: errors of device values and of colours become comparable."""

_VALUES = 0.01
"""Weight of errors of device values beside those of the colour. It keeps recipes alike."""

_AT_LIMIT = 1e-6
"""Device values within this distance of 0 or 1 may be exceeded by interpolation."""

_DISTANCES = (-25.0, 100.0)
"""Range of signed distances of nodes of the table ``gamt`` in ΔE*ab. Curves clip negative ones."""


def lab_codes(lab: FloatArray) -> FloatArray:
    """Return the codes of colours, 0 to 1."""
    codes: FloatArray = np.clip((lab + _OFFSET) * _SCALE, 0.0, 1.0)
    return codes


def forward_table(
    model: DeviceModel,
    measured: tuple[FloatArray, FloatArray] | None = None,
    change: Callable[[FloatArray], FloatArray] | None = None,
    version: int = 2,
) -> bytes:
    """Return the element of a device model's colours, or of changed ones, in a version of profiles.

    The white is exactly that of the connection space. `measured` has device values (m, n) and their
    colours (m, 3). Nodes are at the levels of these values, and have the colours of samples there.
    """
    count = len(model.channels)
    size = min(int(MOST_NODES ** (1 / count) + 1e-9), MOST_A_SIDE.get(count, 17))
    places = np.linspace(0.0, 1.0, size)
    axes = (
        [places] * count
        if measured is None
        else [_levels(channel, size) for channel in measured[0].T]
    )
    steps = np.linspace(0.0, 1.0, _INK_ENTRIES)
    curves = np.stack([np.interp(steps, axis, places) for axis in axes])
    device = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, count)
    lab = model.lab(device)
    if measured is not None:
        nodes, residuals = _residuals(axes, *measured, model)
        lab[nodes] += residuals
    lab[0 if model.inks else -1] = (100.0, 0.0, 0.0)
    codes = lab_codes(lab if change is None else change(lab)).reshape(*[size] * count, 3)
    if version == 5:
        return lut_element("mAB", np.minimum(codes * (257 / 256), 1.0), curves)
    return lut16_element(codes, curves)


def _residuals(
    axes: list[FloatArray], device: FloatArray, lab: FloatArray, model: DeviceModel
) -> tuple[LongArray, FloatArray]:
    """Return the nodes that samples are at, and how far the samples are from the model.

    Samples of one node are averaged. Samples between nodes do not count: residuals that are spread
    to other nodes make colours of other samples worse.
    """
    places = [
        np.abs(axis - each[:, np.newaxis]).argmin(axis=1)
        for axis, each in zip(axes, device.T, strict=True)
    ]
    node_values = np.stack([axis[place] for axis, place in zip(axes, places, strict=True)], axis=1)
    at = (np.abs(node_values - device) < _AT_NODE).all(axis=1)
    rows = np.ravel_multi_index(places, [len(axis) for axis in axes])[at]
    nodes, which, counts = np.unique(rows, return_inverse=True, return_counts=True)
    sums = np.zeros((len(nodes), 3))
    np.add.at(sums, which, (lab - model.lab(device))[at])
    return nodes, sums / counts[:, np.newaxis]


def _levels(values: FloatArray, size: int) -> FloatArray:
    """Return `size` levels of a channel: those that many samples have, and some between.

    The samples of a chart are then at nodes, where a table has no error. Equal steps are taken
    where the levels are too many.
    """
    levels, counts = np.unique(np.round(values, 4), return_counts=True)
    usual = levels[counts >= _USUAL * len(values)]
    axis = np.unique([0.0, *usual[(usual > _CONVERGED_DE) & (usual < 1.0 - _CONVERGED_DE)], 1.0])
    if len(axis) > size or (np.diff(axis) < _CONVERGED_DE).any():
        return np.linspace(0.0, 1.0, size)
    while len(axis) < size:
        widest = int(np.argmax(np.diff(axis)))
        axis = np.insert(axis, widest + 1, axis[widest : widest + 2].mean())
    return axis


@dataclass(frozen=True, eq=False)
class InverseTable:
    """A table from codes of CIELAB to k values, as the file has it."""

    before: FloatArray
    nodes: FloatArray
    after: FloatArray

    def to_bytes(self, version: int = 2) -> bytes:
        """Return the element of the table in a version of profiles."""
        after = np.tile(self.after, (self.nodes.shape[3], 1))
        if version == 5:
            return lut_element("mBA", self.nodes, self.before[:, :_LAB_ENTRIES_5], after)
        return lut16_element(self.nodes, self.before, after)

    def values(self, lab: FloatArray) -> FloatArray:
        """Return the values of colours by tetrahedral interpolation."""
        nodes = np.round(65535.0 * self.nodes) / 65535.0
        table_values = LookupTable(nodes).values(_places(lab, self.before))
        return np.interp(table_values, np.linspace(0.0, 1.0, len(self.after)), self.after)


def _places(lab: FloatArray, before: FloatArray) -> FloatArray:
    codes, steps = lab_codes(lab), np.linspace(0.0, 1.0, _LAB_ENTRIES)
    return np.stack([np.interp(codes[:, i], steps, before[i]) for i in range(3)], axis=1)


class _Grid:
    """The nodes of a table over CIELAB: `size` a side, dense among colours (m, 3).

    `before` has the curves before the table, and `lab` (size³, 3) the colours of the nodes.
    """

    def __init__(self, colours: FloatArray, size: int) -> None:
        self.size, last = size, size - 1
        low, high = colours.min(axis=0) - _MARGIN, colours.max(axis=0) + _MARGIN
        steps, self.before = np.linspace(0.0, 1.0, _LAB_ENTRIES), np.empty((3, _LAB_ENTRIES))
        for axis, curve in enumerate(self.before):
            if axis == 0:
                ends, places = [0.0, 100.0], [0.0, 1.0]
                if 100.0 / last < low[0] < 50.0:
                    ends[1:1], places[1:1] = [low[0]], [1.0 / last]
            else:
                least, most = np.clip(low[axis], -120.0, -16.0), np.clip(high[axis], 16.0, 120.0)
                zero = 1 + round((last - 2) * least / (least - most))
                ends = [-128.0, least, 0.0, most, 128.0]
                places = [0.0, 1.0 / last, zero / last, 1.0 - 1.0 / last, 1.0]
            codes = (np.array(ends) + _OFFSET[axis]) * _SCALE[axis]
            curve[:] = np.round(65535.0 * np.interp(steps, codes, places)) / 65535.0
        axes = [np.interp(np.linspace(0.0, 1.0, size), curve, steps) for curve in self.before]
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        self.lab = nodes / _SCALE - _OFFSET
        self.lab[:, 0] = np.minimum(self.lab[:, 0], 100.0)
        self.lab[np.abs(self.lab) < 0.1] = 0.0  # no entry of the curves is at zero
        self.white = np.flatnonzero((self.lab == (100.0, 0.0, 0.0)).all(axis=1))

    def colours_at(self, places: FloatArray) -> FloatArray:
        """Return the colours of places in the cube of nodes."""
        steps = np.linspace(0.0, 1.0, _LAB_ENTRIES)
        codes = [np.interp(places[:, i], self.before[i], steps) for i in range(3)]
        lab: FloatArray = np.stack(codes, axis=1) / _SCALE - _OFFSET
        return lab


class InverseTables:
    """Makes the tables B2A of a device for one rule of black, with `size` nodes a side."""

    def __init__(self, gamut: Gamut, black: BlackRule, size: int) -> None:
        self._gamut, self._black, self._size = gamut, black, size
        self._model = gamut.device_model
        cube = self._model.limited.cube
        self._room = cube.limit + float(self._model.limited.base[~self._model.limited.free].sum())
        free = self._model.limited.free
        lowest, highest = self._model.limited.base.copy(), self._model.limited.base.copy()
        lowest[free], highest[free] = cube.lowest, cube.highest
        self._white = lowest if self._model.inks else highest
        # only values at the ends of the whole range are clipped by the curves
        self._least = np.where(lowest <= 0.0, -BEYOND, lowest)
        self._most = np.where(highest >= 1.0, 1.0 + BEYOND, highest)

    def colorimetric(self) -> tuple[InverseTable, InverseTable]:
        """Return the table that clips to the nearest colours, and that of distances (``gamt``)."""
        values = spread_values(self._model.limited.cube, 4096)
        grid = _Grid(self._model.lab(self._model.limited.device(values)), self._size)
        device, inside, nearest = self._clipped(grid.lab)
        device[grid.white] = self._white
        fixed = inside.copy()
        fixed[grid.white] = True
        device = self._fitted(grid, device, inside, fixed)
        distance = np.linalg.norm(grid.lab - nearest, axis=1)
        distance[inside] *= -1.0
        low, high = _DISTANCES
        codes = (np.clip(distance, low, high) - low) / (high - low)
        after = np.maximum(np.linspace(low, high, 6), 0.0) / high
        shape = (self._size,) * 3
        gamut = InverseTable(grid.before, codes.reshape(*shape, 1), after)
        return self._table(grid, device), gamut

    def mapped(
        self, colours: FloatArray, mapping: Callable[[FloatArray], FloatArray]
    ) -> InverseTable:
        """Return the table of a gamut mapping, with nodes dense among colours (m, 3)."""
        grid = _Grid(colours, self._size)
        device = self._recipes(mapping(grid.lab))
        device[grid.white] = self._white
        return self._table(grid, device)

    def _table(self, grid: _Grid, device: FloatArray) -> InverseTable:
        codes = (device + BEYOND) / (1.0 + 2.0 * BEYOND)
        return InverseTable(grid.before, codes.reshape(*(self._size,) * 3, -1), _CLIP)

    def _recipes(self, lab: FloatArray) -> FloatArray:
        return self._gamut.inverse_model.recipes(lab, self._black).device

    def _clipped(self, lab: FloatArray) -> tuple[FloatArray, BooleanArray, FloatArray]:
        """Return device values of the nearest colours, which are in gamut, and surface points."""
        inside = self._gamut.contains(lab, space="CIELAB", max_error=0.0)
        nearest = self._gamut.nearest(lab, space="CIELAB", max_error=0.0).points
        return self._recipes(np.where(inside[:, np.newaxis], lab, nearest)), inside, nearest

    def _fitted(
        self, grid: _Grid, device: FloatArray, inside: BooleanArray, fixed: BooleanArray
    ) -> FloatArray:
        """Return device values of nodes, where those that are not fixed extend beyond the surface.

        Accelerated projected gradients (Beck & Teboulle, SIAM Journal on Imaging Sciences 2, 2009)
        with a diagonal preconditioner. Interpolated values beyond 0 or 1 count as clipped.
        """
        from scipy.sparse import csr_array  # noqa: PLC0415  # slow to import

        cells = np.lib.stride_tricks.sliding_window_view(
            inside.reshape((self._size,) * 3), (2, 2, 2)
        ).sum(axis=(3, 4, 5))
        across = np.argwhere((cells > 0) & (cells < 8))
        random = np.random.default_rng(0)
        places = np.repeat(across, PER_CELL, axis=0) + random.random((len(across) * PER_CELL, 3))
        wanted, own, _ = self._clipped(grid.colours_at(places / (self._size - 1)))
        corners, weights = _trilinear(places, self._size)
        rows = np.repeat(np.arange(len(places)), 8)
        shape = (len(places), len(device))
        matrix = csr_array((weights.ravel(), (rows, corners.ravel())), shape=shape)
        metric = np.where(own, 1.0, _OUTSIDE)[:, np.newaxis, np.newaxis] * self._metric(wanted)
        # rows of the matrix have the sum 1, and those of the metric bound its eigenvalues
        step = 1.0 / (matrix.T @ np.abs(metric).sum(axis=2) + _RIDGE)
        at_least, at_most = wanted <= _AT_LIMIT, wanted >= 1.0 - _AT_LIMIT
        iterate, ahead, speed = device, device, 1.0
        for _ in range(STEPS):
            made = np.asarray(matrix @ ahead)
            rest = made - wanted
            rest[(at_least & (made < 0.0)) | (at_most & (made > 1.0))] = 0.0
            slope = matrix.T @ np.einsum("mij,mj->mi", metric, rest)
            after = ahead - step * (slope + _RIDGE * (ahead - device))
            after[fixed] = device[fixed]
            after = self._printable(after)
            faster = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * speed**2))
            ahead = after + (speed - 1.0) / faster * (after - iterate)
            iterate, speed = after, faster
        return iterate

    def _metric(self, device: FloatArray) -> FloatArray:
        """Return matrices (m, n, n): rest · metric · rest is the squared error of device values.

        It is that of the colour, ΔE*ab ÷ `_FULL_INK`, and a share of that of the values.
        """
        count = device.shape[1]
        lab = self._model.lab(device)
        slopes = np.empty((len(device), 3, count))
        for channel in range(count):
            step = np.where(device[:, channel] > 0.5, -_SLOPE, _SLOPE)
            moved = device.copy()
            moved[:, channel] += step
            slopes[:, :, channel] = (self._model.lab(moved) - lab) / (
                _FULL_INK * step[:, np.newaxis]
            )
        squares: FloatArray = np.einsum("mci,mcj->mij", slopes, slopes)
        return squares + _VALUES * np.eye(count)

    def _printable(self, device: FloatArray) -> FloatArray:
        """Return the nearest values whose positive parts are within the limits.

        The sum of positive parts is convex, so interpolated and clipped values keep the limit.
        """
        values: FloatArray = np.clip(device, self._least, self._most)
        over = np.flatnonzero(np.maximum(values, 0.0).sum(axis=1) > self._room)
        for _ in range(values.shape[1] if len(over) else 0):
            some = values[over]
            excess = np.maximum(some, 0.0).sum(axis=1) - self._room
            used = (some > 0.0).sum(axis=1)
            cut = np.maximum(excess, 0.0) / np.maximum(used, 1)
            values[over] = np.where(some > 0.0, np.maximum(some - cut[:, np.newaxis], 0.0), some)
        return values


def _trilinear(places: FloatArray, size: int) -> tuple[LongArray, FloatArray]:
    """Return the rows of the eight nodes around places (m, 3), in steps of nodes, and weights."""
    base = np.minimum(places.astype(np.int64), size - 2)
    upper = places - base
    corners = cube_nodes(2).astype(np.int64)
    rows = (base[:, np.newaxis] + corners) @ np.array((size * size, size, 1))
    share = np.where(corners, upper[:, np.newaxis], 1.0 - upper[:, np.newaxis]).prod(axis=2)
    return rows, share
