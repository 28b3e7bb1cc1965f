"""Histories: every level of a gamut, read, stepped through, saved and loaded.

`splits` has the numbering of all levels, and how splits and collapses change them. `history` reads
levels. `device` adds device values. `file` is the history file, and `columns` its groups of splits.
"""

from gamutcore.history.device import DeviceHistory, build_device_history, nearest_places
from gamutcore.history.file import (
    history_bytes,
    history_description,
    history_from_bytes,
    history_prefix,
    history_section,
)
from gamutcore.history.history import MINIMUM_TRIANGLES, History, LevelCursor, build_history
from gamutcore.history.splits import Splits, apply_splits, fine_columns

__all__ = [
    "MINIMUM_TRIANGLES",
    "DeviceHistory",
    "History",
    "LevelCursor",
    "Splits",
    "apply_splits",
    "build_device_history",
    "build_history",
    "fine_columns",
    "history_bytes",
    "history_description",
    "history_from_bytes",
    "history_prefix",
    "history_section",
    "nearest_places",
]
