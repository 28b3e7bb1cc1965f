"""Volumes and coverage of devices by dense integrals that use nothing of `gamutcore`.

The boundary of a device is taken from the images of the two-dimensional faces of its device cube.
Three channels: signed tetrahedra over the six faces. Four: the outermost radius of all 24 faces by
lightness and hue.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product
from pathlib import Path

import colour
import numpy as np
from scipy.interpolate import RBFInterpolator, RectBivariateSpline

from benchmarks.common import FloatArray

STEPS = {3: 128, 4: 48}
"""Steps along the edges of a face by channels."""

D50 = np.array([0.9642, 1.0, 0.8249])
"""White of the ICC's connection space."""

LIGHTNESS_STEP = 0.5
LIGHTNESSES = np.arange(LIGHTNESS_STEP / 2, 101.0, LIGHTNESS_STEP)
HUES = 1440
PIXEL = 1.5
"""Steps of rings in L*, hues of a turn, and cells in a* and b* for coverage."""

Model = Callable[[FloatArray], FloatArray]
"""From device values between 0 and 1, shape (n, channels), to media-relative CIELAB."""


def faces(channels: int, steps: int) -> list[tuple[FloatArray, int]]:
    """Return device values of each two-dimensional face of the cube, and its orientation."""
    axis = np.linspace(0.0, 1.0, steps + 1)
    one, two = (grid.ravel() for grid in np.meshgrid(axis, axis, indexing="ij"))
    patches = []
    for free in combinations(range(channels), 2):
        fixed = [channel for channel in range(channels) if channel not in free]
        for ends in product((0.0, 1.0), repeat=channels - 2):
            values = np.empty((len(one), channels))
            values[:, free[0]], values[:, free[1]] = one, two
            values[:, fixed] = ends
            outwards = (ends[0] == 1.0) == (fixed[0] != 1)
            patches.append((values, 1 if outwards else -1))
    return patches


@dataclass(frozen=True)
class Solid:
    """A device's solid in CIELAB, from a model of its colours."""

    model: Model
    channels: int

    @cached_property
    def patches(self) -> list[tuple[FloatArray, int]]:
        """Colours of each face as a grid, shape (n + 1, n + 1, 3), and its orientation."""
        steps = STEPS[self.channels]
        shape = (steps + 1, steps + 1, 3)
        return [(self.model(v).reshape(shape), sign) for v, sign in faces(self.channels, steps)]

    @cached_property
    def points(self) -> FloatArray:
        """All colours of the faces, shape (n, 3)."""
        return np.concatenate([grid.reshape(-1, 3) for grid, _ in self.patches])

    @cached_property
    def triangles(self) -> FloatArray:
        """Two triangles for each cell of each face, shape (n, 3, 3)."""
        cells = []
        for grid, sign in self.patches:
            near, left, far, right = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
            for corners in ((near, left, far), (near, far, right)):
                order = corners if sign == 1 else corners[::-1]
                cells.append(np.stack(order, axis=2).reshape(-1, 3, 3))
        return np.concatenate(cells)

    @cached_property
    def volume(self) -> float:
        """Signed tetrahedra for three channels, rings for four."""
        if self.channels == 3:
            one, two, three = np.moveaxis(self.triangles - (50.0, 0.0, 0.0), 1, 0)
            return abs(float(np.einsum("ij,ij->", one, np.cross(two, three)))) / 6
        return self.ring_volume

    @property
    def ring_volume(self) -> float:
        """Volume within the outermost radii."""
        return float(np.sum(self.rings**2)) * LIGHTNESS_STEP * np.pi / HUES

    @cached_property
    def axis(self) -> FloatArray:
        """a* and b* of the line from the darkest to the lightest colour, by lightness."""
        ends = self.points[[np.argmin(self.points[:, 0]), np.argmax(self.points[:, 0])]]
        return self._axis(LIGHTNESSES, ends)

    @staticmethod
    def _axis(lightness: FloatArray, ends: FloatArray) -> FloatArray:
        share = (lightness - ends[0, 0]) / (ends[1, 0] - ends[0, 0])
        axis: FloatArray = ends[0, 1:] + share[..., np.newaxis] * (ends[1, 1:] - ends[0, 1:])
        return axis

    @cached_property
    def rings(self) -> FloatArray:
        """Outermost radius about the axis by lightness and hue, shape (len(LIGHTNESSES), HUES)."""
        ends = self.points[[np.argmin(self.points[:, 0]), np.argmax(self.points[:, 0])]]
        # A shear that makes the axis vertical keeps volumes, and triangles stay flat.
        triangles = self.triangles.copy()
        triangles[..., 1:] -= self._axis(triangles[..., 0], ends)
        lowest, highest = triangles[..., 0].min(axis=1), triangles[..., 0].max(axis=1)
        radii = np.zeros((len(LIGHTNESSES), HUES))
        for ring, lightness in zip(radii, LIGHTNESSES, strict=True):
            _raise_ring(ring, triangles[(lowest < lightness) & (lightness < highest)], lightness)
        return radii

    @cached_property
    def pixels(self) -> list[FloatArray]:
        """Cells of a* and b* within each ring, shape (n, 2)."""
        edge = np.abs(self.points[:, 1:]).max() + 1
        line = np.arange(-edge, edge, PIXEL)
        grid = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
        return [grid[self.contains(index, grid)] for index in range(len(LIGHTNESSES))]

    def coverage_of(self, other: Solid) -> float:
        """Return the share of another solid's volume that this solid contains."""
        common = sum(
            np.count_nonzero(self.contains(index, cells))
            for index, cells in enumerate(other.pixels)
        )
        return common / sum(map(len, other.pixels))

    def contains(self, index: int, pixels: FloatArray) -> FloatArray:
        """Return which a*, b* lie within the ring of a lightness."""
        offset = pixels - self.axis[index]
        hue = np.arctan2(offset[:, 1], offset[:, 0]) * HUES / (2 * np.pi)
        ring = np.interp(hue, np.arange(HUES), self.rings[index], period=HUES)
        return np.asarray(np.hypot(*offset.T) < ring)


def _raise_ring(ring: FloatArray, triangles: FloatArray, lightness: float) -> None:
    """Raise the radii of a ring to the triangles that its plane cuts."""
    height = triangles[..., 0] - lightness
    above = height > 0
    # the corner that lies alone on its side of the plane
    alone = np.argmax(above == (above.sum(axis=1) == 1)[:, np.newaxis], axis=1)
    rows = np.arange(len(triangles))
    top, level = triangles[rows, alone, 1:], height[rows, alone]
    ends = []
    for turn in (1, 2):
        other = (alone + turn) % 3
        share = (level / (level - height[rows, other]))[:, np.newaxis]
        ends.append(top + share * (triangles[rows, other, 1:] - top))
    one, two = ends
    bins = np.arctan2(np.stack([one[:, 1], two[:, 1]]), np.stack([one[:, 0], two[:, 0]]))
    bins *= HUES / (2 * np.pi)
    swing = (bins[1] - bins[0] + HUES / 2) % HUES - HUES / 2
    start = np.where(swing < 0, bins[0] + swing, bins[0])
    first = np.ceil(start).astype(int)
    counts = np.maximum(np.floor(start + np.abs(swing)).astype(int) - first + 1, 0)
    segment = np.repeat(rows, counts)
    hue = first[segment] + np.arange(len(segment)) - np.repeat(np.cumsum(counts) - counts, counts)
    ray = np.stack([np.cos(hue * 2 * np.pi / HUES), np.sin(hue * 2 * np.pi / HUES)], axis=1)
    side = two[segment] - one[segment]
    crossed = ray[:, 0] * side[:, 1] - ray[:, 1] * side[:, 0]
    moment = one[segment, 0] * side[:, 1] - one[segment, 1] * side[:, 0]
    valid = np.abs(crossed) > 1e-12
    np.maximum.at(ring, hue[valid] % HUES, moment[valid] / crossed[valid])


def patches_of(path: Path, prefix: str) -> FloatArray:
    """Return the columns of a CGATS file whose names begin so, shape (n, columns)."""
    lines = path.read_text("latin-1").splitlines()
    names = lines[lines.index("BEGIN_DATA_FORMAT") + 1].split()
    rows = [line.split() for line in lines[lines.index("BEGIN_DATA") + 1 :]]
    rows = rows[: next(i for i, row in enumerate(rows) if row[:1] == ["END_DATA"])]
    columns = [index for index, name in enumerate(names) if name.startswith(prefix)]
    return np.array([[float(row[column]) for column in columns] for row in rows if row])


def ink_model(path: Path) -> Model:
    """Return a cubic radial interpolation of measured inks, relative to the paper."""
    ink, xyz = patches_of(path, "CMYK_") / 100, patches_of(path, "XYZ_")
    white = xyz[ink.sum(axis=1) == 0].mean(axis=0)
    lab = colour.XYZ_to_Lab(xyz / white * D50, colour.XYZ_to_xy(D50))
    ink, rows = np.unique(ink, axis=0, return_inverse=True)
    mean = np.stack([lab[rows.ravel() == row].mean(axis=0) for row in range(len(ink))])
    return RBFInterpolator(ink, mean, kernel="cubic")


def display_model(path: Path) -> Model:
    """Return a cubic spline of each measured face of an RGB cube, relative to its white."""
    rgb, xyz = patches_of(path, "RGB_"), patches_of(path, "XYZ_")
    white = xyz[np.all(rgb == rgb.max(), axis=1)].mean(axis=0)
    matrix = colour.adaptation.matrix_chromatic_adaptation_VonKries(
        white / white[1], D50, transform="Bradford"
    )
    lab = colour.XYZ_to_Lab(xyz / white[1] @ matrix.T, colour.XYZ_to_xy(D50))
    levels = np.unique(rgb)
    axis = levels / levels[-1]
    splines = {}
    for fixed, end in product(range(3), (0.0, 1.0)):
        rows = np.flatnonzero(rgb[:, fixed] == end * levels[-1])
        free = [channel for channel in range(3) if channel != fixed]
        rows = rows[np.lexsort([rgb[rows, free[1]], rgb[rows, free[0]]])]
        grid = lab[rows].reshape(len(axis), len(axis), 3)
        splines[fixed, end] = [RectBivariateSpline(axis, axis, grid[..., k]) for k in range(3)]

    def model(values: FloatArray) -> FloatArray:
        fixed, end = next(
            (channel, end) for channel, end in splines if np.all(values[:, channel] == end)
        )
        free = [channel for channel in range(3) if channel != fixed]
        return np.stack([spline.ev(*values[:, free].T) for spline in splines[fixed, end]], axis=1)

    return model
