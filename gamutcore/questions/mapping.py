"""Gamut mapping: colours and pictures are moved into the gamut by one of the usual methods."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

import numpy as np

from gamutcore import search
from gamutcore.arguments import Boolean, Choice, Coordinates, Text, WholeNumber, check_option
from gamutcore.colour_rows import colour_rows
from gamutcore.colours import (
    ColourConversion,
    compensate_black,
    lab_to_xyz,
    luminance_of_black,
)
from gamutcore.errors import OptionError
from gamutcore.export.picture_file import DEPTHS
from gamutcore.questions.black_rules import BLACK
from gamutcore.questions.conditions import build_warnings, colour_warnings, comparison_warnings
from gamutcore.questions.declarations import (
    BOOLEAN,
    COLOUR,
    DEVICE,
    LEVEL_PARAMETERS,
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
from gamutcore.questions.picture_mapping import (
    BLUE_TURNS,
    MOST_NODES,
    PICTURE_SPACE,
    SpatialMoves,
    map_picture,
    turns_blue,
)
from gamutcore.questions.picture_targets import DECODE, OWN, device_target
from gamutcore.questions.picture_targets import DEVICE as TO_DEVICE
from gamutcore.results import AS_GIVEN, MappedColours
from gamutcore.search import delta_e_2000

if TYPE_CHECKING:
    import os
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from gamutcore.arrays import BooleanArray, Float32Array, FloatArray, LongArray
    from gamutcore.colour_rows import Colours
    from gamutcore.export.picture_file import Depth
    from gamutcore.questions.levels import AskedGamut, IndexedLevel
    from gamutcore.questions.picture_mapping import MappedPicture, Moves
    from gamutcore.search import LevelIndex, Lines, Mapped, MappingMethod

__all__ = [
    "COMPENSATION",
    "MAP",
    "METHOD",
    "PICTURE_PARAMETERS",
    "black_luminance",
    "compensates_black",
    "distance_warnings",
    "map_colours",
    "map_picture_file",
    "map_points",
]

_METHODS = ("clip-nearest", "clip-hue", "clip-lightness", "clip-chroma", "clip-focal", "sgck")
_ALIASES = {"hpminde": "clip-hue"}
METHOD = Annotated[str, Choice(_METHODS, _ALIASES)]
"""Methods of mapping."""

SPATIAL = "spatial"
"""Method for pictures alone: colours of a table have no neighbours."""

ITERATIONS = 25
"""Iterations of the spatial mapping: 20 to 30 are enough for Alsam & Farup (2012)."""

MOST_ITERATIONS = 10_000
"""An hour for 24 megapixels."""

SHIFT = 1e-2
"""A shift by less than this share of `default_error` is no move: 16 bits hardly store it."""

ROUNDING = 1e-9
"""A change of less than this share of `default_error` is a rounding error, and no move."""

EQUAL_BLACKS = 1e-6
"""Difference of the luminances of two blacks, of that of white, up to which they count as equal:
L* 0.001."""

_NAMES = "the gamut", "the source"

_warnings = partial(comparison_warnings, names=_NAMES)


def _build_warnings(gamut: AskedGamut, source: AskedGamut | None) -> tuple[str, ...]:
    if source is None or source is gamut:
        return build_warnings(gamut.conditions)
    return build_warnings(gamut.conditions, source.conditions, names=_NAMES)


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
    rows, conversion = colours_in(gamut, colours, space)
    rule = _rule(
        gamut,
        method,
        conversion,
        focus=focus,
        source=source,
        black=black if black_point_compensation else None,
        triangles=triangles,
        max_error=max_error,
    )
    warnings = _build_warnings(gamut, source)
    warnings += colour_warnings(gamut.conditions, conversion.name)
    warnings += distance_warnings(gamut, rule.method)
    if source is not None:
        warnings += _warnings(gamut.conditions, source.conditions)
    level, start = rule.level, rule.start(rows.points)
    found = rule.mapped(start)
    points = found.points
    difference = delta_e_2000(lab_of(gamut, rows.points), lab_of(gamut, points))
    moved = np.abs(points - rows.points).max(axis=1, initial=0.0)
    return MappedColours(
        points=rows.in_shape(conversion.from_gamut(points)),
        space=conversion.name,
        warnings=warnings,
        moved=rows.in_shape(moved > ROUNDING * gamut.default_error),
        delta_e=rows.in_shape(difference),
        **surface_facts(gamut, level, found, rows),
    )


def map_points(
    gamut: AskedGamut,
    lab: FloatArray,
    method: str,
    *,
    focus: Colours | Literal["cusp"] | None = None,
    source: AskedGamut | None = None,
    black_point_compensation: bool = False,
    black: float = 0.0,
    triangles: int | None = None,
    max_error: float | None = None,
) -> FloatArray:
    """Return colours (n, 3) in CIELAB, mapped as by `map_colours`, without what it states."""
    conversion = _from_lab(gamut)
    rule = _rule(
        gamut,
        method,
        conversion,
        focus=focus,
        source=source,
        black=black if black_point_compensation else None,
        triangles=triangles,
        max_error=max_error,
    )
    return conversion.from_gamut(rule.moved(conversion.to_gamut(lab))[1])


def distance_warnings(gamut: AskedGamut, method: str) -> tuple[str, ...]:
    """Return a warning if nearest colours are those of a distance that is no colour difference."""
    space = gamut.colour_space
    if method != "clip-nearest" or space.definition.is_uniform:
        return ()
    warning = (
        f"Distances in {space.name} are not colour differences, and nearest colours may have "
        f"another hue. Take clip-hue, or build the gamut in {PICTURE_SPACE}."
    )
    return (warning,)


def _from_lab(gamut: AskedGamut) -> ColourConversion:
    return ColourConversion("CIELAB", gamut.colour_space, as_measured=is_as_measured(gamut))


@dataclass(frozen=True)
class _Rule:
    """A method with its arguments, and the level that it maps into.

    `focus` is in the space of the gamut. `blacks` has the luminances of the black of the colours
    and of the gamut if the first is compensated.
    """

    gamut: AskedGamut
    method: MappingMethod
    level: IndexedLevel
    focus: Any
    source: LevelIndex | None
    blacks: tuple[float, float] | None

    def start(self, points: FloatArray) -> FloatArray:
        """Return points in the space of the gamut, with its black if it is compensated."""
        if self.blacks is None:
            return points
        space, as_measured = self.gamut.colour_space, is_as_measured(self.gamut)
        xyz = space.tristimulus(points, as_measured=as_measured)
        scaled = compensate_black(xyz, *self.blacks)
        return space.from_tristimulus(scaled, as_measured=as_measured)[0]

    def outside(self, points: FloatArray) -> BooleanArray:
        """Return which points are out of gamut."""
        return ~search.contains(points, self.level.index, self._tolerance)

    def mapped(self, start: FloatArray) -> Mapped:
        """Return the points, mapped into the level. Those within the tolerance are in gamut."""
        return search.map_colours(
            start,
            self.level.index,
            self.method,
            focus=self.focus,
            source=self.source,
            white=self.gamut.colour_space.white_lightness,
            tolerance=self._tolerance,
        )

    def moved(self, own: FloatArray) -> tuple[BooleanArray, FloatArray]:
        """Return which points are out of gamut, and all points after mapping."""
        mapped = self.mapped(self.start(own))
        is_clipping = self.method != "sgck" and self.blacks is None
        return mapped.moved if is_clipping else self.outside(own), mapped.points

    @cached_property
    def _tolerance(self) -> float:
        """The distance by which the level misses colours of the gamut, at most.

        A coarse level's own error is limited, so that colours far outside do not stay. That of the
        full boundary is not: those colours are of the gamut.
        """
        missed: float = self.gamut.description.get("boundary_error", 0.0)
        known = tolerance_of(self.gamut, self.level.triangles) - missed
        return min(known, self.gamut.default_error) + missed


def _rule(
    gamut: AskedGamut,
    method: str,
    conversion: ColourConversion,
    *,
    focus: Colours | Literal["cusp"] | None,
    source: AskedGamut | None,
    black: float | None,
    triangles: int | None,
    max_error: float | None,
) -> _Rule:
    if method == SPATIAL:
        raise OptionError.not_applicable(
            "method",
            method,
            "it keeps the differences between neighbours, and only pixels have neighbours",
            "Map a picture, or give another method.",
        )
    name = cast("MappingMethod", check_option("method", method, METHOD))
    find_level = answering_level if name == "clip-nearest" else level_with_hue
    level = find_level(gamut, triangles, max_error)
    if focus is not None and not isinstance(focus, str):
        focus = conversion.to_gamut(colour_rows(focus, "focus").points)[0]
    if black is not None and name == "sgck":
        raise OptionError.not_applicable(
            "black_point_compensation", value=True, why="sgck maps black itself"
        )
    origin = None if source is None else answering_level(source, triangles, max_error).index
    blacks = None
    if black is not None:
        blacks = black, black_luminance(gamut, level)
        if abs(blacks[1] - black) <= EQUAL_BLACKS:
            blacks = None
    return _Rule(gamut, name, level, focus, origin, blacks)


def black_luminance(gamut: AskedGamut, level: IndexedLevel | None = None) -> float:
    """Return the luminance of the darkest neutral colour, of the full boundary by default."""
    luminance = _darkest_neutral(gamut, level or answering_level(gamut, None, 0.0))
    if luminance is None:
        raise OptionError.not_applicable(
            "black_point_compensation", value=True, why="the gamut has no neutral colours"
        )
    return luminance


def compensates_black(gamut: AskedGamut, method: str) -> bool:
    """Return whether links and pictures have black-point compensation if nothing is asked.

    It is for colours relative to a white (ISO 18619), and `sgck` maps black itself.
    """
    if method == "sgck" or gamut.conditions.intent in {AS_GIVEN, "absolute"}:
        return False
    return _darkest_neutral(gamut, answering_level(gamut, None, 0.0)) is not None


def _darkest_neutral(gamut: AskedGamut, level: IndexedLevel) -> float | None:
    """Return the luminance where the greys enter a level; None if they do not.

    Greys are on a curve in spaces with incomplete adaptation, such as CAM16-UCS.
    """
    space, as_measured = gamut.colour_space, is_as_measured(gamut)
    greys = lab_to_xyz(np.linspace(0.0, 100.0, 101)[:, np.newaxis] * (1.0, 0.0, 0.0))
    points = space.from_tristimulus(greys, as_measured=as_measured)[0]
    if search.contains(points[:1], level.index, ROUNDING * gamut.default_error)[0]:
        return 0.0
    found = search.crossings(points[:-1], points[1:], level.index, "segment")
    if len(found.t) == 0:
        return None
    return luminance_of_black(space.tristimulus(found.points[:1], as_measured=as_measured)[0])


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
            "`clip-nearest`: to the nearest colour, by the distance in the space of the gamut: "
            "ΔE*ab in CIELAB. `clip-hue`: to the nearest of the same hue (HPMINDE, CIE 156:2004)."
            " `clip-lightness`: the chroma stays. `clip-chroma`: the "
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


_OF_PICTURES = (
    Parameter(
        "iterations",
        Annotated[int, WholeNumber(0, MOST_ITERATIONS)],
        f"Iterations of the method `{SPATIAL}`, {ITERATIONS} by default; without one, it is "
        "clipping.",
    ),
    Parameter(
        "depth",
        Annotated[str, Choice(tuple(DEPTHS))],
        "Depth of the picture that is returned, by default that of the picture: bits, or floats.",
    ),
    Parameter(
        "table",
        Annotated[int, WholeNumber(0, MOST_NODES)],
        f"Nodes of a table along each channel, 5 to {MOST_NODES}; 0 maps every colour exactly. By "
        "default, large pictures have one. The report states its error.",
    ),
    Parameter(
        "to",
        Annotated[str, Text(60, f"{OWN}, {TO_DEVICE}, or the slug of an RGB space")],
        f"Encoding of the picture that is returned. `{OWN}`: that of the picture. The slug of an "
        f"RGB space, with its profile. `{TO_DEVICE}`: values of the device as TIFF, such as CMYK, "
        "with the profile that the gamut was built from.",
        default=OWN,
        example="display-p3",
    ),
    Parameter("black", BLACK, "How much black device values have, as for `recipes`.", example=0.5),
)
_METHOD, *_ARGUMENTS, _COMPENSATION = MAP.parameters
COMPENSATION = replace(
    _COMPENSATION,
    description="Whether colours are first scaled in CIEXYZ, so that the black of the source "
    "becomes the darkest neutral colour of the gamut, and white stays (ISO 18619). Default: true "
    "for colours relative to a white, except by `sgck`, which maps black itself.",
    default=None,
)
"""Black-point compensation of links and pictures."""

PICTURE_METHOD = Annotated[str, Choice((*_METHODS, SPATIAL), _ALIASES)]
"""Methods of mapping for pictures."""

PICTURE_PARAMETERS: tuple[Parameter, ...] = (
    replace(
        _METHOD,
        kind=PICTURE_METHOD,
        description=f"{_METHOD.description} `{SPATIAL}`: for pictures, keeps the differences "
        "between neighbouring pixels.",
    ),
    *_ARGUMENTS,
    COMPENSATION,
    DECODE,
    *_OF_PICTURES,
    *LEVEL_PARAMETERS,
)
"""Parameters of `map_picture_file`, without the heat map."""


def map_picture_file(
    gamut: AskedGamut,
    data: bytes,
    output: str | os.PathLike[str],
    method: str = "clip-hue",
    *,
    focus: Colours | Literal["cusp"] | None = None,
    source: AskedGamut | None = None,
    black_point_compensation: bool | None = None,
    decode: str | None = None,
    iterations: int | None = None,
    depth: Depth | None = None,
    table: int | None = None,
    heat_map: str | os.PathLike[str] | None = None,
    to: str = OWN,
    black: str | float | ArrayLike | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> MappedPicture:
    """Map the colours of a picture file, and write the result."""
    method = str(check_option("method", method, PICTURE_METHOD))
    is_spatial = method == SPATIAL
    if is_spatial:
        given = {"focus": focus, "source": None if source is None else "of another gamut"}
        _check_spatial(given | {"table": table or None})
        table = 0
    elif iterations is not None:
        message = "only the method spatial has iterations"
        raise OptionError.not_applicable("iterations", iterations, message)
    iterations = ITERATIONS if iterations is None else iterations
    if not 0 <= iterations <= MOST_ITERATIONS:
        raise OptionError.refusal("iterations", iterations, f"0 to {MOST_ITERATIONS}")
    if black is not None and to != TO_DEVICE:
        raise OptionError.not_applicable(
            "black", black, f"only device values (to={TO_DEVICE}) need it"
        )
    if triangles is None and max_error is None:
        max_error = 0.0  # edges of a coarser level are visible as arcs
    if black_point_compensation is None:
        black_point_compensation = compensates_black(gamut, method)
    by_lab_hue = gamut.colour_space.name == "CIELAB" and method != "clip-nearest"
    turned = False
    conversion = _from_lab(gamut)

    def moves_from(black: float) -> Moves | SpatialMoves:
        rule = _rule(
            gamut,
            "clip-hue" if is_spatial else method,
            conversion,
            focus=focus,
            source=source,
            black=black if black_point_compensation else None,
            triangles=triangles,
            max_error=max_error,
        )
        negligible = ROUNDING * gamut.default_error

        def moves(lab: FloatArray) -> tuple[BooleanArray, LongArray, FloatArray]:
            nonlocal turned
            own = conversion.to_gamut(lab)
            outside, points = rule.moved(own)
            moved = np.flatnonzero(np.abs(points - own).max(axis=1, initial=0.0) > negligible)
            after = conversion.from_gamut(points[moved])
            turned = turned or (by_lab_hue and turns_blue(lab[moved], after))
            return outside, moved, after

        def shifted(lab: FloatArray, shifts: FloatArray) -> tuple[LongArray, FloatArray]:
            nonlocal turned
            own = conversion.to_gamut(lab)
            points = rule.start(own) - shifts
            least = SHIFT * gamut.default_error
            moved = np.flatnonzero(np.abs(points - own).max(axis=1, initial=0.0) > least)
            after = conversion.from_gamut(points[moved])
            turned = turned or (by_lab_hue and turns_blue(lab[moved], after))
            return moved, after

        return _spatial_moves(rule, conversion, iterations, shifted) if is_spatial else moves

    heat_file = None if heat_map is None else Path(heat_map)
    target = device_target(gamut, conversion, black) if to == TO_DEVICE else to
    done = map_picture(
        data,
        Path(output),
        moves_from,
        depth,
        table=table,
        heat_map=heat_file,
        to=target,
        decode=decode,
    )
    warnings = _build_warnings(gamut, source) + done.warnings
    warnings += distance_warnings(gamut, method)
    if source is not None:
        warnings += _warnings(gamut.conditions, source.conditions)
    if turned:
        warnings += (BLUE_TURNS,)
    return replace(done, warnings=warnings, gamut=gamut.conditions)


def _check_spatial(given: dict[str, Any]) -> None:
    for name, value in given.items():
        if value is not None:
            message = "the method spatial maps pixels, not colours"
            raise OptionError.not_applicable(name, value, message)


def _spatial_moves(
    rule: _Rule,
    conversion: ColourConversion,
    iterations: int,
    shifted: Callable[[FloatArray, FloatArray], tuple[LongArray, FloatArray]],
) -> SpatialMoves:
    """Return the functions of a spatial mapping into the level of a rule."""
    index = rule.level.index
    ends = search.neutral_ends(index)
    if ends is None:
        raise OptionError.not_applicable(
            "method", SPATIAL, "the gamut has no neutral colours", "Give another method."
        )

    def lines(lab: FloatArray) -> tuple[BooleanArray, Lines]:
        own = conversion.to_gamut(lab)
        start = rule.start(own)
        outside = rule.outside(own)
        clipped = outside if rule.blacks is None else rule.outside(start)
        return outside, search.find_lines(start, clipped, index, ends)

    def relaxed(directions: Float32Array, least: Float32Array, most: Float32Array) -> Float32Array:
        return search.relax_shifts(directions, least, most, iterations, ends[1] - ends[0])

    return SpatialMoves(lines, relaxed, shifted)
