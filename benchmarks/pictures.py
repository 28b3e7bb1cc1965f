"""Pictures of docs/decimation.md: the mismatch by triangle count, and levels of a press.

`make figures` draws them, and ``python -m benchmarks.figures --only pictures`` draws them alone.
Needs the optional group ``plot`` (matplotlib).
"""

from __future__ import annotations

from statistics import mean
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from benchmarks.common import ROOT
from benchmarks.decimation_tables import COSTS, Results, mean_errors
from benchmarks.devices import devices
from gamutcore.colours.spaces import CIELAB
from gamutcore.export.rendering import VIEWS
from gamutcore.export.rendering.raster import rasterise
from gamutcore.export.rendering.scene import camera, scene_triangles
from gamutcore.mesh import TriangleMesh

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

PICTURES = ROOT / "docs" / "pictures"

CURVE_COUNTS = (10_000, 5000, 2000, 1000, 500, 200, 100, 50, 20, 10)
"""Triangle counts of the curves."""

SPHERE_LIMIT = 12 * np.pi * (1 / (6 * 3**0.5) - 1 / (8 * np.pi))
"""Least mismatch × triangles on a sphere for many triangles: constants of Ludwig and Böröczky."""

LEVELS = (10_000, 1000, 500, 100, 50, 10)
"""Triangle counts of Figure 7 of the publication."""

PANEL, TEXT = 380, 50
"""Pixels of a panel, and of the two lines of text above it."""

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
    """Draw all pictures."""
    import matplotlib as mpl

    with mpl.rc_context(SETTINGS):
        plot_mismatch(results).savefig(PICTURES / "mismatch.svg", metadata={"Date": None})
    draw_levels()


def plot_mismatch(results: Results) -> Any:  # noqa: ANN401  # a matplotlib figure
    """Mean mismatch by triangle count: Figure 8 of the publication."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 5.4), facecolor="white", layout="constrained")
    axes = figure.add_subplot()
    means = method_means(results)
    for name, (colour, marker) in STYLES.items():
        style: dict[str, Any] = {"color": colour, "marker": marker}
        if name in COSTS:
            errors = [100 * (error or 0) for error in mean_errors(results, name, CURVE_COUNTS)]
            axes.plot(CURVE_COUNTS, errors, **style, label=f"decimation, {name}")
        else:
            axes.plot(
                *zip(*means[name], strict=True), **style, linestyle="--", linewidth=1.1, label=name
            )
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


def method_means(results: Results) -> dict[str, list[tuple[float, float]]]:
    """Return mean triangle counts and mismatches in per cent of the other boundary methods.

    Sizes that fail on a device are left out.
    """
    groups: dict[tuple[str, int], list[Results]] = {}
    for row in results["others"]:
        groups.setdefault((row["method"], row["size"]), []).append(row)
    means: dict[str, list[tuple[float, float]]] = {}
    for (method, _), rows in groups.items():
        if len(rows) == len(results["devices"]):
            error = 100 * mean(row["mismatch"] for row in rows)
            means.setdefault(method, []).append((mean(row["triangles"] for row in rows), error))
    return means


def draw_levels() -> None:
    """Draw levels of a press side by side into a PNG file with 256 colours."""
    device, columns = devices()[0], 3
    rows = -(-len(LEVELS) // columns)
    sheet = Image.new("RGB", (columns * PANEL, rows * (PANEL + TEXT)), "white")
    brush = ImageDraw.Draw(sheet)
    for number, count in enumerate(LEVELS):
        mesh = device.histories["volume"].level(count)
        row, column = divmod(number, columns)
        left, top = column * PANEL, row * (PANEL + TEXT)
        sheet.paste(Image.fromarray(drawn(mesh)), (left, top + TEXT))
        error = 100 * (device.mismatch(mesh) or 0.0)
        lines = [f"{mesh.triangles:,} triangles", f"mismatch {error:.2g} %"]
        for text, height, size in zip(lines, (8, 29), (16, 13), strict=True):
            font = ImageFont.load_default(size)
            brush.text((left + PANEL / 2, top + height), text, "#333333", font, "ma")
    palette = sheet.quantize(256, method=Image.Quantize.MEDIANCUT)
    small = sheet.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)
    colours = np.array(small.getpalette()).reshape(-1, 3)
    colours[np.asarray(small)[0, 0]] = 255  # pure white paper
    small.putpalette(colours.ravel().tolist())
    small.save(PICTURES / "levels-fogra39l.png", optimize=True)


def drawn(mesh: TriangleMesh) -> np.ndarray:
    """Return a picture of a mesh and its edges, (size, size, 3) uint8.

    Edges are narrow strips just before the surface, narrower for low triangles.
    """
    surface = scene_triangles(mesh, CIELAB, camera(*VIEWS["standard"]), PANEL, axes=False)
    start, end = surface.corners, surface.corners[:, [1, 2, 0]]
    along = (end - start)[..., :2]
    length = np.linalg.norm(along, axis=2, keepdims=True)
    area = np.abs(np.cross(along[:, 0], along[:, 1]))[:, np.newaxis, np.newaxis]
    width = np.minimum(0.4, 0.08 * area / np.maximum(length.max(axis=1, keepdims=True), 1e-9))
    aside = np.dstack([along[..., ::-1] * (-1, 1) * width / np.maximum(length, 1e-9), -0 * length])
    lift = (0, 0, 1)
    strips = np.stack(
        [[start - aside, end - aside, end + aside], [start - aside, end + aside, start + aside]]
    )
    strips = strips.transpose(0, 2, 3, 1, 4).reshape(-1, 3, 3) + lift
    ink = np.full(strips.shape, 0.05, np.float32)
    light = rasterise(
        np.concatenate([surface.corners, strips]), np.concatenate([surface.colours, ink]), PANEL, 3
    )
    linear = light[..., :3] + (1 - light[..., 3:])  # on white
    pixels: np.ndarray = np.rint(255 * np.clip(linear, 0, 1) ** (1 / 2.2)).astype(np.uint8)
    return pixels
