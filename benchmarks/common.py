"""Inputs, timing and memory that several measurements share."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gamutcore.characterisation import GamutMesh, IccProfile, Picture, Samples, characterisation
from gamutcore.colours import surface_colours
from gamutcore.decimation import decimate
from gamutcore.history import History, build_history
from gamutcore.mesh import TriangleMesh
from gamutcore.references import Reference

__all__ = [
    "FOGRA39L",
    "ROOT",
    "SHARED",
    "SRGB",
    "FloatArray",
    "build_mesh_history",
    "device_data",
    "resident_bytes",
    "run_module",
    "sphere_samples",
    "surface_points",
    "times_of",
]

ROOT = Path(__file__).parent.parent
SHARED = ROOT.parent / "shared" / "data"
"""Files that the repository may not contain. Measurements that need them are left out without."""

FOGRA39L = ROOT / "examples" / "FOGRA39L.ti3"
SRGB = ROOT / "tests" / "data" / "sRGB-v4.icc"

FloatArray = np.ndarray[Any, np.dtype[np.float64]]


def device_data(data: bytes) -> Samples | IccProfile | Picture:
    """Return the characterisation data in the bytes of a file.

    Raises
    ------
    TypeError
        If the file is a gamut mesh or a reference gamut.
    """
    device = characterisation(data)
    if isinstance(device, GamutMesh | Reference):
        raise TypeError("The file has no device data. Use measurements, a profile or a picture.")
    return device


def surface_points(path: Path, samples: int = 100_000) -> FloatArray:
    """Return at most that many CIELAB colours of a device's surface, shape (n, 3)."""
    return surface_colours(device_data(path.read_bytes()), surface_samples=samples).points


def build_mesh_history(mesh: TriangleMesh, centre: FloatArray, cost: str = "volume") -> History:
    """Decimate a full boundary, which is star-shaped about the centre, and return the history."""
    return build_history(decimate(mesh, centre, cost))


def sphere_samples(seed: int, count: int = 300) -> dict[str, Any]:
    """Return characterisation data as JSON: colours on a sphere, which differ by seed."""
    directions = np.random.default_rng(seed).normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return {"samples": np.round(directions * 40 + (50, 0, 0), 6).tolist()}


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


def run_module(name: str, *arguments: str, prefix: list[str] | None = None, text: str = "") -> str:
    """Run a module of this package in a fresh process and return what it prints.

    Parameters
    ----------
    name : str
        Name of the module inside the package.
    *arguments : str
    prefix : list of str, optional
        Words before the command, such as those of ``taskset``.
    text : str, optional
        Standard input.
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
