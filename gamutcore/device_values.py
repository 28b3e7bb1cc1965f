"""Device values at the vertices of a mesh: the recipe that a device makes each colour by."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.errors import MeshError

if TYPE_CHECKING:
    from gamutcore.arrays import PositionArray

__all__ = ["DeviceValues"]


@dataclass(frozen=True, eq=False)
class DeviceValues:
    """What each channel of a device is set to, vertex by vertex.

    Parameters
    ----------
    channels : tuple of str
        Names of the k channels: inks, lights or whatever the characterisation calls them.
    values : (m, k) float
        From 0 to 1.

    Raises
    ------
    MeshError
        If the array is not of that shape, or has numbers beyond 0 and 1.
    """

    channels: tuple[str, ...]
    values: PositionArray

    def __post_init__(self) -> None:
        values = np.asarray(self.values)
        if values.ndim != 2 or not 0 < values.shape[1] == len(self.channels):
            raise MeshError(
                f"device values have the shape {values.shape} with {len(self.channels)} channels",
                where={"field": "values"},
                remedy="an (m, k) array, and the names of its k ≥ 1 channels",
            )
        if values.dtype.kind != "f" or not ((values >= 0) & (values <= 1)).all():
            raise MeshError(
                "device values are not all numbers from 0 to 1",
                where={"field": "values"},
                remedy="parts of full scale, as floats",
            )

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, DeviceValues)
            and self.channels == other.channels
            and np.array_equal(self.values, other.values)
        )

    __hash__ = None  # type: ignore[assignment]  # arrays can be written to

    def __len__(self) -> int:
        """Return the number of vertices."""
        return len(self.values)
