"""Histories: every level of a gamut, read, stepped through, saved and loaded."""

from gamutcore.history.device_history import DeviceHistory
from gamutcore.history.file import history_bytes, history_from_bytes, history_metadata
from gamutcore.history.history import MINIMUM_TRIANGLES, History, build_history
from gamutcore.history.prefix_order import Splits
from gamutcore.history.stepping import LevelCursor

__all__ = [
    "MINIMUM_TRIANGLES",
    "DeviceHistory",
    "History",
    "LevelCursor",
    "Splits",
    "build_history",
    "history_bytes",
    "history_from_bytes",
    "history_metadata",
]
