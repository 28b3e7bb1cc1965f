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
from contextlib import suppress
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks import pictures
from benchmarks.booleans import mismatch
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
from benchmarks.devices import devices
from benchmarks.markdown import store
from benchmarks.peers import PEERS, installed, peer_rows
from gamutcore.boundary import Boundary, modified_convex_hull, segment_maxima, usv
from gamutcore.errors import BoundaryError, InvalidPointsError
from gamutcore.geometry import TriangleMesh
from gamutcore.levels import LevelRequest, LevelSearch, curve_counts, error_curve
from gamutcore.version import ALGORITHM_VERSION
from gamutcore.warm import compile_kernels

MIDDLE = np.array([50.0, 0.0, 0.0])
SIZES = {105_000: 3, 380_000: 3, 1_750_000: 1}
"""Surface samples for boundaries of about 180,000, 650,000 and 2,500,000 triangles, and runs."""

USV_SPLITS = 5
SEGMENTS = (3, 4, 5, 7, 9, 11, 16, 22, 35, 50)
"""Polar segments of segment maxima, with twice as many azimuth segments."""

LIMITS = {
    "max_error": np.geomspace(5e-3, 5.0, 31).tolist(),
    "max_mismatch": np.geomspace(1e-5, 1e-2, 31).tolist(),
}
"""Limits by query parameter: ΔE, and fractions of the volume."""

process_times = partial(times_of, clock=time.process_time)


def main() -> None:
    """Measure, draw and update the document."""
    parts: dict[str, Callable[[], Results]] = {
        "accuracy": accuracy,
        "peers": lambda: {"peers": peers(results["peers"])},
        "methods": lambda: {"others": methods()},
        "sphere": lambda: {"sphere": spheres()},
        "times": lambda: {"times": times()},
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
        packages = [PEERS[peer][0] for peer in installed()]
        results["machine"] |= {**machine(*packages), "algorithm": ALGORITHM_VERSION}
    store(results, RESULTS, DOCUMENT, document_blocks(results))
    if "pictures" in arguments.only:
        pictures.draw(results)


def accuracy() -> Results:
    """Mismatch and validity of levels of every device and cost, and the time of all levels."""
    found, levels = [], []
    for device in devices():
        mesh, centre = device.boundary.mesh, device.boundary.centre
        seconds = {
            cost: process_times(partial(build_mesh_history, mesh, centre, cost), 3)[0]
            for cost in COSTS
        }
        about = {"name": device.name, "kind": device.kind, "triangles": mesh.triangles}
        found.append({**about, "seconds": seconds})
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


def methods() -> Rows:
    """Measure the other methods of the publication, as means over the devices.

    Sizes that fail on a device are left out.
    """
    found: dict[tuple[str, int], list[tuple[int, float]]] = {}
    for device in devices():
        points, centre = device.points, device.boundary.centre
        makers: dict[tuple[str, int], Callable[[], Boundary]] = {
            ("convex hull", 0): partial(modified_convex_hull, points, 1.0, centre)
        }
        for splits in range(USV_SPLITS):
            makers["USV", splits] = partial(usv, points, "icosahedron", splits, 0.05, centre)
        for polar in SEGMENTS:
            shape = (polar, 2 * polar)
            makers["segment maxima", polar] = partial(segment_maxima, points, shape, centre)
        for key, make in makers.items():
            with suppress(BoundaryError, InvalidPointsError):
                mesh = make().mesh
                found.setdefault(key, []).append((mesh.triangles, device.mismatch(mesh) or 1.0))
    return [
        {"method": method, "triangles": counts, "mismatch": error}
        for (method, _), each in found.items()
        if len(each) == len(devices())
        for counts, error in [np.mean(each, axis=0).tolist()]
    ]


def sphere(vertices: int) -> TriangleMesh:
    """Return a triangulated sphere of radius 50, with vertices evenly spaced on a spiral."""
    number = np.arange(vertices) + 0.5
    height = 1 - 2 * number / vertices
    turn = np.pi * (1 + 5**0.5) * number
    flat = np.sqrt(1 - height**2)
    points = 50 * np.stack([height, flat * np.cos(turn), flat * np.sin(turn)], axis=1)
    return modified_convex_hull(points + MIDDLE, 1.0, MIDDLE).mesh


def spheres() -> Rows:
    """Measure mismatch × triangles on a sphere, where the optimum is known."""
    mesh, counts = sphere(10_000), (1000, 500, 100)
    histories = {f"`{cost}`": build_mesh_history(mesh, MIDDLE, cost) for cost in COSTS}
    products = {
        name: [count * mismatch(mesh, history.level(count)) for count in counts]
        for name, history in histories.items()
    }
    products["least possible"] = [pictures.SPHERE_LIMIT] * len(counts)
    head = ["cost", *(f"{count:,} triangles" for count in counts)]
    return [dict(zip(head, [name, *row], strict=True)) for name, row in products.items()]


def times() -> Rows:
    """Time and memory of histories of an sRGB boundary, each in a fresh process."""
    return [
        json.loads(run_module("figures", "--time", str(samples), cost))
        for samples in SIZES
        for cost in COSTS
    ]


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
    }


def limits(cost: str) -> Rows:
    """Time of searches for levels of two devices by their error."""
    seconds: dict[str, list[float]] = {name: [] for name in LIMITS}
    for device in (devices()[0], devices()[-1]):
        history = device.histories[cost]
        curve = error_curve(history, curve_counts(history.triangles))
        search = LevelSearch([error.to_mapping() for error in curve])
        for name, limit in [(name, limit) for name, asked in LIMITS.items() for limit in asked]:
            start = time.process_time()
            search.find(history, LevelRequest(**{name: limit}))
            seconds[name].append(1e3 * (time.process_time() - start))
    return [
        {
            "cost": f"`{cost}`",
            "limit": f"`{name}`",
            "median time, ms": median(found),
            "longest time, ms": max(found),
        }
        for name, found in seconds.items()
    ]


if __name__ == "__main__":
    main()
