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
from gamutcore.history.device_history import DeviceHistory, device_history_of
from gamutcore.history.prefix_order import Splits, slots_of_vertices, splits_in_prefix_order
from gamutcore.history.stepping import LevelCursor, refine
from gamutcore.kernels import kernel
from gamutcore.mesh import TriangleMesh

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from gamutcore.decimation import Decimation
    from gamutcore.device_values import DeviceValues

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
    device : DeviceHistory or callable, optional
        The device values of all levels, or what makes them from the splits when they are first
        asked for; none of bare colours.
    """

    def __init__(
        self,
        splits: Splits,
        centre: FloatArray,
        step: float,
        device: DeviceHistory | Callable[[Splits], DeviceHistory] | None = None,
    ) -> None:
        self.splits = splits
        self.centre = centre
        self.step = step
        self._device = device
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
        """Memory held, in bytes; device values count once they have been asked for."""
        device = self._device.nbytes if isinstance(self._device, DeviceHistory) else 0
        return device + sum(
            array.nbytes
            for arrays in (self.splits, self._positions, self._corners)
            for array in arrays
        )

    @property
    def device(self) -> DeviceHistory | None:
        """The device values of all levels; None of bare colours.

        Raises
        ------
        HistoryFileError
            When they are first asked for, if those of a file turn out to be damaged.
        """
        if callable(self._device):
            self._device = self._device(self.splits)
        return self._device

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
        vertices = self._vertices_of_level(triangles)
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

    def device_values(self, triangles: int) -> DeviceValues | None:
        """Return the device values at the vertices of a level, in time proportional to it.

        Parameters
        ----------
        triangles : int
            As for `level`.

        Returns
        -------
        DeviceValues or None
            Own array, float32, in the order of the level's vertices; None of bare colours.

        Raises
        ------
        TriangleCountError
            If there is no such level.
        HistoryFileError
            As of `device`.
        """
        vertices = self._vertices_of_level(triangles)
        device = self.device
        return None if device is None else device.level(vertices)

    def _vertices_of_level(self, triangles: int) -> int:
        whole = isinstance(triangles, int | np.integer) and not isinstance(triangles, bool)
        if not whole or not MINIMUM_TRIANGLES <= triangles <= self.triangles:
            raise TriangleCountError(
                f"{triangles!r} triangles were asked for; this gamut has levels of"
                f" {MINIMUM_TRIANGLES} to {self.triangles}",
                where={"field": "triangles"},
                remedy=f"a number from {MINIMUM_TRIANGLES} to {self.triangles}",
            )
        return int(triangles) // 2 + 2

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


def history_of(decimation: Decimation, device: DeviceValues | None = None) -> History:
    """Return the history of a decimation.

    Parameters
    ----------
    decimation : Decimation
    device : DeviceValues, optional
        What makes the vertices of the full boundary, in its order.

    Returns
    -------
    History
    """
    splits = splits_in_prefix_order(decimation)
    if device is None:
        return History(splits, decimation.centre, decimation.step)
    values = device_history_of(device, slots_of_vertices(decimation), splits)
    return History(splits, decimation.centre, decimation.step, values)


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
