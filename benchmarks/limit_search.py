"""Whether answers to error limits contradict each other, over 20 gamuts, 70 limits and all costs.

``python -m benchmarks.limit_search`` writes ``benchmarks/limit_search.json``. The gamuts are those
of `benchmarks.devices` and RGB spaces of colour-science. Levels up to `EVERY` triangles are all
compared, to find the smallest level that keeps a limit.
"""

from __future__ import annotations

import json
import time
from itertools import pairwise
from typing import Any

import colour
import numpy as np

from benchmarks.common import ROOT, build_mesh_history
from benchmarks.devices import devices
from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS
from gamutcore.history import History
from gamutcore.metric.error_curve import curve_counts, error_curve
from gamutcore.metric.level_search import Bounds, LevelSearch, error_bounds

GAMUTS = 20
LIMITS = np.geomspace(3.0, 0.05, 70).tolist()
EVERY = 1500
STEPS = 60
"""Steps of each axis of the faces of an RGB cube: 22,000 colours."""


def rgb_space(name: str) -> np.ndarray:
    """Return CIELAB colours of the surface of an RGB space's cube, shape (n, 3)."""
    space = colour.RGB_COLOURSPACES[name]
    steps = np.linspace(0.0, 1.0, STEPS + 1)
    cube = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1).reshape(-1, 3)
    faces = cube[((cube == 0.0) | (cube == 1.0)).any(axis=1)]
    xyz = (faces**2.2) @ space.matrix_RGB_to_XYZ.T
    return np.asarray(colour.XYZ_to_Lab(xyz, space.whitepoint))


def gamut_rows(name: str, histories: dict[str, History]) -> list[dict[str, Any]]:
    """Return one row for each cost: violations, and the largest excess of a count."""
    rows, answers = [], {}
    for cost, history in histories.items():
        curve = error_curve(history, curve_counts(history.triangles))
        search = LevelSearch([level.to_mapping() for level in curve])
        start = time.process_time()
        found = [search.find(history, Bounds(limit)) for limit in LIMITS]
        seconds = (time.process_time() - start) / len(LIMITS)
        every = error_bounds(history, range(4, min(EVERY, history.triangles), 2))
        pairs = [(level.triangles, level.bounds.distance) for level in every]
        excess = []
        for limit, level in zip(LIMITS, found, strict=True):
            smallest = next((count for count, distance in pairs if distance <= limit), None)
            if smallest is not None:
                excess.append(level.triangles / smallest)
        counts = [level.triangles for level in found]
        answers[cost] = counts
        rows.append(
            {
                "gamut": name,
                "triangles": history.triangles,
                "cost": cost,
                "fewer_for_tighter": sum(a > b for a, b in pairwise(counts)),
                "promised_by_smaller": sum(
                    any(
                        other.triangles < level.triangles and other.bounds.distance <= limit
                        for other in found
                    )
                    for limit, level in zip(LIMITS, found, strict=True)
                ),
                "kept": sum(
                    level.bounds.distance <= limit
                    for limit, level in zip(LIMITS, found, strict=True)
                ),
                "compared": len(excess),
                "most_excess": max(excess),
                "search_s": seconds,
            }
        )
    for row in rows:
        row["more_than_volume"] = sum(
            own > other for own, other in zip(answers[row["cost"]], answers["volume"], strict=True)
        )
    return rows


def main() -> None:
    """Measure all gamuts and write the results."""
    rows = []
    for device in devices():
        rows += gamut_rows(device.name, device.histories)
    others = sorted(name for name in colour.RGB_COLOURSPACES if "Log" not in name)
    for name in others[:: len(others) // (GAMUTS - len(rows) // len(COSTS))]:
        if len(rows) >= GAMUTS * len(COSTS):
            break
        boundary = modified_convex_hull(rgb_space(name))
        histories = {
            cost: build_mesh_history(boundary.mesh, boundary.centre, cost) for cost in COSTS
        }
        rows += gamut_rows(name, histories)
        print(rows[-1], flush=True)
    path = ROOT / "benchmarks" / "limit_search.json"
    path.write_text(json.dumps({"limits": len(LIMITS), "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
