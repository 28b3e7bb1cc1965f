"""Inputs, timing and memory that several measurements share."""

from __future__ import annotations

import contextlib
import os
import platform
import re
import subprocess
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from gamutcore.characterisation import GamutMesh, read_characterisation
from gamutcore.colours import surface_colours
from gamutcore.decimation import decimate
from gamutcore.geometry import TriangleMesh
from gamutcore.history import History, build_history
from gamutcore.references import Reference

ROOT = Path(__file__).parent.parent
DOCUMENT = ROOT / "docs" / "benchmarks.md"
RESULTS = Path(__file__).with_name("results.json")
"""Tables of docs/benchmarks.md, by the names of their blocks."""
SHARED = ROOT.parent / "shared" / "data"
"""Files that the repository may not contain. Measurements that need them are left out without."""

FOGRA39L = ROOT / "examples" / "FOGRA39L.ti3"
SRGB = ROOT / "tests" / "data" / "sRGB-v4.icc"
P3 = ROOT / "tests" / "data" / "DisplayP3-v4.icc"

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
Rows = list[dict[str, Any]]


def machine(*packages: str) -> dict[str, Any]:
    """Return the date, the processor and the versions of the software of this run."""
    cpus = Path("/proc/cpuinfo")
    text = cpus.read_text() if cpus.exists() else ""
    found = re.search(r"^model name\s*:\s*(.+)", text, re.MULTILINE)
    return {
        "date": time.strftime("%Y-%m-%d"),
        "cpu": found[1] if found else platform.machine(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "numba", *packages)},
    }


def use_one_core() -> None:
    """Pin this process to the last core, because the figures are for one core."""
    if sys.platform == "linux":
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def surface_points(path: Path, samples: int = 100_000) -> FloatArray:
    """Return at most that many CIELAB colours of a device's surface, shape (n, 3)."""
    device = read_characterisation(path.read_bytes())
    if isinstance(device, GamutMesh | Reference):
        raise TypeError(f"{path.name} has no device data. Use a profile or measurements.")
    return surface_colours(device, surface_samples=samples).points


def build_mesh_history(mesh: TriangleMesh, centre: FloatArray, cost: str = "volume") -> History:
    """Decimate a full boundary, which is star-shaped about the centre, and return the history."""
    return build_history(decimate(mesh, centre, cost))


def times_of(
    function: Callable[[], object], runs: int, clock: Callable[[], float] = time.perf_counter
) -> list[float]:
    """Return the sorted times of several calls in seconds, after one call that warms up."""
    function()
    times = []
    for _ in range(runs):
        start = clock()
        function()
        times.append(clock() - start)
    return sorted(times)


def resident_bytes(name: str = "VmRSS", pid: int | str = "self") -> int:
    """Return the resident memory of a process: now (VmRSS) or at its peak (VmHWM). Linux only."""
    status = Path(f"/proc/{pid}/status").read_text()
    found = re.search(rf"^{name}:\s+(\d+) kB", status, re.MULTILINE)
    if found is None:
        raise RuntimeError(f"/proc/{pid}/status contains no {name}. The process has ended.")
    return 1024 * int(found[1])


def proportional_bytes(root: int) -> int:
    """Return the sum of PSS of a process and its descendants: pages that they share count once."""
    children: dict[int, list[int]] = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            parent = int(path.read_text().rpartition(")")[2].split()[1])
            children.setdefault(parent, []).append(int(path.parent.name))
    total, found = 0, [root]
    for process in found:
        found += children.get(process, [])
        with contextlib.suppress(OSError):
            rollup = Path(f"/proc/{process}/smaps_rollup").read_text()
            total += int(rollup.partition("\nPss:")[2].split()[0]) * 1024
    return total


def run_module(name: str, *arguments: str, prefix: list[str] | None = None, text: str = "") -> str:
    """Run a module of this package in a fresh process and return what it prints.

    ``prefix`` are words before the command, such as those of ``taskset``; ``text`` is its input.
    """
    done = subprocess.run(
        [*(prefix or []), sys.executable, "-m", f"benchmarks.{name}", *arguments],
        cwd=ROOT,
        input=text,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return done.stdout
