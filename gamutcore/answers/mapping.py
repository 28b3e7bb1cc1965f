"""Gamut mapping: colours are moved into the gamut by one of the usual methods."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self, cast

from gamutcore import queries
from gamutcore.answers.base import Answering
from gamutcore.answers.picture_mapping import map_picture
from gamutcore.answers.results import MappedColours
from gamutcore.colour_rows import colour_rows
from gamutcore.content import content_of
from gamutcore.option_types import Choice, check_option
from gamutcore.queries.colour_difference import delta_e_2000

if TYPE_CHECKING:
    from gamutcore.answers.picture_mapping import MappedPicture
    from gamutcore.arrays import FloatArray
    from gamutcore.colour_rows import Colours
    from gamutcore.export.picture_file import Depth
    from gamutcore.queries.mapping import Method

__all__ = ["METHOD", "MappingAnswers"]

METHOD = Choice(
    ("clip-nearest", "clip-hue", "clip-lightness", "clip-chroma", "clip-focal", "sgck"),
    {"hpminde": "clip-hue"},
)
"""Methods of mapping."""


class MappingAnswers(Answering):
    """Gamut mapping."""

    def map(
        self,
        colours: Colours,
        method: str = "clip-hue",
        *,
        focus: Colours | Literal["cusp"] | None = None,
        source: Self | str | os.PathLike[str] | None = None,
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
        space : str, optional
            Space of the colours, and of the mapped ones; that of the gamut by default.
        triangles, max_error : optional
            The level.

        Returns
        -------
        MappedColours
            With `points`, `moved`, `delta_e` and `device`. Colours inside stay as they are, except
            by ``"sgck"``.

        Raises
        ------
        InvalidPointsError
            A row is not three finite numbers; ``where["row"]`` names it.
        OptionError
            There is no such method or space, or `focus` or `source` does not apply.
        TriangleCountError
            There is no such level.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> Gamut(cube).map((50, 30, 0), "clip-chroma").points.round(3).tolist()
        [50.0, 10.0, 0.0]
        """
        name = cast("Method", check_option("method", method, METHOD))
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
        found = queries.map_colours(rows.points, level.index, name, focus=focus, source=origin)
        device, channels = self._device(level, found.faces, found.weights)
        difference = delta_e_2000(self._lab(rows.points), self._lab(found.points))
        return MappedColours(
            points=rows.in_shape(conversion.from_gamut(found.points)),
            device=None if device is None else rows.in_shape(device),
            channels=channels,
            triangles=level.triangles,
            max_error=level.max_error,
            moved=rows.in_shape(found.moved),
            delta_e=rows.in_shape(difference),
        )

    def map_picture(
        self,
        picture: str | os.PathLike[str] | bytes,
        output: str | os.PathLike[str],
        method: str = "clip-hue",
        *,
        focus: Colours | Literal["cusp"] | None = None,
        source: Self | str | os.PathLike[str] | None = None,
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
        triangles, max_error : optional
            The level.

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
        options: dict[str, Any] = {"focus": focus, "source": source}
        level: dict[str, Any] = {"triangles": triangles, "max_error": max_error}

        def mapped(lab: FloatArray) -> MappedColours:
            return self.map(lab, method, space="CIELAB", **options, **level)

        return map_picture(data, Path(output), mapped, depth)
