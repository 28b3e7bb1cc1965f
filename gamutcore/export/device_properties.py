"""Names of the device values of vertices in mesh files."""

from __future__ import annotations

import re
from functools import lru_cache

__all__ = ["property_names"]

LONGEST = 40
"""Largest part of a channel's name in the name of a property, in characters."""


@lru_cache(maxsize=64)  # called for every served mesh, of few devices
def property_names(channels: tuple[str, ...]) -> tuple[str, ...]:
    """Return a name of letters, digits and underscores for each channel.

    Examples are ``device_C`` for C and ``device_Reflex_Blue`` for Reflex Blue. The channel's number
    replaces an empty name and is appended to a repeated one. Names are distinct without regard to
    case.
    """
    names: list[str] = []
    taken: set[str] = set()
    for number, channel in enumerate(channels, 1):
        plain = re.sub("[^A-Za-z0-9]+", "_", channel).strip("_")[:LONGEST]
        # PLY readers take this word as the end of the header, wherever it occurs
        plain = re.sub("end_header", "endheader", plain, flags=re.IGNORECASE) or str(number)
        name = f"device_{plain}"
        while name.lower() in taken:
            name += f"_{number}"
        taken.add(name.lower())
        names.append(name)
    return tuple(names)
