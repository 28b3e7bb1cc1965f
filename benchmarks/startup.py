"""The way to the first gamut in a fresh clone: ``make bench-startup``.

Clones this repository, serves it with ``make serve``, posts the example, restarts it, and compiles
all kernels from nothing. Packages come from pip's cache, if they were installed before.
"""

from __future__ import annotations

import contextlib
import os
import resource
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.common import ROOT, Rows
from benchmarks.http import SERVE, server


def startup(quick: bool) -> Rows:
    """Measure a clone, or only restarts of this installation."""
    rows: Rows = []

    def add(figure: str, measured: float, goal: str = "–") -> None:
        rows.append({"figure": figure, "measured": measured, "goal": goal})

    with tempfile.TemporaryDirectory() as folder:
        clone = Path(folder) / "clone"
        if not quick:
            subprocess.run(["git", "clone", "-q", str(ROOT), str(clone)], check=True)
            start = time.monotonic()
            with server(pin=False, command=["make", "serve"], folder=clone) as fresh:
                add("`make serve` in a fresh clone to ready, s", fresh.ready, "≤ 50")
                posted = fresh.post({}).elapsed.total_seconds()
                add("`POST examples/FOGRA39L.ti3` at once after that, s", posted, "≤ 2")
                while "optional: compiled" not in fresh.client.get("/readyz").text:
                    time.sleep(0.05)
                compiled = time.monotonic() - start
                add("`make serve` to all optional kernels compiled, s", compiled)
            seconds, size = compilation(clone)
            add("processor time to compile all kernels, s", seconds, "≤ 65")
            add("machine code of all kernels, MB", size / 1e6, "≤ 15")
            warm = restarts(clone, [str(clone / ".venv/bin/gamut"), "serve"])
        else:
            warm = restarts(ROOT, SERVE)
    idle, worker, ready = warm
    add("resident memory of the warm idle server, MiB", idle, "≤ 200")
    add("resident memory of the warm idle build worker, MiB", worker, "≤ 200")
    add("restart of a warm installation to ready, s", ready, "≤ 2.5")
    return rows


def restarts(folder: Path, command: Sequence[str]) -> tuple[float, float, float]:
    """Restart a warm server three times; return its memory, a worker's, and the median time."""
    with server(pin=False, command=command, folder=folder):
        pass
    times = []
    for _ in range(3):
        with server(pin=False, command=command, folder=folder) as found:
            times.append(found.ready)
            time.sleep(3.0)
            used = memory(found.process.pid)
    return *used, sorted(times)[1]


def memory(group: int) -> tuple[float, float]:
    """Return the resident memory of the server and of its largest build worker, in MiB."""
    resident = [0.0, 0.0]
    for entry in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if int((entry / "stat").read_text().rpartition(")")[2].split()[2]) == group:
                worker = b"service.building.worker" in (entry / "cmdline").read_bytes()
                pages = int((entry / "statm").read_text().split()[1])
                used = pages * os.sysconf("SC_PAGE_SIZE") / 2**20
                resident[worker] = max(resident[worker], used)
    return resident[0], resident[1]


def compilation(clone: Path) -> tuple[float, int]:
    """Compile all kernels from nothing; return the processor time and the bytes of code."""
    cache = clone / "kernels"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [str(clone / ".venv/bin/python"), "-m", "gamutcore.warm"],
        cwd=clone,
        check=True,
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
        stderr=subprocess.DEVNULL,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return used, sum(path.stat().st_size for path in cache.rglob("*.nbc"))
