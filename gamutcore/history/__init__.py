"""Histories: every level of a gamut, read, stepped through, saved and loaded."""

from gamutcore.history.history import History
from gamutcore.history.prefix_order import Splits
from gamutcore.history.stepping import LevelCursor

__all__ = ["History", "LevelCursor", "Splits"]
