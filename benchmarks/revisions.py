"""Compare the speed of the compute package with that of an earlier revision: ``make bench-before``.

``make bench-builds`` compares whole builds. Clones the earlier revision and installs it. A process
of each revision then times the same operations for the same data. Both time each operation in turn,
so that a busy machine slows both down. Medians of the times and of their ratios go to
``benchmarks/revisions.json`` and into ``docs/benchmarks.md``. Packages come from pip's cache, if
they were installed before.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from typing import IO, TYPE_CHECKING, Any, cast

import numpy as np

from benchmarks import markdown
from benchmarks.bench import DOCUMENT
from benchmarks.common import ROOT
from benchmarks.devices import Device, devices
from benchmarks.revision_worker import BUILDS, OPERATIONS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["BEFORE", "BEFORE_BUILDS", "GOAL", "compare", "compare_builds", "main", "table_of"]

RESULTS = Path(__file__).with_suffix(".json")
WORKER = Path(__file__).with_name("revision_worker.py")

BEFORE = "eb6eac4"
"""The last revision before each kernel was optimised only once (docs/decisions/kernels.md)."""

BEFORE_BUILDS = "8ada781"
"""The last revision before the centre and γ were chosen by the device's surface; a build may take
1.3 times as long (docs/decisions/gamma.md)."""

BUILDS_OF: tuple[str, ...] = (
    "FOGRA39L",
    "TR 002",
    "phone",
    "Acer XB271HU",
    "Panasonic",
    "Canon",
    "sRGB",
)
"""Devices whose builds are compared."""

GOAL = 1.05
"""Decimation, levels and histories may be this much slower than before."""

PROCESSES = 5
"""Processes of each revision, one after the other."""

NAMES: tuple[str, ...] = ("FOGRA39L", "phone", "sRGB")
"""A press, measured; a display, measured; and a colour space."""


def main() -> None:
    """Compare the working tree with an earlier revision, and write the ratios."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.revisions", description=__doc__)
    parser.add_argument("--builds", action="store_true", help="compare builds instead")
    parser.add_argument("--before", help="revision to compare with")
    parser.add_argument("--clone", type=Path, help="an installed clone of it, to save time")
    parser.add_argument("--rounds", type=int, default=3, help="in each process")
    arguments = parser.parse_args()
    key, names, function = "devices", NAMES, compare
    before = arguments.before or BEFORE
    if arguments.builds:
        key, names, function = "builds", BUILDS_OF, compare_builds
        before = arguments.before or BEFORE_BUILDS
    with tempfile.TemporaryDirectory() as folder:
        clone = arguments.clone or _install(before, Path(folder) / "clone")
        found = {
            device.name: function(device, clone, arguments.rounds)
            for device in devices()
            if device.name in names
        }
    results = json.loads(RESULTS.read_text())
    results["before_builds" if arguments.builds else "before"] = before
    results[key] = found
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")
    text = table_of(found, BUILDS if arguments.builds else OPERATIONS)
    print(text)
    markdown.update_document(DOCUMENT, {"builds" if arguments.builds else "revisions": text})


def compare(device: Device, clone: Path, rounds: int) -> dict[str, dict[str, float]]:
    """Return the medians of the processor times of both revisions in seconds, and of their ratios.

    Parameters
    ----------
    device : Device
    clone : Path
        An installed clone of the earlier revision.
    rounds : int
        How often each operation is timed in each process.

    Returns
    -------
    dict of dict
        ``before``, ``now`` and ``ratio`` by the names of `OPERATIONS`.
    """
    mesh = device.boundary.mesh
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    with tempfile.TemporaryDirectory() as folder:
        np.savez(
            Path(folder) / "boundary.npz",
            vertices=mesh.vertices,
            faces=mesh.faces,
            centre=device.boundary.centre,
            channels=(mesh.vertices - low) / (high - low),
        )
        return _alternate(OPERATIONS, clone, folder, rounds)


def compare_builds(device: Device, clone: Path, rounds: int) -> dict[str, dict[str, float]]:
    """Return the same as `compare` for `BUILDS` of a device's characterisation.

    Parameters
    ----------
    device : Device
    clone : Path
        An installed clone of the earlier revision.
    rounds : int

    Returns
    -------
    dict of dict
    """
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "characterisation").write_bytes(device.path.read_bytes())
        return _alternate(BUILDS, clone, folder, rounds)


def _alternate(
    names: Iterable[str], clone: Path, folder: str, rounds: int
) -> dict[str, dict[str, float]]:
    """Medians of the times of operations in both revisions, which take turns."""
    pythons = (str(clone / ".venv/bin/python"), sys.executable)
    times = []
    # where a process's arrays lie in memory changes a time by up to 1.7
    for _ in range(PROCESSES):
        workers = [_start(python, folder) for python in pythons]
        times += [
            {name: [_seconds(worker, name) for worker in workers] for name in names}
            for _ in range(rounds)
        ]
        for worker in workers:
            worker.communicate()
    return {
        name: {
            "before": median(each[name][0] for each in times),
            "now": median(each[name][1] for each in times),
            "ratio": median(each[name][1] / each[name][0] for each in times),
        }
        for name in names
    }


def table_of(compared: dict[str, Any], operations: Mapping[str, str] = OPERATIONS) -> str:
    """Return the ratios as a Markdown table, with the times of the first device.

    Parameters
    ----------
    compared : dict
        Figures by device, as in the file of results.
    operations : mapping of str to str, optional
        Titles of the operations.
    """
    first = next(iter(compared))
    head = ["operation", f"{first} before, ms", "now, ms", *(f"{name}, ratio" for name in compared)]
    rows = []
    for name, title in operations.items():
        times = [f"{1e3 * compared[first][name][key]:.3g}" for key in ("before", "now")]
        ratios = [f"{figures[name]['ratio']:.2f}" for figures in compared.values()]
        rows.append([title, *times, *ratios])
    return markdown.table(head, rows)


def _install(revision: str, clone: Path) -> Path:
    subprocess.run(["git", "clone", "-q", str(ROOT), str(clone)], check=True)
    subprocess.run(["git", "checkout", "-q", revision], cwd=clone, check=True)
    subprocess.run(["make", "install"], cwd=clone, check=True)
    return clone


def _start(python: str, folder: str) -> subprocess.Popen[str]:
    worker = subprocess.Popen(
        [python, "-P", str(WORKER), folder],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        cwd=folder,
        text=True,
    )
    cast("IO[str]", worker.stdout).readline()
    return worker


def _seconds(worker: subprocess.Popen[str], name: str) -> float:
    """Return the processor time of an operation."""
    print(name, file=worker.stdin, flush=True)
    return float(cast("IO[str]", worker.stdout).readline())


if __name__ == "__main__":
    main()
