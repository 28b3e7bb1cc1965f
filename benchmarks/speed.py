"""Time and memory of complete histories, for boundaries of 50 to 2.5 million triangles.

Times are processor times of one core with compiled kernels: the shortest and the median of several
runs. Memory is the growth of a fresh process during the decimation, which
``python -m benchmarks.speed FILE COST`` measures.
"""

from __future__ import annotations

import functools
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks.common import (
    SRGB,
    build_mesh_history,
    resident_bytes,
    run_module,
    surface_points,
    times_of,
)
from benchmarks.peers import PEERS
from gamutcore.boundary import Boundary, modified_convex_hull
from gamutcore.decimation import COSTS
from gamutcore.history import History, history_bytes, history_from_bytes
from gamutcore.mesh import TriangleMesh
from gamutcore.metric.error_curve import curve_counts, error_curve

__all__ = [
    "LEVEL",
    "few_triangles",
    "history_times",
    "peer_times",
    "scaling",
    "shortest_times",
    "storage",
    "timed_histories",
    "with_memory",
]

SIZES = (105_000, 380_000, 1_750_000)
"""Surface samples for boundaries of about 180,000, 650,000 and 2,600,000 triangles."""

FEW = (30, 100, 400, 1200, 3400, 10_000, 32_000)
"""Surface samples for boundaries of about 50 to 60,000 triangles."""

LEVEL = 1000
"""Triangle count that the other libraries are asked for."""

Rows = list[dict[str, Any]]

process_times = functools.partial(times_of, clock=time.process_time)


def timed_histories(boundary: Boundary, runs: int) -> tuple[dict[str, History], Rows]:
    """Build the history of a boundary with every cost, and time it.

    Returns
    -------
    histories : dict of History
        By the name of the cost.
    rows : list of dict
        ``cost``, ``triangles``, ``seconds`` (shortest), ``median_s``, ``us_per_triangle``,
        ``curve_s`` (error curve, shortest), ``curve_part`` (of ``seconds``) and
        ``bits_per_vertex`` of the history file.
    """
    histories, rows = {}, []
    for cost in COSTS:
        times = process_times(
            functools.partial(build_mesh_history, boundary.mesh, boundary.centre, cost), runs
        )
        history = histories[cost] = build_mesh_history(boundary.mesh, boundary.centre, cost)
        curve = functools.partial(error_curve, history, curve_counts(history.triangles))
        curve_s = process_times(curve, runs)[0]
        rows.append(
            {
                "cost": cost,
                "triangles": boundary.mesh.triangles,
                "seconds": times[0],
                "median_s": median(times),
                "us_per_triangle": 1e6 * times[0] / boundary.mesh.triangles,
                "curve_s": curve_s,
                "curve_part": curve_s / times[0],
                "bits_per_vertex": 8 * len(history_bytes(history)) / history.vertices,
            }
        )
    return histories, rows


def shortest_times(boundary: Boundary, runs: int, processes: int) -> Rows:
    """Return the rows of `timed_histories` with the shortest times of several processes.

    Where a process's arrays lie in memory changes a time by up to 1.7.
    """
    context = get_context("spawn")
    measured = []
    for _ in range(processes):
        with ProcessPoolExecutor(1, context) as pool:
            measured.append(pool.submit(_times, boundary, runs).result())
    return [min(rows, key=lambda row: row["seconds"]) for rows in zip(*measured, strict=True)]


def _times(boundary: Boundary, runs: int) -> Rows:
    return timed_histories(boundary, runs)[1]


def with_memory(boundary: Boundary, rows: Rows) -> Rows:
    """Return the rows of a boundary with the memory of its decimation in bytes per triangle."""
    return [
        {**row, "bytes_per_triangle": memory_growth(boundary, row["cost"]) / row["triangles"]}
        for row in rows
    ]


def history_times(runs: int) -> Rows:
    """Time complete histories of the sRGB boundary."""
    return timed_histories(srgb_boundary(100_000), runs)[1]


def peer_times() -> Rows:
    """Time one level of the sRGB boundary from each installed library."""
    mesh = srgb_boundary(100_000).mesh
    vertices, faces = mesh.vertices.astype(np.float64), mesh.faces.astype(np.int64)
    rows = []
    for name, (_, peer) in PEERS.items():
        try:
            runs = [peer(vertices, faces, LEVEL) for _ in range(3)]
        except ImportError:
            continue
        times = sorted(run[2] for run in runs)
        level = len(runs[0][1])
        rows.append({"peer": name, "level": level, "seconds": times[0], "median_s": times[1]})
    return rows


def scaling(runs: int) -> Rows:
    """Time and memory by the size of the boundary."""
    rows = []
    for samples in SIZES:
        boundary = srgb_boundary(samples)
        timed = timed_histories(boundary, runs if samples < 1_000_000 else 1)[1]
        rows += with_memory(boundary, timed)
    return rows


def few_triangles(runs: int) -> Rows:
    """Time, memory and file sizes of small boundaries."""
    boundaries = map(srgb_boundary, FEW)
    return [
        row
        for boundary in boundaries
        for row in with_memory(boundary, timed_histories(boundary, runs)[1])
    ]


def storage(runs: int) -> Rows:
    """Size of history files of about 200,000 triangles, and the times to read levels."""
    boundary = srgb_boundary(115_000)
    rows = []
    for cost in COSTS:
        history = build_mesh_history(boundary.mesh, boundary.centre, cost)
        data = history_bytes(history)

        def milliseconds(count: int, data: bytes = data) -> float:
            read: Callable[[], TriangleMesh] = lambda: history_from_bytes(data)[0].level(count)  # noqa: E731
            return 1e3 * process_times(read, runs)[0]

        rows.append(
            {
                "cost": cost,
                "triangles": history.triangles,
                "bytes": len(data),
                "bits_per_vertex": 8 * len(data) / history.vertices,
                "first_level_ms": milliseconds(4),
                "common_level_ms": milliseconds(LEVEL),
                "all_levels_ms": milliseconds(history.triangles),
            }
        )
    return rows


def srgb_boundary(samples: int) -> Boundary:
    """Return the full boundary of at most that many surface colours of sRGB."""
    return modified_convex_hull(surface_points(SRGB, samples))


def memory_growth(boundary: Boundary, cost: str) -> int:
    """Return by how many bytes a fresh process grows at most while it decimates a boundary."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "boundary.npz"
        mesh = boundary.mesh
        np.savez(file, vertices=mesh.vertices, faces=mesh.faces, centre=boundary.centre)
        return int(run_module("speed", str(file), cost))


def main() -> None:
    """Print by how many bytes this process grows while it decimates the boundary in a file."""
    file, cost = sys.argv[1:]
    small = srgb_boundary(200)
    build_mesh_history(small.mesh, small.centre, cost)  # loads the kernels
    with np.load(file) as arrays:
        mesh, centre = TriangleMesh(arrays["vertices"], arrays["faces"]), arrays["centre"]
    Path("/proc/self/clear_refs").write_text("5")  # resets the peak, see man 5 proc
    before = resident_bytes()
    build_mesh_history(mesh, centre, cost)
    print(resident_bytes("VmHWM") - before)


if __name__ == "__main__":
    main()
