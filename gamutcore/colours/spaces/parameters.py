"""The parameters of colour spaces: the accepted values, and the defaults of each space.

`gamutcore.options` declares an option for each parameter from this module.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces.appearance_model import SURROUNDS
from gamutcore.colours.spaces.definitions import SPACES
from gamutcore.colours.spaces.white_points import ADAPTATIONS, WHITES
from gamutcore.errors import OptionError
from gamutcore.option_types import (
    Choice,
    Number,
    OptionType,
    Vector,
    check_option,
    finite_number,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = [
    "MEASURED",
    "SPACE",
    "SPACE_PARAMETERS",
    "measured_luminance",
    "parameter_defaults",
    "space_parameters",
]

SPACE = Choice(
    tuple(SPACES),
    {
        "lab": "CIELAB",
        "luv": "CIELUV",
        "xyz": "CIEXYZ",
        "cam16": "CAM16-UCS",
        "cam02": "CAM02-UCS",
        "ciecam02": "CAM02-UCS",
        "ciecam02ucs": "CAM02-UCS",
    },
)
"""Names of colour spaces, with their usual spellings."""

MEASURED = "measured"
"""Value of ``luminance`` for the luminance of the white that the data declares."""

LUMINANCE = Number(0.1, 10_000.0, unit="cd/m²")

_LEAST_WHITE, _MOST_WHITE = 0.1, 5.0
"""Bounds of X and Z of a white with Y = 1. Illuminant A has Z 0.36, a blue sky Z 1.7."""

_LEAST_RESPONSE = 0.05
"""Smallest response of any cone or sensor to a white with Y = 1; illuminant A gives 0.33."""


def _white(x: float, y: float, z: float) -> tuple[float, float, float] | None:
    """Scale a white to Y = 1; None for a light that is far from white."""
    if not 1e-6 <= y <= 1e6:
        return None
    white = (x / y, 1.0, z / y)
    # chromatic adaptation divides by the responses of the cones and sensors
    matrices = [np.array(matrix) for matrix in ADAPTATIONS.values() if matrix is not None]
    responds = all(bool((matrix @ white >= _LEAST_RESPONSE).all()) for matrix in matrices)
    return (
        white if responds and all(_LEAST_WHITE <= part <= _MOST_WHITE for part in white) else None
    )


SPACE_PARAMETERS: Mapping[str, tuple[OptionType, ...]] = MappingProxyType(
    {
        "reference_white": (
            Choice(tuple(WHITES)),
            Vector("X, Y, Z of a light that is nearly white", _white),
        ),
        "adaptation": (Choice(tuple(ADAPTATIONS)),),
        "scale": (Number(1e-4, 1e6),),
        "luminance": (LUMINANCE, Choice((MEASURED,))),
        "adapting_luminance": (Number(0.01, 10_000.0, unit="cd/m²"),),
        "background": (Number(1.0, 100.0, unit="per cent of the white"),),
        "surround": (Choice(tuple(SURROUNDS)),),
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
    for name, types in SPACE_PARAMETERS.items():
        value = given.get(name)
        if name not in defaults:
            if value is not None:
                raise OptionError.not_applicable(name, value, f"the space {space} has no {name}")
            result[name] = None
            continue
        settled = defaults[name] if value is None else check_option(name, value, *types)
        result[name] = None if space == "CIELAB" and settled == defaults[name] else settled
    return result


def measured_luminance(stated: object) -> float:
    """Return the luminance of a device's white, in cd/m², that its data declares.

    A missing luminance, or one out of the option's range, raises `OptionError`.
    """
    number = finite_number(stated)
    if number is None or LUMINANCE.canonical(number) is None:
        raise OptionError(
            "The data does not declare the luminance of its white."
            if number is None
            else f"The data declares a white of {number:g} cd/m².",
            where={"field": "luminance"},
            remedy=f"Give {LUMINANCE.accepted}.",
        )
    return number
