"""A device model from a complete grid of samples: multilinear interpolation.

A grid is complete if the device values are all combinations of some levels of each channel. The
levels may be unevenly spaced. Colours between neighbouring levels are interpolated as in the lookup
tables of profiles, by the same kernel.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gamutcore.characterisation.icc.transforms import checked_positions, multilinear
from gamutcore.errors import OptionError, UnsupportedProfileError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = ["GridModel", "grid_model"]

_APART = 1e-6
"""Distance of two levels of a channel as a fraction of its range; closer values are one level."""


@dataclass(frozen=True, eq=False)
class GridModel:
    """Device value to colour, interpolated between the nodes of a grid.

    Attributes
    ----------
    levels : tuple of (l,) float
        Ascending levels of each of k channels; one level for a constant channel.
    table : (product of levels, 3) float32
        Colours at the nodes; the last channel varies fastest. Single precision is 10⁻⁵ ΔE, far
        below the noise of measurements.
    """

    levels: tuple[FloatArray, ...]
    table: npt.NDArray[np.float32] = field(repr=False)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of levels of each channel."""
        return tuple(len(levels) for levels in self.levels)

    def colours(self, device: FloatArray) -> FloatArray:
        """Return the colours (m, 3) of device values (m, k), clipped to the outermost levels."""
        positions = np.empty(device.shape)
        for channel, levels in enumerate(self.levels):
            fractions = np.linspace(0.0, 1.0, len(levels))
            positions[:, channel] = np.interp(device[:, channel], levels, fractions)
        try:
            positions, steps, strides = checked_positions(positions, self.shape)
        except UnsupportedProfileError as error:
            raise OptionError(error.message, where=error.where, remedy=error.remedy) from None
        colours = np.empty((len(device), 3))
        multilinear(positions, steps, strides, self.table, colours)
        return colours

    def leave_out_errors(self) -> FloatArray:
        """Return the interpolation errors (m,) at nodes that are left out.

        Every second level of each channel is left out at once, except the last one. The missing
        nodes are interpolated between the remaining ones. The errors of the whole grid are two to
        four times smaller: halving the steps quarters the errors of smooth colours
        (``docs/decisions/device-model.md``). The result is empty if no channel has more than two
        levels.
        """
        shape = self.shape
        kept = [np.unique([*range(0, count, 2), count - 1]) for count in shape]
        stays = np.zeros(shape, dtype=bool)
        stays[np.ix_(*kept)] = True
        left_out = ~stays.reshape(-1)
        coarse = GridModel(
            tuple(levels[some] for levels, some in zip(self.levels, kept, strict=True)),
            np.ascontiguousarray(self.table[~left_out]),
        )
        indices = np.unravel_index(np.flatnonzero(left_out), shape)
        device = np.column_stack(
            [levels[index] for levels, index in zip(self.levels, indices, strict=True)]
        )
        errors: FloatArray = np.linalg.norm(coarse.colours(device) - self.table[left_out], axis=1)
        return errors


def grid_model(device: FloatArray, colours: FloatArray) -> GridModel | None:
    """Return the model of samples that form a complete grid; None for other samples.

    `device` has distinct device values (n, k) in any order, and `colours` (n, 3) their colours.
    """
    count = len(device)
    if count < 2:
        return None
    levels, indices = [], []
    nodes = 1
    for values in device.T:
        order = np.argsort(values, kind="stable")
        ranked = values[order]
        first = np.concatenate([[True], np.diff(ranked) > _APART])
        levels.append(ranked[first])
        nodes *= len(levels[-1])
        # scattered samples have far more combinations of levels than samples
        if nodes > count:
            return None
        index = np.empty(count, dtype=np.int64)
        index[order] = np.cumsum(first) - 1
        indices.append(index)
    if nodes < count:
        return None
    row = np.ravel_multi_index(tuple(indices), tuple(len(some) for some in levels))
    if len(np.unique(row)) < count:
        return None
    table = np.empty((count, 3), dtype=np.float32)
    table[row] = colours
    return GridModel(tuple(levels), table)
