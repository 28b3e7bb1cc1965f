"""Levels that are chosen by a limit to the error: how many triangles, how long it takes.

Each limit is searched with nothing remembered from the one before, as the first client who asks for
it meets it. Times are processor time of one core.
"""

from __future__ import annotations

import time
from math import inf
from statistics import geometric_mean, median
from typing import Any

import numpy as np

from benchmarks.devices import Device
from gamutcore.history import History
from gamutcore.metric.error_curve import curve_counts, error_curve
from gamutcore.metric.level_choice import RESOLUTION, Bounds, FullBoundary, LevelChoice

__all__ = ["limit_rows"]

ASKED = {
    "max_error": [Bounds(distance, inf) for distance in np.geomspace(5e-3, 5.0, 31).tolist()],
    "max_mismatch": [Bounds(inf, mismatch) for mismatch in np.geomspace(1e-5, 1e-2, 31).tolist()],
}
"""Limits by the name of their parameter: ΔE, and parts of the volume."""


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
        For each cost and parameter: ``limits``, how many; ``kept``, how many of the levels found
        keep them by a comparison with the full boundary; ``smallest``, of how many that is so and
        the level with a 128th fewer triangles does not; ``saved`` and ``most_saved``, triangles of
        the smallest level of the error curve that promises as much ÷ those of the level found,
        geometric mean and largest; ``median_s`` and ``longest_s``.
    """
    rows = []
    for cost, history in histories.items():
        curve = [
            error.to_mapping() for error in error_curve(history, curve_counts(history.triangles))
        ]
        full = FullBoundary(history)
        for name, limits in ASKED.items():
            found, seconds = [], []
            for limit in limits:
                start = time.process_time()
                found.append(LevelChoice(history.triangles, curve).found(history, limit))
                seconds.append(time.process_time() - start)
            saved = [
                by_curve(curve, limit) / level.triangles
                for limit, level in zip(limits, found, strict=True)
            ]
            rows.append(
                {
                    "device": device.name,
                    "cost": cost,
                    "limit": name,
                    "limits": len(limits),
                    "kept": sum(
                        full.bounds(level.triangles).within(limit)
                        for limit, level in zip(limits, found, strict=True)
                    ),
                    "smallest": sum(
                        not full.bounds(coarser(level.triangles)).within(limit)
                        for limit, level in zip(limits, found, strict=True)
                    ),
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


def coarser(triangles: int) -> int:
    """Triangles of the level that a search does not find if it need not be finer."""
    return max(4, triangles - max(2, 2 * (triangles // (2 * RESOLUTION))))
