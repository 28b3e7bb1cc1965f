"""Measurement conditions M0 to M3 of ISO 13655, and the choice of one.

Fluorescent papers have different colours under different conditions, so conditions are never mixed.
Data with several conditions is refused until one is chosen. Files state conditions in many ways.
Only unambiguous statements are used: an instrument without a filter, for example, states nothing.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from gamutcore.errors import ConditionError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from gamutcore.errors import Where

__all__ = [
    "CONDITION_KEYWORDS",
    "WHOLE_KEYWORDS",
    "chosen_condition",
    "condition_label",
    "is_reflective_condition",
    "stated_condition",
]

MAX_LABEL_LENGTH = 60
MAX_SHOWN = 10

_CODE = re.compile(r"(?<![A-Z0-9])M([0-3])(?![A-Z0-9.])")
_ULTRAVIOLET_CUT = re.compile(r"UV[ _-]?(?:CUT|EXCLUDED|FILTER(?:ED)?)\b|NO[ _-]UV\b")
_POLARISED = re.compile(r"(?<!NO )(?<!NON-)(?<!UN)\bPOLARI[SZ](?:ED|ER|ING|ATION)\b")
WHOLE_KEYWORDS = (
    "MEASUREMENT_CONDITION",
    "MEASUREMENT_CONDITIONS",
    "MEASUREMENT_MODE",
    "ISO13655_CONDITION",
)
"""Keywords whose whole text is a measurement condition."""

_SEARCHED_KEYWORDS = (
    "FILTER",
    "INSTRUMENT_FILTER",
    "MEASUREMENT_FILTER",
    "MEASUREMENT_SOURCE",
    "ISIS_INFO",
    "INSTRUMENTATION",
    "WEIGHTING_FUNCTION",
    "MEASUREMENT_GEOMETRY",
)
CONDITION_KEYWORDS = frozenset({*WHOLE_KEYWORDS, *_SEARCHED_KEYWORDS})
"""Keywords that may state a measurement condition."""

_REMEDY = "Choose one of them by the option `condition`."


def condition_label(text: str) -> str:
    """Return the name of a measurement condition, M0 to M3 if possible.

    Parameters
    ----------
    text : str
        As in a file or a request: ``"M1"``, ``"m1"``, ``"M1_Daylight"``, ``"UVcut"``.

    Returns
    -------
    str
        ``"M0"`` to ``"M3"`` (ISO 13655:2017, 4.2.2), else the text itself without surplus space.
    """
    upper = text.upper().replace("_", " ")
    match = _CODE.search(upper)
    if match:
        return f"M{match[1]}"
    if _ULTRAVIOLET_CUT.search(upper):
        return "M2"
    if _POLARISED.search(upper):
        return "M3"
    return " ".join(text.split())[:MAX_LABEL_LENGTH]


def is_reflective_condition(label: str | None) -> bool:
    """Return whether a condition is one of ISO 13655, which apply to reflecting samples."""
    return label is not None and re.match(r"M[0-3]\b", label) is not None


def stated_condition(keywords: Mapping[str, str]) -> str | None:
    """Return the measurement condition that the keywords of a file state.

    Parameters
    ----------
    keywords : mapping
        Keywords (upper case) to text.

    Returns
    -------
    str or None
        None if they state none. An ultraviolet filter means M2, a polariser M3. The absence of a
        filter means nothing, because the lamp is unknown.
    """
    for keyword in WHOLE_KEYWORDS:
        text = keywords.get(keyword, "").strip()
        if text:
            return condition_label(text)
    for keyword in _SEARCHED_KEYWORDS:
        label = condition_label(keywords.get(keyword, ""))
        if re.fullmatch(r"M[0-3]", label):
            return label
    return None


def chosen_condition(
    found: Iterable[str | None], asked: str | None, *, where: Where | None = None
) -> str | None:
    """Return the measurement condition to use.

    Parameters
    ----------
    found : iterable of str or None
        Conditions of the data, in order; None for parts that state none.
    asked : str or None
        The requested condition.
    where : dict, optional
        Location of the conditions, for errors.

    Returns
    -------
    str or None
        None if the data states none and none is requested.

    Raises
    ------
    ConditionError
        There are several and none is requested, or not the requested one.
    """
    labels = list(dict.fromkeys(found))
    named = [label for label in labels if label is not None]
    place: Where = {**(where or {}), "field": "condition", "conditions": named[:MAX_SHOWN]}
    if asked is not None:
        folded = " ".join(asked.split()).lower()
        label = next((name for name in named if name.lower() == folded), condition_label(asked))
        if label in named:
            return label
        known = f"it has {_listed(named)}" if named else "it states none"
        raise ConditionError(
            f"The data has no measurements under the condition {label}: {known}.",
            where=place,
            remedy=_REMEDY if named else "Leave the option `condition` out.",
        )
    if len(labels) > 1:
        also = ", and parts without one" if None in labels else ""
        raise ConditionError(
            f"The data was measured under several conditions: {_listed(named)}{also}.",
            where=place,
            remedy=_REMEDY,
        )
    return labels[0] if labels else None


def _listed(labels: list[str]) -> str:
    shown = ", ".join(labels[:MAX_SHOWN])
    return shown if len(labels) <= MAX_SHOWN else f"{shown} and {len(labels) - MAX_SHOWN} more"
