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

    `points` maps device values (m, k) in the cube to colours, as those of `SurfaceColours`. A
    boundary is likely to miss the colours of the device values `tried` (j, k).
    """

    cube: InkCube
    points: Callable[[FloatArray], FloatArray]
    tried: FloatArray


class AbsoluteColours(NamedTuple):
    """What media-relative colours are with the intent absolute, and as the device's own.

    `matrix` (3, 3) leads from tristimulus values relative to D50, Y = 1 for the white of the
    medium, to absolute ones. These are the device's own in all spaces but ICC's CIELAB if
    `as_measured`. `own` (3, 3) leads to the device's own values, without adaptation and up to a
    common factor; None if they are the absolute ones.
    """

    matrix: FloatArray
    as_measured: bool = False
    own: FloatArray | None = None

    def own_from(self, intent: object) -> FloatArray | None:
        """Return the matrix from the colours of an intent to the device's own; None for unity."""
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
    own : DeviceColours, optional
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
    own: DeviceColours | None = None
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
        found, first, which = np.unique(keys, return_index=True, return_inverse=True)
        edges = np.column_stack(np.divmod(found, len(self.vertices)))
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
        reached = np.zeros((len(self.edges), self.cells + 1), np.int64)
        np.cumsum(edge_parts, axis=1, out=reached[:, 1:])
        inner = np.maximum(reached[:, -1] - 1, 0)
        outside = len(self.vertices) + int(inner.sum())
        inside = inside_count(parts)
        layout = Layout(
            self.knots,
            parts,
            self.which,
            self.is_reversed,
            self.edges,
            reached,
            len(self.vertices) + np.cumsum(inner) - inner,
            self._turned(),
        )
        # Euler's formula for each patch
        triangles = 2 * inside + int(reached[self.which, -1].sum())
        patch, position, corners, labels = lattice_faces(
            layout, outside, inside, triangles, int(max(parts.max(), edge_parts.max()))
        )
        inner_values = self.device(patch, position[:, 0], position[:, 1])
        device = np.concatenate([self.vertices, self._on_edges(edge_parts), inner_values])
        channels = device.shape[1]
        return device, SurfaceFaces(corners, labels, channels == 3) if channels > 2 else None

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
        kept = (piece > 0) | (number > 0)
        ends = self.vertices[self.edges[edge]]
        values: FloatArray = (ends[:, 0] * (1 - at) + ends[:, 1] * at)[kept]
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
    """How patches share edges, and how finely everything is divided.

    `knots` (p, 2, k + 1) are the lines of the cells along s and t, and `parts` (p, k, k, 2) the
    numbers of parts of each cell. `which` (p, 4) is the edge at each side of a patch, and
    `is_reversed` (p, 4) tells whether it runs against s or t. `edges` (e, 2) are corners.
    `reached` (e, k + 1) counts the parts of an edge before each of its coarse nodes, and
    `edge_start` (e,) numbers its first inner point. The triangles of patches that are `turned` (p,)
    are clockwise in s and t.
    """

    knots: FloatArray
    parts: LongArray
    which: LongArray
    is_reversed: BooleanArray
    edges: LongArray
    reached: LongArray
    edge_start: LongArray
    turned: BooleanArray


def inside_count(parts: LongArray) -> int:
    """Return the number of points inside of all patches, from their parts (p, k, k, 2)."""
    along, across = parts[..., 0], parts[..., 1]
    nodes = len(parts) * (parts.shape[1] - 1) ** 2
    level = int(np.maximum(along[:, :, 1:], along[:, :, :-1]).sum()) - along[:, :, 1:].size
    upright = int(np.maximum(across[:, 1:], across[:, :-1]).sum()) - across[:, 1:].size
    return int(nodes + level + upright + ((along - 1) * (across - 1)).sum())


@leaf_kernel
def _side_parts(layout: Layout, patch: int, i: int, j: int, side: int) -> int:
    """Return the number of parts of a side of the cell (i, j)."""
    parts, last = layout.parts, layout.parts.shape[1] - 1
    direction = 0 if side <= ABOVE else 1
    x, y = i, j  # the cell beyond
    if side == BELOW:
        y -= 1
    elif side == ABOVE:
        y += 1
    elif side == BEFORE:
        x -= 1
    else:
        x += 1
    if 0 <= x <= last and 0 <= y <= last:
        return int(max(parts[patch, i, j, direction], parts[patch, x, y, direction]))
    edge, piece = layout.which[patch, side], i if direction == 0 else j
    if layout.is_reversed[patch, side]:
        piece = last - piece
    return int(layout.reached[edge, piece + 1] - layout.reached[edge, piece])


@leaf_kernel
def _edge_point(layout: Layout, patch: int, side: int, node: int, further: int) -> int:
    """Return the point on an edge of a patch, by its number of parts beyond a coarse node."""
    edge, last = layout.which[patch, side], layout.reached.shape[1] - 1
    reached = layout.reached
    if layout.is_reversed[patch, side]:
        at = reached[edge, last - node] - further
    else:
        at = reached[edge, node] + further
    if at == 0:
        return int(layout.edges[edge, 0])
    if at == reached[edge, last]:
        return int(layout.edges[edge, 1])
    return int(layout.edge_start[edge] + at - 1)


@leaf_kernel
def _node(layout: Layout, patch: int, start: int, i: int, j: int) -> int:
    """Return the point at a coarse node of a patch, whose inner nodes have numbers from `start`."""
    cells = layout.parts.shape[1]
    if j == 0:
        return _edge_point(layout, patch, BELOW, i, 0)
    if j == cells:
        return _edge_point(layout, patch, ABOVE, i, 0)
    if i == 0:
        return _edge_point(layout, patch, BEFORE, j, 0)
    if i == cells:
        return _edge_point(layout, patch, AFTER, j, 0)
    return int(start + (i - 1) * (cells - 1) + j - 1)


@leaf_kernel
def _emit(faces: IndexArray, count: int, turned: bool, one: int, two: int, three: int) -> int:
    """Write a triangle unless two of its corners are the same; return the number of triangles."""
    if one == two or two == three or three == one:
        return count
    faces[count, 0] = one
    faces[count, 1], faces[count, 2] = (three, two) if turned else (two, three)
    return count + 1


@leaf_kernel
def _zip_ring(
    faces: IndexArray, count: int, turned: bool, chain: LongArray, outer: int, inner: int
) -> int:
    """Write the triangles between a side of a cell and the inner points next to it.

    `chain` (m,) has the points of the side, then the inner points on its left. The side has `outer`
    parts; its `inner` points are at multiples of 1 ÷ (inner + 1).
    """
    i, j, left = 0, 0, outer + 1
    while i < outer or j < inner - 1:
        if j == inner - 1 or (i < outer and (i + 1) * (inner + 1) <= (j + 2) * outer):
            count = _emit(faces, count, turned, chain[i], chain[i + 1], chain[left + j])
            i += 1
        else:
            count = _emit(faces, count, turned, chain[i], chain[left + j + 1], chain[left + j])
            j += 1
    return count


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
        i_end, j_end = rights - 1, lefts - 1
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
def _append(chain: LongArray, at: int, sides: LongArray, side: int, parts: int, back: bool) -> int:
    """Append a side of a cell to a chain, without its first point if the chain has one."""
    for index in range(parts + 1):
        chain[at + index] = sides[side, parts - index if back else index]
    return at + parts


@leaf_kernel
def _fill_small_cell(
    faces: IndexArray,
    count: int,
    turned: bool,
    chain: LongArray,
    sides: LongArray,
    side_parts: LongArray,
) -> int:
    """Write the triangles of a cell without inner points, given the parts of its sides."""
    below, above, before, after = (
        side_parts[BELOW],
        side_parts[ABOVE],
        side_parts[BEFORE],
        side_parts[AFTER],
    )
    if before <= 1 and after <= 1:
        _append(chain, 0, sides, BELOW, below, False)
        _append(chain, below + 1, sides, ABOVE, above, False)
        return _zip_chains(faces, count, turned, chain, below, below + 1, above)
    if below <= 1 and above <= 1:
        _append(chain, 0, sides, AFTER, after, False)
        _append(chain, after + 1, sides, BEFORE, before, False)
        return _zip_chains(faces, count, turned, chain, after, after + 1, before)
    # along a diagonal, so that no triangle has three corners on one side
    if before + below >= 2 and above + after >= 2:
        at = _append(chain, 0, sides, BEFORE, before, True)
        rights = _append(chain, at, sides, BELOW, below, False)
        at = _append(chain, rights + 1, sides, ABOVE, above, False)
        _append(chain, at, sides, AFTER, after, True)
        return _zip_chains(faces, count, turned, chain, rights, rights + 1, above + after)
    at = _append(chain, 0, sides, BELOW, below, False)
    rights = _append(chain, at, sides, AFTER, after, False)
    at = _append(chain, rights + 1, sides, BEFORE, before, False)
    _append(chain, at, sides, ABOVE, above, False)
    return _zip_chains(faces, count, turned, chain, rights, rights + 1, before + above)


@leaf_kernel
def _fill_cell(
    faces: IndexArray,
    count: int,
    turned: bool,
    chain: LongArray,
    sides: LongArray,
    side_parts: LongArray,
    along: int,
    across: int,
    start: int,
) -> int:
    """Write the triangles of a cell whose inner points have numbers from `start`."""
    rows, columns = along - 1, across - 1
    for side in range(4):
        outer = side_parts[side]
        _append(chain, 0, sides, side, outer, False)
        inner, length = outer + 1, rows if side <= ABOVE else columns
        for index in range(length):
            if side <= ABOVE:
                x, y = index, 0 if side == BELOW else columns - 1
            else:
                x, y = 0 if side == BEFORE else rows - 1, index
            chain[inner + index] = start + x * columns + y
        # the inner points are on the right of the two other sides
        is_right = side in (ABOVE, BEFORE)
        count = _zip_ring(faces, count, turned != is_right, chain, outer, length)
    for x in range(rows - 1):
        for y in range(columns - 1):
            one = start + x * columns + y
            two, three, four = one + columns, one + columns + 1, one + 1
            count = _emit(faces, count, turned, one, two, three)
            count = _emit(faces, count, turned, one, three, four)
    return count


@leaf_kernel
def _gather_side(
    layout: Layout,
    sides: LongArray,
    side_parts: LongArray,
    level: LongArray,
    upright: LongArray,
    nodes: int,
    patch: int,
    i: int,
    j: int,
    side: int,
) -> None:
    """Write the points of a side of the cell (i, j), in the direction of s or t, to `sides`.

    `level` and `upright` (k, k) have the first inner points of the cells' sides ABOVE and AFTER.
    """
    cells, some = layout.parts.shape[1], side_parts[side]
    if side <= ABOVE:
        line, piece = (j if side == BELOW else j + 1), i
        sides[side, 0] = _node(layout, patch, nodes, i, line)
        sides[side, some] = _node(layout, patch, nodes, i + 1, line)
        start = level[i, line - 1]
    else:
        line, piece = (i if side == BEFORE else i + 1), j
        sides[side, 0] = _node(layout, patch, nodes, line, j)
        sides[side, some] = _node(layout, patch, nodes, line, j + 1)
        start = upright[line - 1, j]
    on_edge = line in (0, cells)
    for index in range(1, some):
        if on_edge:
            sides[side, index] = _edge_point(layout, patch, side, piece, index)
        else:
            sides[side, index] = start + index - 1


@kernel
def lattice_faces(  # noqa: C901, PLR0912  # one pass over all cells
    layout: Layout, outside: int, inside: int, triangles: int, longest: int
) -> tuple[LongArray, FloatArray, IndexArray, IndexArray]:
    """Return the patch (i,), s and t (i, 2) of inner points, and triangles (m, 3) with their patch.

    `outside` is the number of corners and points on edges, and `inside` that of the other points.
    `triangles` bounds the number of triangles, and `longest` the number of parts of any side.
    """
    knots, parts = layout.knots, layout.parts
    cells = parts.shape[1]
    owner, position = np.empty(inside, np.int64), np.empty((inside, 2))
    faces, labels = np.empty((triangles, 3), np.int32), np.empty(triangles, np.int32)
    side_parts, sides = np.empty(4, np.int64), np.empty((4, longest + 1), np.int64)
    chain = np.empty(4 * longest + 8, np.int64)
    level, upright = np.zeros((cells, cells), np.int64), np.zeros((cells, cells), np.int64)
    count, used = 0, 0
    for patch in range(len(parts)):
        nodes = outside + used
        for i in range(1, cells):
            for j in range(1, cells):
                position[used, 0], position[used, 1] = knots[patch, 0, i], knots[patch, 1, j]
                used += 1
        for i in range(cells):
            for j in range(cells):
                low_s, low_t = knots[patch, 0, i], knots[patch, 1, j]
                wide, high = knots[patch, 0, i + 1] - low_s, knots[patch, 1, j + 1] - low_t
                for side in range(4):
                    side_parts[side] = _side_parts(layout, patch, i, j, side)
                # points of the sides towards lower cells exist already
                if j + 1 < cells:
                    level[i, j] = outside + used
                    for index in range(1, side_parts[ABOVE]):
                        position[used, 0] = low_s + index / side_parts[ABOVE] * wide
                        position[used, 1] = knots[patch, 1, j + 1]
                        used += 1
                if i + 1 < cells:
                    upright[i, j] = outside + used
                    for index in range(1, side_parts[AFTER]):
                        position[used, 0] = knots[patch, 0, i + 1]
                        position[used, 1] = low_t + index / side_parts[AFTER] * high
                        used += 1
                for side in range(4):
                    _gather_side(
                        layout, sides, side_parts, level, upright, nodes, patch, i, j, side
                    )
                along, across = parts[patch, i, j, 0], parts[patch, i, j, 1]
                first, turned = count, layout.turned[patch]
                if along > 1 and across > 1:
                    start = outside + used
                    for x in range(1, along):
                        for y in range(1, across):
                            position[used, 0] = low_s + x / along * wide
                            position[used, 1] = low_t + y / across * high
                            used += 1
                    count = _fill_cell(
                        faces, count, turned, chain, sides, side_parts, along, across, start
                    )
                else:
                    count = _fill_small_cell(faces, count, turned, chain, sides, side_parts)
                labels[first:count] = patch
        owner[nodes - outside : used] = patch
    return owner, position, faces[:count].copy(), labels[:count].copy()


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
    limited: LimitedCube,
    surface: DeviceSurface,
    lab: Callable[[FloatArray], FloatArray],
    samples: FloatArray | None = None,
) -> DeviceColours:
    """All colours of a device; `samples` are further device values, (m, n), to be tried."""
    tried = values_between(surface)
    if samples is not None:
        tried = np.concatenate([tried, samples])
    return DeviceColours(
        limited.cube, lambda values: lab(limited.device(values)), tried[:, limited.free]
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
