"""The parameters of colour spaces as options: which space has which, their values and defaults.

`gamutcore.options` asks here, so that the parameters of a space stand beside the spaces and options
know nothing of whites and surrounds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces.appearance_model import SURROUNDS
from gamutcore.colours.spaces.definitions import SPACES
from gamutcore.colours.spaces.white_points import ADAPTATIONS, WHITES
from gamutcore.errors import OptionError
from gamutcore.numbers import finite_number

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["MEASURED", "SPACE_PARAMETERS", "measured_luminance", "space_parameters"]

MEASURED = "measured"
"""Luminance of the white as the data states it."""

SPACE_PARAMETERS = (
    "reference_white",
    "adaptation",
    "scale",
    "luminance",
    "adapting_luminance",
    "background",
    "surround",
)
"""Options of spaces. All spaces have the first three."""

_RANGES = {
    "scale": (1e-4, 1e6, "a number from 0.0001 to 1000000"),
    "luminance": (0.1, 10_000.0, "'measured', or a number from 0.1 to 10000, in cd/m²"),
    "adapting_luminance": (0.01, 10_000.0, "a number from 0.01 to 10000, in cd/m²"),
    "background": (1.0, 100.0, "a number from 1 to 100, in per cent of the white"),
}

_LEAST_WHITE, _MOST_WHITE = 0.1, 5.0
"""Of X and Z of a white with Y = 1; illuminant A has Z 0.36, a blue sky of 25,000 K Z 1.7."""

_LEAST_RESPONSE = 0.05
"""Of every sensor, for a white with Y = 1; illuminant A has 0.33."""


def space_parameters(space: str, given: Mapping[str, object]) -> dict[str, object]:
    """Return the parameters of a space in their canonical form, with the space's defaults.

    Parameters
    ----------
    space : str
        A key of `SPACES`.
    given : mapping of str
        Values by name; None where not given.

    Returns
    -------
    dict
        For every name of `SPACE_PARAMETERS`; None where the space does not have it. CIELAB's
        defaults are None as well: gamuts without a word about spaces keep their ids.

    Raises
    ------
    OptionError
        A value is not accepted, or the space has no such parameter.
    """
    definition = SPACES[space]
    defaults: dict[str, object] = {
        "reference_white": definition.white,
        "adaptation": "Bradford",
        "scale": 1.0,
        **definition.parameters,
    }
    result: dict[str, object] = {}
    for name in SPACE_PARAMETERS:
        value = given.get(name)
        if name not in defaults:
            if value is not None:
                raise OptionError.not_applicable(name, value, f"the space {space} has no {name}")
            result[name] = None
            continue
        checked = defaults[name] if value is None else _checked(name, value)
        result[name] = None if space == "CIELAB" and checked == defaults[name] else checked
    return result


def measured_luminance(stated: object) -> float:
    """Return the luminance of a device's white that its data states.

    Parameters
    ----------
    stated : float or None
        In cd/m².

    Returns
    -------
    float

    Raises
    ------
    OptionError
        There is none, or it is out of the range of the option.
    """
    least, most, _ = _RANGES["luminance"]
    number = finite_number(stated)
    if number is None or not least <= number <= most:
        raise OptionError(
            "The data does not state the luminance of its white."
            if number is None
            else f"The data states that its white has {number:g} cd/m².",
            where={"field": "luminance"},
            remedy=f"Ask for a luminance from {least:g} to {most:g}, in cd/m².",
        )
    return number


def _checked(name: str, value: object) -> object:
    if name == "reference_white":
        return _checked_white(value)
    if name == "luminance" and value == MEASURED:
        return MEASURED
    if name in _RANGES:
        least, most, accepted = _RANGES[name]
        number = finite_number(value)
        if number is None or not least <= number <= most:
            raise OptionError.refusal(name, value, accepted)
        return number
    choices = tuple(ADAPTATIONS) if name == "adaptation" else tuple(SURROUNDS)
    if not isinstance(value, str) or value not in choices:
        raise OptionError.refusal(name, value, f"one of {', '.join(choices)}")
    return value


def _checked_white(value: object) -> object:
    if isinstance(value, str) and value in WHITES:
        return value
    if isinstance(value, list | tuple) and len(value) == 3:
        x, y, z = (finite_number(part) for part in value)
        if x is not None and y is not None and z is not None and 1e-6 <= y <= 1e6:
            white = (x / y, 1.0, z / y)
            if all(_LEAST_WHITE <= part <= _MOST_WHITE for part in white) and _is_seen(white):
                return white
    raise OptionError.refusal(
        "reference_white",
        value,
        f"one of {', '.join(WHITES)}, or X, Y, Z of a light that is nearly white",
    )


def _is_seen(white: tuple[float, float, float]) -> bool:
    """Whether all cones and sharpened sensors respond to a white: adaptation divides by them."""
    matrices = [np.array(matrix) for matrix in ADAPTATIONS.values() if matrix is not None]
    return all(bool((matrix @ white >= _LEAST_RESPONSE).all()) for matrix in matrices)
