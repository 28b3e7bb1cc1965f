"""Pictures of gamuts at several triangle counts, in their own colours.

Needs the optional group ``plots`` (matplotlib). All panels of a picture have the same view.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.common import ROOT
from benchmarks.devices import Device, exact_mismatch
from benchmarks.raster import View, picture
from gamutcore.history import History
from gamutcore.mesh import TriangleMesh

__all__ = ["PICTURES", "levels_picture", "methods_picture"]

PICTURES = ROOT / "docs" / "pictures"

LEVELS = (10_000, 1000, 500, 100, 50, 10)
"""Triangle counts of Figure 7 of the publication."""

TEXT_HEIGHT = 50
"""Pixels for the two lines of text above a panel."""

Panel = tuple[str, str, TriangleMesh]
"""Title, subtitle, and mesh."""


def levels_picture(device: Device, history: History, name: str) -> Path:
    """Draw a gamut at the triangle counts of Figure 7 and return the PNG file."""
    full = device.boundary.mesh
    panels = [
        (f"{count:,} triangles", _mismatch_text(device, level), level)
        for count, level in ((count, history.level(count)) for count in LEVELS)
    ]
    return _write_panels(panels, View(full), name, 3)


def methods_picture(
    device: Device, meshes: list[tuple[str, TriangleMesh]], name: str, columns: int
) -> Path:
    """Draw the meshes that several methods make of one gamut and return the PNG file."""
    full = device.boundary.mesh
    panels = []
    for title, mesh in meshes:
        error = "" if mesh is full else f", {_mismatch_text(device, mesh)}"
        panels.append((title, f"{mesh.triangles:,} triangles{error}", mesh))
    return _write_panels(panels, View(full, width=340), name, columns)


def _mismatch_text(device: Device, mesh: TriangleMesh) -> str:
    error = 100 * (exact_mismatch(device.boundary.mesh, mesh, device.boundary.centre) or 0.0)
    return f"mismatch {error:.0f} %" if error >= 10 else f"mismatch {error:.2g} %"


def _write_panels(panels: list[Panel], view: View, name: str, columns: int) -> Path:
    from matplotlib.figure import Figure

    rows = -(-len(panels) // columns)
    height = view.height + TEXT_HEIGHT
    wide, high = columns * view.width, rows * height
    figure = Figure(figsize=(wide / 100, high / 100), dpi=100, facecolor="white")
    for index, (title, subtitle, mesh) in enumerate(panels):
        row, column = divmod(index, columns)
        top = high - row * height
        middle = (column + 0.5) / columns
        axes = figure.add_axes(
            (column / columns, (top - height) / high, 1 / columns, view.height / high)
        )
        axes.set_axis_off()
        axes.imshow(np.clip(picture(mesh, view), 0, 1), interpolation="nearest")
        centred: dict[str, Any] = {"ha": "center", "va": "top"}
        figure.text(
            middle, (top - 8) / high, title, size=13, color="#1a1a1a", weight="bold", **centred
        )
        figure.text(middle, (top - 31) / high, subtitle, size=11, color="#5a5a5a", **centred)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100)
    PICTURES.mkdir(exist_ok=True)
    path = PICTURES / f"{name}.png"
    _write_palette_png(buffer, path)
    return path


def _write_palette_png(buffer: io.BytesIO, path: Path) -> None:
    """Write a PNG with 256 dithered colours and a pure white background, a third of the size."""
    from PIL import Image

    image = Image.open(buffer).convert("RGB")
    palette = image.quantize(256, method=Image.Quantize.MEDIANCUT)
    small = image.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)
    colours = small.getpalette() or []
    paper = 3 * int(small.getpixel((0, 0)))  # type: ignore[arg-type]  # an index of the palette
    small.putpalette([*colours[:paper], 255, 255, 255, *colours[paper + 3 :]])
    small.save(path, optimize=True)
