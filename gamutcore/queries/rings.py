"""Gamut rings: the volume of a gamut by hue and lightness, drawn in a plane.

The ring of the lightness L* is a closed curve around the neutral axis. In each sector of hue, the
area within the ring is the volume of the gamut in this sector from the darkest colour up to L*:

    r(L*, h)² Δh / 2 = V(L*, h),   so   r(L*, h) = √(2 V(L*, h) / Δh),

with the width Δh of the sector in radians. The outer ring therefore encloses an area as large as
the volume of the gamut. The radius is the root of the sum of squared chromas over unit steps of
lightness, hence the names a*_RSS and b*_RSS of the axes.

With a reference, the band between the rings of L₁ and L₂ is divided. The intersection of both
gamuts, V∩, takes its area from the inner ring on:

    r∩(L₂, h)² = r(L₁, h)² + 2 (V∩(L₂, h) − V∩(L₁, h)) / Δh.

Source: K. Masaoka, F. Jiang, M. D. Fairchild and R. L. Heckaman, "2D representation of display
color gamut", SID Digest 49 (2018); E. Smith et al., "Measuring the color capability of modern
display systems", Journal of the SID 28 (2020); Information Display Measurements Standard 1.1,
section 5.32. The division by the intersection is that of their program, gamut-volume-m.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray
from gamutcore.errors import InvalidPointsError
from gamutcore.queries.comparison import cell_volumes, checked_sectors
from gamutcore.queries.index import Level, as_index
from gamutcore.queries.rows import checked_numbers
from gamutcore.queries.volume_cells import cells_of, enclosed_cells
from gamutcore.shown import Shown

__all__ = ["LIGHTNESSES", "Rings", "gamut_rings"]

LIGHTNESSES = tuple(range(10, 101, 10))
"""Lightnesses of the rings in the standard, which is for CIELAB."""


@dataclass(frozen=True, eq=False, repr=False)
class Rings(Shown):
    """Gamut rings.

    Attributes
    ----------
    lightness : (n,) float64
        Of the rings, in increasing order.
    hues : (s,) float64
        Middle of each sector of hue, in degrees.
    radius : (n, s) float64
    volume : float
        Volume up to the last lightness: the area within the outer ring.
    reference_radius : (n, s) float64 or None
        Rings of the reference.
    intersection_radius : (n, s) float64 or None
        Outer end of the intersection's part of the band inside each ring.
    """

    lightness: FloatArray
    hues: FloatArray
    radius: FloatArray
    volume: float
    reference_radius: FloatArray | None = None
    intersection_radius: FloatArray | None = None


def gamut_rings(
    level: Level,
    reference: Level | None = None,
    lightness: ArrayLike = LIGHTNESSES,
    sectors: int = 360,
) -> Rings:
    """Return the gamut rings of a level, alone or compared with a reference.

    Parameters
    ----------
    level : LevelIndex or (vertices, faces, centre)
    reference : LevelIndex or (vertices, faces, centre), optional
        In the same colour space.
    lightness : (n,) array_like, optional
        Of the rings, in increasing order. Colours lighter than the last are in no ring.
    sectors : int, optional
        Number of equal sectors of hue, from 1 to `MOST_SECTORS`.

    Returns
    -------
    Rings
        Exact for the level except for rounding: no lines of sight are sampled.

    Raises
    ------
    InvalidPointsError
        The lightnesses are not increasing numbers; ``where["row"]`` names the first that is not.
    OptionError
        The number of sectors is not accepted.
    MeshError
        As for `build_index`.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> round(6 * gamut_rings(tetrahedron).volume, 9)
    1.0
    """
    bounds = checked_numbers(lightness, "lightness")
    falls = np.flatnonzero(np.diff(bounds) <= 0.0) + 1
    if len(bounds) == 0 or len(falls):
        row = int(falls[0]) if len(falls) else 0
        raise InvalidPointsError(
            f"Row {row} of lightness is not larger than the one before."
            if len(falls)
            else "There is no lightness.",
            where={"field": "lightness", "row": row},
            remedy="Give one or more numbers in increasing order.",
        )
    count = checked_sectors(sectors)
    width = 2.0 * np.pi / count
    cells = cells_of(count, bounds)
    index = as_index(level)
    hues = (np.arange(count) + 0.5) * 360.0 / count
    if reference is None:
        bands = _squares(enclosed_cells(index.vertices, index.faces, cells), width)
        squares = bands.cumsum(axis=0)
        return Rings(bounds, hues, np.sqrt(squares), float(squares[-1].sum() * width / 2.0))
    found = cell_volumes(index, as_index(reference), cells)
    bands, of_reference, common = (_squares(volumes, width) for volumes in found)
    squares = bands.cumsum(axis=0)
    inner = squares - bands
    return Rings(
        bounds,
        hues,
        np.sqrt(squares),
        float(squares[-1].sum() * width / 2.0),
        np.sqrt(of_reference.cumsum(axis=0)),
        np.sqrt(inner + common),
    )


def _squares(volumes: FloatArray, width: float) -> FloatArray:
    """Return the differences of squared radii for the volumes of bands, without the last band."""
    return np.maximum(volumes[:-1], 0.0) * (2.0 / width)
