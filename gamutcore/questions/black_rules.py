"""How much black device values have: the argument `black` of recipes and of pictures."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from gamutcore.arguments import Number, Text, check_option
from gamutcore.errors import OptionError
from gamutcore.recipes import LEAST_INK, SHARE, SMOOTH_BLACK, WANTED, BlackRule

__all__ = ["BLACK", "black_rule"]

_RULES = {
    "smooth": SMOOTH_BLACK,
    "none": BlackRule(SHARE, 0.0),
    "maximum": BlackRule(SHARE, 1.0),
    "least-ink": BlackRule(LEAST_INK),
}

BLACK = (
    Annotated[
        str,
        Text(
            400,
            "one of smooth, none, maximum and least-ink, or pairs of L* and black, such as "
            "'10:0.9, 50:0.3, 90:0'",
        ),
    ]
    | Annotated[float, Number(0.0, 1.0)]
)
"""How much black a recipe has: a rule, a share of the possible range, or a curve."""


def black_rule(black: object = None) -> BlackRule:
    """Return the rule that a name, a share or a curve (n, 2) of L* and black stands for.

    None is ``smooth``.
    """
    if black is None:
        return SMOOTH_BLACK
    if isinstance(black, str | float | int):
        value = check_option("black", black, BLACK)
        if value in _RULES:
            return _RULES[value]
        if not isinstance(value, str):
            return BlackRule(SHARE, value)
        black = [pair.split(":") for pair in value.split(",")]
    try:
        curve = np.asarray(black, np.float64)
    except (TypeError, ValueError):
        curve = np.empty(0)
    accepted = curve.ndim == 2 and curve.shape[1:] == (2,) and len(curve) > 1
    if not accepted or not (
        np.isfinite(curve).all()
        and (np.diff(curve[:, 0]) > 0).all()
        and ((curve[:, 1] >= 0) & (curve[:, 1] <= 1)).all()
    ):
        raise OptionError(
            "The rule of black is not accepted.",
            where={"field": "black"},
            remedy="Give smooth, none, maximum, least-ink, a share from 0 to 1, or two or more "
            "pairs of L* and black, with ascending L* and black from 0 to 1.",
        )
    return BlackRule(WANTED, curve=curve)
