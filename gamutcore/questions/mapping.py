"""Gamut mapping: colours and pictures are moved into the gamut by one of the usual methods."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

import numpy as np

from gamutcore import search
from gamutcore.arguments import Boolean, Choice, Coordinates, check_option
from gamutcore.colour_rows import colour_rows
from gamutcore.colours import (
    ColourConversion,
    compensate_black,
    lab_to_xyz,
    luminance_of_black,
)
from gamutcore.errors import OptionError
from gamutcore.questions.conditions import build_warnings, colour_warnings, comparison_warnings
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
    other_gamut,
    surface_facts,
    tolerance_of,
)
from gamutcore.results import AS_GIVEN, MappedColours
from gamutcore.search import delta_e_2000

if TYPE_CHECKING:
    from gamutcore.arrays import BooleanArray, FloatArray
    from gamutcore.colour_rows import Colours
    from gamutcore.questions.levels import GamutLike, IndexedLevel, OtherGamut
    from gamutcore.search import LevelIndex, Mapped, MappingMethod

__all__ = [
    "COMPENSATION",
    "MAP",
    "MAPPING_ALIASES",
    "MAPPING_METHODS",
    "METHOD",
    "PICTURE_SPACE",
    "ROUNDING",
    "SPATIAL",
    "MappingRule",
    "black_luminance",
    "compensates_black",
    "distance_warnings",
    "lab_conversion",
    "map_colours",
    "map_points",
    "mapping_rule",
    "mapping_warnings",
]

MAPPING_METHODS = (
    "clip-nearest",
    "clip-hue",
    "clip-lightness",
    "clip-chroma",
    "clip-focal",
    "sgck",
)
MAPPING_ALIASES = {"hpminde": "clip-hue"}
METHOD = Annotated[str, Choice(MAPPING_METHODS, MAPPING_ALIASES)]
"""Methods of mapping."""

PICTURE_SPACE = "CAM16-UCS"
"""Space of the mapping of pictures, links and profiles; docs/decisions/picture-space.md has why."""

SPATIAL = "spatial"
"""Method for pictures alone: colours of a table have no neighbours."""

ROUNDING = 1e-9
"""A change of less than this share of `default_error` is a rounding error, and no move."""

EQUAL_BLACKS = 1e-6
"""Difference of the luminances of two blacks, of that of white, up to which they count as equal:
L* 0.001."""

_NAMES = "the gamut", "the source"

_warnings = partial(comparison_warnings, names=_NAMES)


def mapping_warnings(
    gamut: GamutLike, source: GamutLike | None, method: str
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Warnings of the builds, and warnings about the method and the two gamuts together."""
    about = distance_warnings(gamut, method)
    if source is not None:
        about += _warnings(gamut.conditions, source.conditions)
    if source is None or source is gamut:
        return build_warnings(gamut.conditions), about
    return build_warnings(gamut.conditions, source.conditions, names=_NAMES), about


def map_colours(
    gamut: GamutLike,
    colours: Colours,
    method: str = "clip-hue",
    *,
    focus: Colours | Literal["cusp"] | None = None,
    source: OtherGamut | None = None,
    black_point_compensation: bool = False,
    space: str | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> MappedColours:
    """Map colours into the gamut.

    Parameters
    ----------
    method : str, optional
        ``"clip-nearest"``: to the nearest colour, by the distance in the space of the gamut:
        ΔE*ab in CIELAB. ``"clip-hue"``: to the nearest colour of the same hue (HPMINDE, CIE
        156:2004). ``"clip-lightness"``: the chroma stays.
        ``"clip-chroma"``: the lightness stays. ``"clip-focal"``: towards a focal point.
        ``"sgck"``: compression from a source gamut (CIE 156:2004).
    focus : (3,) array_like or "cusp", optional
        Focal point of ``"clip-focal"``, in the space of the colours; ``"cusp"``, the default,
        is the lightness of the cusp on the neutral axis.
    source : Gamut, str or path, optional
        The gamut that ``"sgck"`` maps from.
    black_point_compensation : bool, optional
        Whether colours are first scaled in CIEXYZ, so that black, L* = 0, becomes the darkest
        neutral colour of the gamut, and white stays (ISO 18619). Not for ``"sgck"``, which maps
        black itself.

    Returns
    -------
    MappedColours
        With `points`, `moved`, `delta_e` and `device`. Colours inside, and outside within the
        tolerance of `contains` if it is not above `default_error`, stay as they are, except by
        ``"sgck"`` and with black-point compensation.

    Raises
    ------
    OptionError
        Also if `focus`, `source` or `black_point_compensation` does not apply.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> Gamut(cube).map((50, 30, 0), "clip-chroma").points.round(3).tolist()
    [50.0, 10.0, 0.0]
    """
    source = None if source is None else other_gamut(gamut, source)
    rows, conversion = colours_in(gamut, colours, space)
    rule = mapping_rule(
        gamut,
        method,
        conversion,
        focus=focus,
        source=source,
        black=0.0 if black_point_compensation else None,
        triangles=triangles,
        max_error=max_error,
    )
    built, about = mapping_warnings(gamut, source, rule.method)
    warnings = built + colour_warnings(gamut.conditions, conversion.name) + about
    level, start = rule.level, rule.start(rows.points)
    mapping = rule.mapped(start)
    points = mapping.points
    difference = delta_e_2000(lab_of(gamut, rows.points), lab_of(gamut, points))
    moved = np.abs(points - rows.points).max(axis=1, initial=0.0)
    return MappedColours(
        points=rows.in_shape(conversion.from_gamut(points)),
        space=conversion.name,
        warnings=warnings,
        moved=rows.in_shape(moved > ROUNDING * gamut.default_error),
        delta_e=rows.in_shape(difference),
        **surface_facts(gamut, level, mapping, rows),
    )


def map_points(
    gamut: GamutLike,
    lab: FloatArray,
    method: str,
    *,
    focus: Colours | Literal["cusp"] | None = None,
    source: GamutLike | None = None,
    black_point_compensation: bool = False,
    black: float = 0.0,
    triangles: int | None = None,
    max_error: float | None = None,
) -> FloatArray:
    """Return colours (n, 3) in CIELAB, mapped as by `map_colours`, without what it states."""
    conversion = lab_conversion(gamut)
    rule = mapping_rule(
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


def distance_warnings(gamut: GamutLike, method: str) -> tuple[str, ...]:
    """Return a warning if nearest colours are those of a distance that is no colour difference."""
    space = gamut.colour_space
    if method != "clip-nearest" or space.definition.is_uniform:
        return ()
    warning = (
        f"Distances in {space.name} are not colour differences, and nearest colours may have "
        f"another hue. Take clip-hue, or build the gamut in {PICTURE_SPACE}."
    )
    return (warning,)


def lab_conversion(gamut: GamutLike) -> ColourConversion:
    """Conversion between CIELAB and the space of a gamut."""
    return ColourConversion("CIELAB", gamut.colour_space, as_measured=is_as_measured(gamut))


@dataclass(frozen=True)
class MappingRule:
    """A method with its arguments, and the level that it maps into.

    `focus` is in the space of the gamut. `blacks` has the luminances of the black of the colours
    and of the gamut if the first is compensated.
    """

    gamut: GamutLike
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

    def moved(self, points: FloatArray) -> tuple[BooleanArray, FloatArray]:
        """Return which points are out of gamut, and all points after mapping."""
        mapped = self.mapped(self.start(points))
        is_clipping = self.method != "sgck" and self.blacks is None
        return mapped.moved if is_clipping else self.outside(points), mapped.points

    @cached_property
    def _tolerance(self) -> float:
        """The distance by which the level misses colours of the gamut, at most.

        A coarse level's own error is limited, so that colours far outside do not stay. That of the
        full boundary is not: those colours are of the gamut.
        """
        missed: float = self.gamut.description.get("boundary_error", 0.0)
        known = tolerance_of(self.gamut, self.level.triangles) - missed
        return min(known, self.gamut.default_error) + missed


def mapping_rule(
    gamut: GamutLike,
    method: str,
    conversion: ColourConversion,
    *,
    focus: Colours | Literal["cusp"] | None,
    source: GamutLike | None,
    black: float | None,
    triangles: int | None,
    max_error: float | None,
) -> MappingRule:
    """Check the arguments of a mapping, and return its rule. `black` is a luminance or None."""
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
    return MappingRule(gamut, name, level, focus, origin, blacks)


def black_luminance(gamut: GamutLike, level: IndexedLevel | None = None) -> float:
    """Return the luminance of the darkest neutral colour, of the full boundary by default."""
    luminance = _darkest_neutral(gamut, level or answering_level(gamut, None, 0.0))
    if luminance is None:
        raise OptionError.not_applicable(
            "black_point_compensation", value=True, why="the gamut has no neutral colours"
        )
    return luminance


def compensates_black(gamut: GamutLike, method: str) -> bool:
    """Return whether links and pictures have black-point compensation if nothing is asked.

    It is for colours relative to a white (ISO 18619), and `sgck` maps black itself.
    """
    if method == "sgck" or gamut.conditions.intent in {AS_GIVEN, "absolute"}:
        return False
    return _darkest_neutral(gamut, answering_level(gamut, None, 0.0)) is not None


def _darkest_neutral(gamut: GamutLike, level: IndexedLevel) -> float | None:
    """Return the luminance where the greys enter a level; None if they do not.

    Greys are on a curve in spaces with incomplete adaptation, such as CAM16-UCS.
    """
    space, as_measured = gamut.colour_space, is_as_measured(gamut)
    greys = lab_to_xyz(np.linspace(0.0, 100.0, 101)[:, np.newaxis] * (1.0, 0.0, 0.0))
    points = space.from_tristimulus(greys, as_measured=as_measured)[0]
    if search.contains(points[:1], level.index, ROUNDING * gamut.default_error)[0]:
        return 0.0
    hits = search.crossings(points[:-1], points[1:], level.index, "segment")
    if len(hits.t) == 0:
        return None
    return luminance_of_black(space.tristimulus(hits.points[:1], as_measured=as_measured)[0])


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
    pair_warnings=_warnings,
    example={"colours": [[50, 90, 0]], "method": "clip-chroma"},
    example_answer={
        "mapped": [[50, 75.9, 0]],
        "moved": [True],
        "delta_e_2000": [3.3],
        "device": [[0.0, 1.0, 0.05, 0.02]],
    },
)


COMPENSATION = replace(
    MAP.parameters[-1],
    description="Whether colours are first scaled in CIEXYZ, so that the black of the source "
    "becomes the darkest neutral colour of the gamut, and white stays (ISO 18619). Default: true "
    "for colours relative to a white, except by `sgck`, which maps black itself.",
    default=None,
)
"""Black-point compensation of links and pictures."""
