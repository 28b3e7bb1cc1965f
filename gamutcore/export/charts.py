"""Charts of sections as SVG: slices, hue leaves and rings, in the colours that they show.

A chart is a frame with two axes of the same scale, a grid, and layers of shapes and text. Its text
depends on its data alone, so the same data gives the same bytes. Colours outside sRGB are clipped.
"""

from __future__ import annotations

import base64
import math
import textwrap
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

from gamutcore.arrays import FloatArray
from gamutcore.colours.spaces import CIELAB, ColourSpace, srgb
from gamutcore.export.picture_file import png
from gamutcore.number_text import number_text

__all__ = [
    "Chart",
    "SectionAxes",
    "leaf_axes",
    "lightness_axes",
    "plain_text",
    "plane_axes",
    "rich_text",
    "ring_angles",
    "ring_bands",
    "ring_curves",
    "rings_note",
    "rings_svg",
    "section_pixels",
    "section_svg",
]

INK, NOTE, FRAME, GRID, ZERO, PAPER = "#222", "#555", "#888", "#e2e2e2", "#aaa", "#fafafa"
"""Text and lines, small text, frame, grid, grid at 0, and what is within the frame."""

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

SMALL, LABEL, TITLE = 13, 15, 17
"""Sizes of text, in pixels."""

STYLE = (
    f"text{{font-family:Helvetica,Arial,'Liberation Sans',sans-serif;fill:{INK}}}"
    f".tick{{font-size:{SMALL}px}}.label{{font-size:{LABEL}px}}"
    f".title{{font-size:{TITLE}px;font-weight:bold}}.note{{font-size:{SMALL}px;fill:{NOTE}}}"
)


class Chart:
    """A chart under construction, for data between the coordinates `low` and `high`, (x, y).

    `labels` are those of the axes, as for `rich_text`. `note` is a second line of the title, and
    `caption` is below the axes, in as many lines as needed.
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
        self._clip = ""

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
        self._clip = f'<clipPath id="shape"><path clip-rule="evenodd" d="{clip}"/></clipPath>'
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
            f"<defs>{self._clip}</defs>",
            '<rect width="100%" height="100%" fill="#fff"/>',
            f'<rect {frame} fill="{PAPER}"/>',
            grid,
            *self._layers,
            f'<rect {frame} fill="none" stroke="{FRAME}"/>',
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
                stroke = ZERO if number == 0 else GRID
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
    """Return text for an SVG element, without the control characters that XML does not allow."""
    return escape("".join(each for each in text if unicodedata.category(each)[0] != "C"))


RINGS_TITLE = "Gamut rings"

PIXELS = 160
"""Pixels along the longer side of a section's colours."""

WEDGES = 72
"""Parts of a band with the same colour, at most about this number."""

BAND_LIGHTNESS = (22.0, 88.0)
"""CIELAB lightness of the innermost and the outermost band: as in gamut-volume-m, near 20 to 90."""

BAND_CHROMA = 42.0
"""Chroma of the bands. Colours of this chroma are in sRGB at nearly all hues and lightnesses."""

SAMPLE_LIGHTNESS, SAMPLE_CHROMA = 0.5, 0.4
"""Of the colours whose CIELAB hues stand for hues of a space, times the lightness of its white.

With them the primary and secondary colours of sRGB keep their CIELAB hues within 10° in seven of
the ten spaces with a hue, and within 24° in all.
"""

DASHES = f'stroke="{INK}" stroke-width="1.6" stroke-dasharray="8 5"'
"""Line of a reference."""

DOTS = 'stroke="{}" stroke-width="1.2" stroke-dasharray="3 2"'
"""Line of an intersection."""


class SectionAxes(NamedTuple):
    """The plane of a section, and its axes in the picture.

    Attributes
    ----------
    origin : (3,) float64
        Where both axes are 0.
    right, up : (3,) float64
        Unit vectors of the axes.
    labels : (str, str)
    title : str
    """

    origin: FloatArray
    right: FloatArray
    up: FloatArray
    labels: tuple[str, str]
    title: str

    def flat(self, points: FloatArray) -> FloatArray:
        """Return the coordinates of points of the plane along both axes, (n, 2)."""
        return (points - self.origin) @ np.column_stack([self.right, self.up])


def lightness_axes(lightness: float, space: ColourSpace = CIELAB) -> SectionAxes:
    """Return the plane of a constant lightness."""
    upright = space.definition.lightness
    right, up = (axis for axis in range(3) if axis != upright)
    unit = np.eye(3)
    labels = (space.axes[right], space.axes[up])
    title = f"{space.axes[upright]} = {number_text(lightness)}"
    return SectionAxes(lightness * unit[upright], unit[right], unit[up], labels, title)


def leaf_axes(hue: float, space: ColourSpace = CIELAB) -> SectionAxes:
    """Return the half-plane of a hue in degrees: chroma to the right, lightness upwards."""
    angle = math.radians(hue)
    right = np.array([0.0, math.cos(angle), math.sin(angle)])
    chroma = "C*" if space.name in {"CIELAB", "CIELUV"} else "Chroma"
    labels = (chroma, space.axes[0])
    return SectionAxes(np.zeros(3), right, np.eye(3)[0], labels, f"Hue {hue:g}°")


def plane_axes(normal: FloatArray, offset: float, space: ColourSpace = CIELAB) -> SectionAxes:
    """Return axes for the plane normal · p = offset, as level and upright as possible."""
    names = space.axes
    length = float(np.linalg.norm(normal))
    unit = normal / length
    lightness = np.eye(3)[space.definition.lightness]
    # up is the direction in the plane of the steepest lightness
    up = lightness - unit[0] * unit
    if np.linalg.norm(up) < 1e-9:
        up = np.eye(3)[2] - unit[2] * unit
    up /= np.linalg.norm(up)
    right = np.cross(up, unit)
    terms = " + ".join(
        name if value == 1.0 else f"{value:g} {name}"
        for value, name in zip(normal.tolist(), names, strict=True)
        if value
    )
    labels = ("In the plane, across", "In the plane, along lightness")
    return SectionAxes(
        unit * offset / length, right, up, labels, f"{terms} = {number_text(offset)}"
    )


def section_svg(
    polygons: Sequence[FloatArray],
    axes: SectionAxes,
    space: ColourSpace = CIELAB,
    name: str = "",
    caption: str = "",
) -> bytes:
    """Return a picture of a section as SVG. The same arguments give the same bytes.

    Parameters
    ----------
    polygons : sequence of (m, 3) float64
        Closed, in the coordinates of `space`; those inside others are holes.
    axes : SectionAxes
    space : ColourSpace, optional
    name : str, optional
        Of the gamut.
    caption : str, optional
        Below the picture, such as the conditions of the gamut.

    Examples
    --------
    >>> square = np.array([(50, -9, -9), (50, 9, -9), (50, 9, 9), (50, -9, 9)], np.float64)
    >>> section_svg([square], lightness_axes(50), name="Square")[:19]
    b'<?xml version="1.0"'
    """
    flat = [axes.flat(each) for each in polygons]
    # the axes of colour spaces meet in neutral colours, which are always shown
    points = np.vstack([np.zeros((1, 2)), *flat])
    note = f"{name} · {space.name}" if name else space.name
    if not flat:
        note += " · empty"
        points = np.array([[-1.0, -1.0], [1.0, 1.0]])
    chart = Chart(points.min(axis=0), points.max(axis=0), axes.labels, axes.title, note, caption)
    if flat:
        chart.add_image(section_pixels(axes, space, chart.low, chart.high), chart.path(flat))
        chart.add_polygons(
            flat, fill="none", stroke=INK, stroke_width="1.5", stroke_linejoin="round"
        )
    return chart.svg()


def section_pixels(
    axes: SectionAxes, space: ColourSpace, low: Sequence[float], high: Sequence[float]
) -> NDArray[np.uint8]:
    """Return the colours of a section between two corners, (rows, columns, 3) from the top."""
    spans = [high[axis] - low[axis] for axis in range(2)]
    columns, rows = (max(1, round(PIXELS * span / max(spans))) for span in spans)
    across = low[0] + (np.arange(columns) + 0.5) / columns * spans[0]
    along = high[1] - (np.arange(rows) + 0.5) / rows * spans[1]
    x, y = np.meshgrid(across, along)
    colours = axes.origin + x[..., np.newaxis] * axes.right + y[..., np.newaxis] * axes.up
    return _pixels(colours.reshape(-1, 3), space).reshape(rows, columns, 3)


def _pixels(colours: FloatArray, space: ColourSpace) -> NDArray[np.uint8]:
    return np.rint(srgb(space.appearance_lab(colours)) * 255.0).astype(np.uint8)


def rings_svg(
    lightness: FloatArray,
    hues: FloatArray,
    radius: FloatArray,
    *,
    reference_radius: FloatArray | None = None,
    intersection_radius: FloatArray | None = None,
    names: tuple[str, str] = ("", "reference"),
    space: ColourSpace = CIELAB,
    volume: float | None = None,
    caption: str = "",
) -> bytes:
    """Return a picture of gamut rings as SVG. The same arguments give the same bytes.

    Parameters
    ----------
    lightness : (n,) float64
        Of the rings.
    hues : (s,) float64
        Middles of equal sectors, in degrees.
    radius : (n, s) float64
    reference_radius, intersection_radius : (n, s) float64, optional
        As in `gamutcore.results.GamutRings`. The reference is drawn as its outer ring, and the
        intersection within each band.
    names : (str, str), optional
        Of the gamut and of the reference.
    space : ColourSpace, optional
        Of the rings: the names of its axes, and the colours of its hues.
    volume : float, optional
        TabularRepr in the title.
    caption : str, optional
        Below the picture, such as the conditions of the gamuts.
    """
    angle, axes = ring_angles(hues), space.axes
    rings = ring_curves(radius, angle)
    outlines = [rings[-1]]
    if reference_radius is not None:
        outlines.append(ring_curves(reference_radius, angle)[-1])
    points = np.vstack([np.zeros((1, 2)), *outlines])
    chart = Chart(
        points.min(axis=0),
        points.max(axis=0),
        (f"{axes[1]}_RSS", f"{axes[2]}_RSS"),
        RINGS_TITLE,
        rings_note(names[0], volume),
        caption,
    )
    bands = "".join(
        f'<path d="{chart.path([outline])}" fill="#{red:02x}{green:02x}{blue:02x}"/>'
        for outline, (red, green, blue) in ring_bands(rings, angle, space)
    )
    chart.add(f'<g shape-rendering="crispEdges">{bands}</g>')
    outer, middle = len(rings) - 1, max(len(rings) // 2 - 1, 0)
    legend = []
    if reference_radius is not None:
        legend.append((DASHES, names[1]))
    if intersection_radius is not None:
        within = ring_curves(intersection_radius, angle)
        chart.add(f'<path d="{chart.path(within)}" fill="none" {DOTS.format("#fff")}/>')
        legend.append((DOTS.format("#999"), "intersection"))
    for number, ring in enumerate(rings):
        width = "1.8" if number == outer else "0.7"
        chart.add_polygons([ring], fill="none", stroke=INK, stroke_width=width)
    for outline in outlines[1:]:
        chart.add(f'<path d="{chart.path([outline])}" fill="none" {DASHES}/>')
    chart.add_legend(legend)
    ((x, y),) = chart.place(np.zeros((1, 2))).tolist()  # a cross where chroma is 0
    cross = f"M{x - 7:.1f},{y:.1f}h14M{x:.1f},{y - 7:.1f}v14"
    chart.add(f'<path d="{cross}" stroke="#fff" stroke-width="1.2"/>')
    # the labels are where they are farthest apart
    at = len(angle) // len(hues) * int(np.argmax(radius[outer] - radius[middle]))
    for number in sorted({0, middle, outer}):
        chart.add_text(rings[number][at].tolist(), f"{axes[0]} {number_text(lightness[number])}")
    return chart.svg()


def rings_note(name: str, volume: float | None) -> str:
    """Return the second line of the title: the name of the gamut, and its volume."""
    parts = [name] if name else []
    if volume is not None:
        figure = f"{volume:,.0f}" if volume >= 1000.0 else number_text(volume, 4)
        parts.append(f"volume {figure}".replace(",", "\N{NARROW NO-BREAK SPACE}"))
    return " · ".join(parts)


def ring_angles(hues: FloatArray) -> FloatArray:
    """Return the angles of the corners of rings; wide sectors are arcs of several corners."""
    times = max(1, -(-WEDGES // len(hues)))
    turn = 2.0 * np.pi / (len(hues) * times)
    places = np.arange(len(hues) * times) - (times - 1) / 2.0
    return np.asarray(np.radians(hues[0]) + turn * places, np.float64)


def ring_curves(radius: FloatArray, angle: FloatArray) -> list[FloatArray]:
    """Return the corners of closed curves with the radii of equal sectors."""
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    times = len(circle) // radius.shape[1]
    return [np.repeat(each, times)[:, np.newaxis] * circle for each in radius]


def ring_bands(
    rings: list[FloatArray], angle: FloatArray, space: ColourSpace
) -> Iterator[tuple[FloatArray, list[int]]]:
    """Yield the parts of the bands between rings, with the sRGB colours of their hues."""
    low, high = BAND_LIGHTNESS
    count = len(angle)
    width = max(1, count // WEDGES)
    wedges = range(0, count, width)
    shades = np.linspace(low, high, len(rings))
    middles = np.array([angle[(begin + min(begin + width, count) - 1) // 2] for begin in wedges])
    hues = SAMPLE_CHROMA * np.column_stack([np.cos(middles), np.sin(middles)])
    samples = np.column_stack([np.full(len(hues), SAMPLE_LIGHTNESS), hues]) * space.white_lightness
    opponent = np.asarray(space.appearance_lab(samples), np.float64)[:, 1:]
    opponent = opponent * BAND_CHROMA / np.linalg.norm(opponent, axis=1, keepdims=True)
    lab = np.array([(shade, *hue) for shade in shades for hue in opponent])
    colours = _pixels(lab, CIELAB).tolist()
    inner = np.zeros_like(rings[0])
    for band, ring in enumerate(rings):
        for wedge, begin in enumerate(wedges):
            at = np.arange(begin, min(begin + width, count) + 1) % count
            outline = np.vstack([ring[at], inner[at][::-1]])
            yield outline, colours[band * len(middles) + wedge]
        inner = ring
