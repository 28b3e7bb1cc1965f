"""Measure accuracy, time and memory of decimation beside other libraries: ``make figures``.

Also repeats the published experiment of Bakke and Farup ("Simplified Gamut Boundary Representation
using Mesh Decimation") with exact mismatches. The figures go to ``benchmarks/decimation.json``,
into the tables of ``docs/decimation.md`` and into its pictures. ``--only NAME ...`` repeats some
measurements and keeps all other figures, as those of libraries that are not installed are kept.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from functools import partial
from importlib.metadata import distributions
from math import inf
from pathlib import Path
from statistics import mean, median
from typing import Any

import numpy as np

from benchmarks import pictures
from benchmarks.common import (
    SRGB,
    Rows,
    build_mesh_history,
    machine,
    resident_bytes,
    run_module,
    surface_points,
    times_of,
    use_one_core,
)
from benchmarks.decimation_tables import COSTS, DOCUMENT, RESULTS, Results, document_blocks
from benchmarks.devices import Device, devices
from benchmarks.markdown import store
from benchmarks.peers import PEERS, installed, peer_rows
from gamutcore.boundary import Boundary, modified_convex_hull
from gamutcore.boundary.segment_maxima import segment_maxima
from gamutcore.boundary.usv import usv
from gamutcore.errors import BoundaryError, InvalidPointsError
from gamutcore.history import history_bytes
from gamutcore.mesh import TriangleMesh
from gamutcore.metric import mismatch
from gamutcore.metric.error_curve import curve_counts, error_curve
from gamutcore.metric.level_search import Bounds, LevelSearch, error_bounds
from gamutcore.version import ALGORITHM_VERSION
from gamutcore.warm import compile_kernels

MIDDLE = np.array([50.0, 0.0, 0.0])
SIZES = {105_000: 3, 380_000: 3, 1_750_000: 1}
"""Surface samples for boundaries of about 180,000, 650,000 and 2,500,000 triangles, and runs."""

USV_SPLITS = 5
SEGMENTS = (3, 4, 5, 7, 9, 11, 16, 22, 35, 50)
"""Polar segments of segment maxima, with twice as many azimuth segments."""

LIMITS = {
    "max_error": [Bounds(distance, inf) for distance in np.geomspace(5e-3, 5.0, 31).tolist()],
    "max_mismatch": [Bounds(inf, part) for part in np.geomspace(1e-5, 1e-2, 31).tolist()],
}
"""Limits by query parameter: ΔE, and fractions of the volume."""

COARSE = 1000
"""All levels up to this triangle count are compared with a limit to find the smallest."""

process_times = partial(times_of, clock=time.process_time)


def main() -> None:
    """Measure, draw and update the document."""
    parts: dict[str, Callable[[], Results]] = {
        "accuracy": accuracy,
        "peers": lambda: {"peers": peers(results["peers"])},
        "methods": lambda: {"others": [row for each in devices() for row in methods(each)]},
        "sphere": lambda: {"sphere": spheres()},
        "times": lambda: {"times": [times(size, cost) for size in SIZES for cost in COSTS]},
        "limits": lambda: {"limits": [row for cost in COSTS for row in limits(cost)]},
    }
    parser = argparse.ArgumentParser(prog="python -m benchmarks.figures", description=__doc__)
    known = [*parts, "pictures"]
    parser.add_argument("--only", nargs="+", choices=known, default=known, metavar="NAME")
    parser.add_argument("--time", nargs=2, metavar=("SAMPLES", "COST"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    use_one_core()
    compile_kernels()
    if arguments.time:
        print(json.dumps(time_and_memory(int(arguments.time[0]), arguments.time[1])))
        return
    results = json.loads(RESULTS.read_text())
    for name in [each for each in parts if each in arguments.only]:
        print(f"{time.strftime('%H:%M:%S')} {name}", flush=True)
        results.update(parts[name]())
        results["machine"] |= {**machine(), **versions(), "algorithm": ALGORITHM_VERSION}
    store(results, RESULTS, DOCUMENT, document_blocks(results))
    if "pictures" in arguments.only:
        pictures.draw(results)


def versions() -> dict[str, str]:
    """Return the versions of the installed libraries that are compared."""
    names = {package.replace("_", "-") for package, _ in PEERS.values()} | {"vtk"}
    return {each.name: each.version for each in distributions() if each.name in names}


def accuracy() -> Results:
    """Mismatch and faults of levels of every device and cost, and the time of all levels."""
    found, levels = [], []
    for device in devices():
        mesh, centre = device.boundary.mesh, device.boundary.centre
        seconds = {
            cost: process_times(partial(build_mesh_history, mesh, centre, cost), 3)[0]
            for cost in COSTS
        }
        found.append(
            {
                "name": device.name,
                "kind": device.kind,
                "triangles": mesh.triangles,
                "seconds": seconds,
            }
        )
        levels += [
            device.level_row(cost, count, history.level(count))
            for cost, history in device.histories.items()
            for count in pictures.CURVE_COUNTS
        ]
    return {"devices": found, "levels": levels}


def peers(rows: Rows) -> Rows:
    """Measure the installed libraries, and keep the rows of the others, device by device."""
    names = installed()
    print(f"Not installed, so not measured: {', '.join(set(PEERS) - set(names)) or 'none'}")
    kept = [row for row in rows if row["method"] not in names]
    rows = [*kept, *(row for device in devices() for row in peer_rows(device, names))]
    order = [device.name for device in devices()]
    rank = [*PEERS]
    return sorted(rows, key=lambda row: (order.index(row["device"]), rank.index(row["method"])))


def methods(device: Device) -> Rows:
    """Measure the other methods of the publication. ``size`` is the number of segments."""
    points, centre = device.points, device.boundary.centre
    makers: dict[tuple[str, int], Callable[[], Boundary]] = {
        ("convex hull", 0): partial(modified_convex_hull, points, 1.0, centre)
    }
    for splits in range(USV_SPLITS):
        makers["USV", 20 * 4**splits] = partial(usv, points, "icosahedron", splits, 0.05, centre)
    for polar in SEGMENTS:
        shape = (polar, 2 * polar)
        makers["segment maxima", 2 * polar**2] = partial(segment_maxima, points, shape, centre)
    rows = []
    for (method, size), make in makers.items():
        try:
            mesh = make().mesh
        except (BoundaryError, InvalidPointsError):
            print(f"{method}, size {size}: no boundary, the colours do not surround the centre")
            continue
        figures = {"triangles": mesh.triangles, "mismatch": device.mismatch(mesh)}
        rows.append({"device": device.name, "method": method, "size": size, **figures})
    return rows


def sphere(vertices: int, *, random: bool = False) -> TriangleMesh:
    """Return a triangulated sphere of radius 50, with even spacing on a spiral or at random."""
    if random:
        points = np.random.default_rng(1).standard_normal((vertices, 3))
    else:
        number = np.arange(vertices) + 0.5
        height = 1 - 2 * number / vertices
        turn = np.pi * (1 + 5**0.5) * number
        flat = np.sqrt(1 - height**2)
        points = np.stack([height, flat * np.cos(turn), flat * np.sin(turn)], axis=1)
    points *= 50 / np.linalg.norm(points, axis=1)[:, np.newaxis]
    return modified_convex_hull(points + MIDDLE, 1.0, MIDDLE).mesh


def spheres() -> Rows:
    """Measure mismatch × triangles on spheres, where the optimum is known, as the larger of two."""
    meshes = [sphere(10_000), sphere(10_000, random=True)]
    rows: Rows = [{"cost": f"`{cost}`"} for cost in COSTS] + [{"cost": "least possible"}]
    for cost, row in zip(COSTS, rows, strict=False):
        histories = [build_mesh_history(mesh, MIDDLE, cost) for mesh in meshes]
        for count in (1000, 500, 100):
            errors = map(mismatch, meshes, [history.level(count) for history in histories])
            row[f"{count:,} triangles"] = count * max(errors)
            rows[-1][f"{count:,} triangles"] = pictures.SPHERE_LIMIT
    return rows


def times(samples: int, cost: str) -> dict[str, Any]:
    """Time and memory of the history of an sRGB boundary, in a fresh process."""
    row: dict[str, Any] = json.loads(run_module("figures", "--time", str(samples), cost))
    return row


def time_and_memory(samples: int, cost: str) -> dict[str, Any]:
    """Measure this process. Memory is the growth of its peak during the first decimation."""
    boundary = modified_convex_hull(surface_points(SRGB, samples))
    build_mesh_history(sphere(200), MIDDLE, cost)  # loads the kernels
    build = partial(build_mesh_history, boundary.mesh, boundary.centre, cost)
    Path("/proc/self/clear_refs").write_text("5")  # resets the peak, see man 5 proc
    before = resident_bytes()
    history = build()
    growth = resident_bytes("VmHWM") - before
    seconds = process_times(build, SIZES[samples])[0]
    curve = partial(error_curve, history, curve_counts(history.triangles))
    return {
        "cost": f"`{cost}`",
        "triangles": history.triangles,
        "decimation, s": seconds,
        "µs per triangle": 1e6 * seconds / history.triangles,
        "memory, bytes per triangle": growth / history.triangles,
        "error curve, s": process_times(curve, SIZES[samples])[0],
        "file, bits per vertex": 8 * len(history_bytes(history)) / history.vertices,
    }


def limits(cost: str) -> Rows:
    """Search levels of two devices by their error.

    The excess is the triangle count found ÷ the smallest count that keeps the limit, over the
    limits that a level of `COARSE` triangles keeps.
    """
    excess: dict[str, list[float]] = {name: [] for name in LIMITS}
    seconds: dict[str, list[float]] = {name: [] for name in LIMITS}
    for device in (devices()[0], devices()[-1]):
        history = device.histories[cost]
        curve = error_curve(history, curve_counts(history.triangles))
        search = LevelSearch([error.to_mapping() for error in curve])
        coarse = error_bounds(history, range(4, COARSE + 1, 2))
        for name, limit in [(name, limit) for name, asked in LIMITS.items() for limit in asked]:
            start = time.process_time()
            count = search.find(history, limit).triangles
            seconds[name].append(1e3 * (time.process_time() - start))
            keeping = [each.triangles for each in coarse if each.bounds.within(limit)]
            if keeping:
                excess[name].append(count / min(keeping))
    return [
        {
            "cost": f"`{cost}`",
            "limit": f"`{name}`",
            "mean excess": mean(excess[name]),
            "largest excess": max(excess[name]),
            "median time, ms": median(seconds[name]),
            "longest time, ms": max(seconds[name]),
        }
        for name in LIMITS
    ]


if __name__ == "__main__":
    main()
