"""Measure the way to the first gamut in a fresh clone: ``make bench-startup``.

Clones this repository, serves it with ``make serve``, posts the example, restarts it,
and compiles all kernels from nothing. Packages come from pip's cache, if they were
installed before. ``--quick`` restarts this installation only, and writes nothing.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import resource
import subprocess
import tempfile
import time
from pathlib import Path

from benchmarks import markdown
from benchmarks.common import ROOT
from benchmarks.http import SERVE, Server, server

GOALS = {
    "`make serve` in a fresh clone to ready, s": "≤ 60",
    "`POST examples/FOGRA39L.ti3` at once after that, s": "–",
    "`make serve` to all optional kernels compiled, s": "–",
    "processor time to compile all kernels, s": "≤ 100",
    "machine code of all kernels, MB": "≤ 15",
    "resident memory of the warm idle server, MiB": "≤ 200",
    "resident memory of the warm idle build worker, MiB": "≤ 200",
    "restart of a warm installation to ready, s": "≤ 2.5",
}
"""What is measured, in this order, and the most that it should be."""


def main() -> None:
    """Measure the last commit and write the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.startup", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="only restart, and write nothing")
    quick = parser.parse_args().quick
    figures = restarts(ROOT, SERVE) if quick else measure()
    rows = [
        {"figure": name, "measured": figures[name], "goal": goal}
        for name, goal in GOALS.items()
        if name in figures
    ]
    if quick:
        print(markdown.rows_table(rows))
    else:
        markdown.record({"startup": rows})


def measure() -> dict[str, float]:
    """Return the figures of the last commit by the names of `GOALS`."""
    with tempfile.TemporaryDirectory() as folder:
        clone = Path(folder) / "clone"
        subprocess.run(["git", "clone", "-q", str(ROOT), str(clone)], check=True)
        start = time.monotonic()
        with server(pin=False, command=["make", "serve"], folder=clone) as fresh:
            figures = {"`make serve` in a fresh clone to ready, s": fresh.ready}
            posting = fresh.post({}).elapsed.total_seconds()
            figures["`POST examples/FOGRA39L.ti3` at once after that, s"] = posting
            while "optional: compiled" not in fresh.client.get("/readyz").text:
                time.sleep(0.05)
            compiled = time.monotonic() - start
            figures["`make serve` to all optional kernels compiled, s"] = compiled
        return {
            **figures,
            **restarts(clone, [str(clone / ".venv/bin/gamut"), "serve"]),
            **compilation(clone),
        }


def restarts(folder: Path, command: list[str] | tuple[str, ...]) -> dict[str, float]:
    """Restart a warm server three times, and return its memory and the median time."""
    with server(pin=False, command=command, folder=folder):
        pass
    times = []
    for _ in range(3):
        with server(pin=False, command=command, folder=folder) as found:
            times.append(found.ready)
            time.sleep(3.0)
            used = memory(found)
    return {
        "resident memory of the warm idle server, MiB": used["server"],
        "resident memory of the warm idle build worker, MiB": used["worker"],
        "restart of a warm installation to ready, s": sorted(times)[1],
    }


def memory(found: Server) -> dict[str, float]:
    """Return the resident memory of the server and of its largest build worker, in MiB."""
    resident = {"server": 0.0, "worker": 0.0}
    for entry in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            group = int((entry / "stat").read_text().rpartition(")")[2].split()[2])
            if group == found.process.pid:
                worker = b"service.building.worker" in (entry / "cmdline").read_bytes()
                kind = "worker" if worker else "server"
                pages = int((entry / "statm").read_text().split()[1])
                used = pages * os.sysconf("SC_PAGE_SIZE") / 2**20
                resident[kind] = max(resident[kind], used)
    return resident


def compilation(clone: Path) -> dict[str, float]:
    """Compile all kernels from nothing."""
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
    return {
        "processor time to compile all kernels, s": used,
        "machine code of all kernels, MB": (
            sum(path.stat().st_size for path in cache.rglob("*.nbc")) / 1e6
        ),
    }


if __name__ == "__main__":
    main()
