"""Decimation: edge collapses, cheapest first, from the full boundary down to four triangles."""

from gamutcore.decimation.costs import COSTS
from gamutcore.decimation.schedule import Decimation, decimate

__all__ = ["COSTS", "Decimation", "decimate"]
