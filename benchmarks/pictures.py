"""Pictures of docs/decimation.md: the mismatch by triangle count, and levels of a press.

`make figures` draws them, and ``python -m benchmarks.figures --only pictures`` draws them alone.
Needs the optional group ``plot`` (matplotlib).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.common import ROOT
from benchmarks.decimation_tables import COSTS, Results, mean_errors
from benchmarks.devices import devices
from gamutcore.colours.spaces import srgb

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

PICTURES = ROOT / "docs" / "pictures"

CURVE_COUNTS = (10_000, 5000, 2000, 1000, 500, 200, 100, 50, 20, 10)
"""Triangle counts of the curves."""

SPHERE_LIMIT = 12 * np.pi * (1 / (6 * 3**0.5) - 1 / (8 * np.pi))
"""Least mismatch × triangles on a sphere for many triangles: constants of Ludwig and Böröczky."""

LEVELS = (10_000, 1000, 500, 100, 50, 10)
"""Triangle counts of Figure 7 of the publication."""

STYLES = {
    "quadric": ("#0072B2", "o"),
    "volume": ("#D55E00", "s"),
    "finest": ("#009E73", "D"),
    "USV": ("#56B4E9", "h"),
    "segment maxima": ("#E69F00", "X"),
    "convex hull": ("#000000", "*"),
}
"""Colours of Okabe and Ito, which colour-blind readers can distinguish, and markers."""

SETTINGS: dict[RcKeyType, str | float | bool] = {
    "svg.fonttype": "path",  # the same glyphs on every machine
    "svg.hashsalt": "gamut",  # the same file from the same figures
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.markersize": 5,
}


def draw(results: Results) -> None:
    """Draw both pictures."""
    import matplotlib as mpl

    with mpl.rc_context(SETTINGS):
        plot_mismatch(results).savefig(PICTURES / "mismatch.svg", metadata={"Date": None})
        plot_levels().savefig(PICTURES / "levels-fogra39l.png", dpi=85)


def plot_mismatch(results: Results) -> Any:  # noqa: ANN401  # a matplotlib figure
    """Mean mismatch by triangle count: Figure 8 of the publication."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 5.4), facecolor="white", layout="constrained")
    axes = figure.add_subplot()
    for name, (colour, marker) in STYLES.items():
        style: dict[str, Any] = {"color": colour, "marker": marker}
        if name in COSTS:
            means = np.array(mean_errors(results, name, CURVE_COUNTS), float)
            axes.plot(CURVE_COUNTS, means, **style, label=f"decimation, {name}")
        else:
            rows = [row for row in results["others"] if row["method"] == name]
            counts, errors = [r["triangles"] for r in rows], [100 * r["mismatch"] for r in rows]
            axes.plot(counts, errors, **style, linestyle="--", linewidth=1.1, label=name)
    least = [100 * SPHERE_LIMIT / count for count in CURVE_COUNTS]
    axes.plot(CURVE_COUNTS, least, color="#999999", lw=1, ls=":", label="optimum for a sphere")
    axes.set(xscale="log", yscale="log", xlabel="triangles", ylabel="mean mismatch, %")
    axes.set_xticks(CURVE_COUNTS, [f"{count:,}" for count in CURVE_COUNTS])
    axes.set_xticks([], minor=True)
    axes.set_yticks([0.01, 0.1, 1, 10, 100], ["0.01", "0.1", "1", "10", "100"])
    axes.set_title(f"Mismatch by triangle count, mean over {len(results['devices'])} devices")
    axes.grid(visible=True, color="#e4e4e4", linewidth=0.6)
    axes.set_axisbelow(True)
    figure.legend(loc="outside right upper")
    return figure


def plot_levels() -> Any:  # noqa: ANN401  # a matplotlib figure
    """Levels of a press, each triangle in the colour of its middle."""
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    device = devices()[0]
    figure = Figure(figsize=(11.4, 7), facecolor="white", layout="constrained")
    for number, count in enumerate(LEVELS):
        mesh = device.histories["volume"].level(count)
        corners = mesh.vertices[mesh.faces]
        colours = srgb(corners.mean(axis=1))
        axes: Any = figure.add_subplot(2, 3, number + 1, projection="3d", elev=15, azim=-60)
        triangles = corners[..., [1, 2, 0]]  # lightness upwards
        axes.add_collection3d(
            Poly3DCollection(triangles, facecolors=colours, edgecolors="#222222", linewidths=0.15)
        )
        low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
        axes.auto_scale_xyz(*np.stack([low, high], axis=1))
        axes.set_box_aspect(high - low, zoom=1.35)
        axes.set_axis_off()
        error = 100 * (device.mismatch(mesh) or 0.0)
        axes.set_title(f"{mesh.triangles:,} triangles\nmismatch {error:.2g} %")
    return figure
