"""Draw docs/pictures/chromaticity.svg: a display beside the standards, in both diagrams.

Run by ``make chromaticity``. Needs the extra ``docs``.
"""

from __future__ import annotations

from pathlib import Path

import colour
import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import gamutcore as gc
from gamutcore.results import ChromaticityGamut
from gamutcore.search import CHROMATICITY_STANDARDS

FOLDER = Path(__file__).parent
DISPLAY = FOLDER.parents[1] / "examples" / "Panasonic-TV.icc"

LABELS = {"xy": ("CIE 1931", "x", "y"), "uv": ("CIE 1976", "u′", "v′")}

STYLES = {"bt709": ":", "display-p3": "--", "bt2020": "-."}


def locus() -> ChromaticityGamut:
    """Return the spectrum locus of the CIE 1931 observer."""
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    xyz = observer[np.arange(400.0, 700.0, 2.0)]
    return ChromaticityGamut(xyz[:, :2] / xyz.sum(axis=1, keepdims=True), "colours")


def closed(corners: np.ndarray) -> np.ndarray:
    """Return the columns of a polygon with its first corner at the end."""
    return np.vstack([corners, corners[:1]]).T


def main() -> None:
    """Draw the picture."""
    mpl.rcParams["svg.hashsalt"] = "chromaticity"  # the same ids in every run
    display = gc.Gamut(DISPLAY, source="measurements", surface_samples=5000).chromaticity()
    if display is None:
        raise SystemExit("The display has no chromaticities.")
    figure = Figure(figsize=(8, 4.2), layout="constrained")
    for axes, (diagram, (name, across, upwards)) in zip(
        figure.subplots(1, 2), LABELS.items(), strict=True
    ):
        axes.plot(*closed(getattr(locus(), diagram)), color="0.7", lw=1)
        axes.fill(*getattr(display, diagram).T, color="tab:blue", alpha=0.25, label="display")
        for slug, style in STYLES.items():
            standard = CHROMATICITY_STANDARDS[slug]
            covered = getattr(display.compare(standard), diagram).a_covers_b
            corners = closed(getattr(standard, diagram))
            axes.plot(*corners, style, color="k", lw=1, label=f"{slug}: {covered:.1%} covered")
        axes.set(title=f"{name} {across}{upwards}", xlabel=across, ylabel=upwards, aspect="equal")
        axes.legend(loc="upper right" if diagram == "xy" else "lower right", fontsize="small")
    figure.savefig(FOLDER / "chromaticity.svg", metadata={"Date": None, "Creator": None})


if __name__ == "__main__":
    main()
