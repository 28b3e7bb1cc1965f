"""Pictures of a gamut: as PNG, in notebooks, and with matplotlib, which is the extra ``plot``.

The picture in notebooks is SVG. The faces of a coarse level are projected along a fixed direction
and filled with their own colours. Faces that look away are left out. The others are drawn from back
to front.
"""

from __future__ import annotations

import importlib.util
import math
import textwrap
import unicodedata
from types import SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from gamutcore.arguments import Array, Boolean, Choice, FiniteNumber, Number, WholeNumber
from gamutcore.colours.spaces import CIELAB, srgb
from gamutcore.export.rendering import (
    BACKGROUNDS,
    DEFAULT_SIZE,
    LARGEST_PICTURE,
    PICTURE_TRIANGLES,
    SMALLEST_PICTURE,
    VIEWS,
    mesh_picture,
)
from gamutcore.geometry import TriangleMesh
from gamutcore.levels import LevelRequest
from gamutcore.number_text import number_text, volume_text
from gamutcore.questions.declarations import Parameter, Question
from gamutcore.questions.levels import answering_level, other_gamut
from gamutcore.questions.shape import RINGS, rings, section
from gamutcore.results import GamutRings, facts_table

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import ArrayLike, NDArray

    from gamutcore.arrays import FloatArray, PositionArray
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.questions.levels import GamutLike, OtherGamut

__all__ = [
    "MOST_DRAWN_TRIANGLES",
    "PICTURE",
    "PNG_KEYWORD",
    "draw_rings",
    "face_colours",
    "figure",
    "new_axes",
    "notebook_html",
    "picture",
    "plot",
    "plot_rings",
    "plot_slice",
    "plot_text",
    "svg_picture",
]

MOST_DRAWN_TRIANGLES = 100_000
"""Bounds the time of a picture to some seconds, whatever the shape of the triangles."""

NOTEBOOK_TRIANGLES = 400
"""Triangles of the picture in a notebook: 25 kB of SVG, and smooth."""

PNG_KEYWORD = "Gamut"
"""Keyword of the conditions among the texts of a PNG file."""

PLOT_TRIANGLES = 2000
"""Triangles of a plot; matplotlib draws them in a tenth of a second."""

SHELL_OPACITY = 0.12
"""Of a second gamut on the same axes, through which the first one is seen."""

INK, NOTE, FRAME, GRID, ZERO, PAPER = "#222", "#555", "#888", "#e2e2e2", "#aaa", "#fafafa"
"""Text and lines, small text, frame, grid, grid at 0, and what is within the frame."""

SIZE = (6.2, 6.6)
"""Size of a figure in inches."""

POINTS = 0.72
"""Points of a pixel at 100 pixels per inch, in which the sizes of text and lines are."""

SMALL, LABEL, TITLE = 13, 15, 17
"""Sizes of text, in pixels."""

CHARACTER = 7.0
"""Largest mean width of a character of the caption, in pixels."""

LINES: tuple[Any, ...] = ("-", (0, (5, 3.1)), (0, (1.8, 1.4)), (0, (5, 2, 1.2, 2)))
"""Dashes of the first, the second and further gamuts, in widths of the line."""

AZIMUTH, ELEVATION = np.radians(-35.0), np.radians(25.0)
"""Direction of the viewer of the picture in notebooks: in front of the blue and purple hues, from
above."""

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


def picture(
    gamut: GamutLike,
    size: int = DEFAULT_SIZE,
    view: str | Sequence[float] = "standard",
    *,
    background: str = "white",
    axes: bool = True,
    triangles: int | None = None,
    max_error: float | None = None,
) -> bytes:
    """Return a picture of the gamut as PNG, drawn without matplotlib.

    Parameters
    ----------
    size : int, optional
        Width and height in pixels, 16 to 2048.
    view : str or (float, float), optional
        ``standard``, ``front``, ``right``, ``back``, ``left``, ``top`` or ``bottom``; or the
        hue and the elevation in degrees from which the camera looks.
    background : {'white', 'transparent'}, optional
    axes : bool, optional
        Whether there are axes with labels.
    triangles, max_error : optional
        The level, of 20,000 triangles by default.

    Returns
    -------
    bytes
        The text `Gamut` in the file has the conditions of the gamut.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> colours = [(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)]
    >>> Gamut(colours).picture(100)[1:4]
    b'PNG'
    """
    default = min(PICTURE_TRIANGLES, gamut.history.triangles)
    request = LevelRequest(triangles, max_error).or_default(default)
    return mesh_picture(
        gamut.history.level(gamut.search.find(gamut.history, request).triangles),
        gamut.colour_space,
        size=size,
        view=view,
        background=background,
        axes=axes,
        texts={PNG_KEYWORD: str(gamut.conditions)},
    )


PICTURE = Question(
    "picture",
    "drawGamut",
    "Draw the gamut",
    "A picture of the gamut in its own colours, in parallel projection, with lightness upwards. "
    "The same request gives the same bytes.",
    (
        Parameter(
            "size",
            Annotated[int, WholeNumber(SMALLEST_PICTURE, LARGEST_PICTURE)],
            "Width and height in pixels.",
            default=DEFAULT_SIZE,
            example=400,
        ),
        Parameter(
            "view",
            Annotated[str, Choice(tuple(VIEWS))]
            | Annotated[tuple[FiniteNumber, FiniteNumber], Array("2 numbers", 2)],
            "Name of a view, or the hue and the elevation in degrees from which the camera looks. "
            "The elevation is from -90 (from below) to 90 (from above).",
            default="standard",
            example="top",
        ),
        Parameter(
            "background",
            Annotated[str, Choice(BACKGROUNDS)],
            "What is behind the gamut.",
            default="white",
            example="transparent",
        ),
        Parameter(
            "axes", Annotated[bool, Boolean()], "Whether there are axes with labels.", default=True
        ),
        Parameter(
            "triangles",
            Annotated[int, WholeNumber(4, MOST_DRAWN_TRIANGLES)],
            f"Largest triangle count. Default: {PICTURE_TRIANGLES}, or the full boundary if it is "
            "smaller.",
            example=1000,
        ),
        Parameter(
            "max_error",
            Annotated[float, Number(0.0, 1e12)],
            "Largest distance between the level and the full boundary, in units of the space, "
            f"instead of a count. Levels of more than {MOST_DRAWN_TRIANGLES} triangles are not "
            "drawn.",
            example=0.5,
        ),
    ),
    picture,
    level=(),
)


def notebook_html(gamut: GamutLike) -> str:
    """Return a picture and the key figures, for notebooks."""
    space, description = gamut.colour_space, gamut.description
    lowest, highest = description["bounds"]
    facts = {
        **({"name": gamut.name} if gamut.name else {}),
        "space": space.name,
        "channels": " ".join(map(str, description["provenance"].get("channels") or ["-"])),
        "volume": number_text(description["volume"]),
        **{
            axis: f"{number_text(low, 4)} to {number_text(high, 4)}"
            for axis, low, high in zip(space.axes, lowest, highest, strict=True)
        },
        "triangles": f"4 to {gamut.history.triangles}",
        "id": f"{description['id'][:12]}…",
    }
    count = min(NOTEBOOK_TRIANGLES, gamut.history.triangles)
    picture = svg_picture(gamut.history.level(count), space)
    return (
        f"<div style='display:flex;align-items:center;gap:1em'>{picture}{facts_table(facts)}</div>"
    )


def _upright(vertices: PositionArray, space: ColourSpace) -> FloatArray:
    """Return coordinates (n, 3) with lightness as the last axis: (a*, b*, L*) for CIELAB."""
    lightness = space.definition.lightness
    others = [axis for axis in range(3) if axis != lightness]
    return np.asarray(vertices, np.float64)[:, [*others, lightness]]


def face_colours(mesh: TriangleMesh, space: ColourSpace) -> FloatArray:
    """Return the sRGB colour of the middle of each face, (n, 3) from 0 to 1."""
    middles = mesh.vertices[mesh.faces].astype(np.float64).mean(axis=1)
    return srgb(space.appearance_lab(middles))


def svg_picture(mesh: TriangleMesh, space: ColourSpace, size: int = 220) -> str:
    """Return a picture of a star-shaped mesh of a few hundred faces; `size` is in pixels."""
    place = _upright(mesh.vertices, space)
    sine, cosine = np.sin(AZIMUTH), np.cos(AZIMUTH)
    right = place[:, 0] * cosine - place[:, 1] * sine
    back = place[:, 0] * sine + place[:, 1] * cosine
    up = place[:, 2] * np.cos(ELEVATION) + back * np.sin(ELEVATION)
    depth = back * np.cos(ELEVATION) - place[:, 2] * np.sin(ELEVATION)
    flat = np.stack([right, -up], axis=1)
    lowest, highest = flat.min(axis=0), flat.max(axis=0)
    flat = size * (0.5 + 0.96 * (flat - (lowest + highest) / 2) / (highest - lowest).max())
    corners = flat[mesh.faces]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    turn = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    seen = np.flatnonzero(turn < 0 if _is_right_handed(space) else turn > 0)
    seen = seen[np.argsort(-depth[mesh.faces[seen]].mean(axis=1), kind="stable")]
    colours = np.rint(255 * face_colours(mesh, space)).astype(int)
    shapes = []
    for face in seen:
        points = " ".join(f"{px:.1f},{py:.1f}" for px, py in corners[face])
        fill = "#{:02x}{:02x}{:02x}".format(*colours[face])
        shapes.append(f'<polygon points="{points}" fill="{fill}" stroke="{fill}"/>')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size}" height="{size}" '
        f'viewBox="0 0 {size} {size}" stroke-width="0.5">{"".join(shapes)}</svg>'
    )


def _is_right_handed(space: ColourSpace) -> bool:
    """Whether `_upright` keeps the orientation: moving the second axis to the end reverses it."""
    return space.definition.lightness != 1


def plot(
    gamut: GamutLike,
    ax: Any = None,  # noqa: ANN401  # of matplotlib, which is optional
    *,
    triangles: int | None = None,
    max_error: float | None = None,
    **style: Any,  # noqa: ANN401
) -> Any:  # noqa: ANN401
    """Draw the gamut in three dimensions with its own colours.

    Further gamuts on the same axes are shells with dashed lines of constant lightness.

    Parameters
    ----------
    ax : mpl_toolkits.mplot3d.Axes3D, optional
        New axes unless given.
    triangles, max_error : optional
        The level, of 2,000 triangles by default.
    **style
        For `mpl_toolkits.mplot3d.art3d.Poly3DCollection`, such as ``alpha=0.5``; and ``label``,
        a name instead of `Gamut.name`.

    Returns
    -------
    mpl_toolkits.mplot3d.Axes3D

    Raises
    ------
    ModuleNotFoundError
        matplotlib is not installed.
    """
    if ax is None:
        ax = new_axes(projection="3d")
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # noqa: PLC0415  # optional

    number = len(_described(ax).labels)
    if triangles is None and max_error is None:
        triangles = min(PLOT_TRIANGLES, gamut.history.triangles)
    index = answering_level(gamut, triangles, max_error).index
    mesh = TriangleMesh(index.vertices, index.faces)
    place = _upright(mesh.vertices, gamut.colour_space)
    colours = face_colours(mesh, gamut.colour_space)
    label = style.pop("label", gamut.name or f"gamut {number + 1}")
    look = {"facecolors": colours, "edgecolors": colours, "linewidths": 0.2}
    dashes = LINES[number % len(LINES)]
    if number:
        shell = np.column_stack([colours, np.full(len(colours), SHELL_OPACITY)])
        look = {"facecolors": shell, "linewidths": 0.0}
        for part in range(1, 10):
            height = gamut.colour_space.white_lightness * part / 10.0
            cut = section(gamut, height, triangles=triangles, max_error=max_error)
            for ring in cut.polygons:
                closed = _upright(np.vstack([ring, ring[:1]]), gamut.colour_space)
                ax.plot(*closed.T, color=INK, linestyle=dashes, linewidth=POINTS)
    ax.add_collection3d(Poly3DCollection(place[mesh.faces], **(look | style)))
    lowest, highest = place.min(axis=0), place.max(axis=0)
    axes = list(gamut.colour_space.axes)
    up = axes.pop(gamut.colour_space.definition.lightness)
    for name, axis, low, high in zip("xyz", [*axes, up], lowest, highest, strict=True):
        limits = sorted([low, high, *getattr(ax, f"get_{name}lim")()])
        ax.set(**{f"{name}lim": (limits[0], limits[-1]) if number else (low, high)})
        getattr(ax, f"set_{name}label")(axis, fontsize=LABEL * POINTS, color=INK)
        getattr(ax, f"{name}axis").set_pane_color(PAPER)
        getattr(ax, f"{name}axis").line.set_color(FRAME)
    ax.tick_params(labelsize=SMALL * POINTS, labelcolor=INK, color=FRAME)
    ax.set_box_aspect(np.ptp([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()], axis=1), zoom=0.86)
    line = _line(label, linestyle=dashes, linewidth=1.6 * POINTS)
    _describe(ax, str(gamut.conditions), gamut.colour_space.name, [line], label=label)
    return ax


def section_axes(
    space: ColourSpace, lightness: float | None, hue: float | None, plane: ArrayLike | None
) -> SectionAxes:
    """Return the plane of a section, of which one is given, and its axes."""
    if lightness is not None:
        return lightness_axes(lightness, space)
    if hue is not None:
        return leaf_axes(hue, space)
    numbers = np.asarray(plane, np.float64)
    return plane_axes(numbers[:3], float(numbers[3]), space)


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


def lightness_axes(lightness: float, space: ColourSpace) -> SectionAxes:
    """Return the plane of a constant lightness."""
    upright = space.definition.lightness
    right, up = (axis for axis in range(3) if axis != upright)
    unit = np.eye(3)
    labels = (space.axes[right], space.axes[up])
    title = f"{space.axes[upright]} = {number_text(lightness)}"
    return SectionAxes(lightness * unit[upright], unit[right], unit[up], labels, title)


def leaf_axes(hue: float, space: ColourSpace) -> SectionAxes:
    """Return the half-plane of a hue in degrees: chroma to the right, lightness upwards."""
    angle = math.radians(hue)
    right = np.array([0.0, math.cos(angle), math.sin(angle)])
    chroma = "C*" if space.name in {"CIELAB", "CIELUV"} else "Chroma"
    labels = (chroma, space.axes[0])
    return SectionAxes(np.zeros(3), right, np.eye(3)[0], labels, f"Hue {hue:g}°")


def plane_axes(normal: FloatArray, offset: float, space: ColourSpace) -> SectionAxes:
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


def plot_slice(
    gamut: GamutLike,
    L: float | None = None,
    ax: Any = None,  # noqa: ANN401  # of matplotlib
    *,
    hue: float | None = None,
    plane: ArrayLike | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
    **style: Any,  # noqa: ANN401
) -> Any:  # noqa: ANN401
    """Draw a section in the colours that it shows.

    Parameters
    ----------
    L, hue, plane : optional
        One of them, as for `slice`.
    ax : matplotlib.axes.Axes, optional
        New axes unless given. The first gamut is filled with its colours. Further gamuts on
        the same axes are dashed, and there is a legend.
    **style
        For `matplotlib.axes.Axes.fill`; ``label`` is a name instead of `Gamut.name`, and with
        ``color`` or ``fill`` the section does not have its colours.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ModuleNotFoundError
        matplotlib is not installed.
    """
    plane_section = section(
        gamut, L, hue=hue, plane=plane, triangles=triangles, max_error=max_error
    )
    ax = new_axes() if ax is None else ax
    axes = section_axes(gamut.colour_space, L, hue, plane)
    flat = [axes.flat(polygon) for polygon in plane_section.polygons]
    number = len(_described(ax).labels)
    label = style.pop("label", gamut.name or f"gamut {number + 1}")
    line = {"linestyle": LINES[number % len(LINES)], "linewidth": 1.6 * POINTS}
    look = {"fill": False, "edgecolor": INK, **line} | style
    drawn = [patch for polygon in flat for patch in ax.fill(polygon[:, 0], polygon[:, 1], **look)]
    if drawn:
        drawn[0].set_label(plot_text(label))
    if flat and not number and not {"fill", "color", "facecolor"} & style.keys():
        _fill(ax, flat, axes, gamut.colour_space)
    ax.update_datalim([(0.0, 0.0)])
    _dress(ax, axes.labels)
    entry = _line(label, **line, color=drawn[0].get_edgecolor() if drawn else INK)
    note = gamut.colour_space.name if flat else f"{gamut.colour_space.name} · empty"
    _describe(ax, str(plane_section.gamut), note, [entry], title=axes.title, label=label)
    return ax


def _fill(ax: Any, flat: list[FloatArray], axes: SectionAxes, space: ColourSpace) -> None:  # noqa: ANN401
    """Fill polygons with the colours of their section."""
    from matplotlib.path import Path  # noqa: PLC0415  # optional

    points = np.vstack(flat)
    low, high = points.min(axis=0), points.max(axis=0)
    pixels = section_pixels(axes, space, low.tolist(), high.tolist())
    shape = Path.make_compound_path(*(Path(np.vstack([polygon, polygon[:1]])) for polygon in flat))
    extent = (low[0], high[0], low[1], high[1])
    image = ax.imshow(pixels, extent=extent, interpolation="bilinear", zorder=0.9)
    image.set_clip_path(shape, transform=ax.transData)


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


def plot_rings(
    gamut: GamutLike,
    reference: OtherGamut | None = None,
    ax: Any = None,  # noqa: ANN401  # of matplotlib
    *,
    sectors: int = 360,
    triangles: int | None = None,
    max_error: float | None = None,
    **style: Any,  # noqa: ANN401
) -> Any:  # noqa: ANN401
    """Draw the gamut rings, with the outer one of a reference dashed.

    Parameters
    ----------
    reference : Gamut, str or path, optional
    ax : matplotlib.axes.Axes, optional
        New axes unless given.
    sectors : int, optional
        Number of equal sectors of hue.
    **style
        For `matplotlib.axes.Axes.plot`.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ModuleNotFoundError
        matplotlib is not installed.
    """
    reference = None if reference is None else other_gamut(gamut, reference)
    gamut_rings = rings(gamut, reference, sectors=sectors, triangles=triangles, max_error=max_error)
    ax = new_axes() if ax is None else ax
    name = (reference and reference.name) or "reference"
    draw_rings(ax, gamut_rings, gamut.colour_space, gamut.name, name, **style)
    return ax


def draw_rings(
    ax: Any,  # noqa: ANN401  # of matplotlib
    gamut_rings: GamutRings,
    space: ColourSpace,
    name: str,
    reference_name: str = "reference",
    **style: Any,  # noqa: ANN401
) -> None:
    """Draw rings on axes, with the names of the gamut and of the reference."""
    from matplotlib.collections import PolyCollection  # noqa: PLC0415  # optional
    from matplotlib.patheffects import withStroke  # noqa: PLC0415

    angle = ring_angles(gamut_rings.hues)
    curves = ring_curves(gamut_rings.radius, angle)
    if not ax.collections:
        shapes, colours = zip(*ring_bands(curves, angle, space), strict=True)
        fills = np.array(colours) / 255.0
        ax.add_collection(
            PolyCollection(shapes, facecolors=fills, edgecolors="face", antialiaseds=False)
        )
    names = space.axes
    outer, middle = len(curves) - 1, max(len(curves) // 2 - 1, 0)
    drawn = [
        (ring, {"linewidth": POINTS * (1.8 if number == outer else 0.7)})
        for number, ring in enumerate(curves)
    ]
    handles = []
    if gamut_rings.reference_radius is not None:
        dashed = {"linestyle": LINES[1], "linewidth": 1.6 * POINTS}
        dotted = {"linestyle": LINES[2], "linewidth": 1.2 * POINTS}
        drawn.append((ring_curves(gamut_rings.reference_radius, angle)[-1], dashed))
        handles.append(_line(reference_name, **dashed))
    if gamut_rings.intersection_radius is not None:
        inner = ring_curves(gamut_rings.intersection_radius, angle)
        drawn = [(ring, dotted | {"color": "white"}) for ring in inner] + drawn
        handles.append(_line("intersection", **dotted | {"color": FRAME}))
    for ring, look in drawn:
        closed = np.vstack([ring, ring[:1]])
        ax.plot(closed[:, 0], closed[:, 1], **({"color": INK} | look | style))
    ax.plot(0.0, 0.0, "+", color="white", markersize=14 * POINTS)
    # the labels are where they are farthest apart
    at = (
        len(angle)
        // len(gamut_rings.hues)
        * int(np.argmax(gamut_rings.radius[outer] - gamut_rings.radius[middle]))
    )
    for number in sorted({0, middle, outer}):
        ax.text(
            *curves[number][at],
            f"{names[0]} {number_text(gamut_rings.lightness[number])}",
            fontsize=SMALL * POINTS,
            color=INK,
            va="center",
            zorder=4,
            path_effects=[withStroke(linewidth=3 * POINTS, foreground="white")],
        )
    _dress(ax, (f"{names[1]}$_\\mathrm{{RSS}}$", f"{names[2]}$_\\mathrm{{RSS}}$"))
    note = rings_note(name, gamut_rings.volume)
    _describe(ax, rings_caption(gamut_rings), note, handles, title=RINGS_TITLE, name=name)


def rings_caption(gamut_rings: GamutRings) -> str:
    """Return the conditions of one or two gamuts, and the warnings about their comparison."""
    parts = [str(gamut_rings.gamut)]
    warnings: tuple[str, ...] = ()
    if gamut_rings.gamut is not None and gamut_rings.reference_gamut is not None:
        parts.append(f"reference: {gamut_rings.reference_gamut}")
        warnings = RINGS.pair_warnings(gamut_rings.gamut, gamut_rings.reference_gamut)
    return " ".join(["; ".join(parts), *(f"Warning: {warning}" for warning in warnings)])


def rings_note(name: str, volume: float | None) -> str:
    """Return the second line of the title: the name of the gamut, and its volume."""
    parts = [name] if name else []
    if volume is not None:
        parts.append(f"volume {volume_text(volume)}".replace(",", "\N{NARROW NO-BREAK SPACE}"))
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
    return [np.repeat(radii, times)[:, np.newaxis] * circle for radii in radius]


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


def _dress(ax: Any, labels: tuple[str, str]) -> None:  # noqa: ANN401  # of matplotlib
    """Give axes in the plane the frame, the grid and the labels of all charts."""
    ax.set_facecolor(PAPER)
    ax.set_axisbelow(True)
    ax.grid(visible=True, color=GRID, linewidth=POINTS)
    for line in (ax.axhline, ax.axvline):
        line(0.0, color=ZERO, linewidth=POINTS, zorder=0.6)
    for spine in ax.spines.values():
        spine.set_color(FRAME)
    ax.tick_params(length=0, labelsize=SMALL * POINTS, labelcolor=INK)
    ax.set_xlabel(labels[0], fontsize=LABEL * POINTS, color=INK)
    ax.set_ylabel(labels[1], fontsize=LABEL * POINTS, color=INK)
    ax.use_sticky_edges = False
    ax.margins(0.04)
    ax.autoscale()
    ax.set_aspect("equal")


def _line(label: str, **look: Any) -> Any:  # noqa: ANN401  # of matplotlib
    """Return a line of a legend."""
    from matplotlib.lines import Line2D  # noqa: PLC0415  # optional

    return Line2D([], [], label=plot_text(label), **({"color": INK} | look))


def plot_text(text: str) -> str:
    """Return a text for matplotlib, without the control characters that SVG does not allow.

    What is between dollar signs is mathematics to matplotlib.
    """
    shown = "".join(character for character in text if unicodedata.category(character)[0] != "C")
    return shown.replace("$", r"\$")


class _Described(SimpleNamespace):
    """What the texts around some axes are made of."""

    labels: list[str]
    conditions: dict[str, list[str]]
    lines: list[Any]
    texts: list[Any]


def _described(ax: Any) -> _Described:  # noqa: ANN401  # of matplotlib
    """Return what the texts around some axes are made of; they keep it until they are cleared."""
    drawn: _Described | None = vars(ax).get("described_gamuts")
    if drawn is None or not any(text in ax.texts for text in drawn.texts):
        drawn = ax.described_gamuts = _Described(labels=[], conditions={}, lines=[], texts=[])
    return drawn


def _describe(
    ax: Any,  # noqa: ANN401  # of matplotlib
    conditions: str,
    note: str,
    lines: list[Any],
    *,
    title: str = "",
    label: str = "",
    name: str = "",
) -> None:
    """Add the title, a line below it, a legend of several lines, and the conditions below the axes.

    The labels of the gamuts are the title unless one is given; else they are in the line below.
    `name` says whose conditions they are, if there is no label.
    """
    drawn, flat = _described(ax), ax.name != "3d"
    drawn.labels += [label] if label else []
    drawn.lines += lines
    drawn.conditions.setdefault(conditions, []).extend(filter(None, [label or name]))
    names = ", ".join(drawn.labels)
    if title and names:
        note = f"{names} · {note}"
    for text in drawn.texts:
        if text in ax.texts:
            text.remove()
    look = {"fontsize": SMALL * POINTS, "color": NOTE, "annotation_clip": False}
    size = ax.bbox.width / ax.figure.dpi * 72.0
    wrapped = [
        line
        for text, of in drawn.conditions.items()
        for line in textwrap.wrap(
            plot_text(f"{', '.join(of)}: {text}" if of and len(drawn.conditions) > 1 else text),
            max(20, int(size / (CHARACTER * POINTS))),
        )
    ]
    below = {"xytext": (-40, -38), "textcoords": "offset points", "va": "top"}
    above = {"xytext": (0, 6), "textcoords": "offset points"}
    drawn.texts = [
        ax.annotate(plot_text(note), (0, 1), xycoords="axes fraction", **above, **look),
        ax.annotate("\n".join(wrapped), (0, 0), xycoords="axes fraction", **below, **look),
    ]
    strong = {"fontsize": TITLE * POINTS, "fontweight": "bold", "color": INK}
    ax.set_title(plot_text(title or names), loc="left", y=1.0, pad=22, **strong)
    if len(drawn.lines) > (1 if label else 0):
        ax.legend(
            handles=drawn.lines,
            loc="best" if flat else "upper right",
            fontsize=SMALL * POINTS,
            labelcolor=NOTE,
            edgecolor="none",
            markerfirst=False,
        )


def figure() -> Any:  # noqa: ANN401  # of matplotlib, which is optional
    """Return a new figure of matplotlib that needs no window.

    Raises
    ------
    ModuleNotFoundError
        matplotlib is not installed; the message says how to install it.
    """
    if importlib.util.find_spec("matplotlib") is None:
        raise ModuleNotFoundError(
            "matplotlib is not installed. Install it with: pip install "
            "'gamut-boundary-service[plot]'",
            name="matplotlib",
        )
    from matplotlib.figure import Figure  # noqa: PLC0415

    return Figure(figsize=SIZE, layout="compressed")


def new_axes(**kind: Any) -> Any:  # noqa: ANN401  # of matplotlib
    """Return new axes that a notebook or a window shows, as `pyplot` makes them."""
    figure()
    import matplotlib.pyplot as plt  # noqa: PLC0415

    return plt.figure(figsize=SIZE, layout="compressed").add_subplot(**kind)
