"""Measure speed and memory of the compute package and of the service: ``make bench``.

Prints one table per measurement. Writes the figures to ``benchmarks/results.json`` and updates the
tables of ``docs/benchmarks.md`` and ``docs/scaling.md``. ``--only NAME ...`` repeats some
measurements and keeps the figures of the others. ``--quick`` takes fewer runs and writes nothing.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

from benchmarks import common, compute, device_values, http, inputs, markdown, pictures, scaling
from gamutcore.decimation import COSTS
from gamutcore.warm import compile_kernels

__all__ = ["DOCUMENT", "RESULTS", "document_blocks", "machine", "main"]

RESULTS = Path(__file__).with_name("results.json")
DOCUMENT = common.ROOT / "docs" / "benchmarks.md"

Rows = list[dict[str, Any]]


def machine() -> dict[str, Any]:
    """Return the date, the processor and the versions of the software of this run."""
    model = platform.processor() or platform.machine()
    cpus = Path("/proc/cpuinfo")
    if cpus.exists():
        lines = [line for line in cpus.read_text().splitlines() if line.startswith("model name")]
        model = lines[0].partition(":")[2].strip() if lines else model
    return {
        "date": time.strftime("%Y-%m-%d"),
        "cpu": model,
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "scipy", "numba", "trimesh", "uvicorn")},
    }


def measurements(quick: bool) -> dict[str, Callable[[], Rows]]:
    """Return the measurements by name; quick ones take fewer runs."""
    runs = 3 if quick else 9
    sizes = [10_000, 100_000] if quick else [10_000, 30_000, 100_000, 300_000, 1_000_000]
    return {
        "machine": lambda: [machine()],
        "build": lambda: compute.build_times(100_000, runs),
        "memory": lambda: [compute.peak_memory(100_000, cost) for cost in COSTS],
        "levels": lambda: compute.level_times(sizes, 200),
        "inputs": lambda: inputs.input_times(3 if quick else 7),
        "pictures": lambda: pictures.picture_times(1 if quick else 3),
        "device_values": device_values.device_value_figures,
        "post": lambda: [http.build_over_http(3 if quick else 7)],
        "meshes": lambda: http.mesh_rates(2000 if quick else 20_000, 1 if quick else 5),
    }


def main() -> int:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="take fewer runs and write nothing")
    names = list(measurements(quick=False))
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="NAME")
    arguments = parser.parse_args()
    if sys.platform == "linux":
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # the targets are for one core
    compile_kernels()
    results: dict[str, Rows] = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    for name, measure in measurements(arguments.quick).items():
        if name in arguments.only or name not in results:
            results[name] = measure()
            print(f"\n{name}\n\n{figure_table(results[name])}", flush=True)
    if not arguments.quick:
        RESULTS.write_text(json.dumps(results, indent=1) + "\n")
        markdown.update_document(DOCUMENT, document_blocks(results))
        scaling.update(scaling.Load())
    return 0


def document_blocks(results: dict[str, Rows]) -> dict[str, str]:
    """Return the generated blocks of docs/benchmarks.md: one table per measurement."""
    return {name.replace("_", "-"): figure_table(rows) for name, rows in results.items()}


def figure_table(rows: Rows) -> str:
    """Format rows as a Markdown table, with numbers to three significant digits.

    Examples
    --------
    >>> print(figure_table([{"boundary_s": 0.12345}]))
    | boundary, s |
    | --- |
    | 0.123 |
    """
    columns = list(dict.fromkeys(name for row in rows for name in row))
    lines = [[_cell(row.get(name)) for name in columns] for row in rows]
    return markdown.table([_heading(name) for name in columns], lines)


def _heading(name: str) -> str:
    """Column heading: ``total_s`` becomes "total, s", ``requests_per_s`` "requests per s"."""
    words = name.split("_")
    unit = {"s": "s", "ms": "ms", "mb": "MB"}.get(words[-1])
    if unit and len(words) > 1 and words[-2] != "per":
        return f"{' '.join(words[:-1])}, {unit}"
    return " ".join(words).replace(" us ", " µs ")


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    if isinstance(value, int):
        return f"{value:,}"
    if isinstance(value, dict):
        return ", ".join(f"{name}: {count:,}" for name, count in value.items())
    return "–" if value is None else str(value)


if __name__ == "__main__":
    raise SystemExit(main())
