"""The parameters of colour spaces: the accepted values, and the defaults of each space.

`gamutcore.options` declares an option for each parameter from this module.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import AfterValidator

from gamutcore.arguments import (
    Array,
    Choice,
    Coordinates,
    Number,
    accepted_values,
    canonical,
    check_option,
    finite_number,
)
from gamutcore.colours.spaces.appearance_model import SURROUNDS
from gamutcore.colours.spaces.definitions import SPACES
from gamutcore.colours.spaces.white_points import ADAPTATIONS, WHITES
from gamutcore.errors import OptionError

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = [
    "ADAPTATION",
    "ADAPTING_LUMINANCE",
    "BACKGROUND",
    "LUMINANCE",
    "MEASURED",
    "REFERENCE_WHITE",
    "SCALE",
    "SPACE",
    "SPACE_PARAMETERS",
    "SPELLINGS",
    "SURROUND",
    "measured_luminance",
    "parameter_defaults",
    "space_parameters",
]

SPELLINGS = {
    "lab": "CIELAB",
    "luv": "CIELUV",
    "xyz": "CIEXYZ",
    "cam16": "CAM16-UCS",
    "cam02": "CAM02-UCS",
    "ciecam02": "CAM02-UCS",
    "ciecam02ucs": "CAM02-UCS",
}
"""Usual spellings of the names of colour spaces."""

SPACE = Annotated[str, Choice(tuple(SPACES), SPELLINGS)]
"""Names of colour spaces."""

MEASURED = "measured"
"""Value of ``luminance`` for the luminance of the white that the data declares."""

_WHITE_LUMINANCE = Annotated[float, Number(0.1, 10_000.0, unit="cd/m²")]

_LEAST_WHITE, _MOST_WHITE = 0.1, 5.0
"""Bounds of X and Z of a white with Y = 1. Illuminant A has Z 0.36, a blue sky Z 1.7."""

_LEAST_RESPONSE = 0.05
"""Smallest response of any cone or sensor to a white with Y = 1; illuminant A gives 0.33."""


def _white(given: tuple[float, float, float]) -> tuple[float, float, float]:
    """Scale a white to Y = 1; a light that is far from white is refused."""
    x, y, z = given
    if not 1e-6 <= y <= 1e6:
        raise ValueError("no white")
    white = (x / y, 1.0, z / y)
    # chromatic adaptation divides by the responses of the cones and sensors
    matrices = [np.array(matrix) for matrix in ADAPTATIONS.values() if matrix is not None]
    responds = all(bool((matrix @ white >= _LEAST_RESPONSE).all()) for matrix in matrices)
    if not responds or not all(_LEAST_WHITE <= part <= _MOST_WHITE for part in white):
        raise ValueError("far from white")
    return white


REFERENCE_WHITE = (
    Annotated[str, Choice(tuple(WHITES))]
    | Annotated[
        Coordinates, AfterValidator(_white), Array("X, Y, Z of a light that is nearly white", 3)
    ]
)
ADAPTATION = Annotated[str, Choice(tuple(ADAPTATIONS))]
SCALE = Annotated[float, Number(1e-4, 1e6)]
LUMINANCE = _WHITE_LUMINANCE | Annotated[str, Choice((MEASURED,))]
ADAPTING_LUMINANCE = Annotated[float, Number(0.01, 10_000.0, unit="cd/m²")]
BACKGROUND = Annotated[float, Number(1.0, 100.0, unit="per cent of the white")]
SURROUND = Annotated[str, Choice(tuple(SURROUNDS))]

SPACE_PARAMETERS: Mapping[str, object] = MappingProxyType(
    {
        "reference_white": REFERENCE_WHITE,
        "adaptation": ADAPTATION,
        "scale": SCALE,
        "luminance": LUMINANCE,
        "adapting_luminance": ADAPTING_LUMINANCE,
        "background": BACKGROUND,
        "surround": SURROUND,
    }
)
"""Parameters of colour spaces with the types of their values. All spaces have the first three."""


def parameter_defaults(space: str) -> dict[str, object]:
    """Return the parameters of a space with their defaults."""
    definition = SPACES[space]
    return {
        "reference_white": definition.white,
        "adaptation": "Bradford",
        "scale": 1.0,
        **definition.parameters,
    }


def space_parameters(space: str, given: Mapping[str, object]) -> dict[str, object]:
    """Return the parameters of a space in their canonical form, with defaults filled in.

    Every name of `SPACE_PARAMETERS` has a value; None where the space does not have it. The
    defaults of CIELAB are None as well, which keeps the ids of older gamuts. Other values raise
    `OptionError`.
    """
    defaults = parameter_defaults(space)
    result: dict[str, object] = {}
    for name, kind in SPACE_PARAMETERS.items():
        value = given.get(name)
        if name not in defaults:
            if value is not None:
                raise OptionError.not_applicable(name, value, f"the space {space} has no {name}")
            result[name] = None
            continue
        settled = defaults[name] if value is None else check_option(name, value, kind)
        result[name] = None if space == "CIELAB" and settled == defaults[name] else settled
    return result


def measured_luminance(stated: object) -> float:
    """Return the luminance of a device's white, in cd/m², that its data declares.

    A missing luminance, or one out of the option's range, raises `OptionError`.
    """
    number = finite_number(stated)
    if number is None or canonical(number, _WHITE_LUMINANCE) is None:
        raise OptionError(
            "The data does not declare the luminance of its white."
            if number is None
            else f"The data declares a white of {number:g} cd/m².",
            where={"field": "luminance"},
            remedy=f"Give {accepted_values(_WHITE_LUMINANCE)}.",
        )
    return number
