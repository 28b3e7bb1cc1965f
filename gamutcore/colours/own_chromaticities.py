"""The colours of a device as it shows them, before any adaptation to the white of a space."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces.cielab import lab_to_xyz

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.colours.device.surface import SurfaceColours

__all__ = ["display_primaries", "own_tristimulus"]

_SAME = 1e-6
"""Largest difference of device values that count as equal; files have at most six decimals."""


def own_tristimulus(colours: SurfaceColours) -> tuple[FloatArray, FloatArray]:
    """Return tristimulus values without adaptation, and luminances relative to the white.

    Parameters
    ----------
    colours : SurfaceColours
        In ICC's CIELAB.

    Returns
    -------
    xyz : (n, 3) float
        In an arbitrary common scale, which chromaticities do not depend on.
    luminance : (n,) float
    """
    xyz = lab_to_xyz(np.asarray(colours.points, np.float64))
    absolute = colours.absolute
    own = None if absolute is None else absolute.own_from(colours.provenance.get("intent"))
    return (xyz if own is None else xyz @ own.T), xyz[:, 1]


def display_primaries(colours: SurfaceColours) -> FloatArray | None:
    """Return tristimulus values of full red, green and blue, (3, 3), of a display or an RGB space.

    None for other devices and for pictures, and if one of the three is not among the colours.
    """
    facts = colours.provenance
    lights = (
        facts.get("format") == "reference"
        or str(facts.get("medium", "")).startswith("display")
        or facts.get("device_class") in {"display", "colour space"}
    )
    if colours.channels != ("R", "G", "B") or colours.device is None or not lights:
        return None
    low, high = colours.device.min(axis=0), colours.device.max(axis=0)
    wanted = np.where(np.eye(3, dtype=bool), high, low)
    near = np.abs(colours.device[np.newaxis] - wanted[:, np.newaxis]).max(axis=2) < _SAME
    matches = [np.flatnonzero(rows) for rows in near]
    if not all(len(each) for each in matches):
        return None
    xyz, _ = own_tristimulus(colours)
    return np.stack([xyz[each].mean(axis=0) for each in matches])
