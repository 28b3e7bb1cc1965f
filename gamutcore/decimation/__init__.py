"""Decimation: edge collapses, cheapest first, from the full boundary down to four triangles."""

from gamutcore.decimation.costs import COSTS
from gamutcore.decimation.decimate import Decimation, decimated

__all__ = ["COSTS", "Decimation", "decimated"]
