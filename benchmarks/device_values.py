"""Measurements of the device values at vertices: whether they make the colours, what they take.

The difference between the colour at each vertex of a level and the one that the device model
predicts for the values kept there, and the size of the values in a history file.
"""

from __future__ import annotations

import functools
import time
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from benchmarks.compute import FOGRA39L, ROOT, SRGB
from gamutcore.characterisation import IccProfile, Samples, characterisation
from gamutcore.colours.device.scattered_model import scattered_model
from gamutcore.colours.measured_colours import measured_colours
from gamutcore.colours.profile_colours import profile_colours
from gamutcore.gamut import Gamut, Options, build_gamut
from gamutcore.history import History, history_bytes, history_from_bytes

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from gamutcore.arrays import FloatArray
    from gamutcore.device_values import DeviceValues

__all__ = ["device_value_figures"]

COUNTS = (100, 300, 1000, 10_000, 40_000)
P3 = ROOT / "tests" / "data" / "DisplayP3-v4.icc"


def device_model(path: Path) -> Callable[[FloatArray], FloatArray]:
    """From device values to CIELAB, media-relative."""
    device = characterisation(path.read_bytes())
    if isinstance(device, IccProfile):
        return lambda values: profile_colours(device, values, "relative").lab
    if not isinstance(device, Samples):
        raise TypeError(f"{path.name} is neither a profile nor measurements")
    lab = measured_colours(device, "relative").lab
    given = cast("FloatArray", device.device)
    values, which, counts = np.unique(given, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(values), 3))
    np.add.at(sums, which.reshape(-1), lab)
    return scattered_model(values, sums / counts[:, np.newaxis]).colours


def differences(gamut: Gamut, model: Callable[[FloatArray], FloatArray], count: int) -> FloatArray:
    """ΔE*ab between kept and predicted colours at the vertices of a level."""
    level = gamut.level(count)
    predicted = model(cast("DeviceValues", level.device).values.astype(np.float64))
    distances: FloatArray = np.linalg.norm(predicted - level.vertices, axis=1)
    return distances


def milliseconds(function: Callable[[], object], runs: int = 7) -> float:
    """Shortest time of a call."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)


def _geometry_unpacked(data: bytes) -> object:
    return history_from_bytes(data)[0].full()


def _all_unpacked(data: bytes) -> object:
    history, _ = history_from_bytes(data)
    history.full()
    return history.device_values(history.triangles)


def device_value_figures() -> list[dict[str, Any]]:
    """Differences at several levels, as mean and largest, and sizes in a history file."""
    rows = []
    for name, path, cost in (
        ("FOGRA39L", FOGRA39L, "volume"),
        ("FOGRA39L", FOGRA39L, "finest"),
        ("sRGB", SRGB, "volume"),
        ("Display P3", P3, "volume"),
    ):
        gamut = build_gamut(path.read_bytes(), Options(cost=cost))
        history, model = gamut.history, device_model(path)
        row: dict[str, Any] = {"device": name, "cost": cost}
        for count in COUNTS:
            found = differences(gamut, model, count)
            row[f"ΔE at {count}"] = f"{found.mean():.3f} / {found.max():.2f}"
        geometry = history_bytes(History(history.splits, history.centre, history.step))
        data = history_bytes(history)
        row["geometry_bits"] = 8 * len(geometry) / history.vertices
        row["device_bits"] = 8 * (len(data) - len(geometry)) / history.vertices
        unpacked = milliseconds(functools.partial(_all_unpacked, data))
        row["unpacked_ms"] = unpacked - milliseconds(functools.partial(_geometry_unpacked, data))
        rows.append(row)
    return rows
