"""Time one operation of a revision: ``python -m benchmarks.same.ratios INPUTS OPERATION``.

Prints seconds: processor time of operations of the compute package, and for the start of the server
the time until it is ready. The caller reads the peak memory from the resource usage of the process.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np

import gamutcore
from benchmarks.same.observations import Observations
from benchmarks.same.service_probe import serving

__all__ = ["OPERATIONS", "main"]

OPERATIONS = ("build", "level", "query", "start")
RUNS = 5


def main() -> None:
    """Time the operation that the command line names, and print the median."""
    inputs, operation = Path(sys.argv[1]), sys.argv[2]
    file = inputs / "files" / "FOGRA39L.ti3"
    if operation == "start":
        with tempfile.TemporaryDirectory() as folder:
            start = time.monotonic()
            with serving(Path(folder) / "server", Observations(Path(folder), "start"), {}):
                print(time.monotonic() - start)
        return
    if operation == "build":
        print(_seconds(lambda: gamutcore.Gamut(file), 3))
        return
    gamut = gamutcore.Gamut(file, surface_samples=20_000)
    colours = np.random.default_rng(0).uniform((0, -110, -110), (100, 110, 110), (50_000, 3))
    if operation == "level":
        counts = (100, 1000, 10_000)
        print(_seconds(lambda: [gamut.level(n) for n in counts for _ in range(100)], RUNS))
    else:
        print(_seconds(lambda: (gamut.contains(colours), gamut.nearest(colours)), RUNS))


def _seconds(function: Callable[[], object], runs: int) -> float:
    """Return the median of the processor times, after one call that warms up."""
    function()
    times = []
    for _ in range(runs):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return median(times)


if __name__ == "__main__":
    main()
