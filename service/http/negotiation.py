"""Content negotiation (RFC 9110, section 12.5.1) and the ``Prefer`` field (RFC 7240).

Malformed elements are ignored, as both documents recommend.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["OCTET_STREAM", "Preference", "preference", "preferred_media_type", "qualities"]

OCTET_STREAM = "application/octet-stream"
"""Media type of bytes whose format is not named (RFC 2046, section 4.5.1)."""

_QUALITY = re.compile(r"(?:0(?:\.\d{0,3})?|1(?:\.0{0,3})?)\Z", re.ASCII)
"""The qvalue of RFC 9110, section 12.4.2."""

_ELEMENT = re.compile(r'(?:"(?:[^"\\]|\\(?:.|\Z))*(?:"|\Z)|[^",])+', re.DOTALL)
"""A list element. Commas in a quoted string (section 5.6.4) do not end it. An unclosed string
extends to the end, which keeps matching linear."""

_SECONDS = re.compile(r"\d{1,4000}\Z", re.ASCII)
"""Python converts up to 4300 digits."""


def preferred_media_type(accept: str | None, offered: Sequence[str]) -> str | None:
    """Return the media type of `offered` that a client prefers.

    Parameters
    ----------
    accept : str or None
        The value of ``Accept``.
    offered : sequence of str
        Available types in the service's order of preference, which decides ties.

    Returns
    -------
    str or None
        None if the client accepts none of them. Without ``Accept``, the first.

    Examples
    --------
    >>> preferred_media_type("text/*;q=0.5, image/png", ["text/html", "image/png"])
    'image/png'
    """
    if accept is None or not accept.strip():
        return offered[0]
    ranges = {name: quality for name, quality in qualities(accept).items() if "/" in name}
    best, best_quality = None, 0.0
    for media_type in offered:
        kind = media_type.partition("/")[0]
        # The most specific matching range decides (section 12.5.1).
        for pattern in (media_type, f"{kind}/*", "*/*"):
            if pattern in ranges:
                if ranges[pattern] > best_quality:
                    best, best_quality = media_type, ranges[pattern]
                break
    return best


def qualities(field: str) -> dict[str, float]:
    """Return the names of a list in lower case with their quality values (section 12.4.2).

    Parameters
    ----------
    field : str
        The value of ``Accept``, ``Accept-Encoding`` or a similar field.
    """
    found: dict[str, float] = {}
    for element in _ELEMENT.findall(field):
        name, *parameters = (part.strip().lower() for part in element.split(";"))
        quality = 1.0
        for parameter in parameters:
            key, _, value = parameter.partition("=")
            if key.strip() == "q" and _QUALITY.match(value.strip()):
                quality = float(value)
        if name:
            found[name] = max(quality, found.get(name, 0.0))
    return found


@dataclass(frozen=True)
class Preference:
    """How long a client wants to wait for a build.

    Attributes
    ----------
    respond_async : bool
        The client prefers a job over waiting.
    wait : int or None
        Seconds that the client is willing to wait.
    """

    respond_async: bool = False
    wait: int | None = None

    def seconds(self, default: float, longest: float) -> float:
        """Return the seconds to wait: the requested time up to `longest`, else `default`."""
        if self.wait is not None:
            return min(self.wait, longest)
        return 0.0 if self.respond_async else default

    def applied_field(self, *, answered_async: bool, longest: float) -> str:
        """Return the value of ``Preference-Applied``; empty if no preference was applied."""
        applied = []
        if self.respond_async and answered_async:
            applied.append("respond-async")
        if self.wait is not None and self.wait <= longest:
            applied.append(f"wait={self.wait}")
        return ", ".join(applied)


def preference(prefer: Sequence[str]) -> Preference:
    """Return the preferences of a request. The first occurrence of a name counts."""
    found: dict[str, str] = {}
    for element in _ELEMENT.findall(",".join(prefer)):
        name, _, value = element.partition(";")[0].partition("=")
        found.setdefault(name.strip().lower(), value.strip().strip('"'))
    wait = found.get("wait", "")
    return Preference("respond-async" in found, int(wait) if _SECONDS.match(wait) else None)
