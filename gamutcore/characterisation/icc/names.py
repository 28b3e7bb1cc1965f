"""The description of an ICC profile, and the names of its inks.

Both are read tolerantly. They do not affect colours, so damage in them is not an error.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from gamutcore.errors import MalformedProfileError

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.characterisation.icc.element import Element

__all__ = ["colorant_names", "profile_description"]

LONGEST = 200
"""Maximum length of a name; longer names are cut."""


def profile_description(element: Callable[[str], Element]) -> str:
    """Return the description of a profile; empty without one.

    The tag `desc` has the type textDescription (version 2) or multiLocalizedUnicode.
    """
    try:
        tag = element("desc")
        if tag.kind == "mluc":
            length, offset = tag.unsigned(20, 4), tag.unsigned(24, 4)
            return _printable(tag.raw(offset, length).decode("utf-16-be", "replace"))
        if tag.kind == "desc":
            length = tag.unsigned(8, 4)
            return _printable(tag.raw(12, length).decode("latin-1").partition("\0")[0])
    except MalformedProfileError:
        pass
    return ""


def colorant_names(element: Callable[[str], Element], count: int) -> tuple[str, ...]:
    """Return the names of the inks from the tag `clrt` (ICC.1:2022, 10.5).

    The result is empty if a name is missing or repeated.
    """
    try:
        tag = element("clrt")
        if tag.kind != "clrt" or tag.unsigned(8, 4) != count:
            return ()
        names = tuple(
            _printable(tag.raw(12 + 38 * i, 32).decode("latin-1").partition("\0")[0])
            for i in range(count)
        )
    except MalformedProfileError:
        return ()
    return names if all(names) and len(set(names)) == count else ()


def _printable(text: str) -> str:
    return "".join(c for c in text if c.isprintable()).strip()[:LONGEST]
