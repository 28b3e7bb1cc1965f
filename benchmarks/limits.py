"""Levels selected by an error limit: triangle counts and search times.

Times are processor times of one core.
"""

from __future__ import annotations

import time
from math import inf
from statistics import geometric_mean, mean, median
from typing import Any

import numpy as np

from benchmarks.devices import Device
from gamutcore.metric.error_curve import curve_counts, error_curve
from gamutcore.metric.level_search import Bounds, LevelSearch, error_bounds

__all__ = ["limit_rows"]

LIMITS = {
    "max_error": [Bounds(distance, inf) for distance in np.geomspace(5e-3, 5.0, 31).tolist()],
    "max_mismatch": [Bounds(inf, mismatch) for mismatch in np.geomspace(1e-5, 1e-2, 31).tolist()],
}
"""Limits by query parameter: ΔE, and fractions of the volume."""

COARSE = 1000
"""All levels up to this triangle count are compared with the full boundary to find the smallest."""


def limit_rows(device: Device) -> list[dict[str, Any]]:
    """Search levels of a device's histories.

    Returns
    -------
    list of dict
        One row for each cost and parameter. ``limits`` is the number of limits, ``coarse`` the
        number that a level of at most `COARSE` triangles keeps. ``excess`` and ``most_excess`` are
        the mean and the maximum over the latter of the triangle count found ÷ the smallest count
        that keeps the limit. ``saved`` and ``most_saved`` are the geometric mean and the maximum of
        the count that the error curve needs ÷ the count found. ``median_s`` and ``longest_s`` are
        times of a search.
    """
    rows = []
    for cost, history in device.histories.items():
        curve = [
            error.to_mapping() for error in error_curve(history, curve_counts(history.triangles))
        ]
        search = LevelSearch(curve)
        coarse = {
            level.triangles: level.bounds
            for level in error_bounds(history, range(4, COARSE + 1, 2))
        }
        for name, limits in LIMITS.items():
            saved, excess, seconds = [], [], []
            for limit in limits:
                start = time.process_time()
                count = search.find(history, limit).triangles
                seconds.append(time.process_time() - start)
                saved.append(_curve_count(curve, limit) / count)
                keeping = [n for n, bounds in coarse.items() if bounds.within(limit)]
                if keeping:
                    excess.append(count / min(keeping))
            rows.append(
                {
                    "device": device.name,
                    "cost": cost,
                    "limit": name,
                    "limits": len(limits),
                    "coarse": len(excess),
                    "excess": mean(excess),
                    "most_excess": max(excess),
                    "saved": geometric_mean(saved),
                    "most_saved": max(saved),
                    "median_s": median(seconds),
                    "longest_s": max(seconds),
                }
            )
    return rows


def _curve_count(curve: list[dict[str, Any]], limit: Bounds) -> int:
    """Triangle count of the smallest level of an error curve that keeps a limit."""
    return min(
        int(level["triangles"])
        for level in curve
        if Bounds(level["distance_bound"], level["mismatch_bound"]).within(limit)
    )
