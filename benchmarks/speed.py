"""Time and memory of complete histories, of boundaries of up to two million triangles.

Times are processor time (user and system) of one core with warm kernels, the shortest and the
median of several runs: what else the machine does at the same time counts little. Memory is the
growth of a fresh process around the decimation: ``python -m benchmarks.speed FILE COST`` measures
it and is run from here.
"""

from __future__ import annotations

import functools
import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks.devices import ROOT, FloatArray
from benchmarks.files import device_data
from benchmarks.peers import PEERS
from gamutcore.boundary import Boundary, modified_convex_hull
from gamutcore.colours import surface_colours
from gamutcore.decimation import COSTS, decimate
from gamutcore.gamut import Options, build_gamut
from gamutcore.history import History, build_history, history_bytes, history_from_bytes
from gamutcore.mesh import TriangleMesh
from gamutcore.metric.error_curve import curve_counts, error_curve

__all__ = [
    "LEVEL",
    "few_triangles",
    "history_times",
    "hubs",
    "measured_histories",
    "million_points",
    "scaling",
    "storage",
]

SIZES = (105_000, 380_000, 1_750_000)
"""Surface colours that give boundaries of about 150,000, 500,000 and 2,000,000 triangles."""

FEW = (30, 100, 400, 1200, 3400, 10_000, 32_000)
"""Surface colours that give boundaries of about 50 to 60,000 triangles, where the coarse end, which
takes as long whatever there was before it, is most of the time."""

RINGS = (64, 100, 300, 400, 1000, 6000)
"""Vertices between two poles: nothing that comes from a device, but what takes `finest` longest."""

LEVEL = 1000
"""Triangles that the other libraries are asked for, and most clients of a history."""

SRGB = ROOT / "tests" / "data" / "sRGB-v4.icc"


def shortest_and_median(function: Callable[[], object], runs: int) -> tuple[float, float]:
    """Return the shortest and the median time of a call in seconds, after one that warms up."""
    function()
    times = []
    for _ in range(runs):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return min(times), median(times)


def measured_histories(
    boundary: Boundary, runs: int
) -> tuple[dict[str, History], list[dict[str, Any]]]:
    """Make the complete history of a boundary with every cost; time it and its error curve.

    Parameters
    ----------
    boundary : Boundary
    runs : int

    Returns
    -------
    histories : dict of History
        By the name of the cost.
    rows : list of dict
        ``cost``, ``triangles``, ``seconds`` (shortest), ``median_s``, ``us_per_triangle``,
        ``curve_s`` (shortest), ``curve_part`` and ``bits_per_vertex`` of the file.
    """
    histories, rows = {}, []
    for cost in COSTS:

        def build(cost: str = cost) -> None:
            histories[cost] = build_history(decimate(boundary.mesh, boundary.centre, cost))

        shortest, middle = shortest_and_median(build, runs)
        history = histories[cost]
        curve = functools.partial(error_curve, history, curve_counts(history.triangles))
        curve_s = shortest_and_median(curve, runs)[0]
        rows.append(
            {
                "cost": cost,
                "triangles": boundary.mesh.triangles,
                "seconds": shortest,
                "median_s": middle,
                "us_per_triangle": 1e6 * shortest / boundary.mesh.triangles,
                "curve_s": curve_s,
                "curve_part": curve_s / shortest,
                "bits_per_vertex": 8 * len(history_bytes(history)) / history.vertices,
            }
        )
    return histories, rows


def with_memory(boundary: Boundary, rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return these rows of a boundary with ``bytes_per_triangle``, its decimation's memory."""
    return [
        {**row, "bytes_per_triangle": growth(boundary, row["cost"]) / row["triangles"]}
        for row in rows
    ]


def history_times(runs: int) -> list[dict[str, Any]]:
    """Complete histories of the sRGB boundary, the error curve, and one level from each peer."""
    boundary = srgb_boundary(100_000)
    _, rows = measured_histories(boundary, runs)
    vertices = boundary.mesh.vertices.astype(np.float64)
    faces = boundary.mesh.faces.astype(np.int64)
    for name, (_, peer) in PEERS.items():
        try:
            runs_made = [peer(vertices, faces, LEVEL) for _ in range(3)]
        except ImportError:
            continue
        seconds = [run[2] for run in runs_made]
        level = len(runs_made[0][1])
        rows.append(
            {"peer": name, "level": level, "seconds": min(seconds), "median_s": median(seconds)}
        )
    return rows


def scaling(runs: int) -> list[dict[str, Any]]:
    """Time and memory of decimations by size of the boundary, the boundary's own aside."""
    rows = []
    for points in SIZES:
        boundary = srgb_boundary(points)
        _, timed = measured_histories(boundary, runs if points < 1_000_000 else 1)
        rows += with_memory(boundary, timed)
    return rows


def few_triangles(runs: int) -> list[dict[str, Any]]:
    """Time and memory of decimations of smaller boundaries, their error curves and their files.

    Of these also what the service delivers, with the gamut's description: some kilobytes, which
    are not much more than a bit per vertex of those that are larger.
    """
    found = []
    for points in FEW:
        boundary = srgb_boundary(points)
        for row in with_memory(boundary, measured_histories(boundary, runs)[1]):
            options = Options(surface_samples=points, cost=row["cost"])
            description = build_gamut(SRGB.read_bytes(), options).description
            size = len(json.dumps(description, separators=(",", ":")))
            bits = row["bits_per_vertex"] + 8 * size / boundary.mesh.vertices.shape[0]
            found.append({**row, "delivered_bits_per_vertex": bits})
    return found


def hubs(runs: int) -> list[dict[str, Any]]:
    """Time of decimations of double pyramids, whose vertices all hang on two hubs."""
    found = []
    for ring in RINGS:
        turn = np.linspace(0, 2 * np.pi, ring, endpoint=False)
        around = np.stack([40 * np.cos(turn), 40 * np.sin(turn), np.zeros(ring)], axis=1)
        boundary = modified_convex_hull(np.vstack([around, [[0, 0, 50], [0, 0, -50]]]), 1.0)
        _, rows = measured_histories(boundary, runs)
        found += [{"ring": ring, **row} for row in rows]
    return found


def million_points() -> dict[str, Any]:
    """Return the times from 1,000,000 surface colours to boundary and history."""
    points = srgb_points(1_000_000)
    start = time.process_time()
    boundary = modified_convex_hull(points)
    hull = time.process_time() - start
    build_history(decimate(boundary.mesh, boundary.centre))
    total = time.process_time() - start
    return {
        "points": len(points),
        "triangles": boundary.mesh.triangles,
        "boundary_s": hull,
        "history_s": total - hull,
        "total_s": total,
    }


def storage(runs: int) -> list[dict[str, Any]]:
    """Size of history files of about 200,000 triangles, and the times to their levels."""
    boundary = srgb_boundary(115_000)
    rows = []
    for cost in COSTS:
        history = build_history(decimate(boundary.mesh, boundary.centre, cost))
        data = history_bytes(history)
        opening, common, whole = (
            shortest_and_median(functools.partial(_level_of_file, data, count), runs)
            for count in (4, LEVEL, history.triangles)
        )
        rows.append(
            {
                "cost": cost,
                "triangles": history.triangles,
                "bytes": len(data),
                "bits_per_vertex": 8 * len(data) / history.vertices,
                "first_level_ms": 1e3 * opening[0],
                "common_level_ms": 1e3 * common[0],
                "all_levels_ms": 1e3 * whole[0],
            }
        )
    return rows


def _level_of_file(data: bytes, count: int) -> TriangleMesh:
    return history_from_bytes(data)[0].level(count)


def srgb_points(samples: int) -> FloatArray:
    """CIELAB colours of the sRGB cube's surface, at most so many."""
    return surface_colours(device_data(SRGB.read_bytes()), surface_samples=samples).points


def srgb_boundary(samples: int) -> Boundary:
    """Full boundary around those."""
    return modified_convex_hull(srgb_points(samples))


def growth(boundary: Boundary, cost: str) -> int:
    """Largest growth of a process while it decimates a boundary, in bytes."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "boundary.npz"
        np.savez(
            file,
            vertices=boundary.mesh.vertices,
            faces=boundary.mesh.faces,
            centre=boundary.centre,
        )
        done = subprocess.run(
            [sys.executable, "-m", "benchmarks.speed", str(file), cost],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        )
    return int(json.loads(done.stdout))


def main() -> None:
    """Print by how many bytes this process grows while it decimates the boundary in a file."""
    file, cost = sys.argv[1:]
    small = srgb_boundary(200)
    build_history(decimate(small.mesh, small.centre, cost))  # loads the kernels
    with np.load(file) as arrays:
        mesh = TriangleMesh(arrays["vertices"], arrays["faces"])
        centre = arrays["centre"]
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew (man 5 proc)
    before = resident("VmRSS")
    build_history(decimate(mesh, centre, cost))
    print(resident("VmHWM") - before)


def resident(name: str) -> int:
    """Resident size of this process in bytes: now (VmRSS) or at most (VmHWM)."""
    found = re.search(rf"^{name}:\s+(\d+) kB", Path("/proc/self/status").read_text(), re.MULTILINE)
    if found is None:
        raise RuntimeError(f"/proc/self/status has no {name}")
    return 1024 * int(found[1])


if __name__ == "__main__":
    main()
