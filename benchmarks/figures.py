"""Measure accuracy, time and memory of decimation beside other libraries: ``make figures``.

Also repeats the published experiment of Bakke and Farup ("Simplified Gamut Boundary Representation
using Mesh Decimation") with exact mismatches. The figures go to ``benchmarks/decimation.json``,
into the tables of ``docs/decimation.md`` and into its pictures. ``--only NAME ...`` repeats some
measurements, ``--peers NAME ...`` measures some of the libraries, and both keep all other figures.
"""

from __future__ import annotations

import argparse
import json
import sys
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
from benchmarks.decimation_tables import DOCUMENT, RESULTS, Results, document_blocks
from benchmarks.devices import Device, devices, exact_mismatch, sphere
from benchmarks.markdown import store
from benchmarks.peers import PEERS, installed, level_row, peer_rows
from gamutcore.boundary import Boundary, modified_convex_hull
from gamutcore.boundary.segment_maxima import segment_maxima
from gamutcore.boundary.usv import usv
from gamutcore.decimation import COSTS
from gamutcore.errors import BoundaryError, InvalidPointsError
from gamutcore.history import history_bytes
from gamutcore.metric import mismatch
from gamutcore.metric.error_curve import curve_counts, error_curve
from gamutcore.metric.level_search import Bounds, LevelSearch, error_bounds
from gamutcore.version import ALGORITHM_VERSION
from gamutcore.warm import compile_kernels

__all__ = ["main"]

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


def main() -> int:
    """Measure, draw and update the document."""
    parts: dict[str, Callable[[], Results]] = {
        "accuracy": accuracy,
        "peers": lambda: peers(results, arguments.peers),
        "methods": lambda: {"others": [row for each in devices() for row in methods(each)]},
        "sphere": lambda: {"sphere": spheres()},
        "times": lambda: {"times": [one for size in SIZES for one in times(size)]},
        "limits": lambda: {"limits": [*limits(devices()[0]), *limits(devices()[-1])]},
    }
    parser = argparse.ArgumentParser(prog="python -m benchmarks.figures", description=__doc__)
    parser.add_argument("--only", nargs="+", choices=[*parts, "pictures"], metavar="NAME")
    parser.add_argument("--peers", nargs="+", choices=[*PEERS], default=installed(), metavar="NAME")
    parser.add_argument("--time", nargs=2, metavar=("SAMPLES", "COST"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    use_one_core()
    if arguments.time:
        print(json.dumps(time_and_memory(int(arguments.time[0]), arguments.time[1])))
        return 0
    if absent := set(PEERS) - set(installed()):
        print(f"Not installed, so not measured: {', '.join(sorted(absent))}")
    results = json.loads(RESULTS.read_text())
    compile_kernels()
    for name, measure in parts.items():
        if arguments.only is None or name in arguments.only:
            print(f"{time.strftime('%H:%M:%S')} {name}", flush=True)
            results.update(measure())
            results["machine"] |= {**machine(), **versions(), "algorithm": ALGORITHM_VERSION}
    store(results, RESULTS, DOCUMENT, document_blocks(results))
    if arguments.only is None or "pictures" in arguments.only:
        pictures.draw(results)
    return 0


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
            level_row(device, cost, count, history.level(count))
            for cost, history in device.histories.items()
            for count in pictures.CURVE_COUNTS
        ]
    return {"devices": found, "levels": levels}


def peers(results: Results, names: list[str]) -> Results:
    """Measure libraries, and keep the rows of the others, device by device."""
    kept = [row for row in results["peers"] if row["method"] not in names]
    rows = [*kept, *(row for device in devices() for row in peer_rows(device, names))]
    order = {device.name: place for place, device in enumerate(devices())}
    rank = {name: place for place, name in enumerate(PEERS)}
    return {"peers": sorted(rows, key=lambda row: (order[row["device"]], rank[row["method"]]))}


def methods(device: Device) -> Rows:
    """Measure the other methods of the publication, and decimation at their triangle counts.

    ``size`` is the number of segments, and ``volume`` is relative to the reference, minus 1.
    """
    reference, centre = device.boundary.mesh, device.boundary.centre
    points = device.points
    makers: list[tuple[str, int, Callable[[], Boundary]]] = [
        ("convex hull", 0, lambda: modified_convex_hull(points, 1.0, centre)),
    ]
    makers += [
        ("USV", 20 * 4**splits, partial(usv, points, "icosahedron", splits, 0.05, centre))
        for splits in range(USV_SPLITS)
    ]
    makers += [
        (
            "segment maxima",
            2 * polar**2,
            partial(segment_maxima, points, (polar, 2 * polar), centre),
        )
        for polar in SEGMENTS
    ]
    rows = []
    for method, size, make in makers:
        try:
            mesh = make().mesh
        except (BoundaryError, InvalidPointsError):
            print(f"{method}, size {size}: no boundary, the colours do not surround the centre")
            continue
        decimated = {
            cost: exact_mismatch(reference, history.level(mesh.triangles), centre)
            for cost, history in device.histories.items()
        }
        rows.append(
            {
                "device": device.name,
                "method": method,
                "size": size,
                "triangles": mesh.triangles,
                "mismatch": exact_mismatch(reference, mesh, centre),
                "volume": mesh.volume / reference.volume - 1,
                "decimated": decimated,
            }
        )
    return rows


def spheres() -> Rows:
    """Measure mismatch × triangles on spheres of 10,000 vertices, where the optimum is known."""
    rows = []
    for spread in ("spiral", "random"):
        mesh = sphere(10_000, random=spread == "random")
        for cost in COSTS:
            history = build_mesh_history(mesh, np.array([50.0, 0.0, 0.0]), cost)
            for count in (1000, 500, 100):
                product = mismatch(mesh, history.level(count)) * count
                rows.append({"points": spread, "cost": cost, "asked": count, "product": product})
    return rows


def times(samples: int) -> Rows:
    """Time and memory of the history of an sRGB boundary with every cost, in fresh processes."""
    return [json.loads(run_module("figures", "--time", str(samples), cost)) for cost in COSTS]


def time_and_memory(samples: int, cost: str) -> dict[str, Any]:
    """Measure this process. Memory is the growth of its peak during the first decimation."""
    boundary = modified_convex_hull(surface_points(SRGB, samples))
    mesh, centre = boundary.mesh, boundary.centre
    small = sphere(200)
    build_mesh_history(small, np.array([50.0, 0.0, 0.0]), cost)  # loads the kernels
    Path("/proc/self/clear_refs").write_text("5")  # resets the peak, see man 5 proc
    before = resident_bytes()
    history = build_mesh_history(mesh, centre, cost)
    growth = resident_bytes("VmHWM") - before
    runs = SIZES.get(samples, 1)
    seconds = process_times(partial(build_mesh_history, mesh, centre, cost), runs)[0]
    curve = partial(error_curve, history, curve_counts(history.triangles))
    return {
        "cost": cost,
        "triangles": mesh.triangles,
        "seconds": seconds,
        "bytes_per_triangle": growth / mesh.triangles,
        "curve_s": process_times(curve, runs)[0],
        "bits_per_vertex": 8 * len(history_bytes(history)) / history.vertices,
    }


def limits(device: Device) -> Rows:
    """Search levels of a device by their error.

    ``excess`` and ``most_excess`` are the mean and the maximum of the triangle count found ÷ the
    smallest count that keeps the limit, over the limits that a level of `COARSE` triangles keeps.
    """
    rows = []
    for cost, history in device.histories.items():
        curve = error_curve(history, curve_counts(history.triangles))
        search = LevelSearch([error.to_mapping() for error in curve])
        coarse = error_bounds(history, range(4, COARSE + 1, 2))
        for name, asked in LIMITS.items():
            excess, seconds = [], []
            for limit in asked:
                start = time.process_time()
                count = search.find(history, limit).triangles
                seconds.append(time.process_time() - start)
                keeping = [each.triangles for each in coarse if each.bounds.within(limit)]
                if keeping:
                    excess.append(count / min(keeping))
            rows.append(
                {
                    "device": device.name,
                    "cost": cost,
                    "limit": name,
                    "coarse": len(excess),
                    "excess": mean(excess),
                    "most_excess": max(excess),
                    "median_s": median(seconds),
                    "longest_s": max(seconds),
                }
            )
    return rows


if __name__ == "__main__":
    sys.exit(main())
