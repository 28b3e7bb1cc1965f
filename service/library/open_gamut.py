"""A gamut in memory, of which the library makes levels and encoded answers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.gamut import Gamut
    from service.admission import Holding
    from service.storage.published import PublishedGamut

__all__ = ["OpenGamut"]


@dataclass(frozen=True)
class OpenGamut:
    """A gamut in memory, with its record and history.

    A newer gamut with another record may have the same id. `provenance` is for mesh files, `space`
    is the space of the coordinates, and `name` is for the names of files.
    """

    record: PublishedGamut
    gamut: Gamut
    provenance: dict[str, str]
    space: ColourSpace
    name: str
    holding: Holding = field(repr=False)
