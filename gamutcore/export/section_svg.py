"""Pictures of sections as SVG: slices, hue leaves and rings, in the colours that they show.

Colours outside sRGB are clipped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gamutcore.arrays import FloatArray
from gamutcore.colours.spaces import CIELAB, ColourSpace, srgb
from gamutcore.export.svg_chart import INK, Chart

__all__ = ["SectionAxes", "leaf_axes", "lightness_axes", "plane_axes", "rings_svg", "section_svg"]

PIXELS = 160
"""Pixels along the longer side of a section's colours."""

WEDGES = 72
"""Parts of a band with the same colour, at most about this number."""

BAND_LIGHTNESS = (22.0, 88.0)
"""CIELAB lightness of the innermost and the outermost band: as in gamut-volume-m, near 20 to 90."""

BAND_CHROMA = 42.0
"""Chroma of the bands. Colours of this chroma are in sRGB at nearly all hues and lightnesses."""


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


def lightness_axes(lightness: float, space: ColourSpace = CIELAB) -> SectionAxes:
    """Return the plane of a constant lightness."""
    upright = space.definition.lightness
    right, up = (axis for axis in range(3) if axis != upright)
    unit = np.eye(3)
    labels = (space.axes[right], space.axes[up])
    title = f"{space.axes[upright]} = {lightness:g}"
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
    return SectionAxes(unit * offset / length, right, up, labels, f"{terms} = {offset:g}")


def section_svg(
    polygons: Sequence[FloatArray],
    axes: SectionAxes,
    space: ColourSpace = CIELAB,
    name: str = "",
    caption: str = "",
) -> bytes:
    """Return a picture of a section.

    Parameters
    ----------
    polygons : sequence of (m, 3) float64
        Closed; those inside others are holes.
    axes : SectionAxes
    space : ColourSpace, optional
        Of the coordinates.
    name : str, optional
        Of the gamut.
    caption : str, optional
        Below the picture, such as the conditions of the gamut.

    Returns
    -------
    bytes
        SVG. The same arguments give the same bytes.

    Examples
    --------
    >>> square = np.array([(50, -9, -9), (50, 9, -9), (50, 9, 9), (50, -9, 9)], np.float64)
    >>> section_svg([square], lightness_axes(50), name="Square")[:19]
    b'<?xml version="1.0"'
    """
    flat = [(each - axes.origin) @ np.column_stack([axes.right, axes.up]) for each in polygons]
    # the axes of colour spaces meet in neutral colours, which are always shown
    points = np.vstack([np.zeros((1, 2)), *flat])
    note = f"{name} · {space.name}" if name else space.name
    if not flat:
        note += " · empty"
        points = np.array([[-1.0, -1.0], [1.0, 1.0]])
    chart = Chart(points.min(axis=0), points.max(axis=0), axes.labels, axes.title, note, caption)
    if flat:
        longer = max(chart.width, chart.height)
        columns, rows = (
            max(1, round(PIXELS * side / longer)) for side in (chart.width, chart.height)
        )
        across = chart.low[0] + (np.arange(columns) + 0.5) / columns * (
            chart.high[0] - chart.low[0]
        )
        along = chart.high[1] - (np.arange(rows) + 0.5) / rows * (chart.high[1] - chart.low[1])
        x, y = np.meshgrid(across, along)
        colours = axes.origin + x[..., np.newaxis] * axes.right + y[..., np.newaxis] * axes.up
        chart.add_image(
            _pixels(colours.reshape(-1, 3), space).reshape(rows, columns, 3), chart.path(flat)
        )
        chart.add_polygons(
            flat, fill="none", stroke=INK, stroke_width="1.5", stroke_linejoin="round"
        )
    return chart.svg()


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
    axes: tuple[str, str, str] = ("L*", "a*", "b*"),
    volume: float | None = None,
    caption: str = "",
) -> bytes:
    """Return a picture of gamut rings.

    Parameters
    ----------
    lightness : (n,) float64
        Of the rings.
    hues : (s,) float64
        Middles of equal sectors, in degrees.
    radius : (n, s) float64
    reference_radius, intersection_radius : (n, s) float64, optional
        As in `gamutcore.queries.Rings`. The reference is drawn as its outer ring, and the
        intersection within each band.
    names : (str, str), optional
        Of the gamut and of the reference.
    axes : (str, str, str), optional
        Names of lightness and of the axes of hue.
    volume : float, optional
        Shown in the title.
    caption : str, optional
        Below the picture, such as the conditions of the gamuts.

    Returns
    -------
    bytes
        SVG. The same arguments give the same bytes.
    """
    # wide sectors are drawn as arcs
    times = max(1, -(-WEDGES // len(hues)))
    turn = 2.0 * np.pi / (len(hues) * times)
    angle = np.radians(hues[0]) + turn * (np.arange(len(hues) * times) - (times - 1) / 2.0)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    rings = _curves(radius, circle)
    outlines = [rings[-1]]
    if reference_radius is not None:
        outlines.append(_curves(reference_radius, circle)[-1])
    points = np.vstack([np.zeros((1, 2)), *outlines])
    parts = [names[0]] if names[0] else []
    if volume is not None:
        figure = f"{volume:,.0f}" if volume >= 1000.0 else f"{volume:.4g}"
        parts.append(f"volume {figure}".replace(",", "\N{NARROW NO-BREAK SPACE}"))
    chart = Chart(
        points.min(axis=0),
        points.max(axis=0),
        (f"{axes[1]}_RSS", f"{axes[2]}_RSS"),
        "Gamut rings",
        " · ".join(parts),
        caption,
    )
    chart.add(f'<g shape-rendering="crispEdges">{_bands(chart, rings, angle)}</g>')
    outer, middle = len(rings) - 1, max(len(rings) // 2 - 1, 0)
    legend = []
    if reference_radius is not None:
        legend.append((DASHES, names[1]))
    if intersection_radius is not None:
        within = _curves(intersection_radius, circle)
        chart.add(f'<path d="{chart.path(within)}" fill="none" {DOTS.format("#fff")}/>')
        legend.append((DOTS.format("#999"), "intersection"))
    for number, ring in enumerate(rings):
        width = "1.8" if number == outer else "0.7"
        chart.add_polygons([ring], fill="none", stroke=INK, stroke_width=width)
    for outline in outlines[1:]:
        chart.add(f'<path d="{chart.path([outline])}" fill="none" {DASHES}/>')
    chart.add_legend(legend)
    chart.add(_cross(chart))
    # the labels are where they are farthest apart
    at = times * int(np.argmax(radius[outer] - radius[middle]))
    for number in sorted({0, middle, outer}):
        chart.add_text(rings[number][at].tolist(), f"{axes[0]} {lightness[number]:g}")
    return chart.svg()


def _curves(radius: FloatArray, circle: FloatArray) -> list[FloatArray]:
    """Return the corners of closed curves with the radii of equal sectors."""
    times = len(circle) // radius.shape[1]
    return [np.repeat(each, times)[:, np.newaxis] * circle for each in radius]


def _bands(chart: Chart, rings: list[FloatArray], angle: FloatArray) -> str:
    """Return the bands between rings, in the hues that they stand for."""
    low, high = BAND_LIGHTNESS
    count = len(angle)
    width = max(1, count // WEDGES)
    wedges = range(0, count, width)
    shades = np.linspace(low, high, len(rings))
    middles = np.array([angle[(begin + min(begin + width, count) - 1) // 2] for begin in wedges])
    lab = np.array(
        [
            (shade, BAND_CHROMA * math.cos(hue), BAND_CHROMA * math.sin(hue))
            for shade in shades
            for hue in middles
        ]
    )
    colours = _pixels(lab, CIELAB).tolist()
    parts = []
    inner = np.zeros_like(rings[0])
    for band, ring in enumerate(rings):
        for wedge, begin in enumerate(wedges):
            at = np.arange(begin, min(begin + width, count) + 1) % count
            outline = np.vstack([ring[at], inner[at][::-1]])
            red, green, blue = colours[band * len(middles) + wedge]
            parts.append(
                f'<path d="{chart.path([outline])}" fill="#{red:02x}{green:02x}{blue:02x}"/>'
            )
        inner = ring
    return "".join(parts)


def _cross(chart: Chart) -> str:
    """Return a mark where chroma is 0."""
    ((x, y),) = chart.place(np.zeros((1, 2))).tolist()
    lines = f"M{x - 7:.1f},{y:.1f}h14M{x:.1f},{y - 7:.1f}v14"
    return f'<path d="{lines}" stroke="#fff" stroke-width="1.2"/>'
