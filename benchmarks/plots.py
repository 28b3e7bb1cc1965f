"""Plots of the documentation: mean mismatch, mismatch relative to the published cost, and times.

Needs the optional group ``plot`` (matplotlib). The colours are those of Okabe and Ito, which
colour-blind readers can distinguish, and every line has a marker of its own.
"""

from __future__ import annotations

from pathlib import Path
from statistics import mean
from typing import TYPE_CHECKING, Any

from benchmarks.paper import CURVE_COUNTS, SPHERE_LIMIT
from benchmarks.peers import COUNTS
from benchmarks.render import PICTURES
from benchmarks.speed import LEVEL
from benchmarks.summary import (
    PUBLISHED_COST,
    Results,
    best_peer,
    boundary_methods,
    costs_by_accuracy,
    error_ratios,
    level_errors,
    mean_errors,
)

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

__all__ = ["write"]

COST_STYLES = (
    {"color": "#0072B2", "marker": "o"},
    {"color": "#D55E00", "marker": "s"},
    {"color": "#009E73", "marker": "D"},
    {"color": "#CC79A7", "marker": "P"},
)
"""Styles of the costs, the least accurate first."""

METHOD_STYLES = {
    "USV, tetrahedron": {"color": "#56B4E9", "marker": "^"},
    "USV, octahedron": {"color": "#56B4E9", "marker": "v"},
    "USV, icosahedron": {"color": "#56B4E9", "marker": "h"},
    "segment maxima": {"color": "#E69F00", "marker": "X"},
    "subsampled modified hull": {"color": "#777777", "marker": "."},
    "convex hull": {"color": "#000000", "marker": "*"},
}

SETTINGS: dict[RcKeyType, str | float | bool] = {
    "svg.fonttype": "path",  # the same glyphs on every machine
    "svg.hashsalt": "gamut",  # the same file from the same figures
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#5a5a5a",
    "axes.labelcolor": "#1a1a1a",
    "axes.titlelocation": "left",
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "lines.markersize": 5,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
}


def write(results: Results, folder: Path = PICTURES) -> None:
    """Draw all plots as SVG files into a folder."""
    import matplotlib as mpl

    folder.mkdir(exist_ok=True)
    with mpl.rc_context(SETTINGS):
        for name, draw in (("mismatch", _mismatch), ("relative", _relative), ("times", _times)):
            draw(results).savefig(folder / f"{name}.svg", metadata={"Date": None})


def _figure(width: float, height: float) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), facecolor="white", layout="constrained")
    return figure, figure.add_subplot()


def _finish_curves(figure: Any, axes: Any, counts: tuple[int, ...]) -> None:  # noqa: ANN401
    axes.set_xscale("log")
    axes.set_xticks(counts, [f"{count:,}" for count in counts])
    axes.set_xticks([], minor=True)
    axes.set_xlabel("triangles")
    axes.grid(visible=True)
    axes.set_axisbelow(True)
    figure.legend(loc="outside right upper")


def _mismatch(results: Results) -> Any:  # noqa: ANN401  # a matplotlib figure
    """Mean mismatch by triangle count: Figure 8 of the publication."""
    figure, axes = _figure(9.6, 5.4)
    for method, sizes in boundary_methods(results).items():
        axes.plot(
            [row["triangles"] for row in sizes],
            [100 * row["mismatch"] for row in sizes],
            **METHOD_STYLES[method],
            linestyle="--",
            linewidth=1.1,
            label=method,
        )
    for cost, style in zip(costs_by_accuracy(results), COST_STYLES, strict=False):
        errors = mean_errors(results, cost, CURVE_COUNTS)
        means = [100 * (error or 0.0) for error in errors.values()]
        axes.plot(list(errors), means, **style, label=f"decimation, {cost}")
    least = [100 * SPHERE_LIMIT / count for count in CURVE_COUNTS]
    axes.plot(CURVE_COUNTS, least, color="#999999", lw=1, ls=":", label="optimum for a sphere")
    axes.set_yscale("log")
    axes.set_yticks([0.01, 0.1, 1, 10, 100], ["0.01", "0.1", "1", "10", "100"])
    axes.set_ylabel("mean mismatch, %")
    axes.set_title(f"Mismatch by triangle count, mean over {len(results['devices'])} devices")
    _finish_curves(figure, axes, (10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000))
    return figure


def _relative(results: Results) -> Any:  # noqa: ANN401  # a matplotlib figure
    """Mismatch ÷ mismatch of the published cost: costs and best peers, mean and range."""
    figure, axes = _figure(9.6, 4.4)
    counts = tuple(sorted(COUNTS))
    costs = costs_by_accuracy(results)
    curves = [
        (cost, style, [list(error_ratios(results, cost, count).values()) for count in counts])
        for cost, style in zip(costs, COST_STYLES, strict=False)
    ]
    peers = []
    for count in counts:
        published = level_errors(results, PUBLISHED_COST, count)
        best = {device: best_peer(results, device, count) for device in published}
        peers.append([found[1] / published[name] for name, found in best.items() if found])
    if all(peers):
        curves.append(("best other library", {"color": "#777777", "marker": "^"}, peers))
    for name, style, ratios in curves:
        lows, highs = [min(each) for each in ratios], [max(each) for each in ratios]
        axes.fill_between(counts, lows, highs, color=style["color"], alpha=0.13, linewidth=0)
        label = f"{name} (published)" if name == PUBLISHED_COST else name
        axes.plot(counts, [mean(each) for each in ratios], **style, label=label)
    axes.set_ylim(bottom=0)
    axes.set_ylabel("mismatch ÷ that of the published cost")
    axes.set_title("Relative to the published cost: mean and range over the devices")
    _finish_curves(figure, axes, counts)
    return figure


def _times(results: Results) -> Any:  # noqa: ANN401  # a matplotlib figure
    """Time of a complete history, and of one level from other libraries."""
    styles = dict(zip(costs_by_accuracy(results), COST_STYLES, strict=False))
    bars = []
    for row in results["history"]:
        if "cost" in row:
            bars.append(
                (row["seconds"], f"{row['cost']}: all levels", styles[row["cost"]]["color"])
            )
        else:
            reached = "one level" if row["level"] <= LEVEL else f"stalls at {row['level']:,}"
            bars.append((row["seconds"], f"{row['peer']}: {reached}", "#b0b0b0"))
    seconds, names, colours = zip(*sorted(bars, reverse=True), strict=True)
    figure, axes = _figure(9.6, 0.5 + 0.32 * len(bars))
    axes.bar_label(axes.barh(names, seconds, color=colours), fmt=" {:.2f} s")
    triangles = next(row["triangles"] for row in results["history"] if "triangles" in row)
    axes.set_title(f"sRGB, {triangles:,} triangles: time for all levels, or for one of {LEVEL:,}")
    axes.set_xticks([])
    axes.spines["bottom"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.margins(x=0.12)
    return figure
