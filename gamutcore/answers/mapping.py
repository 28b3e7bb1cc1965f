"""Gamut mapping: colours are moved into the gamut by one of the usual methods."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Self, cast

import numpy as np

from gamutcore import queries
from gamutcore.answers.base import Answering
from gamutcore.answers.conditions import colour_warnings, comparison_warnings
from gamutcore.answers.picture_mapping import BLUE_TURNS, map_picture, turns_blue
from gamutcore.arguments import Choice, check_option
from gamutcore.colour_rows import colour_rows
from gamutcore.colours import ICC_D50, compensate_black, luminance_of_black
from gamutcore.content import content_of
from gamutcore.errors import OptionError
from gamutcore.queries import delta_e_2000
from gamutcore.results import MappedColours

if TYPE_CHECKING:
    from gamutcore.answers.base import IndexedLevel
    from gamutcore.answers.picture_mapping import MappedPicture
    from gamutcore.arrays import FloatArray
    from gamutcore.colour_rows import Colours
    from gamutcore.export.picture_file import Depth
    from gamutcore.queries import MappingMethod

__all__ = ["METHOD", "MappingAnswers"]

METHOD = Annotated[
    str,
    Choice(
        ("clip-nearest", "clip-hue", "clip-lightness", "clip-chroma", "clip-focal", "sgck"),
        {"hpminde": "clip-hue"},
    ),
]
"""Methods of mapping."""

NAMES = ("the gamut", "the source")
"""The two gamuts of a mapping, in warnings."""

ROUNDING = 1e-9
"""A change of less than this share of `default_error` is a rounding error, and no move."""


class MappingAnswers(Answering):
    """Gamut mapping."""

    def map(
        self,
        colours: Colours,
        method: str = "clip-hue",
        *,
        focus: Colours | Literal["cusp"] | None = None,
        source: Self | str | os.PathLike[str] | None = None,
        black_point_compensation: bool = False,
        space: str | None = None,
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> MappedColours:
        """Map colours into the gamut.

        Parameters
        ----------
        colours : (..., 3) array_like
        method : str, optional
            ``"clip-nearest"``: to the nearest colour. ``"clip-hue"``: to the nearest colour of the
            same hue (HPMINDE, CIE 156:2004). ``"clip-lightness"``: the chroma stays.
            ``"clip-chroma"``: the lightness stays. ``"clip-focal"``: towards a focal point.
            ``"sgck"``: compression from a source gamut (CIE 156:2004).
        focus : (3,) array_like or "cusp", optional
            Focal point of ``"clip-focal"``, in the space of the colours; ``"cusp"``, the default,
            is the lightness of the cusp on the neutral axis.
        source : Gamut, str or path, optional
            The gamut that ``"sgck"`` maps from, in the same space; the name of a reference or a
            file as for `compare`.
        black_point_compensation : bool, optional
            Whether colours are first scaled in CIEXYZ, so that black, L* = 0, becomes the darkest
            neutral colour of the gamut, and white stays (ISO 18619). Not for ``"sgck"``, which maps
            black itself.
        space : str, optional
            Space of the colours, and of the mapped ones; that of the gamut by default.
        triangles, max_error : optional
            The level.

        Returns
        -------
        MappedColours
            With `points`, `moved`, `delta_e` and `device`. Colours inside, and outside within the
            tolerance of `contains` if it is not above `default_error`, stay as they are, except by
            ``"sgck"`` and with black-point compensation.

        Raises
        ------
        InvalidPointsError
            A row is not three finite numbers; ``where["row"]`` names it.
        OptionError
            There is no such method or space; `focus`, `source` or `black_point_compensation` does
            not apply.
        TriangleCountError
            There is no such level.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> Gamut(cube).map((50, 30, 0), "clip-chroma").points.round(3).tolist()
        [50.0, 10.0, 0.0]
        """
        return self._mapped(
            colours,
            method,
            focus=focus,
            source=source,
            black=0.0 if black_point_compensation else None,
            space=space,
            triangles=triangles,
            max_error=max_error,
        )

    def _mapped(
        self,
        colours: Colours,
        method: str,
        *,
        focus: Colours | Literal["cusp"] | None,
        source: Self | str | os.PathLike[str] | None,
        black: float | None,
        space: str | None,
        triangles: int | None,
        max_error: float | None,
    ) -> MappedColours:
        """Map colours whose black has a luminance, which is compensated unless it is None."""
        name = cast("MappingMethod", check_option("method", method, METHOD))
        rows, conversion = self._asked(colours, space)
        if name == "clip-nearest":
            level = self._level(triangles, max_error)
        else:
            level = self._level_with_hue(triangles, max_error)
        if focus is not None and not isinstance(focus, str):
            focus = conversion.to_gamut(colour_rows(focus, "focus").points)[0]
        origin = None
        if source is not None:
            source = self._same_space(source)
            origin = source._level(triangles, max_error).index  # noqa: SLF001  # its own class
        start = rows.points
        if black is not None:
            if name == "sgck":
                raise OptionError.not_applicable(
                    "black_point_compensation", value=True, why="sgck maps black itself"
                )
            start = self._with_black(start, black, level)
        warnings = colour_warnings(self.conditions, conversion.name)
        if source is not None:
            warnings += comparison_warnings(self.conditions, source.conditions, NAMES)
        found = queries.map_colours(start, level.index, name, focus=focus, source=origin)
        points = found.points
        if name != "sgck":
            # the level may miss colours of the device by its error
            limit = min(self.tolerance(triangles=level.triangles), self.default_error)
            kept = queries.contains(start, level.index, limit)
            points[kept] = start[kept]
        device, channels = self._device(level, found.faces, found.weights)
        difference = delta_e_2000(self._lab(rows.points), self._lab(points))
        moved = np.abs(points - rows.points).max(axis=1, initial=0.0)
        return MappedColours(
            points=rows.in_shape(conversion.from_gamut(points)),
            device=None if device is None else rows.in_shape(device),
            channels=channels,
            triangles=level.triangles,
            max_error=level.max_error,
            gamut=self.conditions,
            warnings=warnings,
            moved=rows.in_shape(moved > ROUNDING * self.default_error),
            delta_e=rows.in_shape(difference),
        )

    def _with_black(self, points: FloatArray, black: float, level: IndexedLevel) -> FloatArray:
        """Return points in the space of the gamut, with its black in place of another one."""
        space, as_measured = self.colour_space, self._as_measured
        own = self._black(level)
        if own == black:
            return points
        xyz = space.tristimulus(points, as_measured=as_measured)
        scaled = compensate_black(xyz, black, own)
        return space.from_tristimulus(scaled, as_measured=as_measured)[0]

    def _black(self, level: IndexedLevel) -> float:
        """Return the luminance of the darkest neutral colour."""
        space, as_measured = self.colour_space, self._as_measured
        ends = np.stack([np.zeros(3), ICC_D50])
        (black, white), _ = space.from_tristimulus(ends, as_measured=as_measured)
        found = queries.crossings(black[np.newaxis], white[np.newaxis], level.index, "ray")
        if len(found.t) == 0:
            raise OptionError.not_applicable(
                "black_point_compensation", value=True, why="the gamut has no neutral colours"
            )
        if not found.entering[0]:  # black is in gamut
            return 0.0
        xyz = space.tristimulus(found.points[:1], as_measured=as_measured)
        return luminance_of_black(xyz[0])

    def map_picture(
        self,
        picture: str | os.PathLike[str] | bytes,
        output: str | os.PathLike[str],
        method: str = "clip-hue",
        *,
        focus: Colours | Literal["cusp"] | None = None,
        source: Self | str | os.PathLike[str] | None = None,
        black_point_compensation: bool = False,
        depth: Depth | None = None,
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> MappedPicture:
        """Map the colours of a picture file into the gamut, and write the result.

        Parameters
        ----------
        picture : path or bytes
            A file of gray or RGB. An embedded profile, or the encoding that the file declares,
            gives the colours, relative to its white; sRGB is assumed without one.
        output : path
            A .png, .tif, .exr or .jpg file. It has the encoding, the depth, the profile and the
            alpha of the picture.
        depth : {"8", "16", "half", "float"}, optional
            Another depth: 8 or 16 bits, or floats of 16 or 32 bits. PNG has no floats, and TIFF no
            half floats, which become floats there by default. Integers of a picture in linear light
            are sRGB, with straight alpha.
        method, focus, source : optional
            As for `map`; a focal point is in CIELAB.
        black_point_compensation : bool, optional
            As for `map`, from the black of the picture's profile or encoding.
        triangles, max_error : optional
            The level; by default the full boundary.

        Returns
        -------
        MappedPicture
            Numbers of pixels: all, moved, and those whose mapped colour the encoding cannot store.

        Raises
        ------
        GamutError
            The picture cannot be read, or is neither gray nor RGB; the output cannot store it; or
            as for `map`.
        OSError
            A file cannot be read or written.

        Notes
        -----
        Rows are read, mapped and written in parts, so memory is bounded by the size of the file
        and some ten megabytes. Pixels in gamut keep their values exactly. Transparent pixels stay.
        """
        data = content_of(picture)
        source = None if source is None else self._same_space(source)
        if triangles is None and max_error is None:
            max_error = 0.0  # edges of a coarser level are visible as arcs

        by_lab_hue = self.colour_space.name == "CIELAB" and method != "clip-nearest"
        turned = False

        def mapped(lab: FloatArray, black: float) -> MappedColours:
            nonlocal turned
            found = self._mapped(
                lab,
                method,
                focus=focus,
                source=source,
                black=black if black_point_compensation else None,
                space="CIELAB",
                triangles=triangles,
                max_error=max_error,
            )
            turned = turned or (by_lab_hue and turns_blue(lab, found.points))
            return found

        done = replace(map_picture(data, Path(output), mapped, depth), gamut=self.conditions)
        if source is not None:
            compared = comparison_warnings(self.conditions, source.conditions, NAMES)
            done = replace(done, warnings=(*done.warnings, *compared))
        return replace(done, warnings=(*done.warnings, BLUE_TURNS)) if turned else done
