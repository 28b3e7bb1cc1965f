"""Colour spaces: their formulas, parameters and white points; CIELAB and sRGB."""

from gamutcore.colours.spaces.conversion import ColourConversion
from gamutcore.colours.spaces.definitions import CIELAB, SPACES, ColourSpace
from gamutcore.colours.spaces.srgb import linear_srgb, srgb

__all__ = ["CIELAB", "SPACES", "ColourConversion", "ColourSpace", "linear_srgb", "srgb"]
