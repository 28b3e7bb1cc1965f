"""The pictures of the documentation: gamuts at several triangle counts, in their own colours.

Needs the optional group ``plots`` (matplotlib). The publication's Figure 7 has one gamut at 10,000
to 10 triangles; so has each picture here, the same view for all of its panels.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from benchmarks.devices import Device, exact_mismatch
from benchmarks.raster import View, picture
from gamutcore.history import History
from gamutcore.mesh import TriangleMesh

__all__ = ["LEVELS", "PICTURES", "levels_picture", "methods_picture"]

PICTURES = Path(__file__).parent.parent / "docs" / "pictures"

LEVELS = (10_000, 1000, 500, 100, 50, 10)
"""Triangle counts of the publication's Figure 7."""

INK = "#1a1a1a"
PALE = "#5a5a5a"


def percent(part: float) -> str:
    """Write a small part as a percentage with two or three significant digits."""
    value = 100 * part
    return f"{value:.0f} %" if value >= 10 else f"{value:.2g} %"


def levels_picture(device: Device, history: History, name: str) -> Path:
    """Draw a gamut at the triangle counts of the publication's Figure 7.

    Parameters
    ----------
    device : Device
    history : History
    name : str
        File name without folder and suffix.

    Returns
    -------
    Path
        The PNG that was written.
    """
    full = device.boundary.mesh
    panels = []
    for count in LEVELS:
        level = history.level(count)
        error = exact_mismatch(full, level, device.boundary.centre)
        panels.append((f"{count:,} triangles", f"mismatch {percent(error or 0.0)}", level))
    return _panels(panels, View(full), name, 3)


def methods_picture(
    device: Device, panels: list[tuple[str, TriangleMesh]], name: str, columns: int
) -> Path:
    """Draw what several methods make of one gamut, with their mismatches.

    Parameters
    ----------
    device : Device
    panels : list of (title, TriangleMesh)
    name : str
        File name without folder and suffix.
    columns : int

    Returns
    -------
    Path
        The PNG that was written.
    """
    full = device.boundary.mesh
    titled = []
    for title, mesh in panels:
        error = exact_mismatch(full, mesh, device.boundary.centre)
        shown = "" if mesh is full else f", mismatch {percent(error or 0.0)}"
        titled.append((title, f"{mesh.triangles:,} triangles{shown}", mesh))
    return _panels(titled, View(full, width=340), name, columns)


def _panels(
    panels: list[tuple[str, str, TriangleMesh]], view: View, name: str, columns: int
) -> Path:
    from matplotlib.figure import Figure
    from PIL import Image

    rows = -(-len(panels) // columns)
    above = 50  # pixels for the two lines of text
    wide, high = columns * view.width, rows * (view.height + above)
    figure = Figure(figsize=(wide / 100, high / 100), dpi=100, facecolor="white")
    for index, (title, subtitle, mesh) in enumerate(panels):
        row, column = divmod(index, columns)
        left, top = column * view.width, high - row * (view.height + above)
        middle = (left + view.width / 2) / wide
        axes = figure.add_axes(
            (left / wide, (top - above - view.height) / high, 1 / columns, view.height / high)
        )
        axes.set_axis_off()
        axes.imshow(np.clip(picture(mesh, view), 0, 1), interpolation="nearest")
        for text, down, size, colour, weight in (
            (title, 8, 13, INK, "bold"),
            (subtitle, 31, 11, PALE, "normal"),
        ):
            figure.text(
                middle,
                (top - down) / high,
                text,
                ha="center",
                va="top",
                size=size,
                color=colour,
                weight=weight,
            )
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100)
    image = Image.open(buffer).convert("RGB")
    PICTURES.mkdir(exist_ok=True)
    path = PICTURES / f"{name}.png"
    # 256 colours, dithered with the palette made beforehand: a third of the size
    palette = image.quantize(256, method=Image.Quantize.MEDIANCUT)
    small = image.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)
    colours = small.getpalette() or []
    paper = 3 * int(small.getpixel((0, 0)))  # type: ignore[arg-type]  # of a palette's picture
    small.putpalette([*colours[:paper], 255, 255, 255, *colours[paper + 3 :]])
    small.save(path, optimize=True)
    return path
