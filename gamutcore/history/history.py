"""The history of a gamut: all its levels, each readable in time proportional to its own size.

A `History` holds the splits, and snapshots of the levels with 4, 8, 16, … vertices and of the full
boundary. A level is read from the smallest snapshot that is not coarser. Its positions are those
of the snapshot, with the splits in between undone. Its faces are the first faces of the snapshot,
where each corner follows the parents of its slot to a slot of the level. This touches less than
twice the vertices and faces of the level, whatever the size of the full boundary. All snapshots
together hold less than three times the full boundary. A history from a file reads groups of
splits and makes its snapshots on request, so the first level is fast as well. A `LevelCursor` steps
through neighbouring levels in place.
"""

from __future__ import annotations

import threading
from operator import attrgetter
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.arrays import Float32Array, IndexArray
from gamutcore.errors import TriangleCountError
from gamutcore.geometry import TriangleMesh
from gamutcore.history.device import build_device_history
from gamutcore.history.splits import (
    apply_splits,
    extended_copy,
    fine_columns,
    group_count,
    group_ranges,
    joined_splits,
    part_begin,
    prefix_order_splits,
    refine,
    undo_splits,
    vertex_slots,
)
from gamutcore.kernels import kernel

if TYPE_CHECKING:
    from collections.abc import Iterator

    from gamutcore.arrays import FloatArray
    from gamutcore.decimation import Decimation
    from gamutcore.geometry import DeviceValues
    from gamutcore.history.columns import StoredGroups
    from gamutcore.history.device import DeviceHistory
    from gamutcore.history.splits import Splits

__all__ = ["MINIMUM_TRIANGLES", "History", "LevelCursor", "build_history"]

MINIMUM_TRIANGLES = 4
"""A tetrahedron: the only triangulation of the sphere in which no edge can be collapsed."""


class History:
    """All levels of a gamut, from four triangles to the full boundary.

    Several threads may read from it at the same time. Methods that take a triangle count raise a
    `TriangleCountError` if there is no such level. Methods and properties that unpack a part of a
    file raise a `HistoryFileError` if that part is damaged.

    Parameters
    ----------
    splits : Splits
        In prefix order and consistent, as `build_history` provides them; of a file, those that are
        read already.
    centre : (3,) float64
        Every level is star-shaped about this point.
    step : float
        Step of the grid of all positions, a power of two.
    device : DeviceHistory, optional
        Device values of all levels; None if the gamut has colours only.
    stored : StoredGroups, optional
        Groups of splits of a file, to be read.
    vertices : int, optional
        Vertices of the full boundary, if groups are stored.

    Attributes
    ----------
    vertices : int
        Vertices of the full boundary.
    centre : (3,) float64
    step : float
    """

    def __init__(
        self,
        splits: Splits,
        centre: FloatArray,
        step: float,
        device: DeviceHistory | None = None,
        stored: StoredGroups | None = None,
        vertices: int | None = None,
    ) -> None:
        self.centre = centre
        self.step = step
        self._splits = splits
        self._stored = stored
        self.vertices = splits.vertices if vertices is None else vertices
        self._device = device
        self._groups = group_ranges(self.vertices)
        self._snapshots = [TriangleMesh(splits.base_positions, splits.base_faces)]
        self._lock = threading.Lock()
        if stored is None:
            self._make_snapshots(len(self._groups))

    @property
    def triangles(self) -> int:
        """Triangle count of the full boundary, the largest count of a level."""
        return 2 * self.vertices - 4

    @property
    def nbytes(self) -> int:
        """Memory in bytes. It grows while levels of a file are unpacked."""
        parts = (self._splits, self._stored, self._device)
        held = sum(part.nbytes for part in parts if part is not None)
        snapshots = list(self._snapshots)
        return held + sum(mesh.vertices.nbytes + mesh.faces.nbytes for mesh in snapshots)

    @property
    def splits(self) -> Splits:
        """All splits."""
        self._make_snapshots(len(self._groups))
        return self._splits

    @property
    def device(self) -> DeviceHistory | None:
        """Device values of all levels; None if the gamut has colours only."""
        self._make_snapshots(len(self._groups))
        return self._device

    def is_unpacked(self, triangles: int) -> bool:
        """Whether a level and its device values can be read without unpacking more of a file."""
        return group_count(self._level_vertices(triangles)) < len(self._snapshots)

    def unpack(self, triangles: int | None = None) -> None:
        """Unpack and check everything that a level and its device values need.

        The level is the full boundary by default.
        """
        count = self.triangles if triangles is None else triangles
        self._make_snapshots(group_count(self._level_vertices(count)))

    def level_triangles(self, triangles: int) -> int:
        """Return the triangle count of the mesh that `level` returns."""
        return 2 * self._level_vertices(triangles) - 4

    def level(self, triangles: int) -> TriangleMesh:
        """Return the mesh with the largest triangle count that is not above a given one.

        Parameters
        ----------
        triangles : int
            From 4 to `self.triangles`. Closed meshes of genus 0 have an even count, so an odd
            number gives the level with one triangle less.

        Returns
        -------
        TriangleMesh
            New arrays, float32 and int32; vertex i is slot i.

        Raises
        ------
        TriangleCountError
            If there is no such level.
        HistoryFileError
            If the file is damaged.
        """
        vertices = self._level_vertices(triangles)
        groups = group_count(vertices)
        self._make_snapshots(groups)
        snapshot, splits = self._snapshots[groups], self._splits
        positions, faces = _level_from_snapshot(
            vertices,
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
        """Return the device values at the vertices of a level, in time proportional to the level.

        Parameters
        ----------
        triangles : int
            As for `level`.

        Returns
        -------
        DeviceValues or None
            New float32 array in the order of the vertices; None if the gamut has colours only.
        """
        vertices = self._level_vertices(triangles)
        if self._device is None:
            return None
        self._make_snapshots(group_count(vertices))
        return self._device.level(vertices, self._splits)

    def full(self) -> TriangleMesh:
        """Return the full boundary."""
        return self.level(self.triangles)

    def cursor(self, triangles: int) -> LevelCursor:
        """Return a level, as `level` does, that can be refined and coarsened in place."""
        return LevelCursor(self.splits, self.level(triangles))

    def levels(self) -> Iterator[TriangleMesh]:
        """Yield every level from the coarsest to the full boundary."""
        for triangles in range(MINIMUM_TRIANGLES, self.triangles + 1, 2):
            yield self.level(triangles)

    def _make_snapshots(self, groups: int) -> None:
        """Read and unpack the first `groups` groups, with the snapshot at the end of each."""
        if groups < len(self._snapshots):
            return
        with self._lock:
            while len(self._snapshots) <= groups:
                self._make_next_snapshot()

    def _make_next_snapshot(self) -> None:
        group = len(self._snapshots) - 1
        start, end = self._groups[group]
        if self._stored is not None:
            self._read_group(self._stored, group)
        positions = extended_copy(self._snapshots[group].vertices, end)
        faces = extended_copy(self._snapshots[group].faces, 2 * end - 4)
        refine(self._splits, positions, faces.reshape(-1), start, end)
        if end == self.vertices:
            self._stored = None
        self._snapshots.append(TriangleMesh(positions, faces))

    def _read_group(self, stored: StoredGroups, number: int) -> None:
        """Append the splits of a group to those that are read."""
        device = self._device
        values = np.empty((0, 0), np.int16) if device is None else device.snapshots[number]
        rows, columns = stored.read(number, self._snapshots[number], values, self.centre, self.step)
        splits = joined_splits(self._splits, rows)
        if device is not None:
            device.append(columns, splits)
        self._splits = splits
        stored.release(number)

    def _level_vertices(self, triangles: int) -> int:
        is_whole = isinstance(triangles, int | np.integer) and not isinstance(triangles, bool)
        if not is_whole or not MINIMUM_TRIANGLES <= triangles <= self.triangles:
            raise TriangleCountError(
                f"{triangles!r} triangles were asked for; this gamut has levels of"
                f" {MINIMUM_TRIANGLES} to {self.triangles}",
                where={"field": "triangles"},
                remedy=f"Give a number from {MINIMUM_TRIANGLES} to {self.triangles}.",
            )
        return int(triangles) // 2 + 2


class LevelCursor:
    """A level that is refined and coarsened in place, split by split."""

    def __init__(self, splits: Splits, level: TriangleMesh) -> None:
        self._full_vertices = splits.vertices
        self._columns = fine_columns(splits), _coarse_columns(splits)
        self._vertices = len(level.vertices)
        self._positions = np.empty((splits.vertices, 3), np.float32)
        self._faces = np.empty((2 * splits.vertices - 4, 3), np.int32)
        self._positions[: self._vertices] = level.vertices
        self._faces[: level.triangles] = level.faces
        self._corners = self._faces.reshape(-1)

    @property
    def triangles(self) -> int:
        """Triangle count of the present level."""
        return 2 * self._vertices - 4

    @property
    def mesh(self) -> TriangleMesh:
        """The present level. Its arrays are views; the next step changes them."""
        return TriangleMesh(self._positions[: self._vertices], self._faces[: self.triangles])

    def finer(self, steps: int = 1) -> None:
        """Apply the next splits.

        If the history has fewer splits left, a `TriangleCountError` is raised, and nothing changes.
        """
        self._move(self._vertices + steps)

    def coarser(self, steps: int = 1) -> None:
        """Undo the last splits.

        If four triangles are reached before, a `TriangleCountError` is raised, and nothing changes.
        """
        self._move(self._vertices - steps)

    def _move(self, vertices: int) -> None:
        if not 4 <= vertices <= self._full_vertices:
            raise TriangleCountError(
                f"a level of {2 * vertices - 4} triangles was asked for",
                where={"field": "steps"},
                remedy=f"Give a level of 4 to {2 * self._full_vertices - 4} triangles.",
            )
        fine, coarse = self._columns
        if vertices > self._vertices:
            apply_splits(self._positions, self._corners, self._vertices, vertices, *fine)
        else:
            _coarsen(self._positions, self._corners, self._vertices, vertices, *coarse)
        self._vertices = vertices


_coarse_columns = attrgetter(
    "parent", "coarse", "moved_end", "moved", "shifted_end", "shifted", "shifted_coarse"
)


def build_history(decimation: Decimation, device: DeviceValues | None = None) -> History:
    """Return the history of a decimation.

    Parameters
    ----------
    decimation : Decimation
    device : DeviceValues, optional
        Device values of the vertices of the full boundary, in its order.

    Returns
    -------
    History
    """
    slots = vertex_slots(decimation)
    splits = prefix_order_splits(decimation, slots)
    values = None if device is None else build_device_history(device, slots, splits)
    return History(splits, decimation.centre, decimation.step, values)


@kernel
def _level_from_snapshot(
    vertices: int,
    snapshot_positions: Float32Array,
    snapshot_faces: IndexArray,
    parent: IndexArray,
    coarse: Float32Array,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_coarse: Float32Array,
) -> tuple[Float32Array, IndexArray]:
    """Return positions and faces of a level from a snapshot of a level that is not coarser."""
    positions, start = snapshot_positions[:vertices].copy(), len(snapshot_positions)
    undo_splits(positions, 3, start, vertices, parent, coarse, shifted_end, shifted, shifted_coarse)
    faces = snapshot_faces[: 2 * vertices - 4].copy()
    corners = faces.reshape(-1)
    for corner in range(len(corners)):
        slot = corners[corner]
        if slot >= vertices:
            while slot >= vertices:
                slot = parent[slot - 4]
            corners[corner] = slot
    return positions, faces


@kernel
def _coarsen(
    positions: Float32Array,
    corners: IndexArray,
    start: int,
    end: int,
    parent: IndexArray,
    coarse: Float32Array,
    moved_end: IndexArray,
    moved: IndexArray,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_coarse: Float32Array,
) -> None:
    undo_splits(positions, 3, start, end, parent, coarse, shifted_end, shifted, shifted_coarse)
    for split in range(start - 5, end - 5, -1):
        for index in range(part_begin(moved_end, split), moved_end[split]):
            corners[moved[index]] = parent[split]
