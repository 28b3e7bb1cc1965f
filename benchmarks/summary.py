"""Statistics of the figures in ``benchmarks/decimation.json``: means over devices and best peers.

A *method* is a cost of this project, another library (a peer), or another way to make a simple
boundary. Errors are relative volume mismatches.
"""

from __future__ import annotations

from collections.abc import Iterable
from statistics import mean
from typing import Any

__all__ = [
    "PUBLISHED_COST",
    "Results",
    "best_peer",
    "boundary_methods",
    "costs_by_accuracy",
    "error_ratios",
    "level_errors",
    "mean_best_peer",
    "mean_errors",
]

Results = dict[str, Any]
"""The content of ``benchmarks/decimation.json``."""

PUBLISHED_COST = "quadric"
"""The cost of the published experiment. Other costs are compared with it."""


def level_errors(results: Results, method: str, count: int) -> dict[str, float]:
    """Return a method's errors at a triangle count by device, where it reaches the count."""
    return {
        row["device"]: row["mismatch"]
        for row in (*results["levels"], *results["peers"])
        if row["method"] == method
        and row["asked"] == count
        and row["reached"]
        and row["mismatch"] is not None
    }


def error_ratios(results: Results, method: str, count: int) -> dict[str, float]:
    """Return a method's errors divided by those of the published cost, by device."""
    published = level_errors(results, PUBLISHED_COST, count)
    errors = level_errors(results, method, count)
    return {device: error / published[device] for device, error in errors.items()}


def mean_errors(results: Results, method: str, counts: Iterable[int]) -> dict[int, float | None]:
    """Return a method's mean error over all devices by count; None if it fails on a device."""
    means: dict[int, float | None] = {}
    for count in counts:
        errors = level_errors(results, method, count)
        means[count] = mean(errors.values()) if len(errors) == len(results["devices"]) else None
    return means


def costs_by_accuracy(results: Results) -> list[str]:
    """Return the costs, the least accurate at 1,000 triangles first."""

    def error(cost: str) -> float:
        return mean(level_errors(results, cost, 1000).values())

    return sorted(results["costs"], key=error, reverse=True)


def best_peer(results: Results, device: str, count: int) -> tuple[str, float] | None:
    """Return name and error of the most accurate other library for a device and count."""
    errors = [
        (row["mismatch"], row["method"])
        for row in results["peers"]
        if row["device"] == device
        and row["asked"] == count
        and row["reached"]
        and row["mismatch"] is not None
    ]
    return (min(errors)[1], min(errors)[0]) if errors else None


def mean_best_peer(results: Results, count: int) -> float | None:
    """Return the mean over devices of the best peer's error; None if a device has none."""
    best = [best_peer(results, device["name"], count) for device in results["devices"]]
    errors = [found[1] for found in best if found is not None]
    return mean(errors) if len(errors) == len(best) else None


def boundary_methods(results: Results) -> dict[str, list[dict[str, Any]]]:
    """Return means over the devices for every size of the other boundary methods.

    Returns
    -------
    dict of list of dict
        By method, in the order of size: ``size``, ``triangles``, ``mismatch``, ``volume``,
        ``decimated`` (mean mismatch by cost at the same triangle counts), ``better`` (number of
        devices on which the published cost is more accurate) and ``devices``. Sizes that fail on
        a device are left out.
    """
    groups: dict[tuple[str, int], list[dict[str, Any]]] = {}
    for row in results["others"]:
        # The convex hull takes all colours. Their number differs slightly between devices.
        size = 0 if row["method"] == "convex hull" else row["size"]
        groups.setdefault((row["method"], size), []).append(row)
    devices = {device["name"] for device in results["devices"]}
    methods: dict[str, list[dict[str, Any]]] = {}
    for (method, size), rows in sorted(groups.items()):
        if {row["device"] for row in rows} != devices:
            continue
        decimated = [row["decimated"] for row in rows]
        methods.setdefault(method, []).append(
            {
                "size": size,
                **{
                    name: mean(row[name] for row in rows)
                    for name in ("triangles", "mismatch", "volume")
                },
                "decimated": {
                    cost: mean(errors[cost] for errors in decimated) for cost in results["costs"]
                },
                "better": sum(row["decimated"][PUBLISHED_COST] < row["mismatch"] for row in rows),
                "devices": len(rows),
            }
        )
    return methods
