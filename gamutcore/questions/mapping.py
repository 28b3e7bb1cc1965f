"""Gamut mapping: colours and pictures are moved into the gamut by one of the usual methods."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, cast

import numpy as np

from gamutcore import queries
from gamutcore.arguments import Boolean, Choice, Coordinates, check_option
from gamutcore.colour_rows import colour_rows
from gamutcore.colours import ICC_D50, compensate_black, luminance_of_black
from gamutcore.errors import OptionError
from gamutcore.queries import delta_e_2000
from gamutcore.questions.conditions import colour_warnings, comparison_warnings
from gamutcore.questions.declarations import (
    BOOLEAN,
    COLOUR,
    DEVICE,
    NUMBER,
    OTHER_GAMUT,
    Column,
    Parameter,
    Question,
    list_of,
)
from gamutcore.questions.levels import (
    answering_level,
    colours_in,
    is_as_measured,
    lab_of,
    level_with_hue,
    surface_facts,
    tolerance_of,
)
from gamutcore.questions.picture_mapping import BLUE_TURNS, map_picture, turns_blue
from gamutcore.results import MappedColours

if TYPE_CHECKING:
    import os

    from gamutcore.arrays import FloatArray
    from gamutcore.colour_rows import ColourRows, Colours
    from gamutcore.colours import ColourConversion
    from gamutcore.export.picture_file import Depth
    from gamutcore.queries import MappingMethod
    from gamutcore.questions.levels import AskedGamut, IndexedLevel
    from gamutcore.questions.picture_mapping import MappedPicture

__all__ = ["MAP", "METHOD", "map_colours", "map_picture_file", "map_points"]

METHOD = Annotated[
    str,
    Choice(
        ("clip-nearest", "clip-hue", "clip-lightness", "clip-chroma", "clip-focal", "sgck"),
        {"hpminde": "clip-hue"},
    ),
]
"""Methods of mapping."""

ROUNDING = 1e-9
"""A change of less than this share of `default_error` is a rounding error, and no move."""

_warnings = partial(comparison_warnings, names=("the gamut", "the source"))


def map_colours(
    gamut: AskedGamut,
    colours: Colours,
    method: str = "clip-hue",
    *,
    focus: Colours | Literal["cusp"] | None = None,
    source: AskedGamut | None = None,
    black_point_compensation: bool = False,
    black: float = 0.0,
    space: str | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> MappedColours:
    """Map colours into the gamut. `black` is the luminance of their black."""
    done = _mapped(
        gamut,
        colours,
        method,
        focus=focus,
        source=source,
        black_point_compensation=black_point_compensation,
        black=black,
        space=space,
        triangles=triangles,
        max_error=max_error,
    )
    rows, points = done.rows, done.points
    difference = delta_e_2000(lab_of(gamut, rows.points), lab_of(gamut, points))
    moved = np.abs(points - rows.points).max(axis=1, initial=0.0)
    return MappedColours(
        points=rows.in_shape(done.conversion.from_gamut(points)),
        warnings=done.warnings,
        moved=rows.in_shape(moved > ROUNDING * gamut.default_error),
        delta_e=rows.in_shape(difference),
        **surface_facts(gamut, done.level, done.found, rows),
    )


def map_points(gamut: AskedGamut, colours: FloatArray, method: str, **how: Any) -> FloatArray:  # noqa: ANN401
    """Return the points of `map_colours` alone, (n, 3), in three quarters of its time.

    `how` has the parameters of `map_colours`.
    """
    done = _mapped(gamut, colours, method, **how)
    return done.conversion.from_gamut(done.points)


class _Mapping(NamedTuple):
    """Colours in the space of the gamut before and after mapping, and how they were mapped."""

    rows: ColourRows
    points: FloatArray
    conversion: ColourConversion
    level: IndexedLevel
    found: queries.Mapped
    warnings: tuple[str, ...]


def _mapped(
    gamut: AskedGamut,
    colours: Colours,
    method: str,
    *,
    focus: Colours | Literal["cusp"] | None = None,
    source: AskedGamut | None = None,
    black_point_compensation: bool = False,
    black: float = 0.0,
    space: str | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> _Mapping:
    name = cast("MappingMethod", check_option("method", method, METHOD))
    rows, conversion = colours_in(gamut, colours, space)
    find_level = answering_level if name == "clip-nearest" else level_with_hue
    level = find_level(gamut, triangles, max_error)
    if focus is not None and not isinstance(focus, str):
        focus = conversion.to_gamut(colour_rows(focus, "focus").points)[0]
    origin = None if source is None else answering_level(source, triangles, max_error).index
    start = rows.points
    if black_point_compensation:
        if name == "sgck":
            raise OptionError.not_applicable(
                "black_point_compensation", value=True, why="sgck maps black itself"
            )
        start = _with_black(gamut, start, black, level)
    warnings = colour_warnings(gamut.conditions, conversion.name)
    if source is not None:
        warnings += _warnings(gamut.conditions, source.conditions)
    found = queries.map_colours(start, level.index, name, focus=focus, source=origin)
    points = found.points
    if name != "sgck":
        # the level may miss colours of the device by its error
        limit = min(tolerance_of(gamut, level.triangles), gamut.default_error)
        kept = queries.contains(start, level.index, limit)
        points[kept] = start[kept]
    return _Mapping(rows, points, conversion, level, found, warnings)


def _with_black(
    gamut: AskedGamut, points: FloatArray, black: float, level: IndexedLevel
) -> FloatArray:
    """Return points in the space of the gamut, with its black in place of another one."""
    space, as_measured = gamut.colour_space, is_as_measured(gamut)
    own = _black(gamut, level)
    if own == black:
        return points
    xyz = space.tristimulus(points, as_measured=as_measured)
    scaled = compensate_black(xyz, black, own)
    return space.from_tristimulus(scaled, as_measured=as_measured)[0]


def _black(gamut: AskedGamut, level: IndexedLevel) -> float:
    """Return the luminance of the darkest neutral colour."""
    space, as_measured = gamut.colour_space, is_as_measured(gamut)
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


MAP = Question(
    "map",
    "mapColours",
    "Map colours into the gamut",
    "Each colour, moved into the gamut by a usual method. Colours inside stay as they are, except "
    "by `sgck` and with `black_point_compensation`.",
    (
        Parameter(
            "method",
            METHOD,
            "`clip-nearest`: to the nearest colour. `clip-hue`: to the nearest of the same hue "
            "(HPMINDE, CIE 156:2004). `clip-lightness`: the chroma stays. `clip-chroma`: the "
            "lightness stays. `clip-focal`: towards `focus`. `sgck`: compression from the gamut "
            "`source` (CIE 156:2004).",
            default="clip-hue",
        ),
        Parameter(
            "focus",
            Annotated[str, Choice(("cusp",))] | Coordinates,
            "Focal point of `clip-focal`, in the space of the colours. `cusp`: the lightness of "
            "the cusp on the neutral axis.",
        ),
        Parameter(
            "source",
            OTHER_GAMUT,
            "Gamut that `sgck` maps from, in the same space: an id, or the slug of a reference "
            "gamut.",
            example="srgb",
        ),
        Parameter(
            "black_point_compensation",
            Annotated[bool, Boolean()],
            "Whether colours are first scaled in CIEXYZ, so that L* = 0 becomes the darkest "
            "neutral colour of the gamut, and white stays (ISO 18619). Not for `sgck`.",
            default=False,
        ),
    ),
    map_colours,
    inputs=("colours",),
    columns=(
        Column("mapped", "The mapped colour.", COLOUR, "axes", "points"),
        Column("moved", "Whether the colour has another place.", BOOLEAN),
        Column("delta_e_2000", "Colour difference CIEDE2000.", NUMBER, "", "delta_e"),
        replace(
            DEVICE,
            description=f"{DEVICE.description} Null inside.",
            schema=list_of({"type": ["number", "null"]}),
        ),
    ),
    other="source",
    compared=_warnings,
    example={"colours": [[50, 90, 0]], "method": "clip-chroma"},
    answered={
        "mapped": [[50, 75.9, 0]],
        "moved": [True],
        "delta_e_2000": [3.3],
        "device": [[0.0, 1.0, 0.05, 0.02]],
    },
)


def map_picture_file(
    gamut: AskedGamut,
    data: bytes,
    output: str | os.PathLike[str],
    method: str = "clip-hue",
    *,
    focus: Colours | Literal["cusp"] | None = None,
    source: AskedGamut | None = None,
    black_point_compensation: bool = False,
    depth: Depth | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> MappedPicture:
    """Map the colours of a picture file, and write the result."""
    if triangles is None and max_error is None:
        max_error = 0.0  # edges of a coarser level are visible as arcs
    by_lab_hue = gamut.colour_space.name == "CIELAB" and method != "clip-nearest"
    turned = False

    def mapped(lab: FloatArray, black: float) -> MappedColours:
        nonlocal turned
        found = map_colours(
            gamut,
            lab,
            method,
            focus=focus,
            source=source,
            black_point_compensation=black_point_compensation,
            black=black,
            space="CIELAB",
            triangles=triangles,
            max_error=max_error,
        )
        turned = turned or (by_lab_hue and turns_blue(lab, found.points))
        return found

    done = replace(map_picture(data, Path(output), mapped, depth), gamut=gamut.conditions)
    if source is not None:
        compared = _warnings(gamut.conditions, source.conditions)
        done = replace(done, warnings=(*done.warnings, *compared))
    return replace(done, warnings=(*done.warnings, BLUE_TURNS)) if turned else done
