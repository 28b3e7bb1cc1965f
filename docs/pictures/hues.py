"""Draw docs/pictures/hues.png, and print the hue errors of docs/decisions/picture-space.md.

Run by ``make hues``, which takes a minute. Needs the extra ``docs``.
"""

from __future__ import annotations

import colorsys
import sys
import warnings
from collections import defaultdict
from pathlib import Path

import colour
import numpy as np
from matplotlib.figure import Figure

import gamutcore as gc
from gamutcore.arrays import FloatArray
from gamutcore.colours import adaptation_matrix, lab_to_xyz, white_point, xyz_to_lab
from gamutcore.colours.spaces import ColourConversion, ColourSpace

FOLDER = Path(__file__).parent
PRESS = FOLDER.parents[1] / "examples" / "FOGRA39L.ti3"

SPACES = ("CIELAB", "CAM16-UCS", "IPT", "Oklab", "Jzazbz", "CIELUV", "ICtCp", "DIN99o")
SHOWN = ("CIELAB", "CAM16-UCS")

FROM_C = adaptation_matrix(white_point("C"), white_point("D50"), "Bradford")
"""The renotation is for illuminant C."""

PERFECT = 102.57
"""Luminance of the perfect diffuser in the renotation, whose unit is magnesium oxide."""

SRGB = ColourConversion("sRGB", ColourSpace())
"""Between sRGB and CIELAB relative to D50."""


def loci() -> dict[tuple[str, float], FloatArray]:
    """Return XYZ relative to D50, in order of chroma, by hue and value of the real colours."""
    found = defaultdict(list)
    for (hue, value, chroma), (x, y, luminance) in colour.MUNSELL_COLOURS["real"]:
        found[hue, value].append((chroma, colour.xyY_to_XYZ([x, y, luminance / PERFECT])))
    return {
        key: np.array([xyz for _, xyz in sorted(row, key=lambda each: each[0])]) @ FROM_C.T
        for key, row in found.items()
    }


def hue_errors(space: ColourSpace, *, in_srgb: bool) -> tuple[float, float]:
    """Return the root mean square of hue angles about those of their loci: all, and 2.5PB–10PB."""
    every, blue = [], []
    for (hue, _), xyz in loci().items():
        if in_srgb:
            rgb = SRGB.from_gamut(xyz_to_lab(xyz))
            xyz = xyz[((rgb >= 0) & (rgb <= 1)).all(axis=1)]  # noqa: PLW2901
        if len(xyz) < 3:
            continue
        points, _ = space.from_tristimulus(xyz)
        angles = np.angle(points[:, 1] + 1j * points[:, 2])
        middle = np.angle(np.exp(1j * angles).mean())
        errors = np.degrees(np.angle(np.exp(1j * (angles - middle))))
        every.extend(errors)
        if hue.endswith("PB"):
            blue.extend(errors)
    return float(np.sqrt(np.mean(np.square(every)))), float(np.sqrt(np.mean(np.square(blue))))


def munsell_hues(lab: FloatArray) -> FloatArray:
    """Return hues of 100 steps; NaN where the renotation ends."""
    hues = []
    for row in colour.XYZ_to_xyY(lab_to_xyz(lab) @ np.linalg.inv(FROM_C).T):
        try:
            found = colour.notation.munsell.xyY_to_munsell_specification(row)
        except (RuntimeError, AssertionError, ValueError):
            hues.append(np.nan)
            continue
        hues.append(float(colour.notation.munsell.hue_to_ASTM_hue([found[0], found[3]])))
    return np.array(hues)


def print_table() -> None:
    """Print a row for each space."""
    rgb = np.array(
        [colorsys.hsv_to_rgb(hue / 360, full, 1) for full in (1, 0.8) for hue in range(0, 360, 15)]
    )
    lab = SRGB.to_gamut(rgb)
    before, blue = munsell_hues(lab), SRGB.to_gamut(np.array([[0.0, 0.0, 1.0]]))
    for name in SPACES:
        press = gc.Gamut(PRESS, surface_samples=20_000, space=name)
        after = munsell_hues(press.map(lab, space="CIELAB", max_error=0).points)
        steps = (after - before + 50) % 100 - 50
        found = press.map(blue, space="CIELAB", max_error=0).points
        cells = [f"{each:.2f}" for each in hue_errors(ColourSpace(name), in_srgb=False)]
        cells += [f"{each:.2f}" for each in hue_errors(ColourSpace(name), in_srgb=True)]
        cells += [f"{np.sqrt(np.nanmean(steps**2)):.2f}"]
        cells += [" ".join(str(round(255 * each)) for each in SRGB.from_gamut(found)[0])]
        sys.stdout.write(f"| {' | '.join([name, *cells])} |\n")


def draw() -> None:
    """Draw blues of sRGB, mapped into a press along the hues of two spaces."""
    hues, saturations = np.linspace(0.56, 0.76, 160), np.linspace(1, 0, 90)
    rgb = np.array([[colorsys.hsv_to_rgb(hue, full, 1) for hue in hues] for full in saturations])
    figure = Figure(figsize=(7.2, 1.9), facecolor="white", layout="constrained")
    panels = figure.subplots(1, 1 + len(SHOWN))
    panels[0].imshow(rgb)
    panels[0].set_title("picture")
    for axes, name in zip(panels[1:], SHOWN, strict=True):
        press = gc.Gamut(PRESS, surface_samples=20_000, space=name)
        axes.imshow(np.clip(press.map(rgb, space="sRGB", max_error=0).points, 0, 1))
        axes.set_title(f"hue of {name}")
    for axes in panels:
        axes.set_axis_off()
    figure.savefig(FOLDER / "hues.png", dpi=85, metadata={"Software": None})


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # colour-science warns of missing optional packages
    draw()
    print_table()
