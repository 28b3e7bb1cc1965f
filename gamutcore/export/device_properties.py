"""What mesh files call the device values of their vertices."""

from __future__ import annotations

import re
from functools import lru_cache

__all__ = ["property_names"]

LONGEST = 40
"""Characters of a channel's name that go into that of a property."""


@lru_cache(maxsize=64)  # asked for every mesh that is served, of few devices
def property_names(channels: tuple[str, ...]) -> tuple[str, ...]:
    """Return a name of letters, digits and underscores for each channel.

    Parameters
    ----------
    channels : tuple of str
        As the characterisation calls them: inks may have any name.

    Returns
    -------
    tuple of str
        ``device_C`` for the channel C, ``device_Reflex_Blue`` for Reflex Blue; the channel's
        number where nothing of its name is left, and behind a name that an earlier one has too.
        Distinct without regard to case.
    """
    names: list[str] = []
    taken: set[str] = set()
    for number, channel in enumerate(channels, 1):
        plain = re.sub("[^A-Za-z0-9]+", "_", channel).strip("_")[:LONGEST]
        # readers of PLY look for this word as the end of the header, wherever it stands
        plain = re.sub("end_header", "endheader", plain, flags=re.IGNORECASE) or str(number)
        name = f"device_{plain}"
        while name.lower() in taken:
            name += f"_{number}"
        taken.add(name.lower())
        names.append(name)
    return tuple(names)
