"""Speed and memory of `gamutcore` on one core."""

from __future__ import annotations

import functools
import sys
from statistics import median
from typing import Any

from benchmarks.common import (
    SRGB,
    build_mesh_history,
    resident_bytes,
    run_module,
    surface_points,
    times_of,
)
from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS

__all__ = ["build_times", "level_times", "peak_memory"]

Rows = list[dict[str, Any]]


def build_times(samples: int, runs: int) -> Rows:
    """Time from surface colours to a complete history, for every cost."""
    points = surface_points(SRGB, samples)
    boundary = modified_convex_hull(points)
    boundary_s = median(times_of(lambda: modified_convex_hull(points), runs))
    rows = []
    for cost in COSTS:
        decimate = functools.partial(build_mesh_history, boundary.mesh, boundary.centre, cost)
        decimation_s = median(times_of(decimate, runs))
        rows.append(
            {
                "cost": cost,
                "points": len(points),
                "triangles": boundary.mesh.triangles,
                "boundary_s": boundary_s,
                "decimation_s": decimation_s,
                "decimation_us_per_triangle": 1e6 * decimation_s / boundary.mesh.triangles,
                "total_s": boundary_s + decimation_s,
            }
        )
    return rows


def level_times(sizes: list[int], runs: int) -> Rows:
    """Time to read levels of histories of different sizes."""
    rows = []
    for samples in sizes:
        boundary = modified_convex_hull(surface_points(SRGB, samples))
        history = build_mesh_history(boundary.mesh, boundary.centre, "quadric")
        row: dict[str, Any] = {
            "points": samples,
            "triangles": history.triangles,
            "memory_bytes_per_triangle": history.nbytes / history.triangles,
        }
        for count in (100, 1000, 10_000, history.triangles):
            name = "full_ms" if count == history.triangles else f"{count}_ms"
            row[name] = 1e3 * median(times_of(functools.partial(history.level, count), runs))
        rows.append(row)
    return rows


def peak_memory(samples: int, cost: str) -> dict[str, Any]:
    """Peak resident memory of a process that builds one history of sRGB from the profile."""
    peak = float(run_module("compute", str(samples), cost))
    return {"cost": cost, "points": samples, "peak_mb": peak / 2**20}


def main() -> None:
    """Build one history and print this process's peak resident memory in bytes."""
    samples, cost = sys.argv[1:]
    boundary = modified_convex_hull(surface_points(SRGB, int(samples)))
    build_mesh_history(boundary.mesh, boundary.centre, cost)
    print(resident_bytes("VmHWM"))


if __name__ == "__main__":
    main()
