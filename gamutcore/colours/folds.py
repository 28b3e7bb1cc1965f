"""Folds inside of a device's cube: sheets of colours that can be outside of the cube's faces.

A device folds where its colours turn back although the device values go on. The boundary of its
gamut then has pieces of the inside of the cube. Such a piece is a fold of a three-dimensional face
of the cut cube: the faces of the cube itself, or sections of the limit of the sum of inks.

Each of these solids has a lattice of tetrahedra. The colours are taken as linear in each. The
boundary of their image then consists of triangles at the surface of the solid, and of triangles
between two tetrahedra of opposite orientation. The latter are the folds.
"""

from __future__ import annotations

from itertools import combinations, permutations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.arrays import BooleanArray, FloatArray, IndexArray, LongArray
from gamutcore.colours.ink_limits import InkCube, corners_within, printable_values

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

_MOST_SOLIDS = 4096
"""Largest number of solids that are searched; nine inks have more."""

_COARSE = 300_000
"""Number of device values in all solids at which folds are sought."""

_FINE = 300_000
"""Number of cells around the folds."""

_DIVISIONS = 64
"""Largest number of cells along an edge of a solid in the search."""

_LARGEST = 128
"""Largest number of cells along an edge of a solid after their division."""

_NEAR = 0.05
"""Distance of known values from a solid, as a share of the range of a channel."""

_TINY = 1e-9

_PATHS = np.array(list(permutations(range(3))))
"""The tetrahedra of a cell: paths along the axes from its lowest corner to its highest (Kuhn)."""

_TURNS = np.array([[list(map(tuple, _PATHS)).index(path) for path in each] for each in (
    [(b, a, c) for a, b, c in _PATHS], [(a, c, b) for a, b, c in _PATHS],
    [(b, c, a) for a, b, c in _PATHS])])  # fmt: skip
"""The tetrahedron beyond the triangle without the second corner of each, without the third, and, in
the cell beyond, without the first."""

_ODD = np.array([np.linalg.det(np.eye(3)[path]) < 0 for path in _PATHS])


class Sheets(NamedTuple):
    """Triangles (m, 3) of printable device values (n, k), and the colours of these."""

    values: FloatArray
    points: FloatArray
    corners: IndexArray


class _Solid(NamedTuple):
    """A three-dimensional face: its free channels, the others' values, and where the limit cuts.

    `dependent` is the channel that takes the rest of the limit; −1 for a face of the cube.
    """

    free: tuple[int, ...]
    fixed: FloatArray
    dependent: int


def fold_sheets(
    cube: InkCube,
    colours: Callable[[FloatArray], FloatArray],
    outside: Callable[[FloatArray], FloatArray],
    threshold: float | None,
    known: FloatArray,
) -> Sheets | None:
    """Return the folds of a device that are outside of a boundary; None without any.

    `colours` maps values of the cube to colours, and `outside` these to their distance from the
    boundary, 0 inside. Folds are sought around `known` values (s, k), and, with a threshold, where
    the distance is above it.
    """
    if len(cube.lowest) < 3:
        return None
    solids = list(_solids(cube))
    if len(solids) > _MOST_SOLIDS:
        return None
    divisions = _DIVISIONS if threshold is None else _divisions(len(solids))
    chosen = [_cells_of(cube, solid, known, divisions) for solid in solids]
    if threshold is not None:
        places = _triples(np.arange((divisions + 1) ** 3), divisions + 1) / divisions
        for index, solid in enumerate(solids):
            distance = outside(colours(_values(cube, solid, places)[0]))
            nodes = (distance > threshold).reshape((divisions + 1,) * 3)
            chosen[index] = np.concatenate([chosen[index], _cells_at(nodes)])
    chosen = [_with_neighbours(cells, divisions) for cells in chosen]
    count = sum(len(cells) for cells in chosen)
    if not count:
        return None
    parts = 1 if threshold is None else _parts(count, divisions)
    sheets = [
        _sheets_of(cube, solid, colours, _divided(cells, parts), divisions * parts)
        for solid, cells in zip(solids, chosen, strict=True)
        if len(cells)
    ]
    first = np.cumsum([0, *(len(sheet.values) for sheet in sheets)])
    points = np.concatenate([sheet.points for sheet in sheets])
    corners = np.concatenate([sheet.corners + at for sheet, at in zip(sheets, first, strict=False)])
    corners = corners[(outside(points) > 0.0)[corners].any(axis=1)]
    if not len(corners):
        return None
    used, corners = np.unique(corners, return_inverse=True)
    values = np.concatenate([sheet.values for sheet in sheets])[used]
    return Sheets(values, points[used], corners.reshape(-1, 3).astype(np.int32))


def _solids(cube: InkCube) -> Iterator[_Solid]:
    """Yield the three-dimensional faces of a cut cube."""
    channels = range(len(cube.lowest))
    for free in combinations(channels, 3):
        lowest = float(cube.lowest[list(free)].sum())
        for fixed in corners_within(cube, *free):
            if fixed.sum() + lowest < cube.limit - _TINY:
                yield _Solid(free, fixed, -1)
    if not cube.cut:
        return
    for first, second, third, last in combinations(channels, 4):
        axes = [first, second, third, last]
        low, high = float(cube.lowest[axes].sum()), float(cube.highest[axes].sum())
        for fixed in corners_within(cube, *axes):
            if low + _TINY < cube.limit - fixed.sum() < high - _TINY:
                yield _Solid((first, second, third), fixed, last)


def _values(cube: InkCube, solid: _Solid, places: FloatArray) -> tuple[FloatArray, BooleanArray]:
    """Return printable values (m, k) at positions (m, 3), and which are no more than the limit's.

    Positions are shares of the ranges of the free channels. Those beyond the limit are moved to it.
    """
    values = np.tile(solid.fixed, (len(places), 1))
    axes, last = list(solid.free), solid.dependent
    low, high = cube.lowest[axes], cube.highest[axes]
    values[:, axes] = low + places * (high - low)
    if last < 0:
        inner = values.sum(axis=1) < cube.limit - _TINY
    else:
        rest = cube.limit - values.sum(axis=1)
        values[:, last] = np.clip(rest, cube.lowest[last], cube.highest[last])
        inner = (rest > cube.lowest[last] + _TINY) & (rest < cube.highest[last] - _TINY)
    return printable_values(cube, values), inner


def _cells_of(cube: InkCube, solid: _Solid, values: FloatArray, divisions: int) -> LongArray:
    """Return the cells (c, 3) of values (s, k) that are near a solid."""
    axes, extent = list(solid.free), cube.highest - cube.lowest
    others = np.setdiff1d(np.arange(len(extent)), [*axes, solid.dependent])
    away = np.abs(values - solid.fixed)[:, others] / extent[others]
    near = (away <= _NEAR).all(axis=1)
    if solid.dependent >= 0:
        near &= values.sum(axis=1) > cube.limit - _NEAR
    places = (values[near][:, axes] - cube.lowest[axes]) / extent[axes]
    cells: LongArray = np.clip((places * divisions).astype(np.int64), 0, divisions - 1)
    return cells


def _cells_at(nodes: BooleanArray) -> LongArray:
    """Return the cells (c, 3) that have one of the nodes as a corner."""
    count = nodes.shape[0] - 1
    cells = np.zeros((count,) * 3, bool)
    for x, y, z in np.ndindex(2, 2, 2):
        cells |= nodes[x : x + count, y : y + count, z : z + count]
    return np.argwhere(cells)


def _with_neighbours(cells: LongArray, divisions: int) -> LongArray:
    """Return cells (c, 3) and those around them, each once."""
    around = _triples(np.arange(27), 3) - 1
    for axis in range(3):  # along one axis after the other, to keep intermediate results small
        steps = around[(np.delete(around, axis, axis=1) == 0).all(axis=1)]
        cells = np.unique((cells[:, np.newaxis] + steps).reshape(-1, 3), axis=0)
    return cells[((cells >= 0) & (cells < divisions)).all(axis=1)]


def _divisions(solids: int) -> int:
    """Return the number of cells along an edge in the search of all of the solids."""
    return int(min(int((_COARSE / solids) ** (1 / 3)) - 1, _DIVISIONS))


def _parts(cells: int, divisions: int) -> int:
    """Return the number of parts into which cells are divided along an edge."""
    return int(max(min((_FINE / cells) ** (1 / 3), _LARGEST / divisions), 1))


def _divided(cells: LongArray, parts: int) -> LongArray:
    """Return the parts³ parts of each cell."""
    inner = _triples(np.arange(parts**3), parts)
    return (cells[:, np.newaxis] * parts + inner).reshape(-1, 3)


def _triples(numbers: LongArray, count: int) -> LongArray:
    return np.stack([numbers // count**2, numbers // count % count, numbers % count], axis=-1)


def _sheets_of(
    cube: InkCube,
    solid: _Solid,
    colours: Callable[[FloatArray], FloatArray],
    cells: LongArray,
    divisions: int,
) -> Sheets:
    """Return the folds of a solid in some cells (c, 3) of its lattice."""
    side = divisions + 1
    strides = np.array([side**2, side, 1])
    keys = np.sort(cells @ strides)
    steps = np.zeros((len(_PATHS), 4, 3), np.int64)
    steps[:, 1:] = np.cumsum(np.eye(3, dtype=np.int64)[_PATHS], axis=1)
    corner_keys = keys[:, np.newaxis, np.newaxis] + steps @ strides  # (c, 6, 4)
    nodes, corner = np.unique(corner_keys, return_inverse=True)
    corner = corner.reshape(corner_keys.shape)
    values, inner = _values(cube, solid, _triples(nodes, side) / divisions)
    points = colours(values)
    one = points[corner[..., 0]]
    first, second, third = (points[corner[..., place]] - one for place in (1, 2, 3))
    determinants = np.einsum("cti,cti->ct", first, np.cross(second, third))
    turned: BooleanArray = np.asarray((determinants < 0.0) != _ODD)
    # beyond the limit, tetrahedra are flat
    real: BooleanArray = np.asarray(inner[corner].any(axis=2))

    pairs = []
    for omitted, turn in ((1, _TURNS[0]), (2, _TURNS[1])):
        folded = (turned != turned[:, turn]) & real & real[:, turn]
        folded &= np.arange(len(turn)) < turn  # once
        pairs.append(np.delete(corner, omitted, axis=2)[folded])
    for tetrahedron, path in enumerate(_PATHS):
        beyond = np.minimum(np.searchsorted(keys, keys + strides[path[0]]), len(keys) - 1)
        other = _TURNS[2][tetrahedron]
        folded = (keys[beyond] == keys + strides[path[0]]) & real[:, tetrahedron]
        folded &= real[beyond, other] & (turned[:, tetrahedron] != turned[beyond, other])
        pairs.append(corner[folded, tetrahedron, 1:])
    return Sheets(values, points, np.concatenate(pairs).astype(np.int32))
