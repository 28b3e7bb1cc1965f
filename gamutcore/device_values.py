"""Device values at the vertices of a mesh: the inks or lights that produce each colour."""

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
    """The values of the channels of a device, vertex by vertex.

    Parameters
    ----------
    channels : tuple of str
        Names of the k channels (inks or lights), as in the characterisation data.
    values : (m, k) float
        From 0 to 1.

    Raises
    ------
    MeshError
        The array has another shape, or values outside 0 to 1.
    """

    channels: tuple[str, ...]
    values: PositionArray

    def __post_init__(self) -> None:
        values = np.asarray(self.values)
        if values.ndim != 2 or not 0 < values.shape[1] == len(self.channels):
            raise MeshError(
                f"Device values of {len(self.channels)} channels have the shape {values.shape}.",
                where={"field": "values"},
                remedy="Give an (m, k) array and the names of its k ≥ 1 channels.",
            )
        if values.dtype.kind != "f" or not ((values >= 0) & (values <= 1)).all():
            raise MeshError(
                "The device values are not all numbers from 0 to 1.",
                where={"field": "values"},
                remedy="Give fractions of full scale, as floats.",
            )

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, DeviceValues)
            and self.channels == other.channels
            and np.array_equal(self.values, other.values)
        )

    __hash__ = None  # type: ignore[assignment]  # arrays are mutable

    def __len__(self) -> int:
        """Return the number of vertices."""
        return len(self.values)
