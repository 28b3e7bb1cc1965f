"""Colour spaces: their formulas, parameters and white points; CIELAB and sRGB."""

from gamutcore.colours.spaces.definitions import CIELAB, SPACES, ColourSpace

__all__ = ["CIELAB", "SPACES", "ColourSpace"]
