"""The plots of the documentation, from the measurements: mean mismatches, ratios, times.

Needs the optional group ``plots`` (matplotlib). Colours are Okabe & Ito's, which colour-blind
readers tell apart; every line also has a marker of its own and its name beside it.
"""

from __future__ import annotations

from math import log
from pathlib import Path
from statistics import mean
from typing import TYPE_CHECKING, Any

from benchmarks.paper import CURVE_COUNTS, SPHERE_LIMIT
from benchmarks.peers import COUNTS
from benchmarks.speed import LEVEL
from benchmarks.summary import (
    Measured,
    best_peer,
    costs_by_accuracy,
    families,
    level_errors,
    mean_errors,
    ratios,
)

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

__all__ = ["PICTURES", "write"]

PICTURES = Path(__file__).parent.parent / "docs" / "pictures"

COST_STYLES = (
    {"color": "#0072B2", "marker": "o"},
    {"color": "#D55E00", "marker": "s"},
    {"color": "#009E73", "marker": "D"},
    {"color": "#CC79A7", "marker": "P"},
)
"""For the costs, the least accurate first."""

OTHER_STYLES = {
    "USV, tetrahedron": {"color": "#56B4E9", "marker": "^"},
    "USV, octahedron": {"color": "#56B4E9", "marker": "v"},
    "USV, icosahedron": {"color": "#56B4E9", "marker": "h"},
    "segment maxima": {"color": "#E69F00", "marker": "X"},
    "subsampled modified hull": {"color": "#777777", "marker": "."},
    "convex hull": {"color": "#000000", "marker": "*"},
}

SETTINGS: dict[RcKeyType, str | float] = {
    "svg.fonttype": "path",  # the same letters everywhere
    "svg.hashsalt": "gamut",  # the same file from the same figures
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#5a5a5a",
    "axes.labelcolor": "#1a1a1a",
    "axes.titlelocation": "left",
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "lines.linewidth": 1.6,
    "lines.markersize": 5,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
}


def write(measured: Measured, folder: Path = PICTURES) -> None:
    """Draw all plots as SVG files.

    Parameters
    ----------
    measured : dict
        The content of ``benchmarks/decimation.json``.
    folder : Path, optional
    """
    import matplotlib as mpl

    folder.mkdir(exist_ok=True)
    with mpl.rc_context(SETTINGS):
        for name, draw in (
            ("mismatch", _mismatch),
            ("relative", _relative),
            ("times", _times),
        ):
            draw(measured).savefig(folder / f"{name}.svg", metadata={"Date": None})


def _figure(width: float, height: float) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), facecolor="white", layout="constrained")
    return figure, figure.add_subplot()


def _logarithmic(axes: Any, counts: tuple[int, ...]) -> None:  # noqa: ANN401  # matplotlib's
    axes.set_xscale("log")
    axes.set_xticks(counts, [f"{count:,}" for count in counts])
    axes.set_xticks([], minor=True)
    axes.set_xlabel("triangles")
    axes.grid(visible=True)
    axes.set_axisbelow(True)


def _named(axes: Any, marks: list[tuple[float, str, str]], gap: float) -> None:  # noqa: ANN401
    """Write names at the right end of the lines, moved apart where they are closer than a gap.

    Parameters
    ----------
    marks : list of (height, name, colour)
        Heights as a part of the axes' height.
    gap : float
        Least distance, as a part of the axes' height.
    """
    groups: list[list[tuple[float, str, str]]] = []
    for mark in sorted(marks):
        groups.append([mark])
        # a group stands around the mean of its heights; groups that overlap become one
        while len(groups) > 1 and _middle(groups[-1]) - _middle(groups[-2]) < gap / 2 * (
            len(groups[-1]) + len(groups[-2])
        ):
            groups[-2:] = [groups[-2] + groups[-1]]
    for group in groups:
        for place, (_, name, colour) in enumerate(group):
            height = _middle(group) + gap * (place - (len(group) - 1) / 2)
            axes.text(
                1.015, height, name, transform=axes.transAxes, va="center", color=_darker(colour)
            )


def _middle(group: list[tuple[float, str, str]]) -> float:
    return mean(height for height, _, _ in group)


def _darker(colour: str) -> tuple[float, ...]:
    """A colour as text on white needs it."""
    from matplotlib.colors import to_rgb

    return tuple(0.72 * channel for channel in to_rgb(colour))


def _mismatch(measured: Measured) -> Any:  # noqa: ANN401  # a matplotlib figure
    """Mean mismatch by triangle count: the publication's Figure 8."""
    figure, axes = _figure(8.4, 5.6)
    ends = []
    for method, sizes in families(measured).items():
        if method not in OTHER_STYLES:
            continue
        across = [row["triangles"] for row in sizes]
        up = [100 * row["mismatch"] for row in sizes]
        axes.plot(across, up, **OTHER_STYLES[method], linestyle="--", linewidth=1.1)
        ends.append((up[-1], method, OTHER_STYLES[method]["color"]))
    for cost, style in zip(costs_by_accuracy(measured), COST_STYLES, strict=False):
        errors = mean_errors(measured, cost, CURVE_COUNTS)
        up = [100 * error for error in errors.values()]
        axes.plot(list(errors), up, **style)
        ends.append((up[0], f"decimation, {cost}", style["color"]))
    least = [100 * SPHERE_LIMIT / count for count in CURVE_COUNTS]
    axes.plot(CURVE_COUNTS, least, color="#999999", linewidth=1, linestyle=":")
    ends.append((least[0], "least for a sphere", "#777777"))
    axes.set_yscale("log")
    _logarithmic(axes, (10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000))
    axes.set_yticks([0.01, 0.1, 1, 10, 100], ["0.01", "0.1", "1", "10", "100"])
    axes.set_xlim(9, 16_000)
    axes.set_ylabel("mean mismatch, %")
    axes.set_title(f"Mismatch against triangle count, mean over {len(measured['devices'])} devices")
    low, high = axes.get_ylim()
    _named(
        axes,
        [(log(up / low) / log(high / low), name, colour) for up, name, colour in ends],
        0.045,
    )
    return figure


def _relative(measured: Measured) -> Any:  # noqa: ANN401  # a matplotlib figure
    """Mismatch relative to the published cost: costs and the best peers, mean and range."""
    figure, axes = _figure(8.4, 4.4)
    counts = tuple(sorted(COUNTS))
    costs = costs_by_accuracy(measured)
    drawn: list[tuple[str, dict[str, Any], list[list[float]]]] = []
    for cost, style in zip(costs[1:], COST_STYLES[1:], strict=False):
        drawn.append((cost, style, [list(ratios(measured, cost, n).values()) for n in counts]))
    names = [each["name"] for each in measured["devices"]]
    peers = []
    for count in counts:
        least = level_errors(measured, costs[0], count)
        found = {name: best_peer(measured, name, count) for name in names}
        peers.append([best[1] / least[name] for name, best in found.items() if best is not None])
    if all(peers):
        drawn.append(("best other library", {"color": "#777777", "marker": "^"}, peers))
    ends = []
    axes.axhline(1, color=COST_STYLES[0]["color"])
    ends.append((1.0, f"{costs[0]} (published)", COST_STYLES[0]["color"]))
    for name, style, values in drawn:
        middle = [mean(each) for each in values]
        axes.fill_between(
            counts, [min(each) for each in values], [max(each) for each in values],
            color=style["color"], alpha=0.13, linewidth=0,
        )  # fmt: skip
        axes.plot(counts, middle, **style)
        ends.append((middle[-1], name, style["color"]))
    _logarithmic(axes, counts)
    axes.set_xlim(9, 11_500)
    top = max(1.2, 1.03 * max(max(each) for _, _, values in drawn for each in values))
    axes.set_ylim(0, top)
    axes.set_ylabel("mismatch ÷ that of the published cost")
    axes.set_title("Against the published cost: mean and range over the devices")
    _named(axes, [(up / top, name, colour) for up, name, colour in ends], 0.06)
    return figure


def _reached(level: int) -> str:
    return "one level" if level <= LEVEL else f"stalls at {level:,}"


def _times(measured: Measured) -> Any:  # noqa: ANN401  # a matplotlib figure
    """Time of a complete history beside that of one level from other libraries."""
    costs = costs_by_accuracy(measured)
    styles = dict(zip(costs, COST_STYLES, strict=False))
    bars = [
        (f"{row['cost']}: all levels", row["seconds"], styles[row["cost"]]["color"])
        if "cost" in row
        else (f"{row['peer']}: {_reached(row['level'])}", row["seconds"], "#b0b0b0")
        for row in measured["history"]
    ]
    bars.sort(key=lambda bar: bar[1], reverse=True)
    figure, axes = _figure(8.4, 0.5 + 0.32 * len(bars))
    axes.barh([bar[0] for bar in bars], [bar[1] for bar in bars], color=[bar[2] for bar in bars])
    for place, bar in enumerate(bars):
        axes.text(bar[1], place, f" {bar[1]:.2f} s", va="center", color="#1a1a1a")
    triangles = next(row["triangles"] for row in measured["history"] if "triangles" in row)
    axes.set_title(f"sRGB, {triangles:,} triangles: time for all levels, and for one of {LEVEL:,}")
    axes.set_xticks([])
    axes.spines["bottom"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.margins(x=0.12)
    return figure
