"""Levels that are chosen by a limit to the error: how many triangles, how long it takes.

Each limit is searched with nothing remembered from the one before, as the first client who asks for
it meets it. Times are processor time of one core.
"""

from __future__ import annotations

import time
from math import inf
from statistics import geometric_mean, mean, median
from typing import Any

import numpy as np

from benchmarks.devices import Device
from gamutcore.history import History
from gamutcore.metric.error_curve import curve_counts, error_curve
from gamutcore.metric.level_search import Bounds, FullBoundary, LevelSearch

__all__ = ["limit_rows"]

ASKED = {
    "max_error": [Bounds(distance, inf) for distance in np.geomspace(5e-3, 5.0, 31).tolist()],
    "max_mismatch": [Bounds(inf, mismatch) for mismatch in np.geomspace(1e-5, 1e-2, 31).tolist()],
}
"""Limits by the name of their parameter: ΔE, and parts of the volume."""

COARSE = 1000
"""Triangles up to which all levels are compared with the full boundary, to know the smallest."""


def limit_rows(device: Device, histories: dict[str, History]) -> list[dict[str, Any]]:
    """Search levels of a device's histories.

    Parameters
    ----------
    device : Device
    histories : dict of History
        By the name of the cost.

    Returns
    -------
    list of dict
        For each cost and parameter: ``limits``, how many; ``coarse``, how many of them are kept by
        a level of at most `COARSE` triangles, and ``excess`` and ``most_excess``, triangles of the
        level found ÷ those of the smallest of all that keep them, mean and largest of these;
        ``saved`` and ``most_saved``, triangles of the smallest level of the error curve that
        promises as much ÷ those of the level found, geometric mean and largest; ``median_s`` and
        ``longest_s``.
    """
    rows = []
    for cost, history in histories.items():
        curve = [
            error.to_mapping() for error in error_curve(history, curve_counts(history.triangles))
        ]
        full = FullBoundary(history)
        coarse = {count: full.bounds(count) for count in range(4, COARSE + 1, 2)}
        for name, limits in ASKED.items():
            found, seconds = [], []
            for limit in limits:
                start = time.process_time()
                found.append(LevelSearch(history.triangles, curve).find(history, limit).triangles)
                seconds.append(time.process_time() - start)
            asked = list(zip(limits, found, strict=True))
            saved = [by_curve(curve, limit) / count for limit, count in asked]
            kept = [[n for n, bounds in coarse.items() if bounds.within(one)] for one in limits]
            excess = [
                one / min(all_kept) for one, all_kept in zip(found, kept, strict=True) if all_kept
            ]
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


def by_curve(curve: list[dict[str, Any]], limit: Bounds) -> int:
    """Triangles of the smallest level whose bounds in the curve are within a limit."""
    return min(
        int(level["triangles"])
        for level in curve
        if Bounds(level["distance_bound"], level["mismatch_bound"]).within(limit)
    )
