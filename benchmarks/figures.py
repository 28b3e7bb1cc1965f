"""The published experiment and all that is claimed about decimation: ``make figures``.

Measures real devices one after another (``devices``, ``peers``, ``paper``), speed and memory
(``speed``) and levels by their error (``limits``), and writes the same figures to
``benchmarks/decimation.json``, ``docs/decimation.md`` with its pictures, and the short table in the
README. What has been measured is kept under
``build/figures`` until any module of ``gamutcore`` or of the measurements changes, so that a run
that was broken off goes on where it was. ``--document`` writes the texts anew from the JSON file.
"""

from __future__ import annotations

import argparse
import functools
import hashlib
import json
import os
import sys
import time
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from benchmarks import document, limits, paper, peers, plots, speed
from benchmarks.bench import machine
from benchmarks.devices import ROOT, Device, devices, disagreement
from benchmarks.render import levels_picture, methods_picture
from benchmarks.summary import costs_by_accuracy
from gamutcore.boundary import modified_convex_hull
from gamutcore.boundary.segment_maxima import segment_maxima
from gamutcore.boundary.usv import usv
from gamutcore.decimation import COSTS, decimate
from gamutcore.history import build_history
from gamutcore.version import ALGORITHM_VERSION
from gamutcore.warm import compile_kernels

__all__ = ["main"]

RESULTS = Path(__file__).with_name("decimation.json")
KEPT = ROOT / "build" / "figures"
MEASURING = ("devices", "files", "limits", "paper", "peers", "speed")
"""Modules of this package that results depend on, besides all of `gamutcore`."""

LIBRARIES = (
    "vtk", "pymeshlab", "meshlib", "fast-simplification", "pyfqmr", "manifold3d", "matplotlib"
)  # fmt: skip

DRAWN = {"FOGRA39L": "levels-fogra39l", "phone": "levels-phone", "sRGB": "levels-srgb"}
"""Devices whose levels are drawn, and the names of the pictures."""


def main() -> int:
    """Measure, write, draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--document", action="store_true", help="only write the texts and plots")
    parser.add_argument("--again", action="store_true", help="measure even what was kept")
    asked = parser.parse_args()
    if asked.document:
        measured = json.loads(RESULTS.read_text())
    else:
        if sys.platform == "linux":
            os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # one core, as the goals say
        absent = peers.missing()
        if absent:
            print(f"not installed, so not measured: {', '.join(absent)}")
        compile_kernels()
        measured = measure(again=asked.again)
        RESULTS.write_text(document.json_text(measured))
        measured = json.loads(RESULTS.read_text())  # rounded, as `--document` will read them
        draw(costs_by_accuracy(measured))
    plots.write(measured)
    document.write(measured)
    return 0


def measure(*, again: bool) -> dict[str, Any]:
    """Return all figures: kept ones, and anew what is not there."""
    folder = KEPT / sources_digest()
    folder.mkdir(parents=True, exist_ok=True)

    def kept(name: str, work: Callable[[], Any]) -> Any:  # noqa: ANN401  # whatever JSON holds
        file = folder / f"{name}.json"
        if again or not file.exists():
            print(f"{time.strftime('%H:%M:%S')} {name}", flush=True)
            file.write_text(json.dumps(work()))
        return json.loads(file.read_text())

    found = [
        kept(f"device-{device.path.stem}", functools.partial(measured_device, device))
        for device in devices()
    ]
    return {
        "machine": {**machine(), **library_versions(), "algorithm": ALGORITHM_VERSION},
        "costs": list(COSTS),
        "devices": [each["device"] for each in found],
        "levels": [row for each in found for row in each["levels"]],
        "peers": [row for each in found for row in each["peers"]],
        "others": [row for each in found for row in each["others"]],
        "floors": [each["floor"] for each in found],
        "voxels": [row for each in found for row in each["voxels"]],
        "disagreement": max(each["disagreement"] for each in found),
        "sphere": kept("sphere", paper.sphere_rows),
        "million": kept("million", speed.million_points),
        "history": kept("history", lambda: speed.history_times(15)),
        "storage": kept("storage", lambda: speed.storage(25)),
        "few": kept("few", lambda: speed.few_triangles(7)),
        "hubs": kept("hubs", lambda: speed.hubs(7)),
        "scaling": kept("scaling", lambda: speed.scaling(3)),
        "limits": kept("limits", limited_levels),
    }


def measured_device(device: Device) -> dict[str, Any]:
    """All that is measured on one device."""
    histories, times = speed.measured_histories(device.boundary, 5)
    levels = peers.level_rows(device, histories, paper.CURVE_COUNTS)
    return {
        "device": {
            "name": device.name,
            "kind": device.kind,
            "points": len(device.points),
            "triangles": device.boundary.mesh.triangles,
            "volume": device.boundary.mesh.volume,
            "histories": speed.with_memory(device.boundary, times),
        },
        "levels": levels,
        "peers": peers.peer_rows(device),
        "others": paper.other_rows(device, histories, levels),
        "floor": paper.floor_row(device),
        "voxels": paper.voxel_rows(device, histories["quadric"]),
        "disagreement": max(
            disagreement(device.boundary.mesh, histories[cost].level(count), device.boundary.centre)
            for cost in histories
            for count in (1000, 50)
        ),
    }


def limited_levels() -> list[dict[str, Any]]:
    """Levels chosen by limits, of the first device and of the last."""
    return [
        row
        for device in (devices()[0], devices()[-1])
        for row in limits.limit_rows(device, device.histories)
    ]


def draw(costs: list[str]) -> None:
    """Draw the pictures: levels of three devices with the default cost, and one by all methods."""
    for device in devices():
        if device.name in DRAWN:
            history = build_history(decimate(device.boundary.mesh, device.boundary.centre))
            levels_picture(device, history, DRAWN[device.name])
    device = devices()[0]
    boundary, points = device.boundary, device.points
    by_usv = usv(points, "icosahedron", 1, 0.05, boundary.centre).mesh
    count = by_usv.triangles
    decimations = [
        (f"decimation, {cost}", build_history(decimate(boundary.mesh, boundary.centre, cost)))
        for cost in costs
    ]
    methods_picture(
        device,
        [
            ("reference", boundary.mesh),
            ("convex hull", modified_convex_hull(points, 1.0, boundary.centre).mesh),
            ("segment maxima", segment_maxima(points, (6, 13), boundary.centre).mesh),
            ("USV, icosahedron", by_usv),
            ("subsampled modified hull", paper.subsampled(points, boundary.centre, count).mesh),
            *((name, history.level(count)) for name, history in decimations),
        ],
        "methods-fogra39l",
        4,
    )


def sources_digest() -> str:
    """Digest of every module that the results depend on, of the data and of the libraries."""
    files = sorted((ROOT / "gamutcore").rglob("*.py"))
    files += [Path(__file__).with_name(f"{name}.py") for name in MEASURING]
    files += [device.path for device in devices()]
    digest = hashlib.sha256(json.dumps(library_versions()).encode())
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def library_versions() -> dict[str, str]:
    """Return the versions of the libraries that are compared; of those installed."""
    versions = {}
    for name in LIBRARIES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            continue
    return versions


if __name__ == "__main__":
    raise SystemExit(main())
