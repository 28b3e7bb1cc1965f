"""Measure matches of many stored gamuts, and the matrix of their coverages.

``python -m benchmarks.matches`` runs by hand, for some minutes, and writes its figures to
``benchmarks/matches.json`` and into ``docs/benchmarks.md``. trimesh and SciPy answer for a few of
the same levels, and their times are scaled to all gamuts.
"""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.spatial import Delaunay

import gamutcore
from benchmarks.common import DOCUMENT, ROOT, FloatArray, Rows, resident_bytes
from benchmarks.markdown import rows_table, store
from gamutcore.gamut import load_level

RESULTS = Path(__file__).with_name("matches.json")

DEVICES = ("FOGRA39L.ti3", "FOGRA29L.ti3", "Panasonic-TV.icc")
"""Examples; every one is stored many times, and every file is read by itself."""

GAMUTS, COLOURS = 200, 2000

COMPARED = 40
"""Gamuts of the matrix that is measured; the time of 200 is by the number of pairs."""

PEER_GAMUTS = 3

CORES = 2


def main() -> None:
    """Measure, and write the tables."""
    random = np.random.default_rng(1)
    colours = random.uniform((10.0, -70.0, -70.0), (95.0, 70.0, 70.0), (COLOURS, 3))
    with tempfile.TemporaryDirectory() as folder:
        files = _stored(Path(folder))
        gamutcore.match(colours[:50], files[:2])  # compiles and warms
        rows = [
            _row("positions and ΔE76", 10, lambda: gamutcore.match(colours, files, delta_e=False)),
            _row("with ΔE00", 60, lambda: gamutcore.match(colours, files)),
            _matrix_row(files),
        ]
        peers = _peer_rows(colours, files, rows[0])
    results = {"matches": rows, "match-peers": peers}
    store(results, RESULTS, DOCUMENT, document_blocks(results))


def document_blocks(results: dict[str, Rows]) -> dict[str, str]:
    """Return the blocks of the document."""
    return {name: rows_table(rows) for name, rows in results.items()}


def _stored(folder: Path) -> list[Path]:
    """Return the files of stored gamuts with default options."""
    files: list[Path] = []
    for device in DEVICES:
        path = folder / f"{Path(device).stem}-0.gamut"
        gamutcore.Gamut(ROOT / "examples" / device).save(path)
        files.append(path)
    while len(files) < GAMUTS:
        source = files[len(files) % len(DEVICES)]
        copy = folder / f"{source.stem[:-2]}-{len(files)}.gamut"
        files.append(Path(shutil.copyfile(source, copy)))
    return files


def _row(question: str, goal: float, ask: Callable[[], Any], share: float = 1.0) -> dict[str, Any]:
    """Return the times of a question, of which a share is asked."""
    wall, processor = time.perf_counter(), time.process_time()
    ask()
    wall, processor = time.perf_counter() - wall, time.process_time() - processor
    return {
        "question": question,
        "goal, s": goal,
        f"processor, s ÷ {CORES}": processor / CORES / share,
        "clock, s": wall / share,
        "peak memory, MB": resident_bytes("VmHWM") / 1e6,
    }


def _matrix_row(files: list[Path]) -> dict[str, Any]:
    chosen = files[:COMPARED]
    share = COMPARED * (COMPARED - 1) / (GAMUTS * (GAMUTS - 1))
    question = f"coverage at 1,000 triangles, from {COMPARED} × {COMPARED}"
    return _row(question, 300, lambda: gamutcore.compare_all(chosen, triangles=1000), share)


def _peer_rows(colours: FloatArray, files: list[Path], own: dict[str, Any]) -> Rows:
    """Return the times of peers for positions, scaled to all gamuts."""
    ours = CORES * own[f"processor, s ÷ {CORES}"]
    meshes = []
    for path in files[:PEER_GAMUTS]:
        gamut, count = load_level(path)
        meshes.append(gamut.level(count).to_trimesh())
    peers: dict[str, tuple[str, Callable[[trimesh.Trimesh], Any]]] = {
        "trimesh, signed_distance": (
            "position and distance",
            lambda mesh: trimesh.proximity.signed_distance(mesh, colours),
        ),
        "trimesh, contains": ("in or out", lambda mesh: mesh.contains(colours)),
        "SciPy, Delaunay.find_simplex": (
            "in or out of the convex hull",
            lambda mesh: Delaunay(mesh.vertices).find_simplex(colours),
        ),
    }
    rows: Rows = [
        {
            "program": "gamut match",
            "answer": "position and distance, files read",
            "processor, s": ours,
            "ratio": 1.0,
        }
    ]
    for name, (answer, ask) in peers.items():
        start = time.process_time()
        for mesh in meshes:
            ask(mesh)
        seconds = (time.process_time() - start) * GAMUTS / len(meshes)
        rows.append(
            {"program": name, "answer": answer, "processor, s": seconds, "ratio": seconds / ours}
        )
    return rows


if __name__ == "__main__":
    main()
