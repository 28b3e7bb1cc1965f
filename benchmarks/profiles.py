"""Profiles beside those of Argyll's colprof, from the same measurements: ``make bench-profiles``.

``profcheck -k`` compares the measurements with the colours that a profile gives for them. The round
trip asks ``xicclu -fb`` for device values and ``xicclu -ff`` for their colours, with the relative
intent. Colours in gamut are those of random device values within the ink limit; colours out of
gamut have a* and b* from −100 to 100. Times are processor times. colprof has no ink limit, so its
gamut is larger where it is dark.
"""

from __future__ import annotations

import re
import resource
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.common import FOGRA39L, ROOT, SHARED, FloatArray, Rows
from benchmarks.recipes import xicclu
from gamutcore import Gamut, profile
from gamutcore.search import delta_e_2000

PRESSES = {
    "FOGRA39L": (FOGRA39L, 300),
    "TR002": (SHARED / "press" / "TR002.ti3", 260),
    "FOGRA29L": (ROOT / "examples" / "FOGRA29L.ti3", 300),
}
"""Measurements and total ink limits in per cent."""


def profiles(quick: bool) -> Rows:
    """Errors and times of profiles by both programs."""
    rows: Rows = []
    for name, (path, limit) in PRESSES.items():
        if not path.is_file() or shutil.which("colprof") is None:
            print(f"{name} is left out: {path} or colprof is not there.", flush=True)
            continue
        with tempfile.TemporaryDirectory() as folder:
            measured = Path(folder) / "press.ti3"
            shutil.copyfile(path, measured)
            inside, outside = _colours(path, limit, 500 if quick else 5000)
            own, start = Path(folder) / "own.icc", time.process_time()
            profile(path, ink_limit=limit).save(own)
            seconds = {"gamut profile": time.process_time() - start}
            peer = measured.with_suffix(".icc")
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            quality = "-ql" if quick else "-qh"
            command = ["colprof", quality, str(measured.with_suffix(""))]
            subprocess.run(command, check=True, capture_output=True)
            seconds["colprof"] = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
            for program, made in (("gamut profile", own), ("colprof", peer)):
                row: dict[str, Any] = {"press": name, "program": program, "s": seconds[program]}
                rows.append(row | figures(measured, made, inside, outside))
    return rows


def _colours(path: Path, limit: float, count: int) -> tuple[FloatArray, FloatArray]:
    """Return colours in gamut and out of gamut."""
    gamut, random = Gamut(path, ink_limit=limit), np.random.default_rng(3)
    device = random.random((8 * count, 4))
    inside = gamut.to_colour(device[device.sum(axis=1) <= limit / 100][:count])
    anywhere = random.random((2 * count, 3)) * (100, 200, 200) - (0, 100, 100)
    return inside, anywhere[~gamut.contains(anywhere)][:count]


def figures(
    measured: Path, made: Path, inside: FloatArray, outside: FloatArray
) -> dict[str, float]:
    """Return the errors of a profile in ΔE00."""
    checked = subprocess.run(
        ["profcheck", "-k", str(measured), str(made)], capture_output=True, text=True, check=True
    )
    worst, mean = re.findall(r"(?:max|avg)\. = ([0-9.]+)", checked.stdout)
    row = {"profcheck, mean": float(mean), "profcheck, worst": float(worst)}
    trips = []
    for colours in (inside, outside):
        device, _ = xicclu(made, ["-fb"], colours, 4)
        trips.append(delta_e_2000(colours, xicclu(made, ["-ff"], device, 3)[0]))
    there, beyond = trips
    return row | {
        "in gamut, mean": float(there.mean()),
        "95 %": float(np.percentile(there, 95)),
        "worst": float(there.max()),
        "out of gamut, mean": float(beyond.mean()),
    }
