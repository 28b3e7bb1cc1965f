"""What mesh files say beside the numbers: provenance, and names of device values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from gamutcore.version import __version__

__all__ = [
    "ascii_line",
    "comment_lines",
    "mesh_provenance",
    "property_names",
]


def mesh_provenance(description: Mapping[str, Any]) -> dict[str, str]:
    """Return the simple values of a gamut's description, for the provenance of mesh files.

    Numbers are written as in the description, without loss. The centre is the computed one, not the
    option.
    """
    provenance = description.get("provenance", {})
    facts = {"gamut": str(description["id"])}
    for name, triple in (("centre", description.get("centre")), ("white", provenance.get("white"))):
        if triple:
            facts[name] = " ".join(map(repr, triple))
    for name, part_name, member in (
        ("input_sha256", "input", "sha256"),
        ("algorithm_version", "algorithm", "version"),
    ):
        part = provenance.get(part_name, {})
        if member in part:
            facts[name] = str(part[member])
    options = description.get("options", {})
    white = options.get("reference_white")
    if isinstance(white, list):
        facts["reference_white"] = " ".join(map(repr, white))
    if white is not None:
        # The space's adaptation, even if the provenance has another one for an earlier step.
        facts["adaptation"] = str(options.get("adaptation", "Bradford"))
    for part in ("options", "provenance"):
        for name, value in description.get(part, {}).items():
            if isinstance(value, str | int | float):
                facts.setdefault(name, str(value))
    return facts


def ascii_line(text: str) -> str:
    r"""Return a text as one line of ASCII without double quotation marks.

    Other characters become escapes such as ``\xe9``.
    """
    line = " ".join(text.split()).replace('"', "'")
    return line.encode("ascii", "backslashreplace").decode()


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


def comment_lines(provenance: Mapping[str, str]) -> list[str]:
    """Return provenance as lines of text, one per entry, without line breaks."""
    entries = {"generator": f"gamutcore {__version__}", **provenance}
    return [" ".join(f"{name}: {value}".split()) for name, value in entries.items()]
