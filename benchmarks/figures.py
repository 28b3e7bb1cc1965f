"""Measure accuracy, speed and memory of decimation, and repeat the published experiment.

``make figures`` runs it. The measurements are in `devices`, `peers`, `paper`, `speed` and `limits`.
The figures go to ``benchmarks/decimation.json``, from which the tables of ``docs/decimation.md``
and the plots are made. ``--document`` makes the tables and plots from the existing file.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from benchmarks import decimation_tables, limits, paper, peers, plots, speed
from benchmarks.bench import machine
from benchmarks.common import ROOT, build_mesh_history
from benchmarks.devices import Device, devices, disagreement
from benchmarks.markdown import update_document
from benchmarks.render import levels_picture, methods_picture
from benchmarks.summary import costs_by_accuracy
from gamutcore.boundary import modified_convex_hull
from gamutcore.boundary.segment_maxima import segment_maxima
from gamutcore.boundary.usv import usv
from gamutcore.decimation import COSTS
from gamutcore.version import ALGORITHM_VERSION
from gamutcore.warm import compile_kernels

__all__ = ["DOCUMENT", "RESULTS", "json_text", "main"]

RESULTS = Path(__file__).with_name("decimation.json")
DOCUMENT = ROOT / "docs" / "decimation.md"

LIBRARIES = (
    "vtk", "pymeshlab", "meshlib", "fast-simplification", "manifold3d", "matplotlib"
)  # fmt: skip

DRAWN = {"FOGRA39L": "levels-fogra39l", "phone": "levels-phone", "sRGB": "levels-srgb"}
"""Devices whose levels are drawn, and the names of their pictures."""


def main() -> int:
    """Measure, draw and update the document."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--document", action="store_true", help="only make tables and plots")
    parser.add_argument(
        "--keep-peers", action="store_true", help="keep the stored figures of other libraries"
    )
    parser.add_argument(
        "--times", action="store_true", help="measure times and memory again, keep the rest"
    )
    arguments = parser.parse_args()
    if not arguments.document:
        if sys.platform == "linux":
            os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # the figures are for one core
        if absent := peers.missing():
            print(f"Not installed, so not measured: {', '.join(absent)}")
        compile_kernels()
        if arguments.times:
            results = with_times(json.loads(RESULTS.read_text()))
        else:
            stored = json.loads(RESULTS.read_text()) if arguments.keep_peers else {}
            results = measure(stored)
            draw_pictures(costs_by_accuracy(results))
        RESULTS.write_text(json_text(results))
    results = json.loads(RESULTS.read_text())
    plots.write(results)
    update_document(DOCUMENT, decimation_tables.document_blocks(results))
    return 0


def measure(stored: dict[str, Any]) -> dict[str, Any]:
    """Return all figures, with those of other libraries from stored results if there are any."""
    measured = []
    for device in devices():
        print(f"{time.strftime('%H:%M:%S')} {device.name}", flush=True)
        measured.append(device_figures(device))
    if stored:
        peer_rows, peer_times = stored["peers"], [r for r in stored["history"] if "peer" in r]
    else:
        peer_rows = [row for device in devices() for row in peers.peer_rows(device)]
        peer_times = speed.peer_times()
    first, *_, last = devices()
    return {
        "machine": {**machine(), **library_versions(), "algorithm": ALGORITHM_VERSION},
        "costs": list(COSTS),
        "devices": [figures["device"] for figures in measured],
        "floors": [figures["floor"] for figures in measured],
        **{
            name: [row for figures in measured for row in figures[name]]
            for name in ("levels", "others", "voxels")
        },
        "peers": peer_rows,
        "disagreement": max(figures["disagreement"] for figures in measured),
        "sphere": paper.sphere_rows(),
        "history": [*speed.history_times(15), *peer_times],
        "storage": speed.storage(25),
        "few": speed.few_triangles(7),
        "scaling": speed.scaling(3),
        "limits": [*limits.limit_rows(first), *limits.limit_rows(last)],
    }


def with_times(stored: dict[str, Any]) -> dict[str, Any]:
    """Return stored figures with new times and memory, measured when the machine is quiet."""
    for device, figures in zip(devices(), stored["devices"], strict=True):
        print(f"{time.strftime('%H:%M:%S')} {device.name}", flush=True)
        times = speed.shortest_times(device.boundary, 5, processes=3)
        figures["histories"] = speed.with_memory(device.boundary, times)
    return {
        **stored,
        "machine": {**machine(), **library_versions(), "algorithm": ALGORITHM_VERSION},
        "history": [*speed.history_times(15), *speed.peer_times()],
        "storage": speed.storage(25),
        "few": speed.few_triangles(7),
        "scaling": speed.scaling(3),
    }


def device_figures(device: Device) -> dict[str, Any]:
    """Return all figures of one device."""
    mesh, centre = device.boundary.mesh, device.boundary.centre
    histories, times = speed.timed_histories(device.boundary, 5)
    levels = peers.level_rows(device, histories, paper.CURVE_COUNTS)
    return {
        "device": {
            "name": device.name,
            "kind": device.kind,
            "points": len(device.points),
            "triangles": mesh.triangles,
            "volume": mesh.volume,
            "histories": speed.with_memory(device.boundary, times),
        },
        "levels": levels,
        "others": paper.other_rows(device, histories),
        "floor": paper.floor_row(device),
        "voxels": paper.voxel_rows(device, histories["quadric"]),
        "disagreement": max(
            disagreement(mesh, history.level(count), centre)
            for history in histories.values()
            for count in (1000, 50)
        ),
    }


def draw_pictures(costs: list[str]) -> None:
    """Draw levels of three devices with the default cost, and one device by all methods."""
    for device in devices():
        if device.name in DRAWN:
            history = build_mesh_history(device.boundary.mesh, device.boundary.centre)
            levels_picture(device, history, DRAWN[device.name])
    device = devices()[0]
    points, centre = device.points, device.boundary.centre
    by_usv = usv(points, "icosahedron", 1, 0.05, centre).mesh
    count = by_usv.triangles
    methods_picture(
        device,
        [
            ("reference", device.boundary.mesh),
            ("convex hull", modified_convex_hull(points, 1.0, centre).mesh),
            ("segment maxima", segment_maxima(points, (6, 13), centre).mesh),
            ("USV, icosahedron", by_usv),
            ("subsampled modified hull", paper.subsampled(points, centre, count).mesh),
            *((f"decimation, {cost}", device.histories[cost].level(count)) for cost in costs),
        ],
        "methods-fogra39l",
        4,
    )


def library_versions() -> dict[str, str]:
    """Return the versions of the installed libraries that are compared."""
    versions = {}
    for name in LIBRARIES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            continue
    return versions


def json_text(results: dict[str, Any]) -> str:
    """Format results as JSON: a table row per line, numbers to six significant digits."""

    def rounded(value: Any) -> Any:  # noqa: ANN401  # any JSON value
        if isinstance(value, float):
            return float(f"{value:.6g}")
        if isinstance(value, dict):
            return {name: rounded(each) for name, each in value.items()}
        return [rounded(each) for each in value] if isinstance(value, list) else value

    parts = []
    for name, value in rounded(results).items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = ",\n  ".join(json.dumps(row, ensure_ascii=False) for row in value)
            parts.append(f"{json.dumps(name)}: [\n  {rows}\n ]")
        else:
            parts.append(f"{json.dumps(name)}: {json.dumps(value, ensure_ascii=False)}")
    return "{\n " + ",\n ".join(parts) + "\n}\n"


if __name__ == "__main__":
    raise SystemExit(main())
