"""Pictures of a gamut: as PNG, in notebooks, and with matplotlib, which is the extra ``plot``.

The picture in notebooks is SVG. The faces of a coarse level are projected along a fixed direction
and filled with their own colours. Faces that look away are left out. The others are drawn from back
to front.
"""

from __future__ import annotations

import importlib.util
from html import escape
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from gamutcore.arguments import Array, Boolean, Choice, FiniteNumber, Number, WholeNumber
from gamutcore.colours.spaces import srgb
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
from gamutcore.questions.declarations import Parameter, Question
from gamutcore.questions.levels import answering_level
from gamutcore.questions.shape import rings, rings_caption, section

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gamutcore.arrays import FloatArray, PositionArray
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.questions.levels import AskedGamut

__all__ = [
    "MOST_DRAWN_TRIANGLES",
    "PICTURE",
    "PNG_KEYWORD",
    "face_colours",
    "figure",
    "new_axes",
    "notebook_html",
    "picture",
    "plot",
    "plot_rings",
    "plot_slice",
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

AZIMUTH, ELEVATION = np.radians(-35.0), np.radians(25.0)
"""Direction of the viewer of the picture in notebooks: in front of the blue and purple hues, from
above."""


def picture(
    gamut: AskedGamut,
    size: int = DEFAULT_SIZE,
    view: str | Sequence[float] = "standard",
    *,
    background: str = "white",
    axes: bool = True,
    triangles: int | None = None,
    max_error: float | None = None,
) -> bytes:
    """Return a picture of a gamut as PNG, drawn without matplotlib."""
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


def notebook_html(gamut: AskedGamut) -> str:
    """Return a picture and the key figures, for notebooks."""
    space, description = gamut.colour_space, gamut.description
    lowest, highest = description["bounds"]
    facts = {
        "space": space.name,
        "channels": " ".join(map(str, description["provenance"].get("channels") or ["-"])),
        "volume": f"{description['volume']:.6g}",
        **{
            axis: f"{low:.4g} to {high:.4g}"
            for axis, low, high in zip(space.axes, lowest, highest, strict=True)
        },
        "triangles": f"4 to {gamut.history.triangles}",
        "id": f"{description['id'][:12]}…",
    }
    rows = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th><td>{escape(value)}</td></tr>"
        for name, value in facts.items()
    )
    count = min(NOTEBOOK_TRIANGLES, gamut.history.triangles)
    picture = svg_picture(gamut.history.level(count), space)
    return (
        f"<div style='display:flex;align-items:center;gap:1em'>{picture}<table>{rows}</table></div>"
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
    gamut: AskedGamut,
    ax: Any = None,  # noqa: ANN401  # of matplotlib, which is optional
    *,
    triangles: int | None = None,
    max_error: float | None = None,
    **style: Any,  # noqa: ANN401
) -> Any:  # noqa: ANN401
    """Draw a gamut in three dimensions with its own colours."""
    if ax is None:
        ax = new_axes(projection="3d")
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # noqa: PLC0415  # optional

    if triangles is None and max_error is None:
        triangles = min(PLOT_TRIANGLES, gamut.history.triangles)
    index = answering_level(gamut, triangles, max_error).index
    mesh = TriangleMesh(index.vertices, index.faces)
    place = _upright(mesh.vertices, gamut.colour_space)
    colours = face_colours(mesh, gamut.colour_space)
    look = {"facecolors": colours, "edgecolors": colours, "linewidths": 0.2} | style
    ax.add_collection3d(Poly3DCollection(place[mesh.faces], **look))
    lowest, highest = place.min(axis=0), place.max(axis=0)
    axes = list(gamut.colour_space.axes)
    up = axes.pop(gamut.colour_space.definition.lightness)
    for name, label, low, high in zip("xyz", [*axes, up], lowest, highest, strict=True):
        limits = sorted([low, high, *getattr(ax, f"get_{name}lim")()])
        is_first = len(ax.collections) == 1
        ax.set(**{f"{name}lim": (low, high) if is_first else (limits[0], limits[-1])})
        ax.set(**{f"{name}label": label})
    _caption(ax, str(gamut.conditions))
    ax.set_box_aspect(np.ptp([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()], axis=1))
    return ax


def plot_slice(
    gamut: AskedGamut,
    lightness: float | None = None,
    ax: Any = None,  # noqa: ANN401  # of matplotlib
    *,
    hue: float | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
    **style: Any,  # noqa: ANN401
) -> Any:  # noqa: ANN401
    """Draw a section by a lightness, or a hue leaf."""
    found = section(gamut, lightness, hue=hue, triangles=triangles, max_error=max_error)
    ax = new_axes() if ax is None else ax
    place = gamut.colour_space.definition.lightness
    names = list(gamut.colour_space.axes)
    up = names.pop(place)
    # the next colour of the cycle of matplotlib
    look = {"fill": False, "edgecolor": f"C{len(ax.patches) % 10}"} | style
    for polygon in found.polygons:
        flat = np.delete(polygon, place, axis=1)
        if hue is not None:
            turn = np.radians(hue)
            chroma = flat @ (np.cos(turn), np.sin(turn))
            flat = np.stack([chroma, polygon[:, place]], axis=1)
        ax.fill(flat[:, 0], flat[:, 1], **look)
    _caption(ax, str(found.gamut))
    ax.set_xlabel(names[0] if hue is None else f"chroma at {hue:g}°")
    ax.set_ylabel(names[1] if hue is None else up)
    ax.set_aspect("equal")
    return ax


def plot_rings(
    gamut: AskedGamut,
    reference: AskedGamut | None = None,
    ax: Any = None,  # noqa: ANN401  # of matplotlib
    *,
    sectors: int = 360,
    triangles: int | None = None,
    max_error: float | None = None,
    **style: Any,  # noqa: ANN401
) -> Any:  # noqa: ANN401
    """Draw the gamut rings, with those of a reference dashed."""
    found = rings(gamut, reference, sectors=sectors, triangles=triangles, max_error=max_error)
    ax = new_axes() if ax is None else ax
    turn = np.radians(np.append(found.hues, found.hues[0]))
    drawn = [(found.radius, {"color": "black", "linewidth": 1.0})]
    if found.reference_radius is not None:
        drawn.append((found.reference_radius, {"color": "gray", "linestyle": "--"}))
    for radii, look in drawn:
        for ring in radii:
            radius = np.append(ring, ring[0])
            ax.plot(radius * np.cos(turn), radius * np.sin(turn), **(look | style))
    ax.set_aspect("equal")
    _caption(ax, rings_caption(found))
    ax.set_xlabel(f"{gamut.colour_space.axes[1]} direction, area = volume")
    return ax


def _caption(ax: Any, text: str) -> None:  # noqa: ANN401  # of matplotlib
    """Add a line to the title of some axes, unless it is there."""
    lines = [line for line in ax.get_title().splitlines() if line]
    if text not in lines:
        ax.set_title("\n".join([*lines, text]), fontsize="small")


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

    return Figure(figsize=(6, 6))


def new_axes(**kind: Any) -> Any:  # noqa: ANN401  # of matplotlib
    """Return new axes that a notebook or a window shows, as `pyplot` makes them."""
    figure()
    import matplotlib.pyplot as plt  # noqa: PLC0415

    return plt.figure().add_subplot(**kind)
