"""Multidimensional lookup tables, interpolated linearly in every dimension.

Interpolation over simplices is common, but differs by up to 4.8 ΔE*ab for seven inks. Profiles are
specified for multilinear interpolation (ICC.1:2022, 10.12, annex D). On the surface of a device
cube most coordinates are nodes; the kernel skips these dimensions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gamutcore.errors import UnsupportedProfileError
from gamutcore.kernels import kernel

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = ["Grid", "checked_positions", "multilinear"]

MAX_CORNERS = 300_000_000
"""Maximum number of table reads in one evaluation, about 3 s: 100,000 points in 11 dimensions."""


@kernel
def multilinear(
    positions: FloatArray,
    steps: npt.NDArray[np.int64],
    strides: npt.NDArray[np.int64],
    table: npt.NDArray[np.uint16] | npt.NDArray[np.float32],
    out: FloatArray,
) -> None:
    """Interpolate linearly in every dimension.

    Parameters
    ----------
    positions : (m, n) float
        Coordinates, 0 to 1.
    steps, strides : (n,) int
        Nodes along each dimension, less one; and rows of `table` from one node to the next.
    table : (nodes, 3) uint16 or float32
        Values at the nodes, the last dimension varying fastest.
    out : (m, 3) float
        Receives the values, on the table's scale.
    """
    dimensions = positions.shape[1]
    fractions = np.empty(dimensions)
    offsets = np.empty(dimensions, dtype=np.int64)
    for i in range(positions.shape[0]):
        base = 0
        between = 0
        for d in range(dimensions):
            position = min(max(positions[i, d], 0.0), 1.0) * steps[d]
            node = int(position)
            base += node * strides[d]
            # A dimension in which the point is a node needs no neighbour.
            if position > node:
                fractions[between] = position - node
                offsets[between] = strides[d]
                between += 1
        first = second = third = 0.0
        for corner in range(1 << between):
            weight = 1.0
            row = base
            for d in range(between):
                if corner >> d & 1:
                    weight *= fractions[d]
                    row += offsets[d]
                else:
                    weight *= 1.0 - fractions[d]
            first += weight * table[row, 0]
            second += weight * table[row, 1]
            third += weight * table[row, 2]
        out[i, 0] = first
        out[i, 1] = second
        out[i, 2] = third


def checked_positions(
    positions: FloatArray, nodes: tuple[int, ...]
) -> tuple[FloatArray, npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the arguments of `multilinear`: positions (m, n) clipped to 0 to 1, steps, strides.

    An evaluation with more than `MAX_CORNERS` table reads is refused.
    """
    steps = np.array(nodes, dtype=np.int64) - 1
    strides = np.cumprod(np.array([1, *nodes[:0:-1]], dtype=np.int64))[::-1].copy()
    # The kernel does not check positions, so none may be NaN.
    clipped = np.ascontiguousarray(np.clip(np.nan_to_num(positions, nan=0.0), 0.0, 1.0))
    between = np.count_nonzero(clipped * steps % 1.0, axis=1)
    corners = int((1 << between).sum())
    if corners > MAX_CORNERS:
        raise UnsupportedProfileError(
            f"Interpolating {len(positions)} points over {len(nodes)} channels takes "
            f"{corners} table entries.",
            where={"field": "surface_samples"},
            remedy="Ask for fewer surface_samples.",
        )
    return clipped, steps, strides


@dataclass(frozen=True, eq=False)
class Grid:
    """A lookup table (CLUT) with three outputs.

    Attributes
    ----------
    nodes : tuple of int
        Nodes along each dimension, each at least 2.
    table : (product of nodes, 3) uint16
        Values at the nodes, the last dimension varying fastest.
    """

    nodes: tuple[int, ...]
    table: npt.NDArray[np.uint16]

    def values(self, positions: FloatArray) -> FloatArray:
        """Return the interpolated outputs (m, 3), 0 to 1, at positions (m, n) clipped to 0 to 1."""
        clipped, steps, strides = checked_positions(positions, self.nodes)
        out = np.empty((len(positions), 3))
        multilinear(clipped, steps, strides, self.table, out)
        return out / 65535.0
