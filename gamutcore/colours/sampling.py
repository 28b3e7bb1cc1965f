"""Device values at the surface of a device's cut cube, denser where the colours curve.

A coarse first pass measures the curvature of the colours on every face, and how near they are to
the outside of the gamut. The points are then distributed to minimise the volume between the gamut
and the flat pieces through the points. With too few points for that, each face has the same
lattice.

A patch of the surface has k × k cells. Each cell is divided into its own numbers of parts along s
and t, and each side of a cell into as many parts as the finer of the two cells beside it. A ring of
triangles joins the sides of a cell to its inner points, so there are no T-junctions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isqrt
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np

from gamutcore.arguments import WholeNumber
from gamutcore.arrays import BooleanArray, FloatArray, IndexArray, LongArray
from gamutcore.colours.ink_limits import (
    InkCube,
    LimitedCube,
    Patches,
    surface_corners,
    surface_patches,
)
from gamutcore.geometry import TriangleMesh
from gamutcore.kernels import kernel, leaf_kernel

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.characterisation.samples import JSON
    from gamutcore.colours.models import DeviceModel

SURFACE_SAMPLES = Annotated[int, WholeNumber(8, 5_000_000)]
"""Accepted numbers of points: from the corners of a cube of three channels to the number whose
convex hull takes gigabytes."""

_COARSE = 12
"""Cells along an edge in the first pass, for a model without a grid of its own."""
_FEWEST = 2
"""Smallest useful number of cells along an edge in the first pass."""
_BINS = (24, 48)
"""Numbers of polar and azimuth bins that tell the outside."""
_INSIDE, _OUTSIDE = 0.8, 0.95
"""Fractions of the largest radius in a direction at which a colour has no and full weight."""
MAX_PATCHES = 200_000
"""Largest number of patches; above it (13 inks and more), only the corners are sampled."""
_BLOCK = 1 << 15
"""Number of points that are computed at once, to limit the memory of intermediate results."""
MOST_BETWEEN = 200_000
"""Largest number of sides within faces whose middles are tried. 100,000 points have as many."""
_EVENLY = 0.1
"""Share of the mean curvature that every cell is given, because the first pass may miss some."""


@dataclass(frozen=True, eq=False)
class SurfaceFaces:
    """Triangles that cover all two-dimensional faces of a device's cut cube, without T-junctions.

    `corners` (m, 3) are rows of device values; corners and edges of the cube have their rows once.
    `labels` (m,) number the flat patches of the cube's surface. With three free channels, the
    triangles are a `closed`, oriented surface. With more, the faces cross inside of the gamut.
    """

    corners: IndexArray
    labels: IndexArray
    closed: bool


@dataclass(frozen=True, eq=False)
class DeviceSurface:
    """Device values (m, n) at a device's surface, and the triangles between them.

    `density` is ``"by curvature"``, ``"uniform"`` or ``"corners"``. Too many faces, or fewer than
    three channels, give no triangles.
    """

    device: FloatArray
    density: str
    faces: SurfaceFaces | None = None


class DeviceColours(NamedTuple):
    """All colours that a device can make.

    `points` maps device values (m, k) in the cube to colours, as those of `SurfaceColours`. `tried`
    (j, k) are device values between the surface samples, whose colours a boundary is likely to
    miss. `model` gives colours in CIELAB. `measured` (r, 3) are the measured colours of the
    printable samples. `printed` maps device values (m, n) to those that a
    profile's B2A tables print in their place; None if these are the same.
    """

    cube: InkCube
    points: Callable[[FloatArray], FloatArray]
    tried: FloatArray
    model: DeviceModel
    measured: FloatArray
    printed: Callable[[FloatArray], FloatArray] | None = None


class AbsoluteColours(NamedTuple):
    """The way from media-relative colours to absolute ones, and to the device's unadapted ones.

    `matrix` (3, 3) maps tristimulus values relative to D50, with Y = 1 for the white of the medium,
    to those of the intent absolute. With `as_measured` these are unadapted already. Otherwise `own`
    (3, 3) maps to the unadapted values of the device, up to a common factor; None if there is no
    such matrix.
    """

    matrix: FloatArray
    as_measured: bool = False
    own: FloatArray | None = None

    def own_from(self, intent: object) -> FloatArray | None:
        """Return the matrix from an intent to the device's unadapted values; None for identity."""
        if intent != "absolute":
            return self.matrix if self.own is None else self.own
        return None if self.own is None else self.own @ np.linalg.inv(self.matrix)


@dataclass(frozen=True, eq=False)
class SurfaceColours:
    """Points that the boundary of the gamut is wrapped around.

    Attributes
    ----------
    points : (m, 3) float
        CIELAB relative to ICC's D50, or coordinates of a space after `colours_in_space`.
    device : (m, k) float or None
        Their device values, or the values of pixels, 0 to 1; None for bare colours.
    provenance : dict
        All inputs and choices, JSON-able.
    as_measured : bool
        Whether the tristimulus values are a display's or an encoding's own, without adaptation.
    channels : tuple of str
        Names of the k device channels; empty for bare colours.
    faces : SurfaceFaces, optional
        Triangles between the points; None without a device model, or if they are too many.
    device_colours : DeviceColours, optional
        All colours that the device can make, by its model.
    absolute : AbsoluteColours, optional
        The way to absolute colours, and to the device's own; None if it is not known.
    """

    points: FloatArray
    device: FloatArray | None
    provenance: dict[str, JSON]
    as_measured: bool = False
    channels: tuple[str, ...] = ()
    faces: SurfaceFaces | None = None
    device_colours: DeviceColours | None = None
    absolute: AbsoluteColours | None = None


def device_surface(
    cube: InkCube,
    colours: Callable[[FloatArray], FloatArray],
    surface_samples: int,
    nodes: FloatArray | None = None,
) -> DeviceSurface:
    """Return device values at the surface of a cut cube of n channels.

    There are at most `surface_samples` points, unless the cube has more corners. `nodes` (n, k) are
    each channel's ascending values, over its whole range, between which the model is smooth.
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
    count = len(patches.corners)
    if cells < _FEWEST:
        lattice = _Lattice(patches, np.tile([0.0, 1.0], (count, 2, 1)))
        ones = np.ones((count, 1, 1))
        device, faces = lattice.divided(ones, ones, surface_samples)
        density = "corners" if len(device) == len(lattice.vertices) else "uniform"
        return DeviceSurface(device, density, faces)
    if nodes is not None and nodes.shape[1] - 1 <= cells:
        low, high = cube.lowest[:, np.newaxis], cube.highest[:, np.newaxis]
        fractions = (nodes - low) / (high - low)
        regular = np.linspace(0.0, 1.0, nodes.shape[1])
        knots = np.concatenate([fractions, regular[np.newaxis]])[patches.axes]  # regular for -1
    else:
        knots = np.tile(np.linspace(0.0, 1.0, min(cells, _COARSE) + 1), (count, 2, 1))
    lattice = _Lattice(patches, knots)
    weights, aspect = _weights(lattice, colours)
    device, faces = lattice.divided(weights, aspect, surface_samples)
    return DeviceSurface(device, "by curvature", faces)


def outward_faces(points: FloatArray, faces: SurfaceFaces) -> SurfaceFaces:
    """Return closed faces so that they enclose a positive volume; other faces are unchanged."""
    if not faces.closed or TriangleMesh(points, faces.corners).volume >= 0:
        return faces
    return replace(faces, corners=np.ascontiguousarray(faces.corners[:, [0, 2, 1]]))


def values_between(surface: DeviceSurface) -> FloatArray:
    """Return device values in the middle of the longest sides of a surface's triangles, (k, n).

    There the colours are farthest from the flat pieces between the points. Sides on edges of the
    cube have three values each, because nothing beside such an edge covers what is missed.
    """
    if surface.faces is None:
        return surface.device[:0]
    values, labels = surface.device, surface.faces.labels
    starts, ends = surface.faces.corners, np.roll(surface.faces.corners, -1, axis=1)
    longest = ((values[starts] - values[ends]) ** 2).sum(axis=2).argmax(axis=1)
    keys = np.minimum(starts, ends) * np.int64(len(values)) + np.maximum(starts, ends)
    inner = np.unique(keys[np.arange(len(keys)), longest])
    inner = inner[:: -(-len(inner) // MOST_BETWEEN)]
    order = np.argsort(keys, axis=None)
    ranked, label = keys.reshape(-1)[order], np.repeat(labels, 3)[order]
    first = np.flatnonzero(np.append(True, ranked[1:] != ranked[:-1]))
    on_edge = np.minimum.reduceat(label, first) != np.maximum.reduceat(label, first)
    outer = ranked[first[on_edge]]
    parts = []
    for share, sides in ((0.5, inner), (0.25, outer), (0.5, outer), (0.75, outer)):
        one, two = np.divmod(sides, len(values))
        parts.append((1 - share) * values[one] + share * values[two])
    return np.concatenate(parts)


class _Lattice:
    """The coarse cells of all patches, each of which can be subdivided."""

    def __init__(self, patches: Patches, knots: FloatArray) -> None:
        self.corners = patches.corners
        self.knots = knots
        self.cells = knots.shape[2] - 1
        self.vertices, indices = distinct_rows(
            np.round(self.corners.reshape(-1, self.corners.shape[3]), 9) + 0.0
        )
        corner = indices.reshape(-1, 2, 2)
        # edges of each patch: t = 0, t = 1 (along s), s = 0, s = 1 (along t)
        ends = np.stack(
            [corner[:, :, 0], corner[:, :, 1], corner[:, 0, :], corner[:, 1, :]], axis=1
        )
        self.is_reversed = ends[..., 0] > ends[..., 1]
        keys = np.sort(ends, axis=2).reshape(-1, 2) @ [len(self.vertices), 1]
        edge_keys, first, which = np.unique(keys, return_index=True, return_inverse=True)
        edges = np.column_stack(np.divmod(edge_keys, len(self.vertices)))
        self.edges, self.which = edges, which.reshape(-1, 4)
        self.collapsed = edges[:, 0] == edges[:, 1]
        along = np.stack([knots[:, 0], knots[:, 0], knots[:, 1], knots[:, 1]], axis=1)
        is_reversed = self.is_reversed[..., np.newaxis]
        along = np.where(is_reversed, 1.0 - along[..., ::-1], along)
        self.edge_knots = along.reshape(-1, self.cells + 1)[first]

    def device(self, patch: LongArray, s: FloatArray, t: FloatArray) -> FloatArray:
        """Device values at the positions (s, t) of patches."""
        values = np.empty((len(patch), self.corners.shape[3]))
        for start in range(0, len(patch), _BLOCK):
            rows = slice(start, start + _BLOCK)
            corners = self.corners[patch[rows]]
            at_s, at_t = s[rows, np.newaxis], t[rows, np.newaxis]
            near = corners[:, 0, 0] * (1 - at_t) + corners[:, 0, 1] * at_t
            far = corners[:, 1, 0] * (1 - at_t) + corners[:, 1, 1] * at_t
            values[rows] = near * (1 - at_s) + far * at_s
        return values

    def parts(self, weights: FloatArray, aspect: FloatArray, scale: float) -> LongArray:
        """Numbers of parts of each cell along s and t, (p, k, k, 2)."""
        wanted = np.maximum(weights * scale, 1.0)
        along = np.clip(np.rint(np.sqrt(wanted * aspect)), 1, None)
        across = np.clip(np.rint(wanted / along), 1, None)
        return np.stack([along, across], axis=-1).astype(np.int64)

    def edge_parts(self, parts: LongArray) -> LongArray:
        """Numbers of parts of the pieces of each edge, (edges, k): those of the finer cell."""
        beside = np.stack(
            [parts[:, :, 0, 0], parts[:, :, -1, 0], parts[:, 0, :, 1], parts[:, -1, :, 1]], axis=1
        )
        beside = np.where(self.is_reversed[..., np.newaxis], beside[..., ::-1], beside)
        most = np.ones((len(self.edges), self.cells), dtype=np.int64)
        np.maximum.at(most, self.which.reshape(-1), beside.reshape(-1, self.cells))
        most[self.collapsed] = 0
        return most

    def count(self, parts: LongArray) -> int:
        """Number of points for given numbers of parts."""
        on_edges = int(self.edge_parts(parts).sum()) - int((~self.collapsed).sum())
        return len(self.vertices) + on_edges + inside_count(parts)

    def divided(
        self, weights: FloatArray, aspect: FloatArray, wanted: int
    ) -> tuple[FloatArray, SurfaceFaces | None]:
        """At most `wanted` points, distributed by weight, and the triangles between them."""
        low, high = 0.0, 1.0 + 2.0 * wanted / max(float(weights.sum()), 1e-300)
        for _ in range(24):
            middle = (low + high) / 2
            if self.count(self.parts(weights, aspect, middle)) <= wanted:
                low = middle
            else:
                high = middle
        parts = self.parts(weights, aspect, low)
        edge_parts = self.edge_parts(parts)
        layout, counts = self._layout(parts, edge_parts)
        # Euler's formula for each patch
        triangles = 2 * int(counts.sum()) + int(edge_parts[self.which].sum())
        position, corners, labels = lattice_faces(
            layout, counts.sum(), triangles, max(parts.max(), edge_parts.max())
        )
        patch = np.repeat(np.arange(len(counts)), counts)
        inner_values = self.device(patch, position[:, 0], position[:, 1])
        device = np.concatenate([self.vertices, self._on_edges(edge_parts), inner_values])
        channels = device.shape[1]
        return device, SurfaceFaces(corners, labels, channels == 3) if channels > 2 else None

    def _layout(self, parts: LongArray, edge_parts: LongArray) -> tuple[Layout, LongArray]:
        """Numbers of all points for given numbers of parts, and of those inside of each patch.

        The points are the corners, then the inner points of the edges, then those of the patches. A
        patch has its nodes first, then for each cell the points on its sides ABOVE and AFTER, and
        those inside of it.
        """
        count, cells = len(parts), self.cells
        reached = np.zeros((len(self.edges), cells + 1), np.int64)  # parts before each node
        np.cumsum(edge_parts, axis=1, out=reached[:, 1:])
        on_edge = np.maximum(reached[:, -1:] - 1, 0)
        start = len(self.vertices) + np.cumsum(on_edge, axis=0) - on_edge
        outside = len(self.vertices) + int(on_edge.sum())

        level = np.maximum(parts[:, :, 1:, 0], parts[:, :, :-1, 0])  # between cells, as all below
        upright = np.maximum(parts[:, 1:, :, 1], parts[:, :-1, :, 1])
        inner = np.zeros((count, cells, cells, 3), np.int64)
        inner[:, :, :-1, 0], inner[:, :-1, :, 1] = level - 1, upright - 1
        inner[..., 2] = (parts - 1).prod(axis=-1)
        sequence = np.concatenate(
            [np.full((count, 1), (cells - 1) ** 2), inner.reshape(count, -1)], axis=1
        )
        starts = (outside + np.cumsum(sequence)).reshape(sequence.shape) - sequence
        cell_starts = starts[:, 1:].reshape(inner.shape)

        nodes = np.empty((count, cells + 1, cells + 1), np.int64)
        nodes[:, 1:-1, 1:-1] = np.arange((cells - 1) ** 2).reshape(cells - 1, cells - 1)
        nodes[:, 1:-1, 1:-1] += starts[:, 0, np.newaxis, np.newaxis]
        at_ends = np.where(reached == 0, self.edges[:, :1], self.edges[:, 1:])
        is_end = (reached == 0) | (reached == reached[:, -1:])
        on_sides = self._oriented(np.where(is_end, at_ends, start + reached - 1))
        nodes[:, 0], nodes[:, -1] = on_sides[:, BEFORE], on_sides[:, AFTER]
        nodes[:, :, 0], nodes[:, :, -1] = on_sides[:, BELOW], on_sides[:, ABOVE]

        is_reversed = self.is_reversed[..., np.newaxis]
        steps = np.where(is_reversed, -1, 1)
        first = np.where(
            is_reversed, self._oriented(reached[:, 1:]), self._oriented(reached[:, :-1])
        )
        layout = Layout(
            self.knots,
            parts,
            nodes,
            outside,
            cell_starts,
            _at_sides(level, upright, self._oriented(edge_parts)),
            _at_sides(
                cell_starts[:, :, :-1, 0] - 1,
                cell_starts[:, :-1, :, 1] - 1,
                first + start[self.which] - 1,
            ),
            _at_sides(np.ones_like(level), np.ones_like(upright), np.tile(steps, cells)),
            self._turned(),
        )
        return layout, sequence.sum(axis=1)

    def _oriented(self, values: LongArray) -> LongArray:
        """Values (edges, m) along the edges as values (p, 4, m) along the sides of patches."""
        side_values = values[self.which]
        return np.where(self.is_reversed[..., np.newaxis], side_values[..., ::-1], side_values)

    def _turned(self) -> BooleanArray:
        """Whether s and t run clockwise around each patch, seen from outside of the cube."""
        corners = self.corners
        if corners.shape[3] != 3:
            return np.zeros(len(corners), bool)
        normals = np.cross(corners[:, 1, 1] - corners[:, 0, 0], corners[:, 0, 1] - corners[:, 1, 0])
        outwards = corners.mean(axis=(1, 2)) - self.vertices.mean(axis=0)
        return np.asarray((normals * outwards).sum(axis=1) < 0)

    def _on_edges(self, counts: LongArray) -> FloatArray:
        counts = counts.reshape(-1)
        cell = np.repeat(np.arange(len(counts)), counts)
        number = np.arange(len(cell)) - (np.cumsum(counts) - counts)[cell]
        edge, piece = np.divmod(cell, self.cells)
        fraction = number / counts[cell]
        start, end = self.edge_knots[edge, piece], self.edge_knots[edge, piece + 1]
        at = (start + fraction * (end - start))[:, np.newaxis]
        is_inner = (piece > 0) | (number > 0)
        ends = self.vertices[self.edges[edge]]
        values: FloatArray = (ends[:, 0] * (1 - at) + ends[:, 1] * at)[is_inner]
        return values


def distinct_rows(rows: FloatArray) -> tuple[FloatArray, LongArray]:
    """Return the distinct rows of an array in order, and the index of each row among them.

    `numpy.unique` along an axis takes two seconds for the half million rows of twelve inks with a
    limit. A hash of the bits tells nearly all rows apart; collisions are found by comparison.
    """
    bits = np.ascontiguousarray(rows).view(np.uint64)
    # random odd factors; the low bits of short fractions are all zero, so mix in the high bits
    factors = np.random.default_rng(0).integers(2**63, size=rows.shape[1], dtype=np.uint64) * 2 + 1
    keys = ((bits ^ (bits >> np.uint64(29))) * factors).sum(axis=1, dtype=np.uint64)
    _, first, group = np.unique(keys, return_index=True, return_inverse=True)
    few = rows[first]
    if not np.array_equal(few[group], rows):
        few, group = rows, np.arange(len(rows))
    distinct, indices = np.unique(few, axis=0, return_inverse=True)
    return distinct, indices.reshape(-1)[group]


def _weights(
    lattice: _Lattice, colours: Callable[[FloatArray], FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Share of the points of each cell, (p, k, k), and the squared ratio of parts along s and t.

    A cell of area A with deviation e from a flat piece has a volume error of A·e/N with N points.
    The sum over all cells is least if N is proportional to √(A·e).
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

    def deviation(*deviations: FloatArray) -> FloatArray:
        heights = [np.abs(np.einsum("...i,...i->...", d, normal)) for d in deviations]
        highest: FloatArray = np.max(heights, axis=0)
        return highest

    along = deviation(
        grid[:, middle, first] - (low + right) / 2,
        grid[:, middle, middle] - (grid[:, first, middle] + grid[:, last, middle]) / 2,
        grid[:, middle, last] - (left + high) / 2,
    )
    across = deviation(
        grid[:, first, middle] - (low + left) / 2,
        grid[:, middle, middle] - (grid[:, middle, first] + grid[:, middle, last]) / 2,
        grid[:, last, middle] - (right + high) / 2,
    )
    twist = deviation((low + high - left - right) / 4)
    # three channels have no faces inside of the gamut
    outside = _outside(grid) if lattice.corners.shape[3] > 3 else np.ones(area.shape)
    bending = along + across + twist
    mean = float((area * outside * bending).sum() / max(float((area * outside).sum()), 1e-300))
    floor = _EVENLY * mean + 1e-6
    weights = outside * np.sqrt(area * (bending + floor))
    aspect = np.clip((along + twist / 2 + floor) / (across + twist / 2 + floor), 1 / 16, 16)
    return weights, aspect


def _outside(grid: FloatArray) -> FloatArray:
    """Weight of each cell, (p, k, k), by its radius relative to the largest in its direction."""
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
    near = [
        part[:, i::2, j::2][:, : part.shape[1] // 2, : part.shape[2] // 2]
        for i, j in ((0, 0), (0, 1), (1, 0), (1, 1))
    ]
    cells = np.maximum.reduce(near)
    share: FloatArray = np.clip((cells - _INSIDE) / (_OUTSIDE - _INSIDE), 0.0, 1.0)
    return share


BELOW, ABOVE, BEFORE, AFTER = range(4)
"""Sides of a patch or cell: t = 0 and t = 1 (along s), s = 0 and s = 1 (along t)."""


class Layout(NamedTuple):
    """How finely the cells are divided, and the numbers of all points.

    `knots` (p, 2, k + 1) are the lines of the cells along s and t, and `parts` (p, k, k, 2) the
    numbers of parts of each cell. `nodes` (p, k + 1, k + 1) are the points where lines cross.
    Points inside of patches have numbers from `outside` on, and `starts` (p, k, k, 3) has the first
    point on a cell's sides ABOVE and AFTER and inside of it. The four sides of a cell have
    `side_parts` (p, k, k, 4); point n of a side is ``before + n * step``. The triangles of patches
    that are `turned` (p,) are clockwise in s and t.
    """

    knots: FloatArray
    parts: LongArray
    nodes: LongArray
    outside: int
    starts: LongArray
    side_parts: LongArray
    before: LongArray
    step: LongArray
    turned: BooleanArray


def _at_sides(level: LongArray, upright: LongArray, on_edges: LongArray) -> LongArray:
    """Values at the four sides of each cell, (p, k, k, 4).

    They are given for the sides between cells, `level` (p, k, k - 1) and `upright` (p, k - 1, k),
    and for those on the edges of patches, (p, 4, k).
    """
    below, above, before, after = np.moveaxis(on_edges, 1, 0)
    level = np.concatenate([below[:, :, np.newaxis], level, above[:, :, np.newaxis]], axis=2)
    upright = np.concatenate([before[:, np.newaxis], upright, after[:, np.newaxis]], axis=1)
    sides = [level[:, :, :-1], level[:, :, 1:], upright[:, :-1], upright[:, 1:]]
    return np.stack(sides, axis=-1)


def inside_count(parts: LongArray) -> int:
    """Return the number of points inside of all patches, from their parts (p, k, k, 2)."""
    along, across = parts[..., 0], parts[..., 1]
    nodes = len(parts) * (parts.shape[1] - 1) ** 2
    level = int(np.maximum(along[:, :, 1:], along[:, :, :-1]).sum()) - along[:, :, 1:].size
    upright = int(np.maximum(across[:, 1:], across[:, :-1]).sum()) - across[:, 1:].size
    return int(nodes + level + upright + ((along - 1) * (across - 1)).sum())


@leaf_kernel
def _emit(faces: IndexArray, count: int, turned: bool, one: int, two: int, three: int) -> int:
    """Write a triangle unless two of its corners are the same; return the number of triangles."""
    if one == two or two == three or three == one:
        return count
    faces[count, 0] = one
    faces[count, 1], faces[count, 2] = (three, two) if turned else (two, three)
    return count + 1


@leaf_kernel
def _zip_chains(
    faces: IndexArray,
    count: int,
    turned: bool,
    chain: LongArray,
    rights: int,
    left: int,
    lefts: int,
) -> int:
    """Write the triangles between two chains of points in the same direction.

    `chain` (m,) has the right chain from 0 and the left one from `left`, with `rights` and `lefts`
    parts. They may share their first and last point.
    """
    i, j, i_end, j_end = 0, 0, rights, lefts
    if chain[0] == chain[left]:
        i, j = 1, 1
        count = _emit(faces, count, turned, chain[0], chain[1], chain[left + 1])
    joined = chain[rights] == chain[left + lefts]
    if joined:
        i_end, j_end = max(rights - 1, 0), lefts - 1  # a collapsed side has no parts
    while i < i_end or j < j_end:
        if j == j_end or (i < i_end and (i + 1) * lefts <= (j + 1) * rights):
            count = _emit(faces, count, turned, chain[i], chain[i + 1], chain[left + j])
            i += 1
        else:
            count = _emit(faces, count, turned, chain[i], chain[left + j + 1], chain[left + j])
            j += 1
    if joined:
        count = _emit(faces, count, turned, chain[i_end], chain[rights], chain[left + j_end])
    return count


@leaf_kernel
def _append(
    chain: LongArray, at: int, layout: Layout, cell: tuple[int, int, int], side: int, back: bool
) -> int:
    """Write the points of a side of a cell to a chain; return the place of the last one.

    They are in the direction of s or t, or go `back` against it.
    """
    patch, i, j = cell
    parts = layout.side_parts[patch, i, j, side]
    x, y = i + (side == AFTER), j + (side == ABOVE)
    start, step = (at + parts, -1) if back else (at, 1)
    chain[start] = layout.nodes[patch, x, y]
    for index in range(1, parts):
        chain[start + step * index] = (
            layout.before[patch, i, j, side] + index * layout.step[patch, i, j, side]
        )
    chain[start + step * parts] = layout.nodes[patch, x + (side <= ABOVE), y + (side > ABOVE)]
    return int(at + parts)


@leaf_kernel
def _fill_small_cell(
    faces: IndexArray, count: int, chain: LongArray, layout: Layout, cell: tuple[int, int, int]
) -> int:
    """Write the triangles of a cell without inner points."""
    patch, i, j = cell
    sides = layout.side_parts[patch, i, j]
    if sides[BEFORE] <= 1 and sides[AFTER] <= 1:
        rights = _append(chain, 0, layout, cell, BELOW, False)
        end = _append(chain, rights + 1, layout, cell, ABOVE, False)
    elif sides[BELOW] <= 1 and sides[ABOVE] <= 1:
        rights = _append(chain, 0, layout, cell, AFTER, False)
        end = _append(chain, rights + 1, layout, cell, BEFORE, False)
    # along a diagonal, so that no triangle has three corners on one side
    elif sides[BEFORE] + sides[BELOW] >= 2 and sides[ABOVE] + sides[AFTER] >= 2:
        at = _append(chain, 0, layout, cell, BEFORE, True)
        rights = _append(chain, at, layout, cell, BELOW, False)
        at = _append(chain, rights + 1, layout, cell, ABOVE, False)
        end = _append(chain, at, layout, cell, AFTER, True)
    else:
        at = _append(chain, 0, layout, cell, BELOW, False)
        rights = _append(chain, at, layout, cell, AFTER, False)
        at = _append(chain, rights + 1, layout, cell, BEFORE, False)
        end = _append(chain, at, layout, cell, ABOVE, False)
    left = rights + 1
    return _zip_chains(faces, count, layout.turned[patch], chain, rights, left, end - left)


@leaf_kernel
def _fill_cell(
    faces: IndexArray, count: int, chain: LongArray, layout: Layout, cell: tuple[int, int, int]
) -> int:
    """Write the triangles of a cell with inner points: a ring along its sides, and the rest."""
    patch, i, j = cell
    start, turned = layout.starts[patch, i, j, 2], layout.turned[patch]
    rows, columns = layout.parts[patch, i, j, 0] - 1, layout.parts[patch, i, j, 1] - 1
    for side in range(4):
        rights = _append(chain, 0, layout, cell, side, False)
        left, length = rights + 1, rows if side <= ABOVE else columns
        for index in range(length):
            if side <= ABOVE:
                x, y = index, 0 if side == BELOW else columns - 1
            else:
                x, y = 0 if side == BEFORE else rows - 1, index
            chain[left + 1 + index] = start + x * columns + y
        chain[left], chain[left + length + 1] = chain[0], chain[rights]
        # the inner points are on the right of the two other sides
        is_right = side in (ABOVE, BEFORE)
        count = _zip_chains(faces, count, turned != is_right, chain, rights, left, length + 1)
    for x in range(rows - 1):
        for y in range(columns - 1):
            one = start + x * columns + y
            two, three, four = one + columns, one + columns + 1, one + 1
            count = _emit(faces, count, turned, one, two, three)
            count = _emit(faces, count, turned, one, three, four)
    return count


@leaf_kernel
def _place_points(
    position: FloatArray, layout: Layout, cell: tuple[int, int, int], along: int, across: int
) -> None:
    """Write s and t of a cell's first node, its sides ABOVE and AFTER, and its inside."""
    patch, i, j = cell
    s, t = layout.knots[patch, 0], layout.knots[patch, 1]
    wide, high, last = s[i + 1] - s[i], t[j + 1] - t[j], layout.parts.shape[1] - 1
    if i > 0 and j > 0:
        at = layout.nodes[patch, i, j] - layout.outside
        position[at, 0], position[at, 1] = s[i], t[j]
    if j < last:
        at, parts = layout.starts[patch, i, j, 0], layout.side_parts[patch, i, j, ABOVE]
        for index in range(1, parts):
            row = at - layout.outside + index - 1
            position[row, 0], position[row, 1] = s[i] + index / parts * wide, t[j + 1]
    if i < last:
        at, parts = layout.starts[patch, i, j, 1], layout.side_parts[patch, i, j, AFTER]
        for index in range(1, parts):
            row = at - layout.outside + index - 1
            position[row, 0], position[row, 1] = s[i + 1], t[j] + index / parts * high
    row = layout.starts[patch, i, j, 2] - layout.outside
    for x in range(1, along):
        for y in range(1, across):
            position[row, 0] = s[i] + x / along * wide
            position[row, 1] = t[j] + y / across * high
            row += 1


@kernel
def lattice_faces(
    layout: Layout, inside: int, triangles: int, longest: int
) -> tuple[FloatArray, IndexArray, IndexArray]:
    """Return s and t (i, 2) of the points inside of patches, and triangles (m, 3) with their patch.

    `inside` is the number of points. `triangles` bounds the number of triangles, and `longest` the
    number of parts of any side.
    """
    position = np.empty((inside, 2))
    faces, labels = np.empty((triangles, 3), np.int32), np.empty(triangles, np.int32)
    chain = np.empty(4 * longest + 8, np.int64)
    count, cells = 0, layout.parts.shape[1]
    for patch in range(len(layout.parts)):
        for i in range(cells):
            for j in range(cells):
                cell, first = (patch, i, j), count
                along, across = layout.parts[patch, i, j]
                _place_points(position, layout, cell, along, across)
                if along > 1 and across > 1:
                    count = _fill_cell(faces, count, chain, layout, cell)
                else:
                    count = _fill_small_cell(faces, count, chain, layout, cell)
                labels[first:count] = patch
    return position, faces[:count].copy(), labels[:count].copy()


def surface_values(
    limited: LimitedCube,
    colours: Callable[[FloatArray], FloatArray],
    surface_samples: int,
    nodes: FloatArray | None = None,
) -> DeviceSurface:
    """Device values at the surface of the printable part of a device's cube."""
    cube = limited.cube
    if not len(cube.lowest):
        return DeviceSurface(limited.base[np.newaxis], "corners")
    if not (limited.free.all() and (cube.lowest == 0).all() and (cube.highest == 1).all()):
        nodes = None
    surface = device_surface(
        cube, lambda values: colours(limited.device(values)), surface_samples, nodes
    )
    return replace(surface, device=limited.device(surface.device))


def device_colours(
    model: DeviceModel,
    surface: DeviceSurface,
    samples: FloatArray | None = None,
    measured: FloatArray | None = None,
) -> DeviceColours:
    """All colours of a device.

    `samples` are further device values, (m, n), to be tried, and `measured` are colours, (r, 3), of
    samples.
    """
    tried, limited = values_between(surface), model.limited
    if samples is not None:
        tried = np.concatenate([tried, samples])
    return DeviceColours(
        limited.cube,
        lambda values: model.lab(limited.device(values)),
        tried[:, limited.free],
        model,
        np.empty((0, 3)) if measured is None else measured,
    )


def count_warnings(points: int, surface_samples: int, density: str) -> list[str]:
    """Return a warning if only the corners of a device's cube were sampled."""
    if density != "corners":
        return []
    if points > surface_samples:
        return [
            f"The corners of the device cube alone are {points} points, more than surface_samples."
        ]
    if points == 1:
        return ["No channel of the device varies: its gamut is one colour."]
    why = (
        f"points on its faces as well would be more than surface_samples, {surface_samples}"
        if surface_samples < MAX_PATCHES
        else "its faces are too many"
    )
    return [f"Only the {points} corners of the device cube were sampled; {why}."]
