"""All measurements in one run: ``make bench``.

Prints tables, and writes the same figures to ``benchmarks/results.json`` and
``docs/benchmarks.md``, with the machine named. ``--quick`` takes fewer runs and writes nothing.
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

from benchmarks import compute, device_values, http, inputs, pictures, scaling
from gamutcore.decimation import COSTS
from gamutcore.warm import compile_kernels

__all__ = ["main"]

RESULTS = Path(__file__).with_name("results.json")
DOCUMENT = compute.ROOT / "docs" / "benchmarks.md"

GOALS = {
    "build": "sRGB, 100,000 points: boundary + history ≤ 1.0 s, of which decimation ≤ 0.5 s",
    "memory": "peak memory of that ≤ 500 MB",
    "levels": "1,000 triangles ≤ 0.2 ms, 10,000 ≤ 1.5 ms, full mesh ≤ 15 ms; cost follows n",
    "accuracy": "FOGRA39L: no worse than the published figures plus 10 %",
    "inputs": "to 100,000 surface colours: CMYK profile ≤ 0.3 s, 1,617 patches ≤ 1.5 s; by HTTP",
    "pictures": "24 megapixels to a gamut: ≤ 10 s, ≤ 1,500 MB",
    "device_values": "device values at vertices: ΔE of what they make, mean / largest; bits each",
    "post": "FOGRA39L posted to a fresh, warm server: 201 within 3 s",
    "meshes": "1,000 triangles, one process: ≥ 1,800 requests/s uncached, ≥ 5,000/s repeated with "
    "p99 ≤ 15 ms, ≥ 6,000/s not modified",
}


INTRODUCTION = """\
Written by `make bench` (benchmarks/bench.py), on the machine named here, one core per process; the
same figures are in benchmarks/results.json. Times are medians of several runs with warm kernels.
Mismatches are exact, in %.
"""


def machine() -> dict[str, Any]:
    """What this run was made on."""
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


def table(rows: list[dict[str, Any]]) -> str:
    """Rows as a Markdown table; numbers to three significant digits."""

    def shown(value: object) -> str:
        if isinstance(value, float):
            return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
        if isinstance(value, int):
            return f"{value:,}"
        if isinstance(value, dict):
            return ", ".join(f"{name}: {count:,}" for name, count in value.items())
        return "–" if value is None else str(value)

    columns = list(dict.fromkeys(name for row in rows for name in row))
    lines = [" | ".join(columns), " | ".join("---" for _ in columns)]
    lines += [" | ".join(shown(row.get(name)) for name in columns) for row in rows]
    return "\n".join(f"| {line} |" for line in lines)


def main() -> int:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer runs, nothing written")
    quick = parser.parse_args().quick
    runs = 3 if quick else 9
    if sys.platform == "linux":
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # one core, as the goals say
    compile_kernels()
    sizes = [10_000, 100_000] if quick else [10_000, 30_000, 100_000, 300_000, 1_000_000]
    measured: dict[str, list[dict[str, Any]]] = {"machine": [machine()]}
    print(table(measured["machine"]), flush=True)
    measurements: tuple[tuple[str, Callable[[], list[dict[str, Any]]]], ...] = (
        ("build", lambda: compute.build_times(100_000, runs)),
        ("memory", lambda: [compute.peak_memory(100_000, cost) for cost in COSTS]),
        ("levels", lambda: compute.level_times(sizes, 200)),
        ("accuracy", lambda: compute.accuracy([10_000, 1000, 500, 100, 50, 20, 10])),
        ("inputs", lambda: inputs.input_times(3 if quick else 7)),
        ("pictures", lambda: pictures.picture_times(1 if quick else 3)),
        ("device_values", device_values.device_value_figures),
        ("post", lambda: [http.build_over_http(3 if quick else 7)]),
        ("meshes", lambda: http.mesh_rates(2000 if quick else 20_000, 1 if quick else 5)),
    )
    for name, measure in measurements:
        measured[name] = measure()
        print(f"\n{GOALS[name]}\n\n{table(measured[name])}", flush=True)
    if not quick:
        RESULTS.write_text(json.dumps(measured, indent=1) + "\n")
        DOCUMENT.write_text(document(measured))
        scaling.write(scaling.Load())  # the same figures, taken further
    return 0


def document(measured: dict[str, list[dict[str, Any]]]) -> str:
    """The figures as a page of the documentation."""
    parts = [
        "# Benchmarks\n",
        INTRODUCTION,
        table(measured["machine"]),
    ]
    for name, goal in GOALS.items():
        parts.append(f"\n## {goal}\n\n{table(measured[name])}")
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    raise SystemExit(main())
