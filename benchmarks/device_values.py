"""Accuracy and size of the device values at vertices.

Measures the difference between the colour of each vertex and the colour that the device model
predicts for the vertex's device values, and the size of the device values in a history file.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from benchmarks.common import FOGRA39L, ROOT, SRGB, times_of
from gamutcore import Gamut
from gamutcore.characterisation import IccProfile, Samples, characterisation
from gamutcore.colours.device.scattered_model import scattered_model
from gamutcore.colours.measured_colours import measured_colours
from gamutcore.colours.profile_colours import profile_colours
from gamutcore.history import History, history_bytes, history_from_bytes

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from gamutcore.arrays import FloatArray
    from gamutcore.mesh import DeviceValues

__all__ = ["device_value_figures"]

COUNTS = (100, 300, 1000, 10_000, 40_000)
P3 = ROOT / "tests" / "data" / "DisplayP3-v4.icc"


def device_model(path: Path) -> Callable[[FloatArray], FloatArray]:
    """Return the function from device values to media-relative CIELAB."""
    device = characterisation(path.read_bytes())
    if isinstance(device, IccProfile):
        return lambda values: profile_colours(device, values, "relative").lab
    if not isinstance(device, Samples):
        raise TypeError(f"{path.name} contains neither a profile nor measurements.")
    lab = measured_colours(device, "relative").lab
    given = cast("FloatArray", device.device)
    values, which, counts = np.unique(given, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(values), 3))
    np.add.at(sums, which.reshape(-1), lab)
    return scattered_model(values, sums / counts[:, np.newaxis]).colours


def differences(gamut: Gamut, model: Callable[[FloatArray], FloatArray], count: int) -> FloatArray:
    """Return ΔE*ab between stored and predicted colours at the vertices of a level."""
    level = gamut.level(count)
    predicted = model(cast("DeviceValues", level.device).values.astype(np.float64))
    distances: FloatArray = np.linalg.norm(predicted - level.vertices, axis=1)
    return distances


def _unpack_geometry(data: bytes) -> None:
    history_from_bytes(data)[0].full()


def _unpack_all(data: bytes) -> None:
    history, _ = history_from_bytes(data)
    history.full()
    history.device_values(history.triangles)


def device_value_figures() -> list[dict[str, Any]]:
    """Measure differences (mean / largest) at several levels, and sizes in bits per vertex."""
    rows = []
    for name, path, cost in (
        ("FOGRA39L", FOGRA39L, "volume"),
        ("FOGRA39L", FOGRA39L, "finest"),
        ("sRGB", SRGB, "volume"),
        ("Display P3", P3, "volume"),
    ):
        gamut = Gamut(path.read_bytes(), cost=cost)
        history, model = gamut.history, device_model(path)
        row: dict[str, Any] = {"device": name, "cost": cost}
        for count in COUNTS:
            found = differences(gamut, model, count)
            row[f"ΔE at {count}"] = f"{found.mean():.3f} / {found.max():.2f}"
        geometry = history_bytes(History(history.splits, history.centre, history.step))
        data = history_bytes(history)
        row["geometry_bits"] = 8 * len(geometry) / history.vertices
        row["device_bits"] = 8 * (len(data) - len(geometry)) / history.vertices
        everything, positions = (
            times_of(functools.partial(unpack, data), 7)[0]
            for unpack in (_unpack_all, _unpack_geometry)
        )
        row["unpacked_ms"] = 1e3 * (everything - positions)
        rows.append(row)
    return rows
