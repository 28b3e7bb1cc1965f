"""Levels: requests, their errors, the smallest within limits, and one side; mismatch of gamuts."""

from gamutcore.levels.error_curve import (
    NO_ERROR,
    BoundedLevel,
    Bounds,
    LevelError,
    curve_counts,
    error_curve,
    round_up,
)
from gamutcore.levels.level_search import DEFAULT_TRIANGLES, LevelRequest, LevelSearch, error_bounds
from gamutcore.levels.overlay import Distances, RadialDifference, radial_difference
from gamutcore.levels.sides import SIDES, Side, sided_level

__all__ = [
    "DEFAULT_TRIANGLES",
    "NO_ERROR",
    "SIDES",
    "BoundedLevel",
    "Bounds",
    "Distances",
    "LevelError",
    "LevelRequest",
    "LevelSearch",
    "RadialDifference",
    "Side",
    "curve_counts",
    "error_bounds",
    "error_curve",
    "radial_difference",
    "round_up",
    "sided_level",
]
