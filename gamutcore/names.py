"""Everyday names: one ranking of what a person may mean by a name.

Names are compared by their words, without regard to letter case and punctuation. "Rec.", "BT." and
"ITU-R BT." are the same word, and so are the names of a print condition: the number of its
characterisation data and the names of the profiles that are made from it.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from functools import lru_cache
from typing import TypeVar

__all__ = ["EXACT", "folded", "near_match", "print_condition", "ranked", "similarity"]

T = TypeVar("T")

LIKENESS = 0.6
"""Smallest ratio of `difflib` at which a misspelled name is similar to another one."""

LONGEST = 200
"""Characters of a name that are compared."""

_MISSPELLED = 60
"""Characters up to which the spelling of names is compared; the time grows with their square."""

EXACT, _WORDS, _PART = 4.0, 3.0, 2.0
"""Similarity of equal names, of names with all the words, and of names with the text in them."""

_WORD = re.compile(r"[a-z]+|[0-9]+")

_SAME_WORDS = {"rec": "bt", "recommendation": "bt", "colour": "color", "colours": "colors"}

_SILENT = frozenset({"itu", "r", "the", "cgats"})
"""Words that a name may lack."""

_CONDITIONS = (
    # CGATS and SWOP characterisation data, and CGATS 21-2, with the profiles of Idealliance
    ("TR 001", "Web Coated SWOP"),
    ("TR 003", "SWOP 2006 Coated 3"),
    ("TR 005", "SWOP 2006 Coated 5"),
    ("TR 006", "GRACoL 2006 Coated 1"),
    ("CRPC 5", "SWOP 2013"),
    ("CRPC 6", "GRACoL 2013"),
    # characterisation data of Fogra, with the profiles of ECI
    ("FOGRA39", "ISO Coated v2"),
    ("FOGRA45", "PSO LWC Improved"),
    ("FOGRA46", "PSO LWC Standard"),
    ("FOGRA47", "PSO Uncoated ISO12647"),
    ("FOGRA51", "PSO Coated v3"),
    ("FOGRA52", "PSO Uncoated v3"),
)
"""Names of print conditions: of the characterisation data, and of the profile that is made from it.
Source: the profile registry of the ICC, www.color.org/registry."""


def folded(name: str) -> str:
    """Return the letters and digits of a name in lower case.

    Examples
    --------
    >>> folded("ITU-R BT.2020")
    'iturbt2020'
    """
    return re.sub(r"[^a-z0-9]", "", name.lower())


@lru_cache(maxsize=4096)
def _words(name: str) -> tuple[str, ...]:
    """Return the words and numbers of a name: ``Rec2020`` has two, 1 and 001 are the same."""
    words = _WORD.findall(name[:LONGEST].lower())
    plain = [_SAME_WORDS.get(word, word.lstrip("0") or "0") for word in words]
    return tuple(word for word in plain if word not in _SILENT)


def similarity(wanted: str, name: str) -> float:
    """Return how well a name fits to what was asked for; 0 if it does not.

    It is 4 for an equal name. From 3 on, the name has all the words that were asked for; from 2 on,
    it has the text; from 0.6 on, it is spelled similarly.

    Examples
    --------
    >>> similarity("Rec2020", "ITU-R BT.2020") == similarity("srgb", "sRGB")
    True
    >>> similarity("srgb", "sRGB") > similarity("srgb", "Linear Rec.709 (sRGB)") > 0
    True
    >>> similarity("TR 006", "GRACoL2006_Coated1v2") > 0
    True
    >>> similarity("srgb", "Display P3")
    0.0
    """
    likeness = _similarity(wanted, name)
    for other in print_condition(wanted):
        likeness = max(likeness, _similarity(other, name) - 0.5)
    return likeness if likeness >= LIKENESS else 0.0


def print_condition(name: str) -> tuple[str, ...]:
    """Return the names of a print condition; empty if the name is of none.

    Examples
    --------
    >>> print_condition("CGATS TR006")
    ('TR 006', 'GRACoL 2006 Coated 1')
    """
    words = set(_words(name))
    known = (
        condition
        for condition in _CONDITIONS
        if any(words >= set(_words(alias)) for alias in condition)
    )
    return next(known, ())


def _similarity(wanted: str, name: str) -> float:
    wanted_words, name_words = _words(wanted), _words(name)
    if not wanted_words or not name_words:
        return 0.0
    wanted_text, name_text = "".join(wanted_words), "".join(name_words)
    if wanted_text == name_text:
        return EXACT
    share = len(wanted_text) / len(name_text)  # what is asked for is in a longer name
    if set(wanted_words) <= set(name_words):
        starts = 0.1 if name_words[: len(wanted_words)] == wanted_words else 0.0
        return _WORDS + min(share, 0.8) + starts
    if wanted_text in name_text and len(wanted_text) > 1:
        return _PART + min(share, 0.9)
    matcher = difflib.SequenceMatcher(None, wanted_text, name_text)
    is_long = max(len(wanted_text), len(name_text)) > _MISSPELLED
    # two bounds of the ratio, which are faster
    if is_long or min(matcher.real_quick_ratio(), matcher.quick_ratio()) < LIKENESS:
        return 0.0
    return matcher.ratio()  # `similarity` leaves out ratios below `LIKENESS`


def ranked(wanted: str, things: Iterable[tuple[T, Iterable[str]]]) -> list[T]:
    """Return the things that a name may mean, the most likely first.

    Of equally likely things, the first one comes first. Things of which no name is similar are left
    out. If a name has the words or the text that were asked for, so are names that are only spelled
    similarly.

    Examples
    --------
    >>> ranked("srgb", [("a", ["Linear Rec.709 (sRGB)"]), ("b", ["sRGB"]), ("c", ["P3"])])
    ['b', 'a']
    """
    scored = [(max(similarity(wanted, name) for name in names), thing) for thing, names in things]
    best = max((score for score, _ in scored), default=0.0)
    least = 1.0 if best >= 1.0 else LIKENESS
    likely = [pair for pair in scored if pair[0] >= least]
    return [thing for _, thing in sorted(likely, key=lambda pair: -pair[0])]


def near_match(name: str, names: Iterable[str]) -> str | None:
    """Return the name that a misspelled one most resembles; None if no name is similar."""
    return next(iter(ranked(name[:60], ((candidate, (candidate,)) for candidate in names))), None)
