"""Ink limits: the part of a press's device cube that is printable.

A total limit is the largest sum of all inks (240 % on newsprint, 300 to 340 % on coated paper). A
black limit is the largest amount of the black ink. Below the limit, black is an ink like the
others: gamuts without black are up to a fifth smaller.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gamutcore.colours.device.ink_cube import InkCube
from gamutcore.errors import OptionError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.samples import JSON

__all__ = ["BLACK_NAMES", "InkLimits", "LimitedCube", "limited_cube"]

BLACK_NAMES = frozenset({"k", "black", "process black", "schwarz", "noir", "nero", "negro"})
"""Names, in lower case, of the channel of the black ink."""

_APART = 1e-6
"""Smallest range of a varying channel, as a fraction of full ink."""


@dataclass(frozen=True)
class InkLimits:
    """Largest amounts of ink.

    Parameters
    ----------
    total : float or None
        Sum of all inks in per cent of one full ink; None without a limit.
    black : float or None
        Black ink in per cent; None without a limit.
    """

    total: float | None = None
    black: float | None = None

    def __bool__(self) -> bool:
        return self.total is not None or self.black is not None

    def refusal(self, why: str) -> OptionError:
        """Return the error for limits of a device that cannot have them.

        Parameters
        ----------
        why : str
            The kind of data, as a sentence.
        """
        field = "ink_limit" if self.total is not None else "black_limit"
        return OptionError(
            f"{field} does not apply: {why}",
            where={"field": field},
            remedy="Leave it out; limits are for profiles and measurements of inks, such as CMYK.",
        )


@dataclass(frozen=True, eq=False)
class LimitedCube:
    """The printable device values, and the channels that are constant.

    Attributes
    ----------
    cube : InkCube
        Of the channels that vary.
    free : (n,) bool
        Whether each of the device's n channels varies.
    base : (n,) float
        Values of the constant channels.
    provenance : dict or None
        The limits; None for devices without inks.
    """

    cube: InkCube
    free: npt.NDArray[np.bool_]
    base: FloatArray
    provenance: dict[str, JSON] | None

    def device(self, values: FloatArray) -> FloatArray:
        """Return complete device values (m, n) from the values (m, k) of the channels that vary."""
        if self.free.all():
            return values
        device = np.tile(self.base, (len(values), 1))
        device[:, self.free] = values
        return device

    def contains(self, device: FloatArray) -> npt.NDArray[np.bool_]:
        """Whether complete device values, (m, n), are printable, (m,)."""
        values, cube = device[:, self.free], self.cube
        found = (values >= cube.lowest - _APART).all(axis=1)
        found &= (values <= cube.highest + _APART).all(axis=1)
        found &= (np.abs(device - self.base)[:, ~self.free] <= _APART).all(axis=1)
        found &= values.sum(axis=1) <= cube.largest_sum + _APART
        return np.asarray(found)


def limited_cube(
    channels: Sequence[str],
    lowest: FloatArray,
    highest: FloatArray,
    limits: InkLimits,
    *,
    inks: bool,
) -> LimitedCube:
    """Return the part of a device's cube that is within the ink limits.

    `lowest` and `highest` are the range of each of n channels, 0 to 1. Limits of a device without
    inks, a black limit without a black channel, and limits below every device value are refused.
    """
    if limits and not inks:
        raise limits.refusal(f"the channels {', '.join(channels)} are not inks.")
    lowest, highest = np.array(lowest, dtype=np.float64), np.array(highest, dtype=np.float64)
    provenance: dict[str, JSON] | None = None
    if inks:
        provenance = {"total": limits.total, "black": limits.black}
    if limits.black is not None:
        black = _black_channel(channels)
        if limits.black / 100 < lowest[black]:
            raise _nothing_left("black_limit", limits.black, f"{100 * lowest[black]:.4g}")
        highest[black] = min(highest[black], limits.black / 100)
    free = highest - lowest > _APART
    total = None
    if limits.total is not None:
        total = limits.total / 100 - float(lowest[~free].sum())
        if total <= float(lowest[free].sum()) + _APART:
            raise _nothing_left("ink_limit", limits.total, f"{100 * lowest.sum():.4g}")
        # a limit below the range of a single ink shortens that range
        room = total - (float(lowest[free].sum()) - lowest[free])
        highest[free] = np.minimum(highest[free], room)
    cube = InkCube(lowest[free], highest[free], total)
    return LimitedCube(cube, free, lowest, provenance)


def _nothing_left(field: str, value: float, least: str) -> OptionError:
    return OptionError(
        f"{field} is {value:g} %, but the lowest amount in the data is {least} %.",
        where={"field": field},
        remedy=f"Give more than {least} %.",
    )


def _black_channel(channels: Sequence[str]) -> int:
    for number, name in enumerate(channels):
        if name.strip().lower() in BLACK_NAMES:
            return number
    raise OptionError(
        f"black_limit does not apply: none of the inks {', '.join(channels)} is named as black.",
        where={"field": "black_limit"},
        remedy="Leave it out, or name the black ink K or Black.",
    )
