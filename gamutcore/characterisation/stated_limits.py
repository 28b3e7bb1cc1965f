"""Ink limits that data states itself, and warnings about limits.

A stated limit is never applied: the same options have the same meaning for all data. A warning
names the limit instead.
"""

from __future__ import annotations

import re
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.characterisation.embedded import embedded_text
from gamutcore.characterisation.icc import IccProfile, largest_output_sum
from gamutcore.characterisation.samples import Samples
from gamutcore.errors import CharacterisationError

if TYPE_CHECKING:
    from gamutcore.characterisation.recognition import Characterisation

__all__ = ["StatedLimit", "ink_limit_warnings", "stated_ink_limit"]

KEYWORD = "TOTAL_INK_LIMIT"
"""Keyword of Argyll's targets and measurements (ArgyllCMS, File Formats, .ti1)."""

SEPARATIONS = ("B2A1", "B2A0")
"""Tables from colours to device values, in the order of preference: colorimetric, perceptual."""

IN_PER_CENT = 50.0
"""Limits below are likely to be meant as a number of full inks: half of one ink prints little."""

_STATED = re.compile(rf'^\s*{KEYWORD}\s+"?(\d{{1,4}}(?:\.\d{{0,6}})?)', re.MULTILINE)
_NUMBER = re.compile(r"\d{1,4}(\.\d*)?")


class StatedLimit(NamedTuple):
    """The largest sum of all inks by the data itself.

    Attributes
    ----------
    total : float
        In per cent of one full ink.
    source : str
        The keyword or the tag.
    """

    total: float
    source: str


def stated_ink_limit(data: Characterisation) -> StatedLimit | None:
    """Return the total ink limit that data states itself.

    Parameters
    ----------
    data : Samples, IccProfile or other data

    Returns
    -------
    StatedLimit or None
        The keyword `TOTAL_INK_LIMIT` of measurements, also of those in a profile's tag `targ`; else
        the largest sum of device values in the profile's table from colours to device values. None
        without a limit below the sum of all inks.
    """
    if not isinstance(data, Samples | IccProfile) or not data.inks:
        return None
    found = _of_samples(data) if isinstance(data, Samples) else _of_profile(data)
    all_inks = 100.0 * len(data.channels)
    return found if found is not None and 0.0 < found.total < all_inks - 0.5 else None


def ink_limit_warnings(data: Characterisation, ink_limit: float | None) -> list[str]:
    """Return warnings about an ink limit, or about a stated limit that was not given.

    Parameters
    ----------
    data : Samples, IccProfile or other data
    ink_limit : float or None
        In per cent, as given.
    """
    if ink_limit is None:
        stated = stated_ink_limit(data)
        if stated is None:
            return []
        total = f"{stated.total:g}"
        warning = (
            f"The data states an ink limit of {total} % ({stated.source}), which is not applied. "
            f"Give ink_limit {total} (--ink-limit {total}) for the colours that are printed."
        )
        return [warning]
    if ink_limit < IN_PER_CENT:
        warning = (
            f"The ink limit is {ink_limit:g} % of one full ink. ink_limit is in per cent: 300 "
            "stands for three full inks."
        )
        return [warning]
    return []


def _of_samples(samples: Samples) -> StatedLimit | None:
    text = samples.conditions.get(KEYWORD, "").strip()
    return StatedLimit(float(text), KEYWORD) if _NUMBER.fullmatch(text) else None


def _of_profile(profile: IccProfile) -> StatedLimit | None:
    # damage in tags that colours do not need does not matter
    if "targ" in profile.tags:
        with suppress(CharacterisationError):
            match = _STATED.search(embedded_text(profile, "targ").decode("latin-1"))
            if match is not None:
                return StatedLimit(float(match[1]), f"{KEYWORD} in the tag targ")
    for tag in SEPARATIONS:
        if tag in profile.tags:
            with suppress(CharacterisationError):
                total = largest_output_sum(profile.element(tag), len(profile.channels))
                if total is not None:
                    return StatedLimit(float(np.round(100.0 * total)), f"largest sum in {tag}")
    return None
