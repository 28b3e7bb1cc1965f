"""Draw docs/pictures/intervals.svg from ``benchmarks/intervals.json``. Run by ``make intervals``.

Each dot is an experiment: its volume without correction, and corrected, beside the truth.
"""

from __future__ import annotations

import json
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

__all__ = ["draw_intervals"]

ROOT = Path(__file__).parents[2]

INK, BLUE, ORANGE = "#7c858f", "#2f86cc", "#d9711a"
"""As in ``concepts.py``: readable on light and dark pages."""

SETTINGS = {
    "svg.fonttype": "path",
    "svg.hashsalt": "gamut",
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": INK,
    "xtick.color": INK,
    "ytick.color": INK,
}


def draw_intervals() -> None:
    """Write the figure."""
    rows = json.loads((ROOT / "benchmarks" / "intervals.json").read_text())
    cases = sorted({(row["noise"], row["patches"]) for row in rows})
    with mpl.rc_context(SETTINGS):
        figure = Figure(figsize=(7, 3.4), layout="constrained")
        axes = figure.add_subplot()
        axes.axhline(0.0, color=INK, linewidth=0.8)
        for place, (noise, patches) in enumerate(cases):
            case = [row for row in rows if (row["noise"], row["patches"]) == (noise, patches)]
            for name, shift, colour in (("uncorrected", -0.16, BLUE), ("estimate", 0.16, ORANGE)):
                values = 100.0 * np.array([row[name] for row in case])
                scatter = np.random.default_rng(1).uniform(-0.1, 0.1, len(values))
                axes.plot(place + shift + scatter, values, ".", color=colour, markersize=4)
                axes.plot(place + shift, values.mean(), "_", color=colour, markersize=34, mew=2)
        labels = [f"{patches:,} patches\n{noise:g} ΔE" for noise, patches in cases]
        axes.set_xticks(range(len(cases)), labels)
        axes.set_ylabel("volume beside the truth, %")
        axes.plot([], [], ".", color=BLUE, label="as built")
        axes.plot([], [], ".", color=ORANGE, label="corrected")
        axes.legend(frameon=False, loc="upper left", ncols=2)
        axes.spines[["top", "right"]].set_visible(False)
        path = Path(__file__).with_name("intervals.svg")
        figure.savefig(path, transparent=True, metadata={"Date": None})


if __name__ == "__main__":
    draw_intervals()
