"""Measurements of `gamutcore`: building histories, reading levels, accuracy, memory.

Each function returns plain numbers; `bench` arranges and prints them. Times are medians of several
runs after one that warms up.
"""

from __future__ import annotations

import functools
import re
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks.files import device_data
from gamutcore.boundary import Boundary, modified_convex_hull
from gamutcore.colours import surface_colours
from gamutcore.decimation import COSTS, decimate
from gamutcore.gamut import Options, build_gamut
from gamutcore.history import History, build_history
from gamutcore.metric import mismatch

__all__ = ["accuracy", "build_times", "level_times", "peak_megabytes", "peak_memory"]

ROOT = Path(__file__).parent.parent
SRGB = ROOT / "tests" / "data" / "sRGB-v4.icc"
FOGRA39L = ROOT / "examples" / "FOGRA39L.ti3"

PUBLISHED = {1000: 0.124, 500: 0.224, 100: 1.01, 50: 2.46, 20: 5.3, 10: 17.8}
"""Mismatch of FOGRA39L with the published cost, in %, as measured before this project was begun."""


def median_seconds(function: Callable[[], object], runs: int) -> float:
    """Median time of a call, after one call that is not counted."""
    function()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return median(times)


def srgb_surface(samples: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """CIELAB colours of the surface of the sRGB cube, at most so many."""
    device = device_data(SRGB.read_bytes())
    return surface_colours(device, surface_samples=samples).points


def history(samples: int, cost: str = "volume") -> History:
    """History of the sRGB cube's surface."""
    return _decimated_history(modified_convex_hull(srgb_surface(samples)), cost)


def _decimated_history(boundary: Boundary, cost: str) -> History:
    return build_history(decimate(boundary.mesh, boundary.centre, cost))


def build_times(samples: int, runs: int) -> list[dict[str, Any]]:
    """Time from points to a complete history, for every cost."""
    points = srgb_surface(samples)
    boundary = modified_convex_hull(points)
    hull = median_seconds(lambda: modified_convex_hull(points), runs)
    rows = []
    for cost in COSTS:
        steps = median_seconds(functools.partial(_decimated_history, boundary, cost), runs)
        rows.append(
            {
                "cost": cost,
                "points": len(points),
                "triangles": boundary.mesh.triangles,
                "boundary_s": hull,
                "decimation_s": steps,
                "decimation_us_per_triangle": 1e6 * steps / boundary.mesh.triangles,
                "total_s": hull + steps,
            }
        )
    return rows


def level_times(sizes: list[int], runs: int) -> list[dict[str, Any]]:
    """Time to read levels of histories of different sizes: milliseconds by triangle count."""
    rows = []
    for samples in sizes:
        built = history(samples, "quadric")
        row: dict[str, Any] = {
            "points": samples,
            "triangles": built.triangles,
            "memory_bytes_per_triangle": built.nbytes / built.triangles,
        }
        for count in (100, 1000, 10_000, built.triangles):
            if count <= built.triangles:
                name = "full_ms" if count == built.triangles else f"{count}_ms"
                read = functools.partial(built.level, count)
                row[name] = 1e3 * median_seconds(read, runs)
        rows.append(row)
    return rows


def accuracy(counts: list[int]) -> list[dict[str, Any]]:
    """Exact mismatch of FOGRA39L's levels, in %, for every cost."""
    data = FOGRA39L.read_bytes()
    rows: list[dict[str, Any]] = [
        {"cost": "published figures", **{str(n): PUBLISHED.get(n) for n in counts}}
    ]
    for cost in COSTS:
        built = build_gamut(data, Options(cost=cost)).history
        full = built.full()
        rows.append(
            {"cost": cost, **{str(n): 100 * mismatch(full, built.level(n)) for n in counts}}
        )
    return rows


def peak_memory(samples: int, cost: str) -> dict[str, Any]:
    """Largest resident size of a process that samples a profile and builds one history from it."""
    code = (
        f"from benchmarks.compute import history, peak_megabytes; history({samples}, {cost!r})\n"
        "print(peak_megabytes())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return {"cost": cost, "points": samples, "peak_mb": float(done.stdout)}


def peak_megabytes() -> float:
    """Largest resident size of this process so far."""
    # Linux: getrusage's peak is taken over from the process that started this one.
    status = Path("/proc/self/status")
    found = re.search(r"VmHWM:\s*(\d+)", status.read_text()) if status.exists() else None
    if found:
        return int(found[1]) / 1024
    # kilobytes, on macOS bytes
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024 if sys.platform == "darwin" else 1) / 1024
