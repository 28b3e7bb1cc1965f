"""The history of a gamut: all its levels, each readable in time proportional to its own size.

The splits are the history; beside them a `History` keeps snapshots of the levels with 4, 8, 16,
... vertices and of the full boundary. A level is read from the smallest snapshot that is not
coarser than it: its vertices differ by what the splits in between did to their parents, and each
corner follows the parents of its slot until one of the level is reached. That touches less than
twice the level's own vertices and faces, whatever the size of the full mesh, and the snapshots
together hold less than three times the full mesh.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.errors import TriangleCountError
from gamutcore.history.prefix_order import Splits, splits_in_prefix_order
from gamutcore.history.stepping import LevelCursor, refine
from gamutcore.kernels import kernel
from gamutcore.mesh import TriangleMesh

if TYPE_CHECKING:
    from collections.abc import Iterator

    from gamutcore.decimation import Decimation

__all__ = ["MINIMUM_TRIANGLES", "History", "history_of"]

MINIMUM_TRIANGLES = 4
"""A tetrahedron: the only triangulation of the sphere in which no edge can be collapsed."""


class History:
    """All levels of a gamut, from four triangles to the full boundary.

    Parameters
    ----------
    splits : Splits
        In prefix order, and consistent: what `history_of` arranges or a checked file holds.
    centre : (3,) float64
        What every level is star-shaped about.
    step : float
        Of the grid that all positions lie on: a power of two.
    """

    def __init__(self, splits: Splits, centre: FloatArray, step: float) -> None:
        self.splits = splits
        self.centre = centre
        self.step = step
        self._levels, self._positions, self._corners = _snapshots(splits)

    @property
    def vertices(self) -> int:
        """Number of vertices of the full boundary."""
        return self.splits.vertices

    @property
    def triangles(self) -> int:
        """Number of triangles of the full boundary, the largest count that can be asked for."""
        return 2 * self.vertices - 4

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return sum(
            array.nbytes
            for arrays in (self.splits, self._positions, self._corners)
            for array in arrays
        )

    def level(self, triangles: int) -> TriangleMesh:
        """Return the mesh with at most so many triangles.

        Parameters
        ----------
        triangles : int
            At least 4, at most `self.triangles`. Closed meshes of genus 0 have an even count: the
            largest even number that is not above it is returned.

        Returns
        -------
        TriangleMesh
            Own arrays, float32 and int32; vertex i is slot i.

        Raises
        ------
        TriangleCountError
            If there is no such level.
        """
        whole = isinstance(triangles, int | np.integer) and not isinstance(triangles, bool)
        if not whole or not MINIMUM_TRIANGLES <= triangles <= self.triangles:
            raise TriangleCountError(
                f"{triangles!r} triangles were asked for; this gamut has levels of"
                f" {MINIMUM_TRIANGLES} to {self.triangles}",
                where={"field": "triangles"},
                remedy=f"a number from {MINIMUM_TRIANGLES} to {self.triangles}",
            )
        vertices = int(triangles) // 2 + 2
        index = min((vertices - 1).bit_length() - 2, len(self._levels) - 1)
        positions, faces = _level_from_snapshot(
            vertices,
            self._levels[index],
            self._positions[index],
            self._corners[index],
            self.splits.parent,
            self.splits.coarse,
            self.splits.shifted_end,
            self.splits.shifted,
            self.splits.shifted_coarse,
        )
        return TriangleMesh(positions, faces)

    def full(self) -> TriangleMesh:
        """Return the full boundary."""
        return self.level(self.triangles)

    def cursor(self, triangles: int) -> LevelCursor:
        """Return a level that can be refined and coarsened in place.

        Parameters
        ----------
        triangles : int
            Where to begin; as for `level`.

        Raises
        ------
        TriangleCountError
            If there is no such level.
        """
        return LevelCursor(self.splits, self.level(triangles))

    def levels(self) -> Iterator[TriangleMesh]:
        """Yield every level from the coarsest to the full boundary."""
        for triangles in range(MINIMUM_TRIANGLES, self.triangles + 1, 2):
            yield self.level(triangles)


def history_of(decimation: Decimation) -> History:
    """Return the history of a decimation.

    Parameters
    ----------
    decimation : Decimation

    Returns
    -------
    History
    """
    return History(splits_in_prefix_order(decimation), decimation.centre, decimation.step)


def _snapshots(splits: Splits) -> tuple[list[int], list[Float32Array], list[IndexArray]]:
    """Levels with 4, 8, 16, ... vertices and the full boundary: counts, positions and faces."""
    total = splits.vertices
    positions = np.empty((total, 3), np.float32)
    faces = np.empty((2 * total - 4, 3), np.int32)
    positions[:4], faces[:4] = splits.base_positions, splits.base_faces
    counts, all_positions, all_faces = [4], [positions[:4].copy()], [faces[:4].copy()]
    while counts[-1] < total:
        count = min(2 * counts[-1], total)
        refine(splits, positions, faces.reshape(-1), counts[-1], count)
        counts.append(count)
        all_positions.append(positions[:count].copy())
        all_faces.append(faces[: 2 * count - 4].copy())
    return counts, all_positions, all_faces


@kernel
def _level_from_snapshot(
    vertices: int,
    snapshot_vertices: int,
    snapshot_positions: Float32Array,
    snapshot_faces: IndexArray,
    parent: IndexArray,
    coarse: Float32Array,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_coarse: Float32Array,
) -> tuple[Float32Array, IndexArray]:
    positions = snapshot_positions[:vertices].copy()
    for slot in range(snapshot_vertices - 1, vertices - 1, -1):
        above = parent[slot - 4]
        if above < vertices:
            for axis in range(3):
                positions[above, axis] = coarse[slot - 4, axis]
        for index in range(shifted_end[slot - 5] if slot > 4 else 0, shifted_end[slot - 4]):
            if shifted[index] < vertices:
                for axis in range(3):
                    positions[shifted[index], axis] = shifted_coarse[index, axis]
    faces = np.empty((2 * vertices - 4, 3), np.int32)
    for face in range(len(faces)):
        for place in range(3):
            slot = snapshot_faces[face, place]
            while slot >= vertices:
                slot = parent[slot - 4]
            faces[face, place] = slot
    return positions, faces
