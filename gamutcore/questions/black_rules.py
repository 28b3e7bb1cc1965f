"""How much black device values have: the argument `black` of recipes and of pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np

from gamutcore.arguments import Number, Text, check_option
from gamutcore.colours import lacks_black, naming_remedy
from gamutcore.errors import OptionError
from gamutcore.recipes import GCR, LEAST_INK, SHARE, WANTED, BlackRule

if TYPE_CHECKING:
    from gamutcore.colours import DeviceModel

__all__ = ["BLACK", "DEFAULT_BLACK", "black_rule"]


def _gcr(start: float, power: float, maximum: float, width: float = np.inf) -> BlackRule:
    """Return a preset of gray component replacement.

    Black begins at the depth `start`: 0 is L* 100, and 1 the darkest neutral colour. There, it has
    the share `maximum` of the most possible. `power` bends the curve between; above 1, light
    colours get less. The share is halved at the chroma of `width`.
    """
    depth = np.linspace(0.0, 1.0, 201)
    rise = np.maximum((depth - start) / (1.0 - start), 0.0)
    return BlackRule(GCR, curve=np.stack([depth, maximum * rise**power], axis=1), width=width)


DEFAULT_BLACK = _gcr(0.13, 1.25, 0.96)
"""`medium`: fitted to the greys of ECI's PSOcoated_v3 and of basICColor's ISOcoated v2 300 %."""

_RULES = {
    "light": _gcr(0.4, 1.0, 0.93, 40.0),
    "medium": DEFAULT_BLACK,
    "heavy": _gcr(0.0, 0.5, 0.97),
    "max": BlackRule(SHARE, 1.0),
    "none": BlackRule(SHARE, 0.0),
    "least-ink": BlackRule(LEAST_INK),
}

_FORMER = {"smooth": "heavy", "maximum": "max"}
"""Former names of rules, which are still accepted."""

BLACK = (
    Annotated[
        str,
        Text(
            400,
            "one of light, medium, heavy, max, none and least-ink, or pairs of L* and black, such "
            "as '10:90, 50:30, 90:0'",
        ),
    ]
    | Annotated[float, Number(0.0, 1.0)]
)
"""How much black a recipe has: a rule, a share of the possible range, or a curve."""


def black_rule(black: object = None, model: DeviceModel | None = None) -> BlackRule:
    """Return the rule that a name, a share or a curve (n, 2) of L* and black stands for.

    None is ``medium``. Other rules are refused for the model of a device with more than three inks
    of which none is named as black. A curve has black in per cent if a value exceeds 1.
    """
    rule = _rule(black)
    if model is not None and rule is not DEFAULT_BLACK and lacks_black(model.channels, model.inks):
        raise OptionError(
            f"A rule of black does not apply: none of the inks {', '.join(model.channels)} is "
            "named as black.",
            where={"field": "black"},
            remedy=naming_remedy(model),
        )
    return rule


def _rule(black: object) -> BlackRule:
    if black is None:
        return DEFAULT_BLACK
    if isinstance(black, str | float | int):
        value = check_option("black", black, BLACK)
        if not isinstance(value, str):
            return BlackRule(SHARE, value)
        name = _FORMER.get(value, value)
        if name in _RULES:
            return _RULES[name]
        black = [pair.split(":") for pair in value.split(",")]
    try:
        curve = np.asarray(black, np.float64)
    except (TypeError, ValueError):
        curve = np.empty(0)
    if curve.ndim == 2 and curve.shape[1:] == (2,) and curve[:, 1].max(initial=0.0) > 1.0:
        curve = curve / (1.0, 100.0)
    accepted = curve.ndim == 2 and curve.shape[1:] == (2,) and len(curve) > 1
    if not accepted or not (
        np.isfinite(curve).all()
        and (np.diff(curve[:, 0]) > 0).all()
        and ((curve[:, 1] >= 0) & (curve[:, 1] <= 1)).all()
    ):
        raise OptionError(
            "The rule of black is not accepted.",
            where={"field": "black"},
            remedy="Give light, medium, heavy, max, none, least-ink, a share from 0 to 1, or two "
            "or more pairs of L* and black, such as 10:90, 50:30, 90:0, with ascending L* and "
            "black in per cent or from 0 to 1.",
        )
    return BlackRule(WANTED, curve=curve)
