"""Mapping of picture files: the parameters, and the rule that moves their pixels."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np

from gamutcore import search
from gamutcore.arguments import Choice, Text, WholeNumber, check_option
from gamutcore.errors import OptionError
from gamutcore.export.picture_file import DEPTHS
from gamutcore.pictures.picture_mapping import (
    BLACK_MOVES,
    BLUE_TURNS,
    MOST_NODES,
    SpatialMoves,
    map_picture,
    turns_blue,
)
from gamutcore.pictures.picture_targets import DECODE, DEVICE, OWN, device_target
from gamutcore.questions import (
    BLACK,
    COMPENSATION,
    LEVEL_PARAMETERS,
    MAP,
    MAPPING_ALIASES,
    MAPPING_METHODS,
    ROUNDING,
    SPATIAL,
    MappingRule,
    Parameter,
    compensates_black,
    lab_conversion,
    mapping_rule,
    mapping_warnings,
)

if TYPE_CHECKING:
    import os
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from gamutcore.arrays import BooleanArray, Float32Array, FloatArray, LongArray
    from gamutcore.colour_rows import Colours
    from gamutcore.colours import ColourConversion
    from gamutcore.export.picture_file import Depth
    from gamutcore.pictures.picture_mapping import MappedPicture, Moves
    from gamutcore.questions import GamutLike
    from gamutcore.search import Lines

__all__ = ["PICTURE_PARAMETERS", "map_picture_file"]

ITERATIONS = 25
"""Iterations of the spatial mapping: 20 to 30 are enough for Alsam & Farup (2012)."""

MOST_ITERATIONS = 10_000
"""An hour for 24 megapixels."""

SHIFT = 1e-2
"""A shift by less than this share of `default_error` is no move: 16 bits hardly store it."""

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
        Annotated[str, Text(60, f"{OWN}, {DEVICE}, or the slug of an RGB space")],
        f"Encoding of the picture that is returned. `{OWN}`: that of the picture. The slug of an "
        f"RGB space, with its profile. `{DEVICE}`: values of the device as TIFF, such as CMYK, "
        "with the profile that the gamut was built from.",
        default=OWN,
        example="display-p3",
    ),
    Parameter("black", BLACK, "How much black device values have, as for `recipes`.", example=0.5),
)
_METHOD, *_ARGUMENTS, _ = MAP.parameters

PICTURE_METHOD = Annotated[str, Choice((*MAPPING_METHODS, SPATIAL), MAPPING_ALIASES)]
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
    gamut: GamutLike,
    data: bytes,
    output: str | os.PathLike[str],
    method: str = "clip-hue",
    *,
    focus: Colours | Literal["cusp"] | None = None,
    source: GamutLike | None = None,
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
    if black is not None and to != DEVICE:
        raise OptionError.not_applicable(
            "black", black, f"only device values (to={DEVICE}) need it"
        )
    if triangles is None and max_error is None:
        max_error = 0.0  # edges of a coarser level are visible as arcs
    by_default = black_point_compensation is None
    if black_point_compensation is None:
        black_point_compensation = compensates_black(gamut, method)
    by_lab_hue = gamut.colour_space.name == "CIELAB" and method != "clip-nearest"
    turned = False
    conversion = lab_conversion(gamut)

    def moves_from(black: float) -> Moves | SpatialMoves:
        rule = mapping_rule(
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
    target = device_target(gamut, conversion, black) if to == DEVICE else to
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
    built, about = mapping_warnings(gamut, source, method)
    warnings = built + done.warnings + about
    if black_point_compensation and by_default and not is_spatial and done.moved > done.outside:
        warnings += (BLACK_MOVES,)
    if turned:
        warnings += (BLUE_TURNS,)
    return replace(done, warnings=warnings, gamut=gamut.conditions)


def _check_spatial(given: dict[str, Any]) -> None:
    for name, value in given.items():
        if value is not None:
            message = "the method spatial maps pixels, not colours"
            raise OptionError.not_applicable(name, value, message)


def _spatial_moves(
    rule: MappingRule,
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
