"""Colours at the surface of a device's gamut, from characterisation data.

`surface_colours` is the entry point. `spaces` has the colour spaces, and `device` the device
models.
"""

from gamutcore.colours.device.ink_cube import spread_values, values_beside
from gamutcore.colours.device.ink_limits import InkLimits
from gamutcore.colours.own_chromaticities import display_primaries, own_tristimulus
from gamutcore.colours.spaces.cielab import ICC_D50, lab_to_xyz, xyz_to_lab
from gamutcore.colours.surface import (
    INTENTS,
    SurfaceColours,
    colours_in_space,
    surface_colours,
)
from gamutcore.colours.volumes import described_volumes, medium_white_lab

__all__ = [
    "ICC_D50",
    "INTENTS",
    "InkLimits",
    "SurfaceColours",
    "colours_in_space",
    "described_volumes",
    "display_primaries",
    "lab_to_xyz",
    "medium_white_lab",
    "own_tristimulus",
    "spread_values",
    "surface_colours",
    "values_beside",
    "xyz_to_lab",
]
