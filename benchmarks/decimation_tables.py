"""The tables of ``docs/decimation.md``, from the content of ``benchmarks/decimation.json``.

A *method* is a cost of this project, another library (a peer), or another way to make a simple
boundary. Errors are relative volume mismatches.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from statistics import mean
from typing import Any

import numpy as np

from benchmarks.common import ROOT
from benchmarks.markdown import percent, table
from benchmarks.peers import COUNTS

__all__ = [
    "COSTS",
    "DOCUMENT",
    "RESULTS",
    "SPHERE_LIMIT",
    "Results",
    "document_blocks",
    "mean_errors",
    "method_means",
]

RESULTS = Path(__file__).with_name("decimation.json")
DOCUMENT = ROOT / "docs" / "decimation.md"

Results = dict[str, Any]
"""The content of ``benchmarks/decimation.json``."""

COSTS = ("finest", "volume", "quadric")
"""The costs, the most accurate first. `quadric` is the published one."""

DEVICE_COUNTS = (1000, 100)
LIBRARY_COUNTS = (1000, 100, 20)
SPHERE_COUNTS = (1000, 500, 100)
METHOD_SIZES = (100, 1000, 10_000)
"""Triangle counts near which the other boundary methods are tabulated; the plot has all sizes."""

SPHERE_LIMIT = 12 * np.pi * (1 / (6 * 3**0.5) - 1 / (8 * np.pi))
"""Least mismatch × triangles on a sphere for many triangles: constants of Ludwig and Böröczky."""


def document_blocks(results: Results) -> dict[str, str]:
    """Return the generated blocks of docs/decimation.md."""
    makers = (mean_mismatch, device_mismatch, times, limits, libraries, sphere, methods, machine)
    return {make.__name__.replace("_", "-"): make(results) for make in makers}


def level_errors(results: Results, method: str, count: int) -> dict[str, float]:
    """Return a method's errors at a triangle count by device, where it reaches the count."""
    return {
        row["device"]: row["mismatch"]
        for row in (*results["levels"], *results["peers"])
        if (row["method"], row["asked"]) == (method, count)
        and row["reached"]
        and row["mismatch"] is not None
    }


def mean_errors(results: Results, method: str, counts: Iterable[int]) -> list[float | None]:
    """Return a method's mean errors over all devices; None where it fails on a device."""
    found = [level_errors(results, method, count) for count in counts]
    everywhere = len(results["devices"])
    return [mean(each.values()) if len(each) == everywhere else None for each in found]


def best_peer(results: Results, device: str, count: int) -> tuple[float, str]:
    """Return error and name of the most accurate other library for a device and count."""
    return min(
        (row["mismatch"], row["method"])
        for row in results["peers"]
        if (row["device"], row["asked"]) == (device, count)
        and row["reached"]
        and row["mismatch"] is not None
    )


def method_means(results: Results) -> dict[str, Results]:
    """Return means over the devices of the other boundary methods, by method and size.

    Sizes that fail on a device are left out.
    """
    groups: dict[str, list[Results]] = {}
    for row in results["others"]:
        groups.setdefault(f"{row['method']}, {row['size']}", []).append(row)
    return {
        name: {
            "method": rows[0]["method"],
            **{key: mean(row[key] for row in rows) for key in ("triangles", "mismatch", "volume")},
            "decimated": [mean(row["decimated"][cost] for row in rows) for cost in COSTS],
        }
        for name, rows in groups.items()
        if len(rows) == len(results["devices"])
    }


def machine(results: Results) -> str:
    """Date, processor and versions."""
    about = dict(results["machine"])
    head = ["date", "algorithm", "cpu", "system", "python", "numpy", "numba"]
    cells = [str(about.pop(name)) for name in head]
    about.pop("cores")
    libraries = ", ".join(f"{name} {version}" for name, version in sorted(about.items()))
    return table([*head, "libraries"], [[*cells, libraries]])


def mean_mismatch(results: Results) -> str:
    """Mean error of every cost and count."""
    rows = [[f"`{cost}`", *map(percent, mean_errors(results, cost, COUNTS))] for cost in COSTS]
    names = [device["name"] for device in results["devices"]]
    best = [mean(best_peer(results, name, count)[0] for name in names) for count in COUNTS]
    rows.append(["best other library per device", *map(percent, best)])
    return table(["triangles", *(f"{count:,}" for count in COUNTS)], rows)


def device_mismatch(results: Results) -> str:
    """Errors by device, and the best other library."""
    costs = [cost for cost in COSTS if cost != "quadric"]
    rows = []
    for device in results["devices"]:
        name = device["name"]
        row = [f"{name}: {device['kind']}", f"{device['triangles']:,}"]
        for count in DEVICE_COUNTS:
            row += [percent(level_errors(results, cost, count).get(name)) for cost in costs]
            error, best = best_peer(results, name, count)
            row.append(f"{percent(error)} ({best})")
        rows.append(row)
    head = [
        f"{name}, {count:,}"
        for count in DEVICE_COUNTS
        for name in (*(f"`{cost}`" for cost in costs), "best other")
    ]
    return table(["device", "full boundary", *head], rows)


def times(results: Results) -> str:
    """Time, memory and size of the file by cost and size."""
    rows = [
        [
            f"`{row['cost']}`",
            f"{row['triangles']:,}",
            f"{row['seconds']:.2f}",
            f"{1e6 * row['seconds'] / row['triangles']:.2f}",
            f"{row['bytes_per_triangle']:.0f}",
            f"{row['curve_s']:.2f}",
            f"{row['bits_per_vertex']:.1f}",
        ]
        for row in results["times"]
    ]
    head = ["cost", "triangles", "decimation, s", "µs per triangle"]
    head += ["memory, bytes per triangle", "error curve, s", "file, bits per vertex"]
    return table(head, rows)


def limits(results: Results) -> str:
    """Excess and time of levels that are found by their error."""
    groups: dict[tuple[str, str], list[Results]] = {}
    for row in results["limits"]:
        groups.setdefault((row["cost"], row["limit"]), []).append(row)
    rows = []
    for (cost, limit), group in groups.items():
        coarse = sum(row["coarse"] for row in group)
        excess = sum(row["coarse"] * row["excess"] for row in group) / coarse
        usual = 1e3 * mean(row["median_s"] for row in group)
        longest = 1e3 * max(row["longest_s"] for row in group)
        rows.append(
            [
                f"`{cost}`",
                f"`{limit}`",
                f"{excess:.3f} / {max(row['most_excess'] for row in group):.2f}",
                f"{usual:.0f} / {longest:.0f}",
            ]
        )
    return table(["cost", "limit", "excess, mean / largest", "time, median / longest, ms"], rows)


def libraries(results: Results) -> str:
    """Errors, counts reached, valid meshes and time by method."""
    total = len(results["devices"]) * len(COUNTS)
    rows = []
    for method in dict.fromkeys([*COSTS, *(row["method"] for row in results["peers"])]):
        reached = [
            row
            for row in (*results["levels"], *results["peers"])
            if row["method"] == method and row["asked"] in COUNTS and row["reached"]
        ]
        valid = sum(not row["faults"] for row in reached)
        crossing = sum("crossings" in " ".join(row["faults"]) for row in reached)
        if method in COSTS:
            seconds = mean(device["seconds"][method] for device in results["devices"])
        else:
            seconds = mean(
                row["seconds"]
                for row in results["peers"]
                if row["method"] == method and row["asked"] == 1000
            )
        rows.append(
            [
                f"`{method}`" if method in COSTS else method,
                *map(percent, mean_errors(results, method, LIBRARY_COUNTS)),
                f"{len(reached)} of {total}",
                str(valid),
                str(crossing),
                f"{seconds:.2f}",
            ]
        )
    errors = [f"{count:,}, %" for count in LIBRARY_COUNTS]
    return table(["method", *errors, "reached", "valid", "self-intersecting", "time, s"], rows)


def sphere(results: Results) -> str:
    """Mismatch × triangles on spheres, the larger of two distributions."""
    rows = []
    for cost in COSTS:
        products = [
            max(
                row["product"]
                for row in results["sphere"]
                if (row["cost"], row["asked"]) == (cost, count)
            )
            for count in SPHERE_COUNTS
        ]
        rows.append([f"`{cost}`", *(f"{product:.2f}" for product in products)])
    rows.append(["least possible", *[f"{SPHERE_LIMIT:.2f}"] * len(SPHERE_COUNTS)])
    return table(["triangles", *(f"{count:,}" for count in SPHERE_COUNTS)], rows)


def methods(results: Results) -> str:
    """Other boundary methods, and decimation at their triangle counts."""
    means = list(method_means(results).values())
    rows = []
    for row in means:
        same = [each for each in means if each["method"] == row["method"]]
        nearest = [min(same, key=lambda each: abs(each["triangles"] / n - 1)) for n in METHOD_SIZES]
        if row in nearest:
            rows.append(
                [
                    row["method"],
                    f"{row['triangles']:,.0f}",
                    percent(row["mismatch"]),
                    f"{100 * row['volume']:+.2f}",
                    *map(percent, row["decimated"]),
                ]
            )
    head = [f"`{cost}`, %" for cost in COSTS]
    return table(["method", "triangles", "mismatch, %", "volume, %", *head], rows)
