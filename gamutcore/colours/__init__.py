"""Characterisation data turned into points of the colour space, at the surface of the gamut.

`surface_colours` is the way in; `xyz_to_lab` and `lab_to_xyz` are CIELAB with the D50 of ICC
profiles.
"""

from gamutcore.colours.device.ink_limits import InkLimits
from gamutcore.colours.spaces.cielab import ICC_D50, lab_to_xyz, xyz_to_lab
from gamutcore.colours.surface import INTENTS, SurfaceColours, surface_colours

__all__ = [
    "ICC_D50",
    "INTENTS",
    "InkLimits",
    "SurfaceColours",
    "lab_to_xyz",
    "surface_colours",
    "xyz_to_lab",
]
