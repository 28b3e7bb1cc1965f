"""The tables of ``docs/decimation.md``, from the content of ``benchmarks/decimation.json``.

A *method* is a cost of this project, another library (a peer), or another way to make a simple
boundary. Errors are relative volume mismatches.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from statistics import mean
from typing import Any

from benchmarks.common import ROOT
from benchmarks.markdown import percent, rows_table, table
from benchmarks.peers import COUNTS

RESULTS = Path(__file__).with_name("decimation.json")
DOCUMENT = ROOT / "docs" / "decimation.md"

Results = dict[str, Any]
"""The content of ``benchmarks/decimation.json``."""

COSTS = ("finest", "volume", "quadric")
"""The costs, the most accurate first. `quadric` is the published one."""

DEVICE_COUNTS = (1000, 100)
LIBRARY_COUNTS = (1000, 100, 20)


def document_blocks(results: Results) -> dict[str, str]:
    """Return the generated blocks of docs/decimation.md."""
    return {
        "mean-mismatch": mean_mismatch(results),
        "device-mismatch": device_mismatch(results),
        "libraries": libraries(results),
        "machine": machine(results),
        **{name: rows_table(results[name]) for name in ("times", "limits", "sphere")},
    }


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
    peers = dict.fromkeys(row["method"] for row in results["peers"])
    errors = {name: level_errors(results, name, count) for name in peers}
    return min((found[device], name) for name, found in errors.items() if device in found)


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


def libraries(results: Results) -> str:
    """Errors, counts reached, valid meshes and time by method."""
    total = len(results["devices"]) * len(COUNTS)
    rows = []
    for method in dict.fromkeys([*COSTS, *(row["method"] for row in results["peers"])]):
        found = [
            row
            for row in (*results["levels"], *results["peers"])
            if row["method"] == method and row["asked"] in COUNTS
        ]
        reached = [row for row in found if row["reached"]]
        if method in COSTS:
            seconds = [device["seconds"][method] for device in results["devices"]]
        else:
            seconds = [row["seconds"] for row in found if row["asked"] == 1000]
        rows.append(
            [
                f"`{method}`" if method in COSTS else method,
                *map(percent, mean_errors(results, method, LIBRARY_COUNTS)),
                f"{len(reached)} of {total}",
                str(sum(not row["faults"] for row in reached)),
                str(sum("crossings" in " ".join(row["faults"]) for row in reached)),
                f"{mean(seconds):.2f}",
            ]
        )
    errors = [f"{count:,}, %" for count in LIBRARY_COUNTS]
    return table(["method", *errors, "reached", "valid", "self-intersecting", "time, s"], rows)
