"""Draw docs/pictures/links.png and neutral-axis.png, and print the table of docs/links.md.

Run by ``make links``, which takes some minutes. Needs the extra ``docs``. All colours are those
that the tables of the links give.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import gamutcore as gc
from gamutcore.arrays import FloatArray
from gamutcore.colours.spaces import ColourConversion, ColourSpace
from gamutcore.questions import PICTURE_SPACE
from gamutcore.search import delta_e_2000

FOLDER = Path(__file__).parent
PRESS = FOLDER.parents[1] / "examples" / "FOGRA39L.ti3"

SAMPLES = {"surface_samples": 20_000}

METHODS: dict[str, dict[str, Any]] = {
    "clip-hue (default)": {},
    "clip-hue, no compensation": {"black_point_compensation": False},
    "clip-nearest": {"method": "clip-nearest"},
    "clip-lightness": {"method": "clip-lightness"},
    "clip-chroma": {"method": "clip-chroma"},
    "clip-focal": {"method": "clip-focal"},
    "sgck": {"method": "sgck"},
}

GREY = [(value,) * 3 for value in (0, 26, 51, 77, 128, 191, 255)]
SKIN = [(115, 82, 68), (194, 150, 130), (241, 194, 167)]
SKY = [(98, 122, 157), (135, 206, 235)]
PRIMARIES = [
    *((255, 0, 0), (0, 255, 0), (0, 0, 255)),
    *((0, 255, 255), (255, 0, 255), (255, 255, 0)),
]
PATCHES = np.array([*GREY, *SKIN, *SKY, *PRIMARIES]) / 255.0
"""Codes of the source. Skins and sky begin with those of the ColorChecker."""

GROUPS = {"grey": GREY, "skin": SKIN, "sky": SKY, "primaries": PRIMARIES}

LAB = ColourConversion("sRGB", ColourSpace())
"""Between sRGB and CIELAB relative to D50."""


def draw_patches(rows: dict[str, FloatArray], axes: Any) -> None:  # noqa: ANN401  # matplotlib's
    """Draw rows of colours (n, 3) in CIELAB, with gaps between the groups."""
    starts = np.cumsum([0, *(len(group) for group in GROUPS.values())])
    gap = np.repeat(np.arange(len(GROUPS)), np.diff(starts)) * 0.4
    for row, lab in enumerate(rows.values()):
        for place, colour in enumerate(np.clip(LAB.from_gamut(lab), 0.0, 1.0)):
            axes.barh(-row, 1.0, 0.86, place + gap[place], color=colour, ec="0.8", lw=0.4)
    for number, name in enumerate(GROUPS):
        middle = 0.5 * (starts[number] + starts[number + 1]) + 0.4 * number
        axes.text(middle, 0.6, name, ha="center", va="bottom")
    axes.set_yticks([-row for row in range(len(rows))], rows)
    axes.set_ylim(0.5 - len(rows), 1.1)
    axes.set_xticks([])
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)


def make_all() -> None:
    """Compute the links, draw their colours, and print the differences."""
    press = gc.Gamut(PRESS, space=PICTURE_SPACE, ink_limit=300, **SAMPLES)
    screens = {
        each: gc.reference(each, space=PICTURE_SPACE, **SAMPLES) for each in ("display-p3", "srgb")
    }
    pairs = {
        "sRGB to FOGRA39L": (screens["srgb"], press),
        "Display P3 to sRGB": (screens["display-p3"], screens["srgb"]),
    }
    figure = Figure(figsize=(9.0, 5.6), facecolor="white", layout="constrained")
    ramp = np.repeat(np.linspace(0.0, 1.0, 257)[:, np.newaxis], 3, axis=1)
    neutral = Figure(figsize=(4.6, 4.2), facecolor="white", layout="constrained")
    curves = neutral.subplots()
    for axes, (title, (source, destination)) in zip(
        figure.subplots(len(pairs), 1), pairs.items(), strict=True
    ):
        before = source.device_model.lab(PATCHES)
        rows = {"source": before}
        sys.stdout.write(f"\n{title}\n")
        for name, chosen in METHODS.items():
            link = gc.link(source, destination, **chosen)
            after = destination.device_model.lab(link.table.values(PATCHES))
            rows[name] = after
            difference, start = delta_e_2000(before, after), 0
            cells = []
            for group in GROUPS.values():
                part = difference[start : start + len(group)]
                cells.append(f"{part.mean():.1f} / {part.max():.1f}")
                start += len(group)
            cells += [f"{link.errors.mean:.2f}", f"{link.table_errors.mean:.2f}"]
            sys.stdout.write(f"| {' | '.join([name, *cells])} |\n")
            if destination is press and name in {*list(METHODS)[:2], "sgck"}:
                greys = destination.device_model.lab(link.table.values(ramp))
                curves.plot(source.device_model.lab(ramp)[:, 0], greys[:, 0], label=name)
        draw_patches(rows, axes)
        axes.set_title(title, loc="left")
    figure.savefig(FOLDER / "links.png", dpi=85, metadata={"Software": None})
    curves.axline((0, 0), slope=1, color="0.7", linewidth=0.8, zorder=0)
    curves.set(
        xlabel="L* of the screen's greys", ylabel="L* in print", xlim=(0, 100), ylim=(0, 100)
    )
    curves.legend(frameon=False)
    neutral.savefig(FOLDER / "neutral-axis.png", dpi=85, metadata={"Software": None})


if __name__ == "__main__":
    make_all()
