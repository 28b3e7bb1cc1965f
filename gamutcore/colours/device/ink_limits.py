"""Limits of ink: how much of the device cube of a press is used.

A total limit is the largest sum of all inks that is printed (240 % on newsprint, 300 to 340 % on
coated paper), a black limit the most of the black ink alone. Black stays an ink like the others
below it: gamuts without black are up to a fifth smaller.
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
"""Names, in lower case, of the channel that is the black ink."""

_APART = 1e-6
"""Part of full ink below which a channel is taken not to vary."""


@dataclass(frozen=True)
class InkLimits:
    """What is printed at most.

    Parameters
    ----------
    total : float or None
        Sum of all inks, in per cent of one full ink; None without a limit.
    black : float or None
        The black ink, in per cent; None without a limit.
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
            What the data is, as a sentence.

        Returns
        -------
        OptionError
        """
        field = "ink_limit" if self.total is not None else "black_limit"
        return OptionError(
            f"{field} does not apply: {why}",
            where={"field": field},
            remedy="Leave it out; limits are for profiles and measurements of inks, such as CMYK.",
        )


@dataclass(frozen=True, eq=False)
class LimitedCube:
    """The device values that are used, and the channels that stay at one value.

    Parameters
    ----------
    cube : InkCube
        Of the channels that vary.
    free : (n,) bool
        Which of the device's n channels vary.
    base : (n,) float
        Values of the others.
    provenance : dict or None
        The limits; None for devices without inks.
    """

    cube: InkCube
    free: npt.NDArray[np.bool_]
    base: FloatArray
    provenance: dict[str, JSON] | None

    def device(self, values: FloatArray) -> FloatArray:
        """Return whole device values from those of the channels that vary.

        Parameters
        ----------
        values : (m, k) float

        Returns
        -------
        (m, n) float
        """
        if self.free.all():
            return values
        device = np.tile(self.base, (len(values), 1))
        device[:, self.free] = values
        return device


def limited_cube(
    channels: Sequence[str],
    lowest: FloatArray,
    highest: FloatArray,
    limits: InkLimits,
    *,
    inks: bool,
) -> LimitedCube:
    """Return the part of a device's cube that is within the limits of ink.

    Parameters
    ----------
    channels : sequence of str
        Names of the n channels.
    lowest, highest : (n,) float
        Ends of each channel's range, 0 to 1.
    limits : InkLimits
    inks : bool
        Whether the channels are inks.

    Returns
    -------
    LimitedCube

    Raises
    ------
    OptionError
        There are limits, and the device has no inks, no channel known for black, or nothing is left
        within them.
    """
    if limits and not inks:
        raise limits.refusal(f"the device's channels are {', '.join(channels)}, which are no inks.")
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
        # A limit below an ink's own range shortens that range.
        room = total - (float(lowest[free].sum()) - lowest[free])
        highest[free] = np.minimum(highest[free], room)
    cube = InkCube(lowest[free], highest[free], total)
    return LimitedCube(cube, free, lowest, provenance)


def _nothing_left(field: str, value: float, least: str) -> OptionError:
    return OptionError(
        f"{field} is {value:g} %, and the data begins at {least} %.",
        where={"field": field},
        remedy=f"More than {least} %.",
    )


def _black_channel(channels: Sequence[str]) -> int:
    for number, name in enumerate(channels):
        if name.strip().lower() in BLACK_NAMES:
            return number
    raise OptionError(
        f"black_limit does not apply: none of the inks {', '.join(channels)} is known for black.",
        where={"field": "black_limit"},
        remedy="Leave it out; the black ink is known by the name K or Black.",
    )
