"""Comparison of two gamuts: volumes, intersection, coverage, by sectors of hue.

The surface of the intersection of A and B is the part of A's surface inside B and the part of B's
surface inside A. The divergence theorem turns fluxes through these parts into volumes
(`gamutcore.queries.volume_cells`), and `gamutcore.queries.overlap` finds the parts. Each level may
have its own centre.

Surfaces that coincide have no side. B is therefore magnified by `STRETCH` about its centre, so that
a surface which both gamuts share counts as A's alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.corner_table import opposite_corners
from gamutcore.errors import OptionError
from gamutcore.queries.index import Level, LevelIndex, as_index
from gamutcore.queries.overlap import overlap_cells
from gamutcore.queries.volume_cells import Cells, cells_of, enclosed_cells
from gamutcore.shown import Shown

__all__ = [
    "MOST_SECTORS",
    "CellVolumes",
    "Comparison",
    "Overlap",
    "cell_volumes",
    "checked_sectors",
    "compare",
]

STRETCH = 1.0 + 2.0**-36
"""Magnification of the second level. It separates shared surfaces by 10⁻⁹ units in CIELAB, ten
thousand times the rounding errors. Volumes change by less than 5 × 10⁻¹¹ of the second volume."""

MOST_SECTORS = 3600
"""Largest number of sectors: tenths of a degree."""

Value = TypeVar("Value", float, FloatArray)


@dataclass(frozen=True, eq=False, repr=False)
class Overlap(Shown, Generic[Value]):
    """Volumes of two gamuts and of their intersection, as numbers or as arrays.

    Attributes
    ----------
    volume_a, volume_b, intersection : float or (n,) float64
        In cubic units of the colour space.
    """

    volume_a: Value
    volume_b: Value
    intersection: Value

    @property
    def union(self) -> Value:
        """Volume inside at least one gamut."""
        return self.volume_a + self.volume_b - self.intersection

    @property
    def symmetric_difference(self) -> Value:
        """Volume inside exactly one gamut."""
        return self.volume_a + self.volume_b - 2.0 * self.intersection

    @property
    def a_covers_b(self) -> Value:
        """Coverage of B by A: intersection ÷ volume of B. NaN where B has no volume."""
        return _ratio(self.intersection, self.volume_b)

    @property
    def b_covers_a(self) -> Value:
        """Coverage of A by B: intersection ÷ volume of A. NaN where A has no volume."""
        return _ratio(self.intersection, self.volume_a)

    @property
    def jaccard(self) -> Value:
        """Jaccard index: intersection ÷ union. NaN where both have no volume."""
        return _ratio(self.intersection, self.union)


def _ratio(part: Any, whole: Any) -> Any:  # noqa: ANN401  # numbers and arrays alike
    with np.errstate(invalid="ignore", divide="ignore"):
        found = np.where(whole > 0.0, np.divide(part, whole), np.nan)
    return found if found.ndim else float(found)


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Overlap[float]):
    """Comparison of two gamuts, A and B.

    Attributes
    ----------
    volume_a, volume_b, intersection : float
    hues : (n + 1,) float64
        Hues between the sectors, from 0 to 360 degrees.
    sectors : Overlap
        The same figures by sector of hue, as arrays of n.
    """

    hues: FloatArray
    sectors: Overlap[FloatArray]


class CellVolumes(NamedTuple):
    """Volumes of two gamuts and of their intersection, (bands, sectors) by lightness and hue."""

    a: FloatArray
    b: FloatArray
    intersection: FloatArray


def compare(level_a: Level, level_b: Level, sectors: int = 36) -> Comparison:
    """Compare two gamuts in the same colour space.

    Parameters
    ----------
    level_a, level_b : LevelIndex or (vertices, faces, centre)
        The centres may differ.
    sectors : int, optional
        Number of equal sectors of hue, the angle of the second and third coordinate, from 1 to
        `MOST_SECTORS`. The first sector begins at 0°.

    Returns
    -------
    Comparison
        Exact to about 10⁻¹⁰ of the volumes.

    Raises
    ------
    OptionError
        The number of sectors is not accepted.
    MeshError, InvalidPointsError
        As for `build_index`.

    Notes
    -----
    Exchanging the levels changes the intersection by rounding errors and by the effect of
    `STRETCH`.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> faces, centre = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], np.full(3, 0.1)
    >>> found = compare((corners, faces, centre), (corners / 2, faces, centre))
    >>> round(found.a_covers_b, 9), round(found.b_covers_a, 9)
    (1.0, 0.125)
    """
    count = checked_sectors(sectors)
    cells = cells_of(count, np.empty(0))
    by_hue = [volumes[0] for volumes in cell_volumes(as_index(level_a), as_index(level_b), cells)]
    totals = [float(volumes.sum()) for volumes in by_hue]
    hues = np.linspace(0.0, 360.0, count + 1)
    return Comparison(totals[0], totals[1], totals[2], hues, Overlap[FloatArray](*by_hue))


def checked_sectors(sectors: int) -> int:
    """Return the number of sectors; OptionError unless it is whole, from 1 to `MOST_SECTORS`."""
    if isinstance(sectors, bool) or not 1 <= sectors <= MOST_SECTORS or sectors != int(sectors):
        raise OptionError.refusal("sectors", sectors, f"a whole number from 1 to {MOST_SECTORS}")
    return int(sectors)


def cell_volumes(one: LevelIndex, other: LevelIndex, cells: Cells) -> CellVolumes:
    """Return the volumes of two levels in one colour space, and of their intersection, in cells."""
    stretched = other.centre + STRETCH * (other.vertices - other.centre)
    common = overlap_cells(one.vertices, one.faces, other, _neighbours(other), STRETCH, cells)
    common += overlap_cells(stretched, other.faces, one, _neighbours(one), 1.0, cells)
    a = enclosed_cells(one.vertices, one.faces, cells)
    b = enclosed_cells(other.vertices, other.faces, cells)
    return CellVolumes(a, b, np.clip(common, 0.0, np.minimum(a, b)))


def _neighbours(level: LevelIndex) -> IndexArray:
    """Return the face across the edge opposite to each corner of each face, (F, 3)."""
    return opposite_corners(level.faces, len(level.vertices)).reshape(-1, 3) // np.int32(3)
