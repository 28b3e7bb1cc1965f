"""Questions about device values: the recipe of a colour, and the colour of a recipe."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore import search
from gamutcore.arguments import check_option
from gamutcore.colours import lab_to_xyz
from gamutcore.errors import InvalidPointsError, OptionError
from gamutcore.questions.black_rules import BLACK, black_rule
from gamutcore.questions.conditions import build_warnings, colour_warnings
from gamutcore.questions.declarations import (
    BOOLEAN,
    COLOUR,
    NULLABLE_NUMBER,
    NUMBER,
    Column,
    Parameter,
    Question,
    list_of,
)
from gamutcore.questions.levels import answering_level, colours_in, is_as_measured, lab_of
from gamutcore.questions.mapping import METHOD, distance_warnings, map_colours
from gamutcore.results import ColourRecipes
from gamutcore.search import delta_e_2000

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.arrays import FloatArray
    from gamutcore.colour_rows import Colours
    from gamutcore.questions.levels import GamutLike

__all__ = ["COLOURS", "RECIPES", "device_colours", "recipes"]

NEAREST_METHOD = "clip-nearest"


def recipes(
    gamut: GamutLike,
    colours: Colours,
    *,
    black: str | float | ArrayLike | None = None,
    method: str = NEAREST_METHOD,
    space: str | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> ColourRecipes:
    """Find device values that give colours: recipes.

    Parameters
    ----------
    black : str, float or (n, 2) array, optional
        How much black, ``"medium"`` by default. ``"light"``, ``"medium"``, ``"heavy"`` and
        ``"max"`` are presets of gray component replacement; ``"none"`` is the least possible. A
        number from 0 to 1 is a share of the possible range. ``"least-ink"``: the least sum of inks.
        An array has pairs of L* and an amount of black from 0 to 1, which is kept to the possible
        range.
    method : str, optional
        How colours out of gamut are mapped, as for `map`.

    Returns
    -------
    ColourRecipes
        With `device`, `points`, `delta_e`, `inside`, `black_least` and `black_most`. The ink
        limits of the gamut are kept. With more than four inks, a recipe is a mean of sets of
        three chromatic inks and black, to which the rule of black applies.

    Raises
    ------
    DeviceModelError
        The gamut is of colours, a picture or a mesh, or its file was saved without the model.

    Notes
    -----
    Preparation takes 0.1 to 1 s once for a gamut, and a colour about 30 µs.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> press = Gamut("examples/FOGRA39L.ti3", surface_samples=1000, ink_limit=300)
    >>> spot = press.to_device((50, 30, 20))
    >>> bool(spot.inside), bool(spot.delta_e < 0.01), spot.channels
    (True, True, ('C', 'M', 'Y', 'K'))
    """
    model = gamut.device_model
    rule = black_rule(black, model)
    rows, conversion = colours_in(gamut, colours, space)
    level = answering_level(gamut, triangles, max_error)
    inside = search.contains(rows.points, level.index)
    targets = rows.points.copy()
    outside = ~inside
    warnings = build_warnings(gamut.conditions)
    warnings += colour_warnings(gamut.conditions, conversion.name)
    if outside.any():
        if check_option("method", method, METHOD) == "sgck":
            raise OptionError.not_applicable("method", method, "it needs another gamut to map from")
        mapped = map_colours(
            gamut, rows.points[outside], method, triangles=triangles, max_error=max_error
        )
        targets[outside] = mapped.points
        warnings += distance_warnings(gamut, method)
    inks = gamut.inverse_model.recipes(lab_of(gamut, targets), rule)
    points = _in_space(gamut, inks.lab)
    has_black = gamut.inverse_model.black is not None
    least, most = (rows.in_shape(inks.black[:, end]) for end in range(2))
    return ColourRecipes(
        points=rows.in_shape(conversion.from_gamut(points)),
        space=conversion.name,
        device=rows.in_shape(inks.device),
        channels=model.channels,
        inside=rows.in_shape(inside),
        delta_e=rows.in_shape(delta_e_2000(lab_of(gamut, rows.points), inks.lab)),
        black_least=least if has_black else None,
        black_most=most if has_black else None,
        triangles=level.triangles,
        max_error=level.max_error,
        gamut=gamut.conditions,
        warnings=warnings,
    )


def device_colours(gamut: GamutLike, device: ArrayLike, *, space: str | None = None) -> FloatArray:
    """Return the colours of device values, by the device model.

    Parameters
    ----------
    device : (..., k) array
        From 0 to 1, in the order of the channels.

    Returns
    -------
    (..., 3) float64

    Raises
    ------
    DeviceModelError
        As for `to_device`.
    InvalidPointsError
        There are not k values from 0 to 1 in each row.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> press = Gamut("examples/FOGRA39L.ti3", surface_samples=1000)
    >>> press.to_colour((0, 0, 0, 0))[0].round(1).item()
    100.0
    """
    model = gamut.device_model
    values = np.asarray(device, np.float64)
    count = len(model.channels)
    if values.shape[-1:] != (count,):
        raise InvalidPointsError(
            f"The device values have the shape {values.shape}.",
            where={"field": "device"},
            remedy=f"Give rows of {count} numbers: {', '.join(model.channels)}.",
        )
    rows = values.reshape(-1, count)
    wrong = np.flatnonzero(~((rows >= 0.0) & (rows <= 1.0)).all(axis=1))
    if len(wrong):
        raise InvalidPointsError(
            f"Device values are from 0 to 1. Row {wrong[0]} has {rows[wrong[0]].tolist()}.",
            where={"field": "device", "row": int(wrong[0])},
            remedy="Divide per cent by 100, and codes of 8 bits by 255.",
        )
    _, conversion = colours_in(gamut, np.empty((0, 3)), space)
    points = conversion.from_gamut(_in_space(gamut, model.lab(rows)))
    return points.reshape(*values.shape[:-1], 3)


class _Colours(NamedTuple):
    points: FloatArray


def _colours(gamut: GamutLike, device: FloatArray, *, space: str | None = None) -> _Colours:
    return _Colours(device_colours(gamut, device, space=space))


COLOURS = Question(
    "colours",
    "convertDeviceValues",
    "Give the colours of device values",
    "The colour of each device value, by the device model: that of measured samples, an ICC "
    "profile or an RGB space. The boundary and the ink limits of the gamut do not matter.",
    (),
    _colours,
    inputs=("device",),
    columns=(Column("colour", "Colour of the device value.", COLOUR, "axes", "points"),),
    example={"device": [[0.15, 0.62, 0.55, 0.21]]},
    example_answer={"colour": [[50, 30, 20]]},
    level=(),
    needs_model=True,
    of_device=True,
)


def _in_space(gamut: GamutLike, lab: FloatArray) -> FloatArray:
    """Return CIELAB relative to D50 in the space of the gamut, as `lab_of` the other way."""
    if gamut.colour_space.is_icc_cielab:
        return lab
    as_measured = is_as_measured(gamut)
    return gamut.colour_space.from_tristimulus(lab_to_xyz(lab), as_measured=as_measured)[0]


RECIPES = Question(
    "recipes",
    "findRecipes",
    "Find device values that give colours",
    "For each colour, device values that give it by the device model: that of measured samples, "
    "an ICC profile or an RGB space. A colour out of gamut gets those of the colour that it is "
    "mapped to. Ink limits of the gamut are kept.",
    (
        Parameter(
            "black",
            BLACK,
            "How much black. Presets of gray component replacement: `light`, `medium`, `heavy` and "
            "`max`. `none`: the least possible; a number from 0 to 1: a share of the possible "
            "range. `least-ink`: the least sum of inks. Pairs such as `10:90, 50:30, 90:0`: a "
            "curve of black over L*, kept to the possible range; in per cent if a value exceeds 1. "
            "Default: `medium`.",
            example=0.5,
        ),
        Parameter(
            "method",
            METHOD,
            "How a colour out of gamut is mapped, as for `map`; not `sgck`.",
            default=NEAREST_METHOD,
        ),
    ),
    recipes,
    inputs=("colours",),
    columns=(
        Column("device", "Device values from 0 to 1.", list_of(NUMBER), "channels"),
        Column("colour", "Their colour by the device model.", COLOUR, "axes", "points"),
        Column(
            "delta_e_2000", "Its difference CIEDE2000 from the colour asked.", NUMBER, "", "delta_e"
        ),
        Column("inside", "Whether the colour asked is in gamut.", BOOLEAN),
        Column("black_least", "Least possible black.", NULLABLE_NUMBER),
        Column("black_most", "Most possible black.", NULLABLE_NUMBER),
    ),
    example={"colours": [[50, 30, 20]], "black": "medium"},
    example_answer={
        "device": [[0.15, 0.62, 0.55, 0.21]],
        "colour": [[50, 30, 20]],
        "delta_e_2000": [0.0],
        "inside": [True],
        "black_least": [0.0],
        "black_most": [0.42],
    },
    needs_model=True,
)
