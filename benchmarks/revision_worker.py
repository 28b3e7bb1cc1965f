"""Time the compute package of any revision; `benchmarks.revisions` starts this file in a clone.

Only `gamutcore` is imported, from the clone. Names that differ in older revisions are listed in
`FORMER_NAMES`. The worker prints the names of all operations when it is ready. For each name on
standard input it then times that operation, and prints the seconds.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["BUILDS", "OPERATIONS", "main"]

FORMER_NAMES = {"decimate": "decimated", "build_history": "history_of"}
"""Names before 2026-11-23."""

OPERATIONS = {
    "decimate": "decimation",
    "build_history": "history of a decimation",
    "build_device_history": "the same with device values of three channels",
    "write": "writing of a history file",
    "read": "reading of a complete history file",
    "level_100": "level of 100 triangles",
    "level_1000": "level of 1,000 triangles",
    "level_10000": "level of 10,000 triangles",
    "level_full": "full boundary",
    "error_curve": "error curve",
}
"""What is timed for a boundary, by the names of the figures."""

BUILDS = {
    "to_decimation": "characterisation to decimation",
    "build": "whole build",
}
"""What is timed for a characterisation, with the default options of each revision."""

SHORT_SECONDS = 0.02
"""An operation is repeated until it takes about so long."""


def main() -> None:
    """Time the operations that are named on standard input."""
    folder = Path(sys.argv[1])
    is_build = (folder / "characterisation").exists()
    operations = _builds(folder) if is_build else _operations(folder)
    repeats = {name: _repeats(operation) for name, operation in operations.items()}
    print(*operations, flush=True)
    for line in sys.stdin:
        name = line.strip()
        print(_seconds(operations[name], repeats[name]), flush=True)


def _operations(folder: Path) -> dict[str, Callable[[], object]]:
    """Return functions for the boundary and the history file in a folder."""
    decimate = _named("gamutcore.decimation", "decimate")
    build_history = _named("gamutcore.history", "build_history")
    history_bytes = _named("gamutcore.history", "history_bytes")
    history_from_bytes = _named("gamutcore.history", "history_from_bytes")
    error_curve = _named("gamutcore.metric.error_curve", "error_curve")
    curve_counts = _named("gamutcore.metric.error_curve", "curve_counts")
    triangle_mesh = _named("gamutcore.mesh", "TriangleMesh")

    with np.load(folder / "boundary.npz") as arrays:
        mesh = triangle_mesh(arrays["vertices"], arrays["faces"])
        centre, channels = arrays["centre"], arrays["channels"]
    decimation = decimate(mesh, centre)
    device = _named("gamutcore.history.device_history", "DeviceValues")(("1", "2", "3"), channels)
    # both revisions read and write the same history, whatever their decimations differ in
    file = folder / "history"
    if not file.exists():
        file.write_bytes(history_bytes(build_history(decimation, device)))
    data = file.read_bytes()
    history = history_from_bytes(data)[0]
    if history_bytes(history) != data:
        raise RuntimeError("A history that was read and written again has other bytes.")
    counts = curve_counts(history.triangles)

    def read() -> None:
        history_from_bytes(data)[0].unpack()

    return {
        "decimate": lambda: decimate(mesh, centre),
        "build_history": lambda: build_history(decimation),
        "build_device_history": lambda: build_history(decimation, device),
        "write": lambda: history_bytes(history),
        "read": read,
        "level_100": lambda: history.level(100),
        "level_1000": lambda: history.level(1000),
        "level_10000": lambda: history.level(10_000),
        "level_full": lambda: history.level(history.triangles),
        "error_curve": lambda: error_curve(history, counts),
    }


class _ReachedError(Exception):
    """A build has reached the stage after the decimation."""


def _builds(folder: Path) -> dict[str, Callable[[], object]]:
    """Return functions that build the gamut of the characterisation in a folder."""
    module = import_module("gamutcore.gamut")
    gamut_of = getattr(module, "build_gamut", module.Gamut)  # its name before the class built
    data = (folder / "characterisation").read_bytes()

    def stop(stage: str, _fraction: float) -> None:
        if stage in {"history", "metric"}:
            raise _ReachedError

    def to_decimation() -> None:
        with suppress(_ReachedError):
            gamut_of(data, progress=stop)

    return {"to_decimation": to_decimation, "build": lambda: gamut_of(data)}


def _named(module: str, name: str) -> Any:  # noqa: ANN401
    imported = import_module(module)
    former = FORMER_NAMES.get(name, name)
    return getattr(imported, former if hasattr(imported, former) else name)


def _repeats(operation: Callable[[], object]) -> int:
    """Return how often an operation runs in `SHORT_SECONDS`, after one call that warms up."""
    operation()
    return max(1, round(SHORT_SECONDS / max(_seconds(operation, 1), 1e-6)))


def _seconds(operation: Callable[[], object], repeats: int) -> float:
    """Return the processor time of one call."""
    start = time.process_time()
    for _ in range(repeats):
        operation()
    return (time.process_time() - start) / repeats


if __name__ == "__main__":
    main()
