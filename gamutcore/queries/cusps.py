"""Cusps: the points of largest chroma at a hue, over all lightnesses."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import kernel
from gamutcore.queries.cusp_table import CuspTable, find_cusp
from gamutcore.queries.index import Level, as_index
from gamutcore.queries.rows import checked_numbers

__all__ = ["Cusps", "cusp_points"]


class Cusps(NamedTuple):
    """Cusps, one for each hue. Rows without one are NaN, and their face is −1.

    Attributes
    ----------
    points : (n, 3) float64
        On the surface of the level.
    chroma : (n,) float64
    faces : (n,) int32
    weights : (n, 3) float64
        Barycentric coordinates in the face.
    """

    points: FloatArray
    chroma: FloatArray
    faces: IndexArray
    weights: FloatArray


def cusp_points(hues: ArrayLike, level: Level) -> Cusps:
    """Return the points of largest chroma at given hues.

    Parameters
    ----------
    hues : (n,) array_like
        Hue angles in degrees.
    level : LevelIndex or (vertices, faces, centre)

    Returns
    -------
    Cusps
        A hue has none if its half-plane does not meet the level.

    Raises
    ------
    InvalidPointsError
        A hue is not a finite number; ``where["row"]`` names it.
    MeshError
        As for `build_index`.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), 100 * np.eye(3)]) - (0, 20, 20)
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (20, 0, 0))
    >>> cusp_points([0, 90], tetrahedron).points.round(9).tolist()
    [[0.0, 60.0, 0.0], [0.0, 0.0, 60.0]]
    """
    angles = np.radians(checked_numbers(hues, "hues"))
    return Cusps(*_cusps(np.cos(angles), np.sin(angles), as_index(level).cusps))


@kernel
def _cusps(
    cosines: FloatArray, sines: FloatArray, table: CuspTable
) -> tuple[FloatArray, FloatArray, IndexArray, FloatArray]:
    count = len(cosines)
    points, chromas = np.full((count, 3), np.nan), np.full(count, np.nan)
    faces, weights = np.full(count, -1, np.int32), np.full((count, 3), np.nan)
    for row in range(count):
        ca, cb = cosines[row], sines[row]
        chroma, lightness, edge, share = find_cusp(ca, cb, table)
        if edge < 0:
            continue
        points[row, 0], points[row, 1], points[row, 2] = lightness, chroma * ca, chroma * cb
        chromas[row] = chroma
        face, at = divmod(table.corners[edge], 3)
        faces[row] = face
        weights[row, at] = 0.0
        weights[row, (at + 1) % 3] = 1.0 - share
        weights[row, (at + 2) % 3] = share
    return points, chromas, faces, weights
