"""Test the intervals of volumes on a device whose truth is known.

``python -m benchmarks.intervals`` runs by hand. The truth is the fit of FOGRA39L. An experiment
takes some of its patches, always with the solids of ink and their overprints, adds noise to their
colours as measured, and asks for the interval of the volume. Each experiment is stored when it is
done, so a run goes on where the last one ended. The figures go to ``benchmarks/intervals.json`` and
into ``docs/uncertainty.md``.
"""

from __future__ import annotations

import argparse
import json
from math import sqrt
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from benchmarks.common import FOGRA39L, ROOT, FloatArray, Rows
from benchmarks.markdown import rows_table, update_document
from gamutcore.arrays import LongArray
from gamutcore.boundary import radial_map
from gamutcore.building import device_model
from gamutcore.colours import ICC_D50, DeviceModel, lab_to_xyz, xyz_to_lab
from gamutcore.colours.device_model import Fit, scattered_model
from gamutcore.colours.sampling import surface_values
from gamutcore.limits import Limits
from gamutcore.options import Options
from gamutcore.questions import conditions_of, uncertainty

DOCUMENT = ROOT / "docs" / "uncertainty.md"
RESULTS = Path(__file__).with_name("intervals.json")

CASES = ((100, 0.3), (400, 0.3), (1588, 0.3), (400, 1.0))
"""Numbers of patches, and noise in ΔE*ab."""

WHITE_LIGHTNESS = 95.0
"""L* of the paper of FOGRA39L. Noise is of colours as measured, which are relative to the paper."""

CENTRE = np.array([54.48, 4.72, 23.83])
"""A point in the middle of the gamut."""

SAMPLES, PIXELS = 20_000, 256
"""Points of the surface of the truth and the estimates, and rays: exact to 0.001 %."""


class Press:
    """The truth: the fit of FOGRA39L, its patches, and experiments with some of them."""

    def __init__(self, content: bytes) -> None:
        known = device_model(content, Options(), Limits())
        if known is None or not isinstance(known[0].function, Fit):
            raise TypeError("FOGRA39L has no fit.")
        self.model, self.fit = known[0], known[0].function.model
        self.patches = self.fit.centres
        self.colours = self.fit.colours(self.patches)
        solid = ((self.patches == 0.0) | (self.patches == 1.0)).all(axis=1)
        self.solids, self.others = np.flatnonzero(solid), np.flatnonzero(~solid)
        self.volume = self.volume_of(self.model)

    def volume_of(self, model: DeviceModel) -> float:
        """Return the volume of the device's surface."""
        surface = surface_values(model.limited, model.lab, SAMPLES)
        if surface.faces is None:
            raise TypeError("The device has too many channels.")
        radii = radial_map(model.lab(surface.device), surface.faces.corners, CENTRE, PIXELS)
        return float((radii**3).sum()) / 3.0 * (2.0 / PIXELS) ** 2

    def readings(self, rows: LongArray, noise: float, random: np.random.Generator) -> FloatArray:
        """Return colours of patches with noise, relative to the white among them."""
        axis = noise * 116.0 / (WHITE_LIGHTNESS + 16.0) / sqrt(3.0)
        lab = self.colours[rows] + random.normal(0.0, axis, (len(rows), 3))
        xyz = lab_to_xyz(lab)
        white = xyz[(self.patches[rows] == 0.0).all(axis=1)][0]
        return xyz_to_lab(xyz * (ICC_D50 / white))

    def experiment(self, patches: int, noise: float, seed: int) -> dict[str, Any]:
        """Return the errors of an estimate and of its interval, as shares of the true volume."""
        random = np.random.default_rng([patches, round(10 * noise), seed])
        chosen = random.choice(self.others, patches - len(self.solids), replace=False)
        rows = np.sort(np.append(self.solids, chosen))
        fit = scattered_model(self.patches[rows], self.readings(rows, noise, random))
        model = DeviceModel(
            self.model.channels, True, self.model.limited, Fit(fit, np.ones(4, bool))
        )
        volume = self.volume_of(model)
        found = uncertainty(measured_gamut(model, volume), noise)
        low, value, high = found.volume.low, found.volume.value, found.volume.high
        return {
            "patches": patches,
            "noise": noise,
            "seed": seed,
            "uncorrected": volume / self.volume - 1.0,
            "estimate": value / self.volume - 1.0,
            "low": low / self.volume - 1.0,
            "high": high / self.volume - 1.0,
            "parts": [found.relative.noise, found.relative.patches],
        }


def measured_gamut(model: DeviceModel, volume: float) -> SimpleNamespace:
    """Return what `uncertainty` needs of a gamut, without a decimation."""
    description = {
        "options": Options().to_mapping(),
        "volume": volume,
        "provenance": {
            "channels": list(model.channels),
            "intent": "relative",
            "medium": "reflective",
            "white_lab": [WHITE_LIGHTNESS, 0.0, -2.0],
            "patches": {"used": 0},
            "model": {"name": "radial basis functions"},
            "boundary": {"method": "device-surface"},
        },
    }
    return SimpleNamespace(
        description=description,
        conditions=conditions_of(description),
        options=Options(),
        colour_space=Options().colour_space(None),
        device_model=model,
        history=SimpleNamespace(centre=CENTRE),
    )


def case_row(experiments: Rows) -> dict[str, Any]:
    """Return the figures of the experiments of one case."""
    column = {
        name: np.array([one[name] for one in experiments])
        for name in ("uncorrected", "estimate", "low", "high")
    }
    right = int(((column["low"] <= 0.0) & (column["high"] >= 0.0)).sum())
    central = float(np.diff(np.percentile(column["estimate"], [2.5, 97.5]))[0])
    width = float((column["high"] - column["low"]).mean())

    def percent(values: FloatArray) -> str:
        return f"{100.0 * values.mean():+.2f} ± {100.0 * values.std(ddof=1):.2f}"

    return {
        "patches": experiments[0]["patches"],
        "noise, ΔE": experiments[0]["noise"],
        "volume, % of truth": percent(column["uncorrected"]),
        "corrected, %": percent(column["estimate"]),
        "interval, ± %": f"{50.0 * width:.2f}",
        "contains the truth": f"{right} of {len(experiments)}",
        "width ÷ central 95 %": f"{width / central:.2f}",
    }


def document_blocks(experiments: Rows) -> dict[str, str]:
    """Return the generated block of the document."""
    rows = []
    for patches, noise in CASES:
        case = [one for one in experiments if (one["patches"], one["noise"]) == (patches, noise)]
        if len(case) > 1:
            rows.append(case_row(case))
    return {"intervals": rows_table(rows)}


def main() -> None:
    """Run the experiments that are missing, store each, and update the document."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.intervals", description=__doc__)
    parser.add_argument("--experiments", type=int, default=60, help="Number for each case.")
    count = parser.parse_args().experiments
    experiments: Rows = json.loads(RESULTS.read_text()) if RESULTS.exists() else []
    done = {(one["patches"], one["noise"], one["seed"]) for one in experiments}
    press = Press(FOGRA39L.read_bytes())
    for seed in range(count):
        for patches, noise in CASES:
            if (patches, noise, seed) in done:
                continue
            experiments.append(press.experiment(patches, noise, seed))
            text = ",\n".join(json.dumps(one) for one in experiments)
            RESULTS.write_text(f"[\n{text}\n]\n")
            print(json.dumps(experiments[-1]), flush=True)
    update_document(DOCUMENT, document_blocks(experiments))


if __name__ == "__main__":
    main()
