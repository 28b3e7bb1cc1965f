"""Single inks that a link from press to press keeps pure: black text, and solid primaries.

The colours of a press have many recipes, so a link that goes through colours alone prints black
text in four inks. A link that preserves black leads from black alone to black alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from gamutcore.arguments import Choice, check_option
from gamutcore.colours import BLACK_NAMES
from gamutcore.errors import OptionError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.colours import DeviceModel

__all__ = ["PRESERVE", "PureInks"]

PRESERVE = Annotated[str, Choice(("black", "primaries"))]
"""Inks that stay pure: black alone, or every ink."""

_STEPS = 1025
"""Amounts of an ink between which its tone curve is straight: four to a step of 8 bits."""


@dataclass(frozen=True, eq=False)
class PureInks:
    """Pairs of a source's channel and a destination's, with the tone curve of each pair.

    `paper` (k,) are the destination's values without ink. A curve (steps,) has the amounts of the
    destination's ink. The shares of the way from paper to the solid colour are equal, as measured
    along the colours of the ink in CIELAB. Paper stays paper, and a solid ink stays solid.
    """

    paper: FloatArray
    pairs: tuple[tuple[int, int], ...]
    curves: tuple[FloatArray, ...]

    @classmethod
    def of(cls, preserve: str, source: DeviceModel, destination: DeviceModel) -> PureInks:
        """Return those of two presses; raise OptionError if they do not have the same inks."""
        check_option("preserve", preserve, PRESERVE)
        if not (source.inks and destination.inks):
            raise _not_applicable(preserve, "one of the devices is no press")
        inks, others = _names(source), _names(destination)
        if preserve == "black":
            inks = {"k": inks["k"]} if "k" in inks else {}
        missing = inks.keys() - others.keys()
        if missing or not inks:
            names = ", ".join(source.channels[inks[ink]] for ink in sorted(missing)) or "black"
            raise _not_applicable(preserve, f"one of the presses does not have the ink {names}")
        pairs = tuple((inks[name], others[name]) for name in inks)
        curves = tuple(
            _tone_curve(_ramp(source, one), _ramp(destination, two)) for one, two in pairs
        )
        return cls(destination.limited.base, pairs, curves)

    def write(self, values: FloatArray, device: FloatArray) -> None:
        """Write those of the device values (m, k) whose values in the source are of one ink."""
        used = values > 0.0
        steps = np.linspace(0.0, 1.0, _STEPS)
        for (one, two), curve in zip(self.pairs, self.curves, strict=True):
            rows = np.flatnonzero(used.sum(axis=1) == used[:, one])
            device[rows] = self.paper
            device[rows, two] = np.interp(values[rows, one], steps, curve)


def _names(model: DeviceModel) -> dict[str, int]:
    """Return the channels that vary by name, with ``k`` for black."""
    names = (name.strip().lower() for name in model.channels)
    return {
        "k" if name in BLACK_NAMES else name: number
        for number, name in enumerate(names)
        if model.limited.free[number]
    }


def _ramp(model: DeviceModel, channel: int) -> tuple[FloatArray, FloatArray]:
    """Return amounts of one ink within its limit, and the way from paper along their colours."""
    limited = model.limited
    place = int(limited.free[:channel].sum())
    device = np.repeat(limited.base[np.newaxis], _STEPS, axis=0)
    device[:, channel] = np.linspace(limited.base[channel], limited.cube.highest[place], _STEPS)
    steps = np.linalg.norm(np.diff(model.lab(device), axis=0), axis=1)
    return device[:, channel], np.concatenate([[0.0], np.cumsum(steps)])


def _tone_curve(
    source: tuple[FloatArray, FloatArray], destination: tuple[FloatArray, FloatArray]
) -> FloatArray:
    (amounts, way), (others, other_way) = source, destination
    share = np.interp(np.linspace(0.0, 1.0, _STEPS), amounts, way / way[-1])
    return np.asarray(np.interp(share, other_way / other_way[-1], others))


def _not_applicable(preserve: str, why: str) -> OptionError:
    return OptionError.not_applicable(
        "preserve", preserve, why, "Leave it out, or give two presses with the same inks."
    )
