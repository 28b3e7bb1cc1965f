"""Levels on one side: surfaces that are contained in the full boundary, or contain it."""

from gamutcore.sides.sided_level import SIDES, Side, sided_level
from gamutcore.sides.sided_search import SidedSearch

__all__ = ["SIDES", "Side", "SidedSearch", "sided_level"]
