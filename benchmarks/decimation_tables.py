"""The tables of ``docs/decimation.md``, from the content of ``benchmarks/decimation.json``.

A *method* is a cost of this project, another library (a peer), or another way to make a simple
boundary. Errors are relative volume mismatches, in per cent in the tables.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from statistics import mean
from typing import Any

from benchmarks.common import ROOT, Rows
from benchmarks.markdown import rows_table
from benchmarks.peers import COUNTS

RESULTS = Path(__file__).with_name("decimation.json")
DOCUMENT = ROOT / "docs" / "decimation.md"

Results = dict[str, Any]
"""The content of ``benchmarks/decimation.json``."""

COSTS = ("finest", "volume", "quadric")
"""The costs, the most accurate first. `quadric` is the published one."""


def document_blocks(results: Results) -> dict[str, str]:
    """Return the generated blocks of docs/decimation.md."""
    tables = {
        "accuracy": accuracy(results),
        "device-mismatch": device_mismatch(results),
        "machine": [results["machine"]],
        **{name: results[name] for name in ("times", "limits", "sphere")},
    }
    return {name: rows_table(rows) for name, rows in tables.items()}


def level_errors(results: Results, method: str, count: int) -> dict[str, float]:
    """Return a method's errors in per cent at a count by device, where it reaches the count."""
    return {
        row["device"]: 100 * row["mismatch"]
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


def accuracy(results: Results) -> Rows:
    """Errors, counts reached, valid meshes and time by method."""
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
        errors = mean_errors(results, method, COUNTS)
        rows.append(
            {
                "method": f"`{method}`" if method in COSTS else method,
                **{f"{count:,}": error for count, error in zip(COUNTS, errors, strict=True)},
                "reached": f"{len(reached)} of {len(results['devices']) * len(COUNTS)}",
                "valid": sum(row["valid"] for row in reached),
                "self-intersecting": sum(row["crossings"] > 0 for row in reached),
                "time, s": mean(seconds),
            }
        )
    return rows


def device_mismatch(results: Results) -> Rows:
    """Errors by device, and the best other library."""
    rows = []
    peers = dict.fromkeys(row["method"] for row in results["peers"])
    for device in results["devices"]:
        name = device["name"]
        row = {"device": f"{name}: {device['kind']}", "full boundary": device["triangles"]}
        for count in (1000, 100):
            for cost in ("finest", "volume"):
                row[f"`{cost}`, {count:,}"] = level_errors(results, cost, count)[name]
            errors = {peer: level_errors(results, peer, count).get(name) for peer in peers}
            error, best = min((error, peer) for peer, error in errors.items() if error is not None)
            row[f"best other, {count:,}"] = f"{error:.3g} ({best})"
        rows.append(row)
    return rows
