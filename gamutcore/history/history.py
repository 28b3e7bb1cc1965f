"""The history of a gamut: all its levels, each readable in time proportional to its own size.

The splits are the history; beside them a `History` keeps snapshots of the levels with 4, 8, 16,
... vertices and of the full boundary. A level is read from the smallest snapshot that is not
coarser than it: its vertices differ by what the splits in between did to their parents, and each
corner follows the parents of its slot until one of the level is reached. That touches less than
twice the level's own vertices and faces, whatever the size of the full mesh, and the snapshots
together hold less than three times the full mesh. Of a history from a file, splits and snapshots
are there as far as levels were asked for, so the first one takes time in proportion to itself too.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.errors import TriangleCountError
from gamutcore.history.device_history import build_device_history
from gamutcore.history.groups import groups_leading_to, groups_of
from gamutcore.history.packed_splits import PackedSplits
from gamutcore.history.prefix_order import slots_of_vertices, splits_in_prefix_order
from gamutcore.history.stepping import LevelCursor, level_from_snapshot, refine
from gamutcore.mesh import TriangleMesh

if TYPE_CHECKING:
    from collections.abc import Iterator

    from gamutcore.arrays import FloatArray
    from gamutcore.decimation import Decimation
    from gamutcore.history.device_history import DeviceHistory
    from gamutcore.history.prefix_order import Splits
    from gamutcore.mesh import DeviceValues

__all__ = ["MINIMUM_TRIANGLES", "History", "build_history"]

MINIMUM_TRIANGLES = 4
"""A tetrahedron: the only triangulation of the sphere in which no edge can be collapsed."""


class History:
    """All levels of a gamut, from four triangles to the full boundary.

    Several threads may read it at the same time.

    Parameters
    ----------
    splits : Splits or PackedSplits
        In prefix order, and consistent: what `build_history` arranges or a file holds.
    centre : (3,) float64
        What every level is star-shaped about.
    step : float
        Of the grid that all positions lie on: a power of two.
    device : DeviceHistory, optional
        The device values of all levels; none of bare colours.
    """

    def __init__(
        self,
        splits: Splits | PackedSplits,
        centre: FloatArray,
        step: float,
        device: DeviceHistory | None = None,
    ) -> None:
        self.centre = centre
        self.step = step
        self.vertices = splits.vertices
        """Number of vertices of the full boundary."""
        self._packed = splits if isinstance(splits, PackedSplits) else None
        self._splits = splits.splits if isinstance(splits, PackedSplits) else splits
        self._device = device
        self._groups = groups_of(self.vertices)
        self._snapshots = [TriangleMesh(self._splits.base_positions, self._splits.base_faces)]
        self._unpacking = threading.Lock()
        if self._packed is None:
            self._reach(len(self._groups))

    @property
    def triangles(self) -> int:
        """Number of triangles of the full boundary, the largest count that can be asked for."""
        return 2 * self.vertices - 4

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes; of a file's history it grows with the levels asked for."""
        splits = self._packed or self._splits
        nbytes = splits.nbytes + (self._device.nbytes if self._device is not None else 0)
        return nbytes + sum(
            mesh.vertices.nbytes + mesh.faces.nbytes for mesh in list(self._snapshots)
        )

    @property
    def splits(self) -> Splits:
        """All splits.

        Raises
        ------
        HistoryFileError
            If those of a file turn out to be damaged.
        """
        self._reach(len(self._groups))
        return self._splits

    @property
    def device(self) -> DeviceHistory | None:
        """The device values of all levels; None of bare colours.

        Raises
        ------
        HistoryFileError
            If those of a file turn out to be damaged.
        """
        if self._device is not None:
            self._reach_device(self._device, len(self._groups))
        return self._device

    def is_unpacked(self, triangles: int) -> bool:
        """Whether a level, with its device values, can be read without unpacking more of a file.

        Parameters
        ----------
        triangles : int
            As for `level`.

        Raises
        ------
        TriangleCountError
            If there is no such level.
        """
        group = groups_leading_to(self._vertices_of_level(triangles))
        unpacked = len(self._snapshots) - 1
        if self._device is not None:
            unpacked = min(unpacked, self._device.unpacked)
        return group <= unpacked

    def unpack(self, triangles: int | None = None) -> None:
        """Unpack and check all that a level needs, and its device values; nothing if that is done.

        Parameters
        ----------
        triangles : int, optional
            As for `level`; without it, the full boundary.

        Raises
        ------
        TriangleCountError
            If there is no such level.
        HistoryFileError
            If what a file holds turns out to be damaged.
        """
        count = self.triangles if triangles is None else triangles
        group = groups_leading_to(self._vertices_of_level(count))
        self._reach(group)
        if self._device is not None:
            self._reach_device(self._device, group)

    def level_triangles(self, triangles: int) -> int:
        """Return how many triangles the level has that is meant by a number of them.

        Parameters
        ----------
        triangles : int
            As for `level`.

        Raises
        ------
        TriangleCountError
            If there is no such level.
        """
        return 2 * self._vertices_of_level(triangles) - 4

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
        HistoryFileError
            If what a file holds of it turns out to be damaged.
        """
        vertices = self._vertices_of_level(triangles)
        group = groups_leading_to(vertices)
        self._reach(group)
        snapshot, splits = self._snapshots[group], self._splits
        positions, faces = level_from_snapshot(
            vertices,
            len(snapshot.vertices),
            snapshot.vertices,
            snapshot.faces,
            splits.parent,
            splits.coarse,
            splits.shifted_end,
            splits.shifted,
            splits.shifted_coarse,
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
        TriangleCountError, HistoryFileError
            As of `level`.
        """
        vertices = self._vertices_of_level(triangles)
        if self._device is None:
            return None
        self._reach_device(self._device, groups_leading_to(vertices))
        return self._device.level(vertices)

    def _reach(self, group: int) -> None:
        """Have the snapshots of so many groups."""
        if group < len(self._snapshots):
            return
        with self._unpacking:
            while len(self._snapshots) <= group:
                self._take_snapshot()

    def _take_snapshot(self) -> None:
        done = len(self._snapshots) - 1
        if self._packed is not None:
            if self._packed.unpacked == done:
                self._packed.unpack()
            self._splits = self._packed.splits
        start, end = self._groups[done]
        positions = np.empty((end, 3), np.float32)
        faces = np.empty((2 * end - 4, 3), np.int32)
        before = self._snapshots[done]
        positions[:start], faces[: 2 * start - 4] = before.vertices, before.faces
        refine(self._splits, positions, faces.reshape(-1), start, end)
        if end == self.vertices:
            self._packed = None
        self._snapshots.append(TriangleMesh(positions, faces))

    def _reach_device(self, device: DeviceHistory, group: int) -> None:
        """Have the device values of so many groups."""
        if group <= device.unpacked:
            return
        self._reach(group)
        with self._unpacking:
            while device.unpacked < group:
                device.unpack(self._splits)

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


def build_history(decimation: Decimation, device: DeviceValues | None = None) -> History:
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
    values = build_device_history(device, slots_of_vertices(decimation), splits)
    return History(splits, decimation.centre, decimation.step, values)
