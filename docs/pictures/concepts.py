"""Draw the pictures of docs/concepts.md. Run by ``make concepts``; needs the extra ``docs``.

The background is transparent, and text and lines have a medium lightness, so that the pictures are
readable on light and dark pages. Glyphs are paths, and the same data gives the same file.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Path2D

import gamutcore as gc
from gamutcore import search
from gamutcore.arrays import FloatArray
from gamutcore.colours.spaces import srgb
from gamutcore.geometry import TriangleMesh
from gamutcore.levels import Side

__all__ = ["CONCEPTS", "FOLDER", "draw_concepts"]

ROOT = Path(__file__).parents[2]
FOLDER = Path(__file__).parent / "concepts"

INK = "#7c858f"
"""Text and axes: a contrast of about 4 with white and with the dark page."""
BLUE, ORANGE, GREEN, VIOLET = "#2f86cc", "#d9711a", "#1d9a5b", "#a668c8"

SETTINGS = {
    "svg.fonttype": "path",
    "svg.hashsalt": "gamut",
    "font.size": 10,
    "text.color": INK,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.5,
    "legend.frameon": False,
}

YELLOW = "#b58a00"

BROWN = np.array([46.0, 24.0, 32.0])
"""A colour inside of the press with a wide range of black."""

SAMPLES = 5000
"""Points on a device's surface, enough for pictures of this size."""

HUE = 40.0
"""Hue angle of the leaves in degrees."""

OUTSIDE = np.array([40.0, 50.0, -85.0])
"""A colour outside of the press, whose nearest points by two metrics lie far apart."""

METHODS = ("clip-hue", "clip-lightness", "clip-chroma", "clip-focal")

PIXELS = 120
"""Pixels along each side of a picture of colours."""

LIGHT = np.array([-0.35, 0.55, 0.75]) / np.linalg.norm([-0.35, 0.55, 0.75])
"""Direction towards the light, in the axes of the view: right, up, towards the eye."""


class Gamuts(NamedTuple):
    """The gamuts of the pictures: coated paper, and sRGB."""

    press: gc.Gamut
    srgb: gc.Gamut


def draw_concepts(folder: Path = FOLDER) -> None:
    """Draw all pictures as SVG files into a folder."""
    press = gc.Gamut(ROOT / "examples" / "FOGRA39L.ti3", surface_samples=SAMPLES)
    gamuts = Gamuts(press, gc.reference("sRGB", surface_samples=SAMPLES))
    folder.mkdir(exist_ok=True)
    with mpl.rc_context(SETTINGS):
        for name, draw in CONCEPTS.items():
            draw(gamuts).savefig(folder / f"{name}.svg", transparent=True, metadata={"Date": None})


def _figure(width: float, height: float, columns: int = 1) -> tuple[Figure, Any]:
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(1, columns)


def _draw_solid(axes: Any, mesh: TriangleMesh, lines: float = 0.4) -> None:  # noqa: ANN401
    """Draw the faces that are turned towards the eye, in their own colours, far ones first."""
    turn, rise = np.radians([-60.0, 18.0])
    eye = np.array([np.sin(rise), np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn)])
    right = np.array([0.0, -np.sin(turn), np.cos(turn)])
    view = np.stack([right, np.cross(eye, right), eye])
    corners = np.stack(mesh.corners(), axis=1).astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ view.T
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    projected = corners @ view.T
    seen = np.flatnonzero(normals[:, 2] > 0)
    seen = seen[np.argsort(projected[seen, :, 2].mean(axis=1), kind="stable")]
    shade = 0.8 + 0.2 * np.clip(normals[seen] @ LIGHT, -1, 1)
    colours = np.clip(srgb(corners[seen].mean(axis=1)), 0, 1) * shade[:, np.newaxis]
    edges = np.clip(colours * 0.6 + 0.15, 0, 1)
    faces = PolyCollection(
        projected[seen, :, :2], facecolors=colours, edgecolors=edges, linewidths=lines
    )
    axes.add_collection(faces)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_axis_off()


def _boundary(gamuts: Gamuts) -> Figure:
    figure, axes = _figure(4.2, 3.2)
    _draw_solid(axes, gamuts.press.level(1000), lines=0.3)
    return figure


def _level(gamuts: Gamuts) -> Figure:
    figure, panels = _figure(8.0, 2.4, 4)
    for axes, triangles in zip(panels, (1000, 100, 30, 10), strict=True):
        _draw_solid(axes, gamuts.press.level(triangles))
        axes.set_title(f"{triangles} triangles")
    return figure


def _sections(gamuts: Gamuts) -> Figure:
    """A slice and a hue leaf with its cusp, filled with the colours that they show."""
    figure, (left, right) = _figure(7.6, 3.2, 2)
    for outline in _slice(gamuts.press, 50.0):
        _fill_with_colours(left, outline, lambda a, b: np.stack([np.full_like(a, 50.0), a, b], -1))
    _label_slice(left, "slice at L* = 50")
    turn = np.radians(HUE)
    leaf = max(_leaf(gamuts.press, HUE), key=len)
    _fill_with_colours(
        right, leaf, lambda c, L: np.stack([L, c * np.cos(turn), c * np.sin(turn)], axis=-1)
    )
    cusp = leaf[np.argmax(leaf[:, 0])]
    right.plot(*cusp, "o", color=INK)
    right.annotate("cusp", cusp, (6, 4), textcoords="offset points")
    _label_leaf(right, f"hue leaf at {HUE:.0f}°")
    return figure


def _mismatch(gamuts: Gamuts) -> Figure:
    """The volume that lies in only one of two solids, seen in a slice."""
    figure, axes = _figure(5.6, 3.2)
    (full,), (level,) = _slice(gamuts.press, 50.0), _slice(gamuts.press, 50.0, 10)
    # One outline is reversed, so that only what lies in one of them has a winding number.
    both = Path2D.make_compound_path(_closed(full), _closed(level[::-1]))
    axes.add_patch(PathPatch(both, facecolor=ORANGE, alpha=0.45, linewidth=0))
    _outline(axes, full, BLUE, "full boundary")
    _outline(axes, level, ORANGE, "10 triangles")
    _label_slice(axes, "")
    figure.legend(loc="outside right upper")
    return figure


def _coverage(gamuts: Gamuts) -> Figure:
    """The common part of two solids, seen in a slice."""
    figure, axes = _figure(5.6, 3.2)
    (press,), (srgb_slice,) = _slice(gamuts.press, 50.0), _slice(gamuts.srgb, 50.0)
    common = PathPatch(_closed(press), facecolor=GREEN, alpha=0.35, linewidth=0)
    axes.add_patch(common)
    common.set_clip_path(_closed(srgb_slice), axes.transData)
    _outline(axes, press, BLUE, "A: coated paper")
    _outline(axes, srgb_slice, ORANGE, "B: sRGB")
    axes.text(8, 8, "A ∩ B", color=GREEN)
    _label_slice(axes, "")
    figure.legend(loc="outside right upper")
    return figure


def _sides(gamuts: Gamuts) -> Figure:
    """Levels on one side of the full boundary."""
    figure, axes = _figure(5.6, 3.2)
    (full,) = _slice(gamuts.press, 50.0)
    _outline(axes, full, BLUE, "full boundary")
    for side, colour in (("outside", ORANGE), ("inside", GREEN)):
        for outline in _slice(gamuts.press, 50.0, 20, side):
            _outline(axes, outline, colour, f"20 triangles, {side}")
    _label_slice(axes, "")
    figure.legend(loc="outside right upper")
    return figure


def _distance(gamuts: Gamuts) -> Figure:
    """Lines of equal signed distance, in a slice."""
    figure, axes = _figure(4.2, 3.2)
    a, b = np.meshgrid(np.linspace(-100, 110, 106), np.linspace(-85, 85, 86))
    distance = gamuts.press.distance(np.stack([np.full_like(a, 50.0), a, b], axis=-1))
    lines = axes.contour(
        a, b, distance, [-30, -20, -10, 0, 10, 20], colors=[GREEN] * 3 + [BLUE] + [ORANGE] * 2
    )
    axes.clabel(lines, fmt="%+d", fontsize=8)
    _label_slice(axes, "signed distance at L* = 50")
    return figure


def _nearest(gamuts: Gamuts) -> Figure:
    """The nearest points of one colour by two metrics, seen along L*."""
    figure, axes = _figure(5.6, 3.2)
    for outline in _slice(gamuts.press, OUTSIDE[0]):
        _outline(axes, outline, BLUE, "coated paper")
    axes.plot(*OUTSIDE[1:], "o", color=INK)
    axes.annotate("colour", OUTSIDE[1:], (6, -4), textcoords="offset points")
    for metric, colour, name in (("CIE 1976", GREEN, "distance"), ("CIE 2000", ORANGE, "ΔE00")):
        near = gamuts.press.nearest(OUTSIDE, metric=metric)
        label = f"least {name}: {near.distance:.1f}, ΔE00 {near.delta_e:.1f}"
        axes.annotate("", near.points[1:], OUTSIDE[1:], arrowprops=_arrow(colour))
        axes.plot(*near.points[1:], "o", color=colour, label=label)
    _label_slice(axes, f"around L* = {OUTSIDE[0]:.0f}")
    figure.legend(loc="outside right upper")
    return figure


def _crossings(gamuts: Gamuts) -> Figure:
    """Where a line enters and leaves a slice."""
    figure, axes = _figure(4.2, 3.2)
    for outline in _slice(gamuts.press, 50.0):
        _outline(axes, outline, BLUE)
    start, end = np.array([50.0, -95.0, -20.0]), np.array([50.0, 95.0, 40.0])
    axes.annotate("", end[1:], start[1:], arrowprops=_arrow(INK))
    found = gamuts.press.crossings(start, end)
    for point, entering in zip(found.points, found.entering, strict=True):
        axes.plot(*point[1:], "o", color=GREEN if entering else ORANGE)
        name = "enters" if entering else "leaves"
        axes.annotate(name, point[1:], (-4, 8), textcoords="offset points", ha="right")
    axes.set_xlim(-100, 100)
    _label_slice(axes, "at L* = 50")
    return figure


def _rings(gamuts: Gamuts) -> Figure:
    """Gamut rings of the press, with the part that is common with sRGB."""
    figure, axes = _figure(5.6, 3.8)
    rings = gamuts.press.rings(gamuts.srgb, sectors=120)
    turn = np.radians(np.append(rings.hues, rings.hues[0]))

    def curve(radius: FloatArray) -> FloatArray:
        return np.append(radius, radius[0]) * [np.cos(turn), np.sin(turn)]

    inner = np.vstack([np.zeros_like(rings.radius[:1]), rings.radius[:-1]])
    for low, common in zip(inner, rings.intersection_radius, strict=True):
        band = np.hstack([curve(low), curve(common)[:, ::-1]])
        axes.fill(*band, color=GREEN, alpha=0.35, linewidth=0)
    for place, radius in enumerate(rings.radius):
        axes.plot(
            *curve(radius), color=BLUE, linewidth=1, label="coated paper" if place == 0 else None
        )
    axes.plot(*curve(rings.reference_radius[-1]), color=ORANGE, ls="--", label="sRGB, outer ring")
    axes.fill([], [], color=GREEN, alpha=0.35, label="common part")
    axes.set(xlabel="a* RSS", ylabel="b* RSS", aspect="equal")
    figure.legend(loc="outside right upper")
    return figure


def _mapping(gamuts: Gamuts) -> Figure:
    """Where several methods put a colour of sRGB, in the leaf of its hue."""
    figure, axes = _figure(5.6, 3.4)
    L, C, turn = 75.0, 62.0, np.radians(HUE)
    colour = np.array([L, C * np.cos(turn), C * np.sin(turn)])
    for outline in _leaf(gamuts.press, HUE):
        _outline(axes, outline, INK)
    for colours, method in zip((BLUE, ORANGE, GREEN, VIOLET), METHODS, strict=True):
        mapped = gamuts.press.map(colour, method).points
        place = (np.hypot(*mapped[1:]), mapped[0])
        axes.annotate("", place, (C, L), arrowprops=_arrow(colours))
        axes.plot(*place, "o", color=colours, label=method)
    axes.plot(C, L, "o", color=INK)
    axes.annotate("colour", (C, L), (6, 2), textcoords="offset points")
    _label_leaf(axes, f"hue {HUE:.0f}°")
    figure.legend(loc="outside right upper")
    return figure


def _recipe(gamuts: Gamuts) -> Figure:
    """Inks of one colour along its range of black, and of neutral colours by medium replacement."""
    figure, (one, gray) = _figure(7.4, 3.2, 2)
    press = gamuts.press
    steps = [press.to_device(BROWN, black=share) for share in np.linspace(0.0, 1.0, 40)]
    inks = 100.0 * np.array([step.device for step in steps])
    lightness = np.linspace(94.0, 12.0, 165)
    neutral = press.to_device(np.stack([lightness, 0 * lightness, 0 * lightness], axis=1))
    names = ("cyan", "magenta", "yellow", "black")
    for number, (name, colour) in enumerate(zip(names, (BLUE, VIOLET, YELLOW, INK), strict=True)):
        if name != "black":
            one.plot(inks[:, 3], inks[:, number], color=colour)
        gray.plot(lightness, 100.0 * neutral.device[:, number], color=colour, label=name)
    one.set(xlabel="black, %", ylabel="ink, %", ylim=(-3, 103), title="L*a*b* 46 24 32")
    gray.set(xlabel="L*", ylim=(-3, 103), title="neutral colours, medium")
    gray.invert_xaxis()
    figure.legend(loc="outside right upper")
    return figure


def _arrow(colour: str) -> dict[str, object]:
    return {"arrowstyle": "->", "color": colour, "shrinkA": 3, "shrinkB": 3}


def _fill_with_colours(
    axes: Any,  # noqa: ANN401
    outline: FloatArray,
    colours: Callable[[FloatArray, FloatArray], FloatArray],
) -> None:
    """Fill a polygon with the colours of its positions. `colours` gives CIELAB of a grid."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    grid = np.meshgrid(*(np.linspace(*ends, PIXELS) for ends in zip(low, high, strict=True)))
    picture = np.clip(srgb(colours(*grid).reshape(-1, 3)), 0, 1).reshape(PIXELS, PIXELS, 3)
    extent = (low[0], high[0], low[1], high[1])
    shown = axes.imshow(picture, extent=extent, origin="lower", interpolation="bilinear")
    shown.set_clip_path(_closed(outline), axes.transData)
    axes.use_sticky_edges = False  # of the picture, which would leave no margin
    _outline(axes, outline, INK)


def _outline(axes: Any, outline: FloatArray, colour: str, label: str | None = None) -> None:  # noqa: ANN401
    axes.plot(*np.vstack([outline, outline[:1]]).T, color=colour, label=label)


def _closed(outline: FloatArray) -> Path2D:
    return Path2D(np.vstack([outline, outline[:1]]), closed=True)


def _label_slice(axes: Any, title: str) -> None:  # noqa: ANN401
    axes.set(xlabel="a*", ylabel="b*", title=title, aspect="equal")
    axes.margins(0.05)


def _label_leaf(axes: Any, title: str) -> None:  # noqa: ANN401
    axes.set(xlabel="chroma C*", ylabel="L*", title=title, aspect="equal")
    axes.margins(0.05)


def _slice(
    gamut: gc.Gamut, lightness: float, triangles: int | None = None, side: Side = "both"
) -> list[FloatArray]:
    """Return the outlines of a level at a lightness as (n, 2) arrays of a* and b*."""
    section = search.slice_polygons(_level_of(gamut, triangles, side), (1, 0, 0), lightness)
    return [polygon[:, 1:] for polygon in section.polygons]


def _leaf(gamut: gc.Gamut, hue: float) -> list[FloatArray]:
    """Return the outlines of a hue leaf as (n, 2) arrays of chroma and lightness."""
    return [
        np.stack([np.hypot(polygon[:, 1], polygon[:, 2]), polygon[:, 0]], axis=-1)
        for polygon in search.hue_leaf(_level_of(gamut), hue).polygons
    ]


def _level_of(
    gamut: gc.Gamut, triangles: int | None = None, side: Side = "both"
) -> search.LevelIndex:
    """Return a level for queries, the full boundary by default."""
    mesh = gamut.level(triangles or gamut.history.triangles, side=side)
    return search.build_index(mesh.vertices, mesh.faces, gamut.description["centre"])


def _link(_: Gamuts) -> Figure:
    """Draw the green of sRGB between two colours of Display P3, exactly and by tables."""
    figure, axes = _figure(6.0, 3.0)
    few: dict[str, Any] = {"surface_samples": SAMPLES}
    source, screen = (
        gc.reference(name, space="CAM16-UCS", **few) for name in ("display-p3", "srgb")
    )
    along = np.linspace(0.0, 1.0, 401)
    # from gray to the red of P3
    values = np.stack([0.5 + 0.5 * along, 0.5 - 0.5 * along, 0.5 - 0.5 * along], axis=1)
    for nodes, colour in ((9, ORANGE), (33, BLUE)):
        table = gc.link(source, screen, method="clip-nearest", size=nodes).table
        axes.plot(along, table.values(values)[:, 1], color=colour, label=f"{nodes} nodes")
    points = source.to_colour(values)
    exact = screen.map(points, "clip-nearest", max_error=0).points
    green = screen.to_device(exact).device[:, 1]
    axes.plot(along, green, color=INK, linewidth=1.0, linestyle=(0, (4, 2)), label="exact")
    axes.set_xlabel("gray of Display P3 to its red")
    axes.set_ylabel("green of sRGB")
    axes.legend()
    return figure


CONCEPTS: dict[str, Callable[[Gamuts], Figure]] = {
    "boundary": _boundary,
    "level": _level,
    "mismatch": _mismatch,
    "sides": _sides,
    "sections": _sections,
    "distance": _distance,
    "nearest": _nearest,
    "crossings": _crossings,
    "coverage": _coverage,
    "rings": _rings,
    "mapping": _mapping,
    "recipe": _recipe,
    "link": _link,
}
"""File names of the pictures and the functions that draw them, in the order of the page."""

if __name__ == "__main__":
    draw_concepts()
