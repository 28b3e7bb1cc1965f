"""Pictures of a gamut: in notebooks, and with matplotlib, which is the extra ``plot``."""

from __future__ import annotations

import importlib.util
from html import escape
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from gamutcore.answers.picture import face_colours, svg_picture, upright
from gamutcore.answers.sections import SectionAnswers
from gamutcore.export import leaf_axes, lightness_axes, plane_axes, rings_svg, section_svg
from gamutcore.export.rendering import DEFAULT_SIZE, PICTURE_TRIANGLES, mesh_picture
from gamutcore.geometry import TriangleMesh
from gamutcore.levels import LevelRequest

if TYPE_CHECKING:
    import os
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from gamutcore.answers.base import IndexedLevel
    from gamutcore.results import GamutRings

__all__ = ["DrawingAnswers", "figure", "new_axes"]

NOTEBOOK_TRIANGLES = 400
"""Triangles of the picture in a notebook: 25 kB of SVG, and smooth."""

PNG_KEYWORD = "Gamut"
"""Keyword of the conditions among the texts of a PNG file."""

PLOT_TRIANGLES = 2000
"""Triangles of a plot; matplotlib draws them in a tenth of a second."""


class DrawingAnswers(SectionAnswers):
    """The pictures of a gamut."""

    def _repr_html_(self) -> str:
        """Return a picture and the key figures, for notebooks."""
        space, description = self.colour_space, self.description
        lowest, highest = description["bounds"]
        facts = {
            "space": space.name,
            "channels": " ".join(map(str, description["provenance"].get("channels") or ["-"])),
            "volume": f"{description['volume']:.6g}",
            **{
                axis: f"{low:.4g} to {high:.4g}"
                for axis, low, high in zip(space.axes, lowest, highest, strict=True)
            },
            "triangles": f"4 to {self.history.triangles}",
            "id": f"{description['id'][:12]}…",
        }
        rows = "".join(
            f"<tr><th style='text-align:left'>{escape(name)}</th><td>{escape(value)}</td></tr>"
            for name, value in facts.items()
        )
        count = min(NOTEBOOK_TRIANGLES, self.history.triangles)
        picture = svg_picture(self.history.level(count), space)
        return (
            "<div style='display:flex;align-items:center;gap:1em'>"
            f"{picture}<table>{rows}</table></div>"
        )

    def picture(
        self,
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

        Raises
        ------
        OptionError
            An option is not accepted, or a count and a limit are given.
        TriangleCountError
            There is no such level.

        Examples
        --------
        >>> colours = [(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)]
        >>> from gamutcore import Gamut
        >>> Gamut(colours).picture(100)[1:4]
        b'PNG'
        """
        default = min(PICTURE_TRIANGLES, self.history.triangles)
        request = LevelRequest(triangles, max_error).or_default(default)
        return mesh_picture(
            self.history.level(self.search.find(self.history, request).triangles),
            self.colour_space,
            size=size,
            view=view,
            background=background,
            axes=axes,
            texts={PNG_KEYWORD: str(self.conditions)},
        )

    def plot(
        self,
        ax: Any = None,  # noqa: ANN401  # of matplotlib, which is optional
        *,
        triangles: int | None = None,
        max_error: float | None = None,
        **style: Any,  # noqa: ANN401
    ) -> Any:  # noqa: ANN401
        """Draw the gamut in three dimensions with its own colours.

        Parameters
        ----------
        ax : mpl_toolkits.mplot3d.Axes3D, optional
            New axes unless given.
        triangles, max_error : optional
            The level, of 2,000 triangles by default.
        **style
            For `mpl_toolkits.mplot3d.art3d.Poly3DCollection`, such as ``alpha=0.5``.

        Returns
        -------
        mpl_toolkits.mplot3d.Axes3D

        Raises
        ------
        ModuleNotFoundError
            matplotlib is not installed.
        OptionError, TriangleCountError
            As for `contains`.
        """
        if ax is None:
            ax = new_axes(projection="3d")
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # noqa: PLC0415  # optional

        if triangles is None and max_error is None:
            triangles = min(PLOT_TRIANGLES, self.history.triangles)
        mesh = _mesh(self._level(triangles, max_error))
        place = upright(mesh.vertices, self.colour_space)
        colours = face_colours(mesh, self.colour_space)
        look = {"facecolors": colours, "edgecolors": colours, "linewidths": 0.2} | style
        ax.add_collection3d(Poly3DCollection(place[mesh.faces], **look))
        lowest, highest = place.min(axis=0), place.max(axis=0)
        axes = list(self.colour_space.axes)
        up = axes.pop(self.colour_space.definition.lightness)
        for name, label, low, high in zip("xyz", [*axes, up], lowest, highest, strict=True):
            limits = sorted([low, high, *getattr(ax, f"get_{name}lim")()])
            is_first = len(ax.collections) == 1
            ax.set(**{f"{name}lim": (low, high) if is_first else (limits[0], limits[-1])})
            ax.set(**{f"{name}label": label})
        _caption(ax, str(self.conditions))
        ax.set_box_aspect(np.ptp([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()], axis=1))
        return ax

    def plot_slice(
        self,
        L: float | None = None,
        ax: Any = None,  # noqa: ANN401  # of matplotlib
        *,
        hue: float | None = None,
        triangles: int | None = None,
        max_error: float | None = None,
        **style: Any,  # noqa: ANN401
    ) -> Any:  # noqa: ANN401
        """Draw a section by a lightness, or a hue leaf.

        Parameters
        ----------
        L : float, optional
            Lightness.
        ax : matplotlib.axes.Axes, optional
            New axes unless given. Gamuts on the same axes are compared.
        hue : float, optional
            Hue in degrees, instead of a lightness.
        triangles, max_error : optional
            The level.
        **style
            For `matplotlib.axes.Axes.fill`.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        ModuleNotFoundError
            matplotlib is not installed.
        InvalidPointsError, OptionError, TriangleCountError
            As for `slice`.
        """
        found = self.slice(L, hue=hue, triangles=triangles, max_error=max_error)
        ax = new_axes() if ax is None else ax
        lightness = self.colour_space.definition.lightness
        names = list(self.colour_space.axes)
        up = names.pop(lightness)
        look = {"fill": False, "edgecolor": next_colour(ax)} | style
        for polygon in found.polygons:
            flat = np.delete(polygon, lightness, axis=1)
            if hue is not None:
                turn = np.radians(hue)
                chroma = flat @ (np.cos(turn), np.sin(turn))
                flat = np.stack([chroma, polygon[:, lightness]], axis=1)
            ax.fill(flat[:, 0], flat[:, 1], **look)
        _caption(ax, str(found.gamut))
        ax.set_xlabel(names[0] if hue is None else f"chroma at {hue:g}°")
        ax.set_ylabel(names[1] if hue is None else up)
        ax.set_aspect("equal")
        return ax

    def plot_rings(
        self,
        reference: Self | str | os.PathLike[str] | None = None,
        ax: Any = None,  # noqa: ANN401  # of matplotlib
        *,
        sectors: int = 360,
        triangles: int | None = None,
        max_error: float | None = None,
        **style: Any,  # noqa: ANN401
    ) -> Any:  # noqa: ANN401
        """Draw the gamut rings, with those of a reference dashed.

        Parameters
        ----------
        reference : Gamut, str or path, optional
            In the same colour space; the name of a reference or a file as for `compare`.
        ax : matplotlib.axes.Axes, optional
            New axes unless given.
        sectors : int, optional
            Number of equal sectors of hue.
        triangles, max_error : optional
            The levels.
        **style
            For `matplotlib.axes.Axes.plot`.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        ModuleNotFoundError
            matplotlib is not installed.
        OptionError, TriangleCountError
            As for `rings`.
        """
        found = self.rings(reference, sectors=sectors, triangles=triangles, max_error=max_error)
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
        _caption(ax, _rings_caption(found))
        ax.set_xlabel(f"{self.colour_space.axes[1]} direction, area = volume")
        return ax

    def slice_svg(
        self,
        L: float | None = None,
        *,
        hue: float | None = None,
        plane: ArrayLike | None = None,
        name: str = "",
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> bytes:
        """Return a picture of a section as SVG, in the colours that it shows.

        Parameters
        ----------
        L, hue, plane : optional
            One of them, as for `slice`.
        name : str, optional
            Of the gamut, for the title.
        triangles, max_error : optional
            The level.

        Returns
        -------
        bytes
            The same arguments give the same bytes. matplotlib is not needed.

        Raises
        ------
        InvalidPointsError, OptionError, TriangleCountError
            As for `slice`.
        """
        found = self.slice(L, hue=hue, plane=plane, triangles=triangles, max_error=max_error)
        space = self.colour_space
        if L is not None:
            axes = lightness_axes(L, space)
        elif hue is not None:
            axes = leaf_axes(hue, space)
        else:
            numbers = np.asarray(plane, np.float64)
            axes = plane_axes(numbers[:3], float(numbers[3]), space)
        return section_svg(found.polygons, axes, space, name, str(found.gamut))

    def rings_svg(
        self,
        reference: Self | str | os.PathLike[str] | None = None,
        *,
        names: tuple[str, str] = ("", "reference"),
        sectors: int = 360,
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> bytes:
        """Return a picture of the gamut rings as SVG.

        Parameters
        ----------
        reference : Gamut, str or path, optional
            In the same colour space; the name of a reference or a file as for `compare`.
        names : (str, str), optional
            Of the gamut and of the reference, for the title and the legend.
        sectors : int, optional
            Number of equal sectors of hue.
        triangles, max_error : optional
            The levels.

        Returns
        -------
        bytes
            The same arguments give the same bytes. matplotlib is not needed.

        Raises
        ------
        OptionError, TriangleCountError
            As for `rings`.
        """
        found = self.rings(reference, sectors=sectors, triangles=triangles, max_error=max_error)
        return rings_svg(
            found.lightness,
            found.hues,
            found.radius,
            reference_radius=found.reference_radius,
            intersection_radius=found.intersection_radius,
            names=names,
            axes=self.colour_space.axes,
            volume=found.volume,
            caption=_rings_caption(found),
        )


def _rings_caption(found: GamutRings) -> str:
    """Return the conditions of one or two gamuts, and the warnings about them."""
    parts = [str(found.gamut)]
    if found.reference_gamut is not None:
        parts.append(f"reference: {found.reference_gamut}")
    return " ".join(["; ".join(parts), *(f"Warning: {each}" for each in found.warnings)])


def _caption(ax: Any, text: str) -> None:  # noqa: ANN401  # of matplotlib
    """Add a line to the title of some axes, unless it is there."""
    lines = [line for line in ax.get_title().splitlines() if line]
    if text not in lines:
        ax.set_title("\n".join([*lines, text]), fontsize="small")


def next_colour(ax: Any) -> str:  # noqa: ANN401  # of matplotlib
    """Return the colour of the next outline on some axes, from matplotlib's cycle."""
    return f"C{len(ax.patches) % 10}"


def _mesh(level: IndexedLevel) -> TriangleMesh:
    return TriangleMesh(level.index.vertices, level.index.faces)


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
