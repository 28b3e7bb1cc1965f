"""Charts in SVG: a frame with two axes of the same scale, a grid, and layers of shapes and text.

The text of a chart depends on its data alone, so that the same data gives the same bytes.
"""

from __future__ import annotations

import base64
import math
import textwrap
import unicodedata
from collections.abc import Iterable, Sequence
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

from gamutcore.arrays import FloatArray
from gamutcore.export.png import png

__all__ = ["INK", "Chart", "plain_text", "rich_text"]

INK = "#222"
PLOT = 520.0
"""Longer side of the frame, in pixels of the picture."""

LEFT, RIGHT, TOP, BOTTOM = 74.0, 26.0, 62.0, 60.0
"""Margins around the frame."""

EDGE, LINE, CHARACTER = 14.0, 17.0, 7.0
"""Margin, height of a line and largest mean width of a character of the caption."""

SHORTEST = 180.0
"""Shorter side of the frame, at least."""

MOST_TICKS = 8
PADDING = 0.04
"""Room around the data ÷ longer side of the data."""

STYLE = (
    "text{font-family:Helvetica,Arial,'Liberation Sans',sans-serif;fill:#222}"
    ".tick{font-size:13px}.label{font-size:15px}.title{font-size:17px;font-weight:bold}"
    ".note{font-size:13px;fill:#555}"
)


class Chart:
    """A chart under construction.

    Parameters
    ----------
    low, high : (float, float)
        Smallest and largest coordinates of the data, (x, y).
    labels : (str, str)
        Of the axes, as for `rich_text`.
    title : str
    note : str, optional
        Second line of the title.
    caption : str, optional
        Below the axes, in as many lines as needed.
    """

    def __init__(
        self,
        low: Sequence[float],
        high: Sequence[float],
        labels: tuple[str, str],
        title: str,
        note: str = "",
        caption: str = "",
    ) -> None:
        spans = [max(high[axis] - low[axis], 0.0) for axis in range(2)]
        room = PADDING * max(*spans, 1e-9)
        least = (max(*spans, 1e-9) + 2.0 * room) * SHORTEST / PLOT
        sizes = [max(span + 2.0 * room, least) for span in spans]
        middles = [(low[axis] + high[axis]) / 2.0 for axis in range(2)]
        self.low = [middle - size / 2.0 for middle, size in zip(middles, sizes, strict=True)]
        self.high = [middle + size / 2.0 for middle, size in zip(middles, sizes, strict=True)]
        self.scale = PLOT / max(sizes)
        self.width, self.height = (size * self.scale for size in sizes)
        self._labels, self._title, self._note = labels, title, note
        columns = int((LEFT + self.width + RIGHT - 2.0 * EDGE) / CHARACTER)
        self._caption = textwrap.wrap(caption, columns)
        self._layers: list[str] = []
        self._definitions: list[str] = []

    def place(self, points: FloatArray) -> FloatArray:
        """Return the positions of points in the picture, (n, 2)."""
        return np.column_stack(
            [
                LEFT + (points[:, 0] - self.low[0]) * self.scale,
                TOP + (self.high[1] - points[:, 1]) * self.scale,
            ]
        )

    def path(self, polygons: Iterable[FloatArray]) -> str:
        """Return the outline of closed polygons as the value of the attribute ``d``."""
        parts = []
        for polygon in polygons:
            corners = " ".join(f"{x:.2f},{y:.2f}" for x, y in self.place(polygon).tolist())
            parts.append(f"M{corners}Z")
        return "".join(parts)

    def add(self, element: str) -> None:
        """Add an element on top of the others."""
        self._layers.append(element)

    def define(self, element: str) -> None:
        """Add an element that others refer to."""
        self._definitions.append(element)

    def add_polygons(self, polygons: Iterable[FloatArray], **attributes: str) -> None:
        """Draw closed polygons, with attributes such as ``stroke_width``."""
        path = self.path(polygons)
        if path:
            text = "".join(
                f' {name.replace("_", "-")}="{value}"' for name, value in attributes.items()
            )
            self.add(f'<path d="{path}"{text}/>')

    def add_text(self, point: Sequence[float], text: str) -> None:
        """Write text to the right of a point, with a white rim."""
        ((x, y),) = self.place(np.array([point], np.float64)).tolist()
        self.add(
            f'<text class="tick" x="{x:.1f}" y="{y:.1f}" dominant-baseline="middle" '
            f'stroke="#fff" stroke-width="3" stroke-linejoin="round" paint-order="stroke">'
            f"{plain_text(text)}</text>"
        )

    def add_image(self, pixels: NDArray[np.uint8], clip: str) -> None:
        """Fill the frame with a picture, (rows, columns, 3) from the top, cut out by a path."""
        data = base64.b64encode(png(pixels)).decode()
        self.define(f'<clipPath id="shape"><path clip-rule="evenodd" d="{clip}"/></clipPath>')
        self.add(
            f'<image x="{LEFT:g}" y="{TOP:g}" width="{self.width:.2f}" height="{self.height:.2f}" '
            f'preserveAspectRatio="none" clip-path="url(#shape)" '
            f'href="data:image/png;base64,{data}"/>'
        )

    def add_legend(self, entries: Sequence[tuple[str, str]]) -> None:
        """Draw lines and their meaning in the upper right corner: (attributes, text)."""
        right = LEFT + self.width
        for row, (line, text) in enumerate(entries):
            y = TOP + 18.0 + 19.0 * row
            x = right - 10.0
            self.add(
                f'<path d="M{x - 30:.1f},{y:.1f}h30" fill="none" {line}/>'
                f'<text class="note" x="{x - 38:.1f}" y="{y:.1f}" text-anchor="end" '
                f'dominant-baseline="middle" stroke="#fff" stroke-width="3" '
                f'paint-order="stroke">{plain_text(text)}</text>'
            )

    def svg(self) -> bytes:
        """Return the picture."""
        width, above = LEFT + self.width + RIGHT, TOP + self.height + BOTTOM
        height = above + LINE * len(self._caption)
        grid, ticks = self._axes()
        x_label, y_label = map(rich_text, self._labels)
        title, note = plain_text(self._title), plain_text(self._note)
        middle, centre = LEFT + self.width / 2.0, TOP + self.height / 2.0
        frame = f'x="{LEFT:g}" y="{TOP:g}" width="{self.width:.2f}" height="{self.height:.2f}"'
        size = f'viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" height="{height:.0f}"'
        across = f'x="{middle:.1f}" y="{above - 14:.1f}"'
        along = f'transform="translate(22,{centre:.1f}) rotate(-90)"'
        lines = [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">',
            f"<title>{title}</title>",
            f"<style>{STYLE}</style>",
            f"<defs>{''.join(self._definitions)}</defs>",
            '<rect width="100%" height="100%" fill="#fff"/>',
            f'<rect {frame} fill="#fafafa"/>',
            grid,
            *self._layers,
            f'<rect {frame} fill="none" stroke="#888"/>',
            ticks,
            f'<text class="title" x="{LEFT:g}" y="26">{title}</text>',
            f'<text class="note" x="{LEFT:g}" y="47">{note}</text>',
            f'<text class="label" {across} text-anchor="middle">{x_label}</text>',
            f'<text class="label" {along} text-anchor="middle">{y_label}</text>',
            *(
                f'<text class="note" x="{EDGE:g}" y="{above + LINE * row + 4:.1f}">'
                f"{plain_text(line)}</text>"
                for row, line in enumerate(self._caption)
            ),
            "</svg>",
        ]
        return ("\n".join(lines) + "\n").encode()

    def _axes(self) -> tuple[str, str]:
        """Return the grid, and the numbers at the axes."""
        step = _step(max(self.high[0] - self.low[0], self.high[1] - self.low[1]))
        bottom, right = TOP + self.height, LEFT + self.width
        grid, ticks = [], []
        for axis in range(2):
            first, last = math.ceil(self.low[axis] / step), math.floor(self.high[axis] / step)
            for number in range(first, last + 1):
                value = number * step
                stroke = "#aaa" if number == 0 else "#e2e2e2"
                text = f"{value:.10g}".replace("-", "\N{MINUS SIGN}")
                if axis == 0:
                    x = LEFT + (value - self.low[0]) * self.scale
                    grid.append(f'<path d="M{x:.2f},{TOP:g}V{bottom:.2f}" stroke="{stroke}"/>')
                    ticks.append(
                        f'<text class="tick" x="{x:.2f}" y="{bottom + 18:.1f}" '
                        f'text-anchor="middle">{text}</text>'
                    )
                else:
                    y = TOP + (self.high[1] - value) * self.scale
                    grid.append(f'<path d="M{LEFT:g},{y:.2f}H{right:.2f}" stroke="{stroke}"/>')
                    ticks.append(
                        f'<text class="tick" x="{LEFT - 8:g}" y="{y:.2f}" text-anchor="end" '
                        f'dominant-baseline="middle">{text}</text>'
                    )
        return "\n".join(grid), "\n".join(ticks)


def _step(span: float) -> float:
    """Return a round step with at most `MOST_TICKS` steps in a span."""
    power = 10.0 ** math.floor(math.log10(span / MOST_TICKS))
    return next(power * part for part in (1, 2, 5, 10, 20) if span / (power * part) <= MOST_TICKS)


def rich_text(text: str) -> str:
    """Return text for an SVG element; what follows ``_`` up to a space is a subscript.

    Examples
    --------
    >>> rich_text("a*_RSS <")
    'a*<tspan dy="4" font-size="70%">RSS</tspan><tspan dy="-4"> &lt;</tspan>'
    """
    before, mark, after = plain_text(text).partition("_")
    if not mark:
        return before
    below, space, rest = after.partition(" ")
    tail = f'<tspan dy="-4">{space}{rest}</tspan>' if space else ""
    return f'{before}<tspan dy="4" font-size="70%">{below}</tspan>{tail}'


def plain_text(text: str) -> str:
    """Return text for an SVG element, without the control characters that XML does not allow.

    Examples
    --------
    >>> plain_text("a & b" + chr(0))
    'a &amp; b'
    """
    return escape("".join(each for each in text if unicodedata.category(each)[0] != "C"))
